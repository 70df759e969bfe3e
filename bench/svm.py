#!/usr/bin/env python3
"""Trains our support vector machine and scikit-learn's SVC on the same points, one core each, and compares time and dual objective.

    python3 bench/svm.py robots/panda-box.toml [--samples 20000] [--rounds 3]

Needs numpy and scikit-learn. Rounds alternate between the two, and the ratio of times is that within a round, so that a machine
that others use too says the same. Both get the same penalty, the same kernel width, the same tolerance (1e-3) and 1 GiB of kernel
cache.
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

REPOSITORY = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def ours(options, folder):
    cargo = ["cargo", "run", "--release", "--quiet", "-p", "extricate", "--example", "svm_training", "--"]
    program = [options.program] if options.program else cargo
    scene = os.path.abspath(options.scene)
    arguments = [scene, str(options.samples), str(options.gamma_factor), str(options.penalty), folder]
    return json.loads(subprocess.run(program + arguments, cwd=REPOSITORY, check=True, capture_output=True, text=True).stdout)


def theirs(found, folder):
    rows = np.fromfile(os.path.join(folder, "features.f64"), "<f8").reshape(found["samples"], -1)
    labels = np.fromfile(os.path.join(folder, "labels.u8"), np.uint8).astype(int)
    svc = SVC(C=found["penalty"], kernel="rbf", gamma=found["gamma"], tol=1e-3, cache_size=1024)
    cpu, started = time.process_time(), time.perf_counter()
    svc.fit(rows, labels)
    seconds, cpu = time.perf_counter() - started, time.process_time() - cpu
    # sum alpha - 1/2 beta' K beta, in blocks of rows.
    beta, support = svc.dual_coef_[0], svc.support_vectors_
    squares, quadratic = (support**2).sum(1), 0.0
    for i in range(0, len(support), 2000):
        part = support[i : i + 2000]
        kernel = np.exp(-found["gamma"] * np.maximum(squares[i : i + 2000, None] + squares - 2 * part @ support.T, 0))
        quadratic += beta[i : i + 2000] @ kernel @ beta
    return {"seconds": seconds, "cpu_seconds": cpu, "dual_objective": np.abs(beta).sum() - 0.5 * quadratic, "support_vectors": len(support)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene")
    parser.add_argument("--samples", type=int, default=20000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--gamma-factor", type=float, default=3.0)
    parser.add_argument("--penalty", type=float, default=10.0)
    parser.add_argument("--program", help="the built example svm_training, instead of cargo run")
    options = parser.parse_args()
    ratios = []
    for _ in range(options.rounds):
        with tempfile.TemporaryDirectory() as folder:
            a = ours(options, folder)
            b = theirs(a, folder)
        ratios.append(b["cpu_seconds"] / a["cpu_seconds"])
        print(f"ours {a['cpu_seconds']:.2f} s, {a['support_vectors']} support vectors, dual objective {a['dual_objective']:.6f}")
        print(f"SVC  {b['cpu_seconds']:.2f} s, {b['support_vectors']} support vectors, dual objective {b['dual_objective']:.6f}")
        difference = abs(a["dual_objective"] / b["dual_objective"] - 1)
        print(f"ratio of times {ratios[-1]:.2f}, relative difference of the objectives {difference:.1e}", flush=True)
    print(f"{options.samples} samples of {a['dimensions']} features: {np.median(ratios):.1f} times faster (median of {len(ratios)})")


if __name__ == "__main__":
    main()
