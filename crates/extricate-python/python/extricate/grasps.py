"""Converts grasps between configurations of a floating hand and the arrays of poses and joints that data sets store.

    Q = extricate.grasps.from_arrays(scene, translation, rotation, {"index_curl": curls, ..}, rotation_as="quat_wxyz")
    released = scene.release(Q, object=cup)
    arrays = extricate.grasps.to_arrays(scene, np.array([grasp.config for grasp in released]), rotation_as="quat_wxyz")

Row k of every array is grasp k. A pose is that of the hand's root link, relative to the `pose` of the scene's robot.
"""

from __future__ import annotations

from typing import Any, List, Literal, Mapping, NamedTuple, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from ._extricate import Joint, Scene

__all__ = ["ROTATIONS", "Arrays", "from_arrays", "to_arrays"]

_Floats = npt.NDArray[np.float64]

# Shape of one rotation in each form.
_SHAPES = {"matrix": (3, 3), "quat_xyzw": (4,), "quat_wxyz": (4,), "rpy": (3,), "columns": (6,)}
Rotation = Literal["matrix", "quat_xyzw", "quat_wxyz", "rpy", "columns"]
ROTATIONS = tuple(_SHAPES)
"""Names of the forms of rotations, for `rotation_as`."""
# Largest deviation from unit quaternions and orthonormal matrices, which may be stored with four digits.
_TOLERANCE = 1e-3


class Arrays(NamedTuple):
    """Grasps as arrays; row k of each is grasp k.

    translation: position of the root link, (n, 3) [m].
    rotation: rotation of the root link: (n, 3, 3), (n, 4), (n, 3) or (n, 6), as requested.
    joints: positions of the joints, (n, k) [rad or m], a column for each of `names`.
    names: names of the joints, in the order of the columns, (k,).
    """

    translation: _Floats
    rotation: _Floats
    joints: _Floats
    names: List[str]


def from_arrays(
    scene: Scene,
    translation: npt.ArrayLike,
    rotation: npt.ArrayLike,
    joints: Union[Mapping[str, npt.ArrayLike], npt.ArrayLike],
    *,
    names: Optional[Sequence[str]] = None,
    rotation_as: Rotation = "matrix",
    base: Optional[str] = None,
    ignore: Sequence[str] = (),
) -> _Floats:
    """Returns the configurations (n, nq) of grasps, for a scene with one floating hand.

    scene: a scene whose robot has `base="floating"`.
    translation: position of the root link, (n, 3) [m].
    rotation: rotation of the root link, in the form of `rotation_as`.
    joints: positions by joint name, (n,) each, or one array (n, k) with the columns `names`. Their order does not matter. Every
        joint of the scene but the base needs a position; a joint that mimics another has none of its own.
    names: joint names of the columns of `joints`, (k,); None if `joints` has the names.
    rotation_as: "matrix" (n, 3, 3), "quat_xyzw" or "quat_wxyz" (n, 4), "rpy" (n, 3) [rad]: about the fixed axes x, y and z, one
        after another (`sxyz` of transforms3d); or "columns" (n, 6): the first two columns of the matrix, first one then the
        other, orthonormalized in that order (Zhou et al. 2019, doi:10.1109/CVPR.2019.00589).
    base: name of the floating joint; None if the scene has one.
    ignore: names in `joints` to leave out, such as those of joints that mimic others.
    Raises ValueError if something is missing, unknown, not finite, of another shape, or no rotation.
    """
    floating = _floating(scene, base)
    places = _finite("translation", translation, (None, 3))
    n = len(places)
    turns = _quaternions(rotation, n, rotation_as)
    columns = _columns(joints, names, n)
    unknown = sorted(set(ignore) - set(columns))
    if unknown:
        raise ValueError(f"ignore: got {unknown[0]!r}, expected names of `joints`: {', '.join(columns)}")
    others = [joint for joint in scene.joints if joint.name != floating.name]
    expected = {joint.name: joint for joint in others}
    for name in columns:
        if name not in expected and name not in ignore:
            raise ValueError(f"joints: got {name!r}, expected joints of the scene ({', '.join(expected)}), or `ignore` to name it")
    Q = np.empty((n, scene.nq))
    Q[:, floating.start : floating.start + 3] = places
    Q[:, floating.start + 3 : floating.stop] = turns
    for name, joint in expected.items():
        if name not in columns or name in ignore:
            raise ValueError(f"joints: {name!r} is missing, got {', '.join(columns) or 'none'}")
        if joint.stop - joint.start != 1:
            raise ValueError(f"scene: joint {name!r} is {joint.kind}, expected joints of one coordinate besides the base")
        Q[:, joint.start] = columns[name]
    return Q


