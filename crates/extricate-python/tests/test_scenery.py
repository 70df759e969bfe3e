"""Points, voxels, half-spaces and height fields as obstacles, and the robot's own points."""

import pickle
import re

import numpy as np
import pytest

import extricate
from extricate import Box, HalfSpace, HeightField, Points, Scene, Sphere, Voxels

from test_scene import SLIDER

BALL = """<robot name="ball"><link name="w"/><link name="x"/>
  <link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="jx" type="prismatic"><parent link="w"/><child link="x"/><axis xyz="1 0 0"/>
    <limit lower="-5" upper="5" effort="1" velocity="1"/></joint>
  <joint name="jz" type="prismatic"><parent link="x"/><child link="ball"/><axis xyz="0 0 1"/>
    <limit lower="-5" upper="5" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize(
    ("obstacle", "near"),
    [
        (Points([[5, 0, 0], [8, 0, 0]]), 5.0),
        (Points([[0, 0, 0]], 0.5, [5, 0.2, 0]), 4.5),
        (Voxels([[10, 0, 0], [12, 1, 1]], 0.5), 5.0),
        (Voxels(np.ones((2, 3, 2), bool), 0.5, [5, 0, 0]), 5.0),
        (HalfSpace([-2, 0, 0], -5.5), 5.5),
        (HalfSpace([0, 0, 1], pose=[5, 0, 0, 0, -np.pi / 2, 0]), 5.0),
        (HeightField(np.full((3, 4), 2.0), 0.5, [5, -0.5, 0]), 5.0),
    ],
)
def test_distances_are_those_of_closed_forms(obstacle: object, near: float) -> None:
    scene = Scene(SLIDER, [obstacle], clearance=0.01)
    assert scene.pairs == [("cart", scene.bodies[1])]
    Q = np.linspace(-10, near - 1.001, 100)[:, None]
    distances = scene.distances(Q)
    np.testing.assert_allclose(distances, near - 1 - Q[:, 0], atol=1e-9)
    np.testing.assert_array_equal(scene.check(Q), distances >= 0.01)
    again = pickle.loads(pickle.dumps(scene))
    np.testing.assert_array_equal(again.distances(Q), distances)


def test_clouds_and_grids_are_as_many_balls_and_boxes() -> None:
    random = np.random.default_rng(3)
    xyz = random.uniform(-4, 4, (200, 3))
    # The distance to overlapping cells is that to the nearest of them.
    xyz = xyz[np.abs(xyz[:, 1]) > 0.5]
    grid = random.random((8, 9, 7)) < 0.1
    corner = np.array([-2.0, 1.2, -0.5])
    cubes = [Box([0.4] * 3, corner + 0.4 * (cell + 0.5)) for cell in np.argwhere(grid)]
    one = Scene(SLIDER, [Points(xyz, 0.05), Voxels(grid, 0.4, corner)])
    many = Scene(SLIDER, [*extricate.spheres(xyz, 0.05), *cubes])
    indices = Scene(SLIDER, [Points(xyz, 0.05), Voxels(np.argwhere(grid), 0.4, corner)])
    assert len(one.pairs) == 2 and len(many.pairs) > 200
    Q = one.sample(200)
    np.testing.assert_array_equal(one.check(Q), many.check(Q))
    np.testing.assert_allclose(one.distances(Q), many.distances(Q), atol=1e-9)
    np.testing.assert_array_equal(one.distances(Q), indices.distances(Q))


@pytest.mark.parametrize("ground", [HalfSpace([0, 0, 1]), HeightField(np.zeros((41, 41)), 0.25, [-5, -5, 0])])
def test_the_way_out_of_the_ground_is_up(ground: object) -> None:
    scene = Scene(BALL, [ground])
    assert not scene.check([0.0, -0.5])
    answer = scene.query([0.02, -0.5])
    assert answer is not None and answer.verified
    assert answer.depth == pytest.approx(0.5 + 0.1 + 1e-4, rel=1e-4)
    assert answer.lower_bound > 0.999 * 0.6


def test_nothing_at_all_is_free() -> None:
    scene = Scene(SLIDER, [Points(np.zeros((0, 3))), Voxels(np.zeros((3, 3, 3), bool), 0.1)])
    assert scene.check([0.0]) and scene.distances([0.0]) == np.inf


def test_the_robots_own_points_are_left_out() -> None:
    scene = Scene(SLIDER, [Sphere(1.0, [8, 0, 0])])
    points = np.array([[0.5, 0, 0], [1.5, 0, 0], [4, 0.9, 0.9], [8, 0, 0]])
    np.testing.assert_array_equal(scene.robot_filter(points, [0.0]), [False, True, True, True])
    np.testing.assert_array_equal(scene.robot_filter(points, [0.0], 0.6), [False, False, True, True])
    np.testing.assert_array_equal(scene.robot_filter(points, [3.5], 0.01), [True, True, False, True])
    assert scene.robot_filter(np.zeros((0, 3)), [0.0]).shape == (0,)


WRONG = [
    (lambda: Scene(SLIDER, [Points([0, 0])]), ValueError, r'obstacle "points1": xyz: got shape \(2,\), expected \(n, 3\)'),
    (lambda: Scene(SLIDER, [Points([[0, 0, np.inf]])]), ValueError, r'obstacle "points1": row 1: got \(0, 0, inf\)'),
    (lambda: Scene(SLIDER, [Points([[0, 0, 0]], -1)]), ValueError, 'obstacle "points1": radius: got -1.0, expected 0 to 1e9'),
    (lambda: Scene(SLIDER, [Voxels(np.zeros((3, 3), bool), 1)]), ValueError, r"got an array of bool of shape \(3, 3\)"),
    (lambda: Scene(SLIDER, [Voxels([[0, 0, 0.5]], 1)]), ValueError, "got 0.5, expected whole numbers"),
    (lambda: Scene(SLIDER, [Voxels([[0, 0, 0]], 0)]), ValueError, 'obstacle "voxels1": size: got 0.0'),
    (lambda: Scene(SLIDER, [HalfSpace([0, 0])]), ValueError, "normal: expected three numbers"),
    (lambda: Scene(SLIDER, [HalfSpace([0, 0, 0])]), ValueError, "expected one that points somewhere"),
    (lambda: Scene(SLIDER, [HeightField([0, 1], 1)]), ValueError, r"got shape \(2,\), expected \(rows, columns\)"),
    (lambda: Scene(SLIDER, [HeightField([[0, 1]], 1)]), ValueError, "expected two full rows and columns"),
    (lambda: Scene(SLIDER).robot_filter([[0, 0, 0]], [0.0], -1), ValueError, "padding: got -1"),
    (lambda: Scene(SLIDER).robot_filter([[0, np.inf, 0]], [0.0]), ValueError, "points: row 0: expected finite"),
]


@pytest.mark.parametrize(("call", "exception", "message"), WRONG, ids=[message[:40] for _, _, message in WRONG])
def test_wrong_input_is_told_what_was_expected(call, exception: type, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(exception) as told:
        call()
    assert type(told.value) is exception
    assert re.search(message, str(told.value)), str(told.value)


def test_points_that_a_camera_did_not_see_are_left_out_and_counted() -> None:
    xyz = np.array([[5.0, 0, 0], [np.nan] * 3, [8, np.nan, 0], [8, 0, 0]])
    with pytest.warns(UserWarning, match="`cloud`: 2 of 4 points are left out: they have coordinates that are NaN"):
        scene = Scene(SLIDER, [Points(xyz, 0.5, name="cloud")])
    assert scene.distances([0.0]) == pytest.approx(3.5)
    with pytest.raises(ValueError, match="row 2: got"):
        Scene(SLIDER, [Points([[0, 0, 0], [np.inf, 0, 0]])])


def test_what_collides_wherever_one_looks_is_named() -> None:
    scene = Scene(SLIDER, [Box([100, 1, 1], name="wall")])
    told = r"no free configuration was found; these pairs collide in all of .*make the scene with disable=\[\[\"cart\", \"wall\"\]\]"
    with pytest.warns(UserWarning, match=told):
        assert scene.query([0.0]) is None
    with pytest.warns(UserWarning, match=told):
        scene.query_batch([[0.0], [1.0]])
    with pytest.warns(UserWarning, match=told):
        assert scene.escape([0.0]).points is None
