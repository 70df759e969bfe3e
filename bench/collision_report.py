"""Writes tables and plots of docs/benchmarks/collision.md from the figures of collision.py; text outside the markers stays."""
import math
import statistics
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "extricate"
import matplotlib.pyplot as plt  # noqa: E402

BEGIN, END = "<!-- measured: begin (bench/collision.py) -->", "<!-- measured: end -->"
KINDS = {"random": "Random poses, half of them colliding", "contact": "Within 1 mm of contact, both sides"}


def write(found, folder):
    folder.mkdir(parents=True, exist_ok=True)
    plots(found["growth"], folder)
    page = folder / "collision.md"
    parts = [about(found), pairs(found), labels(found), growth(found), memory(found), exactness(found)]
    text = page.read_text() if page.exists() else f"# Collision checks, measured\n\n{BEGIN}\n{END}\n"
    head, rest = text.split(BEGIN)
    page.write_text(head + BEGIN + "\n\n" + "\n\n".join(parts) + "\n\n" + END + rest.split(END)[1])
    print(page)


def us(seconds):
    """Formats seconds as microseconds, with three digits."""
    x = 1e6 * seconds
    return f"{x:.0f}" if x >= 100 else f"{x:.1f}" if x >= 10 else f"{x:.2f}"


def table(head, rows):
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in [head, *rows]]
    return "\n".join([lines[0], "|---" * len(head) + "|", *lines[1:]])


def mean(values):
    """Returns the geometric mean."""
    return math.exp(statistics.fmean(map(math.log, values)))


def ratio(above, below):
    """Returns the median over rounds of the ratio within a round."""
    return statistics.median(a / b for a, b in zip(above, below))


def about(found):
    absent = [p for p in ("coal", "fcl") if p not in found["sides"]]
    missing = f" Not installed, so left out: {', '.join(absent)}." if absent else ""
    quick = " A short run (`--quick`)." if found["quick"] else ""
    return f"Machine: {found['machine']}. Medians over {found['rounds']} rounds; in a round all sides take their turns " \
           f"one after another, and ratios are medians of ratios within a round. Means are in processor time of the thread (what other programs do meanwhile is " \
           f"not in them); medians over single calls, and batches on threads, are in wall time.{missing}{quick}"


def pairs(found):
    columns = [(s, limit) for s, limit in [("ours", "0"), ("coal", "0"), ("fcl", "0"), ("ours", "0.0001"), ("coal", "0.0001")]]
    parts = ["## Mesh against mesh", "Microseconds a check, mean over the poses. *Clearance* is what has to be kept; fcl's boolean knows none."]
    for kind, title in KINDS.items():
        have = [c for c in columns if "@".join(c) in found["pairs"][0]["kinds"][kind]["seconds"]]
        head = ["links", "triangles", *(f"{s}, clearance {'0' if limit == '0' else '1e-4'}" for s, limit in have)]
        peers = [(s, limit) for s, limit in have if s != "ours"]
        head += [f"{s} / ours{'' if limit == '0' else ', 1e-4'}" for s, limit in peers]
        rows, ratios = [], {p: [] for p in peers}
        for row in found["pairs"]:
            seconds = row["kinds"][kind]["seconds"]
            for s, limit in peers:
                ratios[s, limit].append(ratio(seconds[f"{s}@{limit}"], seconds[f"ours@{limit}"]))
            rows.append([row["pair"], " x ".join(f"{n:,}" for n in row["triangles"]), *(us(statistics.median(seconds["@".join(c)])) for c in have),
                         *(f"{ratios[p][-1]:.1f}" for p in peers)])
        middle = [us(mean([statistics.median(r["kinds"][kind]["seconds"]["@".join(c)]) for r in found["pairs"]])) for c in have]
        rows.append(["**geometric mean**", "", *middle, *(f"**{mean(ratios[p]):.1f}**" for p in peers)])
        parts += [f"### {title}", table(head, rows), differences(found, kind)]
    return "\n\n".join(parts)


