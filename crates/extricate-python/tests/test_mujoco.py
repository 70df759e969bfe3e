"""Verdicts of MuJoCo and of the robots made from its models: random models, names, pairs, and warnings."""

import dataclasses
import os
import warnings
from typing import Any, List, Tuple

import numpy as np
import pytest

from extricate import Robot, Scene

mujoco: Any = pytest.importorskip("mujoco")
HINGE = '<joint type="hinge" axis="0 0 1" range="-178 178" limited="true"/>'


def loaded(model: Any, **options: Any) -> Tuple[Any, Scene, List[str]]:
    """Returns the robot of a model, its scene, and the warnings."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        robot = Robot.from_mujoco(model, **options)
        scene = Scene(robot)
    return robot, scene, [str(warning.message) for warning in told]


def nearest(model: Any, data: Any) -> float:
    """Returns MuJoCo's least distance of a contact between bodies that can move against each other; inf without one."""
    mujoco.mj_fwdPosition(model, data)
    weld, of = model.body_weldid, model.geom_bodyid
    contacts = [c.dist for c in data.contact[: data.ncon] if weld[of[c.geom[0]]] != weld[of[c.geom[1]]]]
    return float(min(contacts, default=np.inf))


def drawn(model: Any, rng: Any) -> Any:
    """Draws a configuration within the limits."""
    qpos = model.qpos0.copy()
    for joint in range(model.njnt):
        at, kind = model.jnt_qposadr[joint], model.jnt_type[joint]
        if kind == 0:
            qpos[at : at + 3] = rng.uniform(-0.5, 0.5, 3)
        if kind < 2:
            turn, at = rng.normal(size=4), at + (3 if kind == 0 else 0)
            qpos[at : at + 4] = turn / np.linalg.norm(turn)
        else:
            qpos[at] = rng.uniform(*model.jnt_range[joint]) if model.jnt_limited[joint] else rng.uniform(-3, 3)
    return qpos


def differing(model: Any, robot: Any, scene: Scene, count: int, rng: Any) -> Tuple[int, int]:
    """Counts random configurations with different verdicts, and those that overlap in MuJoCo. Within 0.3 mm of contact, both verdicts
    are accepted."""
    data, differ, overlap = mujoco.MjData(model), 0, 0
    for _ in range(count):
        data.qpos[:] = drawn(model, rng)
        theirs, mine = nearest(model, data), float(scene.distances(robot.q(data.qpos)))
        overlap += theirs < 0
        differ += (theirs < 0) != (mine < 0) and abs(mine) > 3e-4
    return differ, overlap


