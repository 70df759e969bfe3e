"""What a worker does: `work` learns a scene or queries a model. As a program (`python -m extricate.fleet._work`) it reads one job from
standard input and writes what became of it to standard output, both pickled."""

from __future__ import annotations

import os
import pickle
import sys
import time
import warnings
from typing import Any, Dict, Tuple


def work(kind: str, payload: Dict[str, Any], threads: int) -> Tuple[Any, ...]:
    """Does a job; raises whatever its scene or its rows deserve."""
    started = time.perf_counter()
    if kind == "learn":
        model = _learned(payload, threads)
        return model.to_bytes(), model.statistics, time.perf_counter() - started
    from .._extricate import Model

    source = payload["model"]
    model = Model.from_bytes(source) if isinstance(source, bytes) else Model.load(source)
    return model.query_batch(payload["rows"], threads=threads, **payload["options"]), time.perf_counter() - started


def _learned(payload: Dict[str, Any], threads: int) -> Any:
    from .._extricate import learn

    scene, options = payload["scene"], dict(payload["options"])
    every = options.pop("checkpoint_every")
    # On another machine the folder may not be there; then nothing is kept.
    if not os.path.isdir(payload["folder"]):
        return learn(scene, threads=threads, **options)
    path = payload["checkpoint"]
    keep = {"checkpoint": path, "checkpoint_every": every, "threads": threads}
    with warnings.catch_warnings():
        # That a checkpoint could not be written ends no run.
        warnings.simplefilter("ignore", RuntimeWarning)
        if os.path.exists(path):
            try:
                return learn(scene, resume=True, **keep, **options)
            except (ValueError, OSError):
                # Of another version, cut short, or held by a worker that has not noticed its end.
                pass
        try:
            return learn(scene, **keep, **options)
        except OSError:
            return learn(scene, threads=threads, **options)


def described(error: BaseException) -> str:
    """What is said of a failure."""
    return f"{type(error).__name__}: {error}"


def main() -> None:
    """One job from standard input."""
    # What libraries print must not come between the bytes of the result.
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    kind, payload, threads = pickle.load(sys.stdin.buffer)
    try:
        result: Tuple[Any, Any] = (work(kind, payload, threads), None)
    except Exception as error:
        result = (None, described(error))
    pickle.dump(result, out)
    out.flush()


if __name__ == "__main__":
    main()
