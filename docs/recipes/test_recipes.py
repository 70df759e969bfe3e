"""Runs the recipes, and asks of each what it promises."""

import pathlib

import mujoco_penetration
import ompl_start
import pinocchio_projection
import plot_plane
import pytest


def test_ompl_plans_from_the_repaired_start() -> None:
    scene, start, goal, path, answer = ompl_start.main()
    assert not scene.check(start) and answer.depth > 0 and answer.verified
    assert path[0] == pytest.approx(answer.witness) and path[-1] == pytest.approx(goal)
    assert scene.check(path).all()


def test_coal_agrees_that_the_projection_is_free() -> None:
    before, after, answer = pinocchio_projection.main()
    assert before and not after and answer.verified


def test_nothing_penetrates_in_mujoco_any_more() -> None:
    before, after, qpos, answer = mujoco_penetration.main()
    assert before > 1e-3 and after == 0
    assert qpos == pytest.approx(answer.witness)


def test_the_plane_is_drawn(tmp_path: pathlib.Path) -> None:
    model, q, answer = plot_plane.main(str(tmp_path / "plane.png"))
    scene, support = model.scene, model.support_vectors
    assert 0 < scene.check(support).mean() < 1 and len(support) <= model.statistics["support_vectors"]
    assert not scene.check(q) and scene.check(answer.witness)
    assert (tmp_path / "plane.png").stat().st_size > 10_000
