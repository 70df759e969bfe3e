"""Worlds, configurations and paths from messages of ROS, and back. ROS need not be installed.

    world = extricate.ros.planning_scene(scene, message)                    # obstacles, attached objects, octomap
    answer = world.query(extricate.ros.state(world, joint_state))
    extricate.ros.joint_state(world, answer.witness)                        # a JointState as a dict

A message is a dict by field (rosbridge, YAML), an object with fields as attributes (rclpy, rosbags), or CDR bytes as bags and
topics hold them. Bytes need the package rosbags: `pip install 'extricate[ros]'`. Positions are in rad or m, times in s. Errors
name message, field, value and what was expected.
"""

from __future__ import annotations

import json
import math
import warnings
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from ._extricate import Scene, _octree_cells, _pose_matrix
from ._parts import Points, Voxels
from ._ros_messages import from_cdr, get, need, octets, plain, to_cdr, typestore
from ._ros_messages import message as message_of

__all__ = [
    "cloud",
    "from_cdr",
    "joint_state",
    "joint_trajectory",
    "octomap",
    "planning_scene",
    "state",
    "to_cdr",
    "trajectory",
    "typestore",
]

_Floats = npt.NDArray[np.float64]
# Fields of a PlanningScene that describe no world, and are long.
_NO_WORLD = {"joint_state", "multi_dof_joint_state", "detach_posture"}
# NumPy's types by the codes of a PointField.
_POINT_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}


def planning_scene(scene: Scene, message: Any) -> Scene:
    """Returns the robots of a scene in the world of a message, as `Scene.in_world` does for a file.

    message: a moveit_msgs/PlanningScene, a PlanningSceneWorld or the answer of GetPlanningScene; as bytes a PlanningScene. Its
        collision objects and its octomap (`<octomap>`) replace the scene's obstacles. Attached objects, allowed collisions and
        padding are added. `state` has the positions of its joints. A UserWarning names what else is not used.

    Raises ValueError for what cannot be used in it.
    """
    message = message_of(message, "moveit_msgs/msg/PlanningScene")
    return scene._in_world_text("PlanningScene.json", json.dumps(plain(message, _NO_WORLD)))


def state(scene: Scene, message: Any) -> _Floats:
    """Returns the configuration of a message, (nq,): `q` of a query. It may be beyond the limits, as a sensor may report it.

    message: a sensor_msgs/JointState, or a message with one: a RobotState, PlanningScene or request of MoveIt; as bytes a
        JointState. A RobotState also places a planar or floating joint, by its name or if it has only one. A UserWarning names
        joints that the scene does not have; they are left out.

    Raises ValueError for joints of the scene that are missing, and for values that are not finite.
    """
    robot = message_of(message, "sensor_msgs/msg/JointState")
    for wrapper in ("scene", "robot_state", "start_state"):
        robot = robot if get(robot, wrapper) is None else get(robot, wrapper)
    joints = robot if get(robot, "joint_state") is None else get(robot, "joint_state")
    names = list(need(joints, "name", "JointState"))
    values = _row(need(joints, "position", "JointState"), names, "JointState.position")
    positions: Dict[str, Any] = {names[at]: values[at] for at in _known(scene, names, "JointState.name")}
    multi = get(robot, "multi_dof_joint_state")
    if multi is not None:
        positions.update(_bases(scene, multi))
    return scene._config_anywhere(positions)


def trajectory(scene: Scene, message: Any, *, start: Optional[npt.ArrayLike] = None) -> Tuple[_Floats, _Floats]:
    """Returns configurations (n, nq) and times (n,) [s] of a message: its points, and when they are due after its start.

    message: a trajectory_msgs/JointTrajectory, or a RobotTrajectory of MoveIt; as bytes a JointTrajectory. A UserWarning names
        joints that the scene does not have; they are left out.
    start: configuration (nq,) with the positions of joints that the message does not name; None if it names all.

    Raises ValueError for joints that are missing, and for values that are not finite.
    """
    message = message_of(message, "trajectory_msgs/msg/JointTrajectory")
    inner = message if get(message, "joint_trajectory") is None else get(message, "joint_trajectory")
    names = list(need(inner, "joint_names", "JointTrajectory"))
    columns = _known(scene, names, "JointTrajectory.joint_names")
    resting = {} if start is None else scene.positions(start)
    resting = {joint.name: resting[joint.name] for joint in scene.joints if joint.name in resting}
    points = list(need(inner, "points", "JointTrajectory"))
    rows, times = np.empty((len(points), scene.nq)), np.empty(len(points))
    for at, point in enumerate(points):
        place = f"JointTrajectory.points[{at}]"
        values = _row(need(point, "positions", place), names, f"{place}.positions")
        rows[at] = scene._config_anywhere({**resting, **{names[k]: values[k] for k in columns}})
        due, place = need(point, "time_from_start", place), f"{place}.time_from_start"
        times[at] = _whole(due, "sec", place) + 1e-9 * _whole(due, "nanosec", place)
    return rows, times


