"""Robots and meshes of other packages: MuJoCo, xacro, SDF, trimesh."""

import pathlib
import warnings
from typing import Any, List, Tuple

import numpy as np
import pytest

import extricate
from extricate import Box, Fixture, Mesh, Robot, Scene
from test_scene import CUBE, SLIDER

MJCF = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="1 1 1"/>
  <body name="shelf" pos="0 0.4 0.5"><geom name="board" type="box" size="0.2 0.05 0.01"/></body>
  <body name="upper" pos="0 0 0.5" euler="0 0 30"><geom type="capsule" size="0.04 0.1" pos="0.1 0 0" euler="0 90 0"/>
    <joint name="turn" axis="0 0 1" range="-120 120" ref="20" pos="0.02 0 0"/><joint name="lift" axis="0 1 0" range="-60 60"/>
    <body name="lower" pos="0.25 0 0"><joint name="push" type="slide" axis="1 0 0" range="-0.05 0.1" ref="0.02"/>
      <geom type="box" size="0.08 0.03 0.03"/><geom name="sensor" type="sphere" size="0.05" contype="2" conaffinity="2"/>
      <body name="tip" pos="0.15 0 0"><joint name="ball" type="ball"/><geom type="ellipsoid" size="0.06 0.03 0.02"/></body>
    </body>
  </body>
  <body name="free" pos="0.3 -0.3 0.6"><freejoint name="flight"/><geom type="cylinder" size="0.05 0.1"/>
    <geom type="sphere" size="0.04" pos="0 0 0.1" contype="2" conaffinity="2"/></body>
