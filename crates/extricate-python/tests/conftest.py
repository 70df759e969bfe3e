"""Fixtures of the tests: small built-in scenes and models, learned once."""

import signal
import time
from typing import Any, Callable

import numpy as np
import numpy.typing as npt
import pytest

import extricate

# A process that was started in the background may ignore interrupts. Those that the tests send would then have no effect, and calls
# that they should end would run for hours.
signal.signal(signal.SIGINT, signal.default_int_handler)

LABELS = 20_000
# Seconds that a node of Ray may take to start. Ray's own limit is 30, which a busy machine exceeds.
RAY_START_SECONDS = 300


def batch_of(asked: Any) -> Callable[..., npt.NDArray[np.void]]:
    """Returns the method of a scene, a model or a solver that answers many queries."""
    batch: Callable[..., npt.NDArray[np.void]] = asked.batch if isinstance(asked, extricate.Solver) else asked.query_batch
    return batch


@pytest.fixture(scope="session")
def planar() -> extricate.Scene:
    return extricate.Scene.builtin("planar-arm")


@pytest.fixture(scope="session")
def model(planar: extricate.Scene) -> extricate.Model:
    return extricate.learn(planar, labels=LABELS, seed=3)


@pytest.fixture(scope="session")
def arm() -> extricate.Scene:
    return extricate.Scene.builtin("shelf-arm")


@pytest.fixture
def patient_ray(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gives nodes of Ray `RAY_START_SECONDS` to start."""
    # These are for the processes of a node; they are read when such a process starts.
    monkeypatch.setenv("RAY_gcs_server_port_wait_time_s", str(RAY_START_SECONDS))
    monkeypatch.setenv("RAY_worker_register_timeout_seconds", str(RAY_START_SECONDS))
    monkeypatch.setenv("RAY_agent_register_timeout_ms", str(1000 * RAY_START_SECONDS))

    from ray._private import services

    # The program that starts a node asks for it again and again. It gives up after 30 s, which no setting changes.
    get_node = services.get_node

    def get_node_at_last(*args: Any) -> Any:
        until = time.monotonic() + RAY_START_SECONDS
        while True:
            try:
                return get_node(*args)
            except RuntimeError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.5)

    monkeypatch.setattr(services, "get_node", get_node_at_last)
