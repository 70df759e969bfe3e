"""Workers of a Ray cluster. A task whose node is lost is begun again elsewhere, by Ray."""

from __future__ import annotations

import importlib
from typing import Any, Dict, Optional, Tuple

from ._work import described, work

# As many times Ray begins a task again whose worker or node is lost.
RETRIES = 3


def _caught(kind: str, payload: Dict[str, Any], threads: int) -> Tuple[Any, Optional[str]]:
    try:
        return work(kind, payload, threads), None
    except Exception as error:
        return None, described(error)


class Pool:
    """Tasks on the cluster that Ray is connected to, or `RAY_ADDRESS` names; else on this machine."""

    def __init__(self, kind: str, workers: int, threads: int) -> None:
        try:
            self._ray: Any = importlib.import_module("ray")
        except ImportError:
            raise ImportError('on: got "ray", which is not installed: pip install "extricate[ray]"') from None
        if not self._ray.is_initialized():
            self._ray.init()
        cores = int(self._ray.cluster_resources().get("CPU", 1))
        # Twice as many as run at once, so that none waits for the next; a cluster may grow meanwhile.
        self.size = workers or max(2, 2 * cores // threads)
        self._kind, self._threads = kind, threads
        self._task = self._ray.remote(num_cpus=threads, max_retries=RETRIES)(_caught)
        self._keys: Dict[Any, str] = {}

    def start(self, key: str, payload: Any) -> None:
        """Begins a job, whose end `wait` tells."""
        self._keys[self._task.options(name=f"extricate {self._kind} {key}").remote(self._kind, payload, self._threads)] = key

    def wait(self) -> Tuple[str, Any, Optional[str]]:
        """The next job that ended: its key, its result, or what went wrong."""
        done = self._ray.wait(list(self._keys), num_returns=1)[0][0]
        key = self._keys.pop(done)
        try:
            result, error = self._ray.get(done)
        except Exception as failure:  # Lost too often, or out of memory.
            return key, None, described(failure)
        return key, result, error

    def close(self) -> None:
        """Ends what still runs. The connection stays: others may use it."""
        for task in self._keys:
            self._ray.cancel(task, force=True)
        self._keys.clear()
