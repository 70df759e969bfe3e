"""Reads a bag of ROS 2 without ROS: a planning scene with an octomap and a joint state become a query, the answer a message."""

import pathlib
import tempfile

import numpy as np
import pyoctomap
from rosbags.rosbag2 import Reader, Writer

import extricate
from extricate import ros

SCENE, JOINTS = "moveit_msgs/msg/PlanningScene", "sensor_msgs/msg/JointState"
# A table, a box and a can in the gripper, as MoveIt's tutorials have them; fields that are missing are 0 or empty.
TABLE = {"id": "table", "pose": {"position": {"x": 0.5, "z": 0.2}}, "primitives": [{"type": 1, "dimensions": [0.5, 1.0, 0.05]}]}
BOX = {"id": "box", "pose": {"position": {"x": 0.4, "y": 0.3, "z": 0.4}}, "primitives": [{"type": 1, "dimensions": [0.1] * 3}]}
CAN = {"id": "can", "pose": {"position": {"z": 0.15}}, "primitives": [{"type": 3, "dimensions": [0.12, 0.03]}]}
HELD = {"link_name": "gripper", "touch_links": ["link_7"], "object": CAN}


def write(path, messages):
    """Writes a bag of (topic, type, message): dicts by field."""
    with Writer(path, version=9) as writer:
        for stamp, (topic, kind, message) in enumerate(messages):
            connection = writer.add_connection(topic, kind, typestore=ros.typestore())
            writer.write(connection, stamp, ros.to_cdr(message, kind))


def read(path):
    """The last message of each topic of a bag, as bytes."""
    with Reader(path) as reader:
        return {connection.topic: data for connection, _, data in reader.messages()}


def wall():
    """An octomap of a wall before the arm, as octomap_server publishes one, and the number of its cells."""
    tree, count = pyoctomap.OcTree(0.05), 0
    for y in np.arange(-0.6, 0.6, 0.05):
        for z in np.arange(0.2, 1.2, 0.05):
            tree.updateNode([0.625, y + 0.025, z + 0.025], True)
            count += 1
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "wall.bt"
        tree.writeBinary(str(path))
        data = path.read_bytes().partition(b"\ndata\n")[2]
    return {"binary": True, "id": "OcTree", "resolution": 0.05, "data": data}, count


def main(folder=None):
    folder = pathlib.Path(folder or tempfile.mkdtemp())
    robot = extricate.Scene.builtin("shelf-arm")
    octomap, cells = wall()
    scene = {
        "world": {"collision_objects": [TABLE, BOX], "octomap": {"octomap": octomap}},
        "robot_state": {"attached_collision_objects": [HELD]},
    }
    start = [2.4, -0.5, -0.1, 1.8, -1.0, 0.5, -1.3]  # the can is in the wall
    write(folder / "robot", [("/planning_scene", SCENE, scene), ("/joint_states", JOINTS, ros.joint_state(robot, start))])

    held = read(folder / "robot")
    world = ros.planning_scene(robot, held["/planning_scene"])
    q = ros.state(world, held["/joint_states"])
    answer = world.query(q)
    print(answer)
    write(folder / "repaired", [("/repaired", JOINTS, ros.joint_state(world, answer.witness))])
    return world, octomap, cells, q, answer, ros.state(world, read(folder / "repaired")["/repaired"])


if __name__ == "__main__":
    main()
