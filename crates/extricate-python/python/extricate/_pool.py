"""Runs jobs on processes of this machine, on a Ray cluster, or on an executor of the caller, and yields the outcome of each."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import BrokenExecutor, Executor, Future
from typing import IO, Any, Callable, Dict, Iterator, List, Optional, Set, Tuple, Union

from ._progress import Bar

# Attempts at a job whose process or node is lost: it may be lost for reasons that are not the job's.
TRIES = 3
# Jobs that an executor of the caller has at once, if it does not tell its size.
DEFAULT_SIZE = 64
# Seconds after which the size of a cluster is read again.
SIZE_SECONDS = 1.0

On = Union[None, str, Executor]


@dataclasses.dataclass(frozen=True)
class Progress:
    """How far a run is.

    done: scenes or rows that are finished, failed ones among them.
    failed: those that failed.
    total: all of them.
    unit: what is counted: "scenes" or "rows".
    """

    done: int
    failed: int
    total: int
    unit: str

    @property
    def fraction(self) -> float:
        """Share that is finished."""
        return self.done / self.total if self.total else 1.0

    @property
    def stage(self) -> str:
        """The state of the run in words."""
        failed = f", {self.failed:,} failed" if self.failed else ""
        return f"{self.done:,} of {self.total:,} {self.unit}{failed}"


Tell = Union[bool, Callable[[Progress], Any]]
# Result and error of a job; one of them is None.
Outcome = Tuple[Any, Optional[str]]


@dataclasses.dataclass(frozen=True)
class Job:
    """A call for a tag; without a function, its result or error is known already."""

    tag: Any
    function: Optional[Callable[..., Any]] = None
    args: Tuple[Any, ...] = ()
    result: Any = None
    error: Optional[str] = None


def caught(function: Callable[..., Any], *args: Any) -> Outcome:
    """Calls a function; an exception becomes an error in one line."""
    try:
        return function(*args), None
    except Exception as error:
        return None, f"{type(error).__name__}: {error}"


@contextlib.contextmanager
def telling(progress: Optional[Tell]) -> Iterator[Callable[[Progress], Any]]:
    """Gives a function that reports progress: as a bar, to the caller's function, or to nobody."""
    if progress is not True:
        yield progress if callable(progress) else lambda state: None
        return
    bar, finished = Bar(), False
    try:
        # `Bar` reads only the fraction and the stage of a state, which `Progress` here has too.
        tell: Any = bar
        yield tell
        finished = True
    finally:
        bar.close(finished)


class Pool:
    """Where the jobs of a run are done.

    `on` is None for processes of this machine, "ray", or an executor. `workers` is how many jobs run at once, 0 for as many as there
    are cores for `threads` each.
    """

    def __init__(self, on: On, workers: int, threads: int) -> None:
        for name, value, least in (("workers", workers, 0), ("threads", threads, 1)):
            if isinstance(value, bool) or not isinstance(value, int) or value < least:
                raise ValueError(f"{name}: got {value!r}, expected a whole number of at least {least}")
        self._place: Any
        if on is None:
            self._place = _Processes(workers, threads)
        elif on == "ray":
            self._place = _Ray(workers, threads)
        elif not isinstance(on, str) and hasattr(on, "submit"):
            self._place = _Given(on, workers)
        else:
            raise ValueError(f'on: got {on!r}, expected None, "ray" or an executor of concurrent.futures')

    def share(self, value: Any) -> Any:
        """Returns what stands for `value` as an argument of many jobs."""
        return self._place.share(value)

    def outcomes(self, jobs: Iterator[Job]) -> Iterator[Tuple[Any, Any, Optional[str]]]:
        """Yields tag, result and error of each job as it ends. Jobs are taken as there is room for them.

        Raises BrokenExecutor if the caller's executor does not work any more.
        """
        done: queue.SimpleQueue[Tuple[Any, Future[Outcome]]] = queue.SimpleQueue()
        running, has_more = 0, True
        while True:
            while has_more and running < self._place.size():
                job = next(jobs, None)
                if job is None:
                    has_more = False
                elif job.function is None:
                    yield job.tag, job.result, job.error
                else:
                    future = self._place.submit(job.function, *job.args)
                    future.add_done_callback(lambda ended, tag=job.tag: done.put((tag, ended)))
                    running += 1
            if running == 0:
                return
            try:
                # Waiting in steps lets Ctrl-C through on every system, and sees a cluster grow.
                tag, ended = done.get(timeout=0.2)
            except queue.Empty:
                continue
            running -= 1
            try:
                result, error = ended.result()
            except BrokenExecutor:
                raise
            except Exception as failure:  # The job was lost too often, or its result does not pickle.
                result, error = None, f"{type(failure).__name__}: {failure}"
            yield tag, result, error

    def close(self) -> None:
        """Ends jobs that still run, as far as they can be ended."""
        self._place.close()


