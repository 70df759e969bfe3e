#!/usr/bin/env python3
"""Trains our support vector machine and scikit-learn's SVC on the same points, one core each, and compares time and dual objective.

    target/peers/bin/python bench/svm.py [--samples 20000] [--rounds 3]

Needs cargo, numpy, scikit-learn and matplotlib (bench/requirements.txt; bench/peers installs them) and the fetched Panda: the points
are uniform configurations of the scene `panda-box` (bench/scenes.py). Writes its part of docs/benchmarks/learning.md. Rounds alternate
between the two, and the ratio is that of processor times within a round, so that a machine that others use too says the same. Both
get the same penalty, the same kernel width, the same tolerance (1e-3) and 1 GiB of kernel cache.
"""
import argparse
import json
import os
import subprocess
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np
from sklearn.svm import SVC

import scenes
from page import number, put, table
from sides import ROOT, machine

# Targets: the speedup, and the relative difference of the dual objectives.
FASTER, DIFFERENCE = 5.0, 1e-3


def ours(options, folder):
    cargo = ["cargo", "run", "--release", "--quiet", "-p", "extricate", "--example", "svm_training", "--"]
    program = [options.program] if options.program else cargo
    arguments = [str(scenes.written()["panda-box"]), str(options.samples), str(options.gamma_factor), str(options.penalty), folder]
    return json.loads(subprocess.run(program + arguments, cwd=ROOT, check=True, capture_output=True, text=True).stdout)


def theirs(found, folder):
    rows = np.fromfile(os.path.join(folder, "features.f64"), "<f8").reshape(found["samples"], -1)
    labels = np.fromfile(os.path.join(folder, "labels.u8"), np.uint8).astype(int)
    svc = SVC(C=found["penalty"], kernel="rbf", gamma=found["gamma"], tol=1e-3, cache_size=1024)
    cpu, started = time.process_time(), time.perf_counter()
    svc.fit(rows, labels)
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    # The dual objective is sum alpha - 1/2 beta' K beta, computed in blocks of rows.
    beta, support = svc.dual_coef_[0], svc.support_vectors_
    squares, quadratic = (support**2).sum(1), 0.0
    for i in range(0, len(support), 2000):
        part = support[i : i + 2000]
        kernel = np.exp(-found["gamma"] * np.maximum(squares[i : i + 2000, None] + squares - 2 * part @ support.T, 0))
        quadratic += beta[i : i + 2000] @ kernel @ beta
    return {"seconds": seconds, "cpu_seconds": cpu, "dual_objective": np.abs(beta).sum() - 0.5 * quadratic, "support_vectors": len(support)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=20000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--gamma-factor", type=float, default=3.0)
    parser.add_argument("--penalty", type=float, default=10.0)
    parser.add_argument("--program", help="the built example svm_training, instead of cargo run")
    options = parser.parse_args()
    rows, ratios, differences = [], [], []
    for k in range(options.rounds):
        with tempfile.TemporaryDirectory() as folder:
            a = ours(options, folder)
            b = theirs(a, folder)
        ratios.append(b["cpu_seconds"] / a["cpu_seconds"])
        differences.append(abs(a["dual_objective"] / b["dual_objective"] - 1))
        for side, found in (("ours", a), ("SVC", b)):
            rows.append([k + 1, side, number(found["cpu_seconds"]), f"{found['support_vectors']:,}", f"{found['dual_objective']:.4f}"])
        print(f"ours {a['cpu_seconds']:.2f} s, SVC {b['cpu_seconds']:.2f} s, objectives differ by {differences[-1]:.1e}", flush=True)
    write(options, a["dimensions"], rows, float(np.median(ratios)), max(differences))


def write(options, dimensions, rows, ratio, difference):
    met = "met" if ratio >= FASTER and difference <= DIFFERENCE else "**missed**"
    text = f"""## Training the classifier

{options.samples:,} uniform configurations of `panda-box`, {dimensions} features, penalty {options.penalty:g}; one core each, processor time; {machine()}.

**{ratio:.1f} times faster** than scikit-learn's SVC (median of {options.rounds} rounds), dual objectives equal to {difference:.0e}. Target: {FASTER:g} times at
equal objectives to {DIFFERENCE:g}; {met}.

""" + table(["round", "side", "processor time [s]", "support vectors", "dual objective"], rows)
    put(ROOT / "docs" / "benchmarks" / "learning.md", "bench/svm.py", text, "Learning, measured")


if __name__ == "__main__":
    main()
