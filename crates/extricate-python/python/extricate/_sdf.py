"""The simple part of SDF as URDF text: one model of links, collision shapes and joints that a URDF has.

Own code, because no package on PyPI that reads SDF is kept: what there is was last released in 2022, and the parser of Gazebo has
no wheels.
"""

from __future__ import annotations

import os
import warnings
import xml.etree.ElementTree as ET
from typing import Any, Dict, Optional, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
_KINDS = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "ball": "spherical",
}
_SIZES = {"box": ["size"], "sphere": ["radius"], "cylinder": ["radius", "length"], "capsule": ["radius", "length"]}


def converted(path: Any) -> str:
    """The URDF text of the one model in a file."""
    name = os.fspath(path)
    try:
        root = ET.parse(name).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{name}: got text that is not XML ({error}), expected SDF") from error
    models = root.findall("model") + root.findall("world/model")
    if root.tag != "sdf" or len(models) != 1:
        found = f"<{root.tag}> with {len(models)} models"
        raise ValueError(f"{name}: got {found}, expected <sdf> with one <model>")
    return _Model(name, models[0]).urdf()


def _transform(xyz: Any, rpy: Any) -> Array:
    (sx, sy, sz), (cx, cy, cz) = np.sin(rpy), np.cos(rpy)
    out = np.eye(4)
    out[:3, :3] = [
        [cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz],
        [cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz],
        [-sy, sx * cy, cx * cy],
    ]
    out[:3, 3] = xyz
    return out


def _quaternion(r: Array) -> Array:
    """x, y, z, w of a rotation: the column of 4 q q' - 1 whose diagonal is largest."""
    k = np.array(
        [
            [r[0, 0] - r[1, 1] - r[2, 2], r[1, 0] + r[0, 1], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[1, 0] + r[0, 1], r[1, 1] - r[0, 0] - r[2, 2], r[2, 1] + r[1, 2], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[2, 1] + r[1, 2], r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], np.trace(r)],
        ]
    ) + np.eye(4)
    column = k[:, int(np.argmax(np.diag(k)))]
    unit: Array = column / np.linalg.norm(column)
    return unit


def _text(numbers: Any) -> str:
    return " ".join(f"{x:.17g}" for x in np.atleast_1d(numbers))


def _origin(pose: Array) -> str:
    return f'<origin xyz="{_text(pose[:3, 3])}" quat_xyzw="{_text(_quaternion(pose[:3, :3]))}"/>'


