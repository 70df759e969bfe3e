"""Rows: mappers, files, runs that resume, executors, tensors."""

import concurrent.futures
import hashlib
import importlib.util
import json
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import time
import types
from typing import Any, Dict, List

import numpy as np
import pytest

import extricate
from extricate import Scene, rows

# Four corners of a box that the fingers of the built-in hand close around.
OBJECT = "v 0 0 0.05\nv 0.03 0 0.05\nv 0 0.03 0.05\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

GRIPPER = """<robot name="gripper"><link name="palm"><collision><geometry><box size="0.08 0.16 0.03"/></geometry></collision></link>
<link name="finger"><collision><origin xyz="0 0 0.04"/><geometry><box size="0.02 0.015 0.08"/></geometry></collision></link>
<joint name="j" type="prismatic"><parent link="palm"/><child link="finger"/><axis xyz="0 1 0"/>
<limit lower="0.01" upper="0.06" effort="1" velocity="1"/></joint></robot>"""


def needs(*names: str) -> Any:
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    return pytest.mark.skipif(bool(missing), reason=f"{', '.join(missing)} is not installed")


def hands(count: int) -> Any:
    """Returns configurations of the built-in hand, some of them squeezed."""
    return Scene.builtin("hand").sample(count, seed=5)


def contents(folder: pathlib.Path) -> Dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir() if path.name.startswith("part-")}


def written(path: pathlib.Path, columns: Dict[str, Any]) -> pathlib.Path:
    """Writes columns as users would, without the package."""
    if path.suffix == ".npz":
        np.savez(path, **columns)
    elif path.suffix == ".npy":
        np.save(path, columns["q"])
    elif path.suffix == ".jsonl":
        lines = [dict(zip(columns, row)) for row in zip(*(np.asarray(values).tolist() for values in columns.values()))]
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    else:
        import pyarrow
        import pyarrow.parquet

        table = pyarrow.table({name: np.asarray(values).tolist() for name, values in columns.items()})
        pyarrow.parquet.write_table(table, path, row_group_size=70)
    return path


def test_queries_are_those_of_a_batch(planar: Scene, model: extricate.Model) -> None:
    Q = planar.sample(40, seed=1, colliding=True)
    for mapper, expected in (
        (rows.Query(planar, effort="quick"), planar.query_batch(Q, effort="quick")),
        (rows.Query(model=model), model.query_batch(Q)),
        (rows.Query(planar, model=model.to_bytes(), exits=2), model.query_batch(Q, exits=2)),
    ):
        found = pickle.loads(pickle.dumps(mapper))({"q": Q, "name": np.arange(40)})
        assert list(found) == ["q", "name", *(expected.dtype.names or ()), "error"]
        assert all(found[name].tobytes() == np.ascontiguousarray(expected[name]).tobytes() for name in expected.dtype.names or ())
        assert not (found["error"] != "").any() and found["name"] is not None and (found["name"] == np.arange(40)).all()


def test_a_spoiled_row_is_a_row_with_a_reason(planar: Scene) -> None:
    Q = planar.sample(40, seed=1, colliding=True)
    spoiled = Q.copy()
    spoiled[3, 1], spoiled[17] = np.nan, 1e12
    found = rows.Query(planar)({"q": spoiled})
    assert set(np.flatnonzero(found["error"] != "")) == {3, 17}
    assert found["error"][3] == "Q: configuration: `joint_2` (coordinate 1): got NaN, expected a finite number within 1e9"
    assert np.isnan(found["depth"][[3, 17]]).all() and not found["verified"][[3, 17]].any()
    good = np.flatnonzero(found["error"] == "")
    assert (found["witness"][good] == planar.query_batch(Q[good])["witness"]).all()

    beyond = Q.copy()
    beyond[5, 1] = 9
    assert not (rows.Query(planar)({"q": beyond})["error"] != "").any()
    assert "expected a value within" in rows.Query(planar, limits="refuse")({"q": beyond})["error"][5]
    checked = rows.Check(planar)({"q": beyond})
    assert "expected a value within" in checked["error"][5] and np.isnan(checked["clearance"][5])
    others = np.delete(np.arange(40), 5)
    assert (checked["free"][others] == planar.check(Q[others])).all()
    assert (checked["clearance"][others] == planar.distances(Q[others])).all()

    measured = rows.Distance(planar, within=2.0)({"q": spoiled})
    assert (measured["error"] == found["error"]).all() and np.isnan(measured["distance"][[3, 17]]).all()
    expected = planar.signed_distance(Q[good], within=2.0)
    for name in ("distance", "bound", "witness", "gradient", "pair", "checks"):
        np.testing.assert_array_equal(measured[name][good], expected[name])

    # Rows of any form, and those that were spoiled before.
    found = rows.Check(planar)({"q": [[0, 0, 0], None, [1, 2], ["x", 0, 0], [0, 0, 0]], "error": ["", "", "", "", "no file"]})
    assert found["error"].tolist() == [
        "",
        "q: got nothing, expected numbers of shape (3,)",
        "q: got shape (2,), expected numbers of shape (3,)",
        "q: could not convert string to float: 'x', expected numbers of shape (3,)",
        "no file",
    ]
    empty = rows.Query(planar)({"q": np.zeros((0, 3))})
    assert empty["witness"].shape == (0, 3) and empty["error"].shape == (0,)


