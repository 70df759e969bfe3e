"""Code of a user for `mypy --strict`, which checks that every name has the expected type. It also runs as a test."""

import pathlib
from typing import List, Literal, Optional, Tuple

import numpy as np
import numpy.typing as npt

import extricate


def first_exits(scene: extricate.Scene, labels: int, folder: pathlib.Path) -> npt.NDArray[np.float64]:
    def tell(state: extricate.Progress) -> bool:
        percent: float = 100 * state.fraction
        return percent <= 100 and state.stage != ""

    model: extricate.Model = extricate.learn(scene, labels=labels, seed=1, progress=tell)
    model.save(folder / "typed.model")
    again = extricate.Model.load(str(folder / "typed.model"))
    q: npt.NDArray[np.float64] = again.scene.sample(1, colliding=True)[0]
    answer = again.query(q, effort="nearest")
    depth: float = answer.depth
    pairs: List[Tuple[str, str]] = answer.colliding
    assert depth > 0 and pairs
    batch = again.query_batch([list(q), list(q)], threads=2)
    depths: npt.NDArray[np.float64] = batch["depth"]
    free: npt.NDArray[np.bool_] = scene.check(batch["witness"])
    several = again.query_batch([q], exits=3, segment=True, contacts=True)
    found: npt.NDArray[np.int64] = several["exit_count"]
    assert free.all() and (depths > 0).all() and 1 <= found[0] <= 3
    return answer.witness


def elsewhere(model: extricate.Model, scene: extricate.Scene) -> float:
    answer = model.in_scene(scene).query(scene.lower, exits=2, starts=8, max_seconds=0.5)
    nearest: float = np.inf if answer is None else answer.depth
    efforts: List[Literal["nearest", "refined"]] = ["nearest", "refined"]
    for effort in efforts:
        nearest = min(nearest, float(model.in_scene(scene).batch([scene.lower], effort=effort)["depth"][0]))
    solver: extricate.Solver = extricate.Solver(scene, model, effort="quick", exits=2)
    there: extricate.Solver = solver.with_scene(scene.without(scene.bodies[-1:]))
    kept: Optional[extricate.Model] = there.model
    free_there: npt.NDArray[np.bool_] = there.check([scene.lower])
    frame: Optional[extricate.Answer] = solver.stream().query(scene.lower, scene=there)
    assert kept is not None and free_there.shape == (1,) and (frame is None or frame.depth >= 0)
    again = extricate.learn(scene, labels=2000, progress=False)
    ways = scene.check_segments(model.boundary[:2], again.boundary[:2])
    free: npt.NDArray[np.bool_] = ways["free"]
    return nearest + float(free.sum())


def obstacles() -> List[extricate.Box]:
    turned = {"xyz": [0, 0, 1], "quat_xyzw": [0, 0, 0, 1]}
    return [extricate.Box([1, 1, 1], pose=np.eye(4)), extricate.Box((1, 2, 3), name="b"), extricate.Box([1, 1, 1], pose=turned)]


def drawn(scene: extricate.Scene) -> int:
    q = scene.config(scene.positions(scene.lower))
    poses: npt.NDArray[np.float64] = scene.poses(q)
    corners = 0
    for body, pose in zip(scene.bodies, poses):
        vertices, triangles = scene.mesh(body)
        corners += len(vertices @ pose[:3, :3].T + pose[:3, 3]) if len(triangles) else 0
    near: npt.NDArray[np.float64] = scene.contacts([q], within=0.1)["distance"]
    assert scene.pair_distances([q]).shape == (1, len(scene.pairs)) and (near < 0.1).all()
    return corners


def mirrored(scene: extricate.Scene, Q: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    arrays: extricate.grasps.Arrays = extricate.grasps.to_arrays(scene, Q, rotation_as="quat_wxyz")
    places = arrays.translation * [1, -1, 1]
    return extricate.grasps.from_arrays(
        scene, places, arrays.rotation, dict(zip(arrays.names, arrays.joints.T)), rotation_as="quat_wxyz"
    )


def labelled(scene: extricate.Scene, Q: npt.NDArray[np.float64], folder: pathlib.Path) -> int:
    label: extricate.rows.Check = extricate.rows.Check(scene)
    found = label({"q": Q})
    np.savez(folder / "rows.npz", q=Q)
    done: extricate.rows.Done = extricate.rows.run(label, folder / "rows.npz", folder / "labels.npz", workers=1)
    free: npt.NDArray[np.bool_] = extricate.rows.read(folder / "labels.npz")["free"]
    assert (free == found["free"]).all()
    return done.rows


def refused(scene: extricate.Scene) -> None:
    """Options that a type checker refuses: if it took one, the comment beside it would be reported as not needed."""
    scene.query(scene.lower, effort="refind")  # type: ignore[arg-type]
    scene.query(scene.lower, limits="forget")  # type: ignore[arg-type]
    scene.query_batch([scene.lower], errors="ignore")  # type: ignore[arg-type]
    scene.show(effort="refind")  # type: ignore[arg-type]
    scene.show(efort="refined")  # type: ignore[call-arg]
    extricate.QueryOptions(effort="refind")  # type: ignore[arg-type]
    extricate.Robot("robot.urdf", base="floats")  # type: ignore[arg-type]
    extricate.Scene("robot.urdf", metric="joints")  # type: ignore[arg-type]


def test_what_is_typed_runs(tmp_path: pathlib.Path) -> None:
    scene = extricate.Scene.builtin("planar-arm")
    assert first_exits(scene, 5000, tmp_path).shape == (scene.nq,)
    model = extricate.learn(scene, labels=5000)
    assert elsewhere(model, scene) >= 0
    assert labelled(scene, np.array([scene.lower, scene.upper]), tmp_path) == 2
    assert len(obstacles()) == 3 and drawn(scene) > 0
    urdf = '<robot name="box"><link name="a"><collision><geometry><box size="1 1 1"/></geometry></collision></link></robot>'
    afloat = extricate.Scene(extricate.Robot(urdf, base="floating", bounds=([-1] * 3, [1] * 3)), [extricate.Sphere(1)])
    assert mirrored(afloat, np.array([[0, 0.5, 0, 0, 0, 0, 1.0]])).tolist() == [[0, -0.5, 0, 0, 0, 0, 1]]
