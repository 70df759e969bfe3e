"""Grasps held in MuJoCo for a second under gravity in six directions: good ones, squeezed ones, and squeezed ones released.

    target/peers/bin/pip install mujoco                          # besides what bench/grasps.py needs
    target/peers/bin/python bench/grasps_held.py                 # the Allegro hand, seven convex objects, 20 grasps each
    target/peers/bin/python bench/grasps_held.py --grasps 5 --objects ball

Good and squeezed grasps are those of bench/grasps.py. MuJoCo takes hulls of meshes, so the objects are the convex ones: geometry
is the same on both sides. A good grasp is one with force closure, epsilon at least 0.02. The hand presses by 10 N in all, by forces
at the contacts of the state that balance each other as well as friction allows; each joint is held by a position actuator, whose
target is the state and what these forces ask for. Links have no weight. The object, of 100 g, is free; it is held in one direction
where it has moved by less than 5 cm after a second.
Writes target/bench/grasps-held.json and a table of docs/benchmarks/grasps.md (`--write` only the latter)."""
import argparse
import json
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
from scipy.optimize import nnls

from grasps import BUILD, CLEARANCE, HANDS, ROOT, SQUEEZES, TOUCH, Trial, objects
from page import put, table

CONVEX = ("ball", "small-ball", "cylinder", "rod", "box", "capsule", "egg")
DIRECTIONS = np.concatenate([np.eye(3), -np.eye(3)])
PRESS, GAIN, STRONGEST, DAMPING, ARMATURE = 10.0, 3.0, 0.7, 0.2, 1e-3
MASS, FRICTION, STEP = 0.1, 0.8, 1e-3
FAR, EVEN, EPSILON = 0.05, 0.1, 0.02
# Result if nothing was released, which counts as not held.
LOST = {"held": [False] * len(DIRECTIONS), "fastest": np.nan, "deepest": np.nan}
STATES = ("good", "squeezed", "released")


def simulation(hand, shape, robots):
    """Makes the hand, fixed at its palm, and the free object. Hand and object collide, links of the hand do not."""
    robot = ET.parse(hand.file(BUILD, robots)).getroot()
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    spec = mujoco.MjSpec.from_string(ET.tostring(robot, encoding="unicode"))
    spec.compiler.balanceinertia = True  # Some links have impossible inertias.
    spec.option.timestep, spec.option.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone, spec.option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10
    for geom in spec.geoms:
        geom.contype, geom.conaffinity, geom.friction[0] = 1, 2, FRICTION
    for joint in spec.joints:
        joint.damping, joint.armature = np.array([DAMPING, 0, 0]), ARMATURE
        joint.frictionloss = 0
        actuator = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=GAIN)
        actuator.forcelimited, actuator.forcerange = True, [-STRONGEST, STRONGEST]
    for body in spec.bodies[1:]:
        body.gravcomp = 1
    body = spec.worldbody.add_body(name="object", pos=hand.center)
    body.add_freejoint()
    geom = geom_of(spec, tomllib.loads(f"shape = {shape}")["shape"])
    body.add_geom(mass=MASS, contype=2, conaffinity=1, friction=[FRICTION, 0.005, 1e-4], **geom)
    return spec.compile()


def geom_of(spec, shape):
    kinds = mujoco.mjtGeom
    if "sphere" in shape:
        return {"type": kinds.mjGEOM_SPHERE, "size": [shape["sphere"], 0, 0]}
    if "box" in shape:
        return {"type": kinds.mjGEOM_BOX, "size": [side / 2 for side in shape["box"]]}
    for name, kind in (("cylinder", kinds.mjGEOM_CYLINDER), ("capsule", kinds.mjGEOM_CAPSULE)):
        if name in shape:
            return {"type": kind, "size": [shape[name][0], shape[name][1] / 2, 0]}
    spec.add_mesh(name="object", file=shape["mesh"])
    return {"type": kinds.mjGEOM_MESH, "meshname": "object"}


def pressing(model, scene, hand, q):
    """Returns torques (nq,) of contact forces that balance each other: non-negative along edges of friction cones."""
    data, names = mujoco.MjData(model), [joint.name for joint in scene.joints]
    data.qpos[[model.joint(name).qposadr[0] for name in names]] = q
    mujoco.mj_forward(model, data)
    dofs, wrenches, torques = [model.joint(name).dofadr[0] for name in names], [], []
    for contact in scene.contacts(q, within=CLEARANCE + TOUCH, threads=1):
        pair = scene.pairs[contact["pair"]]
        if "object" not in pair:
            continue
        first = pair[0] == "object"
        point, inward = contact["points"][0 if first else 1], contact["normal"] * (1 if first else -1)
        jacobian = np.zeros((3, model.nv))
        # MuJoCo merges links without a joint between them into one body.
        mujoco.mj_jac(model, data, jacobian, None, point, model.body(pair[1 if first else 0].replace("_tip", "")).id)
        across = np.linalg.svd(inward[None])[2][1:]
        for angle in np.linspace(0, 2 * np.pi, 8, endpoint=False):
            edge = inward + 0.9 * FRICTION * (np.cos(angle) * across[0] + np.sin(angle) * across[1])
            wrenches.append(np.concatenate([edge, np.cross(point - hand.center, edge) / 0.03]))
            torques.append(jacobian[:, dofs].T @ edge)
    if not wrenches:
        return np.zeros(len(names))
    count = len(wrenches)
    # Balance comes first, then equal forces at all contacts, because a pinch of two lets the object rotate.
    system = np.concatenate([np.transpose(wrenches), 0.3 * np.ones((1, count)), EVEN * np.eye(count)])
    shares = nnls(system, np.concatenate([np.zeros(6), [0.3], np.zeros(count)]))[0]
    return PRESS * shares / shares.sum() @ np.array(torques)


