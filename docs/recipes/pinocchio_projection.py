"""Projects a configuration of pinocchio to the nearest free one, and has coal recheck it."""

import pathlib
import tempfile

import coal
import numpy as np
import pinocchio as pin

import extricate


def project(solver, robot, q):
    """The nearest free configuration to `q`, in pinocchio's order; and the answer. Continuous joints are (cos, sin) there."""
    answer = solver.query(robot.q(q))
    return robot.pinocchio_q(answer.witness), answer


def with_cylinders(urdf, model, cylinders):
    """The robot's geometry and `cylinders` (radius, length, position) as pinocchio and coal see them."""
    geometry = pin.buildGeomFromUrdf(model, str(urdf), pin.GeometryType.COLLISION)
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
        model = pin.buildModelFromUrdf(str(urdf))
        geometry = with_cylinders(urdf, model, cylinders)
    robot = extricate.Robot.from_pinocchio(model, geometry)
    solver = extricate.Solver(extricate.Scene(robot, clearance=1e-3))
    angle = 0.45  # the first joint is continuous: (cos, sin), then two angles
    q = np.array([np.cos(angle), np.sin(angle), 0.1, -0.2])
    projected, answer = project(solver, robot, q)
    data, geometry_data = model.createData(), geometry.createData()
    before = pin.computeCollisions(model, data, geometry, geometry_data, q, False)
    after = pin.computeCollisions(model, data, geometry, geometry_data, projected, False)
    print(f"coal: colliding before {before}, after {after}; moved by {answer.depth:.4f} rad")
    return before, after, answer


if __name__ == "__main__":
    main()
