"""What the tests share: small built-in scenes and models, learned once."""

import signal

import pytest

import extricate

# A process that was started in the background may have inherited that interrupts are ignored: those that the tests send would
# never arrive, and what they should end would go on for hours.
signal.signal(signal.SIGINT, signal.default_int_handler)

LABELS = 20_000


@pytest.fixture(scope="session")
def planar() -> extricate.Scene:
    return extricate.Scene.builtin("planar-arm")


@pytest.fixture(scope="session")
def model(planar: extricate.Scene) -> extricate.Model:
    return extricate.learn(planar, labels=LABELS, seed=3)


@pytest.fixture(scope="session")
def arm() -> extricate.Scene:
    return extricate.Scene.builtin("shelf-arm")
