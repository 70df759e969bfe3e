#!/usr/bin/env python3
"""The benchmark of motions: escapes, plans and repairs beside OMPL, checks counted alike, in one run.

    python3 bench/applications escape        colliding starts of built-in scenes: straight to the nearest exit, one of six, ours
    python3 bench/applications plan          narrow passages of our own (passages.py), beside OMPL's planners
    python3 bench/applications open          open scenes, beside OMPL's RRTConnect
    python3 bench/applications repair        straight paths that collide, and planned paths after an obstacle moved
    python3 bench/applications clip          clips of a humanoid, repaired frame by frame, judged by pinocchio and coal
    python3 bench/applications judged        edges of all motions, judged by pinocchio and coal
    python3 bench/applications reset         random states of three robots brought to touch the ground or an object, judged by MuJoCo
    ... --quick                              few of each; writes nothing

Needs the wheels of extricate, ompl (2.0.1), pin and coal in the environment. A check is one configuration that our exact checker evaluated, for
both sides: ours are labels, contacts and stretches of proofs; OMPL's are calls of its state validity checker, which is ours. A path
counts where every edge is proved free; a path of ours is proved before it is returned, one of OMPL is proved afterwards, at no cost to it.
The page is docs/benchmarks/motion.md.
"""
import argparse
import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent.parent)]

import numpy as np  # noqa: E402

import clips  # noqa: E402
import edges  # noqa: E402
import escapes  # noqa: E402
import paths  # noqa: E402
import repairs  # noqa: E402
import resets  # noqa: E402
from page import put  # noqa: E402

PAGE = Path(__file__).resolve().parent.parent.parent / "docs" / "benchmarks" / "motion.md"
PARTS = {"escape": escapes.table, "plan": paths.narrow, "open": paths.open_scenes, "repair": repairs.repaired, "judged": edges.judged, "clip": clips.clips, "reset": resets.resets}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--count", type=int, help="starts, seeds or paths a scene")
    parser.add_argument("--checks", type=float, default=1e6, help="that a planner may spend")
    parser.add_argument("--planners", nargs="+", default=["ours", "RRTConnect", "BKPIECE1", "PRM"], help="of `plan`")
    parser.add_argument("--scenes", nargs="+", metavar="NAME", help="only these")
    options = parser.parse_args()
    np.set_printoptions(precision=4, suppress=True)
    text = PARTS[options.part](options)
    print(text)
    if not options.quick:
        put(PAGE, f"bench/applications {options.part}", text, "Motions")


if __name__ == "__main__":
    main()
