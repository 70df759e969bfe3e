#!/usr/bin/env python3
"""How the time of a query grows with samples and with obstacles, and what streams save: figures and plots for docs/benchmarks/query.md.

    target/peers/bin/python bench/query.py [--queries 100] [--labels 500000] [--only samples obstacles streams]

Needs cargo, numpy and matplotlib (bench/requirements.txt; bench/peers installs them), streams the fetched robots. Measured on one thread, the first
two on the built-in `shelf-arm`, its links as hulls:

samples    time and checks of a query against the number of boundary samples, from models of 10^4 labels to the default
obstacles  the same against the number of obstacles: the arm among 1 to 1000 boxes, of together the same volume
streams    frames of motions through colliding configurations of the scenes of bench/scenes.py, each asked by a stream and on its own

Times are processor time of the thread. The same queries are asked in several rounds, all rows in turns; of each query the shortest
time counts, and medians are over queries. The exponent p is that of the power law time = c n^p that fits the medians best.
"""
import argparse
import math
import pathlib
import random
import statistics
import tempfile

import matplotlib.pyplot as plt
import numpy as np

import programs
import query_streams
import scenes
from page import number, put, save, table
from sides import ROOT, machine

EFFORTS = ("nearest", "refined")
COUNTS = (1, 3, 10, 30, 100, 300, 1000)
OBSTACLE_LABELS = 30_000
GROWTH = ("samples", "obstacles")
PARTS = (*GROWTH, "streams")


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, pathlib.Path(folder)
        exported = scenes.built_in("shelf-arm")
        self.arm = exported.with_name("shelf-hulls.toml")
        self.arm.write_text(exported.read_text().replace("[[robot]]", '[[robot]]\ngeometry = "convex-hull"'))

    def learn(self, scene, labels):
        """The model, and how many samples it has."""
        model = self.folder / f"{scene.stem}-{labels}.model"
        return model, programs.learn(scene, model, labels)["statistics"]["boundary_samples"]

    def queries(self, scene):
        return programs.sample(scene, self.options.queries, 7)

    def figures(self, asked):
        """Converts rows of (what, model, queries) to rows of figures, one for each effort."""
        answers = {}
        for _ in range(self.options.rounds):
            for k, (_, model, queries) in enumerate(asked):
                for effort in EFFORTS:
                    answers.setdefault((k, effort), []).append(programs.answers(model, queries, effort))
        rows = []
        for k, (what, *_) in enumerate(asked):
            for effort in EFFORTS:
                rounds = answers[k, effort]
                us = [1e6 * min(a["seconds"] for a in of) for of in zip(*rounds)]
                row = {"us": statistics.median(us), "us_95": float(np.quantile(us, 0.95))}
                row |= {"checks": statistics.median(a["checks"] for a in rounds[0]), "depth": statistics.mean(a["depth"] for a in rounds[0])}
                rows.append(what | {"effort": effort} | row)
        return rows

    def samples(self):
        asked, queries, budgets = [], self.queries(self.arm), [10_000]
        while budgets[-1] < self.options.labels:
            last = budgets[-1]
            budgets.append(min(self.options.labels, 3 * last if str(last).startswith("1") else last // 3 * 10))
        for labels in budgets:
            model, stored = self.learn(self.arm, labels)
            asked.append(({"labels": labels, "samples": stored}, model, queries))
        return self.figures(asked)

    def obstacles(self):
        asked, robot = [], self.arm.read_text().split("[[obstacle]]")[0]
        for count in COUNTS:
            scene = self.arm.with_name(f"boxes{count}.toml")
            scene.write_text(robot + boxes(count))
            asked.append(({"obstacles": count}, self.learn(scene, OBSTACLE_LABELS)[0], self.queries(scene)))
        return self.figures(asked)


def boxes(count):
    """Draws boxes in a shell around the arm, as entries of a scene file. Their total volume does not depend on their number, in the mean."""
    rng, size, text = random.Random(count), 0.35 / count ** (1 / 3), ""
    for k in range(count):
        x, y, z = 0.0, 0.0, 0.0
        while not 0.35 < (x * x + y * y) ** 0.5 < 1.0:
            x, y, z = rng.uniform(-1, 1), rng.uniform(-1, 1), rng.uniform(0.0, 1.2)
        sides = [round(size * rng.uniform(0.5, 1.0), 4) for _ in range(3)]
        text += f'[[obstacle]]\nname = "box{k}"\nshape = {{ box = {sides} }}\npose = {{ xyz = [{x:.3f}, {y:.3f}, {z:.3f}] }}\n'
    return text


def exponent(rows, key):
    """Returns the exponent of the power law that fits best."""
    return float(np.polyfit(np.log([row[key] for row in rows]), np.log([row["us"] for row in rows]), 1)[0])


def beside_logarithm(rows, key):
    """Says how much the time of each effort grows from the smallest to the largest row, beside the logarithm of `key`."""
    first, last, grown = rows[0], rows[-1], []
    for effort in EFFORTS:
        times = [row["us"] for row in rows if row["effort"] == effort]
        grown.append(f"`{effort}` x {times[-1] / times[0]:.2f}")
    # The logarithm of 1 is 0, so that there is no ratio.
    logarithm = f"; their logarithm x {math.log(last[key]) / math.log(first[key]):.2f}" if first[key] > 1 else ""
    return f"From {first[key]:,} to {last[key]:,} {key}: {', '.join(grown)}{logarithm}."


def section(title, rows, key, picture, folder):
    columns = [c for c in rows[0] if c not in ("effort", "us", "us_95", "checks", "depth")]
    head = [*columns, "effort", "time, median [us]", "95 %", "checks, median", "depth, mean"]
    body = table(head, [[*(f"{row[c]:,}" for c in columns), row["effort"], number(row["us"]), number(row["us_95"]), number(row["checks"]), number(row["depth"])] for row in rows])
    figure, axes = plt.subplots(1, 2, figsize=(8, 3.2), layout="constrained")
    grown = []
    for effort in EFFORTS:
        of = [row for row in rows if row["effort"] == effort]
        grown.append(f"`{effort}` {exponent(of, key):.2f}")
        for axis, what in zip(axes, ("us", "checks")):
            axis.loglog([row[key] for row in of], [row[what] for row in of], "o-", label=effort)
    for axis, what in zip(axes, ("microseconds", "checks")):
        axis.set(xlabel=key, ylabel=f"{what}, median")
        axis.grid(True, alpha=0.3)
    axes[0].legend()
    save(figure, folder / picture)
    return f"### {title}\n\nExponents p of {key}: {', '.join(grown)} (1 would be linear, 0 no growth). {beside_logarithm(rows, key)}\n\n{body}\n\n![{title}]({picture})"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, help="folder with the built extricate and extricate-bench; else cargo builds them")
    parser.add_argument("--queries", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--labels", type=int, default=500_000, help="of the largest model; as many as `learn` takes by default")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--segments", type=int, default=20, help="between successive queries, that streams walk along")
    parser.add_argument("--frames", type=int, help="of each of these; all by default")
    parser.add_argument("--stream-labels", type=int, default=1_000_000, help="of the models that streams ask")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "docs/benchmarks")
    options = parser.parse_args()
    if options.programs:
        programs.folder = options.programs.resolve()
    else:
        programs.build()
    page, told = options.out / "query.md", f"Machine: {machine()}, shared and noisy; one thread"
    parts = ["## How the time grows", f"{told}; `shelf-arm` with its links as hulls, {options.queries} random colliding configurations."]
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, folder)
        if "samples" in options.only:
            parts.append(section("Time against samples", bench.samples(), "samples", "query-samples.svg", options.out))
        if "obstacles" in options.only:
            parts.append(section("Time against obstacles", bench.obstacles(), "obstacles", "query-obstacles.svg", options.out))
        if set(GROWTH) & set(options.only):
            put(page, "bench/query.py", "\n\n".join(parts), "Queries, measured")
        if "streams" in options.only:
            text = query_streams.section(query_streams.measure(options, bench.folder), options)
            put(page, "bench/query.py streams", text.replace("\n\n", f"\n\n{told}.\n\n", 1), "Queries, measured")


if __name__ == "__main__":
    main()
