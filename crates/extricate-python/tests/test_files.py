"""Worlds in files, and configurations by name."""

import pathlib
import types
import warnings

import numpy as np
import pytest

import extricate
from extricate import Box, Robot, Scene, Sphere

SLIDER = """<robot name="slider"><link name="rail"/><link name="cart"><collision><geometry><box size="2 2 2"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-10" upper="10" effort="1" velocity="1"/></joint></robot>"""
# Two joints that move, one that follows, one that is locked, one that is fixed.
ARM = """<robot name="arm"><link name="base"/>{}</robot>""".format("".join(
    f"""<link name="{child}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/>{more}</joint>"""
    for name, kind, parent, child, more in [
        ("shoulder", "revolute", "base", "upper", ""), ("elbow", "revolute", "upper", "fore", ""),
        ("finger", "revolute", "fore", "tip", '<mimic joint="elbow" multiplier="0.5"/>'),
        ("lid", "revolute", "fore", "cover", ""), ("bolt", "fixed", "base", "foot", ""),
    ]))
SCENE = "(noname)+\n* table\n0 0 0\n0 0 0 1\n1\nbox\n2 2 2\n5 0 0\n0 0 0.7071 0.7071\n1 0 0 1\n0\n.\n"


@pytest.fixture
def arm() -> Scene:
    return Scene(Robot(ARM, locked={"lid": 0.25}))