def test_what_is_no_fault_of_a_row_is_an_error(planar: Scene) -> None:
    Q = planar.sample(2, seed=1)
    for call, expected in (
        (lambda: rows.Query(), "scene: got None"),
        (lambda: rows.Query(planar)({"p": Q}), "columns: got p, expected 'q' among them"),
        (lambda: rows.Query(planar)({"q": Q[:, :2]}), r"q: got rows of shape \(2,\), expected \(3,\)"),
        (lambda: rows.Query(planar)({"q": [["a", "b", "c"]]}), "q: got <U1, expected numbers"),
        (lambda: rows.Query(planar, effort="x")({"q": Q}), "effort: got "),
        (lambda: rows.Release(planar), "object: got neither, expected `object` or `objects`"),
        (lambda: rows.Release(planar, object="none")({"q": Q}), "none"),
        (lambda: rows.Repair(planar, resolution=-1)({"path": [Q]}), "resolution"),
    ):
        with pytest.raises(ValueError, match=expected):
            call()
    with pytest.raises(TypeError, match="unexpected keyword argument 'effrt'"):
        rows.Query(planar, effrt="quick")({"q": Q})
    with pytest.raises(TypeError, match="unexpected keyword argument 'effort'"):
        rows.Check(planar, effort="quick")({"q": Q})


def test_hands_are_released(tmp_path: pathlib.Path) -> None:
    hand, ball = Scene.builtin("hand"), extricate.Sphere(0.03, [0, 0, 0.08])
    Q = hands(60)
    grasps = hand.release(Q, object=ball)
    spoiled = np.vstack([Q, np.full((1, hand.nq), np.nan)])
    found = rows.Release(hand, object=ball)({"q": spoiled})
    assert (found["config"][:-1] == [grasp.config for grasp in grasps]).all() and np.isnan(found["config"][-1]).all()
    assert found["kept_fingers"][:-1].tolist() == [grasp.fingers[1] for grasp in grasps]
    assert found["error"][-1].startswith("Q: configuration: ") and not (found["error"][:-1] != "").any()

    for name, text in (("good.obj", OBJECT), ("bad.obj", "v 0 0 x\n")):
        (tmp_path / name).write_text(text)
    release = rows.Release(hand, objects=tmp_path)
    names = ["good.obj", "bad.obj", "none.obj", "../good.obj", str(tmp_path / "good.obj"), "good.obj", "good.obj"]
    found = release({"q": Q[:7], "object": names, "scale": [1, 1, 1, 1, 1, 0.5, "x"]})
    assert found["error"][0] == found["error"][5] == ""
    for place, part in ((1, "line 1: got `v 0 0 x`"), (2, "none.obj"), (3, "'../good.obj', expected a file below"), (4, "below"), (6, "scale: got 'x'")):
        assert part in found["error"][place]
    half = hand.release(Q[5], object=extricate.Mesh(tmp_path / "good.obj", scale=0.5))
    assert (found["config"][5] == half.config).all()


