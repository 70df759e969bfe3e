"""The peers' part of docs/benchmarks/query.md, its plot, and the table of the README."""
import math

import matplotlib.pyplot as plt
import numpy as np

from ours import DEFAULT, METHODS, NEAREST, NO_MODEL, ROBOTS_MODEL
from page import number, put, save, table
from sides import ROOT

# Ends of the plotted excess: smaller ones are drawn at the first, missing answers at the second.
LEAST, MOST = 1e-4, 300.0
MULTISTART = "pinocchio + coal, "
# Targets of the default effort: least shares within 5 % and 1 %, and most microseconds (median, 95 %).
TARGETS = {"panda-box": (0.99, 0.95, 100, 500), "panda-torus": (0.99, 0.95, 200, 1000), "ur5-shelf": (0.99, 0.95, 150, 1000), "allegro-ball": (0.97, 0.90, 500, 2000)}
# Targets of the nearest sample alone: most microseconds (median).
NEAREST_TARGETS = {"panda-box": 5, "panda-torus": 5, "ur5-shelf": 5, "allegro-ball": 10}
DRAKE_RATIO, MULTISTART_RATIO = 10, 100


def write(found, folder):
    plot(found, folder / "query-peers.svg")
    scenes = found["scenes"]
    parts = ["## Beside its peers", f"Machine: {found['machine']}, shared and noisy; one thread; all methods in turns in the same run, each after other queries. Our models were "
             f"learned with {found['labels']:,} labels. Excess is over the least depth that any method found; `n/a` means that fewer than that share of "
             "the queries had an answer that passed the check.", "![Time against excess](query-peers.svg)", summary(found), targets(scenes)]
    parts += [part(name, s) for name, s in scenes.items()]
    put(folder / "query.md", "bench/peers", "\n\n".join(parts), "Queries, measured")
    if not found["quick"]:
        put(ROOT / "README.md", "bench/peers", readme(found), "")


def percent(x):
    return "n/a" if math.isinf(x) else "0" if x < 1e-6 else "< 0.01 %" if x < 1e-4 else f"{100 * x:.2g} %" if x < 1 else f"x {number(1 + x)}"


def starts(method):
    return int(method.removeprefix(MULTISTART).split()[0])


def part(name, s):
    learned = s["learning"]
    about = f"{s['joints']} joints, {s['pairs']} checked pairs, {s['queries']} random colliding configurations; {learned['samples']:,} boundary samples, " \
            f"learned in {number(learned['seconds'])} s. " + " ".join(s["notes"])
    head = ["method", "verified", "within 5 %", "within 1 %", "excess, median", "95 %", "time, median [us]", "95 %", "checks, median", "refused", "no answer"]
    rows = [[method, f"{f['verified']:.2f}", f"{f['within_5']:.2f}", f"{f['within_1']:.2f}", percent(f["excess_median"]), percent(f["excess_95"]),
             number(f["us"]), number(f["us_95"]), number(f["checks"]), f["refused"], f["missing"]] for method, f in s["methods"].items()]
    ours = s["methods"][DEFAULT]
    return f"### {name}\n\n{about}\n\n{table(head, rows)}\n\nOur lower bound over the best known depth, median: {ours['lower_over_best']:.2f}; above it: {ours['bounds_above_best']}."


def pooled(found):
    """Averages each method over the scenes that have it: mean shares, and the geometric mean of its time ratio to our default."""
    methods = list(dict.fromkeys(m for s in found["scenes"].values() for m in s["methods"]))
    last = max((starts(m) for m in methods if m.startswith(MULTISTART)), default=0)
    for method in methods:
        if method.startswith(MULTISTART) and starts(method) not in (1, 8, last):
            continue
        having = [s["methods"] for s in found["scenes"].values() if method in s["methods"]]
        mean = lambda key: float(np.mean([h[method][key] for h in having]))
        ratio = float(np.exp(np.mean([np.log(h[method]["us"] / h[DEFAULT]["us"]) for h in having])))
        yield method, len(having), mean("verified"), mean("within_5"), mean("within_1"), ratio


def pooled_table(found):
    rows = [[m, n, f"{v:.2f}", f"{five:.2f}", f"{one:.2f}", number(ratio)] for m, n, v, five, one, ratio in pooled(found)]
    return table(["method", "scenes", "verified", "within 5 %", "within 1 %", "time over that of our default"], rows)


def summary(found):
    return f"### All scenes\n\nMeans over the scenes; times as the geometric mean of ratios of medians. Our default is {DEFAULT}.\n\n{pooled_table(found)}"


def readme(found):
    """Makes the short table of README.md: our default and other methods; docs/benchmarks/query.md has the complete one."""
    last = max((starts(m) for s in found["scenes"].values() for m in s["methods"] if m.startswith(MULTISTART)), default=0)
    ours = {DEFAULT: f"extricate: {DEFAULT}", NO_MODEL: f"extricate: {NO_MODEL}"}
    rows = [[ours.get(m, m), n, f"{v:.2f}", f"{five:.2f}", number(ratio)] for m, n, v, five, _, ratio in pooled(found)
            if m in ours or m not in METHODS and not (m.startswith(MULTISTART) and starts(m) not in (8, last))]
    head = ["method", "scenes", "verified", "within 5 % of the best known", f"time over that of {DEFAULT}"]
    return f"Random colliding configurations of {len(found['scenes'])} scenes, every witness checked again with coal, one thread. Source: " \
           f"[docs/benchmarks/query.md](docs/benchmarks/query.md), measured by `python3 bench/peers`.\n\n{table(head, rows)}"


