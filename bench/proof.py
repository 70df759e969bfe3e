#!/usr/bin/env python3
"""How much of the depth is proved, and how soon: for docs/benchmarks/proof.md.

    target/peers/bin/python bench/proof.py [--scenes planar-arm 'boxes-*' ...] [--queries 40] [--program DIR] [--write]

Needs cargo, numpy and matplotlib (bench/requirements.txt). Scenes of the fetched robots are there once scripts/fetch-robots.py was run; built-in and drawn ones always. All are asked without a model, one thread.
`refined` and `exhaustive` are asked without limits; `proved` with a gap of 0.05 for each of --seconds. The gap is 1 - lower_bound / depth; closed is the share of queries where it is at most 0.05.
Times are of this machine; of `proved` what counts is which share is closed within a limit.
"""
import argparse
import fnmatch
import json
import pathlib
import subprocess

import numpy as np

from page import put, save, table
from sides import ROBOTS, ROOT

PAGE = ROOT / "docs" / "benchmarks" / "proof.md"
GAP = 0.05


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=["*"], metavar="PATTERN", help="names, with * and ? as in file names")
    parser.add_argument("--files", nargs="*", default=[], type=pathlib.Path, metavar="SCENE", help="scene files of your own")
    parser.add_argument("--queries", type=int, default=40, help="of each scene")
    parser.add_argument("--seconds", default="0.01,0.1,1", help="limits of `proved`")
    parser.add_argument("--program", type=pathlib.Path, help="folder of a built extricate; else cargo builds it")
    parser.add_argument("--write", action="store_true", help="write the page")
    return parser.parse_args()


def scenes(patterns):
    import scenes as named

    files = named.written() if ROBOTS.is_dir() else {name: named.built_in(name) for name in named.BUILT_IN}
    return {name: path for name, path in files.items() if any(fnmatch.fnmatch(name, pattern) for pattern in patterns)}


def answers(program, scene, queries, *options):
    """Returns the rows of `query --json`; rows without an answer have no depth."""
    command = [program, "query", scene, "--input", "-", "--json", "--threads", "1", *options]
    run = subprocess.run([str(word) for word in command], input=queries, capture_output=True, text=True, check=True)
    return [row for row in map(json.loads, run.stdout.splitlines()) if row.get("depth", 0) > 0]


def measure(program, scene, count, limits):
    draw = subprocess.run([str(program), "sample", str(scene), "-n", str(count), "--seed", "7", "--colliding"], capture_output=True, text=True, check=True)
    kinds = {"refined": [], "exhaustive": ["--effort", "exhaustive"]}
    kinds |= {f"proved {limit} s": ["--effort", "proved", "--gap", str(GAP), "--max-seconds", limit] for limit in limits}
    return {kind: answers(program, scene, draw.stdout, *options) for kind, options in kinds.items()}


def rows_of(name, found):
    best = np.min([[row["depth"] for row in rows] for rows in found.values()], axis=0)
    for kind, rows in found.items():
        bounds, gaps = np.array([row["lower_bound"] for row in rows]), np.array([row["gap"] for row in rows])
        assert (bounds <= best * (1 + 1e-9)).all(), f"{name}, {kind}: a bound is above a depth"
        share = bounds / best
        seconds = 1e3 * np.median([row["seconds"] for row in rows])
        yield [name, kind, f"{np.median(share):.2f}", f"{np.quantile(share, 0.1):.2f}", f"{(gaps <= GAP * (1 + 1e-6)).mean():.2f}", f"{seconds:.3g}"]


def draw(found, path):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6, 3.6))
    for name, kinds in found.items():
        points = sorted((np.median([row["seconds"] for row in rows]), np.median([row["gap"] for row in rows])) for rows in kinds.values())
        axes.plot(*zip(*((1e3 * seconds, gap) for seconds, gap in points)), marker="o", markersize=3, label=name)
    axes.set(xscale="log", xlabel="median time of a query [ms]", ylabel="median gap", ylim=(0, None))
    axes.legend(fontsize=7)
    figure.tight_layout()
    save(figure, path)


def main():
    options = arguments()
    program = (options.program or ROOT / "target" / "release") / "extricate"
    if options.program is None:
        subprocess.run(["cargo", "build", "--release", "-p", "extricate-cli"], cwd=ROOT, check=True)
    files = scenes(options.scenes) | {path.stem: path for path in options.files}
    found = {}
    for name, path in files.items():
        found[name] = measure(program, path, options.queries, options.seconds.split(","))
        print(table(["scene", "effort", "proved of the best, median", "of one in ten less than", "closed", "ms, median"], rows_of(name, found[name])), flush=True)
    if options.write:
        rows = [row for name, kinds in found.items() for row in rows_of(name, kinds)]
        text = table(["scene", "effort", "proved of the best depth, median", "of one in ten less than", "closed", "ms, median"], rows)
        draw(found, PAGE.parent / "proof-time.svg")
        put(PAGE, "bench/proof.py", f"{text}\n\n![Gap against time](proof-time.svg)", "Proved bounds")


if __name__ == "__main__":
    main()
