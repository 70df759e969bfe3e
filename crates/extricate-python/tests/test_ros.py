"""Messages of ROS as dicts, objects and bytes: worlds, configurations, clouds, maps and paths."""

import array
import base64
import itertools
import json
import pathlib
import sys
import types
from typing import Any, Dict, List, Set, Tuple

import numpy as np
import pytest

import extricate
from extricate import Robot, Scene, _ros_messages, ros

pytest.importorskip("rosbags")
SCENE, JOINTS = "moveit_msgs/msg/PlanningScene", "sensor_msgs/msg/JointState"
WALL: Set[Tuple[int, ...]] = {(5, j, k) for j in range(-8, 8) for k in range(4, 12)} | set(itertools.product((-6, -5), (0, 1), (4, 5)))
# A continuous joint, one that another follows, so that it does not wrap, and the follower.
WHEEL = """<robot name="wheel"><link name="base"/>
<link name="rim"><collision><geometry><box size="0.1 0.2 0.3"/></geometry></collision></link><link name="hub"/><link name="cap"/>
<joint name="turn" type="continuous"><parent link="base"/><child link="rim"/><axis xyz="0 0 1"/></joint>
<joint name="led" type="continuous"><parent link="base"/><child link="cap"/><axis xyz="0 0 1"/></joint>
<joint name="half" type="revolute"><parent link="base"/><child link="hub"/><axis xyz="0 0 1"/>
<mimic joint="led" multiplier="0.5"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


def tree(cells: Set[Tuple[int, ...]], full: bool, colour: bytes = b"") -> bytes:
    """Writes an octree of OctoMap that is occupied at these cells; eight siblings become one leaf."""

    def inner(corner: Tuple[int, ...], side: int, inside: Set[Tuple[int, ...]]) -> Tuple[int, bytes]:
        """Returns the two bits of a node, and the bytes of what is below it."""
        if len(inside) in (0, side**3):
            return (2 if inside else 0), np.float32(1).tobytes() + colour + b"\0" if full else b""
        half, bits, below = side // 2, 0, b""
        for number in range(8):
            low = tuple(x + half * (number >> axis & 1) for axis, x in enumerate(corner))
            part = {cell for cell in inside if all(x <= y < x + half for x, y in zip(low, cell))}
            kind, data = inner(low, half, part)
            bits |= (int(kind > 0) << number) if full else (kind << 2 * number)
            below += data if kind else b""
        head = np.float32(1).tobytes() + colour + bytes([bits]) if full else bits.to_bytes(2, "little")
        return 3, head + below

    return inner((-(2**15),) * 3, 2**16, cells)[1]


def pose(x: float, y: float, z: float, w: float = 1.0) -> Dict[str, Any]:
    return {"position": {"x": x, "y": y, "z": z}, "orientation": {"x": 0.0, "y": 0.0, "z": (1 - w * w) ** 0.5, "w": w}}


def solid(name: str, kind: int, sizes: List[float], at: Dict[str, Any], frame: str = "world") -> Dict[str, Any]:
    primitive = {"type": kind, "dimensions": sizes}
    header, own = {"frame_id": frame}, pose(0, 0, 0)
    return {"id": name, "header": header, "pose": at, "primitives": [primitive], "primitive_poses": [own]}


def map_of(data: Any, binary: bool = True, kind: str = "OcTree") -> Dict[str, Any]:
    return {"binary": binary, "id": kind, "resolution": 0.1, "data": data}


@pytest.fixture
def message() -> Dict[str, Any]:
    """A planning scene as in MoveIt's tutorials: a table, a box, a cylinder, a can in the gripper, a map."""
    can = solid("can", 3, [0.12, 0.03], pose(0, 0, 0.15), "gripper")
    signed = [byte - 256 if byte > 127 else byte for byte in tree(WALL, False)]
    return {
        "name": "tutorial",
        "robot_state": {
            "joint_state": {"name": ["joint_1"], "position": [0.3]},
            "attached_collision_objects": [{"link_name": "gripper", "touch_links": ["gripper", "link_7"], "object": can}],
        },
        "allowed_collision_matrix": {
            "entry_names": ["link_7", "box", "<octomap>"],
            "entry_values": [{"enabled": row} for row in ([0, 1, 1], [1, 0, 0], [1, 0, 0])],
        },
        "link_padding": [{"link_name": "link_6", "padding": 0.01}],
        "world": {
            "collision_objects": [
                solid("table", 1, [0.5, 1.0, 0.05], pose(0.5, 0, 0.2)),
                solid("box", 1, [0.1, 0.1, 0.3], pose(0.4, 0.3, 0.4, 0.8)),
                solid("cylinder", 3, [0.4, 0.05], pose(0.3, -0.3, 0.4)),
            ],
            "octomap": {"header": {"frame_id": "world"}, "origin": pose(0.1, 0, 0), "octomap": map_of(signed)},
        },
    }


