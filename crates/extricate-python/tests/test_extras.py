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
    # `reset` does the same in MuJoCo's own coordinates, and leaves free states unchanged.
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


PACKAGE = "<package format='2'><name>arm_description</name></package>"


def test_a_xacro_file_lies_in_packages(tmp_path: pathlib.Path) -> None:
    """The folder has another name than the package, as in many repositories of vendors."""
    pytest.importorskip("xacrodoc")
    vendor = tmp_path / "vendor-arm"
    (vendor / "urdf").mkdir(parents=True)
    (vendor / "meshes").mkdir()
    (vendor / "package.xml").write_text(PACKAGE)
    (vendor / "meshes" / "cube.obj").write_text("".join("v %g %g %g\n" % tuple(v) for v in CUBE[0]) + "".join("f %d %d %d\n" % tuple(t + 1) for t in CUBE[1]))
    text = SLIDER.replace('<box size="2 2 2"/>', '<mesh filename="package://arm_description/meshes/cube.obj"/>')
    file = vendor / "urdf" / "slider.urdf.xacro"
    file.write_text(text)
    elsewhere = tmp_path / "slider.urdf.xacro"
    elsewhere.write_text(text)
    ball = [extricate.Sphere(0.5, [5, 0, 0])]
    for robot in (
        Robot.from_xacro(file),
        Robot.from_xacro(elsewhere, packages=[vendor]),
        Robot.from_xacro(elsewhere, options={"packages": [vendor]}),
    ):
        assert Scene(robot, ball).distances([0.0]) == pytest.approx(3.5)
    with pytest.raises(FileNotFoundError, match="arm_description"):
        Scene(Robot.from_xacro(elsewhere), ball)


def test_a_xacro_file_finds_packages_beside_it(tmp_path: pathlib.Path) -> None:
    """Packages are found by the rule for URDFs, also in `$(find NAME)`."""
    pytest.importorskip("xacrodoc")
    for folder in ("src/beside_arm/urdf", "src/beside_parts"):
        (tmp_path / folder).mkdir(parents=True)
    text = SLIDER.replace("<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" ', 1)
    text = text.replace("</robot>", '<xacro:include filename="$(find beside_parts)/more.xacro"/></robot>')
    (tmp_path / "src/beside_arm/urdf/arm.xacro").write_text(text)
    (tmp_path / "src/beside_parts/more.xacro").write_text('<robot><link name="more"/></robot>')
    with pytest.raises(ValueError, match="more"):
        Scene(Robot.from_xacro(tmp_path / "src/beside_arm/urdf/arm.xacro"))
    (tmp_path / "src/beside_parts/more.xacro").write_text("<robot/>")
    assert Scene(Robot.from_xacro(tmp_path / "src/beside_arm/urdf/arm.xacro")).nq == 1


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
        (SDF.replace("<upper>4", "<upper>four"), 'joint "slide": limit: upper: got \'four\', expected a number'),
        (SDF.replace("<pose>0 0 2 0 0 0", "<pose>0 0 2 0 0"), "pose: got '0 0 2 0 0', expected 6 finite numbers"),
        ("<robot/>", "got <robot> with 0 models, expected <sdf> with one <model>"),
    ]:
        file.write_text(wrong)
        with pytest.raises(ValueError, match=expected):
            Robot.from_sdf(file)
    file.write_text(SDF)
    with pytest.raises(ValueError, match=r"this is SDF; in Python `extricate.Robot.from_sdf\(path\)`"):
        Scene(file)


LINK = '<link name="a"><collision name="c"><geometry><sphere><radius>0.1</radius></sphere></geometry></collision></link>'
SLIDE = """<joint name="j" type="prismatic"><parent>world</parent><child>a</child><axis><xyz>1 0 0</xyz><limit><lower>-9</lower>
  <upper>9</upper></limit></axis></joint>"""
ABOVE = "<pose>0 0 1 0 0 0</pose>"


def sdf_model(inside: str) -> str:
    return f'<model name="m">{inside}</model>'


