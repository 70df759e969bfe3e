"""Converts a model of pinocchio and its collision geometry to a robot: joints in their order, shapes, and pairs."""

from __future__ import annotations

import importlib
import tempfile
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Optional, Set, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np

from ._meshes import ellipsoid, write_obj
from ._mujoco import _Names, _text
from ._parts import Box, Capsule, Cylinder, HalfSpace, Mesh, Obstacle, PinocchioRobot, Sphere

_UNLIMITED = 1e300
"""pinocchio has limits of this size, or infinite ones, for joints without limits."""
_X, _Y, _Z = np.eye(3)
_JOINTS: Dict[str, List[Tuple[str, Any]]] = {
    **{f"R{name}": [("revolute", axis)] for name, axis in zip("XYZ", (_X, _Y, _Z))},
    **{f"RUB{name}": [("continuous", axis)] for name, axis in zip("XYZ", (_X, _Y, _Z))},
    **{f"P{name}": [("prismatic", axis)] for name, axis in zip("XYZ", (_X, _Y, _Z))},
    "RevoluteUnaligned": [("revolute", None)],
    "RevoluteUnboundedUnaligned": [("continuous", None)],
    "PrismaticUnaligned": [("prismatic", None)],
    "FreeFlyer": [("floating", _Z)],
    "Spherical": [("spherical", _Z)],
    "SphericalZYX": [("revolute", _Z), ("revolute", _Y), ("revolute", _X)],
    "Planar": [("prismatic", _X), ("prismatic", _Y), ("continuous", _Z)],
    "Translation": [("prismatic", _X), ("prismatic", _Y), ("prismatic", _Z)],
}
"""Joints of a URDF that move as one of pinocchio, one after the other; without an axis, the joint has it."""
_WIDTHS = {"floating": 7, "spherical": 4}
"""Coordinates of a joint here, if they are more than one."""


class _Joint(NamedTuple):
    """A joint here: all of one of pinocchio, or a part of it."""

    name: str
    kind: str
    axis: Any
    placement: Any
    at: int
    is_turn: bool
    """Whether pinocchio has the cosine and the sine of its angle, at `at` and after it."""


def converted(model: Any, geometry: Any, options: Mapping[str, Any]) -> PinocchioRobot:
    """Makes the robot of a model and a geometry model; `options` are further arguments of `Robot`."""
    return _Converter(importlib.import_module("pinocchio"), model, geometry).robot(dict(options))