def cloud(message: Any, pose: Any, *, radius: float = 0.0, name: Optional[str] = None) -> Points:
    """Returns the finite points of a message as one obstacle. Its `xyz` are in the world, as `Scene.robot_filter` takes them.

    message: a sensor_msgs/PointCloud2 with fields x, y and z [m], of any type, order and byte order.
    pose: pose of the message's frame in the scene's world: a Transform, TransformStamped, Pose or PoseStamped, or as in
        `Points`. None: its frame is the world.
    radius: radius of the ball around every point [m].
    name: name of the obstacle; None takes "points1" and so on.

    Raises ValueError for a field that is missing and for data shorter than its size.
    """
    message = message_of(message, "sensor_msgs/msg/PointCloud2")
    height, width, step, row = (_whole(message, key, "PointCloud2") for key in ("height", "width", "point_step", "row_step"))
    data = octets(need(message, "data", "PointCloud2"), "PointCloud2.data")
    needed = (height - 1) * row + width * step if height > 0 and width > 0 else 0
    if min(height, width, step, row) < 0 or len(data) < needed:
        size = f"{height} x {width} points of {step} bytes"
        raise ValueError(f"PointCloud2.data: got {len(data)} bytes, expected {needed}: {size}")
    fields = {get(field, "name"): field for field in need(message, "fields", "PointCloud2")}
    order = ">" if need(message, "is_bigendian", "PointCloud2") else "<"
    columns = []
    for axis in "xyz":
        if axis not in fields:
            raise ValueError(f"PointCloud2.fields: got {', '.join(map(str, fields)) or 'none'}, expected x, y and z")
        code, offset = (_whole(fields[axis], key, f"PointCloud2.fields.{axis}") for key in ("datatype", "offset"))
        if code not in _POINT_TYPES:
            raise ValueError(f"PointCloud2.fields.{axis}.datatype: got {code}, expected 1 to 8")
        kind = np.dtype(order + _POINT_TYPES[code])
        if not 0 <= offset <= step - kind.itemsize:
            raise ValueError(f"PointCloud2.fields.{axis}.offset: got {offset}, expected 0 to {step - kind.itemsize}")
        found = np.ndarray((height, width), kind, data, offset, (row, step)) if needed else np.empty(0)
        columns.append(found.astype(np.float64).ravel())
    points = np.stack(columns, axis=1)
    matrix = _matrix(pose)
    points = points[np.isfinite(points).all(axis=1)] @ matrix[:3, :3].T + matrix[:3, 3]
    return Points(points, radius, name=name)


def octomap(message: Any, pose: Any, *, name: Optional[str] = None) -> Voxels:
    """Returns the occupied leaves of a message as one obstacle, large ones cut to cells of the finest size.

    message: an octomap_msgs/Octomap, binary or full, of the kind OcTree or ColorOcTree. A leaf of a full one is occupied from
        even odds on.
    pose: pose of the message's frame in the scene's world, as in `cloud`.
    name: name of the obstacle; None takes "voxels1" and so on.

    Raises ValueError for bytes that are not one tree, and for more than 16 million cells.
    """
    message = message_of(message, "octomap_msgs/msg/Octomap")
    binary, kind, size, data = (need(message, key, "Octomap") for key in ("binary", "id", "resolution", "data"))
    cells = _octree_cells("Octomap", kind, bool(binary), size, octets(data, "Octomap.data"))
    return Voxels(cells, size, _matrix(pose), name)


def joint_state(scene: Scene, q: npt.ArrayLike) -> Dict[str, Any]:
    """Returns a configuration as a sensor_msgs/JointState: a dict by field, for all joints of one coordinate, also mimic and
    locked ones. `{"joint_state": .., "is_diff": True}` is a RobotState that keeps attached objects.

    q: configuration (nq,); it may be beyond the limits.

    Raises ValueError for a wrong shape and values that are not finite.
    """
    positions = {name: value for name, value in scene.positions(q).items() if isinstance(value, float)}
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    return {"header": header, "name": list(positions), "position": list(positions.values()), "velocity": [], "effort": []}