@pytest.mark.parametrize(
    "inside, expected",
    [
        (LINK + SLIDE, 1.8),
        # The model's own pose, with and without a joint to the world, and of another frame of the model.
        (ABOVE + LINK + SLIDE, 5**0.5 - 0.2),
        (ABOVE + '<link name="base"/>' + LINK + SLIDE.replace("world", "base"), 5**0.5 - 0.2),
        ('<link name="base"><pose>0 0 1 0 0 0</pose></link>' + LINK.replace("<coll", ABOVE + "<coll", 1) + SLIDE.replace("world", "base"), 5**0.5 - 0.2),
        # A pose in degrees: the x axis of the link is y of the world.
        (LINK.replace("<coll", '<pose degrees="true">0 1 0 0 0 90</pose><coll', 1) + SLIDE, 2.8),
        (LINK.replace("<coll", '<pose rotation_format="quat_xyzw">0 1 0 0 0 1 1</pose><coll', 1) + SLIDE, 2.8),
        # A frame as child, and one of a joint as parent.
        ('<frame name="f" attached_to="a"/>' + LINK + SLIDE.replace("<child>a", "<child>f"), 1.8),
        ('<frame name="f" attached_to="fix"><pose>0 0 0 0 0 0</pose></frame><link name="base"/>' + LINK + SLIDE.replace("world", "f")
         + '<joint name="fix" type="fixed"><parent>world</parent><child>base</child></joint>', 1.8),
    ],
)
def test_poses_and_frames_of_an_sdf_count(tmp_path: pathlib.Path, inside: str, expected: float) -> None:
    """The distance to a ball at the origin, in closed form."""
    file = tmp_path / "m.sdf"
    file.write_text(f'<sdf version="1.9">{sdf_model(inside)}</sdf>')
    scene = Scene(Robot.from_sdf(file), [extricate.Sphere(0.1, [0, 0, 0], name="o")], clearance=0)
    assert scene.distances([2.0]) == pytest.approx(expected, abs=1e-9)
    turned = f'<model name="m" placement_frame="p"><frame name="p"><pose>0 0 -3 0 0 0</pose></frame>{inside}</model>'
    if ABOVE not in inside:
        file.write_text(f'<sdf version="1.9">{turned}</sdf>')
        scene = Scene(Robot.from_sdf(file), [extricate.Sphere(0.1, [0, 0, 3], name="o")], clearance=0)
        assert scene.distances([2.0]) == pytest.approx(expected, abs=1e-9)


def test_shapes_and_limits_of_an_sdf_are_taken_or_refused(tmp_path: pathlib.Path) -> None:
    file, ball = tmp_path / "m.sdf", [extricate.Sphere(0.1, [0, 0, 0], name="o")]
    file.write_text(f'<sdf version="1.9">{sdf_model(LINK + SLIDE)}</sdf>'.replace("<sphere><radius>0.1</radius></sphere>", "<ellipsoid><radii>0.3 0.1 0.2</radii></ellipsoid>"))
    with pytest.warns(UserWarning, match="a collision shape <ellipsoid> is taken for a polyhedron around it"):
        robot = Robot.from_sdf(file)
    assert Scene(robot, ball, clearance=0).distances([2.0]) == pytest.approx(1.6, abs=3e-3)
    mesh = "<mesh><uri>two.obj</uri><submesh><name>right</name></submesh></mesh>"
    file.write_text(f'<sdf version="1.9">{sdf_model(LINK + SLIDE)}</sdf>'.replace("<sphere><radius>0.1</radius></sphere>", mesh))
    with pytest.raises(ValueError, match="link \"a\": got the part 'right' of the mesh 'two.obj', expected a whole file"):
        Robot.from_sdf(file)
    endless = LINK + SLIDE.replace("-9", "-inf").replace(">9<", ">inf<").replace("\n", "")
    file.write_text(f'<sdf version="1.9">{sdf_model(endless)}</sdf>')
    with pytest.raises(ValueError, match=r'joint "j": got limits of -inf to inf, expected finite ones, or Robot.from_sdf\(path, limits='):
        Robot.from_sdf(file)
    assert Scene(Robot.from_sdf(file, limits={"j": (-9, 9)}), ball, clearance=0).distances([2.0]) == pytest.approx(1.8)
    file.write_text(f'<sdf version="1.9">{sdf_model(endless.replace("prismatic", "revolute"))}</sdf>')
    assert [joint.kind for joint in Scene(Robot.from_sdf(file), ball).joints] == ["continuous"]