def targets(scenes):
    """Makes the table of targets and results, misses in bold."""
    rows = []
    show = lambda good, text: text if good else f"**{text}**"
    for name, s in scenes.items():
        ours, methods = s["methods"][DEFAULT], s["methods"]
        drake = next((f for m, f in methods.items() if m.startswith("Drake")), None)
        drawn = "not run"
        if drake:
            ratio = drake["us"] / ours["us"]
            drawn = show(ratio >= DRAKE_RATIO and ours["within_5"] >= drake["within_5"], f"{number(ratio)} times, {ours['within_5']:.2f} against {drake['within_5']:.2f}")
        several = [f for m, f in sorted(((m, f) for m, f in methods.items() if m.startswith(MULTISTART)), key=lambda each: starts(each[0]))]
        equal = next((f for f in several if f["within_1"] >= ours["within_1"]), None)
        ratio = (equal or several[-1])["us"] / ours["us"]
        met = ratio >= MULTISTART_RATIO
        peer = show(met, f"{number(ratio)} times" + ("" if equal else f", only {several[-1]['within_1']:.2f} against {ours['within_1']:.2f}"))
        t = TARGETS.get(name)
        quality = show(not t or ours["within_5"] >= t[0] and ours["within_1"] >= t[1], f"{ours['within_5']:.2f} / {ours['within_1']:.2f}")
        speed = show(not t or ours["us"] <= t[2] and ours["us_95"] <= t[3], f"{number(ours['us'])} / {number(ours['us_95'])}")
        us, most = methods[NEAREST]["us"], NEAREST_TARGETS.get(name)
        alone = show(not most or us <= most, number(us))
        rows.append([name, quality, f"{t[0]} / {t[1]}" if t else "", speed, f"{t[2]} / {t[3]}" if t else "", alone, most or "", drawn, peer])
    head = ["scene", "within 5 % / 1 %", "target", "time, median / 95 % [us]", "target", "`nearest`, median [us]", "target", f"faster than Drake (target {DRAKE_RATIO}, at more within 5 %)",
            f"faster than multistart at equal share within 1 % (target {MULTISTART_RATIO})"]
    return f"### Against the targets\n\n{DEFAULT}, but for the columns of `nearest`; misses in bold. The targets of times were set for one quiet core.\n\n{table(head, rows)}"


def plot(found, path):
    scenes = found["scenes"]
    columns = min(3, len(scenes))
    lines = math.ceil(len(scenes) / columns)
    figure, axes = plt.subplots(lines, columns, figsize=(3.5 * columns, 3.0 * lines + 0.8), layout="constrained", squeeze=False, sharey=True, sharex=True)
    others = [m for m in dict.fromkeys(m for s in scenes.values() for m in s["methods"]) if m not in METHODS and not m.startswith(MULTISTART)]
    at = lambda f: (f["us"], min(max(f["excess_95"], LEAST), MOST))
    for axis, (name, s) in zip(axes.flat, scenes.items()):
        methods = s["methods"]
        line = [m for m in METHODS if m not in (NO_MODEL, ROBOTS_MODEL)]
        axis.plot(*at(methods[NO_MODEL]), "*", color="C0", ms=10, label="extricate: refined, no model")
        axis.plot(*at(methods[ROBOTS_MODEL]), "P", color="C0", ms=7, label="extricate: refined, robot's model")
        axis.plot(*zip(*(at(methods[m]) for m in line)), "o-", color="C0", ms=4, label="extricate: nearest; refined from 1, 2, 4, 8 starts, by default, from 16; exhaustive")
        several = sorted((m for m in methods if m.startswith(MULTISTART)), key=starts)
        axis.plot(*zip(*(at(methods[m]) for m in several)), "s-", color="C1", ms=4, label=f"{MULTISTART}{' '.join(str(starts(m)) for m in several)} starts")
        for k, m in enumerate(others):
            if m in methods:
                axis.plot(*at(methods[m]), "D^v<>"[k % 5], color=f"C{2 + k}", label=m)
        axis.set(xscale="log", yscale="log", title=name, xlabel="us a query, median", ylim=(LEAST / 2, MOST * 2))
        axis.grid(alpha=0.3)
    for axis in list(axes.flat)[len(scenes):]:
        axis.set_visible(False)
    figure.supylabel("excess over the best known, 95 % (top: no answer)", fontsize=9)
    labels = {label: handle for axis in axes.flat for handle, label in zip(*axis.get_legend_handles_labels())}
    figure.legend(labels.values(), labels.keys(), loc="outside lower center", ncols=2, fontsize=8)
    save(figure, path)
    plt.close(figure)