# The same as a scene file.
BY_HAND = """padding = { link_6 = 0.01 }
[[obstacle]]
name = "table"
shape = { box = [0.5, 1.0, 0.05] }
pose = { xyz = [0.5, 0, 0.2] }
[[obstacle]]
name = "box"
shape = { box = [0.1, 0.1, 0.3] }
pose = { xyz = [0.4, 0.3, 0.4], quat_xyzw = [0, 0, 0.6, 0.8] }
[[obstacle]]
name = "cylinder"
shape = { cylinder = [0.05, 0.4] }
pose = { xyz = [0.3, -0.3, 0.4] }
[[obstacle]]
name = "<octomap>"
shape = { voxels = CELLS, size = 0.1 }
pose = { xyz = [0.1, 0, 0] }
[[attached]]
name = "can"
link = "gripper"
touch = ["link_7"]
shape = { cylinder = [0.03, 0.12] }
pose = { xyz = [0, 0, 0.15] }
[pairs]
disable = [["link_7", "box"], ["link_7", "<octomap>"]]
""".replace("CELLS", str([list(cell) for cell in sorted(WALL)]))


def as_objects(value: Any) -> Any:
    """Converts a dict to objects with attributes, as rclpy has them: bytes as array.array."""
    if isinstance(value, dict):
        return types.SimpleNamespace(**{key: as_objects(part) for key, part in value.items()})
    if isinstance(value, list) and len(value) > 50:
        return array.array("b" if min(value) < 0 else "B", value)
    return [as_objects(part) for part in value] if isinstance(value, list) else value


def test_a_bag_is_one_call_from_an_answer(arm: Scene, message: Dict[str, Any], tmp_path: pathlib.Path) -> None:
    from rosbags.rosbag2 import Reader, Writer

    start = arm.sample(1, seed=3)[0]
    with Writer(tmp_path / "bag", version=9) as writer:
        for topic, kind, part in [("/scene", SCENE, message), ("/joints", JOINTS, ros.joint_state(arm, start))]:
            connection = writer.add_connection(topic, kind, typestore=ros.typestore())
            writer.write(connection, 0, ros.to_cdr(part, kind))
    with Reader(tmp_path / "bag") as reader:
        held = {connection.topic: data for connection, _, data in reader.messages()}
    world = ros.planning_scene(arm, held["/scene"])
    q = ros.state(world, held["/joints"])
    assert q == pytest.approx(start, abs=1e-15)
    (tmp_path / "world.toml").write_text(BY_HAND)
    by_hand = arm.in_world(tmp_path / "world.toml")
    assert world.bodies[-5:] == ["table", "box", "cylinder", "<octomap>", "can"] and world.pairs == by_hand.pairs
    Q = world.sample(300, seed=1)
    assert world.distances(Q) == pytest.approx(by_hand.distances(Q), abs=1e-12)
    colliding = Q[~world.check(Q)]
    hit = {name for at in colliding for pair in world.colliding_pairs(at) for name in pair}
    assert {"<octomap>", "can", "table"} <= hit
    answer = world.query(colliding[0])
    assert answer is not None and answer.verified and by_hand.check(answer.witness)
    written = ros.from_cdr(ros.to_cdr(ros.joint_state(world, answer.witness), JOINTS), JOINTS)
    assert ros.state(world, written) == pytest.approx(answer.witness, abs=1e-15)
    # The whole state stands in a planning scene too.
    message["robot_state"]["joint_state"] = ros.joint_state(arm, q)
    assert (ros.state(world, ros.from_cdr(ros.to_cdr(message, SCENE), SCENE)) == q).all()