class Drawing:
    """A random MJCF text: trees of bodies, several joints of all kinds per body, masks, pairs, exclusions, shared names."""

    def __init__(self, rng: Any) -> None:
        self.rng, self.bodies, self.geoms = rng, [], []  # type: Any, List[str], List[str]

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def numbers(self, low: float, high: float, count: int) -> str:
        return " ".join(f"{x:.4f}" for x in self.rng.uniform(low, high, count))

    def name(self, kind: str, names: List[str]) -> str:
        """Draws an attribute `name`: often none, often the name of another kind of element, or one that the conversion makes."""
        if self.chance(0.3):
            return ""
        free = [n for n in ("a", "b", "body1", "body2", "geom1", "a__2", "a__joint0", "world_geom0") if n not in names]
        names.append(str(self.rng.choice(free)) if free and self.chance(0.5) else f"{kind}{len(names)}_")
        return f'name="{names[-1]}"'

    def geom(self) -> str:
        kind = self.rng.choice(["sphere", "capsule", "box", "cylinder"])
        size = {"sphere": self.numbers(0.03, 0.08, 1), "box": self.numbers(0.02, 0.09, 3)}.get(kind, self.numbers(0.02, 0.08, 2))
        mask = f'contype="{self.rng.integers(0, 4)}" conaffinity="{self.rng.integers(0, 4)}"' if self.chance(0.4) else ""
        place = f'pos="{self.numbers(-0.12, 0.12, 3)}" euler="{self.numbers(-90, 90, 3)}"'
        return f'<geom {self.name("geom", self.geoms)} type="{kind}" size="{size}" {place} {mask}/>'

    def joint(self, joints: List[str]) -> str:
        kind = self.rng.choice(["hinge", "hinge", "slide", "ball"])
        name, place = self.name("joint", joints), f'pos="{self.numbers(-0.05, 0.05, 3)}" axis="{self.numbers(0.1, 1, 3)}"'
        span, reference = {"hinge": "-150 150", "slide": "-0.2 0.2", "ball": ""}[kind], {"hinge": "20", "slide": "0.03"}.get(kind)
        limits = f'range="{span}" limited="true"' if kind == "slide" or (span and self.chance(0.7)) else ""
        ref = f'ref="{reference}"' if reference and self.chance(0.4) else ""
        return f'<joint {name} type="{kind}" {place} {limits} {ref}/>'

    def body(self, depth: int, joints: List[str]) -> str:
        own = "".join(self.joint(joints) for _ in range(self.rng.choice([0, 1, 1, 1, 2])))
        # MuJoCo takes no rotational joint after a ball joint.
        own = own[: own.index("/>", own.index('"ball"')) + 2] if '"ball"' in own else own
        if depth == 0 and self.chance(0.2):
            own = f'<freejoint {self.name("joint", joints)}/>'
        head = f'<body {self.name("body", self.bodies)} pos="{self.numbers(-0.3, 0.3, 3)}" euler="{self.numbers(-60, 60, 3)}">'
        geoms = "".join(self.geom() for _ in range(self.rng.integers(1, 4)))
        below = "".join(self.body(depth + 1, joints) for _ in range(self.rng.integers(0, 3))) if depth < 2 else ""
        return head + own + geoms + below + "</body>"

    def text(self) -> str:
        joints: List[str] = []
        world = "".join(self.geom() for _ in range(self.rng.integers(0, 3)))
        plane = '<geom type="plane" size="1 1 1" pos="0 0 -0.4"/>' if self.chance(0.4) else ""
        bodies = "".join(self.body(0, joints) for _ in range(self.rng.integers(1, 4)))
        contact = ""
        for _ in range(self.rng.integers(0, 4)):
            if len(self.geoms) > 1:
                one, other = self.rng.choice(self.geoms, 2, replace=False)
                contact += f'<pair geom1="{one}" geom2="{other}"/>'
        if len(self.bodies) > 1 and self.chance(0.5):
            one, other = self.rng.choice(self.bodies, 2, replace=False)
            contact += f'<exclude body1="{one}" body2="{other}"/>'
        flag = '<option><flag filterparent="disable"/></option>' if self.chance(0.4) else ""
        return f"<mujoco>{flag}<worldbody>{world}{plane}{bodies}</worldbody><contact>{contact}</contact></mujoco>"


def test_random_models_have_mujocos_verdicts() -> None:
    """EXTRICATE_MJCF_MODELS sets another number of models, with 60 configurations each."""
    count, rng = int(os.environ.get("EXTRICATE_MJCF_MODELS", "12")), np.random.default_rng(11)
    differ, overlap, done, joined = [], 0, 0, 0
    while done < count:
        text = Drawing(rng).text()
        model = mujoco.MjModel.from_xml_string(text)
        if model.nq == 0:
            continue
        free = [k for k in range(model.njnt) if model.jnt_type[k] == 0]
        names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) or f"joint{k}" for k in free]
        try:
            robot, scene, _ = loaded(model, limits={name: (-1.0, 1.0) for name in names})
        except ValueError as error:
            raise AssertionError(f"{error} in {text}") from error
        wrong, overlapping = differing(model, robot, scene, 60, rng)
        if wrong:
            differ.append((wrong, text))
        overlap, done, joined = overlap + overlapping, done + 1, joined + bool(robot.enable)
    print(f"{done} models, 60 configurations each: {overlap} overlap, {len(differ)} models differ, {joined} check neighbours")
    assert not differ, differ
    assert overlap > 6 * count and joined > count / 10


TWO = """<mujoco>%s<worldbody><geom name="wall" type="box" size=".1 .1 .1" pos=".25 .1 0"/>
  <body name="a">%s<geom name="ga" type="capsule" size=".05" fromto="0 0 0 1 0 0"/>
    <body name="b" pos="1.2 0 0">%s<geom name="gb" type="capsule" size=".05" fromto="0 0 0 1 0 0"/></body></body>
  </worldbody>%s</mujoco>"""


def two(option: str = "", contact: str = "", joints: Tuple[str, str] = (HINGE, HINGE)) -> str:
    return TWO % (option, *joints, contact)


