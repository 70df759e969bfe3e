"""Hands released from their objects, and streams that do not jump."""

import numpy as np
import pytest

import extricate
from extricate import Scene, Sphere

BALL = Sphere(0.03, [0, 0, 0.08], name="ball")
SQUEEZED = [0, 0.45, 0, 0.45, 0.45]


@pytest.fixture(scope="module")
def hand() -> Scene:
    return Scene.builtin("hand")


def test_a_squeezed_hand_is_released_and_holds(hand: Scene) -> None:
    scene = hand.with_obstacles([BALL])
    grasp = scene.release(SQUEEZED, object="ball")
    assert grasp.verified and scene.check(grasp.config) and not scene.check(SQUEEZED)
    assert grasp.fingers == (3, 3) and set(grasp.kept) < set(grasp.touched) and grasp.kept_sides
    assert grasp.depth_before > 1e-3 and grasp.force_closure and 0 < grasp.epsilon < 1
    assert grasp.moved == pytest.approx(np.linalg.norm(grasp.config - SQUEEZED))
    for contact in grasp.contacts:
        assert contact.link in scene.bodies and 0 < contact.distance < 3e-3
        # The point lies on the ball, and the normal points into it.
        arm = contact.point - [0, 0, 0.08]
        assert np.linalg.norm(arm) == pytest.approx(0.03, abs=1e-6)
        assert contact.normal @ arm == pytest.approx(-0.03, abs=1e-4)
    # A free hand stays where it is.
    again = scene.release(grasp.config, object="ball")
    assert again.moved == 0 and again.config.tolist() == grasp.config.tolist()


def test_batches_are_single_releases(hand: Scene) -> None:
    radii = [0.02, 0.03, 0.025]
    balls = [Sphere(radius, [0, 0, 0.08]) for radius in radii]
    Q = [[0, curl, 0, curl, curl] for curl in (0.5, 0.45, 0.55, 0.6)]
    objects = [balls[k % 3] for k in range(4)]
    for threads in (1, 2):
        grasps = hand.release(Q, object=objects, threads=threads)
        for q, ball, grasp in zip(Q, objects, grasps):
            alone = hand.release(q, object=ball)
            assert grasp.config.tolist() == alone.config.tolist() and grasp.kept == alone.kept


def test_the_base_of_a_floating_hand_hardly_moves() -> None:
    files = Scene.builtin_files("hand")
    urdf = next(text for name, text in files.items() if name.endswith(".urdf")).decode()
    # Plain shapes replace the meshes, so that no file has to be read.
    for mesh in ("proximal", "tip"):
        urdf = urdf.replace(f'<mesh filename="meshes/{mesh}.stl"/>', '<sphere radius="0.009"/>')
    if "<mesh" in urdf:
        urdf = __import__("re").sub(r"<mesh [^>]*/>", '<sphere radius="0.009"/>', urdf)
    scene = Scene(extricate.Robot(urdf, base="floating", bounds=([-1] * 3, [1] * 3)), [Sphere(0.04, [0, 0, 0.09], name="ball")])
    base = [0, 0, 0, 0, 0, 0, 1]
    q = [*base, 0, 0.7, 0, 0.7, 0.7]
    assert not scene.check(q)
    dear, equal = (scene.release(q, object="ball", weights=weights) for weights in (None, "scene"))
    assert dear.verified and equal.verified
    assert np.linalg.norm(dear.config[:3]) <= np.linalg.norm(equal.config[:3]) + 1e-9
    locked = scene.release(q, object="ball", locked=["base"])
    assert locked.config[:7].tolist() == base


@pytest.mark.parametrize(
    "keywords, message",
    [
        ({"object": "cup"}, "ball"),
        ({"object": "ball", "keep": "grip"}, "expected \"contacts\" or \"pose\""),
        ({"object": "ball", "touch": -1}, "touch: got -1"),
        ({"object": "ball", "friction": float("nan")}, "friction: got NaN"),
        ({"object": "ball", "locked": ["elbow"]}, "elbow"),
        ({"object": "ball", "open": [0]}, "open: "),
        ({"object": [BALL, BALL]}, "got 2 obstacles for 1 rows"),
        ({"object": "ball", "max_seconds": 0}, "max_seconds: got 0"),
    ],
)
def test_wrong_input_is_told_what_was_expected(hand: Scene, keywords, message: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=message):
        hand.with_obstacles([BALL]).release(SQUEEZED, **keywords)


def test_an_object_that_cannot_be_read_is_named(hand: Scene) -> None:
    with pytest.raises((ValueError, OSError), match="nowhere.stl"):
        hand.release(SQUEEZED, object=extricate.Mesh("nowhere.stl"))


def test_a_continuous_stream_moves_where_it_is_free() -> None:
    scene = Scene.builtin("planar-arm")
    Q = scene.sample(2, seed=3, colliding=False)
    stream = scene.stream(continuous=True)
    before, behind = None, 0
    for t in np.linspace(0, 1, 80):
        answer = stream.query(Q[0] + t * (Q[1] - Q[0]))
        assert answer.nearest is not None and answer.depth >= answer.nearest - 1e-9
        behind += answer.depth > answer.nearest + 1e-3
        if before is not None:
            assert scene.check_segments([before], [answer.witness], resolution=2e-5)["contact"].tolist() == [False]
        before = answer.witness
    assert scene.stream().query(Q[0]).nearest is None
