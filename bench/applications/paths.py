"""Plans and repairs beside OMPL."""
import time

import numpy as np

import extricate
import peers
import passages
from page import number, table

OPEN = ("planar-arm", "shelf-arm", "dual-arm", "hand")
# Of our proofs [m]: parts of metres pass each other with decimetres of play, links of arms with centimetres.
RESOLUTION = 1e-3


def narrow(options):
    """Passages that trees do not find: what share is solved, and with how many checks."""
    seeds = options.count or (2 if options.quick else 20)
    rows = []
    for name in options.scenes or passages.SCENES:
        scene, start, goal = passages.SCENES[name]()
        start, goal = np.array(start, float), np.array(goal, float)
        for side in options.planners:
            solved, checks, wrong, began = 0, [], 0, time.process_time()
            for seed in range(seeds):
                if side == "ours":
                    plan = scene.plan(start, goal, seed=seed, max_checks=int(options.checks), resolution=RESOLUTION)
                    path, spent = plan.points, plan.checks
                else:
                    path, spent = peers.plan(scene, start, goal, side, options.checks, 3600, seed)
                proved = path is not None and peers.proved(scene, path)
                wrong += path is not None and not proved
                solved += proved
                checks.append(spent)
            seconds = (time.process_time() - began) / seeds
            rows.append([name, side, number(solved / seeds), number(np.median(checks)), wrong, number(seconds)])
            print(rows[-1], flush=True)
    return table(["scene", "planner", "solved", "checks, median", "paths not proved", "processor s a run"], rows)


def open_scenes(options):
    """Random free ends of built-in scenes."""
    count = options.count or (10 if options.quick else 100)
    rows = []
    for name in options.scenes or OPEN:
        scene = extricate.Scene.builtin(name)
        free = scene.sample(2 * count, seed=5, colliding=False)
        ours, theirs, solved, proved = [], [], [0, 0], 0
        for seed, (start, goal) in enumerate(zip(free[::2], free[1::2])):
            plan = scene.plan(start, goal, seed=seed, shortcut=False, max_checks=50_000, resolution=RESOLUTION)
            path, spent = peers.plan(scene, start, goal, "RRTConnect", 50_000, 600, seed)
            ours.append(plan.checks)
            theirs.append(spent)
            solved[0] += plan.points is not None
            solved[1] += path is not None
            proved += path is not None and peers.proved(scene, path)
        medians = [np.median(ours), np.median(theirs)]
        rows.append([name, *(number(s / count) for s in solved), number(proved / count), *map(number, medians), number(medians[0] / medians[1])])
        print(rows[-1], flush=True)
    return table(["scene", "ours solved and proved", "OMPL solved", "OMPL proved", "checks of ours, median", "of OMPL", "ratio"], rows)


def repaired(options):
    """Straight paths between free ends that collide."""
    count = options.count or (10 if options.quick else 200)
    rows = []
    for name in options.scenes or OPEN:
        scene = extricate.Scene.builtin(name)
        free = scene.sample(40 * count, seed=9, colliding=False)
        first, last = free[::2], free[1::2]
        hit = scene.check_segments(first, last)["contact"]
        found = []
        for seed, (start, goal) in enumerate(zip(first[hit][:count], last[hit][:count])):
            new = scene.repair(np.array([start, goal]), seed=seed)
            path, spent = peers.plan(scene, start, goal, "RRTConnect", 100_000, 600, seed)
            theirs = path is not None and peers.proved(scene, path)
            straight = np.linalg.norm(goal - start)
            far = off(path, start, goal) if theirs else np.nan
            found.append((new.points is not None, new.length / new.length_before if new.points is not None else np.nan, off(new.points, start, goal) if new.points is not None else np.nan, new.checks, theirs, np.linalg.norm(np.diff(path, axis=0), axis=1).sum() / straight if theirs else np.nan, far, spent))
        f = np.array(found, float)
        columns = [f[:, 0].mean(), np.nanmedian(f[:, 1]), np.nanpercentile(f[:, 2], 95), np.median(f[:, 3]), f[:, 4].mean(), np.nanmedian(f[:, 5]), np.nanpercentile(f[:, 6], 95), np.median(f[:, 7])]
        rows.append([name, len(f), *map(number, columns)])
        print(rows[-1], flush=True)
    return table(["scene", "paths", "ours proved", "length over straight, median", "deviation, 95 %", "checks, median", "OMPL proved", "length", "deviation, 95 %", "checks"], rows)


def off(path, start, goal):
    """Largest distance of a path's edges from the straight segment between its ends (intervals)."""
    points = np.concatenate([np.linspace(a, b, 20) for a, b in zip(path[:-1], path[1:])])
    axis = goal - start
    share = np.clip((points - start) @ axis / (axis @ axis), 0, 1)
    return float(np.linalg.norm(points - start - share[:, None] * axis, axis=1).max())