def test_dicts_objects_and_bytes_are_the_same_world(arm: Scene, message: Dict[str, Any]) -> None:
    data = ros.to_cdr(message, SCENE)
    worlds = [ros.planning_scene(arm, given) for given in (message, as_objects(message), data, ros.from_cdr(data, SCENE))]
    message["world"]["octomap"]["octomap"]["data"] = base64.b64encode(tree(WALL, False)).decode()  # as rosbridge writes bytes
    worlds.append(ros.planning_scene(arm, json.loads(json.dumps({"scene": message}))))
    Q = worlds[0].sample(100, seed=1)
    for world in worlds[1:]:
        assert world.pairs == worlds[0].pairs and (world.distances(Q) == worlds[0].distances(Q)).all()


def test_a_message_with_an_octomap_is_written_as_a_scene_file(arm: Scene, message: Dict[str, Any], tmp_path: pathlib.Path) -> None:
    del message["robot_state"]["joint_state"]
    (tmp_path / "scene.json").write_text(json.dumps(message))
    written = extricate.import_world(tmp_path / "scene.json", tmp_path / "world.toml", robot=arm)
    assert written == [tmp_path / "world.toml", tmp_path / "world-meshes" / "_octomap_.csv"]
    world, again = ros.planning_scene(arm, message), arm.in_world(written[0])
    Q = world.sample(100, seed=1)
    assert again.pairs == world.pairs and (again.distances(Q) == world.distances(Q)).all()


def test_faults_of_a_planning_scene_name_the_field(arm: Scene, message: Dict[str, Any]) -> None:
    box = message["world"]["collision_objects"][1]
    box["pose"]["position"]["x"] = np.float64("nan")
    with pytest.raises(ValueError, match=r'PlanningScene.json: collision object "box".pose.position.x: got "nan"'):
        ros.planning_scene(arm, message)
    box["pose"]["position"]["x"] = 0.4
    message["world"]["octomap"]["octomap"]["data"] = array.array("b", tree(WALL, False)[:-1])
    with pytest.raises(ValueError, match=r"world.octomap.octomap.data: got \d+ bytes, expected a node of 2 bytes"):
        ros.planning_scene(arm, message)
    for given in (None, 3, "scene", [1]):
        with pytest.raises(TypeError, match=f"PlanningScene: got {type(given).__name__}, expected a dict by field"):
            ros.planning_scene(arm, given)


@pytest.mark.parametrize(("kind", "binary"), [("OcTree", True), ("OcTree", False), ("ColorOcTree", False)])
def test_octomaps_binary_and_full(kind: str, binary: bool) -> None:
    colour = b"rgb" if kind == "ColorOcTree" else b""
    data = tree(WALL, not binary, colour)
    for given in (data, np.frombuffer(data, np.int8), list(data), base64.b64encode(data).decode()):
        voxels = ros.octomap(map_of(given, binary, kind), [1, 0, 0], name="map")
        assert {tuple(cell) for cell in np.asarray(voxels.occupied).tolist()} == WALL
        assert (voxels.size, voxels.name) == (0.1, "map") and np.asarray(voxels.pose)[0, 3] == 1
    held = ros.octomap(ros.to_cdr(map_of(data, binary, kind), "octomap_msgs/msg/Octomap"), None)
    assert len(np.asarray(held.occupied)) == len(WALL)


