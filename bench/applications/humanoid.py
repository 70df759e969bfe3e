"""A humanoid of capsules and boxes, written for this benchmark: 31 joints, held at its pelvis, with nothing to touch but itself."""
import numpy as np

import extricate
from passages import box_part, capsule_link

WAIST = [("yaw", "0 0 1", -1.2, 1.2), ("roll", "1 0 0", -0.5, 0.5), ("pitch", "0 1 0", -0.4, 0.8)]
NECK = [("yaw", "0 0 1", -1.2, 1.2), ("pitch", "0 1 0", -0.6, 0.6)]
# Roll and yaw are those of the left side; the right side is its mirror image.
SHOULDER = [("pitch", "0 1 0", -2.8, 1.0), ("roll", "1 0 0", -0.4, 2.5), ("yaw", "0 0 1", -1.5, 1.5)]
WRIST = [("yaw", "0 0 1", -1.5, 1.5), ("roll", "1 0 0", -0.6, 0.6), ("pitch", "0 1 0", -1.2, 1.2)]
HIP = [("yaw", "0 0 1", -0.6, 0.8), ("roll", "1 0 0", -0.4, 0.8), ("pitch", "0 1 0", -1.8, 0.6)]
ANKLE = [("pitch", "0 1 0", -0.8, 0.6), ("roll", "1 0 0", -0.4, 0.4)]
# Each side of a joint of more than one axis: they touch by design.
JOINED = [("pelvis", "chest"), ("chest", "head")]
JOINED += [(f"{side}_{a}", f"{side}_{b}") for side in ("left", "right") for a, b in (("forearm", "hand"), ("shin", "foot"))]
JOINED += [("pelvis", f"{side}_thigh") for side in ("left", "right")]


def joints(name, axes, parent, child, xyz, mirrored=False):
    """Returns joints one after the other between two links, with links without geometry between them."""
    parts = []
    for k, (word, axis, lower, upper) in enumerate(axes):
        last = k == len(axes) - 1
        link = child if last else f"{name}_{word}"
        if mirrored and axis != "0 1 0":
            lower, upper = -upper, -lower
        parts.append("" if last else f'<link name="{link}"/>')
        parts.append(
            f'<joint name="{name}_{word}" type="revolute"><parent link="{parent}"/><child link="{link}"/>'
            f'<origin xyz="{" ".join(map(str, xyz if k == 0 else (0, 0, 0)))}"/><axis xyz="{axis}"/>'
            f'<limit lower="{lower}" upper="{upper}" effort="1" velocity="1"/></joint>'
        )
        parent = link
    return "".join(parts)


def urdf():
    def link(name, collision):
        return f'<link name="{name}">{collision}</link>'

    parts = [link("pelvis", box_part((0.2, 0.28, 0.16), (0, 0, 0))), link("chest", box_part((0.2, 0.3, 0.36), (0, 0, 0.23)))]
    parts += [link("head", capsule_link(0.09, [(0, 0, 0.12), (0, 0, 0.2)]))]
    parts += [joints("waist", WAIST, "pelvis", "chest", (0, 0, 0.1)), joints("neck", NECK, "chest", "head", (0, 0, 0.42))]
    for side, sign in (("left", 1), ("right", -1)):
        elbow, knee = [("elbow", "0 1 0", -2.4, 0.0)], [("knee", "0 1 0", 0.0, 2.2)]
        parts += [link(f"{side}_upper_arm", capsule_link(0.05, [(0, 0, -0.06), (0, 0, -0.26)]))]
        parts += [link(f"{side}_forearm", capsule_link(0.042, [(0, 0, -0.05), (0, 0, -0.2)]))]
        parts += [link(f"{side}_hand", box_part((0.03, 0.09, 0.16), (0, 0, -0.1)))]
        parts += [link(f"{side}_thigh", capsule_link(0.07, [(0, 0, -0.1), (0, 0, -0.34)]))]
        parts += [link(f"{side}_shin", capsule_link(0.055, [(0, 0, -0.08), (0, 0, -0.34)]))]
        parts += [link(f"{side}_foot", box_part((0.24, 0.1, 0.05), (0.05, 0, -0.06)))]
        parts += [joints(f"{side}_shoulder", SHOULDER, "chest", f"{side}_upper_arm", (0, sign * 0.23, 0.37), sign < 0)]
        parts += [joints(side, elbow, f"{side}_upper_arm", f"{side}_forearm", (0, 0, -0.32))]
        parts += [joints(f"{side}_wrist", WRIST, f"{side}_forearm", f"{side}_hand", (0, 0, -0.26), sign < 0)]
        parts += [joints(f"{side}_hip", HIP, "pelvis", f"{side}_thigh", (0, sign * 0.1, -0.08), sign < 0)]
        parts += [joints(side, knee, f"{side}_thigh", f"{side}_shin", (0, 0, -0.42))]
        parts += [joints(f"{side}_ankle", ANKLE, f"{side}_shin", f"{side}_foot", (0, 0, -0.42), sign < 0)]
    return '<robot name="humanoid">' + "".join(parts) + "</robot>"


def scene():
    return extricate.Scene(extricate.Robot(urdf()), disable=JOINED)


def clip(of, rows, share, seed):
    """Returns a smooth motion of `rows` frames at 60 a second: each joint sums three sines of 0.1 to 0.6 Hz, within its limits.

    share: how much of each joint's range the motion may take, around a middle that is drawn.
    """
    rng = np.random.default_rng(seed)
    lower, upper = np.asarray(of.lower), np.asarray(of.upper)
    half = share * (upper - lower) / 2
    middle = rng.uniform(lower + half, upper - half)
    seconds = np.arange(rows)[:, None, None] / 60
    waves = np.sin(2 * np.pi * rng.uniform(0.1, 0.6, (3, of.nq)) * seconds + rng.uniform(0, 2 * np.pi, (3, of.nq)))
    weights = rng.dirichlet(np.ones(3), of.nq).T
    return middle + half * (waves * weights).sum(axis=1)