def to_arrays(
    scene: Scene,
    Q: npt.ArrayLike,
    *,
    names: Optional[Sequence[str]] = None,
    rotation_as: Rotation = "matrix",
    base: Optional[str] = None,
) -> Arrays:
    """Returns the arrays of configurations: the inverse of `from_arrays`.

    scene: a scene whose robot has `base="floating"`.
    Q: configurations, (n, nq).
    names: names of the joints in the columns of `joints`, in this order; None takes all in the scene's order.
    rotation_as: as in `from_arrays`. Quaternions have w of at least 0; roll and yaw are within pi, pitch within pi / 2.
    base: name of the floating joint; None if the scene has one.
    """
    floating = _floating(scene, base)
    given = _finite("Q", Q, (None, scene.nq))
    expected = {joint.name: joint for joint in scene.joints if joint.name != floating.name}
    chosen = list(expected) if names is None else list(names)
    for at, name in enumerate(chosen):
        if name not in expected:
            raise ValueError(f"names[{at}]: got {name!r}, expected one of {', '.join(expected)}")
    turns = _unit("Q: quaternions of the base", given[:, floating.start + 3 : floating.stop])
    positions = given[:, [expected[name].start for name in chosen]]
    return Arrays(given[:, floating.start : floating.start + 3].copy(), _in_form(turns, rotation_as), positions, chosen)


def _floating(scene: Scene, base: Optional[str]) -> Joint:
    found = [joint for joint in scene.joints if joint.kind == "floating"]
    if base is not None:
        named = [joint for joint in found if joint.name == base]
        if not named:
            known = ", ".join(joint.name for joint in found) or "none in this scene"
            raise ValueError(f"base: got {base!r}, expected a floating joint: {known}")
        return named[0]
    if len(found) != 1:
        hint = f"{', '.join(joint.name for joint in found)}: name one as `base`" if found else 'a robot with base="floating"'
        raise ValueError(f"scene: got {len(found)} floating joints, expected one ({hint})")
    return found[0]


