"""Motions of a scene as recordings of rerun and of Foxglove.

    extricate.recordings.save_rerun(scene, path.points, "escape.rrd")       # pip install 'extricate[rerun]'
    extricate.recordings.save_mcap(scene, path.points, "escape.mcap")       # pip install 'extricate[foxglove]'

Both hold the shapes that are checked, one body each, with their poses at every configuration. Links that collide are orange.
"""

from __future__ import annotations

import importlib
from typing import Any, List, Tuple

import numpy as np
import numpy.typing as npt

from ._extricate import Scene
from ._page import PathLike

__all__ = ["save_mcap", "save_rerun"]

_Floats = npt.NDArray[np.float64]
_Color = Tuple[float, float, float, float]

# Colours of links, of what collides and of obstacles: red, green, blue and opacity, 0 to 1. Those of pages.
_LINK, _HIT, _OBSTACLE = (0.58, 0.63, 0.70, 1.0), (0.84, 0.37, 0.0, 1.0), (0.78, 0.75, 0.65, 0.5)


def _imported(module: str, package: str, extra: str) -> Any:
    """Imports a module of an optional package."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ImportError(f"this needs {package}: pip install 'extricate[{extra}]'") from error


def _frames(scene: Scene, Q: npt.ArrayLike, times: Any) -> Tuple[_Floats, _Floats]:
    """Returns the configurations, (n, nq), and their times [s], (n,)."""
    configs = np.atleast_2d(np.asarray(Q, dtype=float))
    if configs.ndim != 2 or configs.shape[1] != scene.nq or not len(configs):
        raise ValueError(f"Q: got shape {np.shape(Q)}, expected (n, {scene.nq}) with n at least 1")
    seconds = np.arange(len(configs)) / 10 if times is None else np.asarray(times, dtype=float)
    if seconds.shape != (len(configs),):
        raise ValueError(f"times: got shape {seconds.shape}, expected ({len(configs)},), one for each configuration")
    if not np.all(np.isfinite(seconds)) or seconds[0] < 0 or np.any(np.diff(seconds) < 0):
        raise ValueError("times: expected finite seconds from 0 on that do not decrease")
    return configs, seconds


def _colors(scene: Scene, q: _Floats, moving: npt.NDArray[np.bool_]) -> List[_Color]:
    """Returns the colour of every body at a configuration."""
    hit = {body for pair in scene.colliding_pairs(q) for body in pair}
    links = [_HIT if body in hit else _LINK for body in scene.bodies]
    return [color if moves else _OBSTACLE for color, moves in zip(links, moving)]


def _moving(scene: Scene) -> npt.NDArray[np.bool_]:
    """Returns which bodies a motion moves: all but obstacles and links that no joint carries."""
    poses = scene.poses(scene.sample(4, seed=0))
    return np.asarray(np.ptp(poses, axis=0).max(axis=(1, 2)) > 0)


def save_rerun(scene: Scene, Q: npt.ArrayLike, path: PathLike, *, times: Any = None) -> None:
    """Writes configurations as a recording of rerun (https://rerun.io), which its viewer opens.

    Q: configurations, (n, nq), or (nq,) for one.
    path: file to write, usually `.rrd`.
    times: seconds of the configurations, (n,), from 0 on; None for ten a second.

    Bodies are at `scene/NAME`; their transforms lead to the world, as those of `scene.poses`. The timeline is `time`.

    Raises ImportError without rerun-sdk, ValueError for wrong shapes.
    """
    rr = _imported("rerun", "rerun-sdk", "rerun")
    configs, seconds = _frames(scene, Q, times)
    poses, moving = scene.poses(configs), _moving(scene)
    recording = rr.RecordingStream("extricate")
    recording.save(str(path))
    recording.log("scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    names = [f"scene/{rr.escape_entity_path_part(body)}" for body in scene.bodies]
    for name, body, color in zip(names, scene.bodies, _colors(scene, configs[0], moving)):
        vertices, triangles = scene.mesh(body)
        recording.log(name, rr.Mesh3D(vertex_positions=vertices, triangle_indices=triangles, albedo_factor=color), static=True)
    for q, second, placed in zip(configs, seconds, poses):
        recording.set_time("time", duration=float(second))
        for at, (name, color) in enumerate(zip(names, _colors(scene, q, moving))):
            recording.log(name, rr.Transform3D(translation=placed[at, :3, 3], mat3x3=placed[at, :3, :3]))
            if moving[at]:
                recording.log(f"{name}/collides", rr.Scalars(float(color is _HIT)))
    recording.disconnect()


def _quaternion(rotation: _Floats) -> Tuple[float, float, float, float]:
    """Returns a rotation matrix as a unit quaternion x, y, z, w (Bar-Itzhack, doi:10.2514/2.4654)."""
    r = rotation
    n = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], 0, 0, 0],
            [r[0, 1] + r[1, 0], r[1, 1] - r[0, 0] - r[2, 2], 0, 0],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], r[2, 2] - r[0, 0] - r[1, 1], 0],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    )
    # The eigenvector of the largest eigenvalue; `eigh` reads the lower triangle.
    x, y, z, w = np.linalg.eigh(n)[1][:, -1]
    return float(x), float(y), float(z), float(w)


def save_mcap(scene: Scene, Q: npt.ArrayLike, path: PathLike, *, times: Any = None) -> None:
    """Writes configurations as an MCAP file (https://mcap.dev), which Foxglove and ROS tools open.

    Q, times: as for `save_rerun`.
    path: file to write, usually `.mcap`; an existing one is replaced.

    `/tf` has foxglove.FrameTransforms from `world` to every body, `/scene` a foxglove.SceneUpdate of their triangles.

    Raises ImportError without foxglove-sdk, ValueError for wrong shapes.
    """
    foxglove = _imported("foxglove", "foxglove-sdk", "foxglove")
    channels, fox = importlib.import_module("foxglove.channels"), importlib.import_module("foxglove.messages")
    configs, seconds = _frames(scene, Q, times)
    poses, moving = scene.poses(configs), _moving(scene)
    context = foxglove.Context()
    transforms = channels.FrameTransformsChannel("/tf", context=context)
    updates = channels.SceneUpdateChannel("/scene", context=context)
    meshes = []
    for body in scene.bodies:
        vertices, triangles = scene.mesh(body)
        points = [fox.Point3(x=x, y=y, z=z) for x, y, z in vertices.tolist()]
        meshes.append((points, [corner for triangle in triangles.tolist() for corner in triangle]))
    drawn: List[Any] = [None] * len(meshes)
    with foxglove.open_mcap(str(path), allow_overwrite=True, context=context):
        for q, second, placed in zip(configs, seconds, poses):
            log_time = round(second * 1e9)
            stamp = fox.Timestamp(sec=log_time // 10**9, nsec=log_time % 10**9)
            tree = []
            for body, pose in zip(scene.bodies, placed):
                x, y, z, w = _quaternion(pose[:3, :3])
                tree.append(
                    fox.FrameTransform(
                        timestamp=stamp,
                        parent_frame_id="world",
                        child_frame_id=body,
                        translation=fox.Vector3(x=pose[0, 3], y=pose[1, 3], z=pose[2, 3]),
                        rotation=fox.Quaternion(x=x, y=y, z=z, w=w),
                    )
                )
            transforms.log(fox.FrameTransforms(transforms=tree), log_time=log_time)
            # A body is sent again if its colour changes.
            entities = []
            for at, color in enumerate(_colors(scene, q, moving)):
                if drawn[at] == color:
                    continue
                drawn[at] = color
                points, corners = meshes[at]
                r, g, b, a = color
                shape = fox.TriangleListPrimitive(points=points, indices=corners, color=fox.Color(r=r, g=g, b=b, a=a))
                body = scene.bodies[at]
                entities.append(
                    fox.SceneEntity(timestamp=stamp, frame_id=body, id=body, frame_locked=True, triangles=[shape])
                )
            if entities:
                updates.log(fox.SceneUpdate(entities=entities), log_time=log_time)
