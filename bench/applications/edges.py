"""Edges of all motions, judged by pinocchio and coal (coal_judge.py) on drawn and built-in scenes and on the humanoid."""
import warnings
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import coal_judge
import extricate
import humanoid
from drawn import draw
from page import number, table

BUILT_IN = ("planar-arm", "shelf-arm", "free-box", "dual-arm", "hand", "four-legs")
KINDS = ("plan", "plan of a roadmap", "plan out of collision", "escape", "repair", "repair of frames", "continuous stream", "refused")
# Checks of one motion, rows of a clip and of a stream, and motions of each kind a scene.
BUDGET = {"max_checks": 3000}
ROWS = 60
MOTIONS = 8
# coal takes milliseconds for two meshes, so scenes of meshes have fewer motions.
FEW = {"shelf-arm": 2, "dual-arm": 2}
TOLERANCE = 1e-3


def scene_of(source, seed):
    """Returns a scene and its judge, or None if nothing of it can move or is checked."""
    if source == "humanoid":
        scene = humanoid.scene()
        return scene, coal_judge.of_humanoid(scene)
    if source != "drawn":
        scene = extricate.Scene.builtin(source)
        return scene, coal_judge.of_builtin(source, scene)
    drawn = draw(seed)
    # coal's distance to a mesh has no sign, so contact without a clearance cannot be judged.
    drawn.clearance = drawn.clearance or 1e-3
    return coal_judge.of_drawn(drawn)


def motions(scene, judge, seed, count):
    """Yields (kind, call, from, to, what it has to keep) for each edge."""
    def path(kind, call, points, keep=None, free_from=0):
        """`keep` is that of the edges up to `free_from`; the others keep the clearance."""
        for k, (a, b) in enumerate(zip(points[:-1], points[1:])):
            yield kind, call, a, b, keep if k < free_from else None

    free, hit = (drawn_rows(scene, 2 * count, seed, colliding) for colliding in (False, True))
    for k, q in enumerate(hit[:count]):
        found = scene.escape(q, tolerance=TOLERANCE, tree_checks=1000, seed=k, **BUDGET)
        if found.points is not None:
            yield from path("escape", k, found.points, judge.keeps(q, TOLERANCE), found.free_from)
    if len(free) < 2 * count:
        return
    straight = scene.check_segments(free[:-1], free[1:], threads=1)
    for k in np.flatnonzero(straight["contact"])[:count]:
        yield "refused", int(k), free[k], free[k + 1], None
    roadmap = extricate.Roadmap(scene, seed=seed)
    for k in range(count):
        start, goal = free[2 * k], free[2 * k + 1]
        for kind, more in (("plan", {"shortcut": k % 2 == 0}), ("plan of a roadmap", {"roadmap": roadmap, "shortcut": k % 2 == 0})):
            found = scene.plan(start, goal, seed=k, threads=1, **more, **BUDGET)
            if found.points is not None:
                yield from path(kind, k, found.points)
        if k < len(hit):
            found = scene.plan(hit[k], goal, seed=k, threads=1, **BUDGET)
            if found.points is not None:
                yield from path("plan out of collision", k, found.points, judge.keeps(hit[k], TOLERANCE), found.free_from)
        found = scene.repair(free[k:k + 4], seed=k, max_checks=20_000)
        if found.points is not None:
            yield from path("repair", k, found.points)
    for k in range(count):
        # Half of them pass through a configuration in collision.
        ends = [free[k], (hit if k % 4 < 2 and k < len(hit) else free)[k], free[k + count]]
        rows = np.concatenate([coal_judge.between(scene, a, b, np.linspace(0, 1, ROWS // 2)) for a, b in zip(ends, ends[1:])])
        if k % 2:
            found = scene.repair(rows, frames=True, seed=k, max_checks=100 * ROWS)
            if found.points is not None:
                yield from path("repair of frames", k, found.points)
        else:
            stream = scene.stream(continuous=True)
            answers = [stream.query(q) for q in rows]
            yield from path("continuous stream", k, [a.witness for a in answers if a is not None])


def drawn_rows(scene, count, seed, colliding):
    try:
        return scene.sample(count, seed=seed, colliding=colliding, threads=1)
    except (RuntimeError, ValueError):
        # A drawn scene may never be free, or always.
        return np.empty((0, scene.nq))


def one(job):
    """Judges the edges of one scene; returns counts, samples and faults by kind."""
    source, seed = job
    warnings.simplefilter("ignore")
    found = scene_of(source, seed)
    counts = {kind: [0, 0, 0, 0] for kind in KINDS}
    faults = []
    if found is None:
        return counts, faults
    scene, judge = found
    for kind, call, a, b, keep in motions(scene, judge, seed, FEW.get(source, MOTIONS)):
        fault, samples = judge.edge(a, b, keep)
        moved = not np.array_equal(a, b)
        for k, more in enumerate((1, moved, samples, fault is not None)):
            counts[kind][k] += more
        if fault and kind != "refused":
            faults.append({"scene": source, "seed": seed, "kind": kind, "call": call, "from": np.asarray(a).tolist(), "to": np.asarray(b).tolist(), "fault": fault})
    return counts, faults


def judged(options):
    """Counts edges by kind, and those that the judge finds nearer than the clearance, or deeper than at the start of an escape."""
    scenes = options.count or (8 if options.quick else 180)
    jobs = [(name, seed) for seed in range(1 if options.quick else 2) for name in (*BUILT_IN, "humanoid")]
    jobs += [("drawn", seed) for seed in range(scenes)]
    jobs = [job for job in jobs if not options.scenes or job[0] in options.scenes]
    total = {kind: np.zeros(4, int) for kind in KINDS}
    with ProcessPoolExecutor(2) as pool:
        for done, (counts, faults) in enumerate(pool.map(one, jobs), 1):
            for kind, row in counts.items():
                total[kind] += row
            for fault in faults:
                print(fault, flush=True)
            if done % 10 == 0:
                print(f"{done} of {len(jobs)} scenes, {sum(row[0] for row in total.values()):,} edges", flush=True)
    rows = [[kind, *(f"{x:,}" for x in row)] for kind, row in total.items() if kind != "refused"]
    proved = sum(row for kind, row in total.items() if kind != "refused")
    rows += [["all", *(f"{x:,}" for x in proved)], ["straight edges that are refused", *(f"{x:,}" for x in total["refused"])]]
    print(number(proved[2] / max(1, proved[0])), "samples an edge")
    return table(["edges of", "edges", "that move", "samples", "the judge finds a collision"], rows)