def test_the_rest_of_the_world_of_an_sdf_stands(tmp_path: pathlib.Path) -> None:
    ground = """<model name="ground"><static>true</static><link name="l"><collision name="c"><geometry><plane><normal>0 0 1</normal>
      </plane></geometry></collision></link></model>"""
    # The shelf is static although it has a joint that moves, and has the name of a link.
    shelf = sdf_model("<static>1</static><pose>2 0 4 0 0 0</pose>" + LINK + SLIDE).replace('"m"', '"a"')
    file = tmp_path / "w.sdf"
    file.write_text(f'<sdf version="1.9"><world name="w">{ground}{sdf_model(ABOVE + LINK + SLIDE)}{shelf}<include/></world></sdf>')
    with pytest.warns(UserWarning) as told:
        robot = Robot.from_sdf(file)
    assert ["an <include> is left out" in str(t.message) or "the model a is called a__model here" in str(t.message) for t in told] == [True, True]
    scene = Scene(robot, clearance=0)
    assert scene.bodies == ["a", "ground", "a__model"] and scene.pairs == [("a", "ground"), ("a", "a__model")]
    np.testing.assert_allclose(scene.pair_distances([2.0]), [0.9, 2.8], atol=1e-9)
    file.write_text(f'<sdf version="1.9"><world name="w">{sdf_model(LINK + SLIDE)}{sdf_model(LINK + SLIDE)}</world></sdf>')
    with pytest.raises(ValueError, match="got 2 models, of which 'm', 'm' have joints that move, expected one that has"):
        Robot.from_sdf(file)


def test_models_of_an_sdf_that_do_not_hang_together_stand_or_are_refused(tmp_path: pathlib.Path) -> None:
    loose = LINK.replace('"a"', '"b"').replace("<collision", "<pose>0 0 7 0 0 0</pose><collision", 1)
    file, ball = tmp_path / "m.sdf", [extricate.Sphere(0.1, [0, 0, 0], name="o")]
    # The model is not marked as static, but no joint moves it: it is an obstacle of two links.
    pieces = sdf_model("<pose>0 0 2 0 0 0</pose>" + LINK.replace('"a"', '"c"') + loose).replace('"m"', '"pieces"')
    file.write_text(f'<sdf version="1.9"><world name="w">{sdf_model(LINK + SLIDE)}{pieces}</world></sdf>')
    scene = Scene(Robot.from_sdf(file), clearance=0)
    assert scene.bodies == ["a", "pieces"] and scene.distances([0.0]) == pytest.approx(1.8, abs=1e-9)
    file.write_text(f'<sdf version="1.9"><world name="w">{sdf_model(LINK + SLIDE.replace("world", "b") + loose + LINK.replace(chr(34) + "a", chr(34) + "c"))}</world></sdf>')
    with pytest.raises(ValueError, match=r"m.sdf: model \"m\": got the links 'b', 'c' that no joint moves or holds, expected one"):
        Robot.from_sdf(file)
    ring = LINK + loose + SLIDE.replace("world", "b") + SLIDE.replace("world", "a").replace("<child>a", "<child>b").replace('"j"', '"k"')
    file.write_text(f'<sdf version="1.9">{sdf_model(ring)}</sdf>')
    with pytest.raises(ValueError, match="model \"m\": got links each of which hangs on another, expected a tree"):
        Robot.from_sdf(file)
    # A static model may have any joints: of unknown kinds, with two parents, in a ring.
    for inside in (LINK + SLIDE.replace("prismatic", "screw"), ring, LINK + loose + 2 * SLIDE):
        static = sdf_model("<static>true</static><pose>0 0 3 0 0 0</pose>" + inside).replace('"m"', '"static"')
        file.write_text(f'<sdf version="1.9"><world name="w">{sdf_model(LINK + SLIDE)}{static}</world></sdf>')
        scene = Scene(Robot.from_sdf(file), ball, clearance=0)
        assert scene.pair_distances([1.0])[scene.pairs.index(("a", "static"))] == pytest.approx(10**0.5 - 0.2, abs=1e-9)


class OpenMesh:
    """Mesh with the attributes of one of open3d."""

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


