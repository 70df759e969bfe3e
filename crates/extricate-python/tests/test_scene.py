"""Scenes: from files, text and arrays; checks and distances; messages for wrong input."""

import pathlib
import pickle
import re
import threading
import time
import warnings

import numpy as np
import pytest

import extricate
from extricate import Box, Capsule, Cylinder, Mesh, Robot, Scene, Sphere

SLIDER = """<robot name="slider">
  <link name="rail"/>
  <link name="cart"><collision><geometry><box size="2 2 2"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-10" upper="10" effort="1" velocity="1"/></joint>
</robot>"""
CUBE = (
    np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]),
    np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]),
)


def test_what_a_user_should_know_of_a_scene_is_raised() -> None:
    seen = SLIDER.replace("collision>", "visual>")
    with pytest.warns(UserWarning, match="no link has <collision> geometry.*cart"):
        scene = Scene(seen, [Box([1, 1, 1])])
    assert any("<collision>" in warning for warning in scene.warnings)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not Scene(Robot(seen, geometry="visual"), [Box([1, 1, 1])]).check([0.0])


@pytest.mark.parametrize(
    ("obstacle", "near"),
    [
        (Box([2, 4, 6], [5, 0, 0]), 4.0),
        (Sphere(1.5, [5, 0, 0]), 3.5),
        (Cylinder(0.5, 4, [5, 0, 0]), 4.5),
        (Capsule(0.5, 4, [5, 0, 0, 0, np.pi / 2, 0]), 2.5),
        (Mesh(CUBE, [5, 0, 0], scale=2), 3.0),
        (Mesh(CUBE, [5, 0, 0], scale=[0.5, 1, 1], convex=True), 4.5),
    ],
)
def test_distances_are_those_of_closed_forms(obstacle: object, near: float) -> None:
    scene = Scene(SLIDER, [obstacle], clearance=0.01)
    Q = np.linspace(-10, near - 1, 400)[:, None]
    distances = scene.distances(Q)
    assert distances.shape == (400,)
    np.testing.assert_allclose(distances, near - 1 - Q[:, 0], atol=1e-9)
    np.testing.assert_array_equal(scene.check(Q), distances >= 0.01)


def test_packages_are_found_without_a_scene_file(tmp_path: pathlib.Path) -> None:
    corners = "".join("v %g %g %g\n" % tuple(v) for v in CUBE[0]) + "".join("f %d %d %d\n" % tuple(t + 1) for t in CUBE[1])
    text = SLIDER.replace('<box size="2 2 2"/>', '<mesh filename="package://arm/cube.obj"/>')
    (tmp_path / "ws/arm/urdf").mkdir(parents=True)
    (tmp_path / "ws/arm/cube.obj").write_text(corners)
    inside, outside = tmp_path / "ws/arm/urdf/r.urdf", tmp_path / "r.urdf"
    scene_file = tmp_path / "s.toml"
    inside.write_text(text)
    outside.write_text(text)
    scene_file.write_text('[[robot]]\nurdf = "r.urdf"\n')
    for scene in (
        Scene(inside),
        Scene(outside, packages=[tmp_path / "ws"]),
        Scene(text, packages=[str(tmp_path / "ws/arm")]),
        Scene.load(inside),
        Scene.load(scene_file, packages=[tmp_path / "ws"]),
    ):
        assert scene.bodies == ["cart"]
    with pytest.raises(FileNotFoundError, match="tried the package `arm` in `packages`: none; the URDF's folders: "):
        Scene(outside)
    with pytest.raises(TypeError, match="packages: got the text .*, expected a list of folders, such as"):
        Scene(outside, packages=str(tmp_path / "ws"))  # type: ignore[arg-type]