@pytest.mark.parametrize(
    "text",
    [
        two('<option><flag filterparent="disable"/></option>'),
        two(contact='<contact><pair geom1="ga" geom2="gb"/></contact>'),
    ],
)
def test_a_body_and_its_child_are_checked_where_mujoco_does(text: str) -> None:
    model = mujoco.MjModel.from_xml_string(text)
    robot, scene, told = loaded(model)
    assert robot.enable == [("a", "b")] and ("a", "b") in scene.pairs and not told
    folded = robot.q([2.0, 3.1])
    assert not scene.check(folded) and scene.colliding_pairs(folded) == [("a", "b")]
    # The caller can disable the pair.
    assert ("a", "b") not in Scene(robot, disable=[("b", "a")]).pairs
    assert ("a", "b") not in Scene(robot, disable=[("mujoco/b", "a")]).pairs
    assert ("a", "b") not in Scene(dataclasses.replace(robot, name="left"), disable=[("b", "left/a")]).pairs
    # A locked joint makes the bodies on either side of it one, so that `a` and `c` become neighbours.
    three = text.replace("</body></body>", f'<body name="c" pos="1 0 0">{HINGE}<geom size=".05" pos=".2 0 0"/></body></body></body>')
    model = mujoco.MjModel.from_xml_string(three)
    second = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, 1) or "joint1"
    _, scene, _ = loaded(model, locked={second: 3.1})
    assert ("a", "c") in scene.pairs


def test_pairs_that_nothing_moves_are_told() -> None:
    text = two(contact='<contact><pair geom1="ga" geom2="gb"/></contact>', joints=(HINGE, ""))
    robot, scene, told = loaded(mujoco.MjModel.from_xml_string(text))
    assert any("the pair of ga and gb is not checked: no joint moves one against the other" in t for t in told), told
    assert scene.pairs == [("a", "wall"), ("b", "wall")]


@pytest.mark.parametrize(
    "text, bodies",
    [
        (two().replace('name="wall"', 'name="a"'), ["a", "b", "a__geom"]),
        (two().replace('name="wall"', 'name="world"'), ["a", "b", "world__geom"]),
        (two().replace('name="wall"', 'name="a__joint0"'), ["a", "b", "a__joint0"]),
        (two().replace('name="a"', "").replace('name="b"', 'name="body1"'), ["body1__2", "body1", "wall"]),
        (two().replace("<joint ", '<joint name="joint1" ', 1), ["a", "b", "wall"]),
        (two().replace("<joint ", '<joint name="b__fixed" ', 1), ["a", "b", "wall"]),
        (two().replace('name="a"', 'name="mujoco/b"'), ["mujoco/b", "b", "wall"]),
        (
            two().replace("<body name=\"b\"", '<geom size=".04" contype="2" conaffinity="2"/><body name="a__2"'),
            ["a", "a__2__2", "a__2", "wall"],
        ),
    ],
)
def test_bodies_geoms_and_joints_have_names_of_their_own(text: str, bodies: List[str]) -> None:
    model = mujoco.MjModel.from_xml_string(text)
    robot, scene, told = loaded(model)
    assert scene.bodies == bodies
    renamed = [name for name in bodies if name.endswith("__geom")]
    assert len(told) == len(renamed) and all(name in t for name, t in zip(renamed, told))
    differ, overlap = differing(model, robot, scene, 60, np.random.default_rng(2))
    assert differ == 0 and 0 < overlap < 60


def test_mocap_bodies_and_contacts_that_are_off_are_told() -> None:
    mocap = '<body name="m" mocap="true" pos="0 3 0"><geom name="part" type="box" size=".2 .2 .2"/>%s</body><body name="a"'
    model = mujoco.MjModel.from_xml_string(two().replace('<body name="a"', mocap % "", 1))
    robot, scene, told = loaded(model)
    assert len(told) == 1 and 'the mocap body m stands where the model has it' in told[0]
    assert 'scene.moved({"part": pose})' in told[0] and "hangs on it" not in told[0]
    data = mujoco.MjData(model)
    data.mocap_pos[0] = [1.0, 0.5, 0]
    mujoco.mj_kinematics(model, data)
    part = model.geom("part").id
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = data.geom_xmat[part].reshape(3, 3), data.geom_xpos[part]
    moved = scene.moved({"part": pose})
    rng, overlap = np.random.default_rng(4), 0
    for _ in range(60):
        data.qpos[:] = drawn(model, rng)
        theirs = nearest(model, data)
        overlap += theirs < 0
        assert (theirs < 0) == (float(moved.distances(robot.q(data.qpos))) < 0)
    assert 10 < overlap < 60
    hanging = mocap % f'<body name="k" pos="1 0 0">{HINGE}<geom size=".1"/></body>'
    _, _, told = loaded(mujoco.MjModel.from_xml_string(two().replace('<body name="a"', hanging, 1)))
    assert any("what hangs on it by joints does not go with it" in t for t in told)
    _, scene, told = loaded(mujoco.MjModel.from_xml_string(two('<option><flag contact="disable"/></option>')))
    assert len(told) == 1 and "contacts are off in the model" in told[0] and scene.pairs