class _Converter:
    def __init__(self, pinocchio: Any, model: Any, geometry: Any) -> None:
        self.pinocchio, self.model = pinocchio, model
        self.folder = tempfile.TemporaryDirectory(prefix="extricate-pinocchio-")
        self.objects = list(geometry.geometryObjects)
        self.partners: List[Set[int]] = [set() for _ in self.objects]
        for pair in geometry.collisionPairs:
            a, b = int(pair.first), int(pair.second)
            # No joint moves two objects of one joint against each other.
            is_off = self.objects[a].disableCollision or self.objects[b].disableCollision
            if not is_off and self.objects[a].parentJoint != self.objects[b].parentJoint:
                self.partners[a].add(b)
                self.partners[b].add(a)
        self.names = _Names("world")
        self.bodies = self.grouped()
        taken = _Names(*model.names)
        # By joint of pinocchio; the first one is the world.
        self.joints: List[List[_Joint]] = [list(self.parts(joint, taken)) if joint else [] for joint in range(model.njoints)]
        self.fixed = _Names(*taken.taken)

    def grouped(self) -> Dict[str, List[int]]:
        """Groups the objects of a frame that are in the same pairs. Each group is a body; the first has the name of the frame.
        Objects without a frame are bodies of their own."""
        found: Dict[Any, List[int]] = {}
        for number, part in enumerate(self.objects):
            if self.partners[number]:
                key = part.parentFrame, part.parentJoint, self.is_hull(number), frozenset(self.partners[number])
                found.setdefault(number if self.stands(number) or self.frame(number) is None else key, []).append(number)
        return {
            self.names.free(self.objects[numbers[0]].name if key == numbers[0] else str(self.frame(numbers[0]))): numbers
            for key, numbers in found.items()
        }

    def frame(self, number: int) -> Optional[str]:
        """Returns the name of the frame that an object is part of; None for the world, and if pinocchio was told none."""
        frame = self.objects[number].parentFrame
        return str(self.model.frames[frame].name) if 0 < frame < len(self.model.frames) else None

    def is_hull(self, number: int) -> bool:
        return "Convex" in type(self.objects[number].geometry).__name__

    def stands(self, number: int) -> bool:
        """Whether an object is an obstacle: one of the world itself."""
        is_plane = type(self.objects[number].geometry).__name__ == "Halfspace"
        return self.objects[number].parentJoint == 0 and (is_plane or self.frame(number) is None)

    def parts(self, joint: int, taken: _Names) -> Iterator[_Joint]:
        """Yields the joints here that move as one of pinocchio."""
        model, whole = self.model, self.model.joints[joint].extract()
        of_composite: List[Any] = []
        if hasattr(whole, "joints"):
            of_composite = [(part.extract(), place) for part, place in zip(whole.joints, whole.jointPlacements)]
        for number, (part, place) in enumerate(of_composite or [(whole, self.pinocchio.SE3.Identity())]):
            kinds = _JOINTS.get(part.shortname().replace("JointModel", ""))
            if kinds is None:
                known = ", ".join(_JOINTS)
                raise ValueError(f"from_pinocchio: {model.names[joint]}: got a {part.shortname()}, expected one of {known}")
            at = part.idx_q
            place = model.jointPlacements[joint] * place if number == 0 else place
            for kind, axis in kinds:
                name = model.names[joint] + (f"_{number}" if of_composite else "")
                if len(kinds) > 1:
                    name += "_" + "xyz"[int(np.argmax(axis))]
                name = name if name == model.names[joint] else taken.free(name)
                is_turn = kind == "continuous"
                yield _Joint(name, kind, part.axis if axis is None else axis, place, at, is_turn)
                place = self.pinocchio.SE3.Identity()
                at += 2 if is_turn else _WIDTHS.get(kind, 1)

    def robot(self, options: Dict[str, Any]) -> PinocchioRobot:
        locked = options.get("locked", {})
        index: List[int] = []
        turns: List[int] = []
        limits: Dict[str, Any] = {}
        q0 = np.array(self.pinocchio.neutral(self.model), dtype=np.float64)
        for joint in (joint for joints in self.joints for joint in joints):
            lower, upper = self.limits(joint, 3)
            if joint.kind == "floating" and max(np.abs([lower, upper]).flat) < _UNLIMITED:
                limits[joint.name] = (lower.tolist(), upper.tolist())
            if joint.name in locked:
                angle = locked[joint.name]
                q0[joint.at : joint.at + 1 + joint.is_turn] = [np.cos(angle), np.sin(angle)] if joint.is_turn else angle
                continue
            turns += [len(index)] * joint.is_turn
            index += range(joint.at, joint.at + _WIDTHS.get(joint.kind, 1))
        stands = {name: numbers[0] for name, numbers in self.bodies.items() if self.stands(numbers[0])}
        hulls = {name: "convex-hull" for name, (first, *_) in self.bodies.items() if name not in stands and self.is_hull(first)}
        options["limits"] = {**limits, **options.get("limits", {})}
        options["links"] = {**hulls, **options.get("links", {})}
        disable, enable = self.pairs(locked)
        return PinocchioRobot(
            self.urdf(),
            **options,
            disable=disable,
            enable=enable,
            obstacles=[self.obstacle(name, number) for name, number in stands.items()],
            q_index=np.array(index, dtype=np.int64),
            turns=np.array(turns, dtype=np.int64),
            q0=q0,
            files=self.folder,
        )

    def limits(self, joint: _Joint, count: int) -> Tuple[Any, Any]:
        """Returns the lower and upper limits of the first coordinates of a joint."""
        part = slice(joint.at, joint.at + count)
        return self.model.lowerPositionLimit[part], self.model.upperPositionLimit[part]

    def shape(self, number: int) -> Tuple[str, Any]:
        """Returns the kind of an object's shape in a URDF, and its sizes [m] or its file."""
        part = self.objects[number]
        shape = part.geometry
        kind = type(shape).__name__
        if getattr(shape, "getSweptSphereRadius", float)() > 0:
            got = shape.getSweptSphereRadius()
            raise ValueError(f"from_pinocchio: {part.name}: got a swept sphere radius of {got} m, expected 0")
        if kind == "Box":
            return "box", 2 * shape.halfSide
        if kind == "Sphere":
            return "sphere", float(shape.radius)
        if kind in ("Cylinder", "Capsule"):
            return kind.lower(), (float(shape.radius), 2 * float(shape.halfLength))
        if kind == "Ellipsoid":
            return "mesh", self.file(number, *ellipsoid(shape.radii))
        if self.is_hull(number):
            # Three of its points each, so that all are part of the mesh whose hull is taken.
            points = np.array(shape.points())
            return "mesh", self.file(number, points, [np.array([k, k + 1, k + 2]) % len(points) for k in range(len(points))])
        if kind.startswith("BVHModel"):
            triangles = [np.array([triangle[k] for k in range(3)]) for triangle in map(shape.tri_indices, range(shape.num_tris))]
            return "mesh", self.file(number, shape.vertices(), triangles)
        known = "Box, Sphere, Cylinder, Capsule, Ellipsoid, Convex, BVHModel, or a Halfspace of the world"
        raise ValueError(f"from_pinocchio: {part.name}: got a {kind}, expected one of {known}")

    def file(self, number: int, vertices: Any, triangles: Any) -> Path:
        """Writes the mesh file of an object and returns its path."""
        path = Path(self.folder.name) / f"{number}.obj"
        write_obj(path, vertices, triangles)
        return path

    def obstacle(self, name: str, number: int) -> Obstacle:
        part = self.objects[number]
        pose = np.array(part.placement.homogeneous)
        if type(part.geometry).__name__ == "Halfspace":
            return HalfSpace(part.geometry.n, float(part.geometry.d), pose, name)
        kind, size = self.shape(number)
        if kind == "box":
            return Box(size, pose, name)
        if kind == "sphere":
            return Sphere(size, pose, name)
        if kind in ("cylinder", "capsule"):
            return (Cylinder if kind == "cylinder" else Capsule)(size[0], size[1], pose, name)
        return Mesh(size, pose, name, convex=self.is_hull(number))

    def origin(self, placement: Any) -> str:
        numbers = self.pinocchio.SE3ToXYZQUAT(placement)
        return f'<origin xyz="{_text(numbers[:3])}" quat_xyzw="{_text(numbers[3:])}"/>'

    def urdf(self) -> str:
        # Names of the form `pinocchio/name` must not collide with names of the model.
        robot = "pinocchio"
        while any(name.startswith(f"{robot}/") for name in self.names.taken | self.fixed.taken):
            robot += "_"
        out, ends = [f'<robot name="{robot}"><link name="world"/>'], ["world"]
        for number, joints in enumerate(self.joints):
            above = ends[self.model.parents[number]] if number else "world"
            for joint in joints:
                (lower,), (upper,) = self.limits(joint, 1)
                kind, limit = joint.kind, ""
                if kind in ("revolute", "prismatic") and max(abs(lower), abs(upper)) < _UNLIMITED:
                    limit = f'<limit lower="{lower:.17g}" upper="{upper:.17g}"/>'
                elif kind == "revolute":
                    kind = "continuous"
                link = self.names.free(f"{joint.name}__end")
                moved = self.joint(joint.name, kind, above, link, joint.placement, joint.axis, limit)
                out.append(f"<link name={quoteattr(link)}/>{moved}")
                above = link
            if number:
                ends.append(above)
        for name, numbers in self.bodies.items():
            if not self.stands(numbers[0]):
                parts = "".join(f"<collision>{self.geometry(k)}</collision>" for k in numbers)
                end, fixed = ends[self.objects[numbers[0]].parentJoint], self.fixed.free(f"{name}__fixed")
                tied = self.joint(fixed, "fixed", end, name, self.pinocchio.SE3.Identity(), _Z)
                out.append(f"<link name={quoteattr(name)}>{parts}</link>{tied}")
        return "".join(out) + "</robot>"

    def joint(self, name: str, kind: str, parent: str, child: str, placement: Any, axis: Any, limit: str = "") -> str:
        return (
            f"<joint name={quoteattr(name)} type=\"{kind}\"><parent link={quoteattr(parent)}/><child link={quoteattr(child)}/>"
            f"{self.origin(placement)}<axis xyz=\"{_text(axis)}\"/>{limit}</joint>"
        )

    def geometry(self, number: int) -> str:
        kind, size = self.shape(number)
        if kind == "box":
            text = f'size="{_text(size)}"'
        elif kind == "sphere":
            text = f'radius="{size:.17g}"'
        elif kind == "mesh":
            text = f"filename={quoteattr(str(size))}"
        else:
            text = f'radius="{size[0]:.17g}" length="{size[1]:.17g}"'
        return f"{self.origin(self.objects[number].placement)}<geometry><{kind} {text}/></geometry>"

    def pairs(self, locked: Mapping[str, float]) -> Tuple[List[Tuple[str, str]], List[Tuple[str, str]]]:
        """Returns the pairs to disable, which are not in the geometry model, and those to enable, which are although one joint
        joins them."""
        # The joint that each is fixed to if `locked` joints do not move: itself, if it moves.
        rigid = [0]
        for joint in range(1, self.model.njoints):
            moves = any(part.name not in locked for part in self.joints[joint])
            rigid.append(joint if moves else rigid[self.model.parents[joint]])
        disable, enable, bodies = [], [], list(self.bodies.items())
        for k, (name, (first, *_)) in enumerate(bodies):
            for other, (second, *_) in bodies[k + 1 :]:
                joints = self.objects[first].parentJoint, self.objects[second].parentJoint
                a, b = rigid[joints[0]], rigid[joints[1]]
                is_neighbour = b == rigid[self.model.parents[a]] or a == rigid[self.model.parents[b]]
                if joints[0] != joints[1] and second not in self.partners[first]:
                    disable.append((name, other))
                elif a != b and is_neighbour and not (self.stands(first) or self.stands(second)):
                    enable.append((name, other))
        return disable, enable
