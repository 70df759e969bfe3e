"""Workers of this machine: a process a job, so that one which dies takes no other with it."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import subprocess
import sys
import tempfile
import threading
from typing import Any, Dict, Optional, Tuple

# A process that dies is no fault of its scene the first time.
TRIES = 3


class Pool:
    """Processes that each do one job. They need no `if __name__ == "__main__"` of the program that starts them."""

    def __init__(self, kind: str, workers: int, threads: int) -> None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        self.size = workers or max(1, cores // threads)
        self._kind, self._threads = kind, threads
        self._done: queue.Queue[Tuple[str, Any, Optional[str]]] = queue.Queue()
        self._lock = threading.Lock()
        self._processes: Dict[str, subprocess.Popen[bytes]] = {}
        self._closed = False

    def start(self, key: str, payload: Any) -> None:
        """Begins a job, whose end `wait` tells."""
        threading.Thread(target=self._attend, args=(key, payload), daemon=True).start()

    def wait(self) -> Tuple[str, Any, Optional[str]]:
        """The next job that ended: its key, its result, or what went wrong."""
        while True:
            try:
                # In steps, so that Ctrl-C is noticed on every system.
                return self._done.get(timeout=0.2)
            except queue.Empty:
                continue

    def close(self) -> None:
        """Ends what still runs."""
        with self._lock:
            self._closed = True
            running = list(self._processes.values())
        for process in running:
            process.kill()
        for process in running:
            process.wait()

    def _attend(self, key: str, payload: Any) -> None:
        result: Any = None
        error: Optional[str] = "the run was closed"
        try:
            job = pickle.dumps((self._kind, payload, self._threads))
            for _ in range(TRIES):
                code, said, data = self._once(key, job)
                if code == 0:
                    result, error = pickle.loads(data)
                    break
                if self._closed:
                    break
                error = f"its process ended with status {code}, {TRIES} times: {said[-400:].strip() or 'it said nothing'}"
        except Exception as failure:
            result, error = None, f"{type(failure).__name__}: {failure}"
        self._done.put((key, result, error))

    def _once(self, key: str, job: bytes) -> Tuple[int, str, bytes]:
        with tempfile.TemporaryFile() as said:
            with self._lock:
                if self._closed:
                    return 1, "", b""
                process = subprocess.Popen(
                    [sys.executable, "-m", "extricate.fleet._work"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=said
                )
                self._processes[key] = process
            data = _exchanged(process, job)
            with self._lock:
                self._processes.pop(key, None)
            said.seek(0)
            return process.returncode, said.read().decode(errors="replace"), data


def _exchanged(process: subprocess.Popen[bytes], job: bytes) -> bytes:
    """What a worker answers to its job. Its standard input stays open until it has ended: a worker whose standard input closes
    knows that this process is gone, however it ended, and ends too."""
    assert process.stdin and process.stdout
    data = b""
    try:
        process.stdin.write(job)
        process.stdin.flush()
        data = process.stdout.read()
    except OSError:
        # The worker died before it had read its job, which its status tells.
        pass
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):
            pipe.close()
    return data