def joint_trajectory(scene: Scene, points: npt.ArrayLike, times: Optional[npt.ArrayLike] = None) -> Dict[str, Any]:
    """Returns configurations as a trajectory_msgs/JointTrajectory: a dict by field, for the joints of one coordinate that move
    by themselves. Continuous joints turn on beyond pi instead of jumping back.

    points: configurations (n, nq), such as those of a `Plan`.
    times: when each is due after the start, ascending (n,) [s]; None leaves all at 0, for a path without times.

    Raises ValueError for wrong shapes, values that are not finite, and times that do not ascend.
    """
    rows = np.asarray(points, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != scene.nq:
        raise ValueError(f"points: got shape {rows.shape}, expected (n, {scene.nq})")
    due = np.zeros(len(rows)) if times is None else np.asarray(times, dtype=np.float64)
    if due.shape != (len(rows),):
        raise ValueError(f"times: got shape {due.shape}, expected ({len(rows)},)")
    if not (np.isfinite(rows).all() and np.isfinite(due).all() and (due >= 0).all() and (np.diff(due) >= 0).all()):
        raise ValueError("points, times: expected finite numbers, and times from 0 that ascend")
    joints = [joint for joint in scene.joints if joint.stop - joint.start == 1]
    # A continuous joint that another one follows does not wrap.
    wraps = scene._config_anywhere({**_rest(scene), **{joint.name: 4.0 for joint in joints}}) < 0
    columns = [np.unwrap(rows[:, j.start]) if wraps[j.start] else rows[:, j.start] for j in joints]
    header = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    rest: Dict[str, Any] = {"velocities": [], "accelerations": [], "effort": []}
    found = []
    for at, time in enumerate(due):
        sec, nanosec = divmod(round(float(time) * 1e9), 10**9)
        positions = [float(column[at]) for column in columns]
        found.append({"positions": positions, **rest, "time_from_start": {"sec": sec, "nanosec": nanosec}})
    return {"header": header, "joint_names": [joint.name for joint in joints], "points": found}


def _rest(scene: Scene) -> Dict[str, List[float]]:
    """Returns positions of all joints with coordinates: zeros, and no rotation."""
    sizes = {joint.name: (joint.stop - joint.start, joint.kind in ("floating", "spherical")) for joint in scene.joints}
    return {name: [0.0] * (size - 1) + [float(turns)] for name, (size, turns) in sizes.items()}


def _known(scene: Scene, names: Sequence[str], place: str) -> List[int]:
    """Returns the indices of names that joints of the scene have, after a warning with the others."""
    has = scene.positions(scene._config_anywhere(_rest(scene)))
    others = [name for name in names if name not in has]
    if others:
        warnings.warn(f"{place}: the scene has no joint {', '.join(others)}: left out", UserWarning, stacklevel=3)
    twice = [name for name in names if list(names).count(name) > 1]
    if twice:
        raise ValueError(f"{place}: got {twice[0]!r} twice, expected every joint once")
    return [at for at, name in enumerate(names) if name in has]


def _row(values: Any, names: Sequence[str], place: str) -> _Floats:
    try:
        row = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{place}: got {str(values)[:40]}, expected numbers") from error
    if row.shape != (len(names),):
        raise ValueError(f"{place}: got {row.size} numbers, expected {len(names)}, one for each name")
    return row


def _whole(message: Any, field: str, place: str) -> int:
    value = need(message, field, place)
    if not isinstance(value, (int, np.integer)):
        raise ValueError(f"{place}.{field}: got {value!r}, expected a whole number")
    return int(value)


def _bases(scene: Scene, multi: Any) -> Dict[str, List[float]]:
    """Returns the positions of planar and floating joints of a MultiDOFJointState."""
    moving = {joint.name: joint for joint in scene.joints if joint.kind in ("planar", "floating")}
    names, transforms = get(multi, "joint_names") or [], get(multi, "transforms") or []
    if len(names) != len(transforms):
        raise ValueError(f"multi_dof_joint_state: got {len(names)} names and {len(transforms)} transforms, expected as many")
    found: Dict[str, List[float]] = {}
    for name, transform in zip(names, transforms):
        # MoveIt names the base by its SRDF.
        joint = next(iter(moving.values())) if len(moving) == len(names) == 1 else moving.get(name)
        if joint is None:
            text = f"multi_dof_joint_state: the scene has no planar or floating joint {name}: left out"
            warnings.warn(text, UserWarning, stacklevel=3)
            continue
        given = _from_message(transform)
        (x, y, z), turn = given["xyz"], given["quat_xyzw"]
        if joint.kind == "planar" and max(abs(turn[0]), abs(turn[1])) > 1e-3:
            raise ValueError(f"multi_dof_joint_state: {name}: got the rotation {turn}, expected one about z")
        found[joint.name] = [x, y, z, *turn] if joint.kind == "floating" else [x, y, 2 * math.atan2(turn[2], turn[3])]
    return found


def _from_message(pose: Any) -> Any:
    """Returns a Pose or Transform, stamped or not, as in a scene file; poses in other forms as they are."""
    for wrapper in ("transform", "pose"):
        pose = pose if get(pose, wrapper) is None else get(pose, wrapper)
    for place, turn in (("translation", "rotation"), ("position", "orientation")):
        if get(pose, place) is not None:
            xyz = [float(need(get(pose, place), axis, place)) for axis in "xyz"]
            quaternion = [float(need(need(pose, turn, "pose"), axis, turn)) for axis in "xyzw"]
            # Quaternions that nobody has set are zeros; MoveIt takes them for no rotation.
            return {"xyz": xyz, "quat_xyzw": quaternion if any(quaternion) else [0.0, 0.0, 0.0, 1.0]}
    return pose


def _matrix(pose: Any) -> _Floats:
    return _pose_matrix(_from_message(pose))