@pytest.mark.parametrize(("change", "expected"), [
    ({"id": "Tree"}, "Octomap.id: got `Tree`, expected OcTree or ColorOcTree"),
    ({"data": [0, 0]}, "Octomap.data: got 281474976710656 corners, points or cells or more, expected at most"),
    ({"data": [300]}, r"Octomap.data: got '\[300\]', expected bytes"),
    ({"data": "?"}, "Octomap.data: got '\\?', expected bytes"),
    ({"resolution": 0.0}, "Octomap.resolution: size: got 0.0"),
    ({"resolution": None}, "Octomap.resolution: missing, expected it among binary, id"),
])
def test_faults_of_octomaps(change: Dict[str, Any], expected: str) -> None:
    with pytest.raises(ValueError, match=expected):
        ros.octomap({**map_of(tree(WALL, False)), **change}, None)


def cloud_of(points: Any, code: int, order: str, bigendian: bool, height: int = 1) -> Dict[str, Any]:
    """Returns a PointCloud2 with other fields around x, y and z, and bytes after each row."""
    kind = (">" if bigendian else "<") + {7: "f4", 8: "f8", 3: "i2"}[code]
    size, fields = np.dtype(kind).itemsize, []
    step, width = 3 * size + 7, len(points) // height
    row = step * width + 5
    data = np.zeros(row * height, np.uint8)
    for at, axis in enumerate(order):
        offset = 4 + at * size
        fields.append({"name": axis, "offset": offset, "datatype": code, "count": 1})
        column = np.ascontiguousarray(points[:, "xyz".index(axis)], kind).view(np.uint8).reshape(height, width, size)
        np.ndarray((height, width, size), np.uint8, data, offset, (row, step, 1))[:] = column
    fields.insert(1, {"name": "rgb", "offset": 0, "datatype": 6, "count": 1})
    return {"height": height, "width": width, "fields": fields, "is_bigendian": bigendian, "point_step": step, "row_step": row,
            "data": data, "is_dense": False}


@pytest.mark.parametrize("bigendian", [False, True])
@pytest.mark.parametrize(("code", "order", "height"), [(7, "xyz", 1), (8, "zxy", 2), (3, "yzx", 3)])
def test_clouds_of_any_layout(code: int, order: str, height: int, bigendian: bool) -> None:
    points = np.array([[1.0, 2, 3], [4, 5, 6], [-7, 8, 9], [10, 11, 12], [13, 14, 15], [16, 17, 18]])
    kept = points
    if code != 3:
        points = points.copy()
        points[1, 2], points[4, 0] = np.nan, np.inf
        kept = points[[0, 2, 3, 5]]
    message = cloud_of(points, code, order, bigendian, height)
    turn = {"translation": {"x": 0.5, "y": 0, "z": 0}, "rotation": {"x": 0, "y": 0, "z": 1, "w": 0}}
    listed = {**message, "data": message["data"].tolist()}
    for given in (message, listed, as_objects(listed), ros.to_cdr(message, "sensor_msgs/msg/PointCloud2")):
        assert (ros.cloud(given, None).xyz == kept).all()
        for place in (turn, types.SimpleNamespace(transform=turn), {"xyz": [0.5, 0, 0], "quat_xyzw": [0, 0, 1, 0]}):
            seen = ros.cloud(given, place, radius=0.02, name="seen")
            assert seen.xyz == pytest.approx(kept * [-1, -1, 1] + [0.5, 0, 0]) and (seen.radius, seen.name) == (0.02, "seen")


