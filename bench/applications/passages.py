"""Scenes with narrow passages, made of boxes and capsules for this benchmark: name -> (scene, start, goal).

The number in a name is the width of the passage relative to the part that has to pass.
"""
import dataclasses

import numpy as np

import extricate

HALF = np.sqrt(0.5)


def capsule_link(radius, points):
    """Returns the collision elements of a polyline of capsules."""
    parts = []
    for a, b in zip(points[:-1], points[1:]):
        a, b = np.asarray(a, float), np.asarray(b, float)
        axis, length = b - a, float(np.linalg.norm(b - a))
        pitch, yaw = np.arccos(axis[2] / length), np.arctan2(axis[1], axis[0])
        middle = " ".join(f"{x:.9g}" for x in (a + b) / 2)
        parts.append(
            f'<collision><origin xyz="{middle}" rpy="0 {pitch:.12g} {yaw:.12g}"/>'
            f'<geometry><capsule radius="{radius}" length="{length:.12g}"/></geometry></collision>'
        )
    return "".join(parts)


def box_part(size, xyz):
    return f'<collision><origin xyz="{xyz[0]} {xyz[1]} {xyz[2]}"/><geometry><box size="{size[0]} {size[1]} {size[2]}"/></geometry></collision>'


def flying(name, collisions, bounds):
    """Makes a rigid part that moves freely within bounds."""
    urdf = f'<robot name="{name}"><link name="{name}">{collisions}</link></robot>'
    return extricate.Robot(urdf, base="floating", bounds=bounds)


def plate_with_hole(width, depth, size, thickness, at=(0, 0, 0)):
    """Four boxes around a rectangular hole of width x depth in a plate of size x size."""
    x, y, z = at
    side, end = (size - width) / 2, (size - depth) / 2
    return [
        extricate.Box([side, size, thickness], [x - (width + side) / 2, y, z], name="plate_left"),
        extricate.Box([side, size, thickness], [x + (width + side) / 2, y, z], name="plate_right"),
        extricate.Box([width, end, thickness], [x, y - (depth + end) / 2, z], name="plate_front"),
        extricate.Box([width, end, thickness], [x, y + (depth + end) / 2, z], name="plate_back"),
    ]


def peg(hole):
    """A peg of 1 x 1 x 4.5 m and a square hole in a plate 3 m thick that fills the bounds."""
    robot = flying("peg", box_part((1, 1, 4.5), (0, 0, 0)), ([-4, -4, -6], [4, 4, 6]))
    scene = extricate.Scene(robot, plate_with_hole(hole, hole, 10, 3), metric="object-norm")
    return scene, [2, 2, 4.8, 0, 0, 0, 1], [-2, -2, -4.8, HALF, 0, 0, HALF]


def ring_points(gap, radius=1.0, pieces=10):
    """An arc of a circle in the xz plane that leaves a gap at +x."""
    half = np.arcsin(gap / 2 / radius)
    angles = np.linspace(half, 2 * np.pi - half, pieces + 1)
    return [(radius * np.cos(t), 0.0, radius * np.sin(t)) for t in angles]


def rings(scale):
    """Two open rings of a bent tube, one through the other: the tube just passes the gaps, `scale` times its thickness."""
    tube = 0.15
    points = ring_points(2 * tube * (scale + 1))
    robot = flying("ring", capsule_link(tube, points), ([-4, -4, -4], [4, 4, 4]))
    obstacles = []
    for at, (a, b) in enumerate(zip(points[:-1], points[1:])):
        a, b = np.array(a), np.array(b)
        axis = (b - a) / np.linalg.norm(b - a)
        pitch = np.arctan2(axis[0], axis[2])
        obstacles.append(extricate.Capsule(tube, float(np.linalg.norm(b - a)), [*((a + b) / 2), 0, pitch, 0], name=f"fixed_{at}"))
    scene = extricate.Scene(robot, obstacles, metric="object-norm")
    # The ring crosses the other one through its middle, with the gap on the far side.
    return scene, [-1, 0, 0, 0, HALF, HALF, 0], [3, 2, 0, 0, 0, 0, 1]


