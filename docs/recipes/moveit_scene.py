"""A PlanningScene of MoveIt and a JointState: the start is repaired, and given back by the names of joints."""

import json
import pathlib
import tempfile

import extricate

POINT = {"x": 0, "y": 0, "z": 0}
HERE = {"position": POINT, "orientation": {**POINT, "w": 1}}
# As rosbridge sends it, cut down: a table, and a can that the gripper holds and the last link may touch.
MESSAGE = {
    "world": {
        "collision_objects": [
            {
                "header": {"frame_id": "world"},
                "id": "table",
                "pose": {"position": {"x": 0.5, "y": 0, "z": 0.2}, "orientation": {**POINT, "w": 1}},
                "primitives": [{"type": 1, "dimensions": [0.5, 1.0, 0.05]}],
                "primitive_poses": [HERE],
            }
        ]
    },
    "robot_state": {
        "attached_collision_objects": [
            {
                "link_name": "gripper",
                "touch_links": ["gripper", "link_7"],
                "object": {
                    "header": {"frame_id": "gripper"},
                    "id": "can",
                    "pose": {"position": {"x": 0, "y": 0, "z": 0.15}, "orientation": {**POINT, "w": 1}},
                    "primitives": [{"type": 3, "dimensions": [0.12, 0.03]}],
                    "primitive_poses": [HERE],
                },
            }
        ]
    },
}
NAMES = [f"joint_{number}" for number in (7, 6, 5, 4, 3, 2, 1)]  # as a driver reports them, in any order
JOINT_STATE = {"name": NAMES, "position": [0.0, 2.0, 0.0, 0.7, 0.0, -1.7, 2.3]}


def main(folder=None):
    folder = pathlib.Path(folder or tempfile.mkdtemp())
    (folder / "planning_scene.json").write_text(json.dumps(MESSAGE))
    robot = extricate.Scene.builtin("shelf-arm")
    world = robot.in_world(folder / "planning_scene.json")  # its obstacles in place of the shelf
    start = world.config(JOINT_STATE)
    answer = world.query(start)
    print(answer)
    repaired = world.positions(answer.witness)  # by name, for a JointState or a trajectory's first point
    near = world.contacts(answer.witness, within=0.02)
    for contact in near:
        print(world.pairs[contact["pair"]], f"{1000 * contact['distance']:.1f} mm apart")
    return world, start, answer, repaired, near


if __name__ == "__main__":
    main()
