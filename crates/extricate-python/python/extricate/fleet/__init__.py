"""Many scenes, learned and queried on many processors or machines.

    for done in extricate.fleet.learn({"panda": "panda.toml", "ur5": "ur5.toml"}, "models"):
        print(done.key, done.error or done.statistics["boundary_samples"])
    model = extricate.fleet.open("models")["panda"]

Each scene is learned in a process of its own; with `on="ray"` on the cluster that Ray is connected to. What a folder holds is not
learned again. A scene that fails is reported, and the others go on. Read in this order: `learn`, `query` and `open` here, then
`_manifest` (what a folder holds), `_run` (the loop), `_local` and `_cluster` (where work is done), `_work` (what is done there).
"""

from __future__ import annotations

import dataclasses
import os
import pathlib
import reprlib
from collections import OrderedDict
from typing import Any, Callable, Dict, Iterator, Mapping, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from .._extricate import Model, Scene
from ._manifest import Manifest, digest
from ._run import Job, Progress, Tell, run

__all__ = ["Answered", "Fleet", "Learned", "Progress", "learn", "open", "query"]

_Path = Union[str, "os.PathLike[str]"]
_Scene = Union[Scene, _Path, Callable[[], Scene]]

# Options that a model depends on.
_OPTIONS = ("labels", "seconds", "seed")


@dataclasses.dataclass(frozen=True)
class Learned:
    """What became of one scene.

    key: as in `scenes`.
    path: of the model file; None where there is none.
    statistics: as `Model.statistics`; empty where there is no model.
    error: why there is no model; None where there is one.
    seconds: what learning took on its worker; 0 where the folder had the model.
    cached: whether the folder had the model.
    """

    key: str
    path: Optional[pathlib.Path]
    statistics: Mapping[str, Any]
    error: Optional[str]
    seconds: float
    cached: bool


@dataclasses.dataclass(frozen=True)
class Answered:
    """What became of the queries of one scene.

    key: as in `queries`.
    answers: as `Model.query_batch` gives them; None where there are none.
    error: why there are none; None where there are.
    seconds: what they took on their worker.
    """

    key: str
    answers: Optional[npt.NDArray[np.void]]
    error: Optional[str]
    seconds: float


def learn(
    scenes: Mapping[str, _Scene],
    folder: _Path,
    *,
    on: Optional[str] = None,
    workers: int = 0,
    threads: int = 1,
    progress: Optional[Tell] = None,
    **options: Any,
) -> Iterator[Learned]:
    """Learns a model of every scene that `folder` has none of; yields each as it is done.

    scenes: by key: a `Scene`, the path of a scene file, or a function that makes the scene when its place comes. Equal scenes are
        learned once.
    folder: for models and a manifest; made where it is missing.
    on: None for processes of this machine, "ray" for the cluster that Ray is connected to (`pip install extricate[ray]`).
    workers: how many scenes at once; 0 for one per `threads` cores.
    threads: of each scene. Models do not depend on it.
    progress: True for a bar, or a function that is called with a `Progress` after each scene.
    options: labels, seconds and seed, as `extricate.learn` takes them. A model of other options is another model, and learned.

    Whatever fails is the `error` of its `Learned`: a scene that cannot be loaded, a worker that died three times. Raises TypeError
    and ValueError for arguments that make no sense, OSError where the folder cannot be written, and, at the first result, where
    another run writes to it. A run ends with its last result, or when it is closed. Workers of this machine end with it, and with
    this process, however that ends.
    """
    unknown = sorted(set(options) - set(_OPTIONS))
    if unknown:
        raise TypeError(f"got an unexpected keyword argument '{unknown[0]}', expected one of {', '.join(_OPTIONS)}")
    _texts("scenes", scenes)
    manifest = Manifest(pathlib.Path(folder))
    given = {name: value for name, value in options.items() if value is not None}
    return _held(dict(scenes), manifest, (on, workers, threads, progress), given)


def _texts(name: str, mapping: Mapping[str, Any]) -> None:
    """Raises TypeError for a key that is no text, which the manifest could not keep."""
    for key in mapping:
        if not isinstance(key, str):
            raise TypeError(f"{name}: got the key {reprlib.repr(key)}, expected text")


def _held(scenes: Dict[str, _Scene], manifest: Manifest, how: Tuple[Any, ...], given: Dict[str, Any]) -> Iterator[Learned]:
    with manifest.held():
        yield from _learned(scenes, manifest, how, given)


