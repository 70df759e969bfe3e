"""Robots and worlds drawn at random: every kind of joint, joints that follow others, shapes within each other, sheets; from a
millionth of a metre to a kilometre. Lengths are in units of the scene's scale until it is written."""
from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

KINDS = ["revolute", "revolute", "revolute", "continuous", "prismatic", "fixed", "spherical", "planar", "floating"]
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
# Outward faces of the cube, two triangles each; the last two triangles are its lid.
SIDES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])
PHI = (1 + 5**0.5) / 2
# https://mathworld.wolfram.com/RegularIcosahedron.html: corners, on the unit sphere.
ICOSAHEDRON = np.array([[0, s, t * PHI] for s in (-1, 1) for t in (-1, 1)] + [[s, t * PHI, 0] for s in (-1, 1) for t in (-1, 1)]
                       + [[t * PHI, 0, s] for s in (-1, 1) for t in (-1, 1)], float) / np.hypot(1, PHI)


@dataclass
class Shape:
    """kind, its numbers, and where it is in its link. Meshes have corners and triangles; a hollow box is cut out of a solid one."""

    kind: str
    size: list
    xyz: np.ndarray
    rpy: np.ndarray
    corners: np.ndarray | None = None
    triangles: np.ndarray | None = None


@dataclass
class Joint:
    name: str
    kind: str
    parent: int
    xyz: np.ndarray
    rpy: np.ndarray
    axis: np.ndarray
    lower: float
    upper: float
    # The joint that this one follows, multiplier and offset.
    mimic: tuple | None = None


@dataclass
class Drawn:
    """Link k hangs on joint k - 1."""

    seed: int
    scale: float
    clearance: float
    metric: str
    weights: dict
    base: str
    joints: list = field(default_factory=list)
    links: list = field(default_factory=list)
    obstacles: list = field(default_factory=list)


def faces_of_hull(corners):
    """Returns outward triangles of the hull of corners that are all on it, no four of them in a plane."""
    faces = []
    n = len(corners)
    for i in range(n):
        for j in range(i + 1, n):
            for k in range(j + 1, n):
                normal = np.cross(corners[j] - corners[i], corners[k] - corners[i])
                side = (corners - corners[i]) @ normal
                side = side[np.abs(side) > 1e-12]
                if (side < 0).all():
                    faces.append([i, j, k])
                elif (side > 0).all():
                    faces.append([i, k, j])
    return np.array(faces)


def shape(rng, sheets=True):
    a, b, c = rng.uniform(0.05, 0.4, 3)
    kind = rng.choice(["box", "sphere", "cylinder", "capsule", "solid", "tetrahedron", "hollow"] + sheets * ["sheet", "open"])
    xyz, rpy = rng.uniform(-0.1, 0.1, 3), rng.uniform(-3, 3, 3)
    half = np.array([a, b, c]) / 2
    if kind == "box":
        return Shape(kind, [a, b, c], xyz, rpy)
    if kind == "sphere":
        return Shape(kind, [a / 2], xyz, rpy)
    if kind in ("cylinder", "capsule"):
        return Shape(kind, [a / 2, b], xyz, rpy)
    if kind == "solid":
        return Shape(kind, [], xyz, rpy, ICOSAHEDRON * half, faces_of_hull(ICOSAHEDRON * half))
    if kind == "tetrahedron":
        corners = rng.uniform(-1, 1, (4, 3)) * half * 2
        return Shape("solid", [], xyz, rpy, corners, faces_of_hull(corners))
    if kind == "sheet":
        return Shape(kind, [], xyz, rpy, CUBE[::2] * half * [1, 1, 0], np.array([[0, 2, 3], [0, 3, 1]]))
    if kind == "open":
        return Shape(kind, [], xyz, rpy, CUBE * half, SIDES[:-2])
    thick = rng.uniform(0.1, 0.4) * half.min()
    inner = SIDES[:, ::-1] + 8
    return Shape(kind, [*(2 * half), thick], xyz, rpy, np.concatenate([CUBE * half, CUBE * (half - thick)]), np.concatenate([SIDES, inner]))


def unit(rng):
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def joint(rng, number):
    kind = str(rng.choice(KINDS)) if number > 1 else str(rng.choice(KINDS[:5]))
    axis = np.array([0.0, 0, 1]) if kind == "planar" else unit(rng)
    reach = {"prismatic": 0.5, "planar": 0.5, "floating": 0.5}.get(kind, 2.5)
    lower, upper = -reach * rng.uniform(0.3, 1), reach * rng.uniform(0.3, 1)
    return Joint(f"j{number}", kind, number - 1 if rng.random() < 0.7 else int(rng.integers(0, number)), rng.uniform(-0.4, 0.4, 3), rng.uniform(-3, 3, 3), axis, lower, upper)