@pytest.mark.parametrize("form", ["columns of numbers", "one column each"])
def test_hands_of_data_sets_come_back_as_they_were_stored(form: str) -> None:
    floor = extricate.HalfSpace([0, 0, 1], -0.9)
    scene = Scene(extricate.Robot(GRIPPER, base="floating", bounds=([-1] * 3, [1] * 3)), [floor])
    Q = scene.sample(20, seed=2) * [0.05, 0.05, 0.05, 1, 1, 1, 1, 1]
    arrays = extricate.grasps.to_arrays(scene, Q, rotation_as="rpy")
    batch: Dict[str, Any]
    if form == "one column each":
        layout = rows.Hands(["x", "y", "z"], ["rx", "ry", "rz"], {"j": "width"}, rotation_as="rpy")
        batch = {**dict(zip("xyz", arrays.translation.T)), **dict(zip(["rx", "ry", "rz"], arrays.rotation.T)), "width": arrays.joints[:, 0]}
        batch["rx"] = batch["rx"].copy()
        batch["rx"][4] = np.nan
    else:
        layout = rows.Hands(rotation_as="rpy", names=["j"])
        batch = {"translation": arrays.translation, "rotation": arrays.rotation.copy(), "joints": arrays.joints}
        batch["rotation"][4] = np.nan
    found = rows.Release(scene, q=layout, object=extricate.Sphere(0.05))(batch)
    assert set(np.flatnonzero(found["error"] != "")) == {4} and "rotation" in found["error"][4]
    good = np.delete(np.arange(20), 4)
    expected = scene.release(extricate.grasps.from_arrays(scene, *arrays[:3], names=arrays.names, rotation_as="rpy"), object=extricate.Sphere(0.05))
    assert (found["config"][good] == [expected[at].config for at in good]).all()
    # The stored columns hold the released hands; a spoiled row keeps what it was.
    back, reasons = layout.configurations(scene, found)
    assert set(reasons) == {4} and np.abs(np.abs(back[good]) - np.abs(found["config"][good])).max() < 1e-12
    moved = [grasp.moved > 0 for grasp in expected]
    assert any(moved) and (found["width" if form == "one column each" else "joints"][4] == arrays.joints[4]).all()
    with pytest.raises(ValueError, match="joints: 'j' is missing"):
        rows.Query(scene, q=rows.Hands(rotation_as="rpy", names=[]))({**batch, "translation": arrays.translation, "rotation": arrays.rotation, "joints": np.zeros((20, 0))})


def test_clips_are_repaired(planar: Scene) -> None:
    points = planar.sample(4, seed=3)
    found = rows.Repair(planar)({"path": [points[:2], points[:3], [[0, 0]], [[0, np.nan, 0], [0, 0, 0]]]})
    expected = [planar.repair(points[:2]), planar.repair(points[:3])]
    for at, repaired in enumerate(expected):
        assert repaired.points is not None and (found["points"][at] == repaired.points).all()
        assert found["deviation"][at] == repaired.deviation and found["error"][at] == ""
    assert "got shape (1, 2)" in found["error"][2] and "row 0" in found["error"][3] and len(found["points"][3]) == 0
    clips = np.stack([np.linspace(points[k], points[k] + 0.1, 5) for k in range(2)])
    clips = clips[[bool(planar.check(clip[0])) for clip in clips]]
    kept = rows.Repair(planar, frames=True)({"path": clips})
    assert kept["points"].shape == clips.shape


@pytest.mark.parametrize("before", [".jsonl", ".npz", ".npy", pytest.param(".parquet", marks=needs("pyarrow"))])
@pytest.mark.parametrize("after", [".jsonl", ".npz", pytest.param(".parquet", marks=needs("pyarrow"))])
def test_files_become_files_and_a_second_run_does_nothing(planar: Scene, tmp_path: pathlib.Path, before: str, after: str) -> None:
    Q = planar.sample(250, seed=1)
    Q[9, 0] = 1e12
    given = {"q": Q, "name": np.array([f"row {k}" for k in range(250)])}
    source = written(tmp_path / f"in{before}", given)
    told: List[rows.Progress] = []
    label = rows.Check(planar)
    output = tmp_path / f"out{after}"
    done = rows.run(label, source, output, workers=2, block=64, progress=told.append)
    assert done == rows.Done(250, 250, 1) and told[-1].stage == "250 of 250 rows, 1 failed"
    assert sorted(contents(output)) == [f"part-{k:06d}{after}" for k in range(4)]
    found, expected = rows.read(output), label({"q": Q})
    names = ["q", *(["name"] if before != ".npy" else []), "free", "clearance", "error"]
    assert list(found) == names and (found["q"] == Q).all() and (found["free"] == expected["free"]).all()
    clearance = np.array([np.nan if one is None else one for one in found["clearance"]], dtype=float)
    assert (clearance[expected["error"] == ""] == expected["clearance"][expected["error"] == ""]).all()
    assert found["error"].tolist() == expected["error"].tolist()
    if before != ".npy":
        assert found["name"].tolist() == given["name"].tolist()

    first = contents(output)
    stamps = {path.name: path.stat().st_mtime_ns for path in output.iterdir() if path.name.startswith("part-")}
    assert rows.run(label, source, output, workers=2, block=64) == rows.Done(250, 0, 0)
    assert {name: (output / name).stat().st_mtime_ns for name in stamps} == stamps
    # A block that is lost is done again, alone.
    (output / f"part-000002{after}").unlink()
    assert rows.run(label, source, output, workers=1, block=64) == rows.Done(250, 64, 0)
    assert contents(output) == first


