"""Labels of pinocchio and coal, and of the robots made from their models: joints, limits, pairs, shapes, obstacles, and errors."""

from pathlib import Path
from typing import Any, Tuple

import numpy as np
import pytest

from extricate import Robot, Scene

pinocchio: Any = pytest.importorskip("pinocchio")
coal: Any = pytest.importorskip("coal")
LABELS = 2000


def drawn_model(rng: Any) -> Tuple[Any, Any]:
    """Draws a tree of joints of every kind, with shapes of every kind on them, of which some pairs are checked."""
    model, geometry = pinocchio.Model(), pinocchio.GeometryModel()
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    composite = pinocchio.JointModelComposite()
    composite.addJoint(pinocchio.JointModelRY())
    composite.addJoint(pinocchio.JointModelPX(), pinocchio.SE3.Random())
    kinds = ["FreeFlyer", "RX", "RY", "RZ", "PX", "PY", "PZ", "RUBX", "RUBZ", "Spherical", "SphericalZYX", "Planar", "Translation"]
    joints = [getattr(pinocchio, f"JointModel{kind}")() for kind in kinds] + [composite]
    joints += [pinocchio.JointModelRevoluteUnaligned(axis), pinocchio.JointModelPrismaticUnaligned(axis)]
    for number in range(7):
        joint = joints[rng.integers(len(joints))]
        # Siblings are not beside each other in the order of the joints.
        parent = int(rng.integers(0, number + 1))
        place = pinocchio.SE3(pinocchio.Quaternion(*rng.normal(size=4)).normalized().matrix(), rng.uniform(-0.3, 0.3, 3))
        at = model.addJoint(parent, joint, place, f"joint{number}")
        model.addJointFrame(at)
    limits = np.where(rng.random(model.nq) < 0.3, 0.2, 0.5)
    model.lowerPositionLimit, model.upperPositionLimit = -limits, limits
    corners = coal.StdVec_Vec3s()
    corners.extend(list(rng.uniform(-0.1, 0.1, (12, 3))))
    for number in range(14):
        radius, length, sides = rng.uniform(0.03, 0.1), rng.uniform(0.05, 0.3), rng.uniform(0.05, 0.2, 3)
        shapes = [coal.Sphere(radius), coal.Box(*sides), coal.Capsule(radius, length), coal.Cylinder(radius, length)]
        shapes.append(coal.Convex.convexHull(corners, False, "Qt"))
        joint = 0 if number < 2 else int(rng.integers(0, model.njoints))
        frame = model.getFrameId(model.names[joint]) if joint else 0
        place = pinocchio.SE3(pinocchio.Quaternion(*rng.normal(size=4)).normalized().matrix(), rng.uniform(-0.2, 0.2, 3))
        part = pinocchio.GeometryObject(f"part{number}", joint, frame, place, shapes[rng.integers(len(shapes))])
        part.disableCollision = bool(rng.random() < 0.1)
        geometry.addGeometryObject(part)
    floor = pinocchio.SE3(np.eye(3), np.array([0, 0, -0.8]))
    geometry.addGeometryObject(pinocchio.GeometryObject("floor", 0, 0, floor, coal.Halfspace(0, 0, 1.0, 0)))
    geometry.addAllCollisionPairs()
    for pair in list(geometry.collisionPairs):
        if rng.random() < 0.4:
            geometry.removeCollisionPair(pair)
    return model, geometry


def differing(model: Any, geometry: Any, scene: Scene, robot: Any, Q: Any) -> Tuple[int, int]:
    """Counts the configurations that are labelled otherwise by more than 0.1 mm, and those that collide in coal."""
    data, places = model.createData(), pinocchio.GeometryData(geometry)
    theirs = np.array([pinocchio.computeCollisions(model, data, geometry, places, q, True) for q in Q])
    mine = scene.distances(robot.q(Q))
    assert np.allclose(robot.q(robot.pinocchio_q(robot.q(Q))), robot.q(Q), atol=1e-12)
    return int(((theirs != (mine < 0)) & (np.abs(mine) > 1e-4)).sum()), int(theirs.sum())


