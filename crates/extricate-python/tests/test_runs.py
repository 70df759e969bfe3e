"""Learning runs that are stopped, kept and gone on with, or end by what they reached."""

import os
import pathlib
import signal
import threading

import pytest

import extricate
from extricate import Progress, Scene

LABELS = 20_000


def ended_at(labels: int):  # type: ignore[no-untyped-def]
    """A listener that ends the run once so many labels were spent."""
    return lambda state: state.labels < labels


def test_a_run_goes_on_to_the_same_model(planar: Scene, tmp_path: pathlib.Path) -> None:
    whole = extricate.learn(planar, labels=LABELS, seed=2)
    kept = tmp_path / "run.checkpoint"
    options = {"labels": LABELS, "seed": 2, "checkpoint": kept, "checkpoint_every": 0}
    part = extricate.learn(planar, progress=ended_at(8000), **options)
    assert part.statistics["ended_by"] == "interruption" and part.statistics["labels"] < LABELS and kept.exists()
    # What is not given is what it was; a checkpoint goes when its run ends by itself.
    again = extricate.learn(planar, checkpoint=str(kept), resume=True)
    assert again.to_bytes() == whole.to_bytes() and not kept.exists()
    assert extricate.learn(planar, **options).to_bytes() == whole.to_bytes() and not kept.exists()


@pytest.mark.skipif(os.name == "nt", reason="needs POSIX signals")
def test_what_an_interrupt_stops_can_go_on(planar: Scene, tmp_path: pathlib.Path) -> None:
    kept = tmp_path / "run.checkpoint"
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        extricate.learn(planar, labels=10**9, checkpoint=kept)
    spent = []

    def look(state: Progress) -> bool:
        spent.append(state.labels)
        return False

    extricate.learn(planar, checkpoint=kept, resume=True, progress=look)
    assert spent[0] > 1000 and kept.exists()


def test_a_run_whose_checkpoint_cannot_be_written_goes_on(planar: Scene, tmp_path: pathlib.Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()

    def remove(state: Progress) -> None:
        if folder.exists():
            for left in folder.iterdir():
                left.unlink()
            folder.rmdir()

    with pytest.warns(RuntimeWarning, match="no checkpoint: cannot write .*run.checkpoint"):
        model = extricate.learn(planar, labels=LABELS, checkpoint=folder / "run.checkpoint", checkpoint_every=0, progress=remove)
    assert model.statistics["ended_by"] == "labels"


def test_runs_end_by_what_they_reached(planar: Scene) -> None:
    model = extricate.learn(planar, labels=10**7, target_excess=0.5, target_disagreement=0.2)
    assert model.statistics["ended_by"] == "quality" and model.statistics["labels"] < 10**6
    assert extricate.learn(planar, labels=10**9, memory=8).statistics["ended_by"] == "memory"


def test_wrong_runs_are_told_what_was_expected(planar: Scene, arm: Scene, tmp_path: pathlib.Path) -> None:
    kept, scene_file = tmp_path / "run.checkpoint", tmp_path / "scene.toml"
    scene_file.write_text("clearance = 0")
    extricate.learn(planar, labels=LABELS, checkpoint=kept, progress=ended_at(1))
    for call, kind, message in [
        (lambda: extricate.learn(planar, resume=True), ValueError, "resume: got True without `checkpoint`"),
        (lambda: extricate.learn(planar, checkpoint=kept, resume=True, labels=5), ValueError, "labels: got 5, expected 20000, with which"),
        (lambda: extricate.learn(planar, checkpoint=kept, resume=True, seconds=5), ValueError, "seconds: got 5, expected None"),
        (lambda: extricate.learn(planar, checkpoint=kept, resume=True, seed=5), ValueError, "seed: got 5, expected 0"),
        (lambda: extricate.learn(planar, checkpoint=kept, resume=True, memory=5), ValueError, "memory: got 5, expected 4096"),
        (lambda: extricate.learn(arm, checkpoint=kept, resume=True), ValueError, "belongs to another scene"),
        (lambda: extricate.learn(planar, checkpoint=tmp_path / "none", resume=True), FileNotFoundError, "cannot read .*none"),
        (lambda: extricate.learn(planar, checkpoint=tmp_path / "no" / "c"), OSError, "there is no directory"),
        (lambda: extricate.learn(planar, checkpoint=scene_file), OSError, "exists and is no checkpoint"),
        (lambda: extricate.learn(planar, checkpoint=kept, checkpoint_every=-1), ValueError, "checkpoint_every: got -1, expected"),
        (lambda: extricate.learn(planar, memory=0), ValueError, "memory: got 0, expected at least 1"),
        (lambda: extricate.learn(planar, target_excess=-1), ValueError, "target_excess: got -1, expected 0 or more"),
        (lambda: extricate.learn(planar, target_disagreement=float("nan")), ValueError, "target_disagreement: got NaN, expected 0"),
        (lambda: extricate.learn(planar, seed=-1), ValueError, "seed: got -1, expected a whole number from 0"),
        (lambda: extricate.learn(planar, seed=2**64), ValueError, "seed: got 18446744073709551616, expected"),
        (lambda: extricate.learn(planar, seed="a"), TypeError, "seed: got a, expected a whole number"),
        (lambda: extricate.learn(planar, threads=10**6), ValueError, r"threads: got 1000000, expected 0 \(one per core\) to 1024"),
        (lambda: extricate.learn(planar, progress="yes"), TypeError, "progress: got str, expected True, False, None or a function"),
    ]:
        with pytest.raises(kind, match=message):
            call()