def test_a_run_is_of_one_input_one_mapper_and_one_block(planar: Scene, tmp_path: pathlib.Path) -> None:
    Q = planar.sample(20, seed=1)
    source, output = written(tmp_path / "a.npz", {"q": Q}), tmp_path / "out.npz"
    rows.run(rows.Check(planar), source, output, block=8)
    for mapper, block, name in ((rows.Query(planar), 8, "mapper"), (rows.Check(planar), 9, "block"), (rows.Check(planar.without(planar.bodies[-1:])), 8, "mapper")):
        with pytest.raises(ValueError, match=f"got output of another {name}, expected the same one"):
            rows.run(mapper, source, output, block=block)
    # More input makes more output.
    more = written(tmp_path / "b.npz", {"q": Q[:5]})
    assert rows.run(rows.Check(planar), [source, more], output, block=8) == rows.Done(25, 5, 0)
    assert len(rows.read(output)["q"]) == 25
    written(source, {"q": Q[:4]})
    with pytest.raises(ValueError, match="got output of another input"):
        rows.run(rows.Check(planar), [source, more], output, block=8)
    (output / "part-000001.npz").unlink()
    for read in (rows.read, lambda path: list(rows.batches(path, 4)), lambda path: rows.run(rows.Check(planar), path, tmp_path / "next.npz")):
        with pytest.raises(ValueError, match="out.npz: got 3 of 4 blocks, expected the output of a run that is done"):
            read(output)
    assert len(rows.read(sorted(output.glob("part-*")))["q"]) == 17
    (output / "_run.json").write_text("{}")
    with pytest.raises(ValueError, match="_run.json: KeyError"):
        rows.run(rows.Check(planar), [source, more], output, block=8)


def test_another_mesh_of_the_same_name_is_another_object(tmp_path: pathlib.Path) -> None:
    source, mesh = written(tmp_path / "in.npz", {"q": hands(4)}), tmp_path / "object.obj"
    mesh.write_text(OBJECT)
    release = rows.Release(Scene.builtin("hand"), object=extricate.Mesh(mesh))
    rows.run(release, source, tmp_path / "out.npz")
    assert rows.run(release, source, tmp_path / "out.npz") == rows.Done(4, 0, 0)
    mesh.write_text(OBJECT.replace("0 0 0.1\n", "0 0 0.2\n"))
    with pytest.raises(ValueError, match="got output of another mapper"):
        rows.run(release, source, tmp_path / "out.npz")


def test_arguments_and_files_are_checked(planar: Scene, tmp_path: pathlib.Path) -> None:
    label = rows.Check(planar)
    source = written(tmp_path / "a.npz", {"q": np.zeros((2, 3))})
    (tmp_path / "a.txt").write_text("")
    (tmp_path / "empty").mkdir()
    np.savez(tmp_path / "uneven.npz", q=np.zeros((2, 3)), p=np.zeros(3))
    np.savez(tmp_path / "pickled.npz", q=np.array([{}, {}], dtype=object), allow_pickle=True)
    (tmp_path / "broken.npz").write_bytes(b"PK")
    for given, output, error, expected in (
        (source, "out.csv", ValueError, "output: got 'out.csv', expected a name that ends with .parquet, .npz, .jsonl"),
        (tmp_path / "none.npz", "out.npz", FileNotFoundError, "none.npz: no such file"),
        (tmp_path / "a.txt", "out.npz", ValueError, "a.txt: got a name that ends with '.txt'"),
        (tmp_path / "empty", "out.npz", ValueError, "empty: got a folder without files of rows"),
        (tmp_path / "uneven.npz", "out.npz", ValueError, "expected as many in each"),
        (tmp_path / "pickled.npz", "out.npz", ValueError, "pickled.npz: .*Python objects"),
        (tmp_path / "broken.npz", "out.npz", ValueError, "broken.npz: "),
    ):
        with pytest.raises(error, match=expected):
            rows.run(label, given, output if output == "out.csv" else tmp_path / output)
    with pytest.raises(ValueError, match="block: got 0"):
        rows.run(label, source, tmp_path / "out.npz", block=0)
    with pytest.raises(ValueError, match="on: got 'slurm', expected None, \"ray\" or an executor"):
        rows.run(label, source, tmp_path / "out.npz", on="slurm")


