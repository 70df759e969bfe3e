"""The work of one job: `work` learns a scene or queries a model. As a program (`python -m extricate.fleet._work`) this reads one job
from standard input and writes its outcome to standard output, both pickled. It ends as soon as standard input closes."""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
from typing import Any, Dict, Tuple


def work(kind: str, payload: Dict[str, Any], threads: int) -> Tuple[Any, ...]:
    """Does a job; raises the exceptions of its calls."""
    from .._extricate import Model, learn

    started = time.perf_counter()
    if kind == "learn":
        model = learn(payload["scene"], threads=threads, **payload["options"])
        return model.to_bytes(), model.statistics, time.perf_counter() - started
    source = payload["model"]
    model = Model.from_bytes(source) if isinstance(source, bytes) else Model.load(source)
    return model.query_batch(payload["rows"], threads=threads, **payload["options"]), time.perf_counter() - started


def described(error: BaseException) -> str:
    """Describes a failure in one line."""
    return f"{type(error).__name__}: {error}"


def _end_with_the_run() -> None:
    """Ends this process once its standard input closes, because the process that started it is gone then."""
    # `sys.stdin` would hold a lock that blocks the normal end of this process.
    os.read(0, 1)
    os._exit(1)


def main() -> None:
    """Reads one job from standard input, does it and writes the outcome."""
    # Output that libraries print must not mix with the bytes of the result.
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
