"""Queries of a scene before anything is learned."""

import pickle

import numpy as np
import pytest

import extricate
from conftest import batch_of
from extricate import Box, Model, Scene


def test_answers_are_those_of_a_model_and_verified(model: Model, planar: Scene) -> None:
    Q = planar.sample(200, seed=12, colliding=True)
    batch, learned = planar.query_batch(Q), model.query_batch(Q)
    assert batch["verified"].all() and planar.check(batch["witness"]).all() and not batch["free"].any()
    assert (batch["lower_bound"] <= batch["depth"]).all()
    best = np.minimum(batch["depth"], learned["depth"])
    assert (batch["depth"] <= 1.05 * best).mean() >= 0.98
    for q, row in zip(Q[:20], batch):
        one = planar.query(q)
        assert one is not None and one.depth == row["depth"] and one.colliding == planar.colliding_pairs(q)
    again = pickle.loads(pickle.dumps(planar))
    np.testing.assert_array_equal(again.query_batch(Q, threads=1)["witness"], batch["witness"])


def test_every_effort_verifies_its_witness(planar: Scene) -> None:
    q = planar.sample(1, seed=3, colliding=True)[0]
    depths = []
    for effort in ["nearest", "refined", "exhaustive"]:
        answer = planar.query(q, effort=effort)
        assert answer is not None and answer.verified and planar.check(answer.witness)
        depths.append(answer.depth)
    assert depths == sorted(depths, reverse=True)
    few = planar.query(q, max_checks=1)
    assert few is not None and few.verified and few.depth >= depths[1]


def test_free_configurations_are_their_own_witness(planar: Scene) -> None:
    q = planar.sample(1, seed=4, colliding=False)[0]
    answer = planar.query(q)
    assert answer is not None and answer.depth == 0
    np.testing.assert_array_equal(answer.witness, q)


def test_a_stream_follows_a_motion(planar: Scene) -> None:
    ends = planar.sample(2, seed=8, colliding=True)
    frames = np.linspace(ends[0], ends[1], 200)
    stream = planar.stream(hysteresis=0.1)
    assert "of a scene" in repr(stream)
    alone = planar.query_batch(frames)["depth"]
    depths = []
    for q in frames:
        answer = stream.query(q)
        assert planar.check(answer.witness)
        depths.append(answer.depth)
    assert (np.array(depths) <= 1.16 * alone + 1e-9).mean() > 0.95


def test_beyond_the_limits_is_a_query(model: Model, planar: Scene) -> None:
    Q = planar.sample(50, seed=21)
    rng = np.random.default_rng(1)
    Q[np.arange(50), rng.integers(1, 3, 50)] = np.float32(planar.upper[1] + 0.05)
    limited = Q > planar.upper
    for asked in (planar, model, model.in_scene(planar)):
        batch = batch_of(asked)(Q)
        assert batch["verified"].all() and planar.check(batch["witness"]).all()
        assert (batch["free"] == ~limited.any(axis=1) & (batch["depth"] == 0)).all()
        moved = batch["witness"] - Q
        moved[:, 0] = (moved[:, 0] + np.pi) % (2 * np.pi) - np.pi  # The first joint has no limits.
        assert np.allclose(np.linalg.norm(moved, axis=1), batch["depth"])
        for q, row, beyond in zip(Q[:10], batch, limited):
            one = asked.query(q)
            assert one is not None and one.depth == row["depth"]
            assert one.outside == [joint.name for joint, is_beyond in zip(planar.joints, beyond) if is_beyond]
            assert not one.outside or "limits of" in str(one)


def test_witnesses_survive_single_precision(model: Model, planar: Scene) -> None:
    witnesses = model.query_batch(planar.sample(500, seed=2, colliding=True))["witness"].astype(np.float32)
    again = model.query_batch(witnesses.astype(np.float64))
    assert again["verified"].all() and (again["depth"] < 1e-5).all()


def test_where_nothing_is_free_that_is_said() -> None:
    urdf = Scene.builtin_files("planar-arm")["robot/arm.urdf"].decode()
    buried = Scene(urdf, [Box([9, 9, 9])])
    told = r"no free configuration was found; these pairs collide in all of 100 .* disable=\["
    for ask in (buried.query, buried.query, buried.escape, lambda q: buried.query_batch([q])):
        # The warning comes each time, although the advice is computed once.
        with pytest.warns(UserWarning, match=told):
            answer = ask([0, 0, 0])
        assert answer is None or not getattr(answer, "points", None)
    with pytest.warns(UserWarning, match=told):
        row = buried.query_batch([[0, 0, 0]])[0]
    assert row["depth"] == np.inf and not row["verified"] and np.isnan(row["witness"]).all()


def test_wrong_input_is_told_what_was_expected(model: Model, planar: Scene) -> None:
    for call, message in [
        (lambda: planar.query([0, 0]), r"q: got shape \(2,\), expected \(3,\)"),
        (lambda: planar.query([0, 0, np.nan]), "not finite|finite"),
        (lambda: planar.query([0, 0, 0], effort="x"), 'effort: got "x"'),
        (lambda: planar.stream(hysteresis=2), "hysteresis: got 2"),
        (lambda: planar.stream().query([0, 0, 0], scene=extricate.Solver(Scene.builtin("hand"))), "scene: got one of other coordinates"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()


def test_options_are_the_keywords_as_one_object(planar):
    q = planar.sample(1, seed=3, colliding=True)[0]
    options = extricate.QueryOptions(exits=2, segment=True, max_checks=500)
    by_object, by_keywords = planar.query(q, options=options), planar.query(q, exits=2, segment=True, max_checks=500)
    assert by_object.depth == by_keywords.depth and by_object.segment == by_keywords.segment
    assert len(by_object.exits) == len(by_keywords.exits)
    assert not planar.query(q, options=options, exits=1).exits, "a keyword counts more"
    assert planar.query_batch([q], options=options).dtype == planar.query_batch([q], exits=2, segment=True).dtype
    assert planar.stream(options=extricate.QueryOptions(segment=True)).query(q).segment is not None
    with pytest.raises(ValueError, match="exits: got|options: got exits"):
        planar.stream(options=options)
    with pytest.raises(TypeError, match="options: got dict, expected extricate.QueryOptions"):
        planar.query(q, options={"exits": 2})
    with pytest.raises(ValueError, match="max_checks: got -1"):
        planar.query(q, options=extricate.QueryOptions(max_checks=-1))
