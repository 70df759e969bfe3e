"""Fixtures of the tests: small built-in scenes and models, learned once."""

import signal
from typing import Any, Callable

import numpy as np
import numpy.typing as npt
import pytest

import extricate

# A process that was started in the background may ignore interrupts. Those that the tests send would then have no effect, and calls
# that they should end would run for hours.
signal.signal(signal.SIGINT, signal.default_int_handler)

LABELS = 20_000


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