@pytest.mark.parametrize(("change", "expected"), [
    ({"data": b"12345"}, "PointCloud2.data: got 5 bytes, expected 57: 1 x 3 points of 19 bytes"),
    ({"fields": []}, "PointCloud2.fields: got none, expected x, y and z"),
    ({"fields": [{"name": "x", "offset": 0, "datatype": 9}]}, "PointCloud2.fields.x.datatype: got 9, expected 1 to 8"),
    ({"fields": [{"name": "x", "offset": 17, "datatype": 7}]}, "PointCloud2.fields.x.offset: got 17, expected 0 to 15"),
    ({"width": "3"}, "PointCloud2.width: got '3', expected a whole number"),
    ({"height": None}, "PointCloud2.height: missing, expected it among height, width"),
])
def test_faults_of_clouds(change: Dict[str, Any], expected: str) -> None:
    message = cloud_of(np.zeros((3, 3)), 7, "xyz", False)
    assert len(np.asarray(ros.cloud({**message, "width": 0, "data": b""}, None).xyz)) == 0
    with pytest.raises(ValueError, match=expected):
        ros.cloud({**message, **change}, None)


def test_states_of_more_and_fewer_joints(arm: Scene) -> None:
    q = arm.sample(1, seed=4)[0]
    q[3] = arm.upper[3] + 1e-3  # an encoder reads beyond the limit
    message = ros.joint_state(arm, q)
    assert message["name"][0] == "joint_1" and message["velocity"] == []
    shuffled = {"name": message["name"][::-1], "position": message["position"][::-1]}
    assert (ros.state(arm, {"joint_state": types.SimpleNamespace(**shuffled)}) == q).all()
    more = {"name": [*message["name"], "finger"], "position": [*message["position"], 0.5]}
    with pytest.warns(UserWarning, match="JointState.name: the scene has no joint finger: left out"):
        assert (ros.state(arm, more) == q).all()
    for wrong, expected in [
        ({"name": ["joint_1"], "position": [0.1]}, "joint_2"),
        ({**more, "position": [0.1]}, "JointState.position: got 1 numbers, expected 8, one for each name"),
        ({**message, "position": ["a"] * 7}, r"JointState.position: got \['a', .*, expected numbers"),
        ({"name": message["name"]}, "JointState.position: missing, expected it among name"),
        ({**message, "name": ["joint_1", *message["name"][:-1]]}, "JointState.name: got 'joint_1' twice"),
        ({**message, "position": [np.nan, *message["position"][1:]]}, "NaN"),
    ]:
        with pytest.raises(ValueError, match=expected):
            ros.state(arm, wrong)


@pytest.mark.filterwarnings("ignore:joint `led`", "ignore:no pair of bodies")
@pytest.mark.parametrize("base", ["planar", "floating"])
def test_a_moving_base_is_placed_by_its_transform(base: str) -> None:
    size = 2 if base == "planar" else 3
    scene = Scene(Robot(WHEEL, base=base, bounds=([-5] * size, [5] * size)))
    turn = {"translation": {"x": 1.0, "y": 2.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}}
    message = {
        "joint_state": {"name": ["led", "turn"], "position": [0.2, 0.3]},
        "multi_dof_joint_state": {"joint_names": ["world_joint"], "transforms": [turn]},
    }
    expected = [1, 2, 2 * np.arctan2(0.6, 0.8)] if base == "planar" else [1, 2, 0, 0, 0, 0.6, 0.8]
    for given in (message, ros.from_cdr(ros.to_cdr(message, "moveit_msgs/msg/RobotState"), "moveit_msgs/msg/RobotState")):
        q = ros.state(scene, given)
        assert q[:-2] == pytest.approx(expected)
        assert [scene.positions(q)[name] for name in ("turn", "led", "half")] == pytest.approx([0.3, 0.2, 0.1])
    assert set(ros.joint_state(scene, q)["name"]) == {"turn", "led", "half"}
    with pytest.warns(UserWarning, match="no planar or floating joint world_joint: left out"):
        assert sorted(ros.state(Scene(WHEEL), message)) == pytest.approx([0.2, 0.3])
    if base == "planar":
        turn["rotation"] = {"x": 0.6, "y": 0.0, "z": 0.0, "w": 0.8}
        with pytest.raises(ValueError, match=r"world_joint: got the rotation \[0.6, 0.0, 0.0, 0.8\], expected one about z"):
            ros.state(scene, message)


