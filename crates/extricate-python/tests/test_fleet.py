"""Fleets: many scenes at once, on processes of this machine and, if Ray is installed, on two nodes of a cluster."""

import concurrent.futures
import contextlib
import importlib.util
import os
import pathlib
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from typing import Any, Callable, Dict, Iterator, List

import numpy as np
import pytest

import extricate
from extricate import Scene, _pool, fleet

LABELS = 2000
GRIPPER = """<robot name="gripper"><link name="palm"><collision><geometry><box size="0.08 0.16 0.03"/></geometry></collision></link>
<link name="finger"><collision><origin xyz="0 0 0.04"/><geometry><box size="0.02 0.015 0.08"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="palm"/><child link="finger"/><axis xyz="0 1 0"/>
<limit lower="0.01" upper="0.06" effort="1" velocity="1"/></joint></robot>"""


def objects(count: int) -> Dict[str, Scene]:
    """Makes grippers that float among boxes of different sizes."""
    robot = extricate.Robot(GRIPPER, base="planar", bounds=((-0.3, -0.3), (0.3, 0.3)))
    return {f"box{k}": Scene(robot, [extricate.Box([0.03 + 0.01 * k, 0.05, 0.1], name="box")]) for k in range(count)}


def by_key(results: Iterator[Any]) -> Dict[str, Any]:
    return {result.key: result for result in results}


def test_scenes_are_learned_once_and_a_bad_one_ends_nothing(tmp_path: pathlib.Path) -> None:
    scenes: Dict[str, Any] = dict(objects(2))
    scenes["again"] = scenes["box0"]
    scenes["lazy"] = lambda: Scene.builtin("planar-arm")
    scenes["missing"] = tmp_path / "none.toml"
    scenes["stuck"] = lambda: 1 / 0
    told: List[fleet.Progress] = []
    done = by_key(fleet.learn(scenes, tmp_path / "models", labels=LABELS, seed=1, workers=2, progress=told.append))
    assert set(done) == set(scenes) and told[-1].failed == 2 and told[-1].total == 6
    assert "none.toml" in done["missing"].error and done["missing"].path is None
    assert done["stuck"].error == "ZeroDivisionError: division by zero"
    for key in ("box0", "box1", "lazy"):
        assert done[key].error is None and done[key].statistics["labels"] > 0 and not done[key].cached and done[key].seconds > 0
    assert done["again"].path == done["box0"].path and done["again"].cached
    local = extricate.learn(scenes["box1"], labels=LABELS, seed=1)
    assert done["box1"].path.read_bytes() == local.to_bytes()

    second = by_key(fleet.learn(scenes, tmp_path / "models", labels=LABELS, seed=1))
    assert all(result.cached for key, result in second.items() if key not in ("missing", "stuck"))
    other = by_key(fleet.learn({"box0": scenes["box0"]}, tmp_path / "models", labels=LABELS, seed=2))
    assert not other["box0"].cached, "another seed is another model"

    models = fleet.open(tmp_path / "models", memory=1)
    assert sorted(models) == ["again", "box0", "box1", "lazy"] and len(models) == 4 and "stuck" not in models
    assert models["box1"] is models["box1"] and models.statistics("box1") == done["box1"].statistics
    assert set(models.errors()) == {"missing", "stuck"}
    with pytest.raises(KeyError, match="stuck: no model in .*ZeroDivisionError"):
        models["stuck"]

    rows = {key: models[key].scene.sample(5, seed=3, colliding=True) for key in models}
    spoiled = rows["box0"].copy()
    spoiled[2, 0] = np.nan
    queries: Dict[str, Any] = {**rows, "box0": spoiled, "box1": rows["box1"][:, :2], "none": rows["box0"]}
    answers = by_key(fleet.query(tmp_path / "models", queries, workers=2, exits=2))
    assert "shape" in answers["box1"].error and "never learned" in answers["none"].error
    expected = models["lazy"].query_batch(rows["lazy"], exits=2)
    assert all((answers["lazy"].answers[name] == expected[name]).all() for name in ("depth", "witness", "exit_count", "checks"))
    assert np.flatnonzero(answers["box0"].answers["error"] != "").tolist() == [2]

    # Scenes answer without a folder, and hands are released.
    given = {key: scenes[key] for key in ("box0", "lazy", "stuck")}
    found = by_key(fleet.query(given, {**{key: rows[key] for key in ("box0", "lazy")}, "stuck": [[0.0]], "no": [[0.0]]}, workers=2))
    expected = models["lazy"].scene.query_batch(rows["lazy"])
    assert (found["lazy"].answers["witness"] == expected["witness"]).all()
    assert found["stuck"].error == "ZeroDivisionError: division by zero" and found["no"].error == "KeyError: 'no'"
    measured = by_key(fleet.distance(given, {"lazy": rows["lazy"]}, workers=2))["lazy"].answers
    assert (measured["distance"] == models["lazy"].scene.signed_distance(rows["lazy"])["distance"]).all()
    for source in (given, tmp_path / "models"):
        released = by_key(fleet.release(source, {"box0": rows["box0"], "lazy": rows["lazy"]}, object="box", workers=2))
        hands = scenes["box0"].release(rows["box0"], object="box")
        assert (released["box0"].answers["config"] == [hand.config for hand in hands]).all()
        assert "'box'" in released["lazy"].error or "box" in released["lazy"].error


