"""Projects a configuration of pinocchio to the nearest free one, and has coal recheck it."""

import pathlib
import tempfile

import numpy as np
import pinocchio as pin

import extricate


def project(model, robot, q):
    """The nearest free configuration to `q`, in pinocchio's order; and the answer. Continuous joints are (cos, sin) there."""
    positions = {}
    for joint in model.scene.joints:
        index = robot.getJointId(joint.name)
        at, count = robot.joints[index].idx_q, robot.joints[index].nq
        continuous = count == 2
        positions[joint.name] = np.arctan2(q[at + 1], q[at]) if continuous else q[at : at + count]
    answer = model.query(model.scene.config(positions))
    projected = np.array(q, dtype=float)
    for joint in model.scene.joints:
        index = robot.getJointId(joint.name)
        at, count = robot.joints[index].idx_q, robot.joints[index].nq
        values = answer.witness[joint.start : joint.stop]
        projected[at : at + count] = [np.cos(values[0]), np.sin(values[0])] if count == 2 else values
    return projected, answer


def with_coal(urdf, robot, cylinders):
    """The robot's geometry and `cylinders` (radius, length, position) as pinocchio and coal see them."""
    import coal

    geometry = pin.buildGeomFromUrdf(robot, str(urdf), pin.GeometryType.COLLISION)
    links = list(range(geometry.ngeoms))
    for k, (radius, length, position) in enumerate(cylinders):
        pose = pin.SE3(np.eye(3), np.array(position, dtype=float))
        added = geometry.addGeometryObject(pin.GeometryObject(f"cylinder{k + 1}", 0, pose, coal.Cylinder(radius, length)))
        for link in links:
            if geometry.geometryObjects[link].parentJoint != 0:
                geometry.addCollisionPair(pin.CollisionPair(link, added))
    return geometry


def main():
    files = extricate.Scene.builtin_files("planar-arm")
    cylinders = [(0.12, 0.4, (0.62, 0.3, 0)), (0.15, 0.4, (0.1, 0.75, 0)), (0.14, 0.4, (0.8, -0.35, 0))]
    with tempfile.TemporaryDirectory() as folder:
        urdf = pathlib.Path(folder) / "arm.urdf"
        urdf.write_bytes(files["robot/arm.urdf"])
        robot = pin.buildModelFromUrdf(str(urdf))
        geometry = with_coal(urdf, robot, cylinders)
        scene = extricate.Scene(urdf, [extricate.Cylinder(r, length, at) for r, length, at in cylinders], clearance=1e-3)
    model = extricate.learn(scene, labels=50_000)
    angle = 0.45  # the first joint is continuous: (cos, sin), then two angles
    q = np.array([np.cos(angle), np.sin(angle), 0.1, -0.2])
    projected, answer = project(model, robot, q)
    data, geometry_data = robot.createData(), geometry.createData()
    before = pin.computeCollisions(robot, data, geometry, geometry_data, q, False)
    after = pin.computeCollisions(robot, data, geometry, geometry_data, projected, False)
    print(f"coal: colliding before {before}, after {after}; moved by {answer.depth:.4f} rad")
    return before, after, answer


if __name__ == "__main__":
    main()
