#!/usr/bin/env python3
"""Signed distances: whether proved balls are free, how often a distance misses something nearer, and what it costs.

    target/peers/bin/python bench/distances.py [--scenes planar-arm ...] [--samples 100000] [--pairs 100000] [--rays 100000] [--write]

Needs the wheels of extricate, pin and coal (bench/requirements.txt). Scenes are built-in ones with the joint metric. The page is docs/benchmarks/proof.md.

- balls: samples within the free radius of free configurations, half of them at its end, judged by pinocchio's kinematics and coal's collision tests alone.
  It has to see contact a fiftieth beyond each witness, or it sees nothing.
- pairs: |d(p) - d(q)| is at most |p - q|. Configurations lie in clusters, at 0.001 to 1 rad from a centre; all pairs of a cluster are compared.
- rays: in random directions from a free configuration, each checked at 0.95 of the distance and at a random share of that.
- cost: processor time of a distance of a free configuration, and of a query of a colliding one, on one thread, in turn.
"""
import argparse
import sys
import time
from pathlib import Path

import numpy as np
import pinocchio as pin

import extricate
from page import number, put, table

sys.path.append(str(Path(__file__).resolve().parent / "applications"))
import coal_judge  # noqa: E402

PAGE = Path(__file__).resolve().parent.parent / "docs" / "benchmarks" / "proof.md"
SCENES = ("planar-arm", "hand", "four-legs", "shelf-arm")
IN_BALL, CLUSTER, TIMED = 100, 21, 100
# A pair misses if it is wrong by more than this [rad]; a ray if it is nearer by more than this share.
WRONG, NEARER = 1e-4, 0.05


def difference(scene, a, b):
    """Returns b - a, the short way around for continuous joints."""
    around = np.repeat([joint.kind == "continuous" for joint in scene.joints], [joint.stop - joint.start for joint in scene.joints])
    return np.where(around, (b - a + np.pi) % (2 * np.pi) - np.pi, b - a)


def moved(scene, q, step):
    """Returns q + step within the limits, continuous joints wrapped."""
    around = np.repeat([joint.kind == "continuous" for joint in scene.joints], [joint.stop - joint.start for joint in scene.joints])
    return np.where(around, (q + step + np.pi) % (2 * np.pi) - np.pi, np.clip(q + step, scene.lower, scene.upper))


def directions(rng, shape):
    step = rng.normal(size=shape)
    return step / np.linalg.norm(step, axis=-1, keepdims=True)


def judge_of(name, scene):
    """Returns a function that counts the configurations in which a pair is nearer than a share of the clearance, by pinocchio and coal."""
    judge = coal_judge.of_builtin(name, scene)

    def colliding(Q, share):
        for request in judge.geometry_data.collisionRequests:
            request.security_margin, request.enable_contact = share * scene.clearance, False
        return sum(pin.computeCollisions(judge.model, judge.data, judge.geometry, judge.geometry_data, judge.full(q), True) for q in Q)

    return colliding


