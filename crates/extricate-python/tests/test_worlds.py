"""Changed scenes, models in other worlds, and properties that answers keep."""

import pickle

import numpy as np
import pytest

import extricate
from conftest import batch_of
from extricate import Box, Model, Scene, Sphere

GRIPPER = """<robot name="gripper"><link name="rail"/>
    <link name="palm"><collision><geometry><box size="0.1 0.2 0.1"/></geometry></collision></link>
    <link name="left"><collision><geometry><box size="0.1 0.02 0.05"/></geometry></collision></link>
    <link name="right"><collision><geometry><box size="0.1 0.02 0.05"/></geometry></collision></link>
    <joint name="slide" type="prismatic"><parent link="rail"/><child link="palm"/><axis xyz="1 0 0"/>
      <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="grip" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>
      <limit lower="0.01" upper="0.08" effort="1" velocity="1"/></joint>
    <joint name="grip2" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0.1 0 0"/><axis xyz="0 -1 0"/>
      <mimic joint="grip"/><limit lower="0.01" upper="0.08" effort="1" velocity="1"/></joint></robot>"""
WALL = Box([0.2, 1.0, 1.0], pose=[0.6, 0, 0], name="wall")


def test_obstacles_move_come_and_go() -> None:
    scene = Scene(GRIPPER, [WALL])
    q = [0.4, 0.03]
    moved = scene.moved({"wall": [0.7, 0, 0]})
    for changed, depth in [(scene, 0.0501), (moved, 0.0), (moved.moved({"wall": [0.6, 0, 0, 0, 0, 0]}), 0.0501)]:
        answer = changed.query(q)
        assert answer is not None and abs(answer.depth - depth) < 1e-5
        again = Scene(GRIPPER, [Box(WALL.size, pose=[0.7 if changed is moved else 0.6, 0, 0], name="wall")]).query(q)
        assert again is not None and again.depth == answer.depth
    more = moved.with_obstacles([Sphere(0.1, [0.5, 0, 0]), Sphere(0.1, [0, 5, 0])])
    assert more.bodies[-2:] == ["sphere1", "sphere2"] and len(more.pairs) == len(moved.pairs) + 6
    held = more.query(q)
    assert held is not None and held.depth > 0.05 and "sphere1" in str(held)
    assert more.without(["sphere1", "sphere2"]).pairs == moved.pairs
    rest = scene.disabled([("left", "wall"), ("wall", "right")])
    assert rest.pairs == [pair for pair in scene.pairs if pair not in [("left", "wall"), ("right", "wall")]]
    assert pickle.loads(pickle.dumps(more)).bodies == more.bodies
    with pytest.raises(ValueError, match=r"obstacle \"box\": got `box`, expected one of `wall`"):
        scene.moved({"box": [0, 0, 0]})
    with pytest.raises(ValueError, match="the name is taken"):
        scene.with_obstacles([WALL])
    with pytest.raises(ValueError, match="expected"):
        scene.moved({"wall": [1, 2]})


def test_a_row_of_changes_keeps_no_chain() -> None:
    scene = Scene(GRIPPER, [WALL])
    assert scene.query([0.4, 0.03]) is not None
    for k in range(300):
        scene = scene.moved({"wall": [0.6 + 1e-4 * k, 0, 0]})
        answer = scene.query([0.4, 0.03]) if k % 2 else None
        assert answer is None or abs(answer.depth - (0.0501 - 1e-4 * k)) < 1e-5


def test_an_object_in_the_gripper() -> None:
    scene = Scene(GRIPPER, [WALL])
    rod = Box([0.4, 0.04, 0.04], name="rod")
    held = scene.attach(rod, link="palm", pose=[0.3, 0, 0], touch=["left", "right"])
    answer = held.query([0.05, 0.025])
    assert answer is not None and answer.colliding == [("wall", "rod")] and abs(answer.depth - 0.0501) < 1e-5
    assert not held.check([0.05, 0.025]) and abs(float(held.distances([0.05, 0.025])) + 0.05) < 1e-9
    # A model of the empty hand answers queries with the rod too.
    model = extricate.learn(scene, labels=3000)
    for q in held.sample(30, seed=1, colliding=True):
        one = model.in_world(held).query(q)
        assert one is not None and one.verified and held.check(one.witness)
    with pytest.raises(ValueError, match="link: got `plam`, expected one of `rail`"):
        scene.attach(rod, link="plam")


