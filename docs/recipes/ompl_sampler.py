"""OMPL plans with configurations from where it is narrow: a valid-state sampler on the nearest free configuration."""

import numpy as np
from ompl import base as ob
from ompl import geometric as og

import extricate

AIM = 0.005  # m that sampled configurations keep: above the scene's clearance, or no edge between them is free


class RetractionSampler(ob.ValidStateSampler):
    """Uniform configurations; those that collide are brought to the first exit that is found. In the manner of retraction-based
    planning (Zhang and Manocha, ICRA 2008, doi:10.1109/ROBOT.2008.4543785)."""

    def __init__(self, information, scene, seed=0):
        super().__init__(information)
        self.scene, self.rng = scene, np.random.default_rng(seed)
        self.options = {"starts": 1, "max_checks": 1, "clearance": AIM}

    def sample(self, state):
        q = self.rng.uniform(self.scene.lower, self.scene.upper)
        return self.write(q, state)

    def sampleNear(self, state, near, distance):
        q = np.array([near[k] for k in range(self.scene.nq)])
        q = q + self.rng.uniform(-distance, distance, len(q))
        return self.write(np.clip(q, self.scene.lower, self.scene.upper), state)

    def write(self, q, state):
        answer = self.scene.query(q, **self.options)
        if answer is None:
            return False
        for k, value in enumerate(answer.witness):
            state[k] = float(value)
        return True


def plan(scene, start, goal, seconds=30.0):
    """Configurations (n, nq) from start to goal, every edge proved free; or None."""
    space = ob.RealVectorStateSpace(scene.nq)
    bounds = ob.RealVectorBounds(scene.nq)
    for k, (low, high) in enumerate(zip(scene.lower, scene.upper)):
        bounds.setLow(k, float(low))
        bounds.setHigh(k, float(high))
    space.setBounds(bounds)
    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: bool(scene.check([state[k] for k in range(scene.nq)])))
    setup.getSpaceInformation().setValidStateSamplerAllocator(lambda information: RetractionSampler(information, scene))
    ends = []
    for q in (start, goal):
        state = space.allocState()
        for k, value in enumerate(q):
            state[k] = float(value)
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(og.PRM(setup.getSpaceInformation()))
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None
    states = setup.getSolutionPath().getStates()
    path = np.array([[state[k] for k in range(scene.nq)] for state in states])
    # OMPL samples its edges; what it missed between the samples is repaired.
    return scene.repair(path).points


def main():
    scene = extricate.Scene.builtin("shelf-arm")
    start, goal = scene.sample(2, seed=4, colliding=False)
    path = plan(scene, start, goal)
    print(f"path of {len(path)} configurations, every edge proved")
    return scene, start, goal, path


if __name__ == "__main__":
    main()