def balls(name, scene, count, rng):
    """Returns how many samples within proved balls collide, how many there are, and the share of witnesses beyond which something collides."""
    colliding = judge_of(name, scene)
    q = scene.sample(max(1, count // IN_BALL), seed=1, colliding=False)
    radii, witness = scene.free_radius(q), scene.signed_distance(q)["witness"]
    ends = rng.random((len(q), IN_BALL)) ** (1 / scene.nq)
    ends[:, ::2] = 1 - 1e-9
    steps = directions(rng, (len(q), IN_BALL, scene.nq)) * ends[..., None]
    within = moved(scene, q[:, None], steps * radii[:, None, None]).reshape(-1, scene.nq)
    known = np.isfinite(witness).all(axis=1)
    beyond = moved(scene, q[known], 1.02 * difference(scene, q[known], witness[known]))
    # The other half is more than coal's tolerances.
    return colliding(within, 0.5), len(within), colliding(beyond, 1.0) / len(beyond)


def pairs(scene, count, rng):
    """Returns distances (n,), and the indices of pairs with how far apart they are."""
    clusters = max(1, count // (CLUSTER * (CLUSTER - 1) // 2))
    centers = scene.sample(clusters, seed=2)
    steps = directions(rng, (clusters, CLUSTER, scene.nq)) * 10 ** rng.uniform(-3, 0, (clusters, CLUSTER, 1))
    q = moved(scene, centers[:, None], steps)
    first, second = np.triu_indices(CLUSTER, 1)
    apart = np.linalg.norm(difference(scene, q[:, first], q[:, second]), axis=-1)
    return q.reshape(-1, scene.nq), (first, second), apart


def wrong_pairs(scene, count, rng):
    """Yields for each kind of pair and each gap of the query: kind, gap, pairs, misses, and how much the misses are wrong by."""
    q, (first, second), apart = pairs(scene, count, rng)
    free = scene.check(q)
    distance = scene.signed_distance(q)["distance"]
    shut = distance.copy()
    shut[~free] = extricate.Solver(scene, gap=0.0).signed_distance(q[~free])["distance"]
    free = free.reshape(-1, CLUSTER)
    kinds = {"free, free": free[:, first] & free[:, second], "both collide": ~free[:, first] & ~free[:, second]}
    kinds["one collides"] = ~(kinds["free, free"] | kinds["both collide"])
    for gap, d in (("default", distance), ("0", shut)):
        a, b = d.reshape(-1, CLUSTER)[:, first], d.reshape(-1, CLUSTER)[:, second]
        for kind, is_kind in kinds.items():
            if gap == "default" or kind != "free, free":
                known = is_kind & np.isfinite(a) & np.isfinite(b)
                excess = (np.abs(a - b) - apart)[known]
                share = (excess / np.maximum(np.abs(a), np.abs(b))[known])[excess > WRONG]
                yield kind, gap, known.sum(), len(share), share


def missed_by_rays(scene, count, configurations, rng):
    """Returns of how many configurations a ray meets something nearer by more than `NEARER`, of how many, and the nearest share of any."""
    q = scene.sample(configurations, seed=3, colliding=False)
    rows = scene.signed_distance(q)
    q, distance = q[np.isfinite(rows["distance"])], rows["distance"][np.isfinite(rows["distance"])]
    found, least = 0, 1.0
    for p, d in zip(q, distance):
        nearest = 1.0
        for begin in range(0, count, 10_000):
            step = directions(rng, (min(10_000, count - begin), scene.nq)) * d * (1 - NEARER)
            shares = np.concatenate([np.ones(len(step)), rng.random(len(step))])
            there = moved(scene, p, np.concatenate([step, step]) * shares[:, None])
            hit = there[~scene.check(there)]
            if len(hit):
                nearest = min(nearest, np.linalg.norm(difference(scene, p, hit), axis=1).min() / d)
        found, least = found + (nearest < 1), min(least, nearest)
    return found, len(q), least


def cost(scene):
    """Returns the median processor times [s] of a distance of a free configuration and of a query."""
    free, hit = (scene.sample(TIMED, seed=4, colliding=colliding) for colliding in (False, True))
    times = {scene.signed_distance: [], scene.query_batch: []}
    for pair in zip(free, hit):
        for (call, taken), q in zip(times.items(), pair):
            began = time.process_time()
            call(q[None], threads=1)
            taken.append(time.process_time() - began)
    return [float(np.median(taken)) for taken in times.values()]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", default=SCENES, choices=SCENES)
    parser.add_argument("--samples", type=int, default=100_000, help="within proved balls, a scene")
    parser.add_argument("--pairs", type=int, default=100_000, help="a scene")
    parser.add_argument("--rays", type=int, default=100_000, help="a configuration")
    parser.add_argument("--configurations", type=int, default=50, help="from which rays are sent, a scene")
    parser.add_argument("--write", action="store_true", help="write the page")
    options = parser.parse_args()
    proved, compared, wrong = [], [], 0
    for name in options.scenes:
        scene, rng = extricate.Scene.builtin(name), np.random.default_rng(5)
        outside, inside = cost(scene)
        for kind, gap, all_pairs, misses, share in wrong_pairs(scene, options.pairs, rng):
            middle, most = (f"{np.median(share):.1%}", f"{share.max():.1%}") if misses else ("", "")
            compared.append([name, kind, gap, f"{all_pairs:,}", f"{misses / max(1, all_pairs):.3%}", middle, most])
            print(*compared[-1], sep=" | ", flush=True)
        hits, samples, beyond = balls(name, scene, options.samples, rng)
        wrong += hits
        print(f"{name}: {hits} of {samples} samples in proved balls collide", flush=True)
        found, configurations, least = missed_by_rays(scene, options.rays, options.configurations, rng)
        proved.append([name, scene.nq, f"{hits} of {samples:,}", f"{beyond:.2f}", f"{found} of {configurations}", f"{least:.2f}", number(1e3 * outside), f"{outside / inside:.1f}"])
        print(*proved[-1], sep=" | ", flush=True)
    head = ["scene", "joints", "contacts in proved balls", "contacts beyond the witness", "nearer by 5 % by rays", "nearest over distance", "ms", "cost over a query's"]
    text = table(head, proved) + "\n\n" + table(["scene", "pair", "gap of the query", "pairs", "missed", "by, median", "by, at most"], compared)
    print(text)
    if options.write:
        put(PAGE, "bench/distances.py", text, "Proved bounds")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
