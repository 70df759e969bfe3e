"""Robots and obstacles of a scene: plain descriptions, which `Scene` checks."""

from __future__ import annotations

import inspect
import os
from dataclasses import dataclass, field
from typing import Any, List, Mapping, Optional, Protocol, Sequence, Tuple, Union

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
    """A robot with more than its URDF to say; the same keys as `[[robot]]` in a scene file.

    urdf: path of a URDF file, or its text.
    name: tells robots apart that share names of links or joints: `name/link`. The URDF's name where None.
    srdf: path of an SRDF file, or its text: its disabled pairs are honoured, its groups can be named.
    group: only the joints of this SRDF group move; the others stand where `locked` says, or where their limits come nearest
        to 0.
    packages: folders in which `package://NAME/...` is looked up first, as `FOLDER/NAME/...`; then come the folders that the URDF
        lies in (of a text, the working directory), and those of AMENT_PREFIX_PATH and ROS_PACKAGE_PATH.
    geometry: "mesh": collision meshes as they are; "convex-hull": the hull of each; "convex-parts": convex hulls that together
        hold each; "visual": the <visual> shapes of the robot instead.
    links: by link, what becomes of its meshes instead: "mesh", "convex-hull" or "convex-parts".
    base: "fixed", "planar" (x, y, angle) or "floating" (x, y, z and a quaternion).
    bounds: least and greatest position of a moving base [m]: two numbers each where planar (a third bounds the angle), else
        three.
    pose: where it stands: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    locked: joints that do not move, and their positions [rad or m]; they have no coordinates.
    limits: limits (lower, upper) [rad or m] that replace the URDF's; of a planar or floating joint ((lower, ..), (upper,
        ..)).
    """

    urdf: Path
    name: Optional[str] = None
    srdf: Optional[Path] = None
    group: Optional[str] = None
    packages: Sequence[Path] = ()
    geometry: str = "mesh"
    base: str = "fixed"
    bounds: Optional[Tuple[Sequence[float], Sequence[float]]] = None
    pose: Optional[Pose] = None
    locked: Mapping[str, float] = field(default_factory=dict)
    limits: Mapping[str, Limits] = field(default_factory=dict)
    links: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def from_xacro(
        cls, path: Path, *, packages: Sequence[Path] = (), options: Optional[Mapping[str, Any]] = None, **args: Any
    ) -> "Robot":
        """The robot of a xacro file, expanded in memory by the package xacrodoc (`pip install 'extricate[xacro]'`).

        path: of the xacro file.
        packages: folders in which `package://NAME/...` and `$(find NAME)` are looked up, besides those that the file lies in,
            and ROS where it is installed.
        options: further arguments of `Robot`, such as {"srdf": ..}.
        args: of the xacro file, as on its command line: `prefix="left_"`.

        A xacro file is a program, and xacrodoc runs it: take none from strangers, see SECURITY.md.

        Raises ImportError where the package is missing, ValueError where the file does not expand.
        """
        from ._xacro import expanded

        options = dict(options or {})
        text, folders = expanded(path, args, [*packages, *options.pop("packages", ())])
        return cls(text, packages=folders, **options)

    @classmethod
    def from_sdf(cls, path: Path, **options: Any) -> "SdfRobot":
        """The model of an SDF file, as far as a URDF can say it: links, collision shapes, and joints that are fixed, revolute,
        continuous, prismatic or ball ones. What it leaves out is told by warnings.

        path: of the file. Of several models, one has joints that move; the others are obstacles. `model://` is looked up in
            `packages` and in the folders that the file lies in.
        options: further arguments of `Robot`. `pose` is that of the SDF's world, in which its models have poses of their own.

        Raises ValueError where the file has what cannot be told in a URDF: joints of other kinds, models in models, loops, parts
        of meshes; and where a joint has no finite limits and `limits` gives none.
        """
        from ._sdf import converted

        return converted(path, options)

    @classmethod
    def from_mujoco(cls, model: Any, **options: Any) -> "MujocoRobot":
        """A MuJoCo model, by the package mujoco (`pip install 'extricate[mujoco]'`): the shapes that can collide there, its
        joints in their order, and its pairs.

        model: an `mujoco.MjModel`, or the path of an MJCF file.
        options: further arguments of `Robot`, such as "pose" or "locked".

        Meshes are the convex hulls that MuJoCo takes them for. See `MujocoRobot` for configurations and pairs. A geom of the
        world that has the name of a body gets another one. What is left out or differs (equality constraints, ellipsoids,
        height fields, mocap bodies, contacts that are off) is told by warnings.
        """
        from ._mujoco import converted

        return converted(model, options)