def frame(opening):
    """A Z-shaped bar of 0.3 m to be threaded through a window that is `opening` times its thickness higher than it."""
    parts = box_part((2.4, 0.3, 0.3), (0, 0, 0)) + box_part((0.3, 0.3, 1.0), (1.05, 0, 0.5)) + box_part((0.3, 0.3, 1.0), (-1.05, 0, -0.5))
    robot = flying("bar", parts, ([-3, -4, -3], [3, 4, 3]))
    window = plate_with_hole(1.4, 0.3 * (1 + opening), 12, 0.4)
    turned = [extricate.Box(list(np.array(box.size)[[0, 2, 1]]), [box.pose[0], 0, box.pose[1]], name=box.name) for box in window]
    scene = extricate.Scene(robot, turned, metric="object-norm")
    return scene, [0, 2.6, 0, 0, 0, 0, 1], [0, -2.6, 0, 0, 0, 0, 1]


def hook(play):
    """A hook of 0.2 m in a slot that holds its head: it comes out turned only. `play` is the slot over the thickness."""
    parts = box_part((0.2, 0.2, 1.6), (0, 0, 0)) + box_part((0.7, 0.2, 0.2), (0.25, 0, -0.7))
    robot = flying("hook", parts, ([-3, -3, -3], [3, 3, 3]))
    slot = plate_with_hole(0.2 * play + 0.35, 0.2 * play, 8, 0.3, (0, 0, 0))
    scene = extricate.Scene(robot, slot, metric="object-norm")
    return scene, [0, 0, -1.6, 0, 0, 0, 1], [0, 0, 1.8, 0, 0, 0, 1]


def planar_arm(gap):
    """Five links of 0.5 m in the plane, and a wall with a gap that is `gap` times as wide as a link is thick."""
    thick = 0.1
    links, joints = ['<link name="base"/>'], []
    for k in range(5):
        links.append(f'<link name="link{k}">{box_part((0.5, thick, thick), (0.25, 0, 0))}</link>')
        parent, x = ("base", 0) if k == 0 else (f"link{k - 1}", 0.5)
        joints.append(
            f'<joint name="joint{k}" type="revolute"><parent link="{parent}"/><child link="link{k}"/><origin xyz="{x} 0 0"/>'
            f'<axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6" effort="1" velocity="1"/></joint>'
        )
    urdf = '<robot name="arm">' + "".join(links) + "".join(joints) + "</robot>"
    width = gap * thick
    walls = [
        extricate.Box([0.2, 4, 0.5], [1.2, 2 + width / 2, 0], name="wall_above"),
        extricate.Box([0.2, 4, 0.5], [1.2, -2 - width / 2, 0], name="wall_below"),
    ]
    scene = extricate.Scene(extricate.Robot(urdf), walls)
    return scene, [2.2, -0.5, -0.5, 0.8, 0.4], [0, 0, 0, 0.9, 0.9]


def gripper(slit):
    """A seven-joint arm with a flat hand of 2 cm that reaches into the slit of a box, `slit` times as high as the hand."""
    hand = 0.02
    axes = ["0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1"]
    lengths = [0.3, 0.15, 0.3, 0.15, 0.25, 0.1, 0.05]
    links, joints = ['<link name="base"/>'], []
    for k, (axis, length) in enumerate(zip(axes, lengths)):
        body = capsule_link(0.05, [(0, 0, 0.0), (0, 0, length)]) if k < 6 else box_part((0.08, hand, 0.2), (0, 0, 0.15))
        links.append(f'<link name="link{k}">{body}</link>')
        parent, z = ("base", 0) if k == 0 else (f"link{k - 1}", lengths[k - 1])
        joints.append(
            f'<joint name="joint{k}" type="revolute"><parent link="{parent}"/><child link="link{k}"/><origin xyz="0 0 {z}"/>'
            f'<axis xyz="{axis}"/><limit lower="-2.8" upper="2.8" effort="1" velocity="1"/></joint>'
        )
    disable = [(f"link{a}", f"link{b}") for a in range(7) for b in range(a + 1, 7) if b - a < 3]
    urdf = '<robot name="reach">' + "".join(links) + "".join(joints) + "</robot>"
    height = slit * hand
    box = [
        extricate.Box([0.3, 0.6, 0.3], [0.75, 0, 0.6 + height / 2 + 0.15], name="box_above"),
        extricate.Box([0.3, 0.6, 0.6], [0.75, 0, 0.3 - height / 2], name="box_below"),
    ]
    scene = extricate.Scene(extricate.Robot(urdf), box, disable=disable)
    return scene, [0, -0.5, 0, 1.0, 0, 0.5, 0], [1.194722, 0.565011, -1.658285, 1.865023, -0.715501, -0.637187, 2.798377]


