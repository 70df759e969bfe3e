"""A process of `_pool`: a program (`python -m extricate._worker`) that does jobs from its standard input, one after another, and writes
the outcome of each to its standard output, all pickled. It ends as soon as its standard input closes, even in the middle of a job: the
process that started it is gone then."""

from __future__ import annotations

import os
import pickle
import queue
import threading

from ._pool import Outcome, caught


def main() -> None:
    """Does jobs until standard input closes."""
    # Output that libraries print must not mix with the bytes of the results.
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def read() -> None:
        given = os.fdopen(0, "rb", closefd=False)
        try:
            while True:
                jobs.put(pickle.load(given))
        finally:
            os._exit(1)

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            function, args = pickle.loads(jobs.get())
        except Exception as error:  # A job may need a module that this process cannot import.
            outcome: Outcome = None, f"{type(error).__name__}: {error}"
        else:
            outcome = caught(function, *args)
        pickle.dump(outcome, out)
        out.flush()


if __name__ == "__main__":
    main()
