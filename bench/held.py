#!/usr/bin/env python3
"""Tools held: queries with `keep`, beside a dense search and Drake's InverseKinematics, every answer judged by pinocchio and coal.

    python3 bench/peers --quick                    once: installs the peers into target/peers, and fetches the robots
    target/peers/bin/pip install ./crates/extricate-python
    target/peers/bin/python bench/held.py          everything: two hours on one core; writes docs/benchmarks/query.md
    ... --count 20 --only ur5                      fewer queries, of the rows whose names begin so
    ... --write                                    only the page, from the last figures of every row

Random colliding configurations of a Panda before a box, a UR5 before a shelf, and two arms of seven joints that hold a box, beside a
post; but those at which bodies collide that the held links do not let move relative to each other. A query counts if some free
configuration is known that holds the links: from the dense search (held_search.py) or a query. *Found* is the share of those with an
answer that passes the judge: within limits, every pair at 0.9 of the clearance by coal, links within their tolerances by pinocchio.
*Within 5 %* is beside the nearest that any of them found.

Drake's program minimises the squared distance to the query under its minimum-distance constraint, and position and orientation
constraints of the same tolerances; it begins at the query, and then at random configurations. Only its solver is timed. All times are
processor time of one thread, as ratios to a plain query's for the same configuration."""
import argparse
import json
import sys
import time
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent / "peers")]

import numpy as np  # noqa: E402
import pinocchio as pin  # noqa: E402
import pydrake.all as drake  # noqa: E402

import extricate  # noqa: E402
import scenes  # noqa: E402
from drake_ik import Drake, transform  # noqa: E402
from held_search import Held, Kinematics, nearest  # noqa: E402
from page import number, put, table  # noqa: E402
from pin_scene import PinScene  # noqa: E402
from run import clear  # noqa: E402
from sides import ROBOTS, ROOT, machine  # noqa: E402

PAGE = ROOT / "docs" / "benchmarks" / "query.md"
# Drake is asked for this share of each tolerance: its answers touch what they are asked for.
ASKED = 0.9
# Random starts of Drake after the query itself.
DRAKE_STARTS = 4
# Most configurations that are asked for each that counts.
MOST_DRAWS = 12
HAND, HANDS = {"panda": "panda_hand_tcp", "ur5": "tool0"}, ("left_hand", "right_hand")
BOX = (0.16, 0.3, 0.12)
# Name of a row, its scene, and what is held.
ROWS = [(f"{robot}-{what}", robot, what) for robot in HAND for what in ("pose", "axis", "position")] + [
    ("arms-relative", "arms", "relative pose"), ("arms-both", "arms", "both poses")]


def two_arms():
    """Returns the URDF of two arms of seven joints on one base, the left of which has a box in its hand."""
    parts = ['<robot name="arms"><link name="base"/>']
    # Links: length, radius; joints: axis, limit.
    links = [(0.34, 0.06, "0 0 1", 2.9), (0.2, 0.055, "0 1 0", 2.0), (0.2, 0.055, "0 0 1", 2.9), (0.2, 0.05, "0 -1 0", 2.1),
             (0.2, 0.05, "0 0 1", 2.9), (0.09, 0.045, "0 1 0", 2.1), (0.09, 0.04, "0 0 1", 3.0)]
    for side, y in (("left", 0.3), ("right", -0.3)):
        parent, at = "base", f"0 {y} 0"
        for k, (length, radius, axis, limit) in enumerate(links, 1):
            parts.append(
                f'<link name="{side}_{k}"><collision><origin xyz="0 0 {length / 2}"/><geometry><cylinder radius="{radius}" length="{length}"/>'
                f'</geometry></collision></link><joint name="{side}_joint_{k}" type="revolute"><parent link="{parent}"/><child link="{side}_{k}"/>'
                f'<origin xyz="{at}"/><axis xyz="{axis}"/><limit lower="-{limit}" upper="{limit}" effort="1" velocity="1"/></joint>')
            parent, at = f"{side}_{k}", f"0 0 {length}"
        parts.append(f'<link name="{side}_hand"/><joint name="{side}_tip" type="fixed"><parent link="{parent}"/><child link="{side}_hand"/>'
                     f'<origin xyz="{at}"/></joint>')
    size = " ".join(map(str, BOX))
    parts.append(f'<link name="box"><collision><geometry><box size="{size}"/></geometry></collision></link><joint name="grip" type="fixed">'
                 f'<parent link="left_hand"/><child link="box"/><origin xyz="0 0 {BOX[0] / 2 + 0.005}" rpy="0 1.5707963267948966 0"/></joint></robot>')
    return "\n".join(parts)


