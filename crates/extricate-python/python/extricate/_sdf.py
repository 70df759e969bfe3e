"""Converts simple SDF files to URDF text: a model with links, collision shapes and joints that a URDF has, and obstacles.

It uses no package: those on PyPI that read SDF had their last release in 2022, and the parser of Gazebo has no wheels.
"""

from __future__ import annotations

import os
import tempfile
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, Dict, List, Mapping, Optional, Sequence, Set, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from ._meshes import ellipsoid, write_obj
from ._parts import Fixture, SdfRobot
from ._xacro import packages_around

Array = npt.NDArray[Any]
_KINDS = {
    "fixed": "fixed",
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "ball": "spherical",
}
_SIZES = {"box": ["size"], "sphere": ["radius"], "cylinder": ["radius", "length"], "capsule": ["radius", "length"]}


def converted(path: Any, options: Mapping[str, Any]) -> SdfRobot:
    """Makes a robot of the one model in a file that moves, with the other models as its obstacles."""
    name = os.fspath(path)
    try:
        root = ET.parse(name).getroot()
    except ET.ParseError as error:
        raise ValueError(f"{name}: got text that is not XML ({error}), expected SDF") from error
    found = root.findall("model") + root.findall("world/model")
    if root.tag != "sdf" or not found:
        raise ValueError(f"{name}: got <{root.tag}> with {len(found)} models, expected <sdf> with one <model>")
    made = _Made()
    made.left_out += [f"{name}: an <include> is left out: expand it first" for _ in root.findall("include") + root.findall("world/include")]
    models = [_Model(name, model, made) for model in found]
    moving = [model for model in models if model.moves] if len(models) > 1 else models
    if len(moving) != 1:
        names = ", ".join(repr(model.name) for model in moving) or "none"
        raise ValueError(f"{name}: got {len(models)} models, of which {names} have joints that move, expected one that has")
    robot = moving[0]
    text = robot.urdf()
    robot.check_limits({*options.get("limits", ()), *options.get("locked", ())})
    options = {**options, "packages": [*options.get("packages", ()), *packages_around(path)]}
    taken = {link.get("name", "") for link in robot.model.findall("link")}
    obstacles = [
        fixture for model in models if model is not robot for fixture in model.fixture(taken, options["packages"])
    ]
    for told in made.left_out:
        warnings.warn(f"from_sdf: {told}", stacklevel=3)
    return SdfRobot(text, **options, obstacles=obstacles, files=made.folder)


class _Made:
    """Files that a conversion makes, and notes about what it leaves out."""

    def __init__(self) -> None:
        self.folder = tempfile.TemporaryDirectory(prefix="extricate-sdf-")
        self.count = 0
        self.left_out: List[str] = []

    def path(self, extension: str) -> Path:
        self.count += 1
        return Path(self.folder.name) / f"{self.count}.{extension}"


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