def _learned(scenes: Dict[str, _Scene], manifest: Manifest, how: Tuple[Any, ...], given: Dict[str, Any]) -> Iterator[Learned]:
    hashes: Dict[str, str] = {}
    # By model, the keys that wait for it while another key learns it.
    twins: Dict[str, list[str]] = {}

    def jobs() -> Iterator[Job]:
        for key, source in scenes.items():
            try:
                scene = _scene(source)
                content = digest(scene, given)
            except Exception as error:  # Scenes and their functions may raise anything; only this scene fails.
                yield Job(key, error=f"{type(error).__name__}: {error}")
                continue
            hashes[key] = content
            if manifest.has(content):
                manifest.name(key, content)
                yield Job(key, result=(manifest.statistics(content), 0.0))
            elif content in twins:
                twins[content].append(key)
            else:
                twins[content] = []
                yield Job(key, payload={"scene": scene, "options": given})

    for key, result, error in run("learn", jobs(), len(scenes), *how):
        content = hashes.get(key, "")
        cached = error is None and len(result) == 2
        if error is None and not cached:
            data, statistics, seconds = result
            manifest.store(content, data, statistics)
            result = (statistics, seconds)
        for name in [key, *twins.pop(content, [])]:
            path = None
            if error is None:
                manifest.name(name, content)
                path = manifest.path(content)
            else:
                manifest.fail(name, error)
            statistics, seconds = result if error is None else ({}, 0.0)
            yield Learned(name, path, statistics, error, seconds if name == key else 0.0, cached or name != key)


def _scene(source: _Scene) -> Scene:
    if isinstance(source, Scene):
        return source
    if callable(source):
        return _scene(source())
    return Scene.load(os.fspath(source))


def query(
    folder: _Path,
    queries: Mapping[str, npt.ArrayLike],
    *,
    on: Optional[str] = None,
    workers: int = 0,
    threads: int = 1,
    progress: Optional[Tell] = None,
    **options: Any,
) -> Iterator[Answered]:
    """Queries the models of a folder, each with its own configurations; yields the answers of each as they are there.

    folder: of `learn`.
    queries: by key: float64 (n, nq), as `Model.query_batch` takes them.
    on, workers, threads, progress: as in `learn`. Answers do not depend on them.
    options: as `Model.query_batch` takes them.

    Whatever fails is the `error` of its `Answered`: no such model, rows that are no configurations. Raises TypeError for keys that
    are not text, OSError and ValueError as `open`.
    """
    _texts("queries", queries)
    manifest = Manifest(pathlib.Path(folder), make=False)

    def jobs() -> Iterator[Job]:
        for key, rows in queries.items():
            try:
                path = manifest.path(manifest.content(key))
                model: Any = path.read_bytes() if on == "ray" else str(path.resolve())
                yield Job(key, payload={"model": model, "rows": np.asarray(rows), "options": options})
            except Exception as error:
                yield Job(key, error=f"{type(error).__name__}: {error}")

    for key, result, error in run("query", jobs(), len(queries), on, workers, threads, progress):
        answers, seconds = result if error is None else (None, 0.0)
        yield Answered(key, answers, error, seconds)


class Fleet(Mapping[str, Model]):
    """The models of a folder by key, each loaded when it is first needed. Those used last are kept, up to `memory` bytes of files."""

    def __init__(self, folder: _Path, *, memory: int = 2**31) -> None:
        """folder: of `learn`. memory: most bytes of model files to keep; one model is kept whatever its size."""
        self._manifest = Manifest(pathlib.Path(folder), make=False)
        self._memory = memory
        self._kept: OrderedDict[str, Tuple[Model, int]] = OrderedDict()

    def __getitem__(self, key: str) -> Model:
        """The model of a key. Raises KeyError where there is none, and what `Model.load` raises."""
        content = self._manifest.content(key)
        if content in self._kept:
            self._kept.move_to_end(content)
            return self._kept[content][0]
        path = self._manifest.path(content)
        model = Model.load(path)
        self._kept[content] = (model, path.stat().st_size)
        while len(self._kept) > 1 and sum(size for _, size in self._kept.values()) > self._memory:
            self._kept.popitem(last=False)
        return model

    def __iter__(self) -> Iterator[str]:
        return iter(self._manifest.keys())

    def __len__(self) -> int:
        return len(self._manifest.keys())

    def __contains__(self, key: object) -> bool:
        return key in self._manifest.keys()

    def errors(self) -> Dict[str, str]:
        """Keys without a model, and why, as the last run has it."""
        return self._manifest.errors()

    def statistics(self, key: str) -> Mapping[str, Any]:
        """As `Model.statistics`, without loading the model."""
        return self._manifest.statistics(self._manifest.content(key))


def open(folder: _Path, *, memory: int = 2**31) -> Fleet:
    """The models that `learn` left in a folder, by key.

    folder: of `learn`.
    memory: most bytes of model files that are kept at once.

    Raises OSError where there is no such folder, ValueError where its manifest is none.
    """
    return Fleet(folder, memory=memory)
