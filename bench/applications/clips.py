"""Clips of the humanoid, repaired frame by frame, judged by pinocchio and coal; beside queries of each frame alone."""
import time

import numpy as np

import coal_judge
import humanoid
from page import number, table

ROWS = 600
CHECKS_A_ROW = 100
# The share of each joint's range that a clip takes, and the step allowed over the clip's largest.
SHARES = (0.2, 0.5)
STEP = 1.5
# Clips with fewer colliding frames are left out.
COLLIDING = 0.1


def idle_joints(scene, judge, clip):
    """Returns a mask of the joints on which no pair depends that collides in a clip."""
    hit = np.zeros(len(judge.of), bool)
    for q in clip:
        hit |= judge.distances(q) < judge.clearance
    moves = (judge.reach[hit] > 0).any(axis=0)
    return np.array([not moves[judge.model.getJointId(joint.name)] for joint in scene.joints])


def one(scene, judge, clip, seed):
    steps = np.linalg.norm(np.diff(clip, axis=0), axis=1)
    allowed = STEP * steps.max()
    began = time.process_time()
    found = scene.repair(clip, frames=True, max_step=allowed, seed=seed, max_checks=CHECKS_A_ROW * len(clip))
    seconds = time.process_time() - began
    alone = scene.query_batch(clip, threads=1)
    before = sum(judge.worst(q) < 0 for q in clip)
    jump = np.linalg.norm(np.diff(alone["witness"], axis=0), axis=1).max() / allowed
    told = {"found": found.points is not None, "before": before, "depth": alone["depth"].mean(), "jump": jump, "checks": found.checks / len(clip), "ms": 1e3 * seconds / len(clip)}
    if found.points is None:
        return told
    off, idle = found.points - clip, idle_joints(scene, judge, clip[::5])
    away = np.linalg.norm(off, axis=1)
    return told | {
        "rows": len(found.points),
        "after": sum(judge.worst(q) < 0 for q in found.points),
        "edges": sum(judge.edge(a, b)[0] is not None for a, b in zip(found.points, found.points[1:])),
        "step": np.linalg.norm(np.diff(found.points, axis=0), axis=1).max() / allowed,
        "same": (away == 0).mean(),
        "away": away.mean(),
        "most": away.max(),
        "idle": np.linalg.norm(off[:, idle], axis=1).mean(),
    }


def clips(options):
    """Repairs clips in which at least a tenth of the frames collide."""
    count = options.count or (2 if options.quick else 10)
    scene = humanoid.scene()
    judge = coal_judge.of_humanoid(scene)
    rows = []
    for share in SHARES:
        told, seed = [], 0
        while len(told) < count:
            clip = humanoid.clip(scene, ROWS, share, seed)
            if (~scene.check(clip, threads=1)).mean() >= COLLIDING:
                told.append(one(scene, judge, clip, seed))
                print(share, seed, {key: number(value) for key, value in told[-1].items()}, flush=True)
            seed += 1
        good = [t for t in told if t["found"]]

        def column(key, how=np.mean):
            return number(float(how([t[key] for t in good])))

        whole = sum(t["rows"] == ROWS for t in good)
        faults = f"{sum(t['after'] for t in good)}, {sum(t['edges'] for t in good)}"
        rows.append([share, count, len(good), whole, number(float(np.mean([t["before"] / ROWS for t in told]))), faults, column("step", max), column("jump", max)])
        rows[-1] += [column("same"), column("depth"), column("away"), column("idle"), column("most", max), column("checks"), column("ms")]
    head = ["share of the joints' ranges", "clips", "repaired", "all 600 frames", "frames that collide", "rows, edges that collide after", "largest step over `max_step`", "of frames alone"]
    head += ["frames unchanged", "depth, mean", "deviation, mean", "in joints of no collision", "largest", "checks a frame", "processor ms a frame"]
    return table(head, rows)
