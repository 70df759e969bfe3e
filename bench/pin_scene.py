"""Converts a scene file to a pinocchio + coal model, as their users would build it, with the pairs and clearance of the scene.

One robot with a fixed base among obstacles. Coordinates are those of the scene: joints in the order of the URDF."""
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin


def se3(pose):
    turn = pin.rpy.rpyToMatrix(np.array(pose.get("rpy", [0, 0, 0]), float))
    return pin.SE3(turn, np.array(pose.get("xyz", [0, 0, 0]), float))


def hull(geometry):
    if isinstance(geometry, coal.BVHModelBase):
        geometry.buildConvexHull(True, "Qt")
        return geometry.convex
    return geometry


def shape(entry, folder, convex):
    if "box" in entry:
        return coal.Box(*entry["box"])
    if "sphere" in entry:
        return coal.Sphere(entry["sphere"])
    if "cylinder" in entry:
        return coal.Cylinder(*entry["cylinder"])
    if "capsule" in entry:
        return coal.Capsule(*entry["capsule"])
    scale = np.ones(3) * np.array(entry.get("scale", 1.0))
    mesh = coal.MeshLoader(coal.BV_OBBRSS).load(str(folder / entry["mesh"]), scale)
    return hull(mesh) if convex or entry.get("convex", False) else mesh


