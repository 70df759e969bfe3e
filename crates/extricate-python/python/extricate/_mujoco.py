"""Converts a compiled MuJoCo model to a robot: its shapes that can collide, its joints in their order, its pairs."""

from __future__ import annotations

import importlib
import tempfile
import warnings
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping, Set, Tuple
from xml.sax.saxutils import quoteattr

import numpy as np
import numpy.typing as npt

from ._meshes import ellipsoid, write_obj
from ._parts import Box, Capsule, Cylinder, HalfSpace, Mesh, MujocoRobot, Obstacle, Sphere

Array = npt.NDArray[Any]
_Pairs = List[Tuple[str, str]]
_KINDS = ("floating", "spherical", "prismatic", "revolute")
"""Types of joints in a URDF, by MuJoCo's number of the type."""


def converted(model: Any, options: Mapping[str, Any]) -> MujocoRobot:
    """Makes the robot of a model or an MJCF file; `options` are further arguments of `Robot`."""
    try:
        mujoco: Any = importlib.import_module("mujoco")
    except ImportError as error:
        raise ImportError("Robot.from_mujoco needs the package mujoco: pip install 'extricate[mujoco]'") from error
    if not isinstance(model, mujoco.MjModel):
        model = mujoco.MjModel.from_xml_path(str(model))
    return _Converter(mujoco, model).robot(dict(options))


def _text(numbers: Any) -> str:
    return " ".join(f"{x:.17g}" for x in np.atleast_1d(numbers))


def _rotation(quaternion: Any) -> Array:
    """Returns the matrix of a quaternion w, x, y, z, which is normalised first."""
    w, x, y, z = np.asarray(quaternion, dtype=np.float64) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _quaternion(axis: Any, angle: float) -> Array:
    return np.array([np.cos(angle / 2), *(np.sin(angle / 2) * np.asarray(axis))])


def _product(a: Any, b: Any) -> Array:
    """Multiplies two quaternions w, x, y, z."""
    return np.array(
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    )


def _origin(position: Any, quaternion: Any) -> str:
    w, x, y, z = quaternion
    return f'<origin xyz="{_text(position)}" quat_xyzw="{_text([x, y, z, w])}"/>'


class _Names:
    """Keeps names unique."""

    def __init__(self, *taken: str) -> None:
        self.taken = set(taken)

    def free(self, wanted: str) -> str:
        """Takes and returns the wanted name, or one like it if that is taken."""
        name, number = wanted, 2
        while name in self.taken:
            name, number = f"{wanted}__{number}", number + 1
        self.taken.add(name)
        return name


