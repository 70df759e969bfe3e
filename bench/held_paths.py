#!/usr/bin/env python3
"""Paths that hold tools: escapes, plans and repairs with `keep`, judged by pinocchio and coal at 40 places of every edge.

    python3 bench/peers --quick                    once: installs the peers into target/peers, and fetches the robots
    target/peers/bin/pip install ./crates/extricate-python
    target/peers/bin/python bench/held_paths.py    writes docs/benchmarks/motion.md; [--count 30] [--only ur5] write nothing

The colliding queries are those of bench/held.py for which `query` finds a free configuration that holds the links. An escape may go 1 cm
deeper. Where there is one, `repair` takes its path back and forth, and `plan` leads from its end to a free configuration that holds the
links, found by a query from elsewhere. Limits or collisions may keep the arm from going there with the tool held: the same plan is asked of a
scene in which one pair alone is checked. A path counts if the judge finds each link within its tolerances at every place, and the free part free."""
import argparse

import extricate
import numpy as np

from held import ROWS, Row
from page import number, put, table
from sides import ROOT, machine

PLACES = 40
ONE_PAIR = "plan, one pair checked"


class Paths(Row):
    """A row of bench/held.py, with paths in place of queries."""

    def is_kept(self, points, held, free):
        """Whether the links are held at all places of a path, and the places of the slice `free` of its points are free."""
        shares = np.linspace(0, 1, PLACES, endpoint=False)[:, None]
        places = np.concatenate([a + shares * (b - a) for a, b in zip(points, points[1:])] + [points[-1:]])
        is_free = all(self.passes(x, held) for x in places[PLACES * free.start : PLACES * (free.stop - 1) + 1])
        return is_free and bool(self.kinematics.within(places, held, 1.001).all())

    def judged(self, path, held):
        """Returns what became of a path: None if there is none, else whether the judge agrees."""
        if path.points is None:
            return None
        first, last = getattr(path, "free_from", 0), getattr(path, "free_to", len(path.points) - 1)
        return self.is_kept(path.points, held, slice(first, last + 1))

    def paths(self, count):
        """Returns for each kind of path whether it was found and held, its checks and points."""
        found, rng = {"escape": [], "repair": [], "plan": [], ONE_PAIR: []}, np.random.default_rng(3)
        note = lambda kind, path, held: found[kind].append((self.judged(path, held), path.checks, 0 if path.points is None else len(path.points)))
        bare, asked = extricate.Solver(self.scene.disabled(list(self.scene.pairs)[1:])), 0
        for q in self.queries():
            q = np.asarray(q)
            held, keep = self.held(q)
            if self.is_hopeless(q, held) or self.solver.query(q, keep=keep) is None:
                continue
            escape = self.solver.escape(q, keep=keep, tolerance=0.01)
            note("escape", escape, held)
            if escape.points is not None:
                there = [{**one, "pose": hold.target} for one, hold in zip(keep if isinstance(keep, list) else [keep], held)]
                back = np.concatenate([escape.points[::-1], escape.points[1:]])
                note("repair", self.solver.repair(back, keep=there), held)
                goal = self.solver.query(rng.uniform(self.judge.low, self.judge.high), keep=there)
                if goal is not None:
                    ends = escape.points[-1], goal.witness
                    note("plan", self.solver.plan(*ends, keep=there, max_checks=100_000), held)
                    other = bare.plan(*ends, keep=there, max_checks=100_000)
                    found[ONE_PAIR].append((None if other.points is None else True, other.checks, 0 if other.points is None else len(other.points)))
            asked += 1
            if asked == count:
                return found


def lines(row, found):
    _, robot, what = row
    for kind, paths in found.items():
        there = [path for path in paths if path[0] is not None]
        assert all(judged for judged, *_ in there), (row, kind)
        middle = lambda k: number(np.median([path[k] for path in there])) if there else ""
        yield [robot, what, kind, f"{len(there)} of {len(paths)}", middle(1), middle(2)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=30, help="queries of a row")
    parser.add_argument("--only", metavar="NAME", default="", help="rows whose names begin so")
    options = parser.parse_args()
    measured = []
    for row in ROWS:
        if row[0].startswith(options.only):
            measured += lines(row, Paths(*row).paths(options.count))
            print(*measured[-4:], sep="\n", flush=True)
    text = table(["scene", "held", "path", "found", "checks, median", "points, median"], measured)
    if not options.only:
        put(ROOT / "docs" / "benchmarks" / "motion.md", "bench/held_paths.py", f"Machine: {machine()}, shared and noisy.\n\n{text}", "Motions")


if __name__ == "__main__":
    main()