def test_arguments_are_checked_before_work(tmp_path: pathlib.Path) -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'label'"):
        fleet.learn({}, tmp_path, label=3)
    with pytest.raises(ValueError, match="on: got 'slurm', expected None, \"ray\" or an executor"):
        list(fleet.learn({}, tmp_path, on="slurm"))
    with pytest.raises(ValueError, match="threads: got 0"):
        list(fleet.learn({}, tmp_path, threads=0))
    (tmp_path / "manifest.sqlite").write_text("no database, but long enough to be one" * 100)
    with pytest.raises(ValueError, match="manifest.sqlite: got no manifest"):
        fleet.open(tmp_path)
    with pytest.raises(OSError):
        fleet.open(tmp_path / "none")


def children(of: int = 0) -> List[int]:
    """Returns the ids of the workers of this process, or of another one."""
    found = subprocess.run(["ps", "-ww", "-o", "pid=,args=", "--ppid", str(of or os.getpid())], capture_output=True, text=True).stdout
    return [int(line.split()[0]) for line in found.splitlines() if "extricate._worker" in line]


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes as Linux has them")
def test_a_worker_that_dies_is_begun_again(tmp_path: pathlib.Path) -> None:
    killed: List[int] = []

    def kill() -> None:
        while not killed:
            for pid in children():
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)
            time.sleep(0.01)

    threading.Thread(target=kill, daemon=True).start()
    done = by_key(fleet.learn(objects(2), tmp_path, labels=LABELS, workers=1))
    assert killed and all(result.error is None for result in done.values())


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes as Linux has them")
def test_a_run_that_is_left_ends_its_workers(tmp_path: pathlib.Path) -> None:
    scene = Scene.builtin("planar-arm")
    run = fleet.learn({"quick": objects(1)["box0"], "long": scene}, tmp_path, labels=60_000, seed=4, workers=2)
    next(run)
    run.close()
    assert not children()
    done = by_key(fleet.learn({"long": scene}, tmp_path, labels=60_000, seed=4))
    assert done["long"].path.read_bytes() == extricate.learn(scene, labels=60_000, seed=4).to_bytes()


DRIVER = """
import sys
from extricate import Scene, _pool, fleet
scenes = {"long": Scene.builtin("planar-arm"), "longer": Scene.builtin("hand")}
list(fleet.learn(scenes, sys.argv[1], labels=3_000_000, seed=4, workers=2))
"""