def test_a_transform_is_a_pose() -> None:
    angles = [0.3, -0.7, 2.1]
    cos, sin = np.cos(angles), np.sin(angles)
    turn_x = np.array([[1, 0, 0], [0, cos[0], -sin[0]], [0, sin[0], cos[0]]])
    turn_y = np.array([[cos[1], 0, sin[1]], [0, 1, 0], [-sin[1], 0, cos[1]]])
    turn_z = np.array([[cos[2], -sin[2], 0], [sin[2], cos[2], 0], [0, 0, 1]])
    for rotation in [turn_z @ turn_y @ turn_x, turn_y, np.eye(3)]:
        transform = np.eye(4)
        transform[:3, :3], transform[:3, 3] = rotation, [6, 0.5, -0.2]
        placed = Scene(SLIDER, [Mesh(CUBE, transform)])
        moved = Scene(SLIDER, [Mesh((CUBE[0] @ rotation.T + transform[:3, 3], CUBE[1]))])
        Q = np.linspace(-5, 5, 50)[:, None]
        np.testing.assert_allclose(placed.distances(Q), moved.distances(Q), atol=1e-9)
    # The x axis points straight up, so that roll and yaw have the same axis.
    up = np.eye(4)
    up[:3, :3] = turn_z @ np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]) @ turn_x
    up[0, 3] = 6
    placed = Scene(SLIDER, [Mesh(CUBE, up)])
    moved = Scene(SLIDER, [Mesh((CUBE[0] @ up[:3, :3].T + up[:3, 3], CUBE[1]))])
    np.testing.assert_allclose(placed.distances([[0.0]]), moved.distances([[0.0]]), atol=1e-9)


def test_robots_take_what_scene_files_say(tmp_path: object) -> None:
    text = SLIDER.replace("slider", "other")
    scene = Scene(
        [Robot(SLIDER, name="a"), Robot(text, name="b", base="planar", bounds=([-1, -1], [1, 1]), limits={"slide": (0, 2)})],
        extricate.spheres([[0, 5, 0], [0, 8, 0]], 0.5),
        metric="joint",
        weights={"a/slide": 4, "base": (1, 0.5)},
        disable=[("a/cart", "sphere1")],
    )
    assert [joint.name for joint in scene.joints] == ["a/slide", "base", "b/slide"]
    assert (scene.nq, scene.nv, scene.metric) == (5, 5, "joint")
    np.testing.assert_array_equal(scene.upper, [10, 1, 1, np.pi, 2])
    np.testing.assert_array_equal(scene.lower, [-10, -1, -1, -np.pi, 0])
    assert ("a/cart", "sphere1") not in scene.pairs and ("a/cart", "sphere2") in scene.pairs
    assert scene.bodies == ["a/cart", "b/cart", "sphere1", "sphere2"]
    locked = Scene([Robot(SLIDER, name="a"), Robot(text, name="b", locked={"slide": 5})])
    assert locked.nq == 1 and locked.distances([0.0]) == pytest.approx(3)
    q = scene.config({"b/slide": 1, "a/slide": -3, "base": [0.5, 0.25, 9]})
    np.testing.assert_allclose(q, [-3, 0.5, 0.25, 9 - 2 * np.pi, 1])


def test_files_are_read(tmp_path) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "slider.urdf").write_text(SLIDER)
    (tmp_path / "scene.toml").write_text(
        '[[robot]]\nurdf = "slider.urdf"\n[[obstacle]]\nname = "ball"\nshape = { sphere = 1 }\npose = { xyz = [5, 0, 0] }\n'
    )
    from_file = Scene.load(tmp_path / "scene.toml")
    from_path = Scene(tmp_path / "slider.urdf", [Sphere(1, [5, 0, 0], "ball")])
    assert from_file.pairs == from_path.pairs == [("cart", "ball")]
    assert from_file.distances([1.0]) == from_path.distances([1.0]) == 2


def test_builtin_scenes_can_be_written_to_files(tmp_path) -> None:  # type: ignore[no-untyped-def]
    files = Scene.builtin_files("shelf-arm")
    for path, contents in files.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(contents)
    scene = Scene.load(tmp_path / next(iter(files)))
    Q = scene.sample(20)
    np.testing.assert_array_equal(scene.distances(Q), Scene.builtin("shelf-arm").distances(Q))
    with pytest.raises(ValueError, match='got "shelf", expected one of .*"shelf-arm"'):
        Scene.builtin_files("shelf")


