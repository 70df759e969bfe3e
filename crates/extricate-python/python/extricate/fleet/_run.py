"""The loop of a run: starts jobs while workers are free, and yields the outcome of each."""

from __future__ import annotations

import dataclasses
from typing import Any, Callable, Iterator, Optional, Tuple, Union

from .._progress import Bar
from . import _local


@dataclasses.dataclass(frozen=True)
class Job:
    """Work on one key; without a payload, its result or error is known already."""

    key: str
    payload: Any = None
    result: Any = None
    error: Optional[str] = None


@dataclasses.dataclass(frozen=True)
class Progress:
    """How far a run over many scenes is.

    done: scenes that are finished, failed ones among them.
    failed: those that failed.
    total: all of them.
    """

    done: int
    failed: int
    total: int

    @property
    def fraction(self) -> float:
        """Share of the scenes that are finished."""
        return self.done / self.total if self.total else 1.0

    @property
    def stage(self) -> str:
        """The state of the run in words."""
        failed = f", {self.failed} failed" if self.failed else ""
        return f"{self.done} of {self.total} scenes{failed}"


Tell = Union[bool, Callable[[Progress], Any]]
# Key, result and error of a job; one of the last two is None.
Outcome = Tuple[str, Any, Optional[str]]


def run(
    kind: str, jobs: Iterator[Job], total: int, on: Optional[str], workers: int, threads: int, progress: Optional[Tell]
) -> Iterator[Outcome]:
    """Runs all jobs and yields the outcome of each. Jobs are taken from the iterator as workers become free."""
    if on not in (None, "ray"):
        raise ValueError(f'on: got {on!r}, expected None or "ray"')
    for name, value, least in (("workers", workers, 0), ("threads", threads, 1)):
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise ValueError(f"{name}: got {value!r}, expected a whole number of at least {least}")
    pool: Any
    if on == "ray":
        from . import _cluster

        pool = _cluster.Pool(kind, workers, threads)
    else:
        pool = _local.Pool(kind, workers, threads)
    bar = Bar() if progress is True else None
    # `Bar` reads only the fraction and the stage of a state, which `Progress` here has too.
    tell: Any = bar or (progress if callable(progress) else None)
    done = failed = 0
    finished = False
    try:
        for key, result, error in _outcomes(pool, jobs):
            done += 1
            failed += error is not None
            yield key, result, error
            if tell:
                # The first job of a model finishes all keys that share it, so jobs may exceed the total.
                tell(Progress(min(done, total), failed, total))
        finished = True
    finally:
        pool.close()
        if bar:
            bar.close(finished)


def _outcomes(pool: Any, jobs: Iterator[Job]) -> Iterator[Outcome]:
    running, exhausted = 0, False
    while True:
        while not exhausted and running < pool.size:
            job = next(jobs, None)
            if job is None:
                exhausted = True
            elif job.payload is None:
                yield job.key, job.result, job.error
            else:
                pool.start(job.key, job.payload)
                running += 1
        if running == 0:
            return
        running -= 1
        yield pool.wait()