def _finite(what: str, values: npt.ArrayLike, shape: Sequence[Optional[int]]) -> _Floats:
    """Converts to float64 and checks the shape; None in `shape` allows any length."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape)):
        expected = ", ".join("n" if want is None else str(want) for want in shape) + ("," if len(shape) == 1 else "")
        raise ValueError(f"{what}: got shape {array.shape}, expected ({expected})")
    wrong = np.argwhere(~np.isfinite(array))
    if len(wrong):
        at = tuple(int(k) for k in wrong[0])
        raise ValueError(f"{what}[{', '.join(map(str, at))}]: got {array[at]}, expected a finite number")
    return array


def _columns(joints: Any, names: Optional[Sequence[str]], n: int) -> Mapping[str, _Floats]:
    if isinstance(joints, Mapping):
        if names is not None:
            raise ValueError("names: got both, expected None where `joints` has the names")
        return {name: _finite(f"joints[{name!r}]", values, (n,)) for name, values in joints.items()}
    if names is None:
        raise ValueError("names: got None, expected a name for every column of `joints`")
    twice = [name for at, name in enumerate(names) if name in names[:at]]
    if twice:
        raise ValueError(f"names: got {twice[0]!r} twice, expected each once")
    table = _finite("joints", joints, (n, len(names)))
    return {name: table[:, k] for k, name in enumerate(names)}


def _unit(what: str, quaternions: _Floats) -> _Floats:
    lengths = np.linalg.norm(quaternions, axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1) > _TOLERANCE)
    if len(wrong):
        at = int(wrong[0])
        raise ValueError(f"{what}[{at}]: got {quaternions[at].tolist()} of length {lengths[at]:.6g}, expected 1")
    return np.asarray(quaternions / lengths[:, None])


def _form(rotation_as: str) -> Sequence[int]:
    if rotation_as not in _SHAPES:
        raise ValueError(f"rotation_as: got {rotation_as!r}, expected one of {', '.join(ROTATIONS)}")
    return _SHAPES[rotation_as]


def _quaternions(rotation: npt.ArrayLike, n: int, rotation_as: str) -> _Floats:
    """Converts rotations of any form to quaternions x, y, z, w."""
    given = _finite("rotation", rotation, (n, *_form(rotation_as)))
    if rotation_as == "quat_xyzw":
        return _unit("rotation", given)
    if rotation_as == "quat_wxyz":
        return _unit("rotation", given)[:, [1, 2, 3, 0]]
    if rotation_as == "rpy":
        (sr, cr), (sp, cp), (sy, cy) = ((np.sin(half), np.cos(half)) for half in given.T / 2)
        parts = [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy]
        return np.stack(parts, 1)
    return _of_matrices(_matrices_of_columns(given) if rotation_as == "columns" else _orthonormal(given))


def _orthonormal(matrices: _Floats) -> _Floats:
    off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2), initial=0)
    wrong = np.flatnonzero((off > _TOLERANCE) | (np.linalg.det(matrices) < 0))
    if len(wrong):
        at = int(wrong[0])
        why = f"off by {off[at]:.2g}" if off[at] > _TOLERANCE else "a reflection"
        raise ValueError(f"rotation[{at}]: got {matrices[at].tolist()}, {why}, expected a rotation matrix")
    return matrices


def _matrices_of_columns(columns: _Floats) -> _Floats:
    first, second = columns[:, :3], columns[:, 3:]
    wrong = np.flatnonzero(np.linalg.norm(np.cross(first, second), axis=1) < 1e-9)
    if len(wrong):
        at = int(wrong[0])
        raise ValueError(f"rotation[{at}]: got {columns[at].tolist()}, expected two columns that are not parallel")
    x = first / np.linalg.norm(first, axis=1, keepdims=True)
    z = np.cross(x, second)
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], -1)


def _of_matrices(m: _Floats) -> _Floats:
    """Returns the quaternions of rotation matrices as eigenvectors of Bar-Itzhack's matrix, without a division by small numbers
    ("New method for extracting the quaternion from a rotation matrix", 2000, doi:10.2514/2.4654)."""
    k = np.zeros((len(m), 4, 4))
    for row, column, value in (
        (0, 0, m[:, 0, 0] - m[:, 1, 1] - m[:, 2, 2]),
        (1, 1, m[:, 1, 1] - m[:, 0, 0] - m[:, 2, 2]),
        (2, 2, m[:, 2, 2] - m[:, 0, 0] - m[:, 1, 1]),
        (3, 3, m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]),
        (1, 0, m[:, 1, 0] + m[:, 0, 1]),
        (2, 0, m[:, 2, 0] + m[:, 0, 2]),
        (2, 1, m[:, 2, 1] + m[:, 1, 2]),
        (3, 0, m[:, 2, 1] - m[:, 1, 2]),
        (3, 1, m[:, 0, 2] - m[:, 2, 0]),
        (3, 2, m[:, 1, 0] - m[:, 0, 1]),
    ):
        k[:, row, column] = value  # `eigh` reads the lower triangle.
    found: _Floats = np.linalg.eigh(k)[1][:, :, 3]
    return found


def _matrices(quaternions: _Floats) -> _Floats:
    x, y, z, w = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def _in_form(quaternions: _Floats, rotation_as: str) -> _Floats:
    _form(rotation_as)
    if rotation_as in ("quat_xyzw", "quat_wxyz"):
        upper = np.where(quaternions[:, 3:] < 0, -quaternions, quaternions)
        return np.asarray(upper if rotation_as == "quat_xyzw" else upper[:, [3, 0, 1, 2]])
    m = _matrices(quaternions)
    if rotation_as == "matrix":
        return m
    if rotation_as == "columns":
        return np.concatenate([m[:, :, 0], m[:, :, 1]], 1)
    pitch, yaw = np.arctan2(-m[:, 2, 0], np.hypot(m[:, 0, 0], m[:, 1, 0])), np.arctan2(m[:, 1, 0], m[:, 0, 0])
    # If the x axis points along z, yaw is arbitrary; computing roll from it keeps the rotation exact.
    sy, cy = np.sin(yaw), np.cos(yaw)
    roll = np.arctan2(sy * m[:, 0, 2] - cy * m[:, 1, 2], cy * m[:, 1, 1] - sy * m[:, 0, 1])
    return np.stack([roll, pitch, yaw], 1)