class _Model:
    def __init__(self, file: str, model: ET.Element) -> None:
        self.file, self.model = file, model
        for tag in ("include", "model"):
            if model.find(tag) is not None:
                raise ValueError(f"{file}: got <{tag}> in a model, expected links and joints only: expand it first")
        self.named: Dict[str, Tuple[str, ET.Element]] = {}
        for tag in ("link", "joint", "frame"):
            for element in model.findall(tag):
                self.named[element.get("name", "")] = (tag, element)
        self.poses: Dict[str, Array] = {"__model__": np.eye(4), "": np.eye(4)}

    def fail(self, element: ET.Element, problem: str) -> ValueError:
        return ValueError(f"{self.file}: {element.tag} \"{element.get('name')}\": {problem}")

    def numbers(self, owner: ET.Element, text: Optional[str], count: int, what: str) -> Array:
        try:
            found = np.array([float(word) for word in (text or "").split()])
        except ValueError:
            found = np.zeros(0)
        if len(found) != count or not np.isfinite(found).all():
            raise self.fail(owner, f"{what}: got {text!r}, expected {count} finite numbers")
        return found

    def own_pose(self, owner: ET.Element, element: ET.Element) -> Tuple[Array, str]:
        """What <pose> says, and the name of the frame that it starts from."""
        pose = element.find("pose")
        if pose is None or not (pose.text or "").strip():
            return np.eye(4), "" if pose is None else pose.get("relative_to", "")
        if pose.get("rotation_format", "euler_rpy") != "euler_rpy" or pose.get("degrees", "false") == "true":
            raise self.fail(owner, "pose: got another format, expected x y z roll pitch yaw [m, rad]")
        x = self.numbers(owner, pose.text, 6, "pose")
        return _transform(x[:3], x[3:]), pose.get("relative_to", pose.get("frame", ""))

    def pose(self, name: str, depth: int = 0) -> Array:
        """Of a link, joint or frame, in the coordinates of the model."""
        if name not in self.poses:
            if name not in self.named or depth > len(self.named):
                raise ValueError(f"{self.file}: got the frame {name!r}, expected a link, joint or frame of the model")
            tag, element = self.named[name]
            own, start = self.own_pose(element, element)
            if not start:
                start = {"joint": element.findtext("child", ""), "frame": element.get("attached_to", "")}.get(tag, "")
            self.poses[name] = self.pose(start, depth + 1) @ own
        return self.poses[name]

    def urdf(self) -> str:
        joints = self.model.findall("joint")
        above: Dict[str, ET.Element] = {}
        for joint in joints:
            child = joint.findtext("child", "")
            if child in above:
                raise self.fail(joint, f"got the second joint above {child!r}, expected a tree")
            above[child] = joint
        # A URDF has no frame of a link but that of the joint above it.
        frames = {link.get("name", ""): link.get("name", "") for link in self.model.findall("link")}
        frames.update({child: joint.get("name", "") for child, joint in above.items() if child in frames})
        out = [f"<robot name={quoteattr(self.model.get('name', 'sdf'))}>"]
        if any(joint.findtext("parent") == "world" for joint in joints):
            out.append('<link name="world"/>')
            frames["world"] = "__model__"
        for link in self.model.findall("link"):
            out.append(self.link(link, self.pose(frames[link.get("name", "")])))
        out += [self.joint(joint, frames) for joint in joints]
        return "".join(out) + "</robot>"

    def link(self, link: ET.Element, frame: Array) -> str:
        parts = ""
        for collision in link.findall("collision"):
            own, start = self.own_pose(link, collision)
            pose = self.pose(start or link.get("name", "")) @ own
            shape = self.shape(link, collision.find("geometry"))
            if shape:
                parts += f"<collision>{_origin(np.linalg.solve(frame, pose))}<geometry>{shape}</geometry></collision>"
        return f"<link name={quoteattr(link.get('name', ''))}>{parts}</link>"

    def shape(self, link: ET.Element, geometry: Optional[ET.Element]) -> str:
        for shape in geometry if geometry is not None else ():
            if shape.tag in _SIZES:
                sizes = "".join(f' {tag}="{shape.findtext(tag, "").strip()}"' for tag in _SIZES[shape.tag])
                return f"<{shape.tag}{sizes}/>"
            if shape.tag == "plane":
                return f'<plane normal="{shape.findtext("normal", "0 0 1").strip()}"/>'
            if shape.tag == "mesh":
                uri = shape.findtext("uri", "").strip()
                if "://" not in uri:
                    uri = os.path.join(os.path.dirname(os.path.abspath(self.file)), uri)
                scale = shape.findtext("scale", "1 1 1").strip()
                return f'<mesh filename={quoteattr(uri)} scale="{scale}"/>'
            told = f"{self.file}: link \"{link.get('name')}\": a collision shape <{shape.tag}> is left out"
            warnings.warn(told, stacklevel=6)
        return ""

    def joint(self, joint: ET.Element, frames: Dict[str, str]) -> str:
        kind = _KINDS.get(joint.get("type", ""))
        if kind is None:
            raise self.fail(joint, f"got type {joint.get('type')!r}, expected {', '.join(_KINDS)}")
        ends = [joint.findtext(tag, "") for tag in ("parent", "child")]
        for end in ends:
            if end not in frames:
                raise self.fail(joint, f"got {end!r}, expected a link of the model")
        own = self.pose(joint.get("name", ""))
        out = "".join(f"<{tag} link={quoteattr(end)}/>" for tag, end in zip(("parent", "child"), ends))
        out += _origin(np.linalg.solve(self.pose(frames[ends[0]]), own))
        axis = joint.find("axis")
        if axis is not None and kind in ("revolute", "continuous", "prismatic"):
            out += self.axis(joint, axis, own)
            lower = float(axis.findtext("limit/lower", "-1e16"))
            upper = float(axis.findtext("limit/upper", "1e16"))
            if kind == "revolute" and lower <= -1e9 and upper >= 1e9:
                kind = "continuous"
            elif kind != "continuous" and max(abs(lower), abs(upper)) < 1e9:
                out += f'<limit lower="{lower:.17g}" upper="{upper:.17g}"/>'
        return f"<joint name={quoteattr(joint.get('name', ''))} type=\"{kind}\">{out}</joint>"

    def axis(self, joint: ET.Element, axis: ET.Element, own: Array) -> str:
        xyz = axis.find("xyz")
        direction = self.numbers(joint, "0 0 1" if xyz is None else xyz.text, 3, "axis")
        start = "" if xyz is None else xyz.get("expressed_in", "")
        if start:
            direction = own[:3, :3].T @ self.pose(start)[:3, :3] @ direction
        elif axis.findtext("use_parent_model_frame", "false").strip() in ("1", "true"):
            direction = own[:3, :3].T @ direction
        out = f'<axis xyz="{_text(direction)}"/>'
        mimic = axis.find("mimic")
        if mimic is not None:
            factor, offset, reference = (
                float(mimic.findtext(tag, "1" if tag == "multiplier" else "0"))
                for tag in ("multiplier", "offset", "reference")
            )
            out += (
                f"<mimic joint={quoteattr(mimic.get('joint', ''))} multiplier=\"{factor:.17g}\" "
                f'offset="{offset - factor * reference:.17g}"/>'
            )
        return out
