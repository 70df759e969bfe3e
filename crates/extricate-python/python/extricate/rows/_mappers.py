"""What is done with rows: callable classes that map a dictionary of arrays to one."""

from __future__ import annotations

import functools
import os
import pathlib
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple, Union

import numpy as np

from .._extricate import Model, Scene, Solver
from .._folder import digest
from .._grasp import Grasp
from .._motion import Repaired
from .._parts import Mesh, Obstacle
from .._tensors import maker, to_numpy
from ._columns import Array, Reasons, column, length, objects, reason_of, sifted, table
from ._hands import Hands

Path = Union[str, "os.PathLike[str]"]
Results = Dict[str, Array]


class _UnusableObject(Exception):
    """An object that no row can hold."""


def _load(scene: Union[str, bytes, None], model: Union[str, bytes, None]) -> Solver:
    """Returns the solver of a scene and a model, each a path or bytes."""
    learned = None if model is None else Model.from_bytes(model) if isinstance(model, bytes) else Model.load(model)
    if scene is None:
        assert learned
        return Solver(learned.scene, learned)
    return Solver(Scene._from_bytes(scene) if isinstance(scene, bytes) else Scene.load(scene), learned)


# A process loads what it uses once.
_loaded = functools.lru_cache(maxsize=4)(_load)


class Mapper:
    """A function of columns, which loads its scene once in each process that it comes to. It pickles."""

    def __init__(
        self,
        scene: Union[Scene, Path, None] = None,
        *,
        model: Union[Model, bytes, Path, None] = None,
        q: Union[str, Hands] = "q",
        threads: int = 1,
        **options: Any,
    ) -> None:
        """scene: a `Scene`, or the path of a scene or URDF file; None takes that of the model.
        model: a `Model`, its bytes, or the path of its file; None for none.
        q: name of the column of configurations (n, nq), or `rows.Hands` for hands as data sets store them.
        threads: of each call.
        options: as the call takes them that the class is named after.
        """
        if scene is None and model is None:
            raise ValueError("scene: got None, expected a scene or a model")
        content = scene.__reduce__()[1][0] if isinstance(scene, Scene) else scene
        learned = model.to_bytes() if isinstance(model, Model) else model
        # Workers may have another working directory.
        self._scene = content if isinstance(content, (bytes, type(None))) else os.path.abspath(content)
        self._model = learned if isinstance(learned, (bytes, type(None))) else os.path.abspath(learned)
        self._q, self._options = q, options
        self._ready: Optional[Solver] = None
        self.threads = threads

    def __getstate__(self) -> Dict[str, Any]:
        return {**self.__dict__, "_ready": None}

    def digest(self) -> str:
        """Hashes all that results depend on: the scene, the model, the options and the version."""
        scene = self._scene
        if isinstance(scene, str):
            scene = Scene.load(scene).__reduce__()[1][0]
        model = pathlib.Path(self._model).read_bytes() if isinstance(self._model, str) else self._model
        return digest([type(self).__name__, repr(self._q), self._settings()], scene or b"", model or b"")

    def __call__(self, batch: Mapping[str, Any]) -> Dict[str, Any]:
        """Maps columns to columns: those of `batch`, and the results. A result replaces a column of its name.

        The column `error` says why a row has no result, and is empty for the others; floats of such a row are nan. A row that has
        an `error` already keeps it, and is not worked on. If the configurations are tensors of another package, so are results.

        Raises ValueError for a column that is missing or of another shape, and for options that make no sense.
        """
        solver = self._solver()
        rows = max((length(values) for values in batch.values()), default=0)
        reasons: Reasons = {place: str(said) for place, said in enumerate(batch["error"]) if said} if "error" in batch else {}
        # Of rows that all are spoiled, as lines that are no JSON, columns may be missing.
        given = self._given(solver, batch, reasons) if len(reasons) < rows else np.zeros((rows, solver.scene.nq))
        places = np.array([place for place in range(rows) if place not in reasons], dtype=np.int64)
        found = self._results(solver, given[places], batch, places, reasons)
        made = maker(batch.get(self._q) if isinstance(self._q, str) else None)
        results = {name: made(_spread(values, places, rows)) for name, values in found.items()}
        return {**batch, **results, "error": np.array([reasons.get(place, "") for place in range(rows)], dtype=np.str_)}

    def _solver(self) -> Solver:
        if self._ready is None:
            solver = _loaded(self._scene, self._model)
            self._check(solver)
            self._ready = solver
        return self._ready

    def _given(self, solver: Solver, batch: Mapping[str, Any], reasons: Reasons) -> Array:
        """Returns the configurations (n, nq); adds the rows that are none to `reasons`."""
        if isinstance(self._q, str):
            found, wrong = table(self._q, column(batch, self._q), (solver.scene.nq,))
        else:
            found, wrong = self._q.configurations(solver.scene, batch)
        for place, reason in wrong.items():
            reasons.setdefault(place, reason)
        return found

    def _settings(self) -> Any:
        """Returns what results depend on besides scene, model and columns."""
        return self._options

    def _check(self, solver: Solver) -> None:
        """Raises an exception for options that make no sense: they are no fault of a row."""
        raise NotImplementedError

    def _results(
        self, solver: Solver, Q: Array, batch: Mapping[str, Any], places: Array, reasons: Reasons
    ) -> Results:
        """Returns results for the rows at `places`, whose configurations are Q; adds rows without one to `reasons`."""
        raise NotImplementedError