class PinScene:
    def __init__(self, path):
        folder = Path(path).resolve().parent
        spec = tomllib.loads(Path(path).read_text())
        if len(spec["robot"]) != 1 or spec["robot"][0].get("base", "fixed") != "fixed":
            raise ValueError(f"{path}: expected one robot with a fixed base")
        robot = spec["robot"][0]
        self.spec, self.folder, self.urdf = spec, folder, str(folder / robot["urdf"])
        self.clearance = spec.get("clearance", 1e-4)
        self.convex = robot.get("geometry", "mesh") == "convex-hull"
        model = pin.buildModelFromUrdf(self.urdf)
        packages = [str(folder / p) for p in robot.get("packages", [])]
        geometry = pin.buildGeomFromUrdf(model, self.urdf, pin.GeometryType.COLLISION, package_dirs=packages)
        base = se3(robot.get("pose", {}))
        for g in geometry.geometryObjects:
            if g.parentJoint == 0:
                g.placement = base * g.placement
        for j in range(1, model.njoints):
            if model.parents[j] == 0:
                model.jointPlacements[j] = base * model.jointPlacements[j]
        model, geometry = self.locked(model, geometry, dict(robot.get("locked", {})))
        links = [model.frames[g.parentFrame].name for g in geometry.geometryObjects]
        if self.convex:
            for g in geometry.geometryObjects:
                g.geometry = hull(g.geometry)
        for o in spec.get("obstacle", []):
            geometry.addGeometryObject(pin.GeometryObject(o["name"], 0, 0, se3(o.get("pose", {})), shape(o["shape"], folder, False)))
        names = links + [o["name"] for o in spec.get("obstacle", [])]
        off = {frozenset(p) for p in spec.get("pairs", {}).get("disable", [])}
        if "srdf" in robot:
            for e in ET.parse(folder / robot["srdf"]).getroot().iter("disable_collisions"):
                off.add(frozenset((e.get("link1"), e.get("link2"))))
        for a in range(len(names)):
            for b in range(a + 1, len(names)):
                i, j = geometry.geometryObjects[a].parentJoint, geometry.geometryObjects[b].parentJoint
                joined = b < len(links) and (model.parents[i] == j or model.parents[j] == i)
                if i != j and not joined and frozenset((names[a], names[b])) not in off:
                    geometry.addCollisionPair(pin.CollisionPair(a, b))
        self.model, self.geometry, self.names = model, geometry, names
        self.data, self.geometry_data = model.createData(), geometry.createData()
        for request in self.geometry_data.collisionRequests:
            request.security_margin = self.clearance
            request.enable_contact = False
        order = [e.get("name") for e in ET.parse(self.urdf).getroot().findall("joint")]
        known = set(model.names)
        self.joints = [n for n in order if n in known and self.joint(n).nv == 1]
        joints = [self.joint(n) for n in self.joints]
        # pinocchio describes continuous joints by cosine and sine.
        self.circle = np.array([j.nq == 2 for j in joints])
        self.iq, self.iv = np.array([j.idx_q for j in joints]), np.array([j.idx_v for j in joints])
        self.low = np.where(self.circle, -np.pi, model.lowerPositionLimit[self.iq])
        self.high = np.where(self.circle, np.pi, model.upperPositionLimit[self.iq])
        self.parents = [g.parentJoint for g in geometry.geometryObjects]

    def joint(self, name):
        return self.model.joints[self.model.getJointId(name)]

    def locked(self, model, geometry, positions):
        """Fixes joints; one that mimics a locked joint is fixed at the position that follows."""
        for e in ET.parse(self.urdf).getroot().findall("joint"):
            mimic = e.find("mimic")
            if mimic is not None and mimic.get("joint") in positions:
                there = float(mimic.get("multiplier", 1)) * positions[mimic.get("joint")] + float(mimic.get("offset", 0))
                positions.setdefault(e.get("name"), there)
        if not positions:
            return model, geometry
        q = pin.neutral(model)
        ids = [model.getJointId(name) for name in positions]
        for j, value in zip(ids, positions.values()):
            joint = model.joints[j]
            q[joint.idx_q:joint.idx_q + joint.nq] = [np.cos(value), np.sin(value)] if joint.nq == 2 else [value]
        return pin.buildReducedModel(model, geometry, ids, q)

    def full(self, q):
        """Converts coordinates of the scene to those of pinocchio."""
        x = np.zeros(self.model.nq)
        x[self.iq] = q
        for k in np.flatnonzero(self.circle):
            x[self.iq[k]:self.iq[k] + 2] = np.cos(q[k]), np.sin(q[k])
        return x

    def collides(self, x):
        """Whether a checked pair is nearer than the clearance; `x` as [`full`] gives it. Stops at the first pair."""
        return pin.computeCollisions(self.model, self.data, self.geometry, self.geometry_data, x, True)

    def free(self, q):
        return not self.collides(self.full(q))

    def least_distance(self, q):
        pin.computeDistances(self.model, self.data, self.geometry, self.geometry_data, self.full(q))
        return min(r.min_distance for r in self.geometry_data.distanceResults)

    def inside(self, q, tolerance=1e-9):
        return bool((self.circle | ((q >= self.low - tolerance) & (q <= self.high + tolerance))).all())

    def delta(self, a, b):
        d = np.asarray(b) - np.asarray(a)
        return np.where(self.circle, (d + np.pi) % (2 * np.pi) - np.pi, d)

    def distance(self, a, b):
        """Returns the distance in the joint metric with unit weights."""
        return float(np.linalg.norm(self.delta(a, b)))

    def near_distances(self, q, margin):
        """Returns the signed distances [m] of pairs nearer than `margin`, and their gradients over the scene's coordinates."""
        pin.computeDistances(self.model, self.data, self.geometry, self.geometry_data, self.full(q))
        pin.computeJointJacobians(self.model, self.data, self.full(q))
        distances, gradients = [], []
        for k, pair in enumerate(self.geometry.collisionPairs):
            found = self.geometry_data.distanceResults[k]
            if found.min_distance > margin:
                continue
            normal, row = np.asarray(found.normal), np.zeros(self.model.nv)
            ends = (found.getNearestPoint1(), pair.first, -1.0), (found.getNearestPoint2(), pair.second, 1.0)
            for point, body, sign in ends:
                j = self.parents[body]
                if j:
                    jacobian = pin.getJointJacobian(self.model, self.data, j, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
                    arm = np.asarray(point) - self.data.oMi[j].translation
                    row += sign * (normal @ jacobian[:3] + np.cross(arm, normal) @ jacobian[3:])
            distances.append(found.min_distance)
            gradients.append(row[self.iv])
        return np.array(distances), np.array(gradients).reshape(len(distances), len(self.joints))