def draw(seed):
    rng = np.random.default_rng(seed)
    tiny_or_huge = rng.random() < 0.4
    scale = float(10 ** (rng.uniform(-4, 3) if tiny_or_huge else rng.uniform(-1, 0.5)))
    # Files allow clearances from 1e-9 m, which is much for a tiny robot.
    clearance = float(rng.choice([0.0, 1e-3, 0.02]))
    drawn = Drawn(seed, scale, clearance, str(rng.choice(["joint", "joint", "object-norm", "max-displacement"])), {}, str(rng.choice(["fixed", "fixed", "planar", "floating"])))
    count = int(rng.integers(1, 7))
    drawn.links = [[]]
    for number in range(1, count + 1):
        new = joint(rng, number)
        leads = [j for j in drawn.joints if j.kind in ("revolute", "prismatic") and j.mimic is None]
        if leads and new.kind in ("revolute", "prismatic", "continuous") and rng.random() < 0.25:
            lead = leads[int(rng.integers(len(leads)))]
            new.mimic = (lead.name, float(rng.uniform(-1, 1)), float(rng.uniform(-0.2, 0.2)))
        drawn.joints.append(new)
        drawn.links.append([shape(rng) for _ in range(int(rng.choice([0, 1, 1, 1, 2])))])
    if not any(drawn.links):
        drawn.links[-1] = [shape(rng)]
    if drawn.metric == "joint" and rng.random() < 0.3:
        drawn.weights = {j.name: float(rng.uniform(0.2, 5)) for j in drawn.joints if j.kind in ("revolute", "continuous", "prismatic") and j.mimic is None}
    for _ in range(int(rng.integers(1, 4))):
        new = shape(rng)
        grown = 8.0 if rng.random() < 0.2 else rng.uniform(1, 2)
        # A large shape may contain others.
        new.size = [float(grown * x) for x in new.size]
        new.corners = None if new.corners is None else grown * new.corners
        new.xyz = rng.uniform(-0.8, 0.8, 3)
        drawn.obstacles.append(new)
    return drawn


def words(values):
    return " ".join(repr(float(v)) for v in values)


def obj(path, shape, scale):
    lines = [f"v {words(scale * corner)}\n" for corner in shape.corners]
    lines += [f"f {' '.join(str(k + 1) for k in face)}\n" for face in shape.triangles]
    path.write_text("".join(lines))


def write(drawn, folder):
    """Writes `scene.toml` and the files that it names; returns its path."""
    folder, s = Path(folder), drawn.scale
    names = iter(range(10**6))

    def mesh(one):
        name = f"m{next(names)}.obj"
        obj(folder / name, one, s)
        return name

    def collision(one):
        size = [s * x for x in one.size]
        if one.corners is not None:
            geometry = f'<mesh filename="{mesh(one)}"/>'
        elif one.kind == "box":
            geometry = f'<box size="{words(size)}"/>'
        elif one.kind == "sphere":
            geometry = f'<sphere radius="{words(size)}"/>'
        else:
            geometry = f'<{one.kind} radius="{words(size[:1])}" length="{words(size[1:])}"/>'
        return f'<collision><origin xyz="{words(s * one.xyz)}" rpy="{words(one.rpy)}"/><geometry>{geometry}</geometry></collision>'

    text = ['<robot name="r">']
    text += [f'<link name="l{k}">{"".join(collision(one) for one in shapes)}</link>' for k, shapes in enumerate(drawn.links)]
    limits = []
    for k, j in enumerate(drawn.joints, 1):
        unit = s if j.kind in ("prismatic", "planar", "floating") else 1.0
        more = f'<limit lower="{unit * j.lower!r}" upper="{unit * j.upper!r}" effort="1" velocity="1"/>' if j.kind in ("revolute", "prismatic") else ""
        if j.mimic:
            lead = next(other for other in drawn.joints if other.name == j.mimic[0])
            # The weight of a length against an angle depends on the scale too.
            factor = (s if j.kind == "prismatic" else 1.0) / (s if lead.kind == "prismatic" else 1.0)
            offset = j.mimic[2] * (s if j.kind == "prismatic" else 1.0)
            more += f'<mimic joint="{j.mimic[0]}" multiplier="{factor * j.mimic[1]!r}" offset="{offset!r}"/>'
        if j.kind in ("planar", "floating"):
            limits.append(f"{j.name} = [{unit * j.lower!r}, {unit * j.upper!r}]")
        text.append(f'<joint name="{j.name}" type="{j.kind}"><parent link="l{j.parent}"/><child link="l{k}"/>'
                    f'<origin xyz="{words(s * j.xyz)}" rpy="{words(j.rpy)}"/><axis xyz="{words(j.axis)}"/>{more}</joint>')
    (folder / "r.urdf").write_text("\n".join(text + ["</robot>"]))
    weights = f", weights = {{ {', '.join(f'{n} = {w!r}' for n, w in drawn.weights.items())} }}" if drawn.weights else ""
    toml = [f"clearance = {s * drawn.clearance!r}", f'metric = {{ kind = "{drawn.metric}"{weights} }}', "[[robot]]", 'urdf = "r.urdf"']
    if drawn.base != "fixed":
        n = 2 if drawn.base == "planar" else 3
        toml += [f'base = "{drawn.base}"', f"bounds = {{ min = {[-s] * n}, max = {[s] * n} }}"]
    if limits:
        toml.append(f"limits = {{ {', '.join(limits)} }}")
    for k, one in enumerate(drawn.obstacles):
        size = [s * x for x in one.size]
        spoken = f'mesh = "{mesh(one)}"' if one.corners is not None else f"{one.kind} = {size[0] if one.kind == 'sphere' else size}"
        toml += ["[[obstacle]]", f'name = "o{k}"', f"shape = {{ {spoken} }}", f"pose = {{ xyz = {[s * float(x) for x in one.xyz]}, rpy = {[float(x) for x in one.rpy]} }}"]
    path = folder / "scene.toml"
    path.write_text("\n".join(toml) + "\n")
    return path
