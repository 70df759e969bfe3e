#!/usr/bin/env python3
"""What learning costs and what seconds buy: its part of docs/benchmarks/learning.md, with plots.

    target/peers/bin/python bench/learning.py [--queries 200] [--only joints cores accuracy seconds]

Needs cargo, numpy and matplotlib (bench/requirements.txt; bench/peers installs them) and the fetched robots. What labels buy is measured by
bench/search.py.

joints   planar arms of 2 to 20 joints among six posts: labels and processor seconds until 95 % of random colliding queries that may take
         20 checks, and 50, are answered within 5 % of the best known
cores    the same learning run on one thread and on two: wall time, with how much of the machine other programs had meanwhile
accuracy `panda-box` with 20,000 labels and several seeds: how many held-out configurations the classifier calls what they are
seconds  models of some seconds on two threads: how many random colliding queries `refined` answers within 5 % and 1 % of the best known

Best known is the least depth that any model and effort of the run found (of `seconds`: of the same row), `exhaustive` on the largest included.
"""
import argparse
import functools
import pathlib
import statistics
import tempfile

import learning_accuracy
import learning_joints
import learning_seconds
import programs
import scenes
from page import number, put, table
from sides import ROOT, machine, others_during

# Measured by files of their own.
APART = {"joints": learning_joints, "accuracy": learning_accuracy, "seconds": learning_seconds}
TIMED = ("joints", "cores", "seconds")


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, pathlib.Path(folder)

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


def cores_section(rows, _):
    shown = [[k + 1, number(r[1]["wall"]), number(r[2]["wall"]), f"{r[2]['wall'] / r[1]['wall']:.2f}", number(r[1]["cpu"]), number(r[2]["cpu"]),
              f"{r[1]['others']:.1f}", f"{r[2]['others']:.1f}"] for k, r in enumerate(rows)]
    ratio = min(r[2]["wall"] for r in rows) / min(r[1]["wall"] for r in rows)
    head = ["round", "one thread [s]", "two threads [s]", "ratio", "processor time, one [s]", "two [s]", "cores that others had, one", "two"]
    others = statistics.median(r[2]["others"] for r in rows)
    told = f" Other programs had {others:.1f} of the machine's cores meanwhile (median), so the target is not judged by this." if others > 0.1 else ""
    return f"## Two cores\n\n`panda-box`, 100,000 labels, wall time. Shortest over shortest: **{ratio:.2f}** (target: at most 0.6).{told}\n\n{table(head, shown)}"


def main():
    parts = ("cores", *APART)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--queries", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=5, help="of the comparison of cores")
    parser.add_argument("--share", type=float, default=1.0, help="of the seconds that `seconds` learns for; less only tries it out")
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
        own = {"cores": (bench.cores, cores_section)}
        apart = {part: (functools.partial(file.measure, options, bench.folder), file.section) for part, file in APART.items()}
        for part in options.only:
            measure, section = (own | apart)[part]
            text = section(measure(), options.out)
            told = f"\n\nMachine: {machine()}, shared and noisy." if part in TIMED else ""
            put(options.out / "learning.md", f"bench/learning.py {part}", text.replace("\n\n", f"{told}\n\n", 1) if told else text, "Learning, measured")


if __name__ == "__main__":
    main()
