"""Queries in a changed scene with the model of the scene before."""

import pickle

import numpy as np
import pytest

import extricate
from extricate import Box, Cylinder, Model, Robot, Scene, Solver

URDF = Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()
LOCKED = Robot(URDF, locked={"joint_1": 0.3})


def scene_with(post: float, **options: float) -> Scene:
    """Makes the built-in arm with its first joint locked and two posts, one of them at x = `post` [m]."""
    return Scene(LOCKED, [Cylinder(0.12, 0.4, (post, 0.3, 0)), Cylinder(0.14, 0.4, (0.8, -0.35, 0))], **options)


@pytest.fixture(scope="module")
def before() -> Model:
    return extricate.learn(scene_with(0.62), labels=20_000)


@pytest.fixture(scope="module")
def after() -> Scene:
    return scene_with(0.5)


@pytest.fixture(scope="module")
def changed(before: Model, after: Scene) -> Solver:
    return before.in_scene(after)


def test_answers_hold_in_the_changed_scene(before: Model, after: Scene, changed: Solver) -> None:
    Q = after.sample(100, seed=5, colliding=True)
    assert not after.check(before.query_batch(Q)["witness"]).all()  # Witnesses of the old scene do not all hold.
    anew = extricate.learn(after, labels=20_000).query_batch(Q)["depth"]
    batch = changed.batch(Q, threads=2)
    assert after.check(batch["witness"]).all() and batch["verified"].all() and not batch["free"].any()
    assert (batch["lower_bound"] <= batch["depth"]).all()
    assert (batch["depth"] <= 1.05 * anew).mean() > 0.9
    for q, row in zip(Q[:20], batch):
        one = changed.query(q)
        assert one is not None and one.depth == row["depth"] and one.colliding == after.colliding_pairs(q)
    several = changed.query(Q[0], exits=3, segment=True, starts=4, max_checks=10_000)
    assert several is not None and several.exits and several.segment
    assert changed.scene.pairs == after.pairs and repr(changed).startswith("<Solver of ")
    assert changed.model is not None and changed.model.to_bytes() == before.to_bytes()
    again = pickle.loads(pickle.dumps(changed))
    np.testing.assert_array_equal(again.batch(Q)["witness"], batch["witness"])


def test_where_nothing_is_free_that_is_said(before: Model) -> None:
    buried = before.in_scene(scene_with(0.62, clearance=50.0))
    assert buried.query([0, 0]) is None
    row = buried.batch([[0, 0], [1, 1]])[1]
    assert row["depth"] == np.inf and row["lower_bound"] == 0 and not row["verified"] and not row["free"]
    assert np.isnan(row["witness"]).all() and np.isnan(row["gradient"]).all()


def test_wrong_scenes_are_told_what_was_expected(before: Model, planar: Scene) -> None:
    limited = Scene(Robot(URDF, locked={"joint_1": 0.3}, limits={"joint_2": (-1, 1)}), [Box([0.1, 0.1, 0.1], pose=[0.7, 0, 0])])
    for call, message in [
        (lambda: before.in_scene(planar), "scene: joint .*expected the same: learn it anew"),
        (lambda: before.in_scene(limited), 'scene: joint "joint_2": got other coordinates, limits'),
        (lambda: before.in_scene(scene_with(0.6, metric="object-norm")), "scene: metric: got object-norm, expected that"),
        (lambda: before.in_scene(scene_with(0.6)).query([0, 0, 0]), r"q: got shape \(3,\), expected \(2,\)"),
        (lambda: before.in_scene(scene_with(0.6)).batch([[0, np.nan]]), r"Q\[0\]: configuration: `joint_3`.*got NaN"),
        (lambda: before.in_scene(scene_with(0.6)).query([0, 0], effort="x"), 'effort: got "x"'),
    ]:
        with pytest.raises(ValueError, match=message):
            call()