</worldbody><contact><exclude body1="upper" body2="free"/></contact></mujoco>"""


def uniform(scene: Scene, n: int) -> Any:
    rng = np.random.default_rng(5)
    Q = rng.uniform(np.maximum(scene.lower, -0.6), np.minimum(scene.upper, 0.9), (n, scene.nq))
    for joint in scene.joints:
        if joint.kind in ("floating", "spherical"):
            turns = rng.normal(size=(n, 4))
            Q[:, joint.stop - 4 : joint.stop] = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    return Q


def test_a_mujoco_model_has_its_pairs_and_its_verdicts() -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(MJCF)
    with pytest.warns(UserWarning) as told:
        robot = Robot.from_mujoco(model, limits={"flight": (-2.0, 2.0)})
    assert any("ellipsoid" in str(warning.message) for warning in told)
    scene = Scene(robot)
    assert [joint.kind for joint in scene.joints] == ["revolute", "revolute", "prismatic", "spherical", "floating"]
    assert scene.nq == model.nq and "floor" in scene.bodies and "lower__2" in scene.bodies
    Q = uniform(scene, 1500)
    assert np.array_equal(robot.q(robot.qpos(Q)), Q)
    data, verdicts, depths = mujoco.MjData(model), [], []
    for qpos in robot.qpos(Q):
        data.qpos[:] = qpos
        mujoco.mj_fwdPosition(model, data)
        depth = min([contact.dist for contact in data.contact[: data.ncon]], default=np.inf)
        verdicts.append(depth < 0)
        depths.append(depth)
    mine = ~scene.check(Q)
    assert 0.1 < mine.mean() < 0.9
    differ = mine != np.array(verdicts)
    # The polyhedron around the ellipsoid is half a percent larger.
    assert differ.mean() < 0.01
    assert all(-1e-3 < depth < 1e-3 for depth in np.array(depths)[differ] if np.isfinite(depth))
    answers = scene.query_batch(Q[mine][:50])
    for qpos in robot.qpos(answers["witness"]):
        data.qpos[:] = qpos
        mujoco.mj_fwdPosition(model, data)
        assert all(contact.dist >= 0 for contact in data.contact[: data.ncon])
    # The same in MuJoCo's own coordinates; what is free stays.
    states = robot.qpos(Q[:40])
    reset, moved = robot.reset(states, scene=scene)
    assert ((moved > 0) == mine[:40]).all() and (reset[~mine[:40]] == states[~mine[:40]]).all()
    assert scene.check(robot.q(reset)).all() and not (reset[mine[:40]] == states[mine[:40]]).all(axis=1).any()
    one, distance = robot.reset(states[0])
    assert one.shape == states[0].shape and distance.shape == () and (one == reset[0]).all()


def test_what_mujoco_has_besides_is_told() -> None:
    mujoco = pytest.importorskip("mujoco")
    text = MJCF.replace("</mujoco>", "<equality><joint name='tie' joint1='turn' joint2='lift'/></equality></mujoco>")
    with pytest.warns(UserWarning, match=r"equality constraints \(tie\) do not hold here"):
        robot = Robot.from_mujoco(mujoco.MjModel.from_xml_string(text), locked={"lift": 0.25})
    assert "lift" not in [joint.name for joint in Scene(robot).joints]
    assert robot.qpos(robot.q(robot.qpos0))[1] == 0.25


def test_a_xacro_file_is_expanded(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("xacrodoc")
    (tmp_path / "cube.obj").write_text("".join("v %g %g %g\n" % tuple(v) for v in CUBE[0]) + "".join("f %d %d %d\n" % tuple(t + 1) for t in CUBE[1]))
    file = tmp_path / "slider.urdf.xacro"
    file.write_text(
        SLIDER.replace("<robot", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'")
        .replace('<link name="rail"/>', '<xacro:arg name="reach" default="1"/><link name="rail"/>')
        .replace('upper="10"', 'upper="${2 * $(arg reach)}"')
        .replace('<box size="2 2 2"/>', '<mesh filename="cube.obj"/>')
    )
    assert Scene(Robot.from_xacro(file)).upper == [2.0]
    scene = Scene(Robot.from_xacro(file, reach=3, options={"limits": {"slide": (-1.0, 6.0)}}), [Box([1, 1, 1], [3, 0, 0])])
    assert scene.lower == [-1.0] and scene.distances([0.0]) == pytest.approx(1.5)
    with pytest.raises(ValueError, match="xacro cannot expand it"):
        Robot.from_xacro(file, raech="x", reach="oops(")
    with pytest.raises(ValueError, match=r"expand it first.*extricate.Robot.from_xacro\(path\)"):
        Scene(file)


SDF = """<sdf version="1.9"><model name="arm"><frame name="up"><pose>0 0 2 0 0 0</pose></frame>
  <link name="base"><collision name="c"><pose>0 0 0.5 0 0 0</pose><geometry><box><size>1 1 1</size></box></geometry></collision></link>
  <link name="cart"><pose relative_to="up">1 0 0 0 0 1.5707963267948966</pose><collision name="c"><geometry>
    <sphere><radius>0.5</radius></sphere></geometry></collision></link>
  <joint name="anchor" type="fixed"><parent>world</parent><child>base</child></joint>
  <joint name="slide" type="prismatic"><pose>0 0 0.25 0 0 0</pose><parent>base</parent><child>cart</child><axis><xyz>1 0 0</xyz>
    <limit><lower>-1</lower><upper>4</upper></limit></axis></joint></model></sdf>"""


def test_a_simple_sdf_is_read(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "arm.sdf"
    file.write_text(SDF)
    scene = Scene(Robot.from_sdf(file), [Box([2, 2, 2], [1, 5, 2])])
    # The cart slides along its own x, which is y of the model.
    np.testing.assert_allclose(scene.distances([[0.0], [3.0], [4.0]]), [3.5, 0.5, -0.5], atol=1e-9)
    for wrong, expected in [
        (SDF.replace('"prismatic"', '"screw"'), 'joint "slide": got type \'screw\', expected fixed'),
        (SDF.replace("<link name=", "<include/><link name=", 1), "got <include> in a model"),
        (SDF.replace("<parent>base", "<parent>bose"), 'joint "slide": got \'bose\', expected a link'),
        ("<robot/>", "got <robot> with 0 models, expected <sdf> with one <model>"),
    ]:
        file.write_text(wrong)
        with pytest.raises(ValueError, match=expected):
            Robot.from_sdf(file)
    file.write_text(SDF)
    with pytest.raises(ValueError, match=r"this is SDF; in Python `extricate.Robot.from_sdf\(path\)`"):
        Scene(file)


class OpenMesh:
    """As open3d has it."""

    def __init__(self, vertices: Any, triangles: Any) -> None:
        self.vertices, self.triangles = vertices, triangles


def meshes() -> List[Any]:
    found: List[Any] = [OpenMesh(*CUBE)]
    trimesh = pytest.importorskip("trimesh")
    return [*found, trimesh.creation.box((2, 2, 2))]


def test_meshes_of_other_packages_are_taken() -> None:
    for mesh in meshes():
        assert Scene(SLIDER, [Mesh(mesh, [5, 0, 0])]).distances([0.0]) == pytest.approx(3.0)
    with pytest.raises(TypeError, match=r"got int, expected a path, \(vertices, triangles\) or a mesh with `.vertices`"):
        Scene(SLIDER, [Mesh(3)])  # type: ignore[arg-type]


def test_files_of_trimesh_are_read(tmp_path: pathlib.Path) -> None:
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.creation.icosphere(radius=1.0)
    expected = None
    for name in ["a.stl", "a.obj", "a.ply", "a.glb", "a.gltf"]:
        if name.endswith("gltf"):
            for part, content in trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh)).items():
                (tmp_path / part.replace("model.gltf", name)).write_bytes(content)
        else:
            mesh.export(tmp_path / name)
        found = Scene(SLIDER, [Mesh(tmp_path / name, [5, 0.3, 0.2])]).distances([0.0])
        expected = found if expected is None else expected
        assert found == pytest.approx(expected, abs=1e-6), name
    (tmp_path / "a.off").write_text("OFF")
    with pytest.raises(ValueError, match="extension: got `off`, expected stl, obj, dae, ply, glb or gltf.*trimesh.load"):
        Scene(SLIDER, [Mesh(tmp_path / "a.off")])


def test_parts_of_a_mesh_hold_it_and_fixtures_stand(tmp_path: pathlib.Path) -> None:
    bars: List[Tuple[Any, Any]] = []
    for x, y in [(-2.0, 0.0), (2.0, 0.0), (0.0, 2.0), (0.0, -2.0)]:
        half = np.array([0.2, 2.2, 0.2]) if y == 0 else np.array([2.2, 0.2, 0.2])
        bars.append((CUBE[0] * half + [x, y, 0], CUBE[1]))
    frame = (np.concatenate([v for v, _ in bars]), np.concatenate([t + 8 * k for k, (_, t) in enumerate(bars)]))
    small = SLIDER.replace("2 2 2", "0.2 0.2 0.2")
    whole, hull, parts = (Scene(small, [Mesh(frame, convex=c, convex_parts=p)]) for c, p in [(False, False), (True, False), (False, True)])
    assert parts.distances([0.0]) == pytest.approx(whole.distances([0.0]), abs=0.02)
    assert whole.distances([0.0]) > 1.6 and hull.distances([0.0]) < 0
    with pytest.raises(ValueError, match="got `convex` and `convex-parts`, expected one of them"):
        Scene(small, [Mesh(frame, convex=True, convex_parts=True)])
    table = tmp_path / "table.urdf"
    table.write_text('<robot name="t"><link name="top"><collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>')
    assert Scene(SLIDER, [Fixture(table, [5, 0, 0])]).distances([0.0]) == pytest.approx(3.5)
    assert Scene(SLIDER).with_obstacles([Fixture(str(table), [0, 5, 0])]).distances([0.0]) == pytest.approx(3.5)
    with pytest.raises(TypeError, match="urdf: got str, expected the path of a URDF file"):
        Scene(SLIDER, [Fixture("<robot/>")])


def test_links_have_a_geometry_of_their_own() -> None:
    with pytest.raises(ValueError, match=r'links: got `crat`, expected one of'):
        Scene(Robot(SLIDER, links={"crat": "convex-hull"}))
    with pytest.raises(ValueError, match=r'links\["cart"\]: got "hull", expected "mesh" or'):
        Scene(Robot(SLIDER, links={"cart": "hull"}))
    assert Scene(Robot(SLIDER, links={"cart": "convex-parts"}), [Box([1, 1, 1], [5, 0, 0])]).distances([0.0]) == pytest.approx(3.5)


def test_obstacles_in_millimetres_are_told() -> None:
    turning = SLIDER.replace("prismatic", "revolute").replace("10", "2")
    with pytest.warns(UserWarning, match="obstacle `box1` is 300 m thick.*not mm"):
        Scene(turning, [Box([300, 600, 400], [450, 0, 450])])


def test_whole_floats_are_counts() -> None:
    scene = Scene(SLIDER, [Box([1, 1, 1], [5, 0, 0])])
    assert extricate.learn(scene, labels=1e3).statistics["labels"] <= 1000
    assert scene.sample(1e1).shape == (10, 1)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="labels: got 1.5, expected a whole number"):
        extricate.learn(scene, labels=1.5)
    with pytest.raises(TypeError, match="labels: got str, expected a whole number"):
        extricate.learn(scene, labels="many")  # type: ignore[arg-type]


def test_advice_is_in_words_of_python() -> None:
    with pytest.raises(RuntimeError, match=r'make the scene with disable=\[\["cart", "box1"\]\]'):
        extricate.learn(Scene(SLIDER, [Box([50, 4, 4])]), labels=500)
    scene = Scene(SLIDER, [Box([1, 1, 1], [5, 0, 0])])
    model = extricate.learn(scene, labels=500)
    with pytest.raises(ValueError, match="metric: got object-norm, expected that of the model, joint"):
        model.in_scene(Scene(SLIDER, [Box([1, 1, 1], [5, 0, 0])], metric="object-norm"))
