"""Runs every method on the same queries and checks every witness again with pinocchio + coal."""
import time

import coal
import numpy as np

import scenes
from drake_ik import Drake
from multistart import MultiStart
from ours import METHODS, Ours
from pin_scene import PinScene
from programs import sample
from sampling import Jiggle, Nearby
from sides import machine

# Parts that the queries are split into; the methods run one after another on each.
TURNS = 4
# Share of the clearance that coal has to confirm: its distances near contact have errors beyond rounding.
TOLERATED = 0.9


def everything(options):
    named = [(name, path) for name, path in scenes.written().items() if not options.scenes or name in options.scenes]
    found = {"machine": machine(), "labels": options.labels, "quick": options.quick, "scenes": {}}
    for name, path in named:
        began = time.perf_counter()
        found["scenes"][name] = one_scene(name, path, options)
        print(f"{name}: {time.perf_counter() - began:.0f} s", flush=True)
    return found


def one_scene(name, path, options):
    scene = PinScene(path)
    meshes = any(isinstance(g.geometry, coal.BVHModelBase) for g in scene.geometry.geometryObjects)
    count = 2 * options.queries // 5 if meshes else options.queries
    queries = [np.array(q) for q in sample(path, count, 11)]
    ours, others, notes = Ours(name, path, options.labels), [Jiggle(scene, 1), Nearby(scene)], []
    try:
        others.append(Drake(scene))
    except ValueError as why:
        notes.append(f"Drake is left out: {why}.")
    multistart = MultiStart(scene, 1, options.starts)
    given = {}
    for part in np.array_split(np.arange(count), TURNS):
        if not len(part):
            continue
        asked = [queries[k] for k in part]
        for method in METHODS:
            given.setdefault(method, []).extend(ours.answers(method, asked))
        for other in others:
            given.setdefault(other.name, []).extend(other.solve(q) for q in asked)
        for q in asked:
            for starts, answer in multistart.solve(q).items():
                given.setdefault(f"pinocchio + coal, {starts} start{'s' * (starts > 1)}", []).append(answer)
    rows = {method: judged(scene, queries, answers) for method, answers in given.items()}
    best = np.min([row["depth"] for row in rows.values()], axis=0)
    figures = {method: summary(row, best) for method, row in rows.items()}
    # Bounds hold at the full clearance; a witness of a peer may keep 0.9 of it, and be nearer for that.
    own = np.min([rows[method]["depth"] for method in METHODS], axis=0)
    for method in METHODS:
        lower = np.array([a["lower_bound"] for a in given[method]])
        figures[method] |= {"bounds_above_best": int((lower > own * (1 + 1e-6)).sum()), "lower_over_best": float(np.median(lower / best))}
    for method, found in figures.items():
        shares = ", ".join(f"{what} {found[key]:.2f}" for what, key in [("verified", "verified"), ("within 5 %", "within_5"), ("within 1 %", "within_1")])
        print(f"  {method:<32} {shares}, {found['us']:,.0f} us", flush=True)
    about = {"queries": count, "joints": len(scene.joints), "pairs": len(scene.geometry.collisionPairs), "meshes": meshes}
    return about | {"learning": ours.learning, "notes": notes, "methods": figures}


def judged(scene, queries, answers):
    """Computes depths from the witnesses, infinite if there is none or it fails the check."""
    row = {"depth": np.full(len(queries), np.inf), "refused": 0, "missing": 0}
    for k, (q, answer) in enumerate(zip(queries, answers, strict=True)):
        if answer["witness"] is None:
            row["missing"] += 1
            continue
        witness = np.array(answer["witness"], float)
        depth = scene.distance(q, witness)
        stated = answer.get("depth", depth)
        if scene.inside(witness, 1e-6) and clear(scene, witness) and abs(stated - depth) <= 1e-6 + 1e-4 * depth:
            row["depth"][k] = depth
        else:
            row["refused"] += 1
    row["seconds"] = np.array([a["seconds"] for a in answers])
    row["checks"] = np.array([a.get("checks", np.nan) for a in answers], float)
    return row


def clear(scene, witness):
    """Whether coal finds every pair at [`TOLERATED`] of the clearance or more."""
    requests = scene.geometry_data.collisionRequests
    for request in requests:
        request.security_margin = TOLERATED * scene.clearance
    hit = scene.collides(scene.full(np.clip(witness, np.where(scene.circle, -np.inf, scene.low), np.where(scene.circle, np.inf, scene.high))))
    for request in requests:
        request.security_margin = scene.clearance
    return not hit


def summary(row, best):
    known = np.isfinite(best)
    ratio = np.full(len(best), np.inf)
    ratio[known] = row["depth"][known] / best[known]
    excess = lambda share: float(np.sort(ratio)[int(np.ceil(share * len(ratio))) - 1] - 1)
    checks = None if np.isnan(row["checks"]).any() else float(np.median(row["checks"]))
    return {
        "verified": float(np.isfinite(row["depth"]).mean()), "refused": row["refused"], "missing": row["missing"],
        "within_5": float((ratio < 1.05).mean()), "within_1": float((ratio < 1.01).mean()),
        "excess_median": excess(0.5), "excess_90": excess(0.9), "excess_95": excess(0.95),
        "us": 1e6 * float(np.median(row["seconds"])), "us_95": 1e6 * float(np.quantile(row["seconds"], 0.95)), "checks": checks,
    }


def failures(found):
    ours = [s["methods"][m] for s in found["scenes"].values() for m in METHODS]
    return sum(f["refused"] + f["missing"] + f["bounds_above_best"] for f in ours)