@pytest.mark.parametrize("name", ["shelf-arm", "planar-arm", "free-box", "dual-arm", "hand", "four-legs"])
def test_batches_are_what_single_calls_are(name: str) -> None:
    scene = Scene.builtin(name)
    Q = scene.sample(300, seed=2)
    free, distances = scene.check(Q), scene.distances(Q, threads=2)
    assert 0 < free.sum() < 300
    np.testing.assert_array_equal(free, [bool(scene.check(q)) for q in Q])
    np.testing.assert_array_equal(distances, [float(scene.distances(q)) for q in Q])
    np.testing.assert_array_equal(free, scene.check(Q, threads=1))
    np.testing.assert_array_equal(free, [not scene.colliding_pairs(q) for q in Q])


def test_samples_are_reproducible_and_of_the_kind_that_is_wanted(arm: Scene) -> None:
    any_kind = arm.sample(500, seed=1)
    np.testing.assert_array_equal(any_kind, arm.sample(700, seed=1)[:500])
    np.testing.assert_array_equal(any_kind[~arm.check(any_kind)], arm.sample(500, seed=1, colliding=True)[: (~arm.check(any_kind)).sum()])
    assert not arm.check(arm.sample(50, seed=1, colliding=True)).any()
    assert arm.check(arm.sample(50, seed=1, colliding=False)).all()
    assert (any_kind >= arm.lower).all() and (any_kind <= arm.upper).all()
    assert arm.sample(0).shape == (0, 7)
    with pytest.raises(RuntimeError, match="no colliding configuration among"):
        Scene(SLIDER, [Sphere(1, [50, 0, 0])]).sample(1, colliding=True)


def test_arrays_of_every_layout_are_read_alike(arm: Scene) -> None:
    Q = arm.sample(100, seed=5)
    expected = arm.distances(Q)
    wide = np.zeros((100, 9))
    wide[:, 1:8] = Q
    raw = np.zeros(Q.nbytes + 1, dtype=np.uint8)
    misaligned = raw[1:].view(np.float64).reshape(Q.shape)
    misaligned[:] = Q
    assert not misaligned.flags.aligned
    readonly = Q.copy()
    readonly.flags.writeable = False
    for same in [np.asfortranarray(Q), wide[:, 1:8], misaligned, Q.tolist(), Q[::-1][::-1], Q.astype(">f8"), readonly]:
        np.testing.assert_array_equal(arm.distances(same), expected)
    np.testing.assert_allclose(arm.distances(Q.astype(np.float32)), expected, atol=1e-5)
    assert arm.check(np.zeros((0, 7))).shape == (0,)
    assert Scene(SLIDER).distances([[1], [2]]).tolist() == [np.inf, np.inf]


def test_what_is_no_fault_of_the_value_is_raised_as_it_is(arm: Scene) -> None:
    class Interrupted:
        def __array__(self, *_: object, **__: object) -> object:
            raise KeyboardInterrupt

    class Exhausted:
        def __array__(self, *_: object, **__: object) -> object:
            raise MemoryError

    with pytest.raises(KeyboardInterrupt):
        arm.check(Interrupted())
    with pytest.raises(MemoryError):
        arm.check(Exhausted())
    with pytest.raises(MemoryError, match="more than memory holds"):
        arm.sample(10**15)


def test_scenes_pickle(arm: Scene) -> None:
    again = pickle.loads(pickle.dumps(arm))
    Q = arm.sample(50)
    np.testing.assert_array_equal(again.distances(Q), arm.distances(Q))
    assert again.pairs == arm.pairs
    with pytest.raises(ValueError, match="no scene of this version"):
        Scene._from_bytes(b"\xff\xff\xff\xff\xff")