def is_running(pid: int) -> bool:
    """Whether there is a process with this id that has not ended."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def wait_for(what: Callable[[], Any], process: "subprocess.Popen[bytes]") -> None:
    """Waits until a running process has made a condition true."""
    until = time.monotonic() + 120
    while not what():
        assert process.poll() is None and time.monotonic() < until
        time.sleep(0.01)


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes as Linux has them")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGKILL"])
def test_workers_end_with_their_run_and_the_next_one_begins(tmp_path: pathlib.Path, name: str) -> None:
    scene = Scene.builtin("planar-arm")
    driver = subprocess.Popen([sys.executable, "-c", DRIVER, str(tmp_path)])
    try:
        wait_for(lambda: len(children(driver.pid)) == 2, driver)
        with pytest.raises(OSError, match="another run of fleet.learn writes to this folder"):
            next(fleet.learn({"other": scene}, tmp_path))
        workers = children(driver.pid)
    finally:
        driver.send_signal(getattr(signal, name))
        driver.wait()
    until = time.monotonic() + 20
    while any(is_running(pid) for pid in workers):
        assert time.monotonic() < until
        time.sleep(0.01)
    # The lock of a killed run does not block the next one.
    assert [result.error for result in fleet.learn({"quick": objects(1)["box0"]}, tmp_path, labels=LABELS)] == [None]


def test_a_folder_has_one_run_at_a_time(tmp_path: pathlib.Path) -> None:
    scenes = objects(3)
    run = fleet.learn(scenes, tmp_path, labels=LABELS, workers=1)
    first = next(run)
    with pytest.raises(OSError, match="another run of fleet.learn writes to this folder, expected one at a time"):
        list(fleet.learn(scenes, tmp_path, labels=LABELS))
    assert first.key in fleet.open(tmp_path), "readers are welcome"
    run.close()
    waiting = fleet.learn({"box2": scenes["box2"]}, tmp_path, labels=LABELS)
    done = by_key(fleet.learn(scenes, tmp_path, labels=LABELS))
    assert done[first.key].cached and all(result.error is None for result in done.values())
    # Models that another run learned before this one began are not lost.
    assert [result.cached for result in waiting] == [True]
    assert sorted(fleet.open(tmp_path)) == sorted(scenes)


def test_a_model_that_was_spoilt_is_learned_again(tmp_path: pathlib.Path) -> None:
    scenes = objects(2)
    done = by_key(fleet.learn(scenes, tmp_path, labels=LABELS))
    path, good = done["box0"].path, done["box0"].path.read_bytes()
    middle = len(good) // 2
    for spoilt in (
        good[:middle] + bytes([good[middle] ^ 1]) + good[middle + 1 :],
        good[:100] + bytes([good[100] ^ 255]) + good[101:],
        good[:-1],
        b" " * len(good),
    ):
        path.write_bytes(spoilt)
        again = by_key(fleet.learn(scenes, tmp_path, labels=LABELS))
        assert not again["box0"].cached and again["box0"].error is None and again["box1"].cached
        assert path.read_bytes() == good
    path.unlink()
    assert not by_key(fleet.learn(scenes, tmp_path, labels=LABELS))["box0"].cached


HASH = "0123456789abcdef0123456789abcdef01234567"


@pytest.mark.parametrize(
    "change",
    [
        "PRAGMA user_version = 2",
        "DROP TABLE models",
        "DROP TABLE keys",
        "ALTER TABLE models RENAME COLUMN statistics TO other",
        "UPDATE keys SET content = '../../../etc/passwd'",
        "UPDATE keys SET content = 5",
        "UPDATE models SET statistics = '[]'",
        "UPDATE models SET statistics = '{'",
        "DELETE FROM models",
        b"",
        b"null",
        bytes(5000),
    ],
    ids=str,
)
def test_a_manifest_of_another_shape_is_a_value_error(tmp_path: pathlib.Path, change: Any) -> None:
    list(fleet.learn(objects(1), tmp_path, labels=LABELS))
    file = tmp_path / "manifest.sqlite"
    assert list(fleet.open(tmp_path)) == ["box0"]
    assert sorted(path.suffix for path in tmp_path.iterdir()) == ["", ".model", ".sqlite"], "a run leaves one file of its state"
    if isinstance(change, bytes):
        file.write_bytes(change)
    else:
        with contextlib.closing(sqlite3.connect(file)) as database, database:
            database.execute(change)

    def statistics() -> Any:
        models = fleet.open(tmp_path)
        return models.statistics("box0")

    with pytest.raises(ValueError, match="manifest.sqlite: got no manifest of models .*, expected what fleet.learn wrote"):
        statistics()


def test_a_folder_that_cannot_be_written_is_read(tmp_path: pathlib.Path) -> None:
    list(fleet.learn(objects(1), tmp_path, labels=LABELS))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert before["manifest.sqlite"][18:20] == b"\x01\x01", "readers need no second file"
    assert fleet.open(tmp_path)["box0"].scene.nq == 4
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_last_of_many_keys_takes_no_longer_than_the_first(tmp_path: pathlib.Path) -> None:
    from extricate.fleet._manifest import Manifest

    manifest = Manifest(tmp_path)
    statistics = {f"figure {k}": k / 7 for k in range(25)}
    with manifest.held():
        seconds = []
        for first in range(0, 6000, 500):
            started = time.process_time()
            for at in range(first, first + 500):
                content = f"{at:040x}"
                manifest.note(content, 9, statistics)
                manifest.name(f"key {at}", content)
            seconds.append(time.process_time() - started)
    assert len(fleet.open(tmp_path)) == 6000 and f"key {7}" in fleet.open(tmp_path)
    assert min(seconds[-3:]) < 500 * 1e-3 and min(seconds[-3:]) < 5 * min(seconds[:3])


def test_a_fleet_is_learned_on_any_executor(tmp_path: pathlib.Path) -> None:
    scenes = objects(3)
    with concurrent.futures.ProcessPoolExecutor(2) as processes:
        done = by_key(fleet.learn(scenes, tmp_path, labels=LABELS, seed=1, on=processes))
        rows = {key: scene.sample(5, seed=3, colliding=True) for key, scene in scenes.items()}
        found = by_key(fleet.query(tmp_path, rows, on=processes))
    for key, scene in scenes.items():
        model = extricate.learn(scene, labels=LABELS, seed=1)
        assert done[key].path.read_bytes() == model.to_bytes()
        assert (found[key].answers["witness"] == model.query_batch(rows[key])["witness"]).all()


class Growing(concurrent.futures.ThreadPoolExecutor):
    """An executor that notes how many jobs it has at most."""

    def __init__(self) -> None:
        super().__init__(1)
        self.at_once = self.most = 0

    def submit(self, *args: Any, **kwargs: Any) -> Any:
        self.at_once += 1
        self.most = max(self.most, self.at_once)
        future = super().submit(*args, **kwargs)
        future.add_done_callback(lambda ended: setattr(self, "at_once", self.at_once - 1))
        return future


def test_an_executor_has_as_many_jobs_as_was_wished() -> None:
    scene = Scene.builtin("planar-arm")
    for workers, most in ((3, 3), (0, 2)):
        with Growing() as executor:
            found = list(fleet.query({f"{k}": scene for k in range(9)}, {f"{k}": scene.sample(1) for k in range(9)}, on=executor, workers=workers))
        assert executor.most == most and all(answered.error is None for answered in found)


@pytest.mark.parametrize("key", [5, None, ("t", 1), b"a"])
def test_keys_that_are_not_text_are_refused(tmp_path: pathlib.Path, key: Any) -> None:
    scenes: Any = {"good": Scene.builtin("planar-arm"), key: Scene.builtin("planar-arm")}
    with pytest.raises(TypeError, match="scenes: got the key .*, expected text"):
        fleet.learn(scenes, tmp_path, labels=LABELS)
    assert not list(tmp_path.iterdir())
    list(fleet.learn({"good": scenes["good"]}, tmp_path, labels=LABELS))
    with pytest.raises(TypeError, match="queries: got the key .*, expected text"):
        list(fleet.query(tmp_path, {key: [[0.0]]}))


@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="ray is not installed")
def test_a_cluster_loses_a_node(tmp_path: pathlib.Path, patient_ray: None) -> None:
    import ray
    from ray.cluster_utils import Cluster

    node = {"num_cpus": 1, "object_store_memory": 150 * 2**20}
    cluster = Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False})
    lost = cluster.add_node(**node)
    ray.init(address=cluster.address, log_to_driver=False)
    try:
        good = objects(12)
        scenes: Dict[str, Any] = dict(good)
        scenes["box5"] = tmp_path / "spoiled.urdf"
        scenes["box5"].write_text("<robot")
        learn = {"on": "ray", "labels": 10 * LABELS, "seed": 1}
        done: Dict[str, Any] = {}
        for result in fleet.learn(scenes, tmp_path / "models", **learn):
            done[result.key] = result
            if len(done) == 3:
                # The node stops like a machine that loses its power.
                cluster.remove_node(lost, allow_graceful=False)
        # The cluster notices it late, when heartbeats are missed.
        until = time.monotonic() + 60
        while sum(node["Alive"] for node in ray.nodes()) > 1:
            assert time.monotonic() < until, "the node was never lost"
            time.sleep(0.5)
        assert set(done) == set(scenes) and done.pop("box5").error.startswith("ValueError")
        assert len(done) == 11 and all(result.error is None for result in done.values())

        # After the scene is repaired, it alone is learned.
        second = by_key(fleet.learn(good, tmp_path / "models", **learn))
        assert [key for key, result in second.items() if not result.cached] == ["box5"]
        assert all(result.cached for result in fleet.learn(good, tmp_path / "models", **learn))
        local = {key: extricate.learn(scene, labels=10 * LABELS, seed=1) for key, scene in good.items()}
        assert {key: result.path.read_bytes() for key, result in second.items()} == {key: model.to_bytes() for key, model in local.items()}

        rows = {"box7": local["box7"].scene.sample(5, seed=3, colliding=True)}
        (answered,) = fleet.query(tmp_path / "models", rows, on="ray")
        assert answered.error is None and answered.answers is not None
        assert (answered.answers["witness"] == local["box7"].query_batch(rows["box7"])["witness"]).all()
    finally:
        ray.shutdown()
        cluster.shutdown()


@pytest.mark.skipif(importlib.util.find_spec("ray") is None, reason="ray is not installed")
def test_a_node_that_comes_later_is_used(tmp_path: pathlib.Path, patient_ray: None) -> None:
    import ray
    from ray.cluster_utils import Cluster

    node = {"num_cpus": 1, "object_store_memory": 150 * 2**20}
    cluster = Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False})
    ray.init(address=cluster.address, log_to_driver=False)
    try:
        # Workers do not find this file.
        ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])
        pool = _pool.Pool("ray", 0, 1)
        places: List[str] = []
        for number, place, error in pool.outcomes(_pool.Job(k, place_of) for k in range(60)):
            assert error is None
            places.append(place)
            if len(places) == 3:
                cluster.add_node(**node)
        assert len(places) == 60 and len(set(places)) == 2, "both nodes have worked"
        assert pool._place.size() == 4
        pool.close()
    finally:
        ray.shutdown()
        cluster.shutdown()


def place_of() -> str:
    """Returns the node that a job runs on, after a second."""
    import ray

    time.sleep(1.0)
    return str(ray.get_runtime_context().get_node_id())
