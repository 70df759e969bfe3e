"""Batches return more than the nearest exit: several exits, the straight segment, pairs."""

import numpy as np
import pytest

import extricate
from conftest import batch_of
from extricate import Model, Scene

PLAIN = ("depth", "lower_bound", "gap", "max_displacement", "clearance", "unseen", "checks", "witness", "gradient", "verified", "free", "unique")


def test_nothing_has_a_field_that_was_not_asked_for(model: Model, planar: Scene) -> None:
    Q = planar.sample(10, seed=2)
    assert model.query_batch(Q).dtype.names == PLAIN
    assert model.query_batch(Q, exits=1, segment=False, contacts=False).dtype == model.query_batch(Q).dtype
    asked = {
        "exits": ["exit_count", "exit_depths", "exit_witnesses"],
        "segment": ["segment"],
        "contacts": ["colliding", "touching"],
    }
    for option, fields in asked.items():
        told = model.query_batch(Q, **{option: 2 if option == "exits" else True})
        assert set(told.dtype.names or ()) == {*PLAIN, *fields}, option


@pytest.mark.parametrize("what", ["model", "elsewhere", "scene"])
def test_a_batch_tells_the_exits_ways_and_pairs_of_single_queries(model: Model, planar: Scene, what: str) -> None:
    asked = {"model": model, "elsewhere": model.in_scene(planar), "scene": planar}[what]
    Q = planar.sample(120, seed=9)
    k, pairs = 3, planar.pairs
    batch = batch_of(asked)(Q, exits=k, segment=True, contacts=True, threads=2)
    assert batch["exit_depths"].shape == (120, k) and batch["exit_witnesses"].shape == (120, k, planar.nq)
    assert batch["exit_count"].dtype == np.int64 and batch["segment"].shape == (120, 2)
    assert batch["colliding"].shape == batch["touching"].shape == (120, len(pairs))
    assert batch["exit_touching"].shape == (120, k, len(pairs)) and batch["touching"].dtype == bool
    several = 0
    for q, row in zip(Q, batch):
        one = asked.query(q, exits=k, segment=True)
        assert one is not None
        count = row["exit_count"]
        assert count == len(one.exits) and (count == 0) == row["free"]
        several += count > 1
        for place, found in enumerate(one.exits):
            assert row["exit_depths"][place] == found.depth
            np.testing.assert_array_equal(row["exit_witnesses"][place], found.witness)
            assert [pairs[at] for at in np.flatnonzero(row["exit_touching"][place])] == found.touching
        assert np.isnan(row["exit_depths"][count:]).all() and np.isnan(row["exit_witnesses"][count:]).all()
        assert not row["exit_touching"][count:].any()
        assert [pairs[at] for at in np.flatnonzero(row["colliding"])] == one.colliding
        assert [pairs[at] for at in np.flatnonzero(row["touching"])] == one.touching
        np.testing.assert_array_equal(row["segment"], one.segment or [np.nan, np.nan])
        for field in ["depth", "lower_bound", "max_displacement", "checks", "verified", "free", "unique"]:
            assert row[field] == getattr(one, field), field
        np.testing.assert_array_equal(row["witness"], one.witness)
        np.testing.assert_array_equal(row["gradient"], one.gradient)
    assert several > 10
    colliding = batch[~batch["free"]]
    np.testing.assert_array_equal(colliding["exit_depths"][:, 0], colliding["depth"])
    np.testing.assert_array_equal(colliding["exit_witnesses"][:, 0], colliding["witness"])
    found = np.arange(k) < batch["exit_count"][:, None]
    assert planar.check(batch["exit_witnesses"][found]).all()


def test_nearest_samples_come_with_their_pairs(model: Model, planar: Scene) -> None:
    Q = planar.sample(50, seed=3, colliding=True)
    batch = model.query_batch(Q, effort="nearest", contacts=True)
    for q, row in zip(Q, batch):
        assert [planar.pairs[at] for at in np.flatnonzero(row["colliding"])] == planar.colliding_pairs(q)
    np.testing.assert_array_equal(batch["depth"], model.query_batch(Q, effort="nearest")["depth"])


def test_where_nothing_is_free_there_are_no_exits(model: Model, planar: Scene) -> None:
    urdf = Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()
    buried = model.in_scene(Scene(urdf, [extricate.Sphere(0.1, [0.5, 0, 0])], clearance=50.0))
    rows = buried.batch(np.zeros((2, 3)), exits=2, segment=True, contacts=True)
    assert (rows["exit_count"] == 0).all() and np.isnan(rows["exit_depths"]).all() and np.isnan(rows["exit_witnesses"]).all()
    assert np.isnan(rows["segment"]).all() and not rows["colliding"].any() and not rows["touching"].any()
    assert (rows["depth"] == np.inf).all() and not rows["free"].any()


def test_wrong_questions_are_told(model: Model) -> None:
    Q = np.zeros((2, 3))
    for wrong, message in [
        ({"exits": 0}, "exits: got 0, expected 1 to 100000"),
        ({"starts": 10**12}, "starts: got 1000000000000, expected 1 to 100000"),
        ({"exits": -2}, "exits: got -2, expected 1 to 100000"),
        ({"exits": 10**15}, "exits: got 1000000000000000, expected 1 to 100000"),
        ({"exits": 2, "effort": "nearest"}, 'exits: got 2, expected 1 with effort "nearest"'),
    ]:
        with pytest.raises(ValueError, match=message):
            model.query_batch(Q, **wrong)
        with pytest.raises(ValueError, match=message):
            model.query(Q[0], **wrong)
