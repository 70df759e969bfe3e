"""Solvers: all calls on a scene, with options that stay the same."""

import pickle
import threading

import numpy as np
import pytest

import extricate
from extricate import Box, Model, Scene, Solver


def test_short_forms_say_what_a_solver_says(planar: Scene, model: Model) -> None:
    Q = planar.sample(30, seed=5, colliding=True)
    for short, solver in ((planar, Solver(planar)), (model, Solver(planar, model))):
        assert short.query_batch(Q, exits=2).tobytes() == solver.batch(Q, exits=2).tobytes()
        one, other = short.query(Q[0], segment=True), solver.query(Q[0], segment=True)
        assert one is not None and other is not None and repr(one) == repr(other)
        assert repr(short.escape(Q[0], tree_checks=500)) == repr(solver.escape(Q[0], tree_checks=500))
        assert repr(short.repair(Q[:3], max_checks=1000)) == repr(solver.repair(Q[:3], max_checks=1000))
        frames = [asked.stream() for asked in (short, solver)]
        for q in Q[:5]:
            first, second = (stream.query(q) for stream in frames)
            assert first is not None and second is not None and first.depth == second.depth
    np.testing.assert_array_equal(Solver(planar, model).check(Q), planar.check(Q))
    free = planar.sample(2, seed=2, colliding=False)
    assert repr(planar.plan(*free)) == repr(Solver(planar).plan(*free))


def test_options_of_a_solver_are_defaults_of_its_queries(planar: Scene, model: Model) -> None:
    q = planar.sample(1, seed=5, colliding=True)[0]
    solver = Solver(planar, model, exits=3, effort="exhaustive", max_checks=2000)
    answer = solver.query(q)
    assert answer is not None and answer.effort == "exhaustive" and answer.exits
    assert repr(answer) == repr(model.query(q, exits=3, effort="exhaustive", max_checks=2000))
    assert solver.batch([q]).dtype == model.query_batch([q], exits=3).dtype
    for keyword in (solver.query(q, exits=1), solver.query(q, exits=None)):
        assert keyword is not None and not keyword.exits and keyword.effort == "exhaustive"
    replaced = solver.query(q, options=extricate.QueryOptions(segment=True))
    assert replaced is not None and replaced.effort == "refined" and replaced.segment and not replaced.exits
    frame = solver.stream().query(q)  # A frame has one answer.
    assert frame is not None and frame.effort == "exhaustive" and not frame.exits
    by_object = Solver(planar, options=extricate.QueryOptions(exits=2), effort="quick").query(q)
    assert by_object is not None and by_object.exits and by_object.effort == "quick"


def test_the_nearest_exit_alone_is_a_witness(planar: Scene) -> None:
    solver, Q = Solver(planar), planar.sample(30, seed=5, colliding=True)
    for q in Q:
        witness, answer = solver.nearest_exit(q), solver.query(q)
        assert witness is not None and answer is not None and solver.check(witness)
        moved = (witness - q + np.pi) % (2 * np.pi) - np.pi  # turns without limits wrap
        assert np.linalg.norm(moved) <= 1.0001 * answer.depth
        kept = Solver(planar, locked=[planar.joints[0].name]).nearest_exit(q)
        assert kept is None or kept[0] == q[0]
    free = planar.sample(1, seed=2, colliding=False)[0]
    np.testing.assert_array_equal(solver.nearest_exit(free), free)


def test_a_call_says_which_joints_move(planar: Scene) -> None:
    q = planar.sample(1, seed=5, colliding=True)[0]
    names = [joint.name for joint in planar.joints]
    solver = Solver(planar, locked=names[:1])
    held, moved = solver.query(q), solver.query(q, free=names[:2])
    assert held is None or held.witness[0] == q[0]
    assert moved is None or moved.witness[2] == q[2]
    assert repr(solver.query(q, locked=[])) == repr(planar.query(q))
    heavy = Solver(planar, weights={names[0]: 100.0})
    assert repr(heavy.query(q)) == repr(planar.query(q, weights={names[0]: 100.0}))


def test_a_solver_goes_along_with_scenes_that_change(planar: Scene, model: Model) -> None:
    solver = Solver(planar, model, exits=2)
    moved = planar.moved({"cylinder_1": [0.5, 0.4, 0]})
    there = solver.with_scene(moved)
    Q = moved.sample(20, seed=1, colliding=True)
    assert there.batch(Q).tobytes() == model.in_scene(moved).batch(Q, exits=2).tobytes()
    assert there.scene.bodies == moved.bodies and there.model is not None and not there.check(Q).any()
    assert there.model.statistics == model.statistics
    assert Solver(planar).with_scene(moved).model is None
    stream = solver.stream()
    for q in Q[:5]:
        answer = stream.query(q, scene=there)
        assert answer is not None and answer.verified and moved.check(answer.witness)


def test_solvers_pickle_with_their_options(planar: Scene, model: Model) -> None:
    Q = planar.sample(20, seed=3, colliding=True)
    for solver in (Solver(planar), Solver(planar, model, exits=2, effort="quick"), model.in_world([Box([0.1, 0.1, 0.1], [0.7, 0, 0])])):
        again = pickle.loads(pickle.dumps(solver))
        assert repr(again) == repr(solver) and again.scene.bodies == solver.scene.bodies
        assert again.batch(Q).tobytes() == solver.batch(Q).tobytes()
    told = repr(Solver(planar, model, exits=2, effort="quick"))
    samples = model.statistics["boundary_samples"]
    assert told == f"<Solver of {len(planar.bodies)} bodies, {len(planar.pairs)} checked pairs, {samples} stored samples, exits=2, effort='quick'>"


def test_threads_share_a_solver_that_is_not_prepared(planar: Scene) -> None:
    q = planar.sample(1, seed=3, colliding=True)[0]
    solver = Solver(Scene.builtin("planar-arm"))
    depths = []

    def ask() -> None:
        answer = solver.query(q)
        depths.append(None if answer is None else answer.depth)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(depths) == 4 and len(set(depths)) == 1 and depths[0] is not None


def test_wrong_solvers_are_told_what_was_expected(planar: Scene, model: Model) -> None:
    hand = Scene.builtin("hand")
    for call, message in [
        (lambda: Solver(hand, model), "expected the same: learn it anew"),
        (lambda: Solver(planar, model).with_scene(hand), "expected the same: learn it anew"),
        (lambda: Solver(planar, exits=0), "exits: got 0, expected 1 to 100000"),
        (lambda: Solver(planar, gap=0.1, effort="nearest"), "gap: got 0.1, expected none with effort"),
        (lambda: Solver(planar, gap=0.1).query([0, 0, 0], exits=2), "exits: got 2, expected 1 with a gap"),
        (lambda: Solver(planar, locked=["elbo"]), "locked: got `elbo`"),
        (lambda: Solver(planar, locked=["joint_1"]).with_scene(hand), "locked: got `joint_1`"),
        (lambda: Solver(planar, effort="x"), 'effort: got "x"'),
    ]:
        with pytest.raises(ValueError, match=message):
            call()
    for keyword in ("threads", "errors", "hysteresis", "effrt"):
        with pytest.raises(TypeError, match=f"unexpected keyword argument '{keyword}'"):
            Solver(planar, **{keyword: 1})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="options: got dict, expected extricate.QueryOptions"):
        Solver(planar, options={"exits": 2})  # type: ignore[arg-type]