def opposite():
    """Returns the pose of the right hand in the left one's coordinates: at the other side of the box, facing it."""
    return np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, BOX[0] + 0.01], [0, 0, 0, 1]])


def scene_file(name):
    scenes.FOLDER.mkdir(parents=True, exist_ok=True)
    path = scenes.FOLDER / f"held-{name}.toml"
    where = {"robots": ROBOTS, "packages": ROBOTS.parent.parent}
    if name == "panda":
        text = scenes.PANDA.format(geometry="convex-hull", **where) + scenes.obstacle("box", "box = [0.2, 0.6, 0.4]", [0.45, 0, 0.45])
    elif name == "ur5":
        text = scenes.UR5.format(**where) + scenes.shelf()
    else:
        urdf = scenes.FOLDER / "two-arms.urdf"
        urdf.write_text(two_arms())
        # Links next to a short one overlap when it bends, and both hands touch the box.
        off = [[f"{side}_{a}", f"{side}_{b}"] for side in ("left", "right") for a, b in ((1, 3), (3, 5), (5, 7), (4, 6))]
        off += [["box", f"{side}_{k}"] for side in ("left", "right") for k in (6, 7)]
        text = f'clearance = 1e-4\n[[robot]]\nurdf = "{urdf}"\n[pairs]\ndisable = {json.dumps(off)}\n'
        text += scenes.obstacle("table", "box = [1.8, 1.8, 0.05]", [0.4, 0, -0.1]) + scenes.obstacle("post", "cylinder = [0.06, 0.8]", [0.42, 0, 0.35])
    path.write_text(text)
    return path


class HeldDrake(Drake):
    """Drake's program with constraints of held links; made anew for each query, which is not timed."""

    def hold(self, held):
        self.program()
        for one in held:
            (body, at), (base, base_at) = self.body(one.link), self.body(one.base)
            goal = base_at * pin.SE3(one.target)
            if one.position is not None:
                # The constraint is a box, and what is held a ball.
                most = np.full(3, ASKED * one.position / np.sqrt(3))
                self.ik.AddPositionConstraint(body, at.translation, base, transform(goal), -most, most)
            if one.rotation is not None and one.axis is None:
                turned = [drake.RotationMatrix(pose.rotation) for pose in (goal, at)]
                self.ik.AddOrientationConstraint(base, turned[0], body, turned[1], ASKED * one.rotation)
            elif one.rotation is not None:
                axis = np.array(one.axis, float)
                self.ik.AddAngleBetweenVectorsConstraint(base, goal.rotation @ axis, body, at.rotation @ axis, 0.0, ASKED * one.rotation)

    def body(self, name):
        """Returns the frame of the body that a link is on, and the link's pose on it."""
        if name is None:
            return self.plant.world_frame(), pin.SE3.Identity()
        model = self.scene.model
        frame = model.frames[model.getFrameId(name)]
        body = self.plant.world_body() if frame.parentJoint == 0 else self.plant.GetBodyByName(f"body of {model.names[frame.parentJoint]}")
        return body.body_frame(), frame.placement

    def best(self, q, held, starts, passes, distance):
        """Returns the witness from the query and the best of all starts that passes the judge, each with its seconds."""
        self.hold(held)
        seconds, found, first = 0.0, None, None
        cost = 2 * np.eye(len(q)), -2 * q, q @ q
        self.cost.UpdateCoefficients(*cost, True)
        for k, start in enumerate([q, *starts]):
            guess = np.zeros(len(self.order))
            guess[self.order] = start
            began = time.thread_time()
            result = self.solver.Solve(self.ik.prog(), guess, None)
            seconds += time.thread_time() - began
            witness = result.GetSolution(self.x) if result.is_success() else None
            if witness is not None and passes(witness) and (found is None or distance(witness) < distance(found)):
                found = witness
            if k == 0:
                first = found, seconds
        return first, (found, seconds)


