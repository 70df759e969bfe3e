"""What pinocchio and coal say of a drawn scene: distances by pair, which are checked, the joint metric. It reads no file that
extricate reads, and lengths are in units of the scene's scale, so that coal's tolerances (about 1e-6) mean the same for all."""
from itertools import combinations

import coal
import numpy as np
import pinocchio as pin

# Distance to contact below which the two sides may differ, in units of the scale.
TOLERANCE = 5e-5


def se3(xyz, rpy):
    return pin.SE3(pin.rpy.rpyToMatrix(np.array(rpy, float)), np.array(xyz, float))


def bvh(corners, triangles):
    mesh = coal.BVHModelOBBRSS()
    mesh.beginModel(len(triangles), len(corners))
    mesh.addVertices(np.asarray(corners))
    mesh.addTriangles(np.asarray(triangles))
    mesh.endModel()
    return mesh


def geometries(shape):
    """coal's geometries whose union is the shape, and where each is in it."""
    here = pin.SE3.Identity()
    if shape.kind == "box":
        return [(coal.Box(*shape.size), here)]
    if shape.kind == "sphere":
        return [(coal.Sphere(*shape.size), here)]
    if shape.kind == "cylinder":
        return [(coal.Cylinder(*shape.size), here)]
    if shape.kind == "capsule":
        return [(coal.Capsule(*shape.size), here)]
    if shape.kind == "solid":
        mesh = bvh(shape.corners, shape.triangles)
        mesh.buildConvexHull(True, "Qt")
        return [(mesh.convex, here)]
    if shape.kind in ("sheet", "open"):
        return [(bvh(shape.corners, shape.triangles), here)]
    # The hollow box is six walls.
    sides, thick = np.array(shape.size[:3]), shape.size[3]
    walls = []
    for axis in range(3):
        for sign in (-1, 1):
            size, at = sides.copy(), np.zeros(3)
            size[axis] = thick
            at[axis] = sign * (sides[axis] - thick) / 2
            walls.append((coal.Box(*size), pin.SE3(np.eye(3), at)))
    return walls


def joint_model(joint):
    if joint.kind == "revolute" or joint.kind == "continuous":
        return pin.JointModelRevoluteUnaligned(joint.axis)
    if joint.kind == "prismatic":
        return pin.JointModelPrismaticUnaligned(joint.axis)
    return {"spherical": pin.JointModelSpherical, "planar": pin.JointModelPlanar, "floating": pin.JointModelFreeFlyer}[joint.kind]()