def test_worlds_of_other_programs_are_taken_and_what_is_left_out_is_told(tmp_path: pathlib.Path) -> None:
    (tmp_path / "table.scene").write_text(SCENE)
    (tmp_path / "slider.urdf").write_text(SLIDER)
    slider = Scene(SLIDER, [Sphere(1, [0, 5, 0])])
    with pytest.warns(UserWarning, match="colours are not taken"):
        there = slider.in_world(tmp_path / "table.scene")
    assert there.bodies == ["cart", "table"] and there.distances([1.0]) == pytest.approx(2)
    with pytest.warns(UserWarning, match="colours are not taken"):
        written = extricate.import_world(tmp_path / "table.scene", tmp_path / "world.toml")
    assert written == [tmp_path / "world.toml"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert slider.in_world(tmp_path / "world.toml").distances([1.0]) == there.distances([1.0])
    with pytest.warns(UserWarning):
        extricate.import_world(tmp_path / "table.scene", str(tmp_path / "scene.toml"), robot=tmp_path / "slider.urdf")
        extricate.import_world(tmp_path / "table.scene", tmp_path / "other.toml", robot=slider)
    assert Scene.load(tmp_path / "scene.toml").distances([1.0]) == there.distances([1.0])
    (tmp_path / "bad.scene").write_text(SCENE.replace("2 2 2", "2 x 2"))
    with pytest.raises(ValueError, match="bad.scene: line 7: got `x`, expected the sides x, y, z of a box"):
        slider.in_world(tmp_path / "bad.scene")
    with pytest.raises(FileNotFoundError, match="cannot read .*none.scene"):
        extricate.import_world(tmp_path / "none.scene", tmp_path / "w.toml")
    with pytest.raises(OSError, match="exists and is no scene written by import"):
        extricate.import_world(tmp_path / "table.scene", tmp_path / "slider.urdf")


def test_poses_take_quaternions_by_name() -> None:
    half = np.sqrt(0.5)
    turned = [{"xyz": [5, 0, 0], "quat_xyzw": [0, 0, half, half]}, {"xyz": [5, 0, 0], "quat_wxyz": [half, 0, 0, half]},
              {"xyz": [5, 0, 0], "rpy": [0, 0, np.pi / 2]}, [5, 0, 0, 0, 0, np.pi / 2]]
    for pose in turned:
        assert Scene(SLIDER, [Box([2, 4, 2], pose)]).distances([0.0]) == pytest.approx(2)  # type: ignore[arg-type]
    scene = Scene(SLIDER, [Box([2, 4, 2], name="box")])
    assert scene.moved({"box": turned[0]}).distances([0.0]) == pytest.approx(2)  # type: ignore[dict-item]
    for pose, message in [
        ([5, 0, 0, 0, 0, 0, 1], r"got shape \(7,\), expected .*quat_xyzw.*where the key tells the order of the quaternion"),
        ({"xyz": [0, 0, 0], "quat": [0, 0, 0, 1]}, 'pose: got "quat", expected "xyz" or "rpy" or "quat_xyzw" or "quat_wxyz"'),
        ({"quat_xyzw": [0, 0, 1]}, r'pose\["quat_xyzw"\]: got 3 numbers, expected 4'),
        ({"quat_xyzw": [0, 0, 0, 2]}, "quat_xyzw: got a quaternion of length 2, expected length 1"),
    ]:
        with pytest.raises(ValueError, match=message):
            Scene(SLIDER, [Box([2, 4, 2], pose)])  # type: ignore[arg-type]


def test_joint_states_are_configurations_and_back(arm: Scene) -> None:
    names, positions = ["elbow", "lid", "finger", "bolt", "shoulder"], [0.5, 0.25, 0.25, 0.0, -1.0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for given in [dict(zip(names, positions)), {"name": names, "position": positions}, types.SimpleNamespace(name=names, position=positions)]:
            assert arm.config(given).tolist() == [-1, 0.5]
        back = arm.positions([-1, 0.5])
        assert back == {"shoulder": -1, "elbow": 0.5, "finger": 0.25, "lid": 0.25}
        assert arm.config(back).tolist() == [-1, 0.5]
    with pytest.warns(UserWarning, match="joint `lid` is locked: got 0.5, the scene has it at 0.25"):
        arm.config({"elbow": 0, "shoulder": 0, "lid": 0.5})
    with pytest.warns(UserWarning, match="joint `finger` follows another joint: got 1, the scene has it at 0"):
        arm.config({"elbow": 0, "shoulder": 0, "finger": 1})
    with pytest.raises(ValueError, match="position: got 1 numbers, expected 5, one for each name"):
        arm.config({"name": names, "position": [0.0]})
    with pytest.raises(TypeError, match="positions: got int, expected a dict by joint, or a JointState"):
        arm.config(3)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"q: got shape \(3,\)"):
        arm.positions([0, 0, 0])
    box = Scene.builtin("free-box")
    q = box.sample(1)[0]
    named = box.positions(q)
    assert [value.shape for value in named.values()] == [(7,)]
    np.testing.assert_allclose(box.config(named), q, atol=1e-15)


def test_degrees_are_told(arm: Scene) -> None:
    hint = "angles are in rad: all of them would be within their limits if these were degrees"
    for refusing in [arm.check, arm.distances, arm.colliding_pairs]:
        with pytest.raises(ValueError, match=hint):
            refusing([90.0, 45.0])
    scene = Scene(Robot(ARM, locked={"lid": 0.25}), [Sphere(0.3, [2, 0, 0])])
    with pytest.warns(UserWarning, match=f"q: {hint}"):
        scene.query([90.0, 45.0])
    with pytest.warns(UserWarning, match=rf"Q\[1\]: {hint}"):
        scene.query_batch([[0.5, 0.5], [90.0, 45.0]])


def test_millimetres_are_told() -> None:
    with pytest.warns(UserWarning, match="obstacle `box1` is 300 m thick, more than 50 times the robot's reach of .* lengths are in m, not mm"):
        scene = Scene(ARM, [Box([300, 600, 400], [450, 0, 450])])
    with pytest.warns(UserWarning, match="obstacle `ball` is 400 m thick, more than 50 times"):
        scene.with_obstacles([Sphere(200, name="ball")])
    with pytest.warns(UserWarning, match="attached `rod` is 400 m thick, more than 50 times"):
        scene.attach(Sphere(200, name="rod"), link="tip")
