"""Recordings that other viewers open, and the figure of an answer."""

import pathlib
import pickle

import numpy as np
import pytest

import extricate
from extricate import recordings


def motion() -> tuple:
    """A scene, and a motion of five frames out of collision in it."""
    scene = extricate.Scene.builtin("planar-arm")
    q = scene.sample(1, seed=4, colliding=True)[0]
    answer = scene.query(q)
    return scene, q + np.linspace(0, 1, 5)[:, None] * (answer.witness - q)


def test_a_recording_of_rerun_holds_the_poses(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    from rerun.chunk import RrdReader

    scene, Q = motion()
    path = tmp_path / "a.rrd"
    recordings.save_rerun(scene, Q, path, times=np.arange(5.0))
    found: dict = {}
    seconds: dict = {}
    shapes = set()
    for chunk in RrdReader(str(path)).stream():
        body = str(chunk.entity_path).split("/")[-1]
        batch = chunk.to_record_batch()
        columns = {name.split(":", 1)[-1]: batch.column(at) for at, name in enumerate(batch.schema.names)}
        if "vertex_positions" in columns:
            shapes.add(body)
        if "translation" in columns:
            parts = (columns["translation"], columns["mat3x3"])
            found.setdefault(body, []).extend(zip(*(part.to_pylist() for part in parts)))
            seconds.setdefault(body, []).extend(columns["time"].cast("int64").to_pylist())
    assert set(found) == shapes == set(scene.bodies)
    poses = scene.poses(Q)
    for at, body in enumerate(scene.bodies):
        assert sorted(seconds[body]) == [k * 10**9 for k in range(5)]
        for frame, (translation, rotation) in zip(np.divide(seconds[body], 10**9).astype(int), found[body]):
            # A matrix of rerun is a list of its columns, in single precision.
            assert np.allclose(np.ravel(translation), poses[frame, at, :3, 3], atol=1e-6)
            assert np.allclose(np.reshape(np.ravel(rotation), (3, 3)).T, poses[frame, at, :3, :3], atol=1e-6)


def test_an_mcap_file_reads_back(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
    from mcap.reader import make_reader
    from mcap_protobuf.decoder import DecoderFactory

    scene, Q = motion()
    path = tmp_path / "a.mcap"
    for _ in range(2):
        recordings.save_mcap(scene, Q, path)
    poses = scene.poses(Q)
    with path.open("rb") as stream:
        messages = list(make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages())
    trees = [(message.log_time, tree) for _, channel, message, tree in messages if channel.topic == "/tf"]
    assert [time for time, _ in trees] == [k * 10**8 for k in range(5)]
    for frame, (_, tree) in enumerate(trees):
        assert [found.child_frame_id for found in tree.transforms] == scene.bodies
        for found, pose in zip(tree.transforms, poses[frame]):
            t, r = found.translation, found.rotation
            assert np.allclose([t.x, t.y, t.z], pose[:3, 3])
            turned = [
                [1 - 2 * (r.y**2 + r.z**2), 2 * (r.x * r.y - r.z * r.w), 2 * (r.x * r.z + r.y * r.w)],
                [2 * (r.x * r.y + r.z * r.w), 1 - 2 * (r.x**2 + r.z**2), 2 * (r.y * r.z - r.x * r.w)],
                [2 * (r.x * r.z - r.y * r.w), 2 * (r.y * r.z + r.x * r.w), 1 - 2 * (r.x**2 + r.y**2)],
            ]
            assert np.allclose(turned, pose[:3, :3])
    updates = [update for _, channel, _, update in messages if channel.topic == "/scene"]
    first = {entity.id: entity for entity in updates[0].entities}
    assert set(first) == set(scene.bodies)
    hit = {body for pair in scene.colliding_pairs(Q[0]) for body in pair if body.startswith("link")}
    orange = {body for body, entity in first.items() if entity.triangles[0].color.r > 0.8}
    assert orange == hit and hit
    # The links are orange no longer at the exit.
    last = {entity.id: entity.triangles[0].color.r for update in updates for entity in update.entities}
    assert all(last[body] < 0.8 for body in hit)
    assert len(first["link_1"].triangles[0].points) == len(scene.mesh("link_1")[0])


def test_what_cannot_be_recorded_is_said(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed")
    scene, Q = motion()
    with pytest.raises(ValueError, match=r"Q: got shape \(2,\), expected \(n, 3\)"):
        recordings.save_mcap(scene, [0.0, 1.0], tmp_path / "a.mcap")
    with pytest.raises(ValueError, match=r"times: got shape \(2,\), expected \(5,\)"):
        recordings.save_mcap(scene, Q, tmp_path / "a.mcap", times=[0, 1])
    with pytest.raises(ValueError, match="do not decrease"):
        recordings.save_mcap(scene, Q, tmp_path / "a.mcap", times=[0, 1, 2, 1, 3])
    assert not list(tmp_path.iterdir())


def test_a_figure_shows_depth_bound_and_joints() -> None:
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    scene, Q = motion()
    for source in (scene, extricate.Solver(scene)):
        answer = source.query(Q[0])
        above, below = answer.plot().axes
        assert sorted(bar.get_width() for bar in above.patches) == sorted([answer.lower_bound, answer.depth])
        query, witness = (points.get_offsets()[:, 0] for points in below.collections[1:])
        assert np.allclose(query, Q[0]) and np.allclose(witness, answer.witness)
        assert [label.get_text() for label in below.get_yticklabels()] == ["joint_1", "joint_2", "joint_3"]
    with pytest.raises(RuntimeError, match="does not know its scene"):
        pickle.loads(pickle.dumps(answer)).plot()