def test_a_model_of_the_robot_alone_is_asked_in_any_world(planar: Scene) -> None:
    scene = Scene(GRIPPER)
    model = extricate.learn(scene, labels=500)
    world = model.in_world([WALL])
    answer = world.query([0.4, 0.03])
    assert answer is not None and abs(answer.depth - 0.0501) < 1e-5
    assert world.scene.bodies[-1] == "wall"
    with pytest.raises(ValueError, match="other coordinates"):
        model.in_world(planar)


def test_clearances_of_pairs_and_of_bodies() -> None:
    for options in [
        {"clearance": 0.02, "pair_clearance": [("left", "right", 1e-4)]},
        {"clearance": {"world": 0.02, "self": 1e-4}},
        {"padding": {"wall": 0.0199}},
    ]:
        scene = Scene(GRIPPER, [WALL], **options)  # type: ignore[arg-type]
        answer = scene.query([0.34, 0.015])
        assert answer is not None and abs(answer.depth - 0.01) < 1e-5
        assert answer.colliding == [("left", "wall"), ("right", "wall")]
    with pytest.raises(TypeError, match="expected a number"):
        Scene(GRIPPER, clearance={"wrld": 1})
    with pytest.raises(ValueError, match="padding: palm: got -1"):
        Scene(GRIPPER, padding={"palm": -1})


def test_what_answers_have_to_keep(planar: Scene, model: Model) -> None:
    Q = planar.sample(40, seed=5, colliding=True)
    names = [joint.name for joint in planar.joints]
    for asked in (planar, model, model.in_world(planar)):
        wide = asked.query(Q[0], clearance=0.01, free_radius=True)
        assert wide is not None and wide.clearance == 0.01 and wide.free_radius is not None and wide.free_radius > 0.001
        batch = batch_of(asked)(Q, clearance=0.01, free_radius=True)
        assert (batch["clearance"] == 0.01).all() and (batch["free_radius"] > 0).all()
        assert batch["depth"][0] == wide.depth
        for q in Q[:10]:
            one = asked.query(q, locked=names[:1])
            other = asked.query(q, free=names[1:])
            assert (one is None) == (other is None)
            if one is not None and other is not None:
                assert one.witness[0] == q[0] and one.depth == other.depth and planar.check(one.witness)
        heavy = batch_of(asked)(Q, weights={names[0]: 100.0})
        plain = batch_of(asked)(Q)
        turns = [np.abs(rows["witness"][:, 0] - Q[:, 0]) for rows in (heavy, plain)]
        assert turns[0].mean() < turns[1].mean() and heavy["verified"].all()
        toward = asked.query(Q[0], toward=Q[1], toward_share=0.5)
        assert toward is not None and toward.depth <= 1.5 * plain["depth"][0] + 1e-12
        assert asked.query(Q[0], locked=names) is None
    stream = model.stream(clearance=0.01, locked=names[:1])
    frame = stream.query(Q[0])
    assert frame is None or (frame.clearance == 0.01 and frame.witness[0] == Q[0][0])
    for bad, message in [
        ({"locked": ["elbo"]}, "locked: got `elbo`"),
        ({"locked": names[:1], "free": names[:1]}, "got both"),
        ({"clearance": -1.0}, "clearance: got -1"),
        ({"toward": [0.0]}, "toward: got shape"),
        ({"weights": {"elbo": 1.0}}, "got `elbo`"),
        ({"limits": "forget"}, 'expected "forgive" or "refuse"'),
    ]:
        with pytest.raises(ValueError, match=message):
            model.query(Q[0], **bad)  # type: ignore[call-overload]
    with pytest.raises(TypeError, match="unexpected keyword argument 'effrt'"):
        model.query(Q[0], effrt="refined")  # type: ignore[call-overload]


def test_bad_rows_are_answered_as_such_where_that_is_asked_for(planar: Scene, model: Model) -> None:
    Q = planar.sample(6, seed=6, colliding=True)
    Q[2, 0] = np.nan
    Q[4, 1] = planar.upper[1] + 0.1
    for asked in (planar, model):
        with pytest.raises(ValueError, match=r"Q\[2\]"):
            asked.query_batch(Q)
        rows = asked.query_batch(Q, errors="mask")
        assert np.isnan(rows["depth"]).tolist() == [False, False, True, False, False, False]
        assert not rows["verified"][2] and rows["verified"][[0, 1, 3, 4, 5]].all()
        refused = asked.query_batch(Q, errors="mask", limits="refuse")
        assert np.isnan(refused["depth"]).tolist() == [False, False, True, False, True, False]
        with pytest.raises(ValueError, match="q"):
            asked.query(Q[4], limits="refuse")
        assert asked.query(Q[4]) is not None
