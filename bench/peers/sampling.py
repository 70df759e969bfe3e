"""Random exits from collision, with pinocchio + coal as the check: the first free configuration is taken."""
import time
import weakref

import numpy as np
from ompl import base, util

# OMPL accepts a seed only once per process, at the start.
util.RNG.setSeed(1)
util.setLogLevel(util.LogLevel.LOG_WARN)
MOST_TRIES = 10_000


class Jiggle:
    """Adds normal noise to every joint, 2 % more of it after every try."""
    name = "random jiggle"

    def __init__(self, scene, seed):
        self.scene, self.rng = scene, np.random.default_rng(seed)

    def solve(self, q):
        s, began, spread = self.scene, time.thread_time(), 0.01
        for tries in range(1, MOST_TRIES + 1):
            x = q + self.rng.normal(scale=spread, size=len(q))
            x = np.where(s.circle, x, np.clip(x, s.low, s.high))
            if s.free(x):
                return {"witness": x, "seconds": time.thread_time() - began, "checks": tries}
            spread = min(1.02 * spread, np.pi)
        return {"witness": None, "seconds": time.thread_time() - began, "checks": MOST_TRIES}


class Nearby:
    """OMPL's `SpaceInformation.searchValidNearby`: the first valid of uniform samples nearby, at a growing distance."""
    name = "OMPL, searchValidNearby"
    # First distance in every coordinate [rad], its growth, and samples per distance.
    FIRST, GROWTH, ATTEMPTS = 0.05, 1.3, 30

    def __init__(self, scene):
        self.scene, self.tries = scene, 0
        line = base.RealVectorStateSpace(int((~scene.circle).sum()))
        bounds = base.RealVectorBounds(line.getDimension())
        for k, (low, high) in enumerate(zip(scene.low[~scene.circle], scene.high[~scene.circle])):
            bounds.setLow(k, float(low))
            bounds.setHigh(k, float(high))
        line.setBounds(bounds)
        self.space = base.CompoundStateSpace()
        self.space.addSubspace(line, 1.0)
        for _ in range(int(scene.circle.sum())):
            self.space.addSubspace(base.SO2StateSpace(), 1.0)
        self.information = base.SpaceInformation(self.space)
        # A proxy, because OMPL's reference is invisible to Python's garbage collector.
        me = weakref.proxy(self)
        self.information.setStateValidityChecker(lambda state: me.valid(state))
        self.information.setup()
        self.near, self.state = self.information.allocState(), self.information.allocState()

    def coordinates(self, state):
        q, line, turn = np.empty(len(self.scene.circle)), 0, 0
        for k, circle in enumerate(self.scene.circle):
            if circle:
                turn += 1
                q[k] = state[turn].value
            else:
                q[k] = state[0][line]
                line += 1
        return q

    def put(self, q, state):
        for k, value in enumerate(q[~self.scene.circle]):
            state[0][k] = float(value)
        for k, value in enumerate(q[self.scene.circle]):
            state[k + 1].value = float(value)

    def valid(self, state):
        self.tries += 1
        return self.scene.free(self.coordinates(state))

    def solve(self, q):
        began, before, distance = time.thread_time(), self.tries, self.FIRST
        self.put(q, self.near)
        found = False
        while not found and self.tries - before < MOST_TRIES:
            found = self.information.searchValidNearby(self.state, self.near, min(distance, np.pi), self.ATTEMPTS)
            distance *= self.GROWTH
        witness = self.coordinates(self.state) if found else None
        return {"witness": witness, "seconds": time.thread_time() - began, "checks": self.tries - before}
