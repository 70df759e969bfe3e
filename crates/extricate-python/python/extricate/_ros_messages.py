"""Reads and writes messages of ROS, as dicts, as objects and as CDR bytes. `ros` makes worlds and configurations of them."""

from __future__ import annotations

import array
import base64
import binascii
import dataclasses
import difflib
import importlib
import math
from typing import Any, Iterable, List, Mapping

import numpy as np

# Fields of messages that rosbags does not know, in the order of their bytes: those of moveit_msgs and octomap_msgs for ROS 2.
_DEFINITIONS = {
    "object_recognition_msgs/msg/ObjectType": "string key\nstring db",
    "octomap_msgs/msg/Octomap": "std_msgs/Header header\nbool binary\nstring id\nfloat64 resolution\nint8[] data",
    "octomap_msgs/msg/OctomapWithPose": "std_msgs/Header header\ngeometry_msgs/Pose origin\noctomap_msgs/Octomap octomap",
    "moveit_msgs/msg/CollisionObject": (
        "std_msgs/Header header\ngeometry_msgs/Pose pose\nstring id\nobject_recognition_msgs/ObjectType type\n"
        "shape_msgs/SolidPrimitive[] primitives\ngeometry_msgs/Pose[] primitive_poses\nshape_msgs/Mesh[] meshes\n"
        "geometry_msgs/Pose[] mesh_poses\nshape_msgs/Plane[] planes\ngeometry_msgs/Pose[] plane_poses\n"
        "string[] subframe_names\ngeometry_msgs/Pose[] subframe_poses\nbyte operation"
    ),
    "moveit_msgs/msg/AttachedCollisionObject": (
        "string link_name\nCollisionObject object\nstring[] touch_links\n"
        "trajectory_msgs/JointTrajectory detach_posture\nfloat64 weight"
    ),
    "moveit_msgs/msg/RobotState": (
        "sensor_msgs/JointState joint_state\nsensor_msgs/MultiDOFJointState multi_dof_joint_state\n"
        "AttachedCollisionObject[] attached_collision_objects\nbool is_diff"
    ),
    "moveit_msgs/msg/RobotTrajectory": (
        "trajectory_msgs/JointTrajectory joint_trajectory\n"
        "trajectory_msgs/MultiDOFJointTrajectory multi_dof_joint_trajectory"
    ),
    "moveit_msgs/msg/AllowedCollisionEntry": "bool[] enabled",
    "moveit_msgs/msg/AllowedCollisionMatrix": (
        "string[] entry_names\nAllowedCollisionEntry[] entry_values\nstring[] default_entry_names\nbool[] default_entry_values"
    ),
    "moveit_msgs/msg/LinkPadding": "string link_name\nfloat64 padding",
    "moveit_msgs/msg/LinkScale": "string link_name\nfloat64 scale",
    "moveit_msgs/msg/ObjectColor": "string id\nstd_msgs/ColorRGBA color",
    "moveit_msgs/msg/PlanningSceneWorld": "CollisionObject[] collision_objects\noctomap_msgs/OctomapWithPose octomap",
    "moveit_msgs/msg/PlanningScene": (
        "string name\nRobotState robot_state\nstring robot_model_name\n"
        "geometry_msgs/TransformStamped[] fixed_frame_transforms\n"
        "AllowedCollisionMatrix allowed_collision_matrix\nLinkPadding[] link_padding\nLinkScale[] link_scale\n"
        "ObjectColor[] object_colors\nPlanningSceneWorld world\nbool is_diff"
    ),
}
_STORES: List[Any] = []


def typestore() -> Any:
    """Returns rosbags' store of the latest ROS 2 with the messages of MoveIt and OctoMap that this module takes, to write bags.

    Raises ImportError without rosbags.
    """
    if not _STORES:
        try:
            types: Any = importlib.import_module("rosbags.typesys")
        except ImportError as error:
            raise ImportError("bytes of ROS need the package rosbags: pip install 'extricate[ros]'") from error
        store = types.get_typestore(types.Stores.LATEST)
        for name, text in _DEFINITIONS.items():
            store.register(types.get_types_from_msg(text, name))
        _STORES.append(store)
    return _STORES[0]


def from_cdr(data: Any, type: str) -> Any:
    """Returns the message that CDR bytes hold, as an object of rosbags.

    data: the bytes.
    type: type of the message, such as "moveit_msgs/msg/RobotState".

    Raises ValueError for an unknown type and bytes that do not decode, ImportError without rosbags.
    """
    store = typestore()
    _check_type(store, type)
    try:
        return store.deserialize_cdr(bytes(data), type)
    except Exception as error:
        # Bytes of another type can fail anywhere in rosbags.
        raise ValueError(f"{type}: got {len(data)} bytes that do not decode ({error}), expected CDR of this type") from error


def to_cdr(message: Any, type: str) -> bytes:
    """Returns a message as CDR bytes, to publish it or to write it into a bag.

    message: a dict by field or an object with fields as attributes; fields that are missing are 0, empty or False.
    type: type of the message, such as "sensor_msgs/msg/JointState".

    Raises ValueError for an unknown type, field or value, ImportError without rosbags.
    """
    store = typestore()
    _check_type(store, type)
    return bytes(store.serialize_cdr(_built(store, type, message, type.rpartition("/")[2]), type))


