#!/usr/bin/env python3
"""What learning costs and what labels and seconds buy: its part of docs/benchmarks/learning.md, with plots.

    target/peers/bin/python bench/learning.py [--queries 200] [--labels 640000] [--seeds 3] [--only labels joints cores accuracy seconds adapt]

Needs cargo, numpy and matplotlib (bench/requirements.txt; bench/peers installs them) and the fetched robots.

labels   excess of queries against labels spent, for models of `extricate learn` and for models whose labels all went to uniform
         samples (`extricate-bench uniform`), on the scenes of the query benchmark and the other built-in ones; every model is learned
         with several seeds, and the excesses of all are one sample
joints   planar arms of 2 to 20 joints among six posts: labels and processor seconds until 95 % of random colliding queries that may take
         20 checks, and 50, are answered within 5 % of the best known
cores    the same learning run on one thread and on two: wall time, with how much of the machine other programs had meanwhile
accuracy `panda-box` with 20,000 labels and several seeds: how many held-out configurations the classifier calls what they are
seconds  models of 10 and 60 seconds on two threads: how many random colliding queries `refined` answers within 5 % and 1 % of the best known
adapt    an obstacle moved, removed or added: `adapt` with a fifth of the labels beside learning anew, and a chain of adaptations there and back

Best known is the least depth that any model and effort of the run found (of `seconds` and `adapt`: of the same row), `exhaustive` on the largest
included. In `labels`, excess below 0.1 % counts as that much: descents to one way out agree no better everywhere, and what misses it is mostly farther.
"""
import argparse
import functools
import math
import pathlib
import statistics
import tempfile

import matplotlib.pyplot as plt
import numpy as np

import learning_accuracy
import learning_adapt
import learning_joints
import learning_seconds
import programs
import scenes
from excess import SLIGHT, asked, quantile
from page import number, put, save, table
from sides import ROOT, machine, others_during

