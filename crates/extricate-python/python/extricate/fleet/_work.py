"""What a worker does: `work` learns a scene or queries a model. As a program (`python -m extricate.fleet._work`) it reads one job from
standard input and writes what became of it to standard output, both pickled. It ends as soon as standard input closes."""

from __future__ import annotations

import os
import pickle
import sys
import threading
import time
from typing import Any, Dict, Tuple


def work(kind: str, payload: Dict[str, Any], threads: int) -> Tuple[Any, ...]:
    """Does a job; raises whatever its scene or its rows deserve."""
    from .._extricate import Model, learn

    started = time.perf_counter()
    if kind == "learn":
        model = learn(payload["scene"], threads=threads, **payload["options"])
        return model.to_bytes(), model.statistics, time.perf_counter() - started
    source = payload["model"]
    model = Model.from_bytes(source) if isinstance(source, bytes) else Model.load(source)
    return model.query_batch(payload["rows"], threads=threads, **payload["options"]), time.perf_counter() - started


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