class _Converter:
    def __init__(self, mujoco: Any, model: Any) -> None:
        self.mujoco, self.model = mujoco, model
        self.folder = tempfile.TemporaryDirectory(prefix="extricate-mujoco-")
        self.meshes: Dict[Any, Path] = {}
        self.left_out: List[str] = []
        explicit = set(model.pair_geom1.tolist()) | set(model.pair_geom2.tolist())
        self.geoms = [
            [g for g in np.flatnonzero(model.geom_bodyid == body) if self.collides(int(g)) or int(g) in explicit]
            for body in range(model.nbody)
        ]
        # A body moves if it or a body above it has joints; MuJoCo numbers parents before their children.
        self.moves = np.zeros(model.nbody, dtype=bool)
        for body in range(1, model.nbody):
            self.moves[body] = self.moves[model.body_parentid[body]] or model.body_jntnum[body] > 0

        self.give_names()

    def given(self, kind: str, number: int) -> str:
        """Returns the name in the model, empty if there is none."""
        return self.mujoco.mj_id2name(self.model, getattr(self.mujoco.mjtObj, f"mjOBJ_{kind}"), number) or ""

    def name(self, kind: str, number: int, otherwise: str) -> str:
        return self.given(kind, number) or f"{otherwise}{number}"

    def give_names(self) -> None:
        """Chooses unique names for links, obstacles and joints. MJCF keeps names of bodies and geoms apart; here links and
        obstacles share one name space. Names of the model come before new ones."""
        model = self.model
        bodies = [self.given("BODY", body) for body in range(model.nbody)]
        self.names = _Names("world", *(name for name, moves in zip(bodies, self.moves) if moves and name))
        # Each geom of a body that does not move is an obstacle of its own, so that body is no link.
        standing = [int(geom) for body in np.flatnonzero(~self.moves) for geom in self.geoms[body]]
        self.obstacles: Dict[int, str] = {}
        for geom in standing:
            wanted = self.given("GEOM", geom)
            if wanted:
                taken = wanted in self.names.taken
                self.obstacles[geom] = self.names.free(f"{wanted}__geom" if taken else wanted)
                if taken:
                    self.left_out.append(f"the geom {wanted} is called {self.obstacles[geom]} here, as a body has its name")
        self.bodies: List[str] = []
        for body, (name, moves) in enumerate(zip(bodies, self.moves)):
            self.bodies.append(name or (self.names.free(f"body{body}") if moves else f"body{body}"))
        for geom in standing:
            if geom not in self.obstacles:
                self.obstacles[geom] = self.names.free(f"{self.bodies[model.geom_bodyid[geom]]}_geom{geom}")
        joints = [self.given("JOINT", joint) for joint in range(model.njnt)]
        self.joint_names = _Names(*filter(None, joints))
        self.joints = [name or self.joint_names.free(f"joint{joint}") for joint, name in enumerate(joints)]
        self.links = {int(body): list(self.groups(int(body))) for body in np.flatnonzero(self.moves)}

    def collides(self, geom: int) -> bool:
        return bool(self.model.geom_contype[geom] or self.model.geom_conaffinity[geom])

    def robot(self, options: Dict[str, Any]) -> MujocoRobot:
        model = self.model
        data = self.mujoco.MjData(model)
        data.qpos[:] = model.qpos0
        self.mujoco.mj_kinematics(model, data)
        everything = {name: geoms for links in self.links.values() for name, geoms in links if geoms}
        obstacles: List[Obstacle] = []
        for geom, name in self.obstacles.items():
            found = self.obstacle(geom, name, data)
            if found is not None:
                obstacles.append(found)
                everything[name] = [geom]
        text = self.urdf()
        index, qpos0 = self.coordinates(options.get("locked", {}))
        disable, enable = self.pairs(everything, options.get("locked", {}))
        self.tell_of_the_rest()
        for told in self.left_out:
            warnings.warn(f"from_mujoco: {told}", stacklevel=4)
        options.setdefault("geometry", "convex-hull")
        return MujocoRobot(
            text,
            **options,
            disable=disable,
            enable=enable,
            obstacles=obstacles,
            qpos_index=index,
            qpos0=qpos0,
            files=self.folder,
        )

    def tell_of_the_rest(self) -> None:
        """Notes what the robot does not take over from the model."""
        model = self.model
        equalities = [self.name("EQUALITY", k, "equality") for k in range(model.neq)]
        if equalities:
            self.left_out.append(f"equality constraints ({', '.join(equalities[:6])}) do not hold here")
        if model.opt.disableflags & self.mujoco.mjtDisableBit.mjDSBL_CONTACT:
            self.left_out.append('contacts are off in the model (<flag contact="disable"/>): here its pairs are checked all the same')
        for body in np.flatnonzero(model.body_mocapid >= 0):
            own = [name for geom, name in self.obstacles.items() if model.geom_bodyid[geom] == body]
            moved = ", ".join(f'"{name}": pose' for name in own[:6])
            told = f"the mocap body {self.bodies[body]} stands where the model has it"
            if own:
                told += f": where data.mocap_pos and mocap_quat have it elsewhere, go on with scene.moved({{{moved}}})"
            if any(self.moves[below] for below in np.flatnonzero(model.body_parentid == body)):
                told += "; what hangs on it by joints does not go with it"
            self.left_out.append(told)
        rigid = self.rigid({})
        for first, second in zip(model.pair_geom1, model.pair_geom2):
            if rigid[model.geom_bodyid[first]] == rigid[model.geom_bodyid[second]]:
                names = " and ".join(self.name("GEOM", int(geom), "geom") for geom in (first, second))
                why = "no joint moves one against the other, so that their distance never changes"
                self.left_out.append(f"the pair of {names} is not checked: {why}")

    def groups(self, body: int) -> Iterator[Tuple[str, List[int]]]:
        """Groups the geoms of a body by what they collide with. Each group is a link; the first has the name of the body."""
        found: Dict[Any, List[int]] = {}
        explicit = [set(pair) for pair in zip(self.model.pair_geom1.tolist(), self.model.pair_geom2.tolist())]
        for geom in self.geoms[body]:
            own = tuple(k for k, pair in enumerate(explicit) if int(geom) in pair)
            mask = (int(self.model.geom_contype[geom]), int(self.model.geom_conaffinity[geom]), own)
            found.setdefault(mask, []).append(int(geom))
        for number, geoms in enumerate(found.values()):
            yield self.names.free(f"{self.bodies[body]}__{number + 1}") if number else self.bodies[body], geoms

    def coordinates(self, locked: Mapping[str, float]) -> Tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
        index: List[int] = []
        qpos0 = np.array(self.model.qpos0, dtype=np.float64)
        for joint in range(self.model.njnt):
            at, kind = int(self.model.jnt_qposadr[joint]), int(self.model.jnt_type[joint])
            name = self.joints[joint]
            if name in locked:
                qpos0[at] = locked[name]
            else:
                # Quaternions have w first in MuJoCo, and last here.
                index += ([0, 1, 2, 4, 5, 6, 3], [1, 2, 3, 0], [0], [0])[kind]
                width = (7, 4, 1, 1)[kind]
                index[-width:] = [at + k for k in index[-width:]]
        return np.array(index, dtype=np.int64), qpos0

    def shape(self, geom: int) -> str:
        """Returns the URDF text of a geom's shape, empty if URDF has no such shape."""
        kinds, size = self.mujoco.mjtGeom, self.model.geom_size[geom]
        kind = kinds(int(self.model.geom_type[geom]))
        if kind == kinds.mjGEOM_BOX:
            return f'<box size="{_text(2 * size)}"/>'
        if kind == kinds.mjGEOM_SPHERE:
            return f'<sphere radius="{size[0]:.17g}"/>'
        if kind in (kinds.mjGEOM_CYLINDER, kinds.mjGEOM_CAPSULE):
            tag = "cylinder" if kind == kinds.mjGEOM_CYLINDER else "capsule"
            return f'<{tag} radius="{size[0]:.17g}" length="{2 * size[1]:.17g}"/>'
        source = self.mesh(geom)
        return f'<mesh filename={quoteattr(str(source))}/>' if source else ""

    def mesh(self, geom: int) -> Any:
        """Writes the mesh file of a mesh or an ellipsoid and returns its path; notes other geoms and returns None."""
        kinds = self.mujoco.mjtGeom
        kind = kinds(int(self.model.geom_type[geom]))
        name = self.name("GEOM", geom, "geom")
        key: Any = int(self.model.geom_dataid[geom])
        if kind == kinds.mjGEOM_MESH:
            first, faces = self.model.mesh_vertadr[key], self.model.mesh_faceadr[key]
            vertices = self.model.mesh_vert[first : first + self.model.mesh_vertnum[key]]
            triangles = self.model.mesh_face[faces : faces + self.model.mesh_facenum[key]]
        elif kind == kinds.mjGEOM_ELLIPSOID:
            key = tuple(self.model.geom_size[geom])
            vertices, triangles = ellipsoid(key)
            self.left_out.append(f"the ellipsoid {name} is taken for a polyhedron around it, half a percent larger")
        else:
            kind_name = kind.name.replace("mjGEOM_", "").lower()
            self.left_out.append(f"the {kind_name} {name} is left out")
            return None
        if key not in self.meshes:
            path = Path(self.folder.name) / f"{len(self.meshes)}.obj"
            write_obj(path, vertices, triangles)
            self.meshes[key] = path
        return self.meshes[key]

    def obstacle(self, geom: int, name: str, data: Any) -> Any:
        """Makes the obstacle of a geom that does not move; None if its shape is left out."""
        kinds, size = self.mujoco.mjtGeom, self.model.geom_size[geom]
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        kind = kinds(int(self.model.geom_type[geom]))
        if kind == kinds.mjGEOM_PLANE:
            return HalfSpace([0, 0, 1], 0.0, pose, name)
        if kind == kinds.mjGEOM_BOX:
            return Box(2 * size, pose, name)
        if kind == kinds.mjGEOM_SPHERE:
            return Sphere(float(size[0]), pose, name)
        if kind in (kinds.mjGEOM_CYLINDER, kinds.mjGEOM_CAPSULE):
            made = Cylinder if kind == kinds.mjGEOM_CYLINDER else Capsule
            return made(float(size[0]), float(2 * size[1]), pose, name)
        source = self.mesh(geom)
        return Mesh(source, pose, name, convex=True) if source else None

    def urdf(self) -> str:
        # Names of the form `mujoco/name` must not collide with names of the model.
        robot = "mujoco"
        while any(name.startswith(f"{robot}/") for name in self.names.taken | self.joint_names.taken):
            robot += "_"
        out = [f'<robot name="{robot}"><link name="world"/>']
        for body in np.flatnonzero(self.moves):
            out.append(self.body(int(body)))
        return "".join(out) + "</robot>"

    def body(self, body: int) -> str:
        """Returns the URDF text of a link for every joint, one after the other, and then the body itself, fixed to the last of
        them."""
        model, out = self.model, ""
        parent = int(model.body_parentid[body])
        position, quaternion = model.body_pos[body].copy(), model.body_quat[body].copy()
        if self.moves[parent]:
            above = self.bodies[parent]
        else:
            above = "world"
            data = self.mujoco.MjData(model)
            self.mujoco.mj_kinematics(model, data)
            position = data.xpos[parent] + data.xmat[parent].reshape(3, 3) @ position
            quaternion = _product(data.xquat[parent], quaternion)
        anchor = np.zeros(3)
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            name, kind = self.joints[joint], _KINDS[model.jnt_type[joint]]
            axis, limits = model.jnt_axis[joint], ""
            reference = float(model.qpos0[model.jnt_qposadr[joint]])
            limited = bool(model.jnt_limited[joint])
            if kind == "floating":
                position, quaternion, new_anchor = np.zeros(3), np.array([1.0, 0, 0, 0]), np.zeros(3)
            else:
                new_anchor = model.jnt_pos[joint].copy() if kind != "prismatic" else anchor.copy()
                position = position + _rotation(quaternion) @ (new_anchor - anchor)
                # MuJoCo measures positions from qpos0; moving the frame back by it makes positions equal in both.
                if kind == "revolute":
                    quaternion = _product(quaternion, _quaternion(axis, -reference))
                elif kind == "prismatic":
                    position = position - _rotation(quaternion) @ axis * reference
            if kind == "revolute" and not limited:
                kind = "continuous"
            if limited and kind in ("revolute", "prismatic"):
                lower, upper = model.jnt_range[joint]
                limits = f'<limit lower="{lower:.17g}" upper="{upper:.17g}"/>'
            elif limited:
                self.left_out.append(f"the limit of the ball joint {name} is left out")
            carried = self.names.free(f"{self.bodies[body]}__{name}")
            child = quoteattr(carried)
            out += (
                f"<link name={child}/><joint name={quoteattr(name)} type=\"{kind}\"><parent link={quoteattr(above)}/>"
                f"<child link={child}/>{_origin(position, quaternion)}<axis xyz=\"{_text(axis)}\"/>{limits}</joint>"
            )
            above = carried
            position, quaternion, anchor = np.zeros(3), np.array([1.0, 0, 0, 0]), new_anchor
        links = self.links[body] or [(self.bodies[body], [])]
        if model.body_jntnum[body]:
            position = -anchor
        for name, geoms in links:
            parts = ""
            for geom in geoms:
                shape = self.shape(geom)
                if shape:
                    origin = _origin(model.geom_pos[geom], model.geom_quat[geom])
                    parts += f"<collision>{origin}<geometry>{shape}</geometry></collision>"
            fixed = quoteattr(self.joint_names.free(f"{name}__fixed"))
            out += (
                f"<link name={quoteattr(name)}>{parts}</link><joint name={fixed} type=\"fixed\">"
                f"<parent link={quoteattr(above)}/><child link={quoteattr(name)}/>{_origin(position, quaternion)}</joint>"
            )
        return out

    def pairs(self, everything: Mapping[str, List[int]], locked: Mapping[str, float]) -> Tuple[_Pairs, _Pairs]:
        """Returns the pairs to disable, which MuJoCo does not check, and those to enable, which it checks although one joint
        joins them."""
        model = self.model
        excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
        explicit = {frozenset(pair) for pair in zip(model.pair_geom1.tolist(), model.pair_geom2.tolist())}
        body_of = {name: int(model.geom_bodyid[geoms[0]]) for name, geoms in everything.items()}
        names, disable, enable = list(everything), [], []
        rigid = self.rigid(locked)
        for k, a in enumerate(names):
            for b in names[k + 1 :]:
                first, second = body_of[a], body_of[b]
                if not (self.moves[first] or self.moves[second]):
                    continue
                x, y = everything[a][0], everything[b][0]
                meet = (model.geom_contype[x] & model.geom_conaffinity[y]) or (
                    model.geom_contype[y] & model.geom_conaffinity[x]
                )
                is_excluded = (first, second) in excluded or (second, first) in excluded
                is_checked = meet and not is_excluded and not self.are_neighbours(first, second)
                if not is_checked and not any(frozenset((x, y)) in explicit for x in everything[a] for y in everything[b]):
                    disable.append((a, b))
                elif self.moves[first] and self.moves[second] and self.are_joined(rigid, first, second):
                    enable.append((a, b))
        return disable, enable

    def rigid(self, locked: Mapping[str, float]) -> List[int]:
        """Returns, for each body, the body that it is fixed to if `locked` joints do not move: itself, if a joint moves it."""
        model, out = self.model, [0]
        for body in range(1, model.nbody):
            own = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
            moves = any(self.joints[joint] not in locked for joint in own)
            out.append(body if moves else out[model.body_parentid[body]])
        return out

    def are_joined(self, rigid: Any, first: int, second: int) -> bool:
        """Whether a joint connects the two bodies; `rigid` lists, for each body, the one that it is fixed to."""
        a, b, parent = int(rigid[first]), int(rigid[second]), self.model.body_parentid
        return a != b and bool(rigid[parent[a]] == b or rigid[parent[b]] == a)

    def are_neighbours(self, first: int, second: int) -> bool:
        """Whether MuJoCo treats the two bodies as one rigid body, or as parent and child; the world has no neighbours."""
        weld = self.model.body_weldid
        ids: Set[int] = {int(weld[first]), int(weld[second])}
        if len(ids) == 1:
            return True
        if 0 in ids or self.model.opt.disableflags & self.mujoco.mjtDisableBit.mjDSBL_FILTERPARENT:
            return False
        return self.are_joined(weld, first, second)