class Row:
    """One scene and one way to hold."""

    def __init__(self, name, robot, what):
        path = scene_file(robot)
        self.name, self.robot, self.what = name, robot, what
        self.scene, self.judge = extricate.Scene.load(path), PinScene(path)
        ours = {frozenset(pair) for pair in self.scene.pairs}
        names = self.judge.names
        theirs = {frozenset((names[p.first], names[p.second])) for p in self.judge.geometry.collisionPairs}
        assert ours == theirs, (ours - theirs, theirs - ours)
        self.solver, self.kinematics, self.drake = extricate.Solver(self.scene), Kinematics(self.judge), HeldDrake(self.judge)
        self.rng = np.random.default_rng(7)

    def queries(self):
        """Draws colliding configurations without end; arms hold the box at all of them."""
        for seed in range(1, 10**6):
            if self.robot != "arms":
                yield from self.scene.sample(100, seed=seed, colliding=True)
                continue
            Q = self.rng.uniform(self.judge.low, self.judge.high, (400, self.scene.nq))
            Q = self.kinematics.solve(Q, [Held(HANDS[1], opposite(), HANDS[0])])
            yield from Q[~self.scene.check(Q, threads=1)]

    def held(self, q):
        """Returns what is held at q, and `keep` for it."""
        if self.what == "relative pose":
            return [Held(HANDS[1], opposite(), HANDS[0])], {"link": HANDS[1], "relative_to": HANDS[0], "pose": opposite()}
        links = HANDS if self.robot == "arms" else (HAND[self.robot],)
        R, p = self.kinematics.poses(q[None])
        held = []
        for link in links:
            _, turn, at = self.kinematics.frame(link, R, p)
            target = np.eye(4)
            target[:3, :3], target[:3, 3] = turn[0], at[0]
            held.append(Held(link, target, rotation=None if self.what == "position" else 1e-3, axis=(0, 0, 1) if self.what == "axis" else None))
        extra = {"position": {"rotation": None}, "axis": {"axis": [0, 0, 1]}}.get(self.what, {})
        return held, [{"link": link, **extra} for link in links]

    def is_hopeless(self, q, held):
        """Whether bodies collide that cannot move relative to each other, because they are on held links or in the world."""
        if self.what not in ("pose", "both poses"):
            return False
        model, objects = self.judge.model, self.judge.geometry.geometryObjects
        fixed = {0, *(int(model.frames[model.getFrameId(one.link)].parentJoint) for one in held)}
        names = {g.name if g.name in self.judge.names else model.frames[g.parentFrame].name for g in objects if g.parentJoint in fixed}
        return any(names.issuperset(pair) for pair in self.scene.colliding_pairs(q))

    def passes(self, x, held):
        return self.judge.inside(x, 1e-6) and clear(self.judge, x) and bool(self.kinematics.within(x[None], held, 1.001)[0])

    def one(self, q, held, keep):
        distance = lambda x: self.judge.distance(q, x)
        passes = lambda x: self.passes(x, held)
        # A first call each, since what ran before is still in the caches.
        self.solver.query(q, effort="quick")
        began = time.thread_time()
        plain = self.solver.query(q)
        between = time.thread_time()
        answer = self.solver.query(q, keep=keep)
        seconds = time.thread_time() - between
        row = {"plain_seconds": between - began, "plain_checks": plain.checks, "seconds": seconds, "checks": answer.checks if answer else None}
        dense = nearest(self.kinematics, q, held, lambda Q: self.scene.check(Q, threads=1), self.rng)
        first, all_ = ((None, 0.0), (None, 0.0))
        if dense is not None or answer is not None:
            starts = self.rng.uniform(self.judge.low, self.judge.high, (DRAKE_STARTS, len(q)))
            first, all_ = self.drake.best(q, held, starts, passes, distance)
        sides = {"ours": (answer.witness if answer else None, seconds), "dense": (dense, None), "drake": first, "drake_starts": all_}
        for side, (witness, took) in sides.items():
            good = witness is not None and passes(witness)
            row[side] = {"depth": distance(witness) if good else None, "seconds": took, "refused": witness is not None and not good}
        if row["ours"]["depth"] is not None:
            shift, turn = self.kinematics.errors(answer.witness[None], held)
            row["off"] = [float(shift.max()) if held[0].position else 0.0, float(turn.max()) if held[0].rotation else 0.0]
            row["bound_holds"] = answer.lower_bound <= row["ours"]["depth"] * (1 + 1e-9)
        return row

    def run(self, count):
        """Yields what each query found, until `count` of them have a known free configuration."""
        asked, known = 0, 0
        for q in self.queries():
            held, keep = self.held(np.asarray(q))
            if self.is_hopeless(q, held):
                continue
            found = self.one(np.asarray(q), held, keep)
            yield found
            asked, known = asked + 1, known + (best(found) is not None)
            if known == count or asked == MOST_DRAWS * count:
                return


