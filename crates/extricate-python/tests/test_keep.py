"""Links that queries keep in place."""

import numpy as np
import pytest

from extricate import Scene, Solver


def test_the_tool_stays_and_the_answer_says_how_far_it_is_off() -> None:
    scene = Scene.builtin("shelf-arm")
    queries = scene.sample(24, seed=3, colliding=True)
    link = scene.joints[-1].name.replace("joint", "link")
    kept = 0
    for q in queries:
        plain = scene.query(q)
        answer = scene.query(q, keep={"link": link, "rotation": None})
        assert plain is not None
        if answer is None:
            continue
        kept += 1
        assert answer.verified and scene.check(answer.witness) and answer.depth >= plain.lower_bound
        before, after = (scene.poses(each, of=[link])[0] for each in (q, answer.witness))
        off = float(np.linalg.norm(after[:3, 3] - before[:3, 3]))
        assert off <= 1e-4 and answer.kept[0][0] == pytest.approx(off, abs=1e-12)
        given = scene.query(q, keep=[{"link": link, "pose": before, "rotation": None}])
        assert given is not None and given.depth == pytest.approx(answer.depth, rel=0.05)
    assert kept > 8


def test_a_list_may_hold_names() -> None:
    scene = Scene.builtin("dual-arm")
    q, hands = scene.sample(1, seed=2, colliding=False)[0], ["left/gripper", "right/gripper"]
    named = scene.query(q, keep=hands)
    assert named is not None and named.free
    moved = scene.sample(1, seed=3, colliding=False)[0]
    poses = scene.poses(moved, of=hands)
    answers = [
        scene.query(q, keep=[first, {"link": hands[1], "pose": poses[1]}]) for first in (hands[0], {"link": hands[0]})
    ]
    assert all(answer is not None and answer.off == [1] for answer in answers)
    assert answers[0] is not None and answers[1] is not None and (answers[0].witness == answers[1].witness).all()
    with pytest.raises(TypeError, match="keep"):
        scene.query(q, keep=[3])  # type: ignore[list-item]


def test_a_free_query_is_moved_to_a_pose() -> None:
    scene = Scene.builtin("shelf-arm")
    q, target = scene.sample(2, seed=5, colliding=False)
    link = scene.joints[-1].name.replace("joint", "link")
    pose = scene.poses(target, of=[link])[0]
    answer = Solver(scene, keep={"link": link, "pose": pose, "position": np.float64(1e-3)}).query(q)
    assert answer is not None and answer.off == [0] and not answer.free and answer.unproved == "off"
    assert np.allclose(scene.poses(answer.witness, of=[link])[0], pose, atol=2e-3)
    assert "kept" in str(answer)
    rows = scene.query_batch(np.array([q, target]), keep={"link": link, "pose": pose})
    assert not rows["free"][0] and rows["free"][1]
    moved = scene.query(q, keep={"link": link, "pose": pose})
    assert moved is not None and rows["kept"].shape == (2, 1, 2)
    assert rows["kept"][0].tolist() == [list(off) for off in moved.kept] and np.isnan(rows["kept"][1]).all()


@pytest.mark.parametrize(
    "keep, said",
    [
        ("tol", "keep: got `tol`, expected one of"),
        ({"link": "link_7", "wide": 1}, "unknown field `wide`"),
        ({"link": "link_7", "position": 0}, "position 0"),
        ({"link": "link_7", "pose": [1, 2]}, "keep\\[\"pose\"\\]: got shape"),
        ({}, "missing field `link`"),
    ],
)
def test_what_makes_no_sense_is_named(keep: object, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Scene.builtin("shelf-arm").query(np.zeros(7), keep=keep)  # type: ignore[arg-type]


def test_a_batch_says_how_far_apart_pairs_are_that_have_to_touch() -> None:
    scene = Scene.builtin("free-box")
    Q = scene.sample(4, seed=1)
    rows = scene.query_batch(Q, touch=[("body", "floor")])
    for row, q in zip(rows, Q):
        one = scene.query(q, touch=[("floor", "body")])
        assert one is not None and row["depth"] == one.depth and (row["witness"] == one.witness).all()
        assert row["kept"].tolist() == [list(one.kept[0])] and one.kept[0][0] <= 5e-4


def test_paths_keep_the_tool_all_along() -> None:
    scene = Scene.builtin("shelf-arm")
    q = [1.4, -1.6, 0.6, 0.8, 0.5, -1.7, -2.2]
    keep = {"link": "gripper", "pose": scene.poses(q, of=["gripper"])[0], "rotation": None}
    escape = scene.escape(q, keep=keep, tolerance=0.005)
    assert escape.points is not None and len(escape.points) > 4
    back = np.concatenate([escape.points[::-1], escape.points[1:]])
    repaired = scene.repair(back, keep=keep)
    frames = scene.repair(back, keep={"link": "gripper", "rotation": None}, frames=True)
    assert repaired.points is not None and frames.points is not None and len(frames.points) == len(back)
    home = np.array([0, 0.3, 0, 1.2, 0, 0.8, 0])
    there = {"link": "gripper", "pose": scene.poses(home, of=["gripper"])[0]}
    goal = scene.query(np.array([1.0, 0.3, 0, 1.2, 0, 0.8, 0]), keep=there)
    assert goal is not None
    plan = scene.plan(home, goal.witness, keep=there)
    assert plan.points is not None and plan.length > 0.5
    for points, held in ((escape.points, keep), (repaired.points, keep), (plan.points, there)):
        assert len(points) > 2
        shares = np.linspace(0, 1, 20)[:, None]
        places = np.concatenate([a + shares * (b - a) for a, b in zip(points, points[1:])])
        off = scene.poses(places, of=["gripper"])[:, 0, :3, 3] - held["pose"][:3, 3]
        assert np.linalg.norm(off, axis=1).max() <= 1.001e-4
    with pytest.raises(ValueError, match="max_step: got 0.1, expected none with `keep`"):
        scene.repair(back, keep="gripper", frames=True, max_step=0.1)
    with pytest.raises(ValueError, match="goal: kept link `gripper`: got off by"):
        scene.plan(escape.points[-1], np.zeros(7), keep=keep)
    answer = Solver(scene, keep=keep).stream(continuous=True).query(q)
    assert answer is not None and answer.kept[0][0] <= 1e-4
