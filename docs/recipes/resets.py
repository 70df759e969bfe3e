"""Resets without penetration in the arrays of three simulators: MuJoCo and MJWarp, Isaac Lab, and Newton."""

import mujoco
import numpy as np

import extricate

LEG = """<body name="{0}_thigh" pos="0 {1} -0.16"><joint name="{0}_hip" axis="0 1 0" range="-1.5 1.5"/>
<geom type="capsule" size="0.04" fromto="0 0 -0.05 0 0 -0.2"/><body name="{0}_shin" pos="0 0 -0.25">
<joint name="{0}_knee" axis="0 1 0" range="0 2.4"/><geom type="capsule" size="0.035" fromto="0 0 -0.05 0 0 -0.2"/></body></body>"""
BIPED = f"""<mujoco><compiler angle="radian"/><worldbody><geom name="floor" type="plane" size="5 5 0.1"/>
<body name="torso" pos="0 0 0.6"><freejoint name="root"/><geom type="box" size="0.08 0.1 0.15"/>
{LEG.format("left", 0.06)}{LEG.format("right", -0.06)}</body></worldbody></mujoco>"""


def of_mujoco(scene, robot, qpos):
    """Resets for MuJoCo: `qpos` (n, nq), which MJWarp has as `data.qpos`, a row for each world."""
    return robot.reset(qpos, scene=scene)[0]


def of_isaac_lab(scene, root_pose, joint_pos, joint_names, rotation_as="quat_wxyz"):
    """Resets for Isaac Lab: root poses (n, 7) without the origins of the environments, and joint positions (n, k) in the order of the
    articulation's `joint_names`. Quaternions begin with w; from Isaac Lab 3.0 on, give "quat_xyzw"."""
    form = {"names": joint_names, "rotation_as": rotation_as}
    Q = extricate.grasps.from_arrays(scene, root_pose[:, :3], root_pose[:, 3:], joint_pos, **form)
    found = extricate.rows.Query(scene)({"q": Q})
    moves = (found["error"] == "") & ~found["free"]      # a state of which nothing free was found stays as it is
    free = extricate.grasps.to_arrays(scene, np.where(moves[:, None], found["witness"], Q), **form)
    return np.hstack([free.translation, free.rotation]), free.joints


def of_newton(scene, joint_q, joint_names):
    """Resets for Newton: `state.joint_q`, one world after another: position and quaternion of the root, w last, then the other joints.
    `joint_names` are theirs, in this order."""
    worlds = np.reshape(joint_q, (-1, 7 + len(joint_names)))
    return np.hstack(of_isaac_lab(scene, worlds[:, :7], worlds[:, 7:], joint_names, "quat_xyzw")).ravel()


def main(count=200):
    mujoco_model = mujoco.MjModel.from_xml_string(BIPED)
    robot = extricate.Robot.from_mujoco(mujoco_model, limits={"root": ([-1, -1, 0.1], [1, 1, 1])})
    scene = extricate.Scene(robot, clearance=1e-4)
    qpos = robot.qpos(scene.sample(count, seed=1))
    joint_names = ["left_hip", "left_knee", "right_hip", "right_knee"]      # the order of the file
    by_depth = ["left_hip", "right_hip", "left_knee", "right_knee"]         # the order of Isaac Lab on PhysX
    joints = {name: qpos[:, 7 + at] for at, name in enumerate(joint_names)}
    root = qpos[:, :7]
    first = of_mujoco(scene, robot, qpos)
    second = of_isaac_lab(scene, root, np.stack([joints[name] for name in by_depth], axis=1), by_depth)
    third = of_newton(scene, np.hstack([root[:, :3], root[:, [4, 5, 6, 3]], qpos[:, 7:]]).ravel(), joint_names)
    moved = np.count_nonzero((first != qpos).any(axis=1))
    print(f"{moved} of {count} states were moved")
    return mujoco_model, qpos, first, second, third


if __name__ == "__main__":
    main()
