"""Workers of a Ray cluster. Ray restarts a task elsewhere if its node is lost."""

from __future__ import annotations

import importlib
from typing import Any, Dict, Optional, Tuple

from ._work import described, work

# Number of times that Ray restarts a task whose worker or node is lost.
RETRIES = 3


def _caught(kind: str, payload: Dict[str, Any], threads: int) -> Tuple[Any, Optional[str]]:
    try:
        return work(kind, payload, threads), None
    except Exception as error:
        return None, described(error)


class Pool:
    """Runs tasks on the cluster that Ray is connected to or `RAY_ADDRESS` names, else on this machine."""

    def __init__(self, kind: str, workers: int, threads: int) -> None:
        try:
            self._ray: Any = importlib.import_module("ray")
        except ImportError:
            raise ImportError('on: got "ray", which is not installed: pip install "extricate[ray]"') from None
        if not self._ray.is_initialized():
            self._ray.init()
        cores = int(self._ray.cluster_resources().get("CPU", 1))
        # Twice as many tasks as run at once, so that no core waits for its next one, also if the cluster grows.
        self.size = workers or max(2, 2 * cores // threads)
        self._kind, self._threads = kind, threads
        self._task = self._ray.remote(num_cpus=threads, max_retries=RETRIES)(_caught)
        self._keys: Dict[Any, str] = {}

    def start(self, key: str, payload: Any) -> None:
        """Starts a job, whose outcome `wait` returns."""
        self._keys[self._task.options(name=f"extricate {self._kind} {key}").remote(self._kind, payload, self._threads)] = key

    def wait(self) -> Tuple[str, Any, Optional[str]]:
        """Waits for the next job to end; returns its key, its result and its error."""
        done = self._ray.wait(list(self._keys), num_returns=1)[0][0]
        key = self._keys.pop(done)
        try:
            result, error = self._ray.get(done)
        except Exception as failure:  # The task was lost too often, or ran out of memory.
            return key, None, described(failure)
        return key, result, error

    def close(self) -> None:
        """Cancels running tasks. The connection to Ray stays open, because others may use it."""
        for task in self._keys:
            self._ray.cancel(task, force=True)
        self._keys.clear()