def test_changed_scenes_carry_warnings(tmp_path: pathlib.Path) -> None:
    """A changed scene has the warnings of an equal scene made at once, and none of removed obstacles."""
    turning = SLIDER.replace("prismatic", "revolute").replace("10", "2")
    base, big = Scene(turning, [Box([1, 1, 1], [5, 0, 0], name="near")]), Box([300, 600, 400], [450, 0, 450], name="big")
    assert base.warnings == []
    size = "obstacle `big` is 300 m thick"
    surface = Mesh((CUBE[0], CUBE[1][:-1]), [5, 0, 0], name="open")

    def told(make: Any) -> Scene:
        """Checks that `make` raises every warning of its scene as a UserWarning, and returns the scene."""
        with warnings.catch_warnings(record=True) as raised:
            warnings.simplefilter("always")
            scene = make()
        assert isinstance(scene, Scene) and [str(one.message) for one in raised] == scene.warnings
        return scene

    more = told(lambda: base.with_obstacles([big, surface]))
    assert len(more.warnings) == 2 and size in more.warnings[1] and "`open`: its mesh is open" in more.warnings[0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # No warning is raised twice.
        assert more.moved({"big": [900, 0, 0]}).warnings == more.warnings
        assert more.without(["near"]).warnings == more.warnings
        assert more.without(["big"]).warnings == more.warnings[:1] and more.without(["big", "open"]).warnings == []
    held = told(lambda: base.attach(big, link="cart"))
    assert any("attached `big` is 300 m thick" in warning for warning in held.warnings)
    none = told(lambda: base.disabled([["cart", "near"]]))
    assert len(none.warnings) == 1 and "no pair of bodies is checked" in none.warnings[0]
    assert none.with_obstacles([Box([1, 1, 1], [5, 0, 0], name="again")]).warnings == []
    assert "no pair of bodies is checked" in told(lambda: base.without(["near"])).warnings[0]
    file = tmp_path / "world.toml"
    file.write_text('[[obstacle]]\nname = "big"\nshape = { box = [300, 600, 400] }\npose = { xyz = [450, 0, 450] }\n')
    assert size in told(lambda: base.in_world(file)).warnings[0]
    with pytest.warns(UserWarning, match="300 m thick"):
        changed = extricate.learn(base, labels=500).in_world([big])
    assert size in changed.scene.warnings[0]


def test_pairs_of_neighbours_are_enabled() -> None:
    chain = """<robot name="r">%s<joint name="j" type="revolute"><parent link="l0"/><child link="l1"/><axis xyz="0 0 1"/>
      <limit lower="-3" upper="3"/></joint></robot>""" % "".join(
        f'<link name="l{k}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>' for k in range(2)
    )
    with pytest.warns(UserWarning, match="no pair of bodies"):
        assert Scene(chain).pairs == []
    assert Scene(chain, enable=[("l1", "l0")]).pairs == [("l0", "l1")]
    for wrong, expected in [
        ({"enable": [["l0", "l2"]]}, r'pairs: enable \["l0", "l2"\]: got `l2`, expected one of'),
        ({"enable": [["l0", "l1"], ["l1", "l0"]]}, "got the pair twice"),
        ({"enable": [["l0", "l1"]], "disable": [["l1", "l0"]]}, "got a pair that `disable` or `touch` takes out"),
    ]:
        with pytest.raises(ValueError, match=expected):
            Scene(chain, **wrong)  # type: ignore[arg-type]


def test_negative_numbers_are_values_that_are_wrong() -> None:
    scene = Scene.builtin("planar-arm")
    q, Q = scene.sample(1, colliding=True)[0], scene.sample(2, colliding=False)
    calls: List[Any] = [
        lambda **given: scene.escape(q, **given),
        lambda **given: scene.plan(Q[0], Q[1], **given),
        lambda **given: scene.repair(Q, **given),
        lambda **given: extricate.Roadmap(scene, **given),
        lambda **given: scene.sample(3, **given),
        lambda **given: scene.always_colliding(3, **given),
        lambda **given: extricate.learn(scene, labels=100, **given),
    ]
    for call in calls:
        for seed in (-1, 2**64):
            with pytest.raises(ValueError, match=f"seed: got {seed}, expected a whole number from 0 to"):
                call(seed=seed)
    for call, names in [(calls[0], ["exits", "tree_checks", "max_checks"]), (calls[1], ["threads", "max_checks"]), (calls[2], ["max_checks"])]:
        for name in names:
            with pytest.raises(ValueError, match=f"{name}: got -1, expected"):
                call(**{name: -1})
    with pytest.raises(ValueError, match="load_limits: triangles: got -1, expected at least 0"):
        Scene.load("scene.toml", load_limits={"triangles": -1})


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
