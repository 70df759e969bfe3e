"""Escapes beside straight segments, each judged by samples of its own: 200 configurations along it."""
import numpy as np

import extricate
import humanoid
from page import number
from page import table as rows_of

SCENES = ("planar-arm", "shelf-arm", "free-box", "dual-arm", "hand", "four-legs")
SAMPLES = 200


def along(scene, points):
    """Samples configurations along a path, on the geodesics between its points."""
    share = np.linspace(0, 1, max(2, SAMPLES // max(1, len(points) - 1)))
    return np.concatenate([between(scene, a, b, share) for a, b in zip(points[:-1], points[1:])])


def between(scene, a, b, shares):
    """Interpolates along the geodesic of intervals, circles and rotations."""
    out = a + (b - a) * shares[:, None]
    for joint in scene.joints:
        q = slice(joint.start, joint.stop)
        if joint.kind == "continuous" or (joint.kind == "planar" and joint.stop - joint.start == 3):
            at = joint.stop - 1
            turn = (b[at] - a[at] + np.pi) % (2 * np.pi) - np.pi
            out[:, at] = (a[at] + turn * shares + np.pi) % (2 * np.pi) - np.pi
        if joint.kind in ("floating", "spherical"):
            r = slice(joint.stop - 4, joint.stop)
            p, s = a[r], b[r] * (1 if a[r] @ b[r] >= 0 else -1)
            angle = np.arccos(min(1.0, float(p @ s)))
            if angle > 1e-9:
                out[:, r] = (np.sin((1 - shares) * angle)[:, None] * p + np.sin(shares * angle)[:, None] * s) / np.sin(angle)
            out[:, r] /= np.linalg.norm(out[:, r], axis=1, keepdims=True)
        del q
    return np.clip(out, scene.lower, scene.upper)


def is_clean(scene, points, tolerance=1e-3):
    """Whether nothing gets worse: no new pair collides, none gets deeper, and a free path stays free."""
    way = along(scene, np.asarray(points))
    distances = scene.pair_distances(way)
    at_start = distances[0]
    keeps = np.where(at_start < scene.clearance, at_start - tolerance, scene.clearance)
    free = scene.check(way, threads=1)
    if not free[-1] or (distances < keeps - 1e-9).any():
        return False
    return bool(free[np.argmax(free):].all())


def one(scene, q):
    nearest, six = scene.query(q), scene.query(q, exits=6)
    ours = scene.escape(q)
    long = ours if ours.points is not None else scene.escape(q, exits=40, seed=1, tolerance=1e-3, tree_checks=200_000)
    return {
        "nearest": is_clean(scene, [q, nearest.witness]),
        "six": any(is_clean(scene, [q, exit.witness]) for exit in six.exits),
        "ours": ours.points is not None,
        "wrong": ours.points is not None and not is_clean(scene, ours.points),
        "known": long.points is not None,
        "method": ours.method,
        "query": nearest.checks,
        "checks": ours.checks,
    }


def table(options):
    count = options.count or (20 if options.quick else 500)
    rows = []
    for name in options.scenes or (*SCENES, "humanoid"):
        scene = humanoid.scene() if name == "humanoid" else extricate.Scene.builtin(name)
        found = [one(scene, q) for q in scene.sample(count, seed=11, colliding=True)]
        known = sum(f["known"] or f["nearest"] or f["six"] for f in found)
        share = [number(sum(f[key] for f in found) / max(known, 1)) for key in ("nearest", "six", "ours")]
        methods = ", ".join(f"{m} {sum(f['method'] == m for f in found)}" for m in ("nearest", "exit", "pushed", "grown"))
        checks, query = np.median([f["checks"] for f in found]), np.median([f["query"] for f in found])
        failures = [f["checks"] for f in found if not f["ours"]]
        failed = number(np.median(failures)) if failures else ""
        rows.append([name, count, known, *share, sum(f["wrong"] for f in found), methods, number(query), number(checks), number(checks / query), failed])
        print(rows[-1], flush=True)
    head = ["scene", "starts", "known", "straight to the nearest", "a straight one of six", "escape", "judged wrong", "found by", "checks of a query", "of an escape", "ratio", "of one that fails"]
    return rows_of(head, rows)
