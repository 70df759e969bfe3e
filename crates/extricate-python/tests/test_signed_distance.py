"""Signed distances and free radii."""

import numpy as np
import pytest

from extricate import Scene


def test_both_sides_have_witness_and_bound(planar: Scene) -> None:
    Q = planar.sample(40, seed=5)
    rows = planar.signed_distance(Q)
    free = planar.check(Q)
    assert 5 < free.sum() < 35
    assert (rows["distance"][free] > 0).all() and (rows["distance"][~free] < 0).all()
    assert (np.abs(rows["bound"]) <= np.abs(rows["distance"]) + 1e-12).all()
    assert planar.check(rows["witness"]).all()
    inside = planar.query_batch(Q[~free])
    np.testing.assert_array_equal(rows["distance"][~free], -inside["depth"])
    np.testing.assert_array_equal(rows["gradient"][~free], -inside["gradient"])
    one = planar.signed_distance(Q[0])
    assert one["distance"] == rows["distance"][0] and one["pair"] == rows["pair"][0]
    # No two rows differ by more than they are apart.
    apart = np.linalg.norm(Q[1:] - Q[:-1], axis=1)
    assert (np.abs(np.diff(rows["distance"])) <= apart + 1e-6).all()


def test_a_distance_ends_at_within(planar: Scene) -> None:
    q = planar.sample(1, seed=2, colliding=False)[0]
    far = planar.signed_distance(q)
    near = planar.signed_distance(q, within=0.5 * float(far["bound"]))
    assert np.isinf(near["distance"]) and near["bound"] >= 0.5 * far["bound"] and near["pair"] == -1
    with pytest.raises(ValueError, match="within"):
        planar.signed_distance(q, within=0)
    with pytest.raises(ValueError, match=r"Q\[1\]"):
        planar.signed_distance([q, np.full(planar.nq, np.nan)])


def test_free_radii_are_about_the_bounds(planar: Scene) -> None:
    Q = planar.sample(20, seed=4)
    rows = planar.signed_distance(Q)
    radii = planar.free_radius(Q)
    free = planar.check(Q)
    assert (radii[~free] == 0).all() and (radii[free] > 0).all()
    assert (radii[free] <= rows["distance"][free]).all() and (radii[free] > 0.8 * rows["bound"][free]).all()
    assert planar.free_radius(Q[0]) == radii[0]
    with pytest.raises(ValueError, match=r"Q\[1\]"):
        planar.free_radius([Q[0], np.full(planar.nq, np.nan)])