class _Given:
    """An executor of the caller, who also shuts it down."""

    def __init__(self, executor: Executor, workers: int) -> None:
        self._executor = executor
        # Twice as many jobs as run at once, so that no worker waits for its next one.
        self._size = workers or 2 * getattr(executor, "_max_workers", 0) or DEFAULT_SIZE
        self._running: Set[Future[Outcome]] = set()

    def size(self) -> int:
        return self._size

    def share(self, value: Any) -> Any:
        return value

    def submit(self, function: Callable[..., Any], *args: Any) -> Future[Outcome]:
        future = self._executor.submit(caught, function, *args)
        self._running.add(future)
        future.add_done_callback(self._running.discard)
        return future

    def close(self) -> None:
        for future in list(self._running):
            future.cancel()


class _Ray:
    """The cluster that Ray is connected to or `RAY_ADDRESS` names, else this machine. Ray begins a job again whose node is lost."""

    def __init__(self, workers: int, threads: int) -> None:
        try:
            self._ray: Any = importlib.import_module("ray")
        except ImportError:
            raise ImportError('on: got "ray", which is not installed: pip install "extricate[ray]"') from None
        if not self._ray.is_initialized():
            self._ray.init()
        self._workers, self._threads = workers, threads
        self._call = self._ray.remote(num_cpus=threads, max_retries=TRIES)(caught)
        self._running: Dict[Future[Outcome], Any] = {}
        self._known, self._known_until = 0, 0.0

    def size(self) -> int:
        if self._workers:
            return self._workers
        if time.monotonic() > self._known_until:
            cores = int(self._ray.cluster_resources().get("CPU", 1))
            # Twice as many jobs as run at once: no core waits for its next one, and an autoscaler sees that more would be used.
            self._known, self._known_until = max(2, 2 * cores // self._threads), time.monotonic() + SIZE_SECONDS
        return self._known

    def share(self, value: Any) -> Any:
        return self._ray.put(value)

    def submit(self, function: Callable[..., Any], *args: Any) -> Future[Outcome]:
        task = self._call.remote(function, *args)
        future: Future[Outcome] = task.future()
        self._running[future] = task
        future.add_done_callback(lambda ended: self._running.pop(ended, None))
        return future

    def close(self) -> None:
        """Cancels running jobs. The connection to Ray stays open, because others may use it."""
        for task in list(self._running.values()):
            self._ray.cancel(task, force=True)


class _Processes:
    """Processes of this machine, which do one job after another. One that dies affects no job but its own, which another process
    begins again. The program that starts them needs no `if __name__ == "__main__"`."""

    def __init__(self, workers: int, threads: int) -> None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        self._size = workers or max(1, cores // threads)
        self._jobs: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._attendants = 0
        self._lock = threading.Lock()
        self._processes: List[_Process] = []
        self._closed = False

    def size(self) -> int:
        return self._size

    def share(self, value: Any) -> Any:
        return value

    def submit(self, function: Callable[..., Any], *args: Any) -> Future[Outcome]:
        future: Future[Outcome] = Future()
        self._jobs.put((future, function, args))
        if self._attendants < self._size:
            self._attendants += 1
            threading.Thread(target=self._attend, daemon=True).start()
        return future

    def close(self) -> None:
        with self._lock:
            self._closed = True
            running = list(self._processes)
        for _ in range(self._attendants):
            self._jobs.put(None)
        for process in running:
            process.kill()

    def _attend(self) -> None:
        """Gives jobs to one process after another."""
        process: Optional[_Process] = None
        for future, function, args in iter(self._jobs.get, None):
            try:
                job = pickle.dumps((function, args))
                for _ in range(TRIES):
                    process = process or self._start()
                    if process is None:
                        outcome: Outcome = None, "the run was closed"
                        break
                    try:
                        outcome = process.do(job)
                        break
                    except (EOFError, OSError, pickle.UnpicklingError):
                        outcome = None, f"its process ended {TRIES} times, at last with {process.end()}"
                        process = None
            except Exception as failure:
                outcome = None, f"{type(failure).__name__}: {failure}"
                # What is left of a result that could not be read would be taken for the next one.
                if process:
                    process.kill()
                    process = None
            future.set_result(outcome)
        if process:
            process.kill()

    def _start(self) -> Optional[_Process]:
        with self._lock:
            if self._closed:
                return None
            self._processes = [known for known in self._processes if known.runs()]
            self._processes.append(_Process())
            return self._processes[-1]


class _Process:
    """A process that does jobs. Its standard input stays open until it ends: once that closes, the process ends itself."""

    def __init__(self) -> None:
        self._said: IO[bytes] = tempfile.TemporaryFile()
        command = [sys.executable, "-m", "extricate._worker"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said)

    def runs(self) -> bool:
        return self._process.poll() is None

    def do(self, job: bytes) -> Outcome:
        """Returns the outcome of a job. Raises EOFError, OSError or UnpicklingError if the process dies."""
        assert self._process.stdin and self._process.stdout
        pickle.dump(job, self._process.stdin)
        self._process.stdin.flush()
        outcome: Outcome = pickle.load(self._process.stdout)
        return outcome

    def end(self) -> str:
        """Waits for the end of a process that died; says how it ended."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout=5)
        self.kill()
        self._said.seek(0)
        said = self._said.read().decode(errors="replace")
        return f"status {self._process.returncode}: {said[-400:].strip() or 'it said nothing'}"

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe:
                with contextlib.suppress(OSError):
                    pipe.close()