def test_lines_that_are_no_rows_are_spoiled(planar: Scene, tmp_path: pathlib.Path) -> None:
    (tmp_path / "in.jsonl").write_text('{"q": [0, 0, 0], "at": {"x": 1}}\n\n{"p": 1}\n{"q":\n5\n[0.1, 0, 0]\n')
    done = rows.run(rows.Check(planar), tmp_path / "in.jsonl", tmp_path / "out.jsonl", block=2)
    assert done == rows.Done(5, 5, 3)
    lines = [json.loads(line) for path in sorted((tmp_path / "out.jsonl").glob("part-*")) for line in path.read_text().splitlines()]
    assert lines[0]["at.x"] == 1 and lines[0]["free"] is True and lines[4]["error"] == ""
    assert lines[1]["error"] == "q: got nothing, expected numbers of shape (3,)" and lines[1]["clearance"] is None
    assert lines[2]["error"].startswith("line: ") and lines[3]["error"] == "line: got int, expected a JSON object"


def broken(batch: Dict[str, Any]) -> Dict[str, Any]:
    """Fails for the block that begins with 8, unless a file says that it is mended."""
    if batch["k"][0] == 8 and not os.path.exists(os.environ["MENDED"]):
        raise OSError("the disk is gone")
    return {"twice": 2 * batch["k"]}


def test_a_block_that_fails_ends_no_other(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MENDED", str(tmp_path / "mended"))
    source = written(tmp_path / "in.npz", {"k": np.arange(40)})
    with concurrent.futures.ThreadPoolExecutor(2) as threads:
        with pytest.raises(RuntimeError, match="1 of 10 blocks failed, first rows 8 to 12 of .*in.npz .OSError: the disk is gone.; run again"):
            rows.run(broken, source, tmp_path / "out.npz", block=4, on=threads)
        (tmp_path / "mended").touch()
        assert rows.run(broken, source, tmp_path / "out.npz", block=4, on=threads) == rows.Done(40, 4, 0)
    assert (rows.read(tmp_path / "out.npz")["twice"] == 2 * np.arange(40)).all()


class Mortal:
    """A release whose process ends without a word at the first try of some blocks."""

    def __init__(self, release: rows.Release, graves: pathlib.Path) -> None:
        self.release, self.graves = release, graves

    def __call__(self, batch: Dict[str, Any]) -> Dict[str, Any]:
        grave = self.graves / str(batch["row"][0])
        if batch["row"][0] in (0, 1000, 2500) and not grave.exists():
            grave.touch()
            os._exit(9)
        return self.release(batch)


def test_workers_end_again_and_again_and_no_row_is_lost(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(pathlib.Path(__file__).parent), *sys.path]))
    release = rows.Release(Scene.builtin("hand"), object=extricate.Sphere(0.03, [0, 0, 0.08]))
    source = written(tmp_path / "in.npz", {"q": hands(3000), "row": np.arange(3000)})
    rows.run(release, source, tmp_path / "one.npz", workers=1, block=500)
    (tmp_path / "graves").mkdir()
    done = rows.run(Mortal(release, tmp_path / "graves"), source, tmp_path / "two.npz", workers=2, block=500)
    assert len(list((tmp_path / "graves").iterdir())) == 3
    assert done.rows == done.new == 3000 and done.spoiled == 0
    assert contents(tmp_path / "one.npz") == contents(tmp_path / "two.npz")
    assert (rows.read(tmp_path / "two.npz")["row"] == np.arange(3000)).all()


