"""Equal calls have equal answers, to the last bit: twice in one process, in two orders, on one thread and on three, with raw meshes too."""

import dataclasses
import pickle
from typing import Any, Callable, Dict, List

import numpy as np
import numpy.typing as npt

import extricate
from extricate import Mesh, Scene

Rows = npt.NDArray[np.float64]
Ask = Callable[[Any, Rows, int], Any]


def ring(sides: int = 12, inner: float = 0.018, outer: float = 0.03, half: float = 0.02) -> Mesh:
    """Makes a mesh of a ring around y, between the fingers of the hand."""
    corners, faces = [], []
    for side in range(sides):
        c, s = np.cos(2 * np.pi * side / sides), np.sin(2 * np.pi * side / sides)
        corners += [[r * c, y, r * s] for r, y in ((inner, -half), (outer, -half), (outer, half), (inner, half))]
        here, there = 4 * side, 4 * ((side + 1) % sides)
        for k in range(4):
            m = (k + 1) % 4
            faces += [[here + k, there + k, there + m], [here + k, there + m, here + m]]
    return Mesh((np.array(corners), np.array(faces)), [0, 0, 0.08], name="ring")


def plain(value: Any) -> Any:
    """Converts a value to one that is equal only if all bits are."""
    if isinstance(value, np.ndarray):
        return (value.dtype.str, value.shape, value.tobytes())
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, dict):
        return {k: plain(v) for k, v in value.items()}
    return value


def frames(of: Any, Q: Rows, continuous: bool) -> List[Any]:
    stream = of.stream(continuous=continuous)
    return [stream.query(q) for q in Q]


# Calls of both a scene and a model; the number is that of threads.
BOTH: Dict[str, Ask] = {
    "query": lambda of, Q, _: [of.query(q, contacts=True) for q in Q],
    "proved": lambda of, Q, _: of.query(Q[0], effort="proved", max_checks=200),
    "clearance": lambda of, Q, _: of.query(Q[0], clearance=2e-3),
    "batch": lambda of, Q, n: of.query_batch(Q, threads=n),
    "stream": lambda of, Q, _: frames(of, Q, False),
    "continuous": lambda of, Q, _: frames(of, Q, True),
    "escape": lambda of, Q, _: of.escape(Q[0], tree_checks=500),
    "plan": lambda of, Q, n: of.plan(*[of.query(q).witness for q in Q[:2]], max_checks=1000, threads=n),
    "repair": lambda of, Q, _: of.repair(Q[:3], max_checks=1000),
}
SCENE: Dict[str, Ask] = {
    **BOTH,
    "release": lambda of, Q, n: of.release(Q, object="ring", threads=n),
    "check": lambda of, Q, n: of.check(Q, threads=n),
    "distances": lambda of, Q, n: of.distances(Q, threads=n),
    "pair_distances": lambda of, Q, n: of.pair_distances(Q, threads=n),
    "contacts": lambda of, Q, n: of.contacts(Q, within=0.02, threads=n),
    "check_segments": lambda of, Q, n: of.check_segments(Q[:-1], Q[1:], threads=n),
    "colliding_pairs": lambda of, Q, _: [of.colliding_pairs(q) for q in Q],
    "always_colliding": lambda of, Q, _: of.always_colliding(50),
    "sample": lambda of, Q, n: of.sample(10, colliding=True, threads=n),
    "learn": lambda of, Q, n: extricate.learn(of, labels=2000, threads=n).boundary,
}


def make() -> Scene:
    return Scene.builtin("hand").with_obstacles([ring()])


def assert_repeatable(make: Callable[[], Any], asks: Dict[str, Ask], Q: Rows) -> None:
    first = make()
    expected = {name: plain(ask(first, Q, 1)) for name, ask in asks.items()}
    assert {name: plain(ask(first, Q, 1)) for name, ask in asks.items()} == expected
    other = make()
    for name, ask in reversed(list(asks.items())):
        assert plain(ask(other, Q, 3)) == expected[name], name
    for name, ask in asks.items():
        assert plain(ask(make(), Q, 1)) == expected[name], name


def test_a_scene_answers_alike() -> None:
    assert_repeatable(make, SCENE, make().sample(6, seed=2, colliding=True))


def test_a_model_answers_alike() -> None:
    model = extricate.learn(make(), labels=4000, seed=1)
    copy = pickle.dumps(model)
    assert_repeatable(lambda: pickle.loads(copy), BOTH, make().sample(6, seed=2, colliding=True))
