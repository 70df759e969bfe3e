"""OMPL planners on our checker; every state validity check is counted, as ours are."""
import time

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

ou.setLogLevel(ou.LogLevel.LOG_NONE)


def plan(scene, start, goal, planner, checks, seconds, seed, simplify=False):
    """Runs a planner until it has a path or has spent its checks, then OMPL's simplifier if requested; returns (path or None, checks)."""
    ou.RNG.setSeed(seed + 1)
    spent, lower, upper = [0], np.asarray(scene.lower), np.asarray(scene.upper)
    flies = scene.nq == 7 and scene.nv == 6
    space = ob.SE3StateSpace() if flies else ob.RealVectorStateSpace(scene.nq)
    bounds = ob.RealVectorBounds(3 if flies else scene.nq)
    for k in range(3 if flies else scene.nq):
        bounds.setLow(k, float(lower[k]))
        bounds.setHigh(k, float(upper[k]))
    space.setBounds(bounds)

    def read(state):
        if not flies:
            return np.array([state[k] for k in range(scene.nq)])
        turn = state.rotation()
        return np.array([state.getX(), state.getY(), state.getZ(), turn.x, turn.y, turn.z, turn.w])

    def write(state, q):
        if not flies:
            for k in range(scene.nq):
                state[k] = float(q[k])
            return
        state.setX(float(q[0]))
        state.setY(float(q[1]))
        state.setZ(float(q[2]))
        turn = state.rotation()
        turn.x, turn.y, turn.z, turn.w = map(float, q[3:])

    def valid(state):
        if spent[0] >= checks:
            return False
        spent[0] += 1
        q = read(state)
        return bool((q >= lower).all() and (q <= upper).all() and scene.check(q, threads=1))

    setup = og.SimpleSetup(space)
    setup.setStateValidityChecker(valid)
    ends = []
    for q in (start, goal):
        state = space.allocState()
        write(state, q)
        ends.append(state)
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(getattr(og, planner)(setup.getSpaceInformation()))
    setup.setup()
    began = time.time()
    setup.solve(ob.PlannerTerminationCondition(lambda: spent[0] >= checks or time.time() - began > seconds))
    if not setup.haveExactSolutionPath() or spent[0] >= checks:
        return None, spent[0]
    if simplify:
        setup.simplifySolution()
    return np.array([read(state) for state in setup.getSolutionPath().getStates()]), spent[0]


def proved(scene, path):
    """Whether every edge of a path is proved free."""
    return bool(scene.check_segments(path[:-1], path[1:], threads=1)["free"].all())