def test_joints_that_always_collide_are_found() -> None:
    urdf = SLIDER.replace("</robot>", """<link name="tip"><collision><geometry><sphere radius="0.5"/></geometry></collision></link>
        <link name="mid"/><joint name="a" type="revolute"><parent link="cart"/><child link="mid"/><axis xyz="0 0 1"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
        <joint name="b" type="revolute"><parent link="mid"/><child link="tip"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>""")
    assert Scene(urdf).always_colliding() == [("cart", "tip")]
    assert Scene(urdf, disable=[("cart", "tip")]).always_colliding(5, seed=1) == []
    # The box blocks the cart on nine tenths of its rail.
    half = Scene(urdf, [Box([20, 1, 1], [2, 0, 0])], disable=[("cart", "tip")])
    assert half.always_colliding(200) == []
    assert ("cart", "box1") in half.always_colliding(200, share=0.8)
    with pytest.raises(ValueError, match="share: got 0, expected more than 0, at most 1"):
        half.always_colliding(share=0.0)


def test_ways_are_proved_free_or_collide() -> None:
    scene = Scene(SLIDER, [Box([0.001, 2, 2], pose=[5, 0, 0])], clearance=0.0)
    A, B = np.array([[-10.0], [-10.0], [10.0], [5.0]]), np.array([[3.0], [10.0], [7.0], [10.0]])
    found = scene.check_segments(A, B, resolution=1e-3, threads=2)
    assert found["free"].tolist() == [True, False, True, False]
    assert found["contact"].tolist() == [False, True, False, True]
    assert found["pair"].tolist() == [-1, 0, -1, 0] and np.isnan(found["at"][[0, 2]]).all()
    # The cart's front is 1 m before its middle, and the thin wall half a millimetre thick on either side.
    first = (5 - 0.0005 - 1 + 10) / 20
    assert found["free_until"][1] <= first <= found["at"][1] and found["at"][1] - found["free_until"][1] < 1e-3
    assert found["free_until"].tolist()[::3] == [1, 0] and found["at"][3] == 0
    one = scene.check_segments([-10.0], [3.0])
    assert one.shape == (1,) and one["free"].all()
    assert scene.check_segments(np.zeros((0, 1)), np.zeros((0, 1))).shape == (0,)