def _spread(values: Array, places: Array, rows: int) -> Array:
    """Returns the values of the rows at `places` as those of all rows; the others are nan, 0 or False."""
    if len(places) == rows:
        return np.ascontiguousarray(values)
    found: Array = np.zeros((rows, *values.shape[1:]), dtype=values.dtype)
    if values.dtype.kind == "f":
        found[:] = np.nan
    elif values.dtype == object:
        found = objects([np.zeros((0, 0))] * rows)
    found[places] = values
    return found


class Query(Mapper):
    """Finds the nearest free configurations. Results: the fields of `Solver.batch`, such as depth, lower_bound and witness (n, nq).

    options: as `Solver.batch` takes them.
    """

    def _check(self, solver: Solver) -> None:
        solver.batch(np.zeros((0, solver.scene.nq)), **self._options)

    def _results(
        self, solver: Solver, Q: Array, batch: Mapping[str, Any], places: Array, reasons: Reasons
    ) -> Results:
        answers = solver.batch(Q, threads=self.threads, **{**self._options, "errors": "mask"})
        for at in np.flatnonzero(np.isinf(answers["depth"])):
            reasons[int(places[at])] = "nothing free was found"
        raising = {**self._options, "errors": "raise"}
        _, wrong = sifted(lambda at: solver.batch(Q[at], **raising), np.flatnonzero(np.isnan(answers["depth"])))
        reasons.update((int(places[at]), reason) for at, reason in wrong.items())
        return {name: answers[name] for name in answers.dtype.names or ()}


class Check(Mapper):
    """Labels configurations. Results: free, bool (n,), and clearance, the least signed distance of any checked pair (n,) [m]."""

    def _check(self, solver: Solver) -> None:
        if self._options:
            raise TypeError(f"got an unexpected keyword argument {next(iter(self._options))!r}")

    def _results(
        self, solver: Solver, Q: Array, batch: Mapping[str, Any], places: Array, reasons: Reasons
    ) -> Results:
        free, clearance = np.zeros(len(Q), dtype=bool), np.full(len(Q), np.nan)
        good, wrong = sifted(lambda at: solver.check(Q[at], threads=self.threads), np.arange(len(Q)))
        for at, labels in good:
            free[at] = labels
            clearance[at] = solver.scene.distances(Q[at], threads=self.threads)
        reasons.update((int(places[at]), reason) for at, reason in wrong.items())
        return {"free": free, "clearance": clearance}


class Distance(Mapper):
    """Measures signed distances. Results: the fields of `Solver.signed_distance`, such as distance, bound and witness (n, nq).

    options: as `Solver.signed_distance` takes them.
    """

    def _check(self, solver: Solver) -> None:
        solver.signed_distance(np.zeros((0, solver.scene.nq)), **self._options)

    def _results(
        self, solver: Solver, Q: Array, batch: Mapping[str, Any], places: Array, reasons: Reasons
    ) -> Results:
        def call(at: Array) -> Array:
            found: Array = solver.signed_distance(Q[at], threads=self.threads, **self._options)
            return found

        measured = call(np.arange(0))
        distances = np.zeros(len(Q), dtype=measured.dtype)
        for name in ("distance", "bound", "witness", "gradient"):
            distances[name] = np.nan
        # A call with a spoiled row measures others in vain. Rows that no call takes are sifted apart.
        fits = (np.abs(Q) <= 1e9).all(axis=1)
        for some in (np.flatnonzero(fits), np.flatnonzero(~fits)):
            good, wrong = sifted(call, some)
            for at, found in good:
                distances[at] = found
                for row in at[np.isnan(found["distance"])]:
                    reasons[int(places[row])] = "nothing free was found"
            reasons.update((int(places[at]), reason) for at, reason in wrong.items())
        return {name: distances[name] for name in distances.dtype.names or ()}


