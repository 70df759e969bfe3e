"""Converts a stage of OpenUSD to a robot: its rigid bodies, joints and collision shapes, its units and its pairs."""

from __future__ import annotations

import importlib
import tempfile
import warnings
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Optional, Set, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np

from ._meshes import ellipsoid, write_obj
from ._mujoco import Array, _Names
from ._parts import Box, Capsule, Cylinder, HalfSpace, Mesh, Obstacle, Sphere, UsdRobot
from ._sdf import _origin, _text

_Pair = Tuple[str, str]
# How `links` of a robot calls what UsdPhysics.MeshCollisionAPI calls an approximation.
_TREATMENTS = {"convexHull": "convex-hull", "convexDecomposition": "convex-parts"}
_TURNS = {"X": np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), "Y": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), "Z": np.eye(3)}
"""Rotations that take z to an axis: a URDF has cylinders along z."""


def converted(source: Any, options: Mapping[str, Any]) -> UsdRobot:
    """Makes the robot of a stage or a file; `options` are further arguments of `Robot`."""
    try:
        pxr = {name: importlib.import_module(f"pxr.{name}") for name in ("Gf", "Usd", "UsdGeom", "UsdPhysics")}
    except ImportError as error:
        raise ImportError("Robot.from_usd needs the package usd-core: pip install 'extricate[usd]'") from error
    if isinstance(source, pxr["Usd"].Stage):
        return _Converter(pxr, source, source.GetRootLayer().identifier).robot(dict(options))
    try:
        stage = pxr["Usd"].Stage.Open(str(source))
    except Exception as error:  # USD has exceptions of its own.
        raise ValueError(f"{source}: {' '.join(str(error).split())}, expected a stage of USD") from None
    return _Converter(pxr, stage, str(source)).robot(dict(options))


def _rigid(transform: Array) -> Array:
    """Returns the pose that is nearest to a transform: what is left without its scale."""
    left, _, right = np.linalg.svd(transform[:3, :3])
    found = transform.copy()
    found[:3, :3] = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return found


def _name(prim: Any) -> str:
    """Returns the name of a prim; that it had in another format, if USD has no such names and a converter wrote it otherwise."""
    name = str(prim.GetName())
    return str(prim.GetDisplayName()) or name if name.startswith("tn__") else name


class _Shape:
    """A collision shape: its prim, its body (None if it stands), and its pose in the body or in the world."""

    def __init__(self, prim: Any, api: Any, body: Any, transform: Array) -> None:
        self.prim, self.api, self.body, self.transform = prim, api, body, transform
        # Without shear, a transform is a rotation and a scale along each axis.
        self.scale = np.linalg.norm(transform[:3, :3], axis=0)
        self.pose = transform.copy()
        self.pose[:3, :3] = transform[:3, :3] / self.scale
        if np.linalg.det(self.pose[:3, :3]) < 0:
            # Shapes but meshes are their own mirror images.
            self.pose[:3, 0] *= -1
        self.is_sheared = not np.allclose(self.pose[:3, :3].T @ self.pose[:3, :3], np.eye(3), atol=1e-6)


