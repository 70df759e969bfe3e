"""What a worker does: `work` learns a scene or queries a model. As a program (`python -m extricate.fleet._work`) it reads one job from
standard input and writes what became of it to standard output, both pickled. It ends as soon as standard input closes."""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
import warnings
from typing import Any, Dict, Tuple

# How long a worker waits for another one that holds the same checkpoint [s]: that one ends by itself once its run is gone.
PATIENCE = 10.0
# What `learn` says then.
HELD = "another run writes it"


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
    until, begins_anew = time.monotonic() + PATIENCE, False
    with warnings.catch_warnings():
        # That a checkpoint could not be written ends no run.
        warnings.simplefilter("ignore", RuntimeWarning)
        while True:
            resume = not begins_anew and os.path.exists(path)
            try:
                return learn(scene, resume=resume, **keep, **options)
            except ValueError:
                if not resume:
                    raise
                # The checkpoint is of another version, or cut short.
                begins_anew = True
            except OSError as error:
                if HELD in str(error) and time.monotonic() < until:
                    time.sleep(0.1)
                elif resume:
                    begins_anew = True
                else:
                    return learn(scene, threads=threads, **options)


def described(error: BaseException) -> str:
    """What is said of a failure."""
    return f"{type(error).__name__}: {error}"


def _end_with_the_run() -> None:
    """Ends this process once its standard input closes: whoever started it keeps that open, and is gone then."""
    # Not by `sys.stdin`, whose lock would be in the way when this process ends in the usual way.
    os.read(0, 1)
    os._exit(1)


def main() -> None:
    """One job from standard input."""
    # What libraries print must not come between the bytes of the result.
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    kind, payload, threads = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_the_run, daemon=True).start()
    try:
        result: Tuple[Any, Any] = (work(kind, payload, threads), None)
    except Exception as error:
        result = (None, described(error))
    pickle.dump(result, out)
    out.flush()


if __name__ == "__main__":
    main()
