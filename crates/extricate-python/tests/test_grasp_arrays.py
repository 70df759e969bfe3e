"""Conversion of grasps from the arrays of data sets, and back."""

import pathlib
from typing import Any, Dict

import numpy as np
import pytest

import extricate
from extricate import grasps

JOINTS = ["index_spread", "index_curl", "middle_spread", "middle_curl", "thumb_curl"]


@pytest.fixture(scope="module")
def hand(tmp_path_factory: pytest.TempPathFactory) -> extricate.Scene:
    """Makes the built-in hand with a floating base."""
    folder: pathlib.Path = tmp_path_factory.mktemp("hand")
    for name, content in extricate.Scene.builtin_files("hand").items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(content)
    robot = extricate.Robot(
        folder / "robot/hand.urdf", packages=[folder], geometry="convex-hull", base="floating", bounds=([-1] * 3, [1] * 3)
    )
    return extricate.Scene(robot)


def given(n: int = 20) -> Dict[str, Any]:
    rng = np.random.default_rng(1)
    turns = rng.normal(size=(n, 4))
    # Half turns, no turn, and quarter turns about y, at which roll and yaw have the same axis.
    half = np.sqrt(0.5)
    turns[:6] = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [0, half, 0, half], [0, -half, 0, half]]
    turns[6] = [0.5, 0.5, -0.5, 0.5]
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    return {"translation": rng.uniform(-0.5, 0.5, (n, 3)), "quat": turns, "joints": rng.uniform(0, 0.5, (n, 5))}


def root(hand: extricate.Scene, q: Any) -> Any:
    return hand.poses(q, of=["palm"])[0]


def about(axis: int, angle: float) -> Any:
    turned = np.eye(3)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    turned[a, a] = turned[b, b] = np.cos(angle)
    turned[a, b], turned[b, a] = -np.sin(angle), np.sin(angle)
    return turned


def test_the_hand_stands_where_the_arrays_say(hand: extricate.Scene) -> None:
    data, columns = given(), JOINTS[::-1]
    Q = grasps.from_arrays(hand, data["translation"], data["quat"], data["joints"], names=columns, rotation_as="quat_xyzw")
    assert Q.shape == (20, hand.nq)
    for k, q in enumerate(Q):
        x, y, z, w = data["quat"][k]
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        # Rodrigues' formula is independent of the implementation.
        assert root(hand, q)[:3, :3] == pytest.approx(np.eye(3) + 2 * w * cross + 2 * cross @ cross, abs=1e-12)
        assert root(hand, q)[:3, 3] == pytest.approx(data["translation"][k], abs=1e-12)
        positions = hand.positions(q)
        assert [positions[name] for name in columns] == data["joints"][k].tolist()


def test_roll_pitch_and_yaw_are_about_fixed_axes(hand: extricate.Scene) -> None:
    angles = np.random.default_rng(2).uniform(-1.5, 1.5, (10, 3))
    Q = grasps.from_arrays(hand, np.zeros((10, 3)), angles, {name: np.zeros(10) for name in JOINTS}, rotation_as="rpy")
    for q, (roll, pitch, yaw) in zip(Q, angles):
        assert root(hand, q)[:3, :3] == pytest.approx(about(2, yaw) @ about(1, pitch) @ about(0, roll), abs=1e-12)


def test_columns_are_orthonormalized_first_one_first(hand: extricate.Scene) -> None:
    zeros = {name: [0.0] for name in JOINTS}
    q = grasps.from_arrays(hand, np.zeros((1, 3)), [[0, 2, 0, -3, 5, 0]], zeros, rotation_as="columns")[0]
    assert root(hand, q)[:3, :3] == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), abs=1e-12)


@pytest.mark.parametrize("form", grasps.ROTATIONS)
def test_there_and_back(hand: extricate.Scene, form: str) -> None:
    data = given()
    by_name = dict(zip(JOINTS, data["joints"].T))
    Q = grasps.from_arrays(hand, data["translation"], data["quat"], by_name, rotation_as="quat_xyzw")
    arrays = grasps.to_arrays(hand, Q, rotation_as=form, names=JOINTS[::-1])
    assert arrays.names == JOINTS[::-1] and (arrays.joints == data["joints"][:, ::-1]).all()
    again = grasps.from_arrays(hand, *arrays[:3], names=arrays.names, rotation_as=form)
    assert (again[:, 7:] == Q[:, 7:]).all() and (again[:, :3] == Q[:, :3]).all()
    # q and -q are the same rotation.
    assert np.abs((again[:, 3:7] * Q[:, 3:7]).sum(1)) == pytest.approx(np.ones(20), abs=1e-12)
    assert hand.poses(again) == pytest.approx(hand.poses(Q), abs=1e-9)
    stored = [np.float32(part) for part in arrays[:3]]
    single = grasps.from_arrays(hand, *stored, names=arrays.names, rotation_as=form)
    assert hand.poses(single) == pytest.approx(hand.poses(Q), abs=1e-6)


