"""Globally nearest collision-free configurations of articulated robots, verified and bounded.

    scene = extricate.Scene("robot.urdf", [extricate.Box([0.2, 0.6, 0.4], pose=[0.45, 0, 0.45])])
    answer = scene.query(q)            # q in collision
    answer.witness                     # the nearest free configuration that was found
    solver = extricate.Solver(scene, extricate.learn(scene), effort="exhaustive")
    solver.batch(Q)                    # many, from stored samples too, with options that stay the same

A `Solver` answers all that is asked of a scene, with a model or without. The calls of a `Scene` and a `Model` are short forms of its calls.

Configurations are float64 arrays of shape (nq,), lists of them (n, nq), coordinates in the order of `Scene.joints`: angles in
rad, lengths in m, quaternions x, y, z, w. Calls release the interpreter lock; scenes, models and solvers may be shared between
threads.
"""

from . import fleet, grasps
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
    Points,
    Robot,
    SdfRobot,
    Sphere,
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
    "Voxels",
    "__version__",
    "fleet",
    "grasps",
    "import_world",
    "learn",
    "spheres",
]