SIDES = ("ours", "dense", "drake", "drake_starts")


def best(row):
    return min((row[side]["depth"] for side in SIDES if row[side]["depth"] is not None), default=None)


def summary(row, rows):
    _, robot, what = row
    known = [row for row in rows if best(row) is not None]
    none = [row for row in rows if best(row) is None]
    share = lambda side, factor: np.mean([row[side]["depth"] is not None and row[side]["depth"] <= factor * best(row) for row in known])
    times = lambda some, side: np.array([row[side]["seconds"] / row["plain_seconds"] for row in some])
    middle = lambda some: number(np.median(some)) if len(some) else ""
    off = np.max([row["off"] for row in known if "off" in row], axis=0)
    ours = times(known, "ours")
    assert all(row.get("bound_holds", True) for row in rows)
    return [robot, what, f"{len(known)} of {len(rows)}"] + [
        number(share("ours", np.inf)), number(share("ours", 1.05)), sum(row["ours"]["refused"] for row in rows), f"{off[0]:.0e}", f"{off[1]:.0e}",
        middle(ours), number(np.quantile(ours, 0.95)), middle(times(none, "ours")), number(share("dense", 1.05)),
    ] + [cell for side in SIDES[2:] for cell in (number(share(side, np.inf)), number(share(side, 1.05)), middle(times(known, side)))]


HEAD = ["scene", "held", "queries with one known", "found", "within 5 %", "refused by the judge", "off at most [m]", "[rad]", "time over a plain query's", "95 %",
        "if none is known", "dense search within 5 %", "Drake found", "within 5 %", "time", f"with {DRAKE_STARTS} more starts", "within 5 %", "time"]


def tables(lines):
    """Returns the table of ours, and that of the dense search and Drake."""
    parts = slice(0, 11), (0, 1, *range(11, len(HEAD)))
    pick = lambda line, part: line[part] if isinstance(part, slice) else [line[k] for k in part]
    return "\n\n".join(table(pick(HEAD, part), [pick(line, part) for line in lines]) for part in parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=300, help="queries of a row with a known free configuration")
    parser.add_argument("--only", metavar="NAME", default="", help="rows whose names begin so")
    parser.add_argument("--write", action="store_true", help="only write the page, from the last figures of every row")
    options = parser.parse_args()
    files = {name: scenes.BUILD / f"held-{name}.json" for name, *_ in ROWS}
    for row in ROWS if not options.write else ():
        if row[0].startswith(options.only):
            # Rows are written one by one, so that a run that is ended leaves what it has.
            found = []
            for one in Row(*row).run(options.count):
                found.append(one)
                part = files[row[0]].with_suffix(".part")
                part.write_text(json.dumps(found))
                part.replace(files[row[0]])
            print(summary(row, found), flush=True)
    if options.write or not options.only:
        measured = [(row, json.loads(files[row[0]].read_text())) for row in ROWS if files[row[0]].exists()]
        lines = [summary(row, found) for row, found in measured if any(best(one) is not None for one in found)]
        put(PAGE, "bench/held.py", f"Machine: {machine()}, shared and noisy; one thread.\n\n{tables(lines)}", "Queries, measured")


if __name__ == "__main__":
    main()
