"""Many scenes, learned and queried on many processors or machines.

    for done in extricate.fleet.learn({"panda": "panda.toml", "ur5": "ur5.toml"}, "models"):
        print(done.key, done.error or done.statistics["boundary_samples"])
    model = extricate.fleet.open("models")["panda"]

Each scene is learned in a process of this machine, with `on="ray"` on the cluster that Ray is connected to, or on an executor. What a
folder holds is not learned again. A scene that fails is reported, and the others go on. Many rows of one scene are for `rows`. Read in
this order: `learn`, `query`, `distance`, `release` and `open` here, then `_manifest` (what a folder holds).
"""

from __future__ import annotations

import dataclasses
import os
import pathlib
import reprlib
import time
from collections import OrderedDict
from typing import Any, Callable, Dict, Iterator, Mapping, Optional, Tuple, Type, Union

import numpy as np
import numpy.typing as npt

from .. import _pool
from .._extricate import Model, Scene
from .._extricate import learn as _learn
from .._folder import digest
from .._pool import Job, On, Progress, Tell
from ..rows import Distance, Query, Release
from ._manifest import Manifest

__all__ = ["Answered", "Fleet", "Learned", "Progress", "distance", "learn", "open", "query", "release"]

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
    """What became of the rows of one scene.

    key: as in the call.
    answers: results by name, an array each, as `rows.Query`, `rows.Distance` and `rows.Release` give them; its `error` says which rows are spoiled.
        None where there are none.
    error: why there are none; None where there are.
    seconds: what they took on their worker.
    """

    key: str
    answers: Optional[Dict[str, npt.NDArray[Any]]]
    error: Optional[str]
    seconds: float