WRONG = [
    (lambda s: s.check_segments(np.zeros((2, 7)), np.zeros((3, 7))), ValueError, "B: got 3 configurations, expected as many as in A, 2"),
    (lambda s: s.check_segments(np.zeros((2, 7)), np.zeros((2, 6))), ValueError, r"B: got shape \(2, 6\), expected \(7,\) or"),
    (lambda s: s.check_segments([[0] * 7], [[np.nan] * 7]), ValueError, r"B\[0\]: .*got NaN"),
    (lambda s: s.check_segments(np.zeros(7), np.zeros(7), resolution=0), ValueError, "resolution: got 0, expected more than 0 m"),
    (lambda s: s.sample(3, seed=-1), ValueError, "seed: got -1, expected a whole number from 0"),
    (lambda s: s.check(np.zeros((3, 6))), ValueError, r"Q: got shape \(3, 6\), expected \(7,\) or \(n, 7\): the scene has 7 coordinates"),
    (lambda s: s.check(np.zeros((2, 3, 7))), ValueError, r"got shape \(2, 3, 7\)"),
    (lambda s: s.check(0.5), ValueError, r"got shape \(\), expected"),
    (lambda s: s.check([[0] * 6 + [np.nan]]), ValueError, r"Q\[0\]: .*`joint_7` \(coordinate 6\): got NaN, expected a finite number"),
    (lambda s: s.distances([[0] * 7, [0, 99, 0, 0, 0, 0, 0]]), ValueError, r"Q\[1\]: .*`joint_2` \(coordinate 1\): got 99, expected a value within \["),
    (lambda s: s.distances([[0.0] * 7] * 500 + [[np.inf] * 7]), ValueError, r"Q\[500\]: .*`joint_1`"),
    (lambda s: s.check([0, 99, 0, 0, 0, 0, 0]), ValueError, r"^Q: configuration: `joint_2`"),
    (lambda s: s.check("abc"), TypeError, "Q: got an array of <U3, expected numbers"),
    (lambda s: s.check([[0] * 7, [0] * 6]), TypeError, "Q: expected an array of numbers"),
    (lambda s: s.check(np.zeros((1, 7), dtype=complex)), TypeError, "complex128, expected numbers"),
    (lambda s: s.check(None), TypeError, "object, expected numbers"),
    (lambda s: s.check(np.zeros((1, 7)), threads=-1), ValueError, r"threads: got -1, expected 0 \(one per core\)"),
    (lambda s: s.sample(-1), ValueError, "n: got -1"),
    (lambda s: s.colliding_pairs(np.zeros((2, 7))), ValueError, r"q: got shape \(2, 7\), expected \(7,\)"),
    (lambda s: s.config({"joint_1": 0}), ValueError, "got none for `joint_2`, `joint_3`"),
    (lambda s: s.config({"elbow": 0}), ValueError, "got `elbow`, expected one of `joint_1`, `joint_2`"),
    (lambda s: s.config({"joint_1": [0, 1]}), ValueError, "got 2 numbers, expected 1"),
    (lambda s: Scene.builtin("shelf"), ValueError, "`shelf-arm`, `planar-arm`"),
    (lambda s: Scene.load("no-such.toml"), FileNotFoundError, "cannot read no-such.toml"),
    (lambda s: Scene("no-such.urdf"), FileNotFoundError, "robot 1: urdf: got no-such.urdf, expected a file that can be read"),
    (lambda s: Scene("/"), IsADirectoryError, "robot 1: urdf: got /, expected a file that can be read"),
    (lambda s: Scene(Robot(SLIDER, srdf="no-such.srdf")), FileNotFoundError, "robot 1: srdf: got no-such.srdf, expected a file"),
    (lambda s: Scene(SLIDER.replace('<box size="2 2 2"/>', '<mesh filename="package://p/no.stl"/>')), FileNotFoundError, "not found, tried .*`packages`"),
    (lambda s: Scene("<robot"), ValueError, "urdf of robot 1"),
    (lambda s: Scene(3), TypeError, "robot: got int, expected a URDF"),
    (lambda s: Scene([]), ValueError, "expected at least one"),
    (lambda s: Scene([3]), TypeError, "robot 1: got int, expected a URDF"),
    (lambda s: Scene(Robot(SLIDER, locked={"sliide": 1})), ValueError, "locked: got `sliide`, expected one of `slide`"),
    (lambda s: Scene(Robot(SLIDER, locked="slide")), TypeError, "locked: got str, expected a dict by joint"),
    (lambda s: Scene(Robot(SLIDER, packages="ws")), TypeError, r"packages: got the text 'ws', expected a list of folders, such as \['ws'\]"),
    (lambda s: s.query([0] * 7, locked="joint_1"), TypeError, r"locked: got the text 'joint_1', expected a list of names, such as \['joint_1'\]"),
    (lambda s: s.query([0] * 7, free="joint_1"), TypeError, "free: got the text 'joint_1', expected a list of names"),
    (lambda s: s.query([0] * 7, locked=[1]), TypeError, "locked: got a list with int, expected a list of names"),
    (lambda s: s.query([0] * 7, locked=1), TypeError, "locked: got int, expected a list of names"),
    (lambda s: s.without("shelf"), TypeError, "names: got the text 'shelf', expected a list of names"),
    (lambda s: Scene(Robot(SLIDER, limits={"slide": 3})), TypeError, r'limits\["slide"\]: got int, expected \(lower, upper\)'),
    (lambda s: Scene(Robot(SLIDER, limits={"slide": (3, 1)})), ValueError, "lower <= upper"),
    (lambda s: Scene(Robot(SLIDER, base="flying")), ValueError, 'base: got "flying", expected "fixed" or "planar" or "floating"'),
    (lambda s: Scene(Robot(SLIDER, base="floating")), ValueError, "bounds"),
    (lambda s: Scene(Robot(SLIDER, geometry="hull")), ValueError, 'expected "mesh" or "convex-hull" or "convex-parts" or "visual"'),
    (lambda s: Scene(Robot(SLIDER, pose=np.zeros((4, 4)))), ValueError, "no rigid transform"),
    (lambda s: Scene(Robot(SLIDER, pose=[0, 0])), ValueError, r"pose: got shape \(2,\), expected \(3,\) position"),
    (lambda s: Scene(SLIDER, [Box([1, 2])]), ValueError, 'obstacle "box1": size: expected the three full sides'),
    (lambda s: Scene(SLIDER, [Box([1, 2, -3])]), ValueError, 'obstacle "box1": box: got -3'),
    (lambda s: Scene(SLIDER, [Sphere("big")]), TypeError, 'obstacle "sphere1": radius: got an array of <U3'),
    (lambda s: Scene(SLIDER, Sphere(1)), TypeError, "obstacles: got Sphere, expected a list of Box, Sphere"),
    (lambda s: Scene(SLIDER, [3]), TypeError, "obstacle 1: got int, expected Box, Sphere"),
    (lambda s: Scene(SLIDER, [Mesh(([[0, 0, 0]], [[0, 0, 7]]))]), ValueError, "expected indices below the 1 vertices"),
    (lambda s: Scene(SLIDER, [Mesh(([[0, 0, 0]], [[0, 0, 0.5]]))]), ValueError, "got 0.5, expected an index"),
    (lambda s: Scene(SLIDER, [Mesh(([[0, 0]], [[0, 0, 0]]))]), ValueError, r"vertices: got shape \(1, 2\), expected \(n, 3\)"),
    (lambda s: Scene(SLIDER, [Mesh("none.stl")]), FileNotFoundError, r"none\.stl, expected a file \(not found\)"),
    (lambda s: Scene(SLIDER, [Sphere(1, name="a"), Box([1, 1, 1], name="a")]), ValueError, "the name occurs twice"),
    (lambda s: Scene(SLIDER, metric="euclid"), ValueError, 'metric: got "euclid"'),
    (lambda s: Scene(SLIDER, weights={"x": 1}), ValueError, "got `x`, expected one of `slide`"),
    (lambda s: Scene(SLIDER, disable=[("cart", "x")]), ValueError, "got `x`, expected one of"),
    (lambda s: Scene(SLIDER, clearance=-1), ValueError, "clearance: got -1, expected 0 to 1e9"),
    (lambda s: extricate.spheres([0, 0], 1), ValueError, r"centers: got shape \(2,\), expected \(n, 3\)"),
    (lambda s: extricate.spheres([[0, 0, 0]], [1, 2]), ValueError, r"radii: got shape \(2,\)"),
]


