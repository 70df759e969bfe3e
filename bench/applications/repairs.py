"""Repairs beside OMPL: straight paths that collide, and planned paths after an obstacle moved."""
import numpy as np

import extricate
import peers
from escapes import SCENES, along
from page import number, table

CHECKS = 100_000
# Positions of the ball that are tried for one path.
DRAWS = 200
# Radius around the middle within which the robot of a scene moves [m].
SIZES = {"planar-arm": 1.2, "shelf-arm": 0.9, "free-box": 0.8, "dual-arm": 1.0, "hand": 0.15, "four-legs": 0.7}


def straight(scene, count):
    """Makes straight paths between free ends that collide: (scene, rows)."""
    free = scene.sample(40 * count, seed=9, colliding=False)
    first, last = free[::2], free[1::2]
    hit = scene.check_segments(first, last)["contact"]
    return [(scene, np.array(ends)) for ends in list(zip(first[hit], last[hit]))[:count]]


def moved(scene, size, count):
    """Makes planned paths into which a ball of a twentieth to a tenth of the scene's size has moved; their ends stay free."""
    rng = np.random.default_rng(4)
    free = iter(scene.sample(20 * count, seed=3, colliding=False))
    found = []
    for seed, (start, goal) in enumerate(zip(free, free)):
        plan = scene.plan(start, goal, seed=seed, max_checks=CHECKS)
        if plan.points is None:
            continue
        for _ in range(DRAWS):
            ball = extricate.Sphere(size * rng.uniform(0.05, 0.1), list(size * rng.uniform(-1, 1, 3)), name="moved")
            world = scene.with_obstacles([ball])
            ends_are_free = world.check(plan.points[[0, -1]], threads=1).all()
            if ends_are_free and not world.check_segments(plan.points[:-1], plan.points[1:], threads=1)["free"].all():
                found.append((world, plan.points))
                break
        if len(found) == count:
            break
    return found


def one(scene, old, seed):
    """Returns (proved, length, deviation, checks) of ours and of OMPL's RRTConnect and simplifier; lengths are relative to the old path."""
    new = scene.repair(old, seed=seed, max_checks=CHECKS)
    path, spent = peers.plan(scene, old[0], old[-1], "RRTConnect", CHECKS, 600, seed, simplify=True)
    sides = []
    for points, checks in ((new.points, new.checks), (path, spent)):
        if points is None or not peers.proved(scene, points):
            sides += [False, np.nan, np.nan, checks]
        else:
            sides += [True, length(scene, points) / length(scene, old), deviation(scene, points, old), checks]
    return sides


def apart(scene, a, b):
    """Returns distances of configurations in coordinates: angles the short way, quaternions of either sign."""
    step = np.asarray(b) - np.asarray(a)
    for joint in scene.joints:
        at = joint.stop - 1
        if joint.kind == "continuous" or (joint.kind == "planar" and joint.stop - joint.start == 3):
            step[..., at] = (step[..., at] + np.pi) % (2 * np.pi) - np.pi
        if joint.kind in ("floating", "spherical"):
            turn = slice(joint.stop - 4, joint.stop)
            other = np.asarray(b)[..., turn] + np.asarray(a)[..., turn]
            is_other = np.linalg.norm(other, axis=-1) < np.linalg.norm(step[..., turn], axis=-1)
            step[..., turn] = np.where(is_other[..., None], other, step[..., turn])
    return np.linalg.norm(step, axis=-1)


def length(scene, points):
    return float(apart(scene, np.asarray(points)[:-1], np.asarray(points)[1:]).sum())


def deviation(scene, path, old):
    """Returns the largest distance of the path's configurations from the nearest one of the old path, in coordinates."""
    a, b = along(scene, np.asarray(path)), along(scene, np.asarray(old))
    return float(apart(scene, a[:, None], b[None]).min(axis=1).max())


def row(name, found):
    """Makes the row of results; comparisons use cases in which both sides have a path."""
    f = np.array(found, float)
    both = (f[:, 0] == 1) & (f[:, 4] == 1)
    where_theirs = f[f[:, 4] == 1, 0].mean() if (f[:, 4] == 1).any() else np.nan
    checks = np.median(f[:, 3]), np.median(f[:, 7])
    deviations = [np.percentile(f[both, k], 95) for k in (2, 6)]
    lengths = [np.median(f[both, k]) for k in (1, 5)]
    columns = [f[:, 0].mean(), f[:, 4].mean(), where_theirs, *lengths, *deviations, deviations[0] / deviations[1], *checks, checks[0] / checks[1]]
    return [name, len(f), *map(number, columns)]


def repaired(options):
    """Repairs straight paths that collide, and planned paths after an obstacle moved."""
    count = options.count or (10 if options.quick else 200)
    rows = []
    for name in options.scenes or SCENES:
        scene = extricate.Scene.builtin(name)
        for kind, paths in (("straight", straight(scene, count)), ("obstacle moved", moved(scene, SIZES[name], count))):
            found = [one(world, old, seed) for seed, (world, old) in enumerate(paths)]
            if found:
                rows.append(row(f"{name}, {kind}", found))
                print(rows[-1], flush=True)
    head = ["paths", "count", "ours proved", "OMPL proved", "ours where OMPL", "length, ours", "OMPL", "deviation 95 %, ours", "OMPL", "ratio", "checks, ours", "OMPL", "ratio"]
    return table(head, rows)