# A model of uniform samples answers `refined` with up to three times as many checks as one that was learned: hence also at most so many, about twice what
# queries of default models take.
BUDGETED = "refined, 50 checks"
EFFORTS = {"nearest": "nearest", "refined, 1 start": 1, BUDGETED: "50-checks", "refined": "refined"}
LEARNERS = ("active", "uniform")
# Of the largest models of the comparison, where not told otherwise.
LABELS = 640_000
# Doublings up to --labels.
STEPS = 8
LEAST = 1e-3
# Raw meshes and two arms are slow to query; fewer are asked.
FEWER = {"shelf-arm", "panda-torus", "dual-arm"}
# Built-in scenes that the peers cannot be given.
FURTHER = ("free-box", "dual-arm", "hand")
# Measured by files of their own.
APART = {"joints": learning_joints, "accuracy": learning_accuracy, "seconds": learning_seconds, "adapt": learning_adapt}
TIMED = ("joints", "cores", "seconds")


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, pathlib.Path(folder)

    def model(self, scene, labels, learner, seed=1):
        model = self.folder / f"{scene.stem}-{labels}-{learner}-{seed}.model"
        if learner == "active":
            return model, programs.learn(scene, model, labels, seed=seed)
        programs.run("extricate-bench", "uniform", scene, labels, seed, model)
        return model, None

    def labels(self):
        """Per scene and effort: the 95th percentile of the excess for both learners, by labels."""
        found = {}
        for name, scene in (scenes.written() | {name: scenes.built_in(name) for name in FURTHER}).items():
            if name not in (self.options.scenes or [name]):
                continue
            queries = programs.sample(scene, self.options.queries // 2 if name in FEWER else self.options.queries, 23)
            counts = [self.options.labels >> k for k in reversed(range(STEPS))]
            depths, best = {}, np.full(len(queries), np.inf)
            for labels in counts:
                for learner in LEARNERS:
                    for seed in range(1, self.options.seeds + 1):
                        model, _ = self.model(scene, labels, learner, seed)
                        for shown, effort in EFFORTS.items():
                            depth = asked(model, queries, effort)
                            depths.setdefault((labels, learner, shown), []).append(depth)
                            best = np.minimum(best, depth)
            best = np.minimum(best, asked(self.model(scene, counts[-1], "active")[0], queries, "exhaustive"))
            excesses = {key: np.concatenate([depth / best - 1 for depth in depth]) for key, depth in depths.items()}
            found[name] = {key: (max(LEAST, quantile(excess, 0.95)), float((excess > SLIGHT).mean())) for key, excess in excesses.items()}
            print(name, {f"{k[0]} {k[1]} {k[2]}": (round(v, 4), round(m, 4)) for k, (v, m) in found[name].items()}, flush=True)
        return found

    def cores(self):
        scene, rows = scenes.written()["panda-box"], []
        for _ in range(self.options.rounds):
            row = {}
            for threads in (1, 2):
                with others_during() as others:
                    learned = programs.learn(scene, self.folder / "cores.model", 100_000, "--threads", threads)
                row[threads] = {"wall": learned["seconds"], "cpu": learned["cpu_seconds"], "others": others.cores(learned["cpu_seconds"])}
            rows.append(row)
            print(row, flush=True)
        return rows


def fewest(curve, counts, learner, effort, excess):
    """The fewest labels from which on the excess stays at most `excess`, or none."""
    good = None
    for labels in reversed(counts):
        if curve[labels, learner, effort][0] > excess * (1 + 1e-9):
            break
        good = labels
    return good


def labels_section(found, folder):
    counts = sorted({key[0] for curve in found.values() for key in curve})
    rows = []
    for name, curve in found.items():
        for effort in EFFORTS:
            reached = curve[counts[-1], "uniform", effort][0]
            needed = fewest(curve, counts, "active", effort, reached)
            uniform = fewest(curve, counts, "uniform", effort, reached)
            factor = f"{needed / uniform:.2g}" if needed else "**more than 1**"
            met = factor if needed and needed <= uniform / 2 else f"**{factor.strip('*')}**"
            rows.append([name, effort, percent(reached), f"{uniform:,}", f"{needed:,}" if needed else f"> {counts[-1]:,}", met])
    steps = {effort: table(["scene", "learner", *(f"{c:,}" for c in counts)],
                           [[name, learner, *(f"{percent(curve[c, learner, effort][0])}; {100 * curve[c, learner, effort][1]:.1f} %" for c in counts)]
                            for name, curve in found.items() for learner in LEARNERS]) for effort in (BUDGETED, "refined")}
    columns = 3
    lines = math.ceil(len(found) / columns)
    figure, axes = plt.subplots(lines, columns, figsize=(3.5 * columns, 2.8 * lines + 0.6), layout="constrained", squeeze=False, sharex=True)
    for axis, (name, curve) in zip(axes.flat, found.items()):
        for k, effort in enumerate(EFFORTS):
            for learner, style in zip(LEARNERS, ("o-", "s--")):
                axis.loglog(counts, [curve[c, learner, effort][0] for c in counts], style, color=f"C{k}", ms=3, label=f"{effort}, {learner}")
        axis.set(title=name, xlabel="labels")
        axis.grid(alpha=0.3)
    for axis in list(axes.flat)[len(found):]:
        axis.set_visible(False)
    figure.supylabel("excess over the best known, 95 %", fontsize=9)
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    plot = "learning-labels.svg" if counts[-1] == LABELS else f"learning-labels-{counts[-1]}.svg"
    save(figure, folder / plot)
    head = ["scene", "effort", f"95 % excess of uniform sampling, {counts[-1]:,} labels", "labels it needs for that", "labels that learning needs for no more", "ratio"]
    title = "Labels" if counts[-1] == LABELS else f"Labels, up to {counts[-1]:,}"
    return f"## {title}\n\nThe 95th percentile of the excess of queries, learning against uniform sampling at equal labels. The target is a ratio of at most 0.5 for `refined` on " \
           f"at least three of the robots' scenes and on the built-in ones; misses in bold. Counts of labels double from step to step; models of several seeds count together.\n\n{table(head, rows)}\n\n" \
           f"`refined` by labels: 95th percentile of the excess; queries more than {SLIGHT:.0%} beyond the best known.\n\n{steps['refined']}\n\n" \
           f"The same with at most 50 checks a query.\n\n{steps[BUDGETED]}\n\n![Excess against labels]({plot})"


def percent(x):
    return f"< {100 * LEAST:g} %" if x <= LEAST else f"{100 * x:.2g} %" if x < 1 else f"x {number(1 + x)}"


def cores_section(rows, _):
    shown = [[k + 1, number(r[1]["wall"]), number(r[2]["wall"]), f"{r[2]['wall'] / r[1]['wall']:.2f}", number(r[1]["cpu"]), number(r[2]["cpu"]),
              f"{r[1]['others']:.1f}", f"{r[2]['others']:.1f}"] for k, r in enumerate(rows)]
    ratio = min(r[2]["wall"] for r in rows) / min(r[1]["wall"] for r in rows)
    head = ["round", "one thread [s]", "two threads [s]", "ratio", "processor time, one [s]", "two [s]", "cores that others had, one", "two"]
    others = statistics.median(r[2]["others"] for r in rows)
    told = f" Other programs had {others:.1f} of the machine's cores meanwhile (median), so the target is not judged by this." if others > 0.1 else ""
    return f"## Two cores\n\n`panda-box`, 100,000 labels, wall time. Shortest over shortest: **{ratio:.2f}** (target: at most 0.6).{told}\n\n{table(head, shown)}"


def main():
    parts = ("labels", "cores", *APART)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--queries", type=int, default=200)
    parser.add_argument("--labels", type=int, default=LABELS, help="of the largest models of the comparison of labels; other budgets than this have a section of their own")
    parser.add_argument("--seeds", type=int, default=3, help="of every model of the comparison of labels")
    parser.add_argument("--scenes", nargs="+", help="of the comparison of labels; all by default")
    parser.add_argument("--rounds", type=int, default=5, help="of the comparison of cores")
    parser.add_argument("--share", type=float, default=1.0, help="of the seconds that `seconds` learns for; less only tries it out")
    parser.add_argument("--adapt-labels", type=int, default=500_000, help="of what `adapt` learns anew")
    parser.add_argument("--only", nargs="+", choices=parts, default=parts)
    parser.add_argument("--programs", type=pathlib.Path, help="folder with the built extricate and extricate-bench; else cargo builds them")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "docs/benchmarks")
    options = parser.parse_args()
    if options.programs:
        programs.folder = options.programs.resolve()
    else:
        programs.build()
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, folder)
        own = {"labels": (bench.labels, labels_section), "cores": (bench.cores, cores_section)}
        apart = {part: (functools.partial(file.measure, options, bench.folder), file.section) for part, file in APART.items()}
        for part in options.only:
            measure, section = (own | apart)[part]
            text = section(measure(), options.out)
            told = f"\n\nMachine: {machine()}, shared and noisy." if part in TIMED else ""
            name = part if part != "labels" or options.labels == LABELS else f"labels {options.labels}"
            put(options.out / "learning.md", f"bench/learning.py {name}", text.replace("\n\n", f"{told}\n\n", 1) if told else text, "Learning, measured")


if __name__ == "__main__":
    main()