def test_what_mimics_is_left_out_where_that_is_said(hand: extricate.Scene) -> None:
    by_name = {name: [0.1] for name in JOINTS}
    unit = np.eye(3)[None]
    with pytest.raises(ValueError, match="joints: got 'index_tip'.*`ignore`"):
        grasps.from_arrays(hand, [[0, 0, 0]], unit, {**by_name, "index_tip": [0.1]})
    Q = grasps.from_arrays(hand, [[0, 0, 0]], unit, {**by_name, "index_tip": [0.1]}, ignore=["index_tip"])
    assert (Q == grasps.from_arrays(hand, [[0, 0, 0]], unit, by_name)).all()
    assert grasps.from_arrays(hand, np.zeros((0, 3)), np.zeros((0, 3, 3)), {name: [] for name in JOINTS}).shape == (0, hand.nq)


NAMES = list(JOINTS)


@pytest.mark.parametrize(
    "changed, message",
    [
        ({"translation": [[0, 0]]}, r"translation: got shape \(1, 2\), expected \(n, 3\)"),
        ({"translation": [[0, np.nan, 0]]}, r"translation\[0, 1\]: got nan, expected a finite number"),
        ({"rotation": [[0, 0, 0, 1]]}, r"rotation: got shape \(1, 4\), expected \(1, 3, 3\)"),
        ({"rotation": np.zeros((2, 3, 3))}, r"rotation: got shape \(2, 3, 3\), expected \(1, 3, 3\)"),
        ({"rotation": [np.diag([1, 1, -1])]}, r"rotation\[0\]: .* a reflection, expected a rotation matrix"),
        ({"rotation": [np.eye(3) * 1.1]}, r"rotation\[0\]: .* off by 0.21, expected a rotation matrix"),
        ({"rotation_as": "quat", "rotation": [[0, 0, 0, 1]]}, r"rotation_as: got 'quat', expected one of matrix, quat_xyzw"),
        ({"rotation_as": "quat_wxyz", "rotation": [[0, 0, 0, 2]]}, r"rotation\[0\]: got \[0.0, 0.0, 0.0, 2.0\] of length 2, expected 1"),
        ({"rotation_as": "columns", "rotation": [[1, 0, 0, 2, 0, 0]]}, r"rotation\[0\]: .* not parallel"),
        ({"names": None}, "names: got None"),
        ({"names": NAMES[:4]}, r"joints: got shape \(1, 5\), expected \(1, 4\)"),
        ({"names": [*NAMES[:4], "index_curl"]}, "names: got 'index_curl' twice"),
        ({"names": [*NAMES[:4], "elbow"]}, "joints: got 'elbow', expected joints of the scene"),
        ({"names": NAMES[:4], "joints": [[0] * 4]}, "joints: 'thumb_curl' is missing"),
        ({"ignore": ["thumb_curl"]}, "joints: 'thumb_curl' is missing"),
        ({"ignore": ["elbow"]}, "ignore: got 'elbow'"),
        ({"joints": {}}, "names: got both"),
        ({"base": "wrist"}, "base: got 'wrist', expected a floating joint: base"),
    ],
)
def test_wrong_arrays_are_told_what_was_expected(hand: extricate.Scene, changed: Dict[str, Any], message: str) -> None:
    right: Dict[str, Any] = {"translation": [[0, 0, 0]], "rotation": [np.eye(3)], "joints": [[0] * 5], "names": NAMES}
    assert grasps.from_arrays(hand, **right).shape == (1, hand.nq)
    with pytest.raises(ValueError, match=message):
        grasps.from_arrays(hand, **{**right, **changed})


def test_a_hand_that_stands_still_is_no_floating_one() -> None:
    fixed = extricate.Scene.builtin("hand")
    with pytest.raises(ValueError, match="got 0 floating joints, expected one .a robot with base=\"floating\""):
        grasps.to_arrays(fixed, [[0] * fixed.nq])


def test_wrong_configurations_are_told_what_was_expected(hand: extricate.Scene) -> None:
    with pytest.raises(ValueError, match=r"Q: got shape \(12,\), expected \(n, 12\)"):
        grasps.to_arrays(hand, hand.lower)
    with pytest.raises(ValueError, match=r"quaternions of the base\[0\]: .* of length 0, expected 1"):
        grasps.to_arrays(hand, np.zeros((1, 12)))
    good = [[0, 0, 0, 0, 0, 0, 1, *[0] * 5]]
    with pytest.raises(ValueError, match=r"names\[1\]: got 'elbow'"):
        grasps.to_arrays(hand, good, names=["thumb_curl", "elbow"])
    with pytest.raises(ValueError, match="rotation_as: got 'euler'"):
        grasps.to_arrays(hand, good, rotation_as="euler")