def turned(pose, turn):
    """Rotates a pose (position and roll, pitch, yaw, or position and quaternion) by a unit quaternion x, y, z, w."""
    pose = np.asarray(pose, float)
    own = pose[3:] if len(pose) == 7 else of_angles(*(pose[3:] if len(pose) == 6 else np.zeros(3)))
    return [*(matrix(turn) @ pose[:3]), *times(turn, own)]


def entry(pose):
    return {"xyz": [float(x) for x in pose[:3]], "quat_xyzw": [float(x) for x in pose[3:]]}


def of_angles(roll, pitch, yaw):
    """Returns the quaternion of roll, pitch and yaw, in this order about fixed axes."""
    about = [np.array([*(np.eye(3)[k] * np.sin(angle / 2)), np.cos(angle / 2)]) for k, angle in enumerate((roll, pitch, yaw))]
    return times(about[2], times(about[1], about[0]))


def times(a, b):
    """Multiplies quaternions x, y, z, w."""
    v = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.array([*v, a[3] * b[3] - a[:3] @ b[:3]])


def matrix(q):
    x, y, z, w = q
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + 2 * w * cross + 2 * cross @ cross


def socket(ratio, turn=None):
    """A square peg of 4 x 4 x 16 cm and a blind hole 12 cm deep, `ratio` times as wide as it; the peg ends 4 mm above the ground.

    turn: a quaternion that rotates all of it, so that the hole lies along no axis of the base joint.
    """
    width, depth, size = 0.04, 0.12, 0.5
    walls = plate_with_hole(width * ratio, width * ratio, size, depth, (0, 0, -depth / 2))
    walls.append(extricate.Box([size, size, 0.02], [0, 0, -depth - 0.01], name="ground"))
    about = np.array([0.258, 0.231, 0.082, 0.935])
    start, goal = [0.1, 0.08, 0.2, *(about / np.linalg.norm(about))], [0, 0, -0.036, 0, 0, 0, 1]
    bounds = ([-0.25, -0.25, -0.15], [0.25, 0.25, 0.35])
    if turn is not None:
        turn = np.asarray(turn, float) / np.linalg.norm(turn)
        walls = [dataclasses.replace(wall, pose=entry(turned(wall.pose, turn))) for wall in walls]
        start, goal, bounds = turned(start, turn), turned(goal, turn), ([-0.3] * 3, [0.3] * 3)
    robot = flying("peg", box_part((width, width, 0.16), (0, 0, 0)), bounds)
    return extricate.Scene(robot, walls, metric="object-norm", clearance=1e-4), start, goal


def chain(count=8):
    """A chain of links in a corridor twice as wide as they are; the last three lie outside, from one side to the other."""
    length, thick = 0.1, 0.03
    links, joints = ['<link name="base"/>'], []
    for k in range(count):
        links.append(f'<link name="link{k}">{box_part((length - 0.01, thick, thick), (length / 2, 0, 0))}</link>')
        parent, x = ("base", 0) if k == 0 else (f"link{k - 1}", length)
        joints.append(
            f'<joint name="joint{k}" type="revolute"><parent link="{parent}"/><child link="link{k}"/><origin xyz="{x} 0 0"/>'
            f'<axis xyz="0 0 1"/><limit lower="-2.5" upper="2.5" effort="1" velocity="1"/></joint>'
        )
    inside = (count - 3) * length
    middle, deep = inside / 2 - 0.075, inside + 0.05
    walls = [extricate.Box([deep, 0.05, 0.1], [middle, side * (0.025 + thick), 0], name=name) for name, side in (("left", 1), ("right", -1))]
    walls.append(extricate.Box([0.03, 0.03, 0.1], [inside + 0.28, 0, 0], name="post"))
    scene = extricate.Scene(extricate.Robot('<robot name="chain">' + "".join(links) + "".join(joints) + "</robot>"), walls, clearance=1e-4)
    still = [0] * (count - 3)
    return scene, [*still, 1.2, 0.15, 0.15], [*still, -1.2, -0.15, -0.15]


