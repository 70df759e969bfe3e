"""Tools held: queries with `keep`, beside many other starts for the same pose."""
import time

import numpy as np

import extricate
from page import number
from page import table as rows_of

# Scene, held link, and what of it is held.
HELD = (
    ("shelf-arm", "link_7", {}),
    ("shelf-arm", "link_7", {"rotation": None}),
    ("shelf-arm", "link_7", {"axis": [0, 0, 1]}),
    ("planar-arm", "link_3", {"rotation": None}),
)
OTHER_STARTS = 60


def best_known(scene, q, keep, pose, rng):
    """The nearest of the free configurations that queries from elsewhere find for the same pose, and of an exhaustive query."""
    answer = scene.query(q, keep=keep, effort="exhaustive")
    starts = rng.uniform(scene.lower, scene.upper, (OTHER_STARTS, scene.nq))
    found = scene.query_batch(starts, keep={**keep, "pose": pose}, effort="quick")
    distances = np.linalg.norm(found["witness"] - q, axis=1)
    return min(np.nanmin(distances, initial=np.inf), answer.depth if answer else np.inf)


def table(options):
    count = options.count or (15 if options.quick else 150)
    rows = []
    for name, link, held in HELD:
        scene, rng = extricate.Scene.builtin(name), np.random.default_rng(4)
        keep = {"link": link, **held}
        asked, found, near, off, checks, ratios, plain = 0, 0, 0, [0.0, 0.0], [], [], []
        for q in scene.sample(20 * count, seed=9, colliding=True):
            if asked == count:
                break
            best = best_known(scene, q, keep, scene.poses(q, of=[link])[0], rng)
            if not np.isfinite(best):
                continue
            asked += 1
            begun = time.perf_counter()
            plain.append(scene.query(q).checks)
            between = time.perf_counter()
            answer = scene.query(q, keep=keep)
            ratios.append((time.perf_counter() - between) / (between - begun))
            if answer is None:
                continue
            assert scene.check(answer.witness) and answer.lower_bound <= answer.depth
            found += 1
            near += answer.depth <= 1.05 * min(best, answer.depth)
            off = np.maximum(off, [0 if each is None else value for each, value in zip((1, held.get("rotation", 1)), answer.kept[0])])
            checks.append(answer.checks)
        what = "position" if "rotation" in held else "position and axis" if "axis" in held else "pose"
        rows.append([name, what, asked, number(found / asked), number(near / asked), f"{off[0]:.1e}", f"{off[1]:.1e}", number(np.median(checks)), number(np.median(checks) / np.median(plain)), number(np.median(ratios)), number(np.quantile(ratios, 0.95))])
        print(rows[-1], flush=True)
    head = ["scene", "held", "queries", "found", "within 5 %", "off at most [m]", "[rad]", "checks", "as multiple of a query's", "time as its multiple", "95 %"]
    return rows_of(head, rows)