def held(model, scene, hand, q):
    """Returns for each direction of gravity whether the object stays, its greatest speed in 20 ms [m/s], and the penetration at the start [m]."""
    data, names, press = mujoco.MjData(model), [joint.name for joint in scene.joints], pressing(model, scene, hand, q)
    at = [model.joint(name).qposadr[0] for name in names]
    controls = [model.actuator(name).id for name in names]
    stays, fastest, deepest = [], 0.0, 0.0
    for direction in DIRECTIONS:
        mujoco.mj_resetData(model, data)
        model.opt.gravity[:] = 9.81 * direction
        data.qpos[at], data.ctrl[controls] = q, q + press / GAIN
        mujoco.mj_forward(model, data)
        deepest = max(0.0, *-data.contact.dist[: data.ncon], 0.0)
        for step in range(round(1 / STEP)):
            mujoco.mj_step(model, data)
            if step < 20:
                fastest = max(fastest, float(np.linalg.norm(data.body("object").cvel[3:])))
            if np.linalg.norm(data.body("object").xpos - hand.center) > FAR:
                break
        stays.append(bool(np.linalg.norm(data.body("object").xpos - hand.center) < FAR))
    return {"held": stays, "fastest": fastest, "deepest": deepest}


def run(hand, title, shape, grasps, seed, robots):
    path, scene = hand.scene_file(BUILD, title, shape, robots)
    trial, model = Trial(hand, path, scene, seed), simulation(hand, shape, robots)
    rows, tries, number = [], 0, 0
    while number < grasps and tries < 200 * grasps:
        tries += 1
        good = trial.good()
        if good is None or scene.release(good, object="object", threads=1, open=hand.open, friction=FRICTION).epsilon < EPSILON:
            continue
        number += 1
        of_good = held(model, scene, hand, good)
        for by in SQUEEZES:
            q = trial.squeezed(good, by)
            if trial.free(q):
                continue
            grasp = scene.release(q, object="object", threads=1, open=hand.open)
            found = {"good": of_good, "squeezed": held(model, scene, hand, q)}
            found["released"] = LOST if grasp is None else held(model, scene, hand, grasp.config)
            rows += [{"object": title, "squeeze": by, "state": state} | found[state] for state in STATES]
    in_all = {state: sum(all(r["held"]) for r in rows if r["state"] == state) for state in STATES}
    print(title, number, "grasps of", tries, "tries, held in all six:", in_all, flush=True)
    return rows


def page(rows):
    lines = []
    for by in SQUEEZES:
        for state in STATES:
            own = [r for r in rows if r["squeeze"] == by and r["state"] == state]
            all_six = np.mean([all(r["held"]) for r in own])
            deep, fast = 1e3 * np.nanmax([r["deepest"] for r in own]), np.nanmedian([r["fastest"] for r in own])
            share = np.mean([r["held"] for r in own])
            lines.append([f"{by} rad", state, len(own), f"{share:.3f}", f"{all_six:.3f}", f"{deep:.2f}", f"{fast:.2f}"])
    head = ["squeezed by", "state", "grasps", "held, share of directions", "held in all six", "deepest penetration at the start [mm]",
            "object's fastest in the first 20 ms, median [m/s]"]
    share = lambda title, state: np.mean([all(r["held"]) for r in rows if (r["object"], r["state"]) == (title, state)])
    by_object = [[title, *(f"{share(title, state):.2f}" for state in STATES)] for title in dict.fromkeys(r["object"] for r in rows)]
    return f"## Held in MuJoCo\n\n{table(head, lines)}\n\n{table(['object', *(f'{s}, held in all six' for s in STATES)], by_object)}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grasps", type=int, default=20, help="of each object")
    parser.add_argument("--objects", default=",".join(CONVEX), help="convex ones, between commas")
    parser.add_argument("--robots", type=Path, default=ROOT / "robots" / "example-robot-data" / "robots")
    parser.add_argument("--write", action="store_true", help="only write the page again")
    args = parser.parse_args()
    BUILD.mkdir(parents=True, exist_ok=True)
    figures = BUILD / "grasps-held.json"
    if not args.write:
        shapes, chosen = objects(), args.objects.split(",")
        if not set(chosen) <= set(CONVEX):
            parser.error(f"--objects: got {args.objects}, expected some of {', '.join(CONVEX)}")
        rows = []
        for title in chosen:
            rows += run(HANDS["allegro"], title, shapes[title], args.grasps, CONVEX.index(title), args.robots)
            figures.write_text(json.dumps(rows))
    text = page(json.loads(figures.read_text()))
    print(text)
    put(ROOT / "docs" / "benchmarks" / "grasps.md", "bench/grasps_held.py", text, "Grasps released")


if __name__ == "__main__":
    main()
