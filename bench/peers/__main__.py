#!/usr/bin/env python3
"""The query benchmark: ours beside other ways out of collision, all on the same colliding configurations.

    python3 bench/peers                 everything: installs the peers, fetches the robots, runs, writes the page and the plot
    python3 bench/peers --quick         the same in a few minutes, with few queries and small models; writes under target/bench only
    python3 bench/peers --write         only the page, from the figures of the last full run

Needs cargo, Python 3.11 or newer with venv and pip, and a network the first time. The peers go to the virtual environment
target/peers, robots to robots/, what is measured to target/bench/peers.json, the page to docs/benchmarks/query.md.

Peers: Drake's InverseKinematics with a minimum-distance constraint, from the query; sequential quadratic programming on the signed
distances of pinocchio + coal, from up to 64 starts; OMPL's searchValidNearby with a growing distance; random perturbation with a
growing spread; and the nearest stored sample alone, which is our effort `nearest`. Every witness of every side is checked again with
pinocchio + coal: within the limits, every pair at 0.9 of the clearance at least. One that fails counts as no answer. Depths are
measured from the witness and compared with the least that any method found for the query.

All sides are timed in processor time of the one thread that works, in turns within one run: what other programs do meanwhile is
not in it, but for what they take of the caches. Our program is begun anew for every turn; it answers other configurations for a tenth
of a second before it is timed, as the peers' processes, which last, have answered others.
"""
import argparse
import json
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent.parent)]

import install  # noqa: E402
import programs  # noqa: E402
from sides import BUILD, ROOT  # noqa: E402

QUICK = {"queries": 10, "labels": 60_000, "starts": 16}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="{queries} queries a scene, {labels} labels, {starts} starts".format(**QUICK))
    parser.add_argument("--write", action="store_true", help="only write the page again, from the last figures")
    parser.add_argument("--queries", type=int, default=100, help="a scene; raw meshes get two fifths, because of the peers")
    parser.add_argument("--labels", type=int, default=500_000, help="that each model is learned with")
    parser.add_argument("--starts", type=int, default=64, help="of the multistart of pinocchio + coal")
    parser.add_argument("--programs", type=Path, help="folder with the built extricate and extricate-bench; else cargo builds them")
    parser.add_argument("--scenes", nargs="+", metavar="NAME", help="only these")
    options = parser.parse_args()
    if options.quick:
        vars(options).update(QUICK)
    install.enter_environment()

    import report
    import run

    figures = BUILD / ("peers-quick.json" if options.quick else "peers.json")
    if not options.write:
        install.fetch_robots()
        if options.programs:
            programs.folder = options.programs.resolve()
        else:
            programs.build()
        found = run.everything(options)
        figures.write_text(json.dumps(found, indent=1))
    found = json.loads(figures.read_text())
    report.write(found, BUILD / "quick" if options.quick else ROOT / "docs" / "benchmarks")
    failed = run.failures(found)
    return f"{failed} answers of ours are missing, fail the check or claim too high a bound" if failed else 0


if __name__ == "__main__":
    sys.exit(main())
