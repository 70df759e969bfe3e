"""What the tests share: small built-in scenes and models, learned once."""

import pytest

import extricate

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