RUN = """
import sys, extricate
from extricate import rows
release = rows.Release(extricate.Scene.builtin("hand"), object=extricate.Sphere(0.03, [0, 0, 0.08]))
rows.run(release, sys.argv[1], sys.argv[2], workers=2, block=250)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes as Linux has them")
def test_a_run_that_is_killed_goes_on(tmp_path: pathlib.Path) -> None:
    release = rows.Release(Scene.builtin("hand"), object=extricate.Sphere(0.03, [0, 0, 0.08]))
    source, output = written(tmp_path / "in.npz", {"q": hands(2000)}), tmp_path / "out.npz"
    driver = subprocess.Popen([sys.executable, "-c", RUN, str(source), str(output)])
    try:
        until = time.monotonic() + 120
        while not output.exists() or not contents(output):
            assert driver.poll() is None and time.monotonic() < until
            time.sleep(0.01)
        with pytest.raises(OSError, match="another run of rows.run writes to this folder"):
            rows.run(release, source, output, block=250)
    finally:
        driver.kill()
        driver.wait()
    kept = contents(output)
    # A writer that is killed leaves such a file.
    (output / f".part-000007.npz.{'0f' * 16}").touch()
    done = rows.run(release, source, output, block=250)
    assert done.rows == 2000 and 0 < done.new <= 2000 - 250 * len(kept)
    assert {name: digest for name, digest in contents(output).items() if name in kept} == kept
    assert len(rows.read(output)["config"]) == 2000 and not list(output.glob(".*.*"))


def test_executors_give_the_same_bytes(planar: Scene, tmp_path: pathlib.Path) -> None:
    source = written(tmp_path / "in.npz", {"q": planar.sample(200, seed=1, colliding=True)})
    query = rows.Query(planar, effort="quick")
    rows.run(query, source, tmp_path / "own.npz", block=50)
    with concurrent.futures.ProcessPoolExecutor(2) as processes:
        rows.run(query, source, tmp_path / "processes.npz", block=50, on=processes)
        mapped = list(processes.map(query, rows.batches(source, 50)))
    assert contents(tmp_path / "own.npz") == contents(tmp_path / "processes.npz")
    assert (np.concatenate([block["witness"] for block in mapped]) == rows.read(tmp_path / "own.npz")["witness"]).all()


@needs("dask", "distributed", "joblib")
def test_dask_and_joblib_give_the_same(planar: Scene, tmp_path: pathlib.Path) -> None:
    import joblib
    from distributed import Client

    source = written(tmp_path / "in.npz", {"q": planar.sample(200, seed=1, colliding=True)})
    query = rows.Query(planar, effort="quick")
    rows.run(query, source, tmp_path / "own.npz", block=50)
    expected = rows.read(tmp_path / "own.npz")["witness"]
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        rows.run(query, source, tmp_path / "dask.npz", block=50, on=client.get_executor())
        mapped = client.gather(client.map(query, list(rows.batches(source, 50))))
    assert contents(tmp_path / "own.npz") == contents(tmp_path / "dask.npz")
    assert (np.concatenate([block["witness"] for block in mapped]) == expected).all()
    joined = joblib.Parallel(n_jobs=2)(joblib.delayed(query)(block) for block in rows.batches(source, 50))
    assert (np.concatenate([block["witness"] for block in joined]) == expected).all()


@needs("ray", "pyarrow")
def test_ray_loses_a_node(tmp_path: pathlib.Path, patient_ray: None) -> None:
    import ray
    from ray.cluster_utils import Cluster

    hand, ball = Scene.builtin("hand"), extricate.Sphere(0.03, [0, 0, 0.08])
    release = rows.Release(hand, object=ball)
    source = written(tmp_path / "in.parquet", {"q": hands(12_000), "row": np.arange(12_000)})
    rows.run(release, source, tmp_path / "one.parquet", workers=1, block=500)
    node = {"num_cpus": 1, "object_store_memory": 150 * 2**20}
    cluster = Cluster(initialize_head=True, head_node_args={**node, "include_dashboard": False})
    lost = cluster.add_node(**node)
    ray.init(address=cluster.address, log_to_driver=False)
    try:
        done_rows: List[int] = []

        def lose(state: rows.Progress) -> None:
            done_rows.append(state.done)
            if len(done_rows) == 4:
                # The node stops like a machine that loses its power.
                cluster.remove_node(lost, allow_graceful=False)

        done = rows.run(release, source, tmp_path / "two.parquet", on="ray", block=500, progress=lose)
        assert done == rows.Done(12_000, 12_000, 0)
        assert contents(tmp_path / "one.parquet") == contents(tmp_path / "two.parquet")
        assert rows.run(release, source, tmp_path / "two.parquet", on="ray", block=500) == rows.Done(12_000, 0, 0)
    finally:
        ray.shutdown()
        cluster.shutdown()


@needs("ray", "pyarrow")
def test_ray_data_takes_the_classes_as_they_are(tmp_path: pathlib.Path, patient_ray: None) -> None:
    import ray

    hand = Scene.builtin("hand")
    (tmp_path / "good.obj").write_text(OBJECT)
    (tmp_path / "in").mkdir()
    Q = hands(400)
    for part in range(2):
        some = slice(200 * part, 200 * part + 200)
        written(tmp_path / "in" / f"{part}.parquet", {"q": Q[some], "row": np.arange(400)[some], "object": ["good.obj"] * 200})
    # Another cluster may run on this machine.
    ray.init(address="local", num_cpus=2, object_store_memory=150 * 2**20, include_dashboard=False, log_to_driver=False)
    try:
        data = ray.data.read_parquet(str(tmp_path / "in"))
        released = data.map_batches(rows.Release, fn_constructor_args=(hand,), fn_constructor_kwargs={"objects": tmp_path}, concurrency=1, batch_size=128)
        released.map_batches(rows.Check(hand, q="config")).write_parquet(str(tmp_path / "out.parquet"))
    finally:
        ray.shutdown()
    found = rows.read(tmp_path / "out.parquet")
    order = np.argsort(found["row"])
    grasps = hand.release(Q, object=extricate.Mesh(tmp_path / "good.obj"))
    assert (found["row"][order] == np.arange(400)).all() and found["free"].all()
    assert (found["config"][order] == [grasp.config for grasp in grasps]).all()


@needs("jax")
def test_tensors_of_jax_come_back_as_such(planar: Scene) -> None:
    import jax

    jax.config.update("jax_enable_x64", True)
    Q = planar.sample(20, seed=1, colliding=True)
    found = rows.Query(planar)({"q": jax.numpy.asarray(Q)})
    assert isinstance(found["witness"], jax.Array) and (np.asarray(found["witness"]) == planar.query_batch(Q)["witness"]).all()
    assert isinstance(found["verified"], jax.Array) and isinstance(found["error"], np.ndarray)


class Tensor:
    """A tensor as torch has it: it speaks DLPack, unless it needs gradients, and its package has `from_dlpack`."""

    __module__ = "tensors.core"

    def __init__(self, array: Any, needs_gradient: bool = False) -> None:
        self.array, self.needs_gradient = array, needs_gradient

    def __len__(self) -> int:
        return len(self.array)

    def __dlpack__(self, **keywords: Any) -> Any:
        if self.needs_gradient:
            raise BufferError("cannot export tensors that require gradient")
        return self.array.__dlpack__(**keywords)

    def __dlpack_device__(self) -> Any:
        return self.array.__dlpack_device__()


def test_tensors_of_packages_without_array_namespaces_come_back_as_such(planar: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    package: Any = types.ModuleType("tensors")
    package.from_dlpack = lambda array: Tensor(np.from_dlpack(array))
    monkeypatch.setitem(sys.modules, "tensors", package)
    Q = planar.sample(20, seed=1, colliding=True)
    for given in (Q, Q.astype(np.float32)):
        found = rows.Query(planar)({"q": Tensor(given)})
        assert isinstance(found["witness"], Tensor) and isinstance(found["verified"], Tensor) and isinstance(found["error"], np.ndarray)
        assert (found["witness"].array == planar.query_batch(given)["witness"]).all()
    with pytest.raises(ValueError, match="q: got Tensor .*, expected a tensor on the CPU without gradients"):
        rows.Query(planar)({"q": Tensor(Q, needs_gradient=True)})


@needs("array_api_strict")
def test_any_array_that_speaks_dlpack_comes_back_as_such(planar: Scene) -> None:
    import array_api_strict

    Q = planar.sample(20, seed=1, colliding=True)
    found = rows.Query(planar)({"q": array_api_strict.asarray(Q)})
    assert type(found["witness"]) is type(array_api_strict.asarray(Q))
    assert (np.from_dlpack(found["witness"]) == planar.query_batch(Q)["witness"]).all()


def test_whatever_has_a_buffer_is_taken(planar: Scene) -> None:
    Q = planar.sample(20, seed=1, colliding=True)
    assert (rows.Query(planar)({"q": memoryview(Q)})["witness"] == planar.query_batch(Q)["witness"]).all()