@pytest.mark.parametrize(("call", "exception", "message"), WRONG, ids=[message[:40] for _, _, message in WRONG])
def test_wrong_input_is_told_what_was_expected(arm: Scene, call, exception: type, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(exception) as told:
        call(arm)
    assert type(told.value) is exception
    assert re.search(message, str(told.value)), str(told.value)


def test_a_scene_can_be_changed_while_it_is_prepared() -> None:
    n = 300
    u, v = np.meshgrid(np.arange(1, n) * np.pi / n, np.arange(n) * 2 * np.pi / n, indexing="ij")
    P = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], -1).reshape(-1, 3)
    k = np.arange((n - 2) * n).reshape(n - 2, n)
    m = np.roll(k, -1, 1)
    F = np.concatenate([np.stack([k, k + n, m + n], -1), np.stack([k, m + n, m], -1)]).reshape(-1, 3)
    urdf = Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # It is open at its poles.
        scene = Scene(urdf, [extricate.Mesh((P, F), [3, 0, 0], name="ball"), Box([1, 1, 1], [0, 0, 9], name="box")])
        checks = threading.Thread(target=scene.check, args=([0, 0, 0],))
        before, pauses = time.monotonic(), []
        checks.start()
        while checks.is_alive():
            started = time.monotonic()
            scene.without(["box"])
            pauses.append(time.monotonic() - started)
        checks.join()
    assert max(pauses) < (time.monotonic() - before) / 2, "it waited, with the interpreter held, until all was prepared"