def _check_type(store: Any, type: str) -> None:
    if type not in store.fielddefs:
        near = difflib.get_close_matches(type, store.fielddefs, 3, 0.0)
        raise ValueError(f"type: got {type!r}, expected one that rosbags or this module has, such as {', '.join(near)}")


def message(given: Any, type: str) -> Any:
    """Returns a message as it is, and bytes as the message of this type that they hold."""
    if isinstance(given, (bytes, bytearray, memoryview)):
        return from_cdr(given, type)
    if given is None or isinstance(given, (str, int, float, list, tuple, np.ndarray)):
        problem = "expected a dict by field, an object with fields as attributes, or CDR bytes"
        raise TypeError(f"{type.rpartition('/')[2]}: got {given.__class__.__name__}, {problem}")
    return given


def get(message: Any, field: str) -> Any:
    """Returns a field; None if it is missing."""
    return message.get(field) if isinstance(message, Mapping) else getattr(message, field, None)


def need(message: Any, field: str, place: str) -> Any:
    """Returns a field. Errors for one that is missing name the place of the message."""
    found = get(message, field)
    if found is None:
        raise ValueError(f"{place}.{field}: missing, expected it among {', '.join(_fields(message)) or 'no fields'}")
    return found


def _fields(message: Any) -> List[str]:
    if isinstance(message, Mapping):
        return list(message)
    if hasattr(message, "get_fields_and_field_types"):
        return list(message.get_fields_and_field_types())
    if dataclasses.is_dataclass(message):
        # rosbags lists constants as well, in capitals, and `__msgtype__`.
        return [field.name for field in dataclasses.fields(message) if field.name.islower() and field.name[0] != "_"]
    return list(getattr(message, "__dict__", ()))


def plain(value: Any, skipped: Iterable[str]) -> Any:
    """Converts a message to what JSON can hold, without fields of the names `skipped`. Bytes become base64, and numbers that are
    not finite become their text, which the reader refuses with the name of the field."""
    if value is None or isinstance(value, (str, bool, int)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, np.generic):
        return plain(value.item(), skipped)
    if isinstance(value, (bytes, bytearray, memoryview)):
        # rclpy gives a byte as bytes.
        return value[0] if len(value) == 1 else base64.b64encode(value).decode()
    if isinstance(value, array.array):
        value = np.asarray(value)
    if isinstance(value, np.ndarray):
        is_bytes = value.dtype.kind in "iu" and value.dtype.itemsize == 1
        return base64.b64encode(value.tobytes()).decode() if is_bytes else plain(value.tolist(), skipped)
    if isinstance(value, Iterable) and not isinstance(value, Mapping):
        return [plain(element, skipped) for element in value]
    return {field: plain(get(value, field), skipped) for field in _fields(value) if field not in skipped}


def octets(value: Any, place: str) -> bytes:
    """Returns a field of bytes, signed or not: an array, a list of numbers, or text in base64, as rosbridge writes it."""
    try:
        if isinstance(value, str):
            return base64.b64decode(value, validate=True)
        if isinstance(value, (bytes, bytearray, memoryview)):
            return bytes(value)
        numbers = np.asarray(value)
        if numbers.size == 0:
            return b""
        if numbers.ndim == 1 and numbers.dtype.kind in "iu" and numbers.min() >= -128 and numbers.max() < 256:
            return bytes(numbers.astype(np.uint8).tobytes())
    except binascii.Error:
        pass
    raise ValueError(f"{place}: got {str(value)[:40]!r}, expected bytes: whole numbers from -128 to 255, or text in base64")


def _built(store: Any, type: str, message: Any, place: str) -> Any:
    """Makes an object of rosbags of a dict or an object; what is missing is 0, empty or False."""
    fields = dict(store.fielddefs[type][1])
    unknown = [field for field in _fields(message) if field not in fields]
    if unknown:
        raise ValueError(f"{place}: got the field {unknown[0]!r}, expected some of {', '.join(fields)}")
    parts = {field: _part(store, kind, get(message, field), f"{place}.{field}") for field, kind in fields.items()}
    return store.types[type](**parts)


def _part(store: Any, kind: Any, value: Any, place: str) -> Any:
    form, inner = kind
    if form.name == "NAME":
        return _built(store, inner, {} if value is None else value, place)
    if form.name == "BASE":
        try:
            return str(value or "") if inner[0] == "string" else np.dtype(_number(inner[0])).type(value or 0).item()
        except (TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"{place}: got {value!r}, expected {inner[0]}") from error
    (of, name), count = inner
    if of.name == "BASE" and name[0] != "string":
        kind = np.dtype(_number(name[0]))
        if value is None:
            return np.zeros(count if form.name == "ARRAY" else 0, kind)
        if kind.itemsize == 1 and kind.kind != "b":
            return np.frombuffer(octets(value, place), kind)
        try:
            return np.asarray(value, kind)
        except (TypeError, ValueError, OverflowError) as error:
            raise ValueError(f"{place}: got {str(value)[:40]}, expected a list of {name[0]}") from error
    return [_part(store, (of, name), element, f"{place}[{at}]") for at, element in enumerate(() if value is None else value)]


def _number(name: str) -> str:
    return {"byte": "uint8", "octet": "uint8", "char": "uint8"}.get(name, name)
