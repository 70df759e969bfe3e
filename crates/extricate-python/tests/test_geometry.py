"""Poses of bodies, their triangles, and their distances."""

import numpy as np
import pytest

import extricate
from extricate import Box, Capsule, HalfSpace, Points, Scene, Sphere

SLIDER = """<robot name="slider"><link name="rail"/><link name="cart"><collision><origin xyz="0 0 0.5"/><geometry><box size="2 2 2"/></geometry></collision></link>
<link name="hook"/><joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><origin xyz="0 0 1"/><axis xyz="1 0 0"/>
<limit lower="-10" upper="10" effort="1" velocity="1"/></joint>
<joint name="weld" type="fixed"><parent link="cart"/><child link="hook"/><origin xyz="0 3 0"/></joint></robot>"""


def test_bodies_are_where_forward_kinematics_says() -> None:
    scene = Scene(SLIDER, [Box([1, 2, 3], [5, 0, 0, 0, 0, np.pi / 2], "wall")]).attach(Sphere(0.1, name="ball"), link="hook", pose=[0, 0, 2])
    poses = scene.poses([[1.0], [-2.0]])
    assert poses.shape == (2, 3, 4, 4) and scene.bodies == ["cart", "wall", "ball"]
    np.testing.assert_allclose(poses[:, 0, :3, 3], [[1, 0, 1], [-2, 0, 1]])
    np.testing.assert_allclose(poses[:, 2, :3, 3], [[1, 3, 3], [-2, 3, 3]])
    np.testing.assert_allclose(poses[0, 1], [[0, -1, 0, 5], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], atol=1e-12)
    # Configurations beyond the limits, a single one, and a link without geometry.
    np.testing.assert_allclose(scene.poses([11.0], of=["hook", "rail"])[:, :3, 3], [[11, 3, 1], [0, 0, 0]])
    with pytest.raises(ValueError, match="of: got `hok`, expected some of `rail`, `cart`, `hook`"):
        scene.poses([0.0], of=["hok"])
    with pytest.raises(ValueError, match=r"Q\[0\]: .*got NaN"):
        scene.poses([[np.nan]])


def test_meshes_are_the_bodies() -> None:
    scene = Scene(SLIDER, [Capsule(0.5, 2, [5, 0, 0], "post"), HalfSpace([0, 0, 1], -4, name="floor"), Points([[1, 2, 3]], 0.1, name="seen")])
    vertices, triangles = scene.mesh("cart")
    assert vertices.shape == (8, 3) and triangles.shape == (12, 3) and triangles.dtype == np.int64
    np.testing.assert_allclose([vertices.min(0), vertices.max(0)], [[-1, -1, -0.5], [1, 1, 1.5]])
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(8)
    fine, coarse = scene.mesh("post", 64)[0], scene.mesh("post", segments=8)[0]
    assert len(fine) > len(coarse) and np.abs(fine[:, 2]).max() == pytest.approx(1.5)
    assert len(scene.mesh("floor")[1]) == 2 and len(scene.mesh("seen")[1]) > 50
    with pytest.raises(ValueError, match="body: got `rail`, expected one of `cart`, `post`"):
        scene.mesh("rail")
    with pytest.raises(ValueError, match="segments: got 2, expected at least 3"):
        scene.mesh("cart", 2)


@pytest.mark.parametrize("name", ["shelf-arm", "hand", "free-box"])
def test_what_is_drawn_is_what_is_checked(name: str) -> None:
    scene = Scene.builtin(name)
    q = scene.sample(1, seed=3, colliding=False)[0]
    placed = {}
    for body, pose in zip(scene.bodies, scene.poses(q)):
        vertices, triangles = scene.mesh(body, 16)
        placed[body] = vertices @ pose[:3, :3].T + pose[:3, 3]
        assert len(triangles) and triangles.max() < len(vertices)
    # Vertices lie on the bodies, so that no two are nearer than their bodies are.
    for (first, second), distance in list(zip(scene.pairs, scene.pair_distances(q)))[::5]:
        between = np.linalg.norm(placed[first][:, None] - placed[second][None], axis=-1).min()
        assert between >= distance - 1e-9, (first, second)


def test_distances_by_pair_are_those_of_closed_forms() -> None:
    scene = Scene(SLIDER, [Sphere(1, [5, 0, 1.5], "a"), Sphere(1, [-5, 0, 1.5], "b")], clearance={"world": 0.1}, padding={"a": 0.5})
    Q = np.linspace(-4.5, 4.5, 19)[:, None]
    distances = scene.pair_distances(Q)
    assert distances.shape == (19, 2) and scene.pairs == [("cart", "a"), ("cart", "b")]
    np.testing.assert_allclose(distances, np.hstack([3 - Q, 3 + Q]), atol=1e-9)
    np.testing.assert_allclose(distances.min(1), scene.distances(Q), atol=1e-9)
    assert scene.pair_distances([0.0]).tolist() == pytest.approx([3, 3])
    assert Scene(SLIDER).pair_distances([[0.0]]).shape == (1, 0)


def test_contacts_are_told_of_free_configurations_too() -> None:
    scene = Scene(SLIDER, [Sphere(1, [5, 0, 1.5], "a"), Sphere(1, [-5, 0, 1.5], "b")], padding={"a": 0.5})
    found = scene.contacts([[2.5], [0.0], [3.5]], within=1.0)
    assert found["row"].tolist() == [0, 2] and found["pair"].tolist() == [0, 0]
    # Distances do not depend on the clearance that the pair keeps.
    np.testing.assert_allclose(found["distance"], [0.5, -0.5], atol=1e-9)
    np.testing.assert_allclose(found["points"][0], [[3.5, 0, 1.5], [4, 0, 1.5]], atol=1e-9)
    np.testing.assert_allclose(found["normal"], [[-1, 0, 0], [-1, 0, 0]], atol=1e-9)
    assert len(scene.contacts([0.0], within=3.1)) == 2 and len(scene.contacts(np.zeros((0, 1)), within=9)) == 0
    many = extricate.Scene.builtin("shelf-arm")
    Q = many.sample(200, seed=1)
    told = many.contacts(Q, within=0.05, threads=2)
    distances = many.pair_distances(Q)
    assert {(row, pair) for row, pair in zip(told["row"], told["pair"])} == {tuple(at) for at in np.argwhere(distances < 0.05)}
    with pytest.raises(TypeError, match="within"):
        scene.contacts([0.0])  # type: ignore[call-arg]
    with pytest.raises(ValueError, match="within: got NaN, expected a finite distance"):
        scene.contacts([0.0], within=np.nan)


def test_jacobians_are_derivatives_of_distances(planar: Scene) -> None:
    Q = planar.sample(20, seed=3, colliding=False)
    rows = planar.distance_jacobians(Q, within=0.2)
    assert len(rows) == len(np.unique(planar.contacts(Q, within=0.2)[["row", "pair"]])) > 10
    step, agree = 1e-6, 0
    for row in rows:
        sides = Q[row["row"]] + step * np.concatenate([np.eye(planar.nq), -np.eye(planar.nq)])
        distances = planar.pair_distances(np.clip(sides, planar.lower, planar.upper))[:, row["pair"]]
        slopes = (distances[: planar.nq] - distances[planar.nq :]) / (2 * step)
        agree += bool(np.abs(slopes - row["jacobian"]).max() < 1e-5)
    assert agree >= 0.9 * len(rows)
    box = Scene.builtin("free-box")
    assert box.distance_jacobians([0.3, 0, 0, 0, 0, 0, 1], within=0.5)["jacobian"].shape[1] == box.nv == 6