class Release(Mapper):
    """Releases hands from the objects that they penetrate. Results: config (n, nq), moved, verified, fingers and kept_fingers
    (fingers that touched, and of those that still do), kept_sides, depth_before [m], epsilon, force_closure and checks, as in `Grasp`.

    With `q=rows.Hands(..)` the columns of the stored hands become those of the released ones.
    """

    def __init__(
        self,
        scene: Union[Scene, Path, None] = None,
        *,
        object: Union[str, Obstacle, None] = None,
        objects: Optional[Path] = None,
        **settings: Any,
    ) -> None:
        """object: what all rows hold: the name of an obstacle of the scene, or an obstacle that is not in it.
        objects: in place of `object`, the folder of the meshes that the column `object` names; the column `scale`, if there is one,
            scales them.
        settings: as in `Query`; options as `Scene.release` takes them.
        """
        super().__init__(scene, **settings)
        if (object is None) == (objects is None):
            raise ValueError(f"object: got {'both' if objects else 'neither'}, expected `object` or `objects`")
        self._object, self._objects = object, None if objects is None else os.path.abspath(objects)

    def _settings(self) -> Any:
        held: Any = self._object
        if not isinstance(held, (str, type(None))):
            # The scene with the object in it holds all that is in the object's files.
            held = digest(None, self._solver().scene.with_obstacles([held]).__reduce__()[1][0])
        return [self._options, held, bool(self._objects)]

    def _check(self, solver: Solver) -> None:
        held: Union[str, List[Obstacle]] = self._object if isinstance(self._object, str) else []
        solver.release(np.zeros((0, solver.scene.nq)), object=held, **self._options)

    def _held(self, batch: Mapping[str, Any], places: Array, reasons: Reasons) -> List[Tuple[Any, Array]]:
        """Returns the objects that the rows at `places` hold, each with the indices into `places` of its rows."""
        if self._objects is None or not len(places):
            return [(self._object or [], np.arange(len(places)))]
        names = to_numpy("object", column(batch, "object"))[places]
        scales = to_numpy("scale", batch["scale"])[places] if "scale" in batch else np.ones(len(places))
        groups: Dict[Tuple[str, float], List[int]] = {}
        for at, (name, scale) in enumerate(zip(names, scales)):
            path = pathlib.PurePosixPath(str(name).replace("\\", "/"))
            if name is None or path.is_absolute() or ".." in path.parts:
                reasons[int(places[at])] = f"object: got {str(name)!r}, expected a file below {self._objects}"
                continue
            try:
                groups.setdefault((str(path), float(scale)), []).append(at)
            except (TypeError, ValueError):
                reasons[int(places[at])] = f"scale: got {str(scale)!r}, expected a number"
        return [
            (Mesh(os.path.join(self._objects, name), scale=scale), np.array(rows)) for (name, scale), rows in groups.items()
        ]

    def _results(
        self, solver: Solver, Q: Array, batch: Mapping[str, Any], places: Array, reasons: Reasons
    ) -> Results:
        grasps: List[Optional[Grasp]] = [None] * len(Q)
        for held, rows in self._held(batch, places, reasons):

            def call(at: Array) -> List[Optional[Grasp]]:
                try:
                    found: List[Optional[Grasp]] = solver.release(Q[at], object=held, threads=self.threads, **self._options)
                except (OSError, ValueError) as error:
                    if str(error).startswith("Q"):
                        raise
                    raise _UnusableObject(reason_of(error)) from None
                return found

            try:
                good, wrong = sifted(call, rows)
            except _UnusableObject as error:
                good, wrong = [], {int(row): str(error) for row in rows}
            for at, found in good:
                for row, grasp in zip(at, found):
                    grasps[row] = grasp
                    if grasp is None:
                        reasons[int(places[row])] = "nothing free was found"
            reasons.update((int(places[row]), reason) for row, reason in wrong.items())
        return _columns(solver.scene.nq, grasps)

    def __call__(self, batch: Mapping[str, Any]) -> Dict[str, Any]:
        found = super().__call__(batch)
        if isinstance(self._q, Hands) and (found["error"] == "").any():
            found.update(self._q.stored(self._solver().scene, batch, found["config"]))
        return found


