"""Resets in contact: random states of a quadruped, a humanoid and a hand are brought to touch, and MuJoCo judges them.

Each state is drawn at random. The body that is nearest to the ground (or the object) has to touch, and nothing else may collide.
"""
import time

import mujoco
import numpy as np

import extricate
import humanoid
from passages import box_part, capsule_link

COUNT = 10_000
# Largest distance of what has to touch [m].
TOUCHES = 1e-3


def quadruped():
    parts = [f'<link name="torso">{box_part((0.5, 0.22, 0.12), (0, 0, 0))}</link>']
    for name, x, y in (("fl", 0.2, 0.13), ("fr", 0.2, -0.13), ("hl", -0.2, 0.13), ("hr", -0.2, -0.13)):
        hip = [("roll", "1 0 0", -0.6, 0.6), ("pitch", "0 1 0", -1.2, 1.2)]
        parts += [f'<link name="{name}_thigh">{capsule_link(0.03, [(0, 0, -0.08), (0, 0, -0.2)])}</link>']
        parts += [f'<link name="{name}_shin">{capsule_link(0.022, [(0, 0, -0.06), (0, 0, -0.22)])}</link>']
        parts += [humanoid.joints(f"{name}_hip", hip, "torso", f"{name}_thigh", (x, y, 0))]
        parts += [humanoid.joints(name, [("knee", "0 1 0", -2.2, 0.0)], f"{name}_thigh", f"{name}_shin", (0, 0, -0.23))]
    return '<robot name="quadruped">' + "".join(parts) + "</robot>"


def hand():
    parts = [f'<link name="palm">{box_part((0.09, 0.1, 0.025), (0, 0, 0))}</link>']
    for name, y in (("index", 0.04), ("middle", 0.0), ("ring", -0.04)):
        parts += fingers(name, (0.055, y, 0.0), ("0 0 1", -0.3, 0.3), ("0 -1 0", -0.2, 1.5))
    parts += fingers("thumb", (0.0, 0.065, 0.0), ("1 0 0", -0.8, 0.8), ("0 -1 0", -0.2, 1.4))
    return '<robot name="hand">' + "".join(parts) + "</robot>"


def fingers(name, xyz, spread, bend):
    links = [f"{name}_{part}" for part in ("proximal", "middle", "tip")]
    parts = [f'<link name="{link}">{capsule_link(0.009, [(0.012, 0, 0), (0.032, 0, 0)])}</link>' for link in links]
    parts += [humanoid.joints(f"{name}_base", [("spread", *spread), ("bend", *bend)], "palm", links[0], xyz)]
    for before, link in zip(links, links[1:]):
        parts += [humanoid.joints(link, [("bend", "0 -1 0", 0.0, 1.6)], before, link, (0.044, 0, 0))]
    return parts


# URDF, the pairs that touch by design, what has to be touched, and where a floating base may be.
GROUND = extricate.Box([20, 20, 1], [0, 0, -0.5], name="ground")
BALL = extricate.Sphere(0.03, [0.08, 0, 0.06], name="ball")
ROBOTS = {
    "quadruped": (quadruped(), [], GROUND, ([-2, -2, 0.1], [2, 2, 0.8])),
    "humanoid": (humanoid.urdf(), humanoid.JOINED, GROUND, ([-2, -2, 0.4], [2, 2, 1.5])),
    "hand": (hand(), [], BALL, None),
}


class Judge:
    """The same robot in MuJoCo, with the pairs that the scene checks."""

    def __init__(self, scene, urdf, floats, target):
        spec = mujoco.MjSpec.from_string(urdf)
        spec.compiler.boundmass, spec.compiler.boundinertia, spec.compiler.fusestatic = 1e-3, 1e-6, False
        base = spec.worldbody.first_body()
        if floats:
            base.add_freejoint()
        kind, size = (mujoco.mjtGeom.mjGEOM_BOX, [10, 10, 0.5]) if target is GROUND else (mujoco.mjtGeom.mjGEOM_SPHERE, [target.radius, 0, 0])
        spec.worldbody.add_body(name=target.name, pos=target.pose).add_geom(name=target.name, type=kind, size=size)
        names = [body.name for body in spec.bodies if body.name not in ("world", "")]
        checked = {frozenset(pair) for pair in scene.pairs}
        for at, a in enumerate(names):
            for b in names[:at]:
                if frozenset((a, b)) not in checked:
                    spec.add_exclude(bodyname1=a, bodyname2=b)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.target = self.model.geom(target.name).id
        self.floats = floats
        self.order = [self.model.joint(joint.name).qposadr[0] for joint in scene.joints if joint.kind != "floating"]
        self.scene = scene

    def __call__(self, q, body):
        """Returns the deepest penetration [m], 0 if nothing penetrates, and the distance of a body from what it has to touch [m]."""
        if self.floats:
            # MuJoCo has w first.
            self.data.qpos[:7] = [*q[:3], q[6], *q[3:6]]
        self.data.qpos[self.order] = q[7:] if self.floats else q
        mujoco.mj_fwdPosition(self.model, self.data)
        deepest = -min([contact.dist for contact in self.data.contact[: self.data.ncon]], default=0.0)
        own = np.flatnonzero(self.model.geom_bodyid == self.model.body(body).id)
        near = min(mujoco.mj_geomDistance(self.model, self.data, geom, self.target, 1.0, None) for geom in own)
        return max(deepest, 0.0), near


def nearest_bodies(scene, Q, target):
    """Returns for each row the body that is nearest to the target."""
    pairs = [at for at, pair in enumerate(scene.pairs) if target in pair]
    names = [next(name for name in scene.pairs[at] if name != target) for at in pairs]
    return np.array(names)[scene.pair_distances(Q)[:, pairs].argmin(axis=1)]


def of_robot(name, count):
    urdf, joined, target, bounds = ROBOTS[name]
    robot = extricate.Robot(urdf, **({"base": "floating", "bounds": bounds} if bounds else {}))
    scene = extricate.Scene(robot, obstacles=[target], disable=joined)
    judge = Judge(scene, urdf, bounds is not None, target)
    Q = scene.sample(count, seed=1)
    bodies = nearest_bodies(scene, Q, target.name)
    found, seconds = np.full(Q.shape, np.nan), []
    for body in np.unique(bodies):
        rows = np.flatnonzero(bodies == body)
        started = time.process_time()
        found[rows] = scene.query_batch(Q[rows], touch=[(body, target.name)], effort="quick", threads=1)["witness"]
        seconds.append(time.process_time() - started)
    has = ~np.isnan(found[:, 0])
    judged = np.array([judge(q, body) for q, body in zip(found[has], bodies[has])])
    deep = int((judged[:, 0] > 0).sum())
    apart = int((judged[:, 1] > TOUCHES).sum())
    return f"| {name} | {count:,} | {has.mean():.4f} | {deep} | {apart} | {judged[:, 1].max():.1e} | {1e3 * sum(seconds) / count:.2f} |"


def resets(options):
    count = options.count or (200 if options.quick else COUNT)
    lines = [
        "| robot | states | found | penetrate | apart | farthest [m] | ms each |",
        "|---|---|---|---|---|---|---|",
        *(of_robot(name, count) for name in ROBOTS),
    ]
    return "\n".join(lines)