def learn(
    scenes: Mapping[str, _Scene],
    folder: _Path,
    *,
    on: On = None,
    workers: int = 0,
    threads: int = 1,
    progress: Optional[Tell] = None,
    **options: Any,
) -> Iterator[Learned]:
    """Learns a model of every scene that `folder` has none of; yields each as it is done.

    scenes: by key: a `Scene`, the path of a scene file, or a function that makes the scene when its place comes. Equal scenes are
        learned once.
    folder: for models and a manifest; made where it is missing.
    on: None for processes of this machine, "ray" for the cluster that Ray is connected to (`pip install extricate[ray]`), or an
        `Executor` of concurrent.futures, such as `get_executor()` of a client of Dask.
    workers: how many scenes at once; 0 for one per `threads` cores, or for what the cluster has, however it grows.
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
    return _held(dict(scenes), manifest, (on, workers, threads), progress, given)


def _texts(name: str, mapping: Mapping[str, Any]) -> None:
    """Raises TypeError for a key that is no text, which the manifest could not keep."""
    for key in mapping:
        if not isinstance(key, str):
            raise TypeError(f"{name}: got the key {reprlib.repr(key)}, expected text")


def _held(
    scenes: Dict[str, _Scene], manifest: Manifest, how: Tuple[On, int, int], progress: Optional[Tell], given: Dict[str, Any]
) -> Iterator[Learned]:
    with manifest.held():
        yield from _learned(scenes, manifest, how, progress, given)


def _learned(
    scenes: Dict[str, _Scene], manifest: Manifest, how: Tuple[On, int, int], progress: Optional[Tell], given: Dict[str, Any]
) -> Iterator[Learned]:
    hashes: Dict[str, str] = {}
    # By model, the keys that wait for it while another key learns it.
    twins: Dict[str, list[str]] = {}

    def jobs() -> Iterator[Job]:
        for key, source in scenes.items():
            try:
                scene = _scene(source)
                content = digest(sorted(given.items()), scene.__reduce__()[1][0])
            except Exception as error:  # Scenes and their functions may raise anything; only this scene fails.
                yield Job(key, error=f"{type(error).__name__}: {error}")
                continue
            hashes[key] = content
            if manifest.has(content):
                yield Job(key, result=(manifest.statistics(content), 0.0))
            elif content in twins:
                twins[content].append(key)
            else:
                twins[content] = []
                yield Job(key, _model, (scene, given, how[2]))

    for key, result, error in _outcomes(jobs(), len(scenes), how, progress):
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


def _model(scene: Scene, options: Dict[str, Any], threads: int) -> Tuple[bytes, Dict[str, Any], float]:
    """Learns a scene on a worker; returns the model, its statistics and the seconds."""
    started = time.perf_counter()
    model = _learn(scene, threads=threads, **options)
    return model.to_bytes(), model.statistics, time.perf_counter() - started


def _outcomes(
    jobs: Iterator[Job], total: int, how: Tuple[On, int, int], progress: Optional[Tell]
) -> Iterator[Tuple[str, Any, Optional[str]]]:
    """Runs jobs, one for each key, and reports progress."""
    pool = _pool.Pool(*how)
    done = failed = 0
    try:
        with _pool.telling(progress) as tell:
            for key, result, error in pool.outcomes(jobs):
                done += 1
                failed += error is not None
                yield key, result, error
                # The first job of a model finishes all keys that share it, so jobs may exceed the total.
                tell(Progress(min(done, total), failed, total, "scenes"))
    finally:
        pool.close()


def _scene(source: _Scene) -> Scene:
    if isinstance(source, Scene):
        return source
    if callable(source):
        return _scene(source())
    return Scene.load(os.fspath(source))


def query(
    scenes: Union[_Path, Mapping[str, _Scene]],
    queries: Mapping[str, npt.ArrayLike],
    *,
    on: On = None,
    workers: int = 0,
    threads: int = 1,
    progress: Optional[Tell] = None,
    **options: Any,
) -> Iterator[Answered]:
    """Queries many scenes, each with its own configurations; yields the answers of each as they are there.

    scenes: the folder of `learn`, whose models answer; or scenes by key as `learn` takes them, which answer without a model.
    queries: by key: float64 (n, nq), as `rows.Query` takes them.
    on, workers, threads, progress: as in `learn`. Answers do not depend on them.
    options: as `Solver.batch` takes them.

    Whatever fails is the `error` of its `Answered`: no such scene, rows of another length. Raises TypeError for keys that are not
    text, OSError and ValueError as `open`.
    """
    return _answered(Query, "queries", scenes, queries, (on, workers, threads), progress, options)


def distance(
    scenes: Union[_Path, Mapping[str, _Scene]],
    configurations: Mapping[str, npt.ArrayLike],
    *,
    on: On = None,
    workers: int = 0,
    threads: int = 1,
    progress: Optional[Tell] = None,
    **options: Any,
) -> Iterator[Answered]:
    """Measures signed distances in many scenes; yields those of each as they are there.

    scenes: as in `query`.
    configurations: by key: float64 (n, nq), as `rows.Distance` takes them.
    on, workers, threads, progress: as in `learn`. Distances do not depend on them.
    options: as `Solver.signed_distance` takes them.

    Errors are those of `query`.
    """
    return _answered(Distance, "configurations", scenes, configurations, (on, workers, threads), progress, options)


def release(
    scenes: Union[_Path, Mapping[str, _Scene]],
    hands: Mapping[str, npt.ArrayLike],
    *,
    on: On = None,
    workers: int = 0,
    threads: int = 1,
    progress: Optional[Tell] = None,
    **options: Any,
) -> Iterator[Answered]:
    """Releases the hands of many scenes from their objects; yields the answers of each as they are there.

    scenes: as in `query`; models are not used.
    hands: by key: float64 (n, nq), as `rows.Release` takes them.
    on, workers, threads, progress: as in `learn`. Answers do not depend on them.
    options: `object`, and others as `Scene.release` takes them.

    Errors are those of `query`.
    """
    return _answered(Release, "hands", scenes, hands, (on, workers, threads), progress, options)


def _answered(
    kind: Type[Union[Query, Distance, Release]],
    name: str,
    scenes: Union[_Path, Mapping[str, _Scene]],
    given: Mapping[str, npt.ArrayLike],
    how: Tuple[On, int, int],
    progress: Optional[Tell],
    options: Dict[str, Any],
) -> Iterator[Answered]:
    _texts(name, given)
    manifest = None if isinstance(scenes, Mapping) else Manifest(pathlib.Path(scenes), make=False)

    def jobs() -> Iterator[Job]:
        for key, rows in given.items():
            try:
                if isinstance(scenes, Mapping):
                    mapper = kind(_scene(scenes[key]), threads=how[2], **options)
                else:
                    assert manifest
                    path = manifest.path(manifest.content(key))
                    # Workers elsewhere do not see the folder.
                    mapper = kind(model=path if how[0] is None else path.read_bytes(), threads=how[2], **options)
                yield Job(key, _rows, (mapper, np.asarray(rows)))
            except Exception as error:
                yield Job(key, error=f"{type(error).__name__}: {error}")

    for key, result, error in _outcomes(jobs(), len(given), how, progress):
        answers, seconds = result if error is None else (None, 0.0)
        yield Answered(key, answers, error, seconds)


def _rows(mapper: Union[Query, Distance, Release], rows: npt.NDArray[Any]) -> Tuple[Dict[str, npt.NDArray[Any]], float]:
    """Maps the rows of a key on a worker; returns the results and the seconds."""
    started = time.perf_counter()
    found = mapper({"q": rows})
    return {name: values for name, values in found.items() if name != "q"}, time.perf_counter() - started


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
        return self._manifest.size()

    def __contains__(self, key: object) -> bool:
        return self._manifest.has_key(key)

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
