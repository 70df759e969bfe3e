"""Workers of this machine: one process per job, so that a process that dies affects no other job."""

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

# Attempts at a job: a process may die for reasons that are not its scene's.
TRIES = 3


class Pool:
    """Runs each job in a process of its own. The program that starts them needs no `if __name__ == "__main__"`."""

    def __init__(self, kind: str, workers: int, threads: int) -> None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        self.size = workers or max(1, cores // threads)
        self._kind, self._threads = kind, threads
        self._done: queue.Queue[Tuple[str, Any, Optional[str]]] = queue.Queue()
        self._lock = threading.Lock()
        self._processes: Dict[str, subprocess.Popen[bytes]] = {}
        self._closed = False

    def start(self, key: str, payload: Any) -> None:
        """Starts a job, whose outcome `wait` returns."""
        threading.Thread(target=self._attend, args=(key, payload), daemon=True).start()

    def wait(self) -> Tuple[str, Any, Optional[str]]:
        """Waits for the next job to end; returns its key, its result and its error."""
        while True:
            try:
                # Waiting in steps lets Ctrl-C through on every system.
                return self._done.get(timeout=0.2)
            except queue.Empty:
                continue

    def close(self) -> None:
        """Kills the processes that still run."""
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
    """Sends a worker its job and returns its output. Its standard input stays open until it has ended: a worker ends as soon as that
    closes, because this process is gone then."""
    assert process.stdin and process.stdout
    data = b""
    try:
        process.stdin.write(job)
        process.stdin.flush()
        data = process.stdout.read()
    except OSError:
        # The worker died before it had read its job; its status shows that.
        pass
    process.wait()
    for pipe in (process.stdin, process.stdout):
        with contextlib.suppress(OSError):
            pipe.close()
    return data