def _turned(xyz: Any, quaternion: Any) -> Array:
    """Returns the transform of a position and a unit quaternion x, y, z, w."""
    x, y, z, w = quaternion
    out = np.eye(4)
    out[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    out[:3, 3] = xyz
    return out


def _quaternion(r: Array) -> Array:
    """Returns x, y, z, w of a rotation matrix: the column of 4 q q' with the largest diagonal, normalised."""
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
    def __init__(self, file: str, model: ET.Element, made: _Made) -> None:
        self.file, self.model, self.made, self.name = file, model, made, model.get("name", "sdf")
        for tag in ("include", "model"):
            if model.find(tag) is not None:
                raise ValueError(f"{file}: got <{tag}> in a model, expected links and joints only: expand it first")
        self.named: Dict[str, Tuple[str, ET.Element]] = {}
        for tag in ("link", "joint", "frame"):
            for element in model.findall(tag):
                self.named[element.get("name", "")] = (tag, element)
        self.stands = model.findtext("static", "").strip() in ("1", "true")
        self.moves = not self.stands and any(joint.get("type") != "fixed" for joint in model.findall("joint"))
        self.without_limits: Dict[str, str] = {}
        # Poses of frames in the coordinates of the world, by name.
        self.poses: Dict[str, Array] = {}
        self.place(np.eye(4))
        own, start = self.own_pose(model, model)
        if start not in ("", "world"):
            raise self.fail(model, f"pose: got relative_to {start!r}, expected the world's own frame")
        self.place(own @ np.linalg.inv(self.pose(model.get("placement_frame", ""))))

    def place(self, pose: Array) -> None:
        self.poses = {"world": np.eye(4), "__model__": pose, "": pose}

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
        """Reads <pose> and the name of the frame that it is relative to."""
        pose = element.find("pose")
        if pose is None or not (pose.text or "").strip():
            return np.eye(4), "" if pose is None else pose.get("relative_to", "")
        form, start = pose.get("rotation_format", "euler_rpy"), pose.get("relative_to", pose.get("frame", ""))
        in_degrees = pose.get("degrees", "false") in ("1", "true")
        if form not in ("euler_rpy", "quat_xyzw") or (in_degrees and form != "euler_rpy"):
            raise self.fail(owner, "pose: got another format, expected x y z roll pitch yaw or x y z and quat_xyzw")
        if form == "quat_xyzw":
            x = self.numbers(owner, pose.text, 7, "pose")
            if not np.linalg.norm(x[3:]) > 1e-9:
                raise self.fail(owner, f"pose: got {pose.text!r}, expected a quaternion that is not 0")
            return _turned(x[:3], x[3:] / np.linalg.norm(x[3:])), start
        x = self.numbers(owner, pose.text, 6, "pose")
        return _transform(x[:3], np.deg2rad(x[3:]) if in_degrees else x[3:]), start

    def number(self, owner: ET.Element, text: str, what: str) -> float:
        """Reads a number, which may be infinite."""
        try:
            found = float(text)
        except ValueError:
            found = np.nan
        if np.isnan(found):
            raise self.fail(owner, f"{what}: got {text!r}, expected a number")
        return found

    def link_of(self, name: str, depth: int = 0) -> Optional[str]:
        """Returns the link that a frame is fixed to; None if there is no such frame."""
        if name in ("", "__model__"):
            links = self.model.findall("link")
            return self.model.get("canonical_link") or (links[0].get("name", "") if links else None)
        if name not in self.named or depth > len(self.named):
            return None
        tag, element = self.named[name]
        if tag == "link":
            return name
        return self.link_of(element.findtext("child", "") if tag == "joint" else element.get("attached_to", ""), depth + 1)

    def end(self, joint: ET.Element, tag: str) -> str:
        """Returns the link at one end of a joint, or `world`."""
        given = joint.findtext(tag, "").strip()
        found = "world" if given == "world" and tag == "parent" else self.link_of(given) if given else None
        if found is None or found == "":
            raise self.fail(joint, f"got {given!r}, expected a link of the model")
        return found

    def pose(self, name: str, depth: int = 0) -> Array:
        """Returns the pose of a link, joint or frame in the coordinates of the world."""
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
        # Joints of a static model do not move.
        joints = [] if self.stands else self.model.findall("joint")
        above: Dict[str, ET.Element] = {}
        for joint in joints:
            child = self.end(joint, "child")
            if child in above:
                raise self.fail(joint, f"got the second joint above {child!r}, expected a tree")
            above[child] = joint
        # In a URDF, the frame of a link is that of the joint above it.
        frames = {link.get("name", ""): link.get("name", "") for link in self.model.findall("link")}
        frames.update({child: joint.get("name", "") for child, joint in above.items() if child in frames})
        roots = [name for name in frames if name not in above]
        anchored = any(self.end(joint, "parent") == "world" for joint in joints)
        fixed: List[str] = []
        if self.stands or anchored or (not self.moves and len(roots) > 1):
            fixed = roots
        elif len(roots) > 1:
            told = ", ".join(map(repr, roots))
            raise self.fail(self.model, f"got the links {told} that no joint moves or holds, expected one, or a joint to the world")
        elif frames and not roots:
            raise self.fail(self.model, "got links each of which hangs on another, expected a tree")
        elif roots and not np.array_equal(self.pose(frames[roots[0]]), np.eye(4)):
            fixed = roots
        out = [f"<robot name={quoteattr(self.name)}>"]
        if fixed or anchored:
            out.append('<link name="world"/>')
            frames["world"] = "world"
        for link in self.model.findall("link"):
            out.append(self.link(link, self.pose(frames[link.get("name", "")])))
        out += [self.joint(joint, frames) for joint in joints]
        for root in fixed:
            name = f"{root}__fixed"
            while name in self.named:
                name += "_"
            out.append(
                f'<joint name={quoteattr(name)} type="fixed"><parent link="world"/><child link={quoteattr(root)}/>'
                f"{_origin(self.pose(frames[root]))}</joint>"
            )
        return "".join(out) + "</robot>"

    def fixture(self, taken: Set[str], packages: Sequence[Any]) -> List[Fixture]:
        """Returns the model as a list of one obstacle, empty if the model has no shape."""
        text = self.urdf()
        if "<collision>" not in text:
            return []
        path, name = self.made.path("urdf"), self.name
        path.write_text(text, encoding="utf-8")
        while name in taken:
            name += "__model"
        if name != self.name:
            self.made.left_out.append(f"{self.file}: the model {self.name} is called {name} here, as its name is taken")
        taken.add(name)
        return [Fixture(path, name=name, packages=packages)]

    def check_limits(self, given: Set[str]) -> None:
        """Refuses joints without finite limits, which a scene cannot sample, unless the caller gives limits or locks them."""
        for name, found in self.without_limits.items():
            if name not in given:
                told = f'joint "{name}": got limits of {found}, expected finite ones'
                raise ValueError(f'{self.file}: {told}, or Robot.from_sdf(path, limits={{"{name}": (lower, upper)}})')

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
                return self.mesh(link, shape)
            told = f"{self.file}: link \"{link.get('name')}\": a collision shape <{shape.tag}>"
            if shape.tag == "ellipsoid":
                radii = self.numbers(link, shape.findtext("radii"), 3, "radii")
                if not (radii > 0).all():
                    raise self.fail(link, f"radii: got {shape.findtext('radii')!r}, expected three numbers above 0")
                path = self.made.path("obj")
                write_obj(path, *ellipsoid(radii))
                self.made.left_out.append(f"{told} is taken for a polyhedron around it, half a percent larger")
                return f"<mesh filename={quoteattr(str(path))}/>"
            if shape.tag != "empty":
                self.made.left_out.append(f"{told} is left out")
        return ""

    def mesh(self, link: ET.Element, shape: ET.Element) -> str:
        uri, part = shape.findtext("uri", "").strip(), shape.findtext("submesh/name")
        if shape.find("submesh") is not None:
            raise self.fail(link, f"got the part {part!r} of the mesh {uri!r}, expected a whole file: write the part to one of its own")
        if "://" not in uri:
            uri = os.path.join(os.path.dirname(os.path.abspath(self.file)), uri)
        scale = shape.findtext("scale", "1 1 1").strip()
        return f'<mesh filename={quoteattr(uri)} scale="{scale}"/>'

    def joint(self, joint: ET.Element, frames: Dict[str, str]) -> str:
        kind = _KINDS.get(joint.get("type", ""))
        if kind is None:
            raise self.fail(joint, f"got type {joint.get('type')!r}, expected {', '.join(_KINDS)}")
        ends = [self.end(joint, tag) for tag in ("parent", "child")]
        own = self.pose(joint.get("name", ""))
        out = "".join(f"<{tag} link={quoteattr(end)}/>" for tag, end in zip(("parent", "child"), ends))
        out += _origin(np.linalg.solve(self.pose(frames[ends[0]]), own))
        axis = joint.find("axis")
        if axis is not None and kind in ("revolute", "continuous", "prismatic"):
            out += self.axis(joint, axis, own)
        # SDF spells missing limits as 1e16; from 1e9 they count as infinite.
        if kind in ("revolute", "prismatic"):
            lower, upper = (
                self.number(joint, joint.findtext(f"axis/limit/{tag}", otherwise), f"limit: {tag}")
                for tag, otherwise in (("lower", "-inf"), ("upper", "inf"))
            )
            if kind == "revolute" and lower <= -1e9 and upper >= 1e9:
                kind = "continuous"
            elif max(abs(lower), abs(upper)) < 1e9:
                out += f'<limit lower="{lower:.17g}" upper="{upper:.17g}"/>'
            elif joint.find("axis/mimic") is None:
                self.without_limits[joint.get("name", "")] = f"{lower:g} to {upper:g}"
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
                self.number(joint, mimic.findtext(tag, "1" if tag == "multiplier" else "0"), f"mimic: {tag}")
                for tag in ("multiplier", "offset", "reference")
            )
            out += (
                f"<mimic joint={quoteattr(mimic.get('joint', ''))} multiplier=\"{factor:.17g}\" "
                f'offset="{offset - factor * reference:.17g}"/>'
            )
        return out