@pytest.mark.parametrize("seed", range(8))
def test_random_models_have_coals_labels(seed: int) -> None:
    model, geometry = drawn_model(np.random.default_rng(seed))
    robot = Robot.from_pinocchio(model, geometry)
    scene = Scene(robot)
    pinocchio.seed(seed)
    Q = np.array([pinocchio.randomConfiguration(model) for _ in range(LABELS // 4)])
    differ, collide = differing(model, geometry, scene, robot, Q)
    assert differ == 0 and collide > 0


@pytest.mark.parametrize("name", ["shelf-arm", "dual-arm", "hand", "four-legs"])
def test_robots_of_urdf_files_have_coals_labels(name: str, tmp_path: Path) -> None:
    for file, data in Scene.builtin_files(name).items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(data)
    urdf = next(tmp_path.glob("**/*.urdf"))
    model = pinocchio.buildModelFromUrdf(str(urdf))
    geometry = pinocchio.buildGeomFromUrdf(model, str(urdf), pinocchio.GeometryType.COLLISION, package_dirs=[str(tmp_path)])
    geometry.addAllCollisionPairs()
    joint_of = [part.parentJoint for part in geometry.geometryObjects]
    for pair in list(geometry.collisionPairs):
        one, other = joint_of[pair.first], joint_of[pair.second]
        if model.parents[one] == other or model.parents[other] == one:
            geometry.removeCollisionPair(pair)
    robot = Robot.from_pinocchio(model, geometry)
    scene, own = Scene(robot), Scene(urdf)
    assert [joint.name for joint in scene.joints] == list(model.names)[1:] and set(scene.bodies) <= set(own.bodies)
    pinocchio.seed(1)
    Q = np.array([pinocchio.randomConfiguration(model) for _ in range(LABELS // 4)])
    differ, collide = differing(model, geometry, scene, robot, Q)
    assert differ == 0 and 0 < collide < len(Q)


def two(shape: Any, joint: Any) -> Tuple[Any, Any]:
    """Makes a ball on a joint beside a shape of the world."""
    model, geometry = pinocchio.Model(), pinocchio.GeometryModel()
    model.addJoint(0, joint, pinocchio.SE3.Identity(), "hinge")
    place = pinocchio.SE3(np.eye(3), np.array([1.0, 0, 0]))
    geometry.addGeometryObject(pinocchio.GeometryObject("ball", 1, place, coal.Sphere(0.1)))
    geometry.addGeometryObject(pinocchio.GeometryObject("thing", 0, pinocchio.SE3.Identity(), shape))
    geometry.addAllCollisionPairs()
    return model, geometry


def test_a_locked_turn_stays_where_it_is() -> None:
    model, geometry = two(coal.Box(1, 1, 1), pinocchio.JointModelRUBZ())
    model.addJoint(1, pinocchio.JointModelRX(), pinocchio.SE3.Identity(), "twist")
    tip = geometry.addGeometryObject(pinocchio.GeometryObject("tip", 2, pinocchio.SE3.Identity(), coal.Sphere(0.1)))
    geometry.addCollisionPair(pinocchio.CollisionPair(1, tip))
    robot = Robot.from_pinocchio(model, geometry, locked={"hinge": 0.5}, limits={"twist": (-1, 1)})
    assert robot.pinocchio_q([[0.3], [0.4]]).tolist() == [[np.cos(0.5), np.sin(0.5), q] for q in (0.3, 0.4)]
    scene = Scene(robot)
    assert scene.lower.tolist() == [-1] and scene.pairs == [("tip", "thing")]


@pytest.mark.parametrize(
    "shape, joint, told",
    [
        ("Cone", "RZ", "thing: got a Cone, expected one of Box"),
        ("Sphere", "HZ", "hinge: got a JointModelHZ, expected one of RX"),
        ("Sphere", "RZ", "thing: got a swept sphere radius of 0.1 m, expected 0"),
    ],
)
def test_what_a_urdf_cannot_express_is_named(shape: str, joint: str, told: str) -> None:
    made = coal.Cone(0.1, 0.2) if shape == "Cone" else coal.Sphere(0.1)
    if shape == "Sphere":
        made.setSweptSphereRadius(0.1)
    with pytest.raises(ValueError, match=told):
        Robot.from_pinocchio(*two(made, getattr(pinocchio, f"JointModel{joint}")()))
