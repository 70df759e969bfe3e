"""Robots and obstacles of a scene: plain descriptions that `Scene` checks."""

from __future__ import annotations

import inspect
import os
from dataclasses import dataclass, field
from typing import Any, List, Literal, Mapping, Optional, Protocol, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

Path = Union[str, "os.PathLike[str]"]
Limits = Union[Tuple[float, float], Tuple[Sequence[float], Sequence[float]]]
# A pose is an array, or a dict with "xyz" and one of "rpy", "quat_xyzw" and "quat_wxyz".
Pose = Union[npt.ArrayLike, Mapping[str, npt.ArrayLike]]


class _WithFaces(Protocol):
    @property
    def vertices(self) -> Any: ...

    @property
    def faces(self) -> Any: ...


class _WithTriangles(Protocol):
    @property
    def vertices(self) -> Any: ...

    @property
    def triangles(self) -> Any: ...


TriangleMesh = Union[_WithFaces, _WithTriangles]


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot with its URDF and options; the same keys as `[[robot]]` in a scene file.

    urdf: path of a URDF file, or its text.
    name: distinguishes robots that share names of links or joints: `name/link`. None takes the URDF's name.
    srdf: path of an SRDF file, or its text. Its disabled pairs apply, and `group` can name its groups.
    group: only the joints of this SRDF group move. The others stay where `locked` puts them, else as near to 0 as their limits
        allow.
    packages: folders in which `package://NAME/...` is looked up first, as `FOLDER/NAME/...`. Then come the folders that contain
        the URDF (for a text, the working directory), and those of AMENT_PREFIX_PATH and ROS_PACKAGE_PATH.
    geometry: "mesh": collision meshes as they are; "convex-hull": the hull of each; "convex-parts": convex hulls that together
        contain each; "visual": the <visual> shapes of the robot instead.
    links: by link, another treatment of its meshes: "mesh", "convex-hull" or "convex-parts".
    base: "fixed", "planar" (x, y, angle) or "floating" (x, y, z and a quaternion).
    bounds: least and greatest position of a moving base [m]: two numbers each for a planar one (a third bounds the angle),
        three for a floating one.
    pose: pose of the base: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the key names the order.
    locked: positions of joints that do not move, by joint [rad or m]; these joints have no coordinates.
    limits: limits (lower, upper) by joint [rad or m] that replace the URDF's; ((lower, ..), (upper, ..)) for a planar or
        floating joint.
    """

    urdf: Path
    name: Optional[str] = None
    srdf: Optional[Path] = None
    group: Optional[str] = None
    packages: Sequence[Path] = ()
    geometry: Literal["mesh", "convex-hull", "convex-parts", "visual"] = "mesh"
    base: Literal["fixed", "planar", "floating"] = "fixed"
    bounds: Optional[Tuple[Sequence[float], Sequence[float]]] = None
    pose: Optional[Pose] = None
    locked: Mapping[str, float] = field(default_factory=dict)
    limits: Mapping[str, Limits] = field(default_factory=dict)
    links: Mapping[str, Literal["mesh", "convex-hull", "convex-parts"]] = field(default_factory=dict)

    @classmethod
    def from_xacro(
        cls, path: Path, *, packages: Sequence[Path] = (), options: Optional[Mapping[str, Any]] = None, **args: Any
    ) -> "Robot":
        """Makes the robot of a xacro file, which the package xacrodoc (`pip install 'extricate[xacro]'`) expands in memory.

        path: path of the xacro file.
        packages: folders in which `package://NAME/...` and `$(find NAME)` are looked up, besides those that contain the file,
            and ROS if it is installed.
        options: further arguments of `Robot`, such as {"srdf": ..}.
        args: arguments of the xacro file, as on its command line: `prefix="left_"`.

        A xacro file is a program, and xacrodoc runs it: use none from strangers, see SECURITY.md.

        Raises ImportError if the package is missing, ValueError if the file does not expand.
        """
        from ._xacro import expanded

        options = dict(options or {})
        text, folders = expanded(path, args, [*packages, *options.pop("packages", ())])
        return cls(text, packages=folders, **options)

    @classmethod
    def from_sdf(cls, path: Path, **options: Any) -> "SdfRobot":
        """Makes a robot of the model in an SDF file, as far as a URDF can express it: links, collision shapes, and joints that
        are fixed, revolute, continuous, prismatic or ball joints. Warnings name what it leaves out.

        path: path of the file. If it has several models, exactly one has joints that move; the others are obstacles. `model://`
            is looked up in `packages` and in the folders that contain the file.
        options: further arguments of `Robot`. `pose` is that of the SDF's world, in which its models have poses of their own.

        Raises ValueError if a URDF cannot express the file: joints of other kinds, models in models, loops, parts of meshes.
        Also if a joint has no finite limits and `limits` gives none.
        """
        from ._sdf import converted

        return converted(path, options)

    @classmethod
    def from_mujoco(cls, model: Any, **options: Any) -> "MujocoRobot":
        """Makes a robot of a MuJoCo model with the package mujoco (`pip install 'extricate[mujoco]'`): the shapes that can
        collide there, its joints in their order, and its pairs.

        model: an `mujoco.MjModel`, or the path of an MJCF file.
        options: further arguments of `Robot`, such as "pose" or "locked".

        Meshes become their convex hulls, as in MuJoCo. See `MujocoRobot` for configurations and pairs. A geom of the world that
        has the name of a body gets another one. Warnings name what is left out or differs (equality constraints, ellipsoids,
        height fields, mocap bodies, contacts that are off).
        """
        from ._mujoco import converted

        return converted(model, options)

    @classmethod
    def from_pinocchio(cls, model: Any, geometry_model: Any, **options: Any) -> "PinocchioRobot":
        """Makes a robot of a model of pinocchio: its joints in their order, its collision geometry, and its pairs.

        model: a `pinocchio.Model`.
        geometry_model: its `pinocchio.GeometryModel` for collisions, of shapes of coal. Its `collisionPairs` are checked, but those
            of an object whose collisions are off (`disableCollision`), or of two objects of one joint.
        options: further arguments of `Robot`, such as "pose" or "locked".

        Objects of the world that belong to no frame are obstacles. Ellipsoids become polyhedra around them, half a percent larger.
        Closed meshes are solid here, and surfaces in coal. See `PinocchioRobot` for configurations.

        Raises ValueError, with the name, for joints that a URDF cannot express (helical, universal, ellipsoid and mimic joints) and
        for other shapes (cones, planes, octrees, height fields). Also if a prismatic or a free joint has no finite limits and
        `limits` gives none.
        """
        from ._pinocchio import converted

        return converted(model, geometry_model, options)

    @classmethod
    def from_usd(cls, stage: Any, **options: Any) -> "UsdRobot":
        """Makes a robot of a stage of OpenUSD with the package usd-core (`pip install 'extricate[usd]'`): its rigid bodies, joints,
        collision shapes and pairs.

        stage: a `pxr.Usd.Stage`, or the path of a .usd, .usda, .usdc or .usdz file.
        options: further arguments of `Robot`, such as "base" or "limits".

        Lengths become metres by the stage's `metersPerUnit`; axes stay as they are. Links have the names of the bodies, and a joint is
        at 0 where its two frames meet. Bodies without joints, and shapes without a body, are obstacles. Warnings name what is left
        out or differs (loops, joints that mimic others, uneven scales, pairs of which only some shapes are filtered).

        Raises ImportError if the package is missing, ValueError if the file is none, or a URDF cannot express it: D6 and distance
        joints. Also if a prismatic joint has no finite limits and `limits` gives none.
        """
        from ._usd import converted

        return converted(stage, options)


@dataclass(frozen=True, eq=False)
class MujocoRobot(Robot):
    """A robot from MuJoCo. A `Scene` of it has its obstacles, and checks the pairs that MuJoCo checks.

    obstacles: shapes of bodies that do not move.
    disable: pairs that MuJoCo does not check, because of contype and conaffinity, exclusions, or as parent and child.
    enable: pairs of parent and child that MuJoCo does check, because of <pair> or <flag filterparent="disable"/>.
    qpos_index: (nq,) for every coordinate here, its index in MuJoCo's `qpos`.
    qpos0: (model.nq,) MuJoCo's initial state; entries without a coordinate here keep these values.
    files: the folder of the meshes that were made for it; it is deleted with the last robot that has it.
    """

    disable: Sequence[Tuple[str, str]] = ()
    enable: Sequence[Tuple[str, str]] = ()
    obstacles: Sequence[Any] = ()
    qpos_index: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    qpos0: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    files: Any = field(default=None, repr=False)

    def q(self, qpos: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Converts MuJoCo's states (.., model.nq) to configurations (.., nq): the same numbers in the order here, quaternions
        with w last."""
        return np.ascontiguousarray(np.asarray(qpos, dtype=np.float64)[..., self.qpos_index])

    def qpos(self, q: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Converts configurations (.., nq) to MuJoCo's states (.., model.nq): the inverse of `q`."""
        given = np.asarray(q, dtype=np.float64)
        out = np.broadcast_to(self.qpos0, given.shape[:-1] + self.qpos0.shape).copy()
        out[..., self.qpos_index] = given
        return out

    def reset(
        self, qpos: npt.ArrayLike, *, scene: Any = None, threads: int = 0
    ) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """Finds the nearest states without penetration, from which a simulation can start.

        qpos: MuJoCo's states (n, model.nq), or (model.nq,) for one.
        scene: the scene of the states; None makes `Scene(self)`. For many resets, make it once.
        threads: 0 for one per core.
        Returns states of the same shape, and how far each was moved in the scene's metric (n,): 0 if nothing collided, and inf
        if nothing free was found, which leaves the state as it was. Entries without a coordinate here stay as given.
        """
        from ._extricate import Scene

        given = np.array(qpos, dtype=np.float64)
        states = given.reshape(-1, given.shape[-1])
        answers = (Scene(self) if scene is None else scene).query_batch(self.q(states), threads=threads)
        # Free states are returned unchanged, to the last bit.
        found = np.isfinite(answers["depth"]) & ~answers["free"]
        states[np.ix_(found, self.qpos_index)] = answers["witness"][found]
        return states.reshape(given.shape), np.asarray(answers["depth"]).reshape(given.shape[:-1])


@dataclass(frozen=True, eq=False)
class PinocchioRobot(Robot):
    """A robot from pinocchio. A `Scene` of it has its obstacles, and checks the pairs of its geometry model.

    disable: pairs that are not in the geometry model.
    enable: pairs of the geometry model that one joint joins.
    obstacles: objects of the world.
    q_index: (nq,) for every coordinate here, its index in pinocchio's q.
    turns: coordinates here that are angles, and a cosine and a sine in pinocchio, at `q_index` and after it.
    q0: (model.nq,) pinocchio's neutral configuration; entries without a coordinate here keep these values.
    files: the folder of the meshes that were made for it; it is deleted with the last robot that has it.
    """

    disable: Sequence[Tuple[str, str]] = ()
    enable: Sequence[Tuple[str, str]] = ()
    obstacles: Sequence[Any] = ()
    q_index: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    turns: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    q0: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    files: Any = field(default=None, repr=False)

    def q(self, theirs: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Converts configurations of pinocchio (.., model.nq) to those here (.., nq)."""
        given = np.asarray(theirs, dtype=np.float64)
        out = np.ascontiguousarray(given[..., self.q_index])
        at = self.q_index[self.turns]
        out[..., self.turns] = np.arctan2(given[..., at + 1], given[..., at])
        return out

    def pinocchio_q(self, q: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Converts configurations (.., nq) to those of pinocchio (.., model.nq): the inverse of `q`."""
        given = np.asarray(q, dtype=np.float64)
        out = np.broadcast_to(self.q0, given.shape[:-1] + self.q0.shape).copy()
        out[..., self.q_index] = given
        at, angles = self.q_index[self.turns], given[..., self.turns]
        out[..., at], out[..., at + 1] = np.cos(angles), np.sin(angles)
        return out


@dataclass(frozen=True, eq=False)
class SdfRobot(Robot):
    """A robot from SDF. A `Scene` of it has its obstacles.

    obstacles: the other models of its world, in which no joint moves.
    files: the folder of the files that were made for it; it is deleted with the last robot that has it.
    """

    obstacles: Sequence[Any] = ()
    files: Any = field(default=None, repr=False)


@dataclass(frozen=True, eq=False)
class UsdRobot(Robot):
    """A robot from OpenUSD. A `Scene` of it has its obstacles, and checks the pairs that the stage does not filter.

    obstacles: shapes that do not move.
    disable: pairs that the stage filters.
    enable: pairs that one joint joins and the stage checks, because of `collisionEnabled`.
    files: the folder of the meshes that were made for it; it is deleted with the last robot that has it.
    """

    obstacles: Sequence[Any] = ()
    disable: Sequence[Tuple[str, str]] = ()
    enable: Sequence[Tuple[str, str]] = ()
    files: Any = field(default=None, repr=False)


# `help` of the derived classes shows the fields of `Robot` too.
_FIELDS = inspect.cleandoc(Robot.__doc__ or "").partition("\n\n")[2]
for _class in (MujocoRobot, PinocchioRobot, SdfRobot, UsdRobot):
    _class.__doc__ = f"{inspect.cleandoc(_class.__doc__ or '')}\n{_FIELDS}"


@dataclass(frozen=True, eq=False)
class Box:
    """A box as obstacle, its middle at `pose`.

    size: full sides along x, y and z, (3,) [m].
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..},
        also with "quat_wxyz" or "rpy": the key names the order.
    name: name of the obstacle in answers; None takes "box1" and so on.
    """

    size: npt.ArrayLike
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball as obstacle, its middle at `pose`.

    radius: radius of the ball [m].
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..},
        also with "quat_wxyz" or "rpy": the key names the order.
    name: name of the obstacle in answers; None takes "sphere1" and so on.
    """

    radius: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder along z as obstacle, its middle at `pose`.

    radius: radius of the cylinder [m].
    length: length along z [m].
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..},
        also with "quat_wxyz" or "rpy": the key names the order.
    name: name of the obstacle in answers; None takes "cylinder1" and so on.
    """

    radius: float
    length: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Capsule:
    """A capsule along z as obstacle, its middle at `pose`.

    radius: radius of the capsule [m].
    length: length without the caps [m].
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..},
        also with "quat_wxyz" or "rpy": the key names the order.
    name: name of the obstacle in answers; None takes "capsule1" and so on.
    """

    radius: float
    length: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh as obstacle. Connected parts that are closed are solid, others are surfaces.

    source: path of an STL, OBJ, COLLADA, PLY or glTF file; or (vertices, triangles): (n, 3) [m] and indices (m, 3); or a mesh
        of another package with `.vertices` and `.faces` (trimesh) or `.triangles` (open3d).
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..},
        also with "quat_wxyz" or "rpy": the key names the order.
    name: name of the obstacle in answers; None takes "mesh1" and so on.
    scale: one factor, or one along each axis (3,).
    convex: whether to replace the mesh by its convex hull.
    convex_parts: whether to replace the mesh by convex hulls that together contain it.
    """

    source: Union[Path, Tuple[npt.ArrayLike, npt.ArrayLike], TriangleMesh]
    pose: Optional[Pose] = None
    name: Optional[str] = None
    scale: npt.ArrayLike = 1.0
    convex: bool = False
    convex_parts: bool = False


@dataclass(frozen=True, eq=False)
class Fixture:
    """A robot file in which nothing moves, as one obstacle: a table, a shelf, a cell.

    urdf: path of a URDF file whose joints are all fixed.
    pose: pose of its root link: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4).
    name: name of the obstacle in answers; None takes "fixture1" and so on.
    packages: folders in which `package://NAME/...` is looked up.
    geometry: as in `Robot`.
    """

    urdf: Path
    pose: Optional[npt.ArrayLike] = None
    name: Optional[str] = None
    packages: Sequence[Path] = ()
    geometry: Literal["mesh", "convex-hull", "convex-parts", "visual"] = "mesh"


@dataclass(frozen=True, eq=False)
class Points:
    """A cloud of points as one obstacle: a ball around each.

    The cost of a check depends on the points near the robot, not on all points.

    xyz: (n, 3) [m]; n may be 0. Rows with NaN, where a camera saw nothing, are left out; a warning counts them.
    radius: radius of every ball [m]; with 0, distances are those to the points.
    pose: pose of the frame of the points: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform
        (4, 4).
    name: name of the obstacle in answers; None takes "points1" and so on.
    """

    xyz: npt.ArrayLike
    radius: float = 0.0
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Voxels:
    """The occupied cells of a regular grid as one obstacle: solid cubes. Cell (i, j, k) fills from (i, j, k) * size to
    (i + 1, j + 1, k + 1) * size.

    occupied: bool (nx, ny, nz), or the indices of occupied cells, int (n, 3).
    size: side of a cell [m].
    pose: pose of the grid, with its origin at the corner of cell (0, 0, 0): position (3,) [m], position and roll, pitch, yaw
        (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the key names the
        order.
    name: name of the obstacle in answers; None takes "voxels1" and so on.
    """

    occupied: npt.ArrayLike
    size: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """A half-space as obstacle, such as a floor or a wall without end. It is solid where `normal . x <= offset`.

    normal: normal of the plane, (3,) of any length, away from the solid side.
    offset: distance [m] of the plane from the origin, along the normal.
    pose: pose of the frame of normal and offset: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform
        (4, 4), or {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the key names the order.
    name: name of the obstacle in answers; None takes "halfspace1" and so on.
    """

    normal: npt.ArrayLike
    offset: float = 0.0
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class HeightField:
    """The ground below a grid of heights as obstacle, without end downward. Beyond the grid there is nothing.

    heights: (rows, columns) [m]: heights[i, j] is the height at x = i * size, y = j * size; two triangles join four neighbours.
    size: distance between neighbouring heights [m].
    pose: pose of the grid, with its origin at the place of heights[0, 0] and height 0: position (3,) [m], position and roll,
        pitch, yaw (6,) [m, rad], a transform (4, 4), or {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the key
        names the order.
    name: name of the obstacle in answers; None takes "heightfield1" and so on.
    """

    heights: npt.ArrayLike
    size: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


Obstacle = Union[Box, Sphere, Cylinder, Capsule, Mesh, Fixture, Points, Voxels, HalfSpace, HeightField]


def spheres(centers: npt.ArrayLike, radii: npt.ArrayLike) -> List[Sphere]:
    """Makes balls as obstacles, each a body of its own: centers (n, 3) [m], radii one number or (n,) [m].

    The cost of a check grows with their number. For hundreds and more, use `Points`, which is one body.
    """
    points = np.asarray(centers, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"centers: got shape {points.shape}, expected (n, 3)")
    sizes: Any = np.asarray(radii, dtype=np.float64)
    if sizes.shape not in ((), (len(points),)):
        raise ValueError(f"radii: got shape {sizes.shape}, expected () or ({len(points)},)")
    return [Sphere(float(radius), point) for point, radius in zip(points, np.broadcast_to(sizes, len(points)))]
