"""Plans beside OMPL."""
import time

import numpy as np

import extricate
import peers
import passages
from page import number, table
from repairs import length

OPEN = ("planar-arm", "shelf-arm", "dual-arm", "hand")
# Resolution of our proofs [m], small against the play: decimetres for parts of metres, centimetres for links of arms.
RESOLUTION = 1e-3


def narrow(options):
    """Plans through passages that trees do not find: the share solved, and the checks."""
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
    """Plans between random free ends in built-in scenes; lengths are those of shortened paths, in coordinates."""
    count = options.count or (10 if options.quick else 100)
    rows = []
    for name in options.scenes or OPEN:
        scene = extricate.Scene.builtin(name)
        free = scene.sample(2 * count, seed=5, colliding=False)
        ours, theirs, solved, proved, lengths = [], [], [0, 0], 0, []
        for seed, (start, goal) in enumerate(zip(free[::2], free[1::2])):
            plan = scene.plan(start, goal, seed=seed, shortcut=False, max_checks=50_000, resolution=RESOLUTION)
            path, spent = peers.plan(scene, start, goal, "RRTConnect", 50_000, 600, seed)
            ours.append(plan.checks)
            theirs.append(spent)
            solved[0] += plan.points is not None
            solved[1] += path is not None
            proved += path is not None and peers.proved(scene, path)
            short = scene.plan(start, goal, seed=seed, max_checks=50_000, resolution=RESOLUTION).points
            shorter, _ = peers.plan(scene, start, goal, "RRTConnect", 50_000, 600, seed, simplify=True)
            if short is not None and shorter is not None:
                lengths.append(length(scene, short) / length(scene, shorter))
        medians = [np.median(ours), np.median(theirs)]
        rows.append([name, *(number(s / count) for s in solved), number(proved / count), *map(number, medians), number(medians[0] / medians[1]), number(np.median(lengths)), number(max(lengths))])
        print(rows[-1], flush=True)
    return table(["scene", "ours solved and proved", "OMPL solved", "OMPL proved", "checks of ours, median", "of OMPL", "ratio", "length over OMPL's, median", "largest"], rows)
