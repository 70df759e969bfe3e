"""What a scene is put together from. Plain descriptions; `Scene` checks them."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

Path = Union[str, "os.PathLike[str]"]
Limits = Union[Tuple[float, float], Tuple[Sequence[float], Sequence[float]]]


@dataclass(frozen=True, eq=False)
class Robot:
    """A robot with more than its URDF to say; the same keys as `[[robot]]` in a scene file."""

    urdf: Path
    """Path of a URDF file, or its text."""
    name: Optional[str] = None
    """Tells robots apart that share names of links or joints: `name/link`. The URDF's name where None."""
    srdf: Optional[Path] = None
    """Path of an SRDF file, or its text: its disabled pairs are honoured, its groups can be named."""
    group: Optional[str] = None
    """Only the joints of this SRDF group move; the others stand where `locked` says, or where their limits come nearest to 0."""
    packages: Sequence[Path] = ()
    """Folders in which `package://NAME/...` is looked up, as `FOLDER/NAME/...`."""
    geometry: str = "mesh"
    """"mesh": collision meshes as they are; "convex-hull": the hull of each."""
    base: str = "fixed"
    """"fixed", "planar" (x, y, angle) or "floating" (x, y, z and a quaternion)."""
    bounds: Optional[Tuple[Sequence[float], Sequence[float]]] = None
    """Least and greatest position of a moving base [m]: two numbers each where planar (a third bounds the angle), else three."""
    pose: Optional[npt.ArrayLike] = None
    """Where it stands: position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4)."""
    locked: Mapping[str, float] = field(default_factory=dict)
    """Joints that do not move, and their positions [rad or m]; they have no coordinates."""
    limits: Mapping[str, Limits] = field(default_factory=dict)
    """Limits (lower, upper) [rad or m] that replace the URDF's; of a planar or floating joint ((lower, ..), (upper, ..))."""


@dataclass(frozen=True, eq=False)
class Box:
    """A box obstacle, its middle at `pose`."""

    size: npt.ArrayLike
    """Full sides along x, y and z, (3,) [m]."""
    pose: Optional[npt.ArrayLike] = None
    """Position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4)."""
    name: Optional[str] = None
    """What answers call it; "box1" and so on where None."""


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball as obstacle."""

    radius: float
    """[m]"""
    pose: Optional[npt.ArrayLike] = None
    """Position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4)."""
    name: Optional[str] = None
    """What answers call it; "sphere1" and so on where None."""


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder along z as obstacle, its middle at `pose`."""

    radius: float
    """[m]"""
    length: float
    """[m]"""
    pose: Optional[npt.ArrayLike] = None
    """Position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4)."""
    name: Optional[str] = None
    """What answers call it; "cylinder1" and so on where None."""


@dataclass(frozen=True, eq=False)
class Capsule:
    """A capsule along z as obstacle, its middle at `pose`."""

    radius: float
    """[m]"""
    length: float
    """Without the caps [m]."""
    pose: Optional[npt.ArrayLike] = None
    """Position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4)."""
    name: Optional[str] = None
    """What answers call it; "capsule1" and so on where None."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh as obstacle. Connected parts that are closed are solid, others are surfaces."""

    source: Union[Path, Tuple[npt.ArrayLike, npt.ArrayLike]]
    """Path of an STL, OBJ or COLLADA file, or (vertices, triangles): (n, 3) [m] and indices (m, 3)."""
    pose: Optional[npt.ArrayLike] = None
    """Position (3,) [m], position and roll, pitch, yaw (6,) [m, rad], or a transform (4, 4)."""
    name: Optional[str] = None
    """What answers call it; "mesh1" and so on where None."""
    scale: npt.ArrayLike = 1.0
    """One factor, or one along each axis (3,)."""
    convex: bool = False
    """Whether its convex hull stands for it."""


Obstacle = Union[Box, Sphere, Cylinder, Capsule, Mesh]


def spheres(centers: npt.ArrayLike, radii: npt.ArrayLike) -> List[Sphere]:
    """Balls as obstacles, such as a point cloud: centers (n, 3) [m], radii one number or (n,) [m]."""
    points = np.asarray(centers, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"centers: got shape {points.shape}, expected (n, 3)")
    sizes: Any = np.asarray(radii, dtype=np.float64)
    if sizes.shape not in ((), (len(points),)):
        raise ValueError(f"radii: got shape {sizes.shape}, expected () or ({len(points)},)")
    return [Sphere(float(radius), point) for point, radius in zip(points, np.broadcast_to(sizes, len(points)))]
