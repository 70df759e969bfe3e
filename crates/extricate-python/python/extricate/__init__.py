"""Globally nearest collision-free configurations of articulated robots, verified and bounded.

    scene = extricate.Scene("robot.urdf", [extricate.Box([0.2, 0.6, 0.4], pose=[0.45, 0, 0.45])])
    answer = scene.query(q)            # q in collision
    answer.witness                     # the nearest free configuration found
    solver = extricate.Solver(scene, extricate.learn(scene), effort="exhaustive")
    solver.batch(Q)                    # many queries, from stored samples too, with the solver's options

A `Solver` answers all queries about a scene, with a model or without. The calls of a `Scene` and a `Model` are short forms of
its calls.

A configuration is a float64 array of shape (nq,), and n of them have shape (n, nq). Coordinates are in the order of
`Scene.joints`: angles in rad, lengths in m, quaternions x, y, z, w. Calls release the interpreter lock; threads may share
scenes, models and solvers.
"""

from . import fleet, grasps, recordings, ros, rows
from ._answer import Answer, Contact, Exit
from ._grasp import Grasp, GraspContact
from ._extricate import Joint, Model, Progress, Roadmap, Scene, Solver, Stream, __version__, import_world, learn
from ._motion import Escape, Plan, Repaired
from ._options import QueryOptions
from ._page import Page
from ._parts import (
    Box,
    Capsule,
    Cylinder,
    Fixture,
    HalfSpace,
    HeightField,
    Mesh,
    MujocoRobot,
    PinocchioRobot,
    Points,
    Robot,
    SdfRobot,
    Sphere,
    UsdRobot,
    Voxels,
    spheres,
)

__all__ = [
    "Answer",
    "Box",
    "Capsule",
    "Contact",
    "Cylinder",
    "Escape",
    "Exit",
    "Fixture",
    "Grasp",
    "GraspContact",
    "HalfSpace",
    "HeightField",
    "Joint",
    "Mesh",
    "Model",
    "MujocoRobot",
    "Page",
    "PinocchioRobot",
    "Plan",
    "Points",
    "Progress",
    "QueryOptions",
    "Repaired",
    "Roadmap",
    "Robot",
    "Scene",
    "SdfRobot",
    "Solver",
    "Sphere",
    "Stream",
    "UsdRobot",
    "Voxels",
    "__version__",
    "fleet",
    "grasps",
    "import_world",
    "learn",
    "recordings",
    "ros",
    "rows",
    "spheres",
]