def differences(found, kind):
    rows = {}
    poses = sum(r["kinds"][kind]["poses"] for r in found["pairs"])
    for r in found["pairs"]:
        for key, d in r["kinds"][kind]["differences"].items():
            sums = rows.setdefault(key, dict.fromkeys(d, 0))
            for k, v in d.items():
                sums[k] += v
    head = ["peer, clearance", f"answers of {poses:,} that differ from ours", "ours right", "peer right", "within 1e-9 m", "contained"]
    body = [[k.replace("@", ", "), *(d[x] for x in ("differ", "ours_right", "theirs_right", "within_1e-9", "of_these_contained"))] for k, d in rows.items()]
    return "Where answers differ, brute force over all pairs of triangles judges (at most twenty poses a pair of links). *Contained*: one mesh " \
           "lies inside the other, surfaces apart, which the peers do not look for.\n\n" + table(head, body)


def labels(found):
    parts = ["## Whole robots", "Clearance 1e-4 m, one thread, the same configurations for both sides, microseconds a configuration. *Boundary*: ends of "
             "segments between a free and a colliding configuration, halved to 1e-3 rad. pinocchio + coal (`computeCollisions`, which stops at "
             "the first pair) are called from Python once a configuration; what such a call costs by itself is in the last column and not taken out. "
             "*Batch*: the mean of `label_batch_serial`, which is what learning calls."]
    rows, contacts, batches = [], [], []
    for name, scene in found["robots"].items():
        for kind, row in scene["kinds"].items():
            f = row["figures"]
            middle = lambda side, key: statistics.median(x[key] for x in f[side])
            by = ratio([x["median"] for x in f["pin"]], [x["median"] for x in f["ours"]])
            by_mean = ratio([x["mean"] for x in f["pin"]], [x["mean"] for x in f["ours"]])
            by_batch = ratio([x["mean"] for x in f["pin"]], f["serial"])
            rows.append([name, kind, f"{row['colliding']:.0%}", us(middle("ours", "median")), us(middle("ours", "mean")), us(middle("ours", "p95")),
                         us(statistics.median(f["serial"])), us(middle("pin", "median")), us(middle("pin", "mean")),
                         f"{by:.1f} / {by_mean:.1f} / **{by_batch:.1f}**", us(scene["call_overhead"])])
            for search in ("coarse", "exact"):
                c = f[f"contacts {search}"]
                contacts.append([name, kind, search, f"{c[0]['contacts']:.1f}", us(statistics.median(x["median"] for x in c)),
                                 us(statistics.median(x["p95"] for x in c)), us(statistics.median(f["pin distances"]))])
            batches.append([name, kind, *(us(statistics.median(f[k])) for k in ("serial", "one", "two")), f"{ratio(f['one'], f['two']):.2f}"])
    parts.append(table(["scene", "configurations", "colliding", "ours, median", "mean", "95 %", "batch, mean",
                        "pinocchio + coal, median", "mean", "ratio of medians / means / mean over batch", "a call's own cost"], rows))
    lines = []
    for name, scene in found["robots"].items():
        for kind, row in scene["kinds"].items():
            lines.append([name, kind, row["configurations"], row["differ"], row["only_ours_collide"], f"{row['farthest_from_margin']:.2g}"])
    parts += ["Labels that differ, and how far coal's own distances say that the worst of them is from the clearance:",
              table(["scene", "configurations", "number", "differ", "only ours collide", "farthest from the clearance [m]"], lines)]
    parts += ["### Near pairs with gradients", "Contacts of all pairs nearer than 0.02 m with the gradient of each distance, microseconds. pinocchio + coal: "
              "`computeDistances` of all pairs and `computeJointJacobians` (no margin can be given).",
              table(["scene", "configurations", "search", "contacts", "ours, median", "95 %", "pinocchio + coal, median"], contacts)]
    parts += ["### Batches", "Microseconds a configuration of `label_batch_serial`, and of `label_batch` on one and on two threads (the shortest of 20, "
              "because other programs hold the cores too).",
              table(["scene", "configurations", "serial", "one thread", "two threads", "one / two"], batches)]
    return "\n\n".join(parts)