def test_trajectories_there_and_back(arm: Scene) -> None:
    rows, times = arm.sample(5, seed=6), np.array([0.0, 0.5, 1.25, 2.000000001, 3.0])
    message = ros.joint_trajectory(arm, rows, times)
    assert message["points"][3]["time_from_start"] == {"sec": 2, "nanosec": 1}
    held = ros.to_cdr({"joint_trajectory": message}, "moveit_msgs/msg/RobotTrajectory")
    kind = "trajectory_msgs/msg/JointTrajectory"
    for given in (message, ros.to_cdr(message, kind), ros.from_cdr(held, "moveit_msgs/msg/RobotTrajectory")):
        again, due = ros.trajectory(arm, given)
        assert (again == rows).all() and due == pytest.approx(times, abs=1e-12)
    # A group moves, and the rest stays.
    few = [{**point, "positions": point["positions"][:2]} for point in message["points"]]
    part = {"joint_names": message["joint_names"][:2], "points": few}
    again, _ = ros.trajectory(arm, part, start=rows[0])
    assert (again[:, :2] == rows[:, :2]).all() and (again[:, 2:] == rows[0, 2:]).all()
    with pytest.raises(ValueError, match="joint_3"):
        ros.trajectory(arm, part)
    message["points"][1]["positions"] = [0.0]
    with pytest.raises(ValueError, match=r"JointTrajectory.points\[1\].positions: got 1 numbers, expected 7, one for"):
        ros.trajectory(arm, message)
    assert ros.trajectory(arm, {**message, "points": []})[0].shape == (0, 7)
    for points, due, expected in [
        (rows[0], None, r"points: got shape \(7,\), expected \(n, 7\)"),
        (rows, [0, 1], r"times: got shape \(2,\), expected \(5,\)"),
        (rows, [0, 2, 1, 3, 4], "times from 0 that ascend"),
    ]:
        with pytest.raises(ValueError, match=expected):
            ros.joint_trajectory(arm, points, due)


@pytest.mark.filterwarnings("ignore:joint `led`", "ignore:no pair of bodies")
def test_continuous_joints_turn_on() -> None:
    wheel = Scene(WHEEL)
    angles = np.array([3.0, -3.1, -3.0, 3.1])
    message = ros.joint_trajectory(wheel, np.stack([angles, angles], axis=1))
    rows = {name: [point["positions"][at] for point in message["points"]] for at, name in enumerate(message["joint_names"])}
    assert rows["turn"] == pytest.approx([3.0, 2 * np.pi - 3.1, 2 * np.pi - 3.0, 3.1]) and (rows["led"] == angles).all()
    assert ros.trajectory(wheel, message)[0] == pytest.approx(np.stack([angles, angles], axis=1))


def test_bytes_of_the_wrong_type_and_unknown_fields(arm: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    for data, kind, expected in [
        (b"abc", JOINTS, "sensor_msgs/msg/JointState: got 3 bytes that do not decode"),
        (b"", "moveit/Scene", "type: got 'moveit/Scene', expected one that rosbags or this module has, such as"),
    ]:
        with pytest.raises(ValueError, match=expected):
            ros.from_cdr(data, kind)
    for message, expected in [
        ({"names": ["a"]}, "JointState: got the field 'names', expected some of header, name"),
        ({"position": ["a"]}, r"JointState.position: got \['a'\], expected a list of float64"),
        ({"header": {"stamp": {"sec": "x"}}}, "JointState.header.stamp.sec: got 'x', expected int32"),
    ]:
        with pytest.raises(ValueError, match=expected):
            ros.to_cdr(message, JOINTS)
    monkeypatch.setattr(_ros_messages, "_STORES", [])
    monkeypatch.setitem(sys.modules, "rosbags.typesys", None)
    with pytest.raises(ImportError, match=r"pip install 'extricate\[ros\]'"):
        ros.state(arm, b"abc")