def _columns(nq: int, grasps: List[Optional[Grasp]]) -> Results:
    """Returns the results of `Release` as columns."""

    def gathered(kind: Any, missing: Any, of: Callable[[Grasp], Any]) -> Array:
        return np.array([missing if grasp is None else of(grasp) for grasp in grasps], dtype=kind)

    def number(value: Optional[float]) -> float:
        return np.nan if value is None else value

    config = np.full((len(grasps), nq), np.nan)
    for row, grasp in enumerate(grasps):
        if grasp is not None:
            config[row] = grasp.config
    return {
        "config": config,
        "moved": gathered(np.float64, np.nan, lambda grasp: grasp.moved),
        "verified": gathered(np.bool_, False, lambda grasp: grasp.verified),
        "fingers": gathered(np.int64, 0, lambda grasp: grasp.fingers[0]),
        "kept_fingers": gathered(np.int64, 0, lambda grasp: grasp.fingers[1]),
        "kept_sides": gathered(np.bool_, False, lambda grasp: grasp.kept_sides),
        "depth_before": gathered(np.float64, np.nan, lambda grasp: grasp.depth_before),
        "epsilon": gathered(np.float64, np.nan, lambda grasp: number(grasp.epsilon)),
        "force_closure": gathered(np.bool_, False, lambda grasp: bool(grasp.force_closure)),
        "checks": gathered(np.int64, 0, lambda grasp: grasp.checks),
    }


class Repair(Mapper):
    """Repairs paths, such as clips of a motion: a row is a path. Results: points, deviation, length, length_before, stretches, gaps,
    touched, kept and checks, as in `Repaired`. The points of each row are an array (m, nq), of no rows if no path was found; with
    `frames=True` and paths (n, m, nq) they are one array (n, m, nq).

    q: name of the column of paths, "path" by default: (n, m, nq), or n arrays (m, nq) of different m.
    options: as `Scene.repair` takes them.
    """

    def __init__(self, scene: Union[Scene, Path, None] = None, *, q: str = "path", **settings: Any) -> None:
        super().__init__(scene, q=q, **settings)

    def _given(self, solver: Solver, batch: Mapping[str, Any], reasons: Reasons) -> Array:
        return objects(list(to_numpy(str(self._q), column(batch, str(self._q)))))

    def _check(self, solver: Solver) -> None:
        free = solver.scene.sample(1)[[0, 0]]
        solver.repair(free, **{**self._options, "max_checks": 1})

    def _results(
        self, solver: Solver, Q: Array, batch: Mapping[str, Any], places: Array, reasons: Reasons
    ) -> Results:
        shape = to_numpy(str(self._q), batch.get(str(self._q), ())).shape[1:]
        points = objects([np.zeros((0, solver.scene.nq))] * len(Q))
        found: List[Optional[Repaired]] = []
        for at, path in enumerate(Q):
            try:
                repaired = solver.repair(np.array(list(path), dtype=np.float64), **self._options)
                found.append(repaired)
                if repaired.points is None:
                    reasons[int(places[at])] = "no path was found"
                else:
                    points[at] = repaired.points
            except (TypeError, ValueError) as error:
                found.append(None)
                reasons[int(places[at])] = str(error)

        def gathered(name: str, kind: Any, missing: Any) -> Array:
            return np.array([missing if one is None else getattr(one, name) for one in found], dtype=kind)

        if self._options.get("frames") and len(shape) == 2:
            points = np.array([path if len(path) else np.full(shape, np.nan) for path in points]).reshape(-1, *shape)
        floats = {name: gathered(name, np.float64, np.nan) for name in ("deviation", "length", "length_before")}
        counts = {name: gathered(name, np.int64, 0) for name in ("stretches", "gaps", "touched", "kept", "checks")}
        return {"points": points, **floats, **counts}