class _Converter:
    def __init__(self, pxr: Mapping[str, Any], stage: Any, file: str) -> None:
        self.usd, self.geometry, self.physics, self.gf = pxr["Usd"], pxr["UsdGeom"], pxr["UsdPhysics"], pxr["Gf"]
        self.stage, self.file = stage, file
        self.unit = float(self.geometry.GetStageMetersPerUnit(stage))
        self.cache = self.geometry.XformCache()
        self.folder = tempfile.TemporaryDirectory(prefix="extricate-usd-")
        self.files = 0
        self.left_out: List[str] = []
        self.names, self.joint_names = _Names("world"), _Names()
        # Names of joints here, by path.
        self.joints: Dict[Any, str] = {}
        self.prims = list(self.usd.PrimRange(stage.GetPseudoRoot(), self.usd.TraverseInstanceProxies()))
        self.bodies = {prim.GetPath(): self.names.free(_name(prim)) for prim in self.prims if self.is_body(prim)}
        self.shapes = list(self.find_shapes())
        self.treatments: Dict[str, Set[str]] = {}

    def fail(self, prim: Any, problem: str) -> ValueError:
        return ValueError(f"{self.file}: {prim.GetPath()}: {problem}")

    # Bodies and poses

    def is_body(self, prim: Any) -> bool:
        return prim.HasAPI(self.physics.RigidBodyAPI) and bool(self.physics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get())

    def body_of(self, prim: Any) -> Any:
        """Returns the path of the body that a prim is part of; None if it stands."""
        while prim and prim.GetPath() not in self.bodies:
            prim = prim.GetParent()
        return prim.GetPath() if prim else None

    def transform(self, prim: Any) -> Array:
        """Returns the transform of a prim to the world [m], which may scale."""
        found = np.array(self.cache.GetLocalToWorldTransform(prim), dtype=np.float64).T
        found[:3, 3] *= self.unit
        return found

    def pose(self, path: Any) -> Array:
        """Returns the pose of a body in the world, without its scale."""
        if path is None:
            return np.eye(4)
        return _rigid(self.transform(self.stage.GetPrimAtPath(path)))

    # Shapes

    def find_shapes(self) -> Iterator[_Shape]:
        for prim in self.prims:
            if not prim.HasAPI(self.physics.CollisionAPI) or not self.physics.CollisionAPI(prim).GetCollisionEnabledAttr().Get():
                continue
            inside = self.usd.PrimRange(prim, self.usd.TraverseInstanceProxies())
            for shape in [prim] if prim.IsA(self.geometry.Gprim) else inside:
                if shape.IsA(self.geometry.Gprim) and (shape == prim or not shape.HasAPI(self.physics.CollisionAPI)):
                    body = self.body_of(shape)
                    yield _Shape(shape, prim, body, np.linalg.solve(self.pose(body), self.transform(shape)))

    def described(self, shape: _Shape) -> Tuple[Optional[str], Any, Array]:
        """Returns the kind of a shape in a URDF, its sizes [m], and its pose; None as the kind if the shape is left out."""
        geometry, prim, scale, unit = self.geometry, shape.prim, shape.scale, self.unit
        if prim.IsA(geometry.Mesh):
            return self.mesh(shape)
        if shape.is_sheared:
            self.left_out.append(f"{prim.GetPath()} is sheared, and left out")
        elif prim.IsA(geometry.Cube):
            return "box", geometry.Cube(prim).GetSizeAttr().Get() * scale * unit, shape.pose
        elif prim.IsA(geometry.Sphere):
            radii = geometry.Sphere(prim).GetRadiusAttr().Get() * scale * unit
            if np.ptp(radii) < 1e-9 * radii.max():
                return "sphere", float(radii[0]), shape.pose
            self.left_out.append(f"the ellipsoid {prim.GetPath()} is taken for a polyhedron around it, half a percent larger")
            return "mesh", self.written(*ellipsoid(radii)), shape.pose
        elif prim.IsA(geometry.Cylinder) or prim.IsA(geometry.Capsule):
            kind = "cylinder" if prim.IsA(geometry.Cylinder) else "capsule"
            form = geometry.Cylinder(prim) if kind == "cylinder" else geometry.Capsule(prim)
            axis = form.GetAxisAttr().Get()
            along = scale["XYZ".index(axis)]
            across = np.delete(scale, "XYZ".index(axis))
            if np.ptp(across) < 1e-9 * across.max() and (kind == "cylinder" or np.ptp(scale) < 1e-9 * scale.max()):
                pose = shape.pose.copy()
                pose[:3, :3] = pose[:3, :3] @ _TURNS[axis]
                sizes = form.GetRadiusAttr().Get() * across[0] * unit, form.GetHeightAttr().Get() * along * unit
                return kind, (float(sizes[0]), float(sizes[1])), pose
            self.left_out.append(f"the {kind} {prim.GetPath()} is scaled unevenly, and left out")
        elif prim.IsA(geometry.Plane):
            if shape.body is None:
                return "plane", _TURNS[geometry.Plane(prim).GetAxisAttr().Get()] @ [0, 0, 1], shape.pose
            self.left_out.append(f"the plane {prim.GetPath()} moves, and is left out")
        else:
            self.left_out.append(f"the {prim.GetTypeName()} {prim.GetPath()} is left out")
        return None, None, shape.pose

    def mesh(self, shape: _Shape) -> Tuple[Optional[str], Any, Array]:
        """Describes a mesh, or what stands for it: its box, its ball."""
        mesh = self.geometry.Mesh(shape.prim)
        points = np.array(mesh.GetPointsAttr().Get() or np.zeros((0, 3)), dtype=np.float64)
        counts, corners = (np.array(one.Get() or [], dtype=np.int64) for one in (mesh.GetFaceVertexCountsAttr(), mesh.GetFaceVertexIndicesAttr()))
        if counts.sum() != len(corners) or (len(corners) and not 0 <= corners.min() <= corners.max() < len(points)):
            raise self.fail(shape.prim, f"got faces of {counts.sum()} corners, expected {len(corners)} indices of {len(points)} points")
        if not len(corners):
            self.left_out.append(f"the mesh {shape.prim.GetPath()} has no faces, and is left out")
            return None, None, shape.pose
        api = self.physics.MeshCollisionAPI
        approximation = next((api(prim).GetApproximationAttr().Get() for prim in (shape.prim, shape.api) if prim.HasAPI(api)), "none")
        low, high = points.min(axis=0), points.max(axis=0)
        if approximation in ("boundingCube", "boundingSphere") and not shape.is_sheared:
            pose = shape.pose.copy()
            pose[:3, 3] = shape.transform[:3, :3] @ ((low + high) / 2) * self.unit + shape.transform[:3, 3]
            if approximation == "boundingCube":
                return "box", (high - low) * shape.scale * self.unit, pose
            radius = np.linalg.norm((points - (low + high) / 2) * shape.scale, axis=1).max() * self.unit
            return "sphere", float(radius), pose
        if shape.body is not None:
            self.treatments.setdefault(self.bodies[shape.body], set()).add(_TREATMENTS.get(approximation, "mesh"))
        firsts = np.repeat(np.cumsum(counts) - counts, np.maximum(counts - 2, 0))
        steps = np.concatenate([np.arange(1, count - 1) for count in counts]) if len(firsts) else np.zeros(0, dtype=np.int64)
        triangles = np.stack([corners[firsts], corners[firsts + steps], corners[firsts + steps + 1]], axis=1)
        is_mirrored = np.linalg.det(shape.transform[:3, :3]) < 0
        if (mesh.GetOrientationAttr().Get() == self.geometry.Tokens.leftHanded) != is_mirrored:
            triangles = triangles[:, ::-1]
        # The file has what the transform makes of the points, so that it may shear and mirror.
        moved = points @ shape.transform[:3, :3].T * self.unit + shape.transform[:3, 3]
        return "mesh", self.written(moved, triangles), np.eye(4)

    def written(self, vertices: Array, triangles: Array) -> Path:
        self.files += 1
        path = Path(self.folder.name) / f"{self.files}.obj"
        write_obj(path, vertices, triangles)
        return path

    def collision(self, shape: _Shape, offset: Array) -> str:
        """Returns the URDF text of a shape, in a link that has its body at `offset`."""
        kind, sizes, pose = self.described(shape)
        if kind is None:
            return ""
        attributes = {
            "box": lambda: f'size="{_text(sizes)}"',
            "sphere": lambda: f'radius="{sizes:.17g}"',
            "cylinder": lambda: f'radius="{sizes[0]:.17g}" length="{sizes[1]:.17g}"',
            "capsule": lambda: f'radius="{sizes[0]:.17g}" length="{sizes[1]:.17g}"',
            "mesh": lambda: f"filename={quoteattr(str(sizes))}",
        }[kind]()
        return f"<collision>{_origin(offset @ pose)}<geometry><{kind} {attributes}/></geometry></collision>"

    def obstacle(self, shape: _Shape, name: str, before: Array) -> Optional[Obstacle]:
        kind, sizes, pose = self.described(shape)
        pose = before @ pose
        if kind == "box":
            return Box(sizes, pose, name)
        if kind == "sphere":
            return Sphere(sizes, pose, name)
        if kind in ("cylinder", "capsule"):
            return (Cylinder if kind == "cylinder" else Capsule)(sizes[0], sizes[1], pose, name)
        if kind == "plane":
            return HalfSpace(sizes, 0.0, pose, name)
        return Mesh(sizes, pose, name, convex=shape.prim.GetAttribute("physics:approximation").Get() == "convexHull") if kind else None

    # Joints

    def ends(self, joint: Any) -> List[Tuple[Any, Array]]:
        """Returns the bodies of a joint (None for the world) and the frames of the joint in them."""
        api = self.physics.Joint(joint)
        found = []
        for relation, position, rotation in (
            (api.GetBody0Rel(), api.GetLocalPos0Attr(), api.GetLocalRot0Attr()),
            (api.GetBody1Rel(), api.GetLocalPos1Attr(), api.GetLocalRot1Attr()),
        ):
            targets = relation.GetTargets()
            target = self.stage.GetPrimAtPath(targets[0]) if targets else self.stage.GetPseudoRoot()
            if not target:
                raise self.fail(joint, f"got the body {targets[0]}, expected a prim of the stage")
            # The frame is one of the named prim, whose scale moves its origin.
            whole, frame = self.transform(target), np.eye(4)
            frame[:3, 3] = whole[:3, :3] @ np.array(position.Get(), dtype=np.float64) * self.unit + whole[:3, 3]
            turn = self.gf.Quatd(rotation.Get()).GetNormalized()
            frame[:3, :3] = _rigid(whole)[:3, :3] @ np.array(self.gf.Matrix3d(turn), dtype=np.float64).T
            body = self.body_of(target)
            found.append((body, np.linalg.solve(self.pose(body), frame)))
        return found

    def joint(self, joint: Any, name: str, sign: float, given: Set[str]) -> Tuple[str, str]:
        """Returns the type of a joint in a URDF, and the text of its axis and its limits."""
        physics = self.physics
        if joint.IsA(physics.FixedJoint):
            return "fixed", ""
        if joint.IsA(physics.SphericalJoint):
            return "spherical", ""
        if not joint.IsA(physics.RevoluteJoint) and not joint.IsA(physics.PrismaticJoint):
            raise self.fail(joint, f"got a {joint.GetTypeName()}, expected a revolute, prismatic, spherical or fixed joint")
        is_revolute = joint.IsA(physics.RevoluteJoint)
        api = physics.RevoluteJoint(joint) if is_revolute else physics.PrismaticJoint(joint)
        axis = f'<axis xyz="{_text(sign * (_TURNS[api.GetAxisAttr().Get()] @ [0, 0, 1]))}"/>'
        lower, upper = (float(attribute.Get()) * self.native(joint) for attribute in (api.GetLowerLimitAttr(), api.GetUpperLimitAttr()))
        if np.isinf(lower) and np.isinf(upper) and is_revolute:
            return "continuous", axis
        if not np.isfinite([lower, upper]).all() and name not in given:
            told = f"got limits of {lower:g} to {upper:g}, expected finite ones"
            raise self.fail(joint, f'{told}, or Robot.from_usd(path, limits={{"{name}": (lower, upper)}})')
        limits = f'<limit lower="{lower:.17g}" upper="{upper:.17g}"/>' if np.isfinite([lower, upper]).all() else ""
        axis += self.mimic(joint)
        return ("revolute" if is_revolute else "prismatic"), axis + limits

    def native(self, joint: Any) -> float:
        """Returns what a position of a joint in the units of the stage has to be multiplied by: to rad, or to m."""
        return float(np.pi / 180 if joint.IsA(self.physics.RevoluteJoint) else self.unit)

    def mimic(self, joint: Any) -> str:
        """Returns the text that makes a joint follow another one, as Newton's mimic joints do: coef0 + coef1 times the other."""
        relation, enabled = joint.GetRelationship("newton:mimicJoint"), joint.GetAttribute("newton:mimicEnabled")
        targets = relation.GetTargets() if relation and not (enabled and enabled.Get() is False) else []
        others = [name for name in joint.GetAppliedSchemas() if "mimic" in name.lower() and not name.startswith("Newton")]
        if others:
            self.left_out.append(f"the joint {joint.GetPath()} moves on its own: {others[0]} is left out")
        if not targets:
            return ""
        if targets[0] not in self.joints:
            raise self.fail(joint, f"newton:mimicJoint: got {targets[0]}, expected a joint")
        own, other = self.native(joint), self.native(self.stage.GetPrimAtPath(targets[0]))
        offset, factor = (joint.GetAttribute(f"newton:mimicCoef{at}").Get() for at in (0, 1))
        offset, factor = 0.0 if offset is None else offset, 1.0 if factor is None else factor
        return f'<mimic joint={quoteattr(self.joints[targets[0]])} multiplier="{factor * own / other:.17g}" offset="{offset * own:.17g}"/>'

    def robot(self, options: Dict[str, Any]) -> UsdRobot:
        given = {*options.get("limits", ()), *options.get("locked", ())}
        joints = [prim for prim in self.prims if prim.IsA(self.physics.Joint) and self.physics.Joint(prim).GetJointEnabledAttr().Get()]
        self.joints = {joint.GetPath(): self.joint_names.free(_name(joint)) for joint in joints}
        around: Dict[Any, List[Any]] = {}
        both = {joint.GetPath(): self.ends(joint) for joint in joints}
        for joint in joints:
            for body, _ in both[joint.GetPath()]:
                around.setdefault(body, []).append(joint)
        # A body that no joint holds stands where the stage has it.
        roots = [None, *(prim.GetPath() for prim in self.prims if prim.HasAPI(self.physics.ArticulationRootAPI)), *self.bodies]
        # By body, where it is in its link: the link of a URDF has the frame of the joint above it.
        offsets: Dict[Any, Array] = {}
        out, used, joined = [], set(), []
        for root in roots:
            if root in offsets or (root is not None and root not in self.bodies) or (root is not None and root not in around and len(self.bodies) > 1):
                continue
            offsets[root] = np.eye(4)
            if root is not None:
                out.append(self.link(root, offsets[root]) + self.held(root))
            waiting = [root]
            while waiting:
                body = waiting.pop(0)
                for joint in around.get(body, ()):
                    if joint.GetPath() in used:
                        continue
                    used.add(joint.GetPath())
                    (first, frame), (second, other) = both[joint.GetPath()]
                    sign = 1.0 if first == body else -1.0
                    above, below, child = (frame, other, second) if first == body else (other, frame, first)
                    if child in offsets or self.physics.Joint(joint).GetExcludeFromArticulationAttr().Get():
                        self.left_out.append(f"the joint {joint.GetPath()} closes a loop, and does not hold here")
                        continue
                    offsets[child] = np.linalg.inv(below)
                    name = self.joints[joint.GetPath()]
                    kind, text = self.joint(joint, name, sign, given)
                    joined.append((joint, body, child))
                    out.append(
                        self.link(child, offsets[child])
                        + f'<joint name={quoteattr(name)} type="{kind}"><parent link={quoteattr(self.name(body))}/>'
                        + f"<child link={quoteattr(self.name(child))}/>{_origin(offsets[body] @ above)}{text}</joint>"
                    )
                    waiting.append(child)
        if not any(body in offsets for body in self.bodies):
            raise ValueError(f"{self.file}: got no rigid body with joints, expected a robot (UsdPhysics.RigidBodyAPI)")
        text = f'<robot name={quoteattr(self.stage.GetDefaultPrim().GetName() or "usd" if self.stage.GetDefaultPrim() else "usd")}><link name="world"/>'
        obstacles, named = self.obstacles(offsets)
        disable, enable = self.pairs(named, joined)
        links: Dict[str, str] = {}
        for link, found in self.treatments.items():
            if len(found) > 1:
                self.left_out.append(f"the link {link} has meshes of several approximations ({', '.join(sorted(found))}), and is taken as they are")
            elif found != {"mesh"}:
                links[link] = next(iter(found))
        options["links"] = {**links, **options.get("links", {})}
        for told in self.left_out:
            warnings.warn(f"from_usd: {told}", stacklevel=4)
        return UsdRobot(text + "".join(out) + "</robot>", **options, disable=disable, enable=enable, obstacles=obstacles, files=self.folder)

    def name(self, body: Any) -> str:
        return "world" if body is None else self.bodies[body]

    def link(self, body: Any, offset: Array) -> str:
        parts = "".join(self.collision(shape, offset) for shape in self.shapes if shape.body == body)
        return f"<link name={quoteattr(self.name(body))}>{parts}</link>"

    def held(self, body: Any) -> str:
        """Returns the URDF text that holds the first body of a robot where the stage has it."""
        name = quoteattr(self.joint_names.free(f"{self.name(body)}__fixed"))
        return (
            f'<joint name={name} type="fixed"><parent link="world"/><child link={quoteattr(self.name(body))}/>'
            f"{_origin(self.pose(body))}</joint>"
        )

    def obstacles(self, offsets: Mapping[Any, Array]) -> Tuple[List[Obstacle], Dict[Any, str]]:
        """Returns the shapes that do not move as obstacles, and the name of each shape's body here, by the path of the shape."""
        found: List[Obstacle] = []
        named: Dict[Any, str] = {}
        for shape in self.shapes:
            if shape.body in offsets and shape.body is not None:
                named[shape.prim.GetPath()] = self.name(shape.body)
                continue
            if shape.body is not None:
                self.left_out.append(f"the body {shape.body} has no joint, and is an obstacle where the stage has it")
            name = self.names.free(_name(shape.prim))
            made = self.obstacle(shape, name, self.pose(shape.body))
            if made is not None:
                found.append(made)
                named[shape.prim.GetPath()] = name
        return found, named

    # Pairs

    def pairs(self, named: Mapping[Any, str], joined: List[Tuple[Any, Any, Any]]) -> Tuple[List[_Pair], List[_Pair]]:
        """Returns the pairs to disable, because all their shapes are filtered, and those to enable although a joint joins them."""
        parts: Dict[str, List[Any]] = {}
        for path, name in named.items():
            parts.setdefault(name, []).append(path)
        filtered = self.filtered(list(named))
        enable = [
            (self.name(parent), self.name(child))
            for joint, parent, child in joined
            if parent is not None and self.physics.Joint(joint).GetCollisionEnabledAttr().Get() and {self.name(parent), self.name(child)} <= set(parts)
        ]
        disable: List[_Pair] = []
        names = list(parts)
        for at, one in enumerate(names):
            for other in names[at + 1 :]:
                all_pairs = [frozenset((x, y)) for x in parts[one] for y in parts[other]]
                count = sum(pair in filtered for pair in all_pairs)
                if count == len(all_pairs):
                    disable.append((one, other))
                elif count:
                    self.left_out.append(f"{count} of {len(all_pairs)} pairs of shapes of {one} and {other} are filtered: here all are checked")
        return disable, [pair for pair in enable if pair not in disable and pair[::-1] not in disable]

    def filtered(self, shapes: List[Any]) -> Set[Any]:
        """Returns the pairs of shapes that the stage does not check: by filtered pairs, by groups, and within articulations."""
        physics = self.physics
        found: Set[Any] = set()

        def below(path: Any) -> List[Any]:
            return [shape for shape in shapes if shape.HasPrefix(path)]

        def add(some: List[Any], others: List[Any]) -> None:
            found.update(frozenset((x, y)) for x in some for y in others if x != y)

        groups: Dict[Any, List[Any]] = {}
        for prim in self.prims:
            if prim.HasAPI(physics.FilteredPairsAPI):
                for target in physics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetTargets():
                    add(below(prim.GetPath()), below(target))
            if prim.IsA(physics.CollisionGroup):
                members = physics.CollisionGroup(prim).GetCollidersCollectionAPI().ComputeMembershipQuery()
                groups[prim.GetPath()] = [shape for shape in shapes if members.IsPathIncluded(shape)]
            own = prim.GetAttribute("physxArticulation:enabledSelfCollisions")
            if prim.HasAPI(physics.ArticulationRootAPI) and own and own.Get() is False:
                # The root may be applied to the first body, beside which the others stand.
                inside = below(prim.GetParent().GetPath() if prim.GetPath() in self.bodies else prim.GetPath())
                add(inside, inside)
        for path, members in groups.items():
            group = physics.CollisionGroup(self.stage.GetPrimAtPath(path))
            targets = set(group.GetFilteredGroupsRel().GetTargets())
            if group.GetInvertFilteredGroupsAttr().Get():
                targets = set(groups) - targets
            for target in targets:
                add(members, groups.get(target, []))
        return found