class Oracle:
    def __init__(self, drawn, joints):
        """`joints` are those of the scene: where each has its coordinates is all that is taken from it."""
        self.drawn, self.s = drawn, drawn.scale
        self.model = pin.Model()
        self.names = [f"l{k}" for k in range(len(drawn.links))] + [f"o{k}" for k in range(len(drawn.obstacles))]
        base = {"fixed": None, "planar": pin.JointModelPlanar(), "floating": pin.JointModelFreeFlyer()}[drawn.base]
        # For each link, the joint of pinocchio that moves it, and its pose relative to that joint.
        self.seat = [(self.model.addJoint(0, base, pin.SE3.Identity(), "base") if base else 0, pin.SE3.Identity())]
        # For each joint of the scene, its number in pinocchio and its kind.
        self.moving = {"base": (self.seat[0][0], drawn.base)} if base else {}
        for joint in drawn.joints:
            parent, placement = self.seat[joint.parent]
            placement = placement * se3(joint.xyz, joint.rpy)
            if joint.kind == "fixed":
                self.seat.append((parent, placement))
                continue
            number = self.model.addJoint(parent, joint_model(joint), placement, joint.name)
            self.moving[joint.name] = (number, joint.kind)
            self.seat.append((number, pin.SE3.Identity()))
        self.data = self.model.createData()
        self.coordinates = {}
        for joint in joints:
            own = joint.name if joint.name in self.moving else "base"
            self.coordinates[own] = slice(joint.start, joint.stop)
        self.nq = max(c.stop for c in self.coordinates.values())
        expected = {n for n in self.moving if n == "base" or next(j for j in drawn.joints if j.name == n).mimic is None}
        assert set(self.coordinates) == expected, f"{set(self.coordinates)} have coordinates, expected {expected}"
        self.parts = self.shapes_of_bodies()
        self.pairs = self.checked_pairs()

    def shapes_of_bodies(self):
        """Returns for each body the joint that moves it, and its geometries with their poses relative to that joint."""
        parts = []
        seats = self.seat + [(0, pin.SE3.Identity())] * len(self.drawn.obstacles)
        for (joint, placement), shapes in zip(seats, self.drawn.links + [[o] for o in self.drawn.obstacles]):
            found = [(g, placement * se3(s.xyz, s.rpy) * here) for s in shapes for g, here in geometries(s)]
            parts.append((joint, found))
        return parts

    def checked_pairs(self):
        """Returns all pairs except those in one rigid group, those that one joint joins, and those without a shape on a side."""
        pairs = []
        for a, b in combinations(range(len(self.parts)), 2):
            i, j = self.parts[a][0], self.parts[b][0]
            joined = b < len(self.seat) and (self.model.parents[i] == j or self.model.parents[j] == i)
            if i != j and not joined and self.parts[a][1] and self.parts[b][1]:
                pairs.append((a, b))
        return pairs

    def full(self, q):
        """Converts coordinates of the scene to those of pinocchio."""
        x = pin.neutral(self.model)
        values = {}
        for name, where in self.coordinates.items():
            values[name] = np.array(q[where], float)
        for joint in self.drawn.joints:
            if joint.mimic:
                lead, multiplier, offset = joint.mimic
                value = values[lead][0] / self.unit(lead)
                values[joint.name] = np.array([(multiplier * value + offset) * self.unit(joint.name)])
        for name, value in values.items():
            number, kind = self.moving[name]
            at = self.model.joints[number].idx_q
            if kind in ("revolute", "continuous"):
                x[at] = value[0]
            elif kind == "prismatic":
                x[at] = value[0] / self.s
            elif kind == "planar":
                x[at:at + 4] = value[0] / self.s, value[1] / self.s, np.cos(value[2]), np.sin(value[2])
            elif kind == "spherical":
                x[at:at + 4] = value
            else:
                x[at:at + 7] = np.concatenate([value[:3] / self.s, value[3:]])
        return x

    def unit(self, name):
        return self.s if self.moving[name][1] == "prismatic" else 1.0

    def place(self, q):
        """Returns the pose of every geometry at `q`, by body."""
        pin.forwardKinematics(self.model, self.data, self.full(q))
        return [[(g, self.data.oMi[joint] * at) for g, at in found] for joint, found in self.parts]

    def distances(self, q):
        """Returns the distance of each checked pair in units of the scale; 0 or less if it collides."""
        placed = self.place(q)
        request = coal.DistanceRequest()
        out = []
        for a, b in self.pairs:
            least = np.inf
            for g, at in placed[a]:
                for h, there in placed[b]:
                    result = coal.DistanceResult()
                    least = min(least, coal.distance(g, coal.Transform3s(at.rotation, at.translation), h, coal.Transform3s(there.rotation, there.translation), request, result))
            out.append(least)
        return np.array(out)

    def limits(self):
        """Returns lower and upper limits: -1 and 1 for quaternions, none for angles that wrap."""
        low, high = np.full(self.nq, -np.inf), np.full(self.nq, np.inf)
        for name, where in self.coordinates.items():
            kind = self.moving[name][1]
            j = next((j for j in self.drawn.joints if j.name == name), None)
            ends = (-1.0, 1.0) if j is None else (j.lower, j.upper)
            if kind in ("revolute", "prismatic"):
                low[where], high[where] = (e * self.unit(name) for e in ends)
            elif kind in ("planar", "floating"):
                n = 2 if kind == "planar" else 3
                low[where.start:where.start + n], high[where.start:where.start + n] = ends[0] * self.s, ends[1] * self.s
        return low, high

    def draw(self, rng):
        low, high = self.limits()
        q = rng.uniform(np.maximum(low, -np.pi), np.minimum(high, np.pi)) if self.s <= 1 else rng.uniform(np.where(np.isfinite(low), low, -np.pi), np.where(np.isfinite(high), high, np.pi))
        for turn in self.rotations():
            v = rng.normal(size=4)
            q[turn] = v / np.linalg.norm(v)
        return q

    def rotations(self):
        for name, where in self.coordinates.items():
            if self.moving[name][1] in ("spherical", "floating"):
                yield slice(where.stop - 4, where.stop)

    def distance(self, a, b):
        """Returns the distance in the joint metric with the scene's weights."""
        total = 0.0
        for name, where in self.coordinates.items():
            kind, w = self.moving[name][1], self.drawn.weights.get(name, 1.0)
            d = np.asarray(b[where]) - np.asarray(a[where])
            if kind == "continuous":
                d = (d + np.pi) % (2 * np.pi) - np.pi
            elif kind == "planar":
                d[2] = (d[2] + np.pi) % (2 * np.pi) - np.pi
            elif kind in ("spherical", "floating"):
                p, r = (pin.Quaternion(np.array(x[where][-4:], float)) for x in (a, b))
                angle = np.linalg.norm(pin.log3((p.inverse() * r).normalized().toRotationMatrix()))
                d = np.concatenate([d[:-4], [angle]])
            total += w * float(d @ d)
        return total**0.5

    def between(self, a, b, share):
        """Returns the configuration at a share of the geodesic from a to b."""
        a, b = np.array(a, float), np.array(b, float)
        out = a + share * (b - a)
        for name, where in self.coordinates.items():
            kind = self.moving[name][1]
            if kind in ("continuous", "planar"):
                turn = where.stop - 1
                out[turn] = a[turn] + share * ((b[turn] - a[turn] + np.pi) % (2 * np.pi) - np.pi)
        for turn in self.rotations():
            p, r = (pin.Quaternion(x[turn]) for x in (a, b))
            out[turn] = p.slerp(share, r).normalized().coeffs()
        return out

    def near(self, q, length, rng):
        """Draws a configuration within limits, at most about `length` from q in the joint metric, in a random direction."""
        low, high = self.limits()
        step = rng.normal(size=self.nq)
        step *= length / np.linalg.norm(step)
        out = np.array(q, float) + step / max(1.0, max(self.drawn.weights.values(), default=1.0) ** 0.5)
        for turn in self.rotations():
            there = pin.exp3(step[turn][:3])
            out[turn] = (pin.Quaternion(np.array(q[turn], float)) * pin.Quaternion(there)).normalized().coeffs()
        return np.clip(out, low, high)

    def least_displacement(self, a, b, rng):
        """Returns a lower bound on the largest displacement of a point of the moving links [m]."""
        places = [self.place(q)[:len(self.seat)] for q in (a, b)]
        most = 0.0
        for body, other in zip(*places):
            for (g, at), (_, there) in zip(body, other):
                points = surface(g, rng)
                most = max(most, float(np.linalg.norm((at.rotation - there.rotation) @ points + (at.translation - there.translation)[:, None], axis=0).max()))
        return most * self.s


def surface(geometry, rng):
    """Returns points of a geometry as columns, with all its corners if it has any."""
    if isinstance(geometry, coal.Box):
        return (np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * geometry.halfSide).T
    if isinstance(geometry, (coal.Sphere, coal.Capsule)):
        v = rng.normal(size=(3, 400))
        v *= geometry.radius / np.linalg.norm(v, axis=0)
        if isinstance(geometry, coal.Capsule):
            v[2] += np.sign(v[2]) * geometry.halfLength
        return v
    if isinstance(geometry, coal.Cylinder):
        angle = np.linspace(0, 2 * np.pi, 200)
        rim = np.array([np.cos(angle) * geometry.radius, np.sin(angle) * geometry.radius, 0 * angle])
        return np.concatenate([rim + [[0], [0], [z]] for z in (-geometry.halfLength, geometry.halfLength)], axis=1)
    if isinstance(geometry, coal.BVHModelBase):
        return np.array([geometry.vertex(k) for k in range(geometry.num_vertices)]).T
    return np.array([geometry.point(k) for k in range(geometry.num_points)]).T