def bug_trap(neck):
    """A bar of 0.6 x 0.2 m in the plane, in a room whose way out is a neck that leads inward, `neck` times as wide as the bar is thick."""
    joints = "".join(
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="{axis}"/>'
        f'<limit lower="{-reach}" upper="{reach}" effort="1" velocity="1"/></joint>'
        for name, kind, parent, child, axis, reach in (
            ("x", "prismatic", "base", "slide", "1 0 0", 4.0),
            ("y", "prismatic", "slide", "mount", "0 1 0", 4.0),
            ("turn", "revolute", "mount", "bar", "0 0 1", 3.14),
        )
    )
    urdf = f'<robot name="bar"><link name="base"/><link name="slide"/><link name="mount"/><link name="bar">{box_part((0.6, 0.2, 0.2), (0, 0, 0))}</link>{joints}</robot>'
    width, wall = 0.2 * neck, 0.1
    long = (4 - width) / 2
    room = [extricate.Box([4, wall, 0.5], [0, y, 0], name=name) for y, name in ((2, "above"), (-2, "below"))]
    room.append(extricate.Box([wall, 4, 0.5], [-2, 0, 0], name="behind"))
    for side, name in ((1, "upper"), (-1, "lower")):
        room.append(extricate.Box([wall, long, 0.5], [2, side * (width + long) / 2, 0], name=f"front_{name}"))
        room.append(extricate.Box([1.2, wall, 0.5], [1.4, side * (width + wall) / 2, 0], name=f"neck_{name}"))
    return extricate.Scene(extricate.Robot(urdf), room, clearance=1e-4), [1.2, 1.2, 0.5], [3, 0, 1.5]


def exchange():
    """Two seven-joint arms over a table, each on the other's side: the lower one becomes the upper one."""
    below, above = [1.4343, -1.2086, -1.4784, -1.3402, -0.1007, 0.3123, 0], [-0.5944, 0.4114, -0.3546, -1.0243, -0.027, 0.3055, 0]
    start, goal = [*below, 0.5944, 0.4114, 0.3546, -1.0243, 0.027, 0.3055, 0], [*above, -1.6971, -0.5857, -0.8334, 1.3406, -0.0563, -0.3081, 0]
    return extricate.Scene.builtin("dual-arm"), start, goal


# Rotates the hole away from the axes of the base joint.
TILT = [0.3, -0.5, 0.2, 0.7]

SCENES = {
    "socket-1.3": lambda: socket(1.3),
    "socket-1.05": lambda: socket(1.05),
    "socket-1.3-tilted": lambda: socket(1.3, TILT),
    "socket-1.05-tilted": lambda: socket(1.05, TILT),
    "chain-2": chain,
    "chain-12": lambda: chain(12),
    "bug-trap-1.5": lambda: bug_trap(1.5),
    "bug-trap-1.2": lambda: bug_trap(1.2),
    "gripper-1.5": lambda: gripper(1.5),
    "exchange": exchange,
    "peg-1.5": lambda: peg(1.5),
    "peg-1.3": lambda: peg(1.3),
    "peg-1.15": lambda: peg(1.15),
    "rings-1.5": lambda: rings(1.5),
    "rings-1.2": lambda: rings(1.2),
    "rings-1.1": lambda: rings(1.1),
    "frame-1.5": lambda: frame(1.5),
    "hook-1.5": lambda: hook(1.5),
    "arm-1.5": lambda: planar_arm(1.5),
}