def growth(found):
    g = found["growth"]
    sides = [s for s in ("ours", "coal", "fcl") if f"{s} random" in g["triangles"][0]]
    head = ["triangles each", *(f"{s}, {k}" for k in KINDS for s in sides)]
    rows = [[f"{r['triangles']:,}", *(us(statistics.median(r[f"{s} {k}"])) for k in KINDS for s in sides)] for r in g["triangles"]]
    parts = ["## How cost grows", "Two balls with smooth bumps, of the same shape at every number of triangles; microseconds a check, clearance 0.",
             table(head, rows), "![Time against triangles](growth-triangles.svg)",
             "A chain of links of 512 triangles each, random configurations, microseconds a label: 7 links among boxes (which together keep their surface), and "
             "2 to 50 links (which together keep their length) among 10 boxes."]
    for key in ("obstacles", "links"):
        parts.append(table([key, "checked pairs", "colliding", "microseconds"], [[r["size"], r["pairs"], f"{r['colliding']:.0%}", us(r["mean"])] for r in g[key]]))
    parts.append("![Time against obstacles and links](growth-scenes.svg)")
    return "\n\n".join(parts)


def plots(g, folder):
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained")
    for axis, (kind, title) in zip(axes, KINDS.items()):
        for side, color in [("ours", "C0"), ("coal", "C1"), ("fcl", "C2")]:
            rows = [r for r in g["triangles"] if f"{side} {kind}" in r]
            if rows:
                axis.loglog([r["triangles"] for r in rows], [1e6 * statistics.median(r[f"{side} {kind}"]) for r in rows], "o-", color=color, label=side)
        axis.set(title=title, xlabel="triangles of each mesh", ylabel="us a check")
        axis.legend()
        axis.grid(alpha=0.3)
    save(figure, folder / "growth-triangles.svg")
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    for axis, key in zip(axes, ("obstacles", "links")):
        axis.loglog([r["size"] for r in g[key]], [1e6 * r["mean"] for r in g[key]], "o-")
        axis.set(xlabel=key, ylabel="us a label")
        axis.grid(alpha=0.3)
    save(figure, folder / "growth-scenes.svg")


def save(figure, path):
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)
    path.write_text("\n".join(line.rstrip() for line in path.read_text().splitlines()) + "\n")


def memory(found):
    sides = [s for s in ("ours", "coal", "fcl") if s in found["memory"][0]]
    rows = []
    for pair, row in zip(found["pairs"], found["memory"]):
        rows.append([pair["pair"].split(", ")[-1], f"{row['ours']['triangles']:,}", *(f"{row[s]['bytes'] / row[s]['triangles']:.0f}" for s in sides),
                     *(f"{1e3 * row[s]['build_seconds']:.1f}" for s in sides), f"{1e3 * row['ours']['read_seconds']:.0f}"])
    return "## Memory and building\n\nOf the second mesh of each pair, in a process of its own: growth of resident memory, and milliseconds to build the tree from " \
           "triangles in memory. Ours also reads, welds and sorts a mesh into components when the scene is loaded (last column).\n\n" + \
           table(["mesh", "triangles", *(f"{s}, bytes a triangle" for s in sides), *(f"{s}, ms" for s in sides), "ours, reading and welding, ms"], rows)


def exactness(found):
    e = found["exactness"]
    return "## Exactness\n\nAgainst all pairs of triangles in f64, by code that shares nothing with the checker: ordinary meshes, thin sheets and slabs, grids of coplanar " \
           "triangles, a single triangle, loose slivers, nested and open parts, 1e-5 m to 2 km, margins 0, 1e-6, 1e-4 m and 1 % of the size.\n\n" + \
           table(["poses", "near", "within 1e-6 m of the margin", "contained", "within 1e-9 m, not judged", "**disagreements**"],
                 [[f"{e['poses']:,}", f"{e['near']:,}", f"{e['within_1e-6']:,}", f"{e['contained']:,}", f"{e['undecided']:,}", f"**{e['disagreements']}**"]])


if __name__ == "__main__":
    import json
    from sides import BUILD, ROOT
    write(json.loads((BUILD / "collision.json").read_text()), Path(ROOT) / "docs" / "benchmarks")
