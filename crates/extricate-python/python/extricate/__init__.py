"""Globally nearest collision-free configurations of articulated robots, verified and bounded.

    scene = extricate.Scene("robot.urdf", [extricate.Box([0.2, 0.6, 0.4], pose=[0.45, 0, 0.45])])
    model = extricate.learn(scene)
    answer = model.query(q)            # q in collision
    answer.witness                     # the nearest free configuration that was found

Configurations are float64 arrays of shape (nq,), lists of them (n, nq), coordinates in the order of `Scene.joints`: angles in
rad, lengths in m, quaternions x, y, z, w. Calls release the interpreter lock; scenes and models may be shared between threads.
"""

from . import fleet, grasps
from ._answer import Answer, Contact, Exit
from ._grasp import Grasp, GraspContact
from ._extricate import ChangedScene, Joint, Model, Progress, Roadmap, Scene, Stream, __version__, import_world, learn
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
    "ChangedScene",
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
