"""Repairs a start state in collision before OMPL plans from it."""

import numpy as np
from ompl import base as ob
from ompl import geometric as og

import extricate


def plan(model, start, goal, seconds=30.0):
    """Configurations (n, nq) from the repaired start to `goal`, or None; and the start's answer."""
    scene = model.scene
    answer = model.query(start)  # depth 0 and the start itself where it is free
    space = ob.RealVectorStateSpace(scene.nq)
    bounds = ob.RealVectorBounds(scene.nq)
    for k, (low, high) in enumerate(zip(scene.lower, scene.upper)):
        bounds.setLow(k, float(low))
        bounds.setHigh(k, float(high))
    space.setBounds(bounds)
    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(lambda state: bool(scene.check([state[k] for k in range(scene.nq)])))
    ends = []
    for q in (answer.witness, goal):
        state = space.allocState()
        for k, value in enumerate(q):
            state[k] = float(value)
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    setup.solve(seconds)
    if not setup.haveExactSolutionPath():
        return None, answer
    states = setup.getSolutionPath().getStates()
    return np.array([[state[k] for k in range(scene.nq)] for state in states]), answer


def main():
    scene = extricate.Scene.builtin("shelf-arm")
    model = extricate.learn(scene, labels=100_000)
    start = scene.sample(1, seed=3, colliding=True)[0]
    goal = scene.sample(1, seed=4, colliding=False)[0]
    path, answer = plan(model, start, goal)
    print(f"start repaired by {answer.depth:.4f} rad (at least {answer.lower_bound:.4f} is needed), path of {len(path)} states")
    return scene, start, goal, path, answer


if __name__ == "__main__":
    main()