@dataclass(frozen=True, eq=False)
class MujocoRobot(Robot):
    """A robot from MuJoCo: a `Scene` of it has its obstacles, and checks the pairs that MuJoCo checks.

    obstacles: shapes of bodies that do not move.
    disable: pairs that MuJoCo does not check, by contype and conaffinity, exclusions, and as parent and child.
    enable: pairs of parent and child that MuJoCo does check, by <pair> or <flag filterparent="disable"/>.
    qpos_index: (nq,) for every coordinate here its place in MuJoCo's `qpos`.
    qpos0: (model.nq,) where MuJoCo starts; what has no coordinate here stays there.
    files: the folder of the meshes that were made for it, which goes with the last robot that has it.
    """

    disable: Sequence[Tuple[str, str]] = ()
    enable: Sequence[Tuple[str, str]] = ()
    obstacles: Sequence[Any] = ()
    qpos_index: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    qpos0: npt.NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    files: Any = field(default=None, repr=False)

    def q(self, qpos: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """Configurations (.., nq) of MuJoCo's (.., model.nq): the same numbers in the order here, quaternions with w last."""
        return np.ascontiguousarray(np.asarray(qpos, dtype=np.float64)[..., self.qpos_index])

    def qpos(self, q: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """MuJoCo's (.., model.nq) of configurations (.., nq): the inverse of `q`."""
        given = np.asarray(q, dtype=np.float64)
        out = np.broadcast_to(self.qpos0, given.shape[:-1] + self.qpos0.shape).copy()
        out[..., self.qpos_index] = given
        return out

    def reset(
        self, qpos: npt.ArrayLike, *, scene: Any = None, threads: int = 0
    ) -> Tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The nearest states without penetration, as a simulation can start from.

        qpos: MuJoCo's states (n, model.nq), or (model.nq,) for one.
        scene: where they are; None for `Scene(self)`. Whoever resets often makes it once.
        threads: 0 for one per core.
        Returns states of the same shape, and how far each was moved in the scene's metric (n,): 0 where nothing collided, and
        inf where nothing free was found, which leaves the state as it was. What has no coordinate here stays as given.
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
class SdfRobot(Robot):
    """A robot from SDF: a `Scene` of it has its obstacles.

    obstacles: the other models of its world, in which no joint moves.
    files: the folder of what was made for it, which goes with the last robot that has it.
    """

    obstacles: Sequence[Any] = ()
    files: Any = field(default=None, repr=False)


# `help` of the derived classes shows the fields of `Robot` too.
_FIELDS = inspect.cleandoc(Robot.__doc__ or "").partition("\n\n")[2]
for _class in (MujocoRobot, SdfRobot):
    _class.__doc__ = f"{inspect.cleandoc(_class.__doc__ or '')}\n{_FIELDS}"


@dataclass(frozen=True, eq=False)
class Box:
    """A box obstacle, its middle at `pose`.

    size: full sides along x, y and z, (3,) [m].
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "box1" and so on where None.
    """

    size: npt.ArrayLike
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball as obstacle.

    radius: [m]
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "sphere1" and so on where None.
    """

    radius: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder along z as obstacle, its middle at `pose`.

    radius: [m]
    length: [m]
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "cylinder1" and so on where None.
    """

    radius: float
    length: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class Capsule:
    """A capsule along z as obstacle, its middle at `pose`.

    radius: [m]
    length: without the caps [m].
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "capsule1" and so on where None.
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
    pose: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "mesh1" and so on where None.
    scale: one factor, or one along each axis (3,).
    convex: whether its convex hull stands for it.
    convex_parts: whether convex hulls that together hold it stand for it.
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
    pose: of its root link: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4).
    name: what answers call it; "fixture1" and so on where None.
    packages: folders in which `package://NAME/...` is looked up.
    geometry: as of `Robot`.
    """

    urdf: Path
    pose: Optional[npt.ArrayLike] = None
    name: Optional[str] = None
    packages: Sequence[Path] = ()
    geometry: str = "mesh"


@dataclass(frozen=True, eq=False)
class Points:
    """A cloud of points as one obstacle: a ball about each.

    What a check costs is that of the points near the robot, not of all.

    xyz: (n, 3) [m]; n may be 0. Rows with NaN, where a camera saw nothing, are left out; a warning counts them.
    radius: of every ball [m]; with 0, distances are those to the points.
    pose: of the frame that the points are given in: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a
        transform (4, 4).
    name: what answers call it; "points1" and so on where None.
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
    pose: of the corner of cell (0, 0, 0) and the grid's axes: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad],
        a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "voxels1" and so on where None.
    """

    occupied: npt.ArrayLike
    size: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """A half-space as obstacle, such as a floor or a wall without end: solid where `normal . x <= offset`.

    normal: (3,) of any length, away from what is solid.
    offset: distance [m] of the plane from the origin, along the normal.
    pose: of the frame that both are given in: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], a transform
        (4, 4), or {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "halfspace1" and so on where None.
    """

    normal: npt.ArrayLike
    offset: float = 0.0
    pose: Optional[Pose] = None
    name: Optional[str] = None


@dataclass(frozen=True, eq=False)
class HeightField:
    """The ground below a grid of heights as obstacle, without end downward; beyond the grid there is nothing.

    heights: (rows, columns) [m]: heights[i, j] is that at x = i * size, y = j * size; two triangles between four of them.
    size: between neighbouring heights [m].
    pose: of the place of heights[0, 0] at height 0, and the grid's axes: position (3,) [m], position and roll, pitch, yaw
        (6,) [m, rad], a transform (4, 4), or
        {"xyz": .., "quat_xyzw": ..}, also with "quat_wxyz" or "rpy": the name tells the order.
    name: what answers call it; "heightfield1" and so on where None.
    """

    heights: npt.ArrayLike
    size: float
    pose: Optional[Pose] = None
    name: Optional[str] = None


Obstacle = Union[Box, Sphere, Cylinder, Capsule, Mesh, Fixture, Points, Voxels, HalfSpace, HeightField]


def spheres(centers: npt.ArrayLike, radii: npt.ArrayLike) -> List[Sphere]:
    """Balls as obstacles, each a body of its own: centers (n, 3) [m], radii one number or (n,) [m].

    What a check costs grows with their number; of hundreds and more, `Points` is one body.
    """
    points = np.asarray(centers, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"centers: got shape {points.shape}, expected (n, 3)")
    sizes: Any = np.asarray(radii, dtype=np.float64)
    if sizes.shape not in ((), (len(points),)):
        raise ValueError(f"radii: got shape {sizes.shape}, expected () or ({len(points)},)")
    return [Sphere(float(radius), point) for point, radius in zip(points, np.broadcast_to(sizes, len(points)))]
