"""Escapes, plans, repairs and roadmaps."""

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import extricate
from extricate import Model, Roadmap, Scene


def samples(path: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Samples a hundred configurations per edge of the planar arm, whose first joint has no limits."""
    share = np.linspace(0, 1, 100)[:, None]
    turns = np.array([2 * np.pi, np.inf, np.inf])
    steps = [b - a - np.where(np.isfinite(turns), turns, 0) * np.round((b - a) / turns) for a, b in zip(path[:-1], path[1:])]
    return np.concatenate([a + step * share for a, step in zip(path[:-1], steps)])


def crosses(scene: Scene, q: npt.NDArray[np.float64]) -> bool:
    """Whether the links of the planar arm cannot part without getting deeper. Searches a grid of (q2, q3)
    from q through all configurations that are not deeper than q."""
    side = 201
    grid = np.stack(np.meshgrid(*[np.linspace(scene.lower[k], scene.upper[k], side) for k in (1, 2)], indexing="ij"), -1)
    rows = np.concatenate([np.full((side * side, 1), q[0]), grid.reshape(-1, 2)], axis=1)
    pair = scene.pairs.index(("link_1", "link_3"))
    distance = scene.pair_distances(rows)[:, pair].reshape(side, side)
    keeps = distance >= scene.pair_distances(q)[pair] - 2e-3
    at = tuple(int(np.abs(grid[:, 0, 0] - q[1]).argmin()) if k == 0 else int(np.abs(grid[0, :, 1] - q[2]).argmin()) for k in (0, 1))
    seen, stack = {at}, [at]
    while stack:
        i, j = stack.pop()
        if distance[i, j] > scene.clearance:
            return False
        for n in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            if min(n) >= 0 and max(n) < side and keeps[n] and n not in seen:
                seen.add(n)
                stack.append(n)
    return True


def test_nothing_gets_worse_on_an_escape(planar: Scene, model: Model) -> None:
    for q in planar.sample(20, seed=1, colliding=True):
        for asked in (planar, model):
            escape = asked.escape(q)
            if escape.points is None:
                assert escape.method is None and crosses(planar, q), q
                continue
            np.testing.assert_array_equal(escape.points[0], q)
            before = planar.pair_distances(q)
            keeps = np.where(before < planar.clearance, before - 1e-3, planar.clearance)
            assert (planar.pair_distances(samples(escape.points)) >= keeps - 1e-9).all()
            assert planar.check(samples(escape.points[escape.free_from - 1 :])[-1])
            assert {pair for pair, _ in escape.colliding} == set(planar.colliding_pairs(q))
            assert 0 <= escape.deepening <= 1e-3 + 1e-9


def test_bad_escapes_are_told(planar: Scene) -> None:
    q = planar.sample(1, seed=1, colliding=True)[0]
    with pytest.raises(ValueError, match="tolerance: got -1"):
        planar.escape(q, tolerance=-1)
    with pytest.raises(ValueError, match="shape"):
        planar.escape([0.0])
    with pytest.raises(ValueError, match="max_seconds"):
        planar.escape(q, max_seconds=0)
    with pytest.raises(ValueError, match="q: "):
        planar.escape(np.full(planar.nq, 1e3))


def test_plans_are_free_and_share_a_roadmap(planar: Scene, tmp_path: Path) -> None:
    free = planar.sample(8, seed=2, colliding=False)
    roadmap = Roadmap(planar, seed=1)
    for start, goal in zip(free[::2], free[1::2]):
        plan = planar.plan(start, goal, roadmap=roadmap)
        assert plan.points is not None
        np.testing.assert_array_equal(plan.points[[0, -1]], [start, goal])
        assert planar.check(samples(plan.points)).all()
        assert planar.check_segments(plan.points[:-1], plan.points[1:])["free"].all()
        again = planar.plan(start, goal, seed=3, threads=2)
        once = planar.plan(start, goal, seed=3, threads=1)
        assert once.points is not None and again.points is not None
        np.testing.assert_array_equal(once.points, again.points)
    roadmap.save(tmp_path / "planar.roadmap")
    read = Roadmap.load(tmp_path / "planar.roadmap", planar)
    assert (len(read), read.edges, read.checks) == (len(roadmap), roadmap.edges, roadmap.checks)
    with pytest.raises(ValueError):
        Roadmap.load(tmp_path / "planar.roadmap", Scene.builtin("hand"))
    with pytest.raises(ValueError, match="goal: "):
        planar.plan(free[0], np.full(planar.nq, 1e3))


def test_a_plan_leads_colliding_ends_out(planar: Scene) -> None:
    colliding = planar.sample(12, seed=1, colliding=True)
    found = 0
    for start, goal in zip(colliding[::2], colliding[1::2]):
        plan = planar.plan(start, goal, max_checks=20_000)
        assert plan.start_escape is not None
        if plan.points is None:
            continue
        found += 1
        np.testing.assert_array_equal(plan.points[[0, -1]], [start, goal])
        free = plan.points[plan.free_from : plan.free_to + 1]
        assert len(free) == 1 or planar.check_segments(free[:-1], free[1:])["free"].all()
        for q, part in ((start, plan.points[: plan.free_from + 1]), (goal, plan.points[plan.free_to :])):
            before = planar.pair_distances(q)
            keeps = np.where(before < planar.clearance, before - 1e-3, planar.clearance)
            assert len(part) == 1 or (planar.pair_distances(samples(part)) >= keeps - 1e-9).all()
    assert found > 2


def test_frames_stay_frames(planar: Scene) -> None:
    free, colliding = planar.sample(2, seed=4, colliding=False), planar.sample(1, seed=4, colliding=True)
    turns = [free[0], colliding[0], free[1]]
    old = np.concatenate([a + (b - a) * np.linspace(0, 1, 100)[:, None] for a, b in zip(turns[:-1], turns[1:])])
    new = planar.repair(old, frames=True, max_step=0.2, max_checks=None)
    assert new.points is not None and new.points.shape == old.shape and new.stretches > 0
    np.testing.assert_array_equal(new.places, np.arange(len(old)))
    assert planar.check(new.points).all()
    assert planar.check_segments(new.points[:-1], new.points[1:], resolution=2e-5)["contact"].sum() == 0
    with pytest.raises(ValueError, match="max_step"):
        planar.repair(old, max_step=0.1)
    held = planar.repair(old, frames=True, touch=0.01, max_checks=None)
    assert held.points is not None and new.touched == 0 < held.kept <= held.touched
    with pytest.raises(ValueError, match="touch"):
        planar.repair(old, touch=0.01)


def test_repairs_keep_what_is_free(planar: Scene) -> None:
    free = planar.sample(40, seed=4, colliding=False)
    found = 0
    for k in range(0, 36, 3):
        old = free[k : k + 3]
        new = planar.repair(old)
        if new.points is None:
            continue
        found += 1
        assert planar.check(samples(new.points)).all()
        assert (np.diff(new.places) >= 0).all() and new.length >= new.length_before - 1e-9
        for place, q in zip(new.places, new.points):
            if place in (0.0, 2.0):
                np.testing.assert_array_equal(q, old[int(place)])
    assert found >= 10
    with pytest.raises(ValueError, match="path"):
        planar.repair(np.zeros((0, planar.nq)))
