"""Judges configurations and edges by pinocchio's kinematics and coal's distances: none of our own code says what is free.

Between two samples of an edge no pair can meet: a sample covers as much of the edge as the distances at it allow, by a bound on how
far geometries move; near contacts samples are half a millimetre of motion apart. Lengths are in units of `scale`.
"""
import sys
import tempfile
import tomllib
import xml.etree.ElementTree as ET
from itertools import combinations
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin

import extricate
import humanoid
import pin_scene
from escapes import between

sys.path.append(str(Path(__file__).resolve().parent.parent / "judge"))
from drawn import write  # noqa: E402
from oracle import Oracle  # noqa: E402

# Motion between two samples near contacts, and the difference of the two sides' distances that is no fault, in units of the scale.
SPACING, TOLERANCE = 5e-4, 5e-5


class Judge:
    """A model and geometries of pinocchio. `bodies` names the body of each geometry; `full` converts coordinates to pinocchio's."""

    def __init__(self, scene, model, geometry, bodies, pairs, full, scale=1.0):
        self.scene, self.model, self.full, self.scale = scene, model, full, scale
        self.data, self.clearance = model.createData(), scene.clearance / scale
        self.geometry = geometry
        names = {name: k for k, name in enumerate(dict.fromkeys(bodies))}
        of_body = [[] for _ in names]
        for k, body in enumerate(bodies):
            of_body[names[body]].append(k)
        # The pair of bodies of each pair of geometries.
        self.pairs, of = pairs, []
        for number, (a, b) in enumerate(pairs):
            for i in of_body[names[a]]:
                for j in of_body[names[b]]:
                    geometry.addCollisionPair(pin.CollisionPair(i, j))
                    of.append(number)
        self.of, self.geometry_data = np.array(of), geometry.createData()
        objects = geometry.geometryObjects
        self.first, self.second = (np.array([getattr(p, side) for p in geometry.collisionPairs]) for side in ("first", "second"))
        for g in objects:
            g.geometry.computeLocalAABB()
        self.radius = np.array([g.geometry.aabb_radius for g in objects])
        self.center = [np.array(g.geometry.aabb_center) for g in objects]
        self.has_depth = np.array([isinstance(g.geometry, coal.ShapeBase) for g in objects])
        self.reach = self.reaches()

    def reaches(self):
        """Returns how far a pair's geometries are from each joint at most that moves them relative to each other, and whether it does."""
        objects, model = self.geometry.geometryObjects, self.model
        far = np.zeros((len(objects), model.njoints))
        for k, g in enumerate(objects):
            reach = np.linalg.norm(g.placement.act(self.center[k])) + self.radius[k]
            joint = g.parentJoint
            while joint:
                far[k, joint] = reach
                reach += np.linalg.norm(model.jointPlacements[joint].translation) + self.travel(joint)
                joint = model.parents[joint]
        a, b = far[self.first], far[self.second]
        return np.where((a > 0) & (b > 0), 0.0, a + b)

    def travel(self, joint):
        """Returns the farthest that a joint translates, over its limits."""
        at = self.model.joints[joint]
        if at.shortname().startswith("JointModelP") or at.shortname() == "JointModelFreeFlyer":
            ends = np.concatenate([self.full(self.scene.lower), self.full(self.scene.upper)]).reshape(2, -1)[:, at.idx_q:at.idx_q + min(3, at.nv)]
            return float(np.linalg.norm(np.abs(ends).max(axis=0)))
        return 0.0

    def motion(self, a, b):
        """Returns a bound on the relative motion of each pair's geometries along an edge."""
        x, y = self.full(a), self.full(b)
        turn, shift = np.zeros(self.model.njoints), np.zeros(self.model.njoints)
        for k in range(1, self.model.njoints):
            joint = self.model.joints[k]
            p, q = x[joint.idx_q:joint.idx_q + joint.nq], y[joint.idx_q:joint.idx_q + joint.nq]
            name = joint.shortname()
            if name.startswith("JointModelPrismatic") or name in ("JointModelPX", "JointModelPY", "JointModelPZ"):
                shift[k] = abs(q[0] - p[0])
            elif joint.nq == 1:
                turn[k] = abs(q[0] - p[0])
            else:
                # Cosine and sine of an angle, or a quaternion, stand last.
                n = 2 if joint.nq in (2, 4) and joint.nv != 3 or name == "JointModelPlanar" else 4
                shift[k] = np.linalg.norm(q[:-n] - p[:-n])
                chord = np.linalg.norm(q[-n:] - p[-n:]) if n == 2 else min(np.linalg.norm(q[-n:] - p[-n:]), np.linalg.norm(q[-n:] + p[-n:]))
                turn[k] = (1 if n == 2 else 2) * 2 * np.arcsin(min(1.0, chord / 2))
        return self.reach @ turn + (self.reach > 0) @ shift

    def distances(self, q, which=None, enough=None):
        """Returns the signed distances of some pairs of geometries, by default all; of one that is surely `enough` apart, less than that."""
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.geometry_data, self.full(q))
        which = np.arange(len(self.of)) if which is None else which
        found = np.empty(len(which))
        for n, k in enumerate(which):
            if enough is not None:
                i, j = int(self.first[k]), int(self.second[k])
                apart = self.geometry_data.oMg[i].act(self.center[i]) - self.geometry_data.oMg[j].act(self.center[j])
                found[n] = np.sqrt(apart @ apart) - self.radius[i] - self.radius[j]
                if found[n] > enough[n]:
                    continue
            found[n] = pin.computeDistance(self.geometry, self.geometry_data, int(k)).min_distance
        return found

    def worst(self, q):
        """Returns the least distance beyond the clearance [m]."""
        return float((self.distances(q).min() - self.clearance) * self.scale)

    def keeps(self, q, tolerance):
        """Returns what an escape from q has to keep of each pair: the clearance, or the depth at q and no more than a tolerance."""
        body = np.full(len(self.pairs), np.inf)
        found = self.distances(q)
        np.minimum.at(body, self.of, found)
        keep = np.where(body < self.clearance, body - tolerance / self.scale, self.clearance)
        # Surfaces have no depth, and meshes no exact one.
        known = np.ones(len(self.pairs), bool)
        np.logical_and.at(known, self.of, self.has_depth[self.first] & self.has_depth[self.second])
        return np.where(known | (body >= self.clearance), keep, -np.inf)[self.of]

    def edge(self, a, b, keep=None):
        """Returns the first fault found on an edge, (share, pair, distance, expected), or None; and the number of samples."""
        keep = (np.full(len(self.of), self.clearance) if keep is None else keep) - TOLERANCE
        motion = self.motion(a, b)
        most = motion.max(initial=0.0)
        todo, samples = [(0.0, 1.0, np.arange(len(self.of)))], 0
        while todo:
            begin, end, which = todo.pop()
            middle, half = (begin + end) / 2, (end - begin) / 2
            need = (keep + motion * half)[which]
            found = self.distances(between(self.scene, a, b, np.array([middle]))[0], which, need)
            samples += 1
            for n in np.flatnonzero(found < keep[which])[:1]:
                k = which[n]
                return (middle, self.pairs[self.of[k]], float(found[n] * self.scale), float(keep[k] * self.scale)), samples
            which = which[found < need]
            if half * most > SPACING / 2 and len(which):
                todo += [(middle, end, which), (begin, middle, which)]
        return None, samples


def of_drawn(drawn):
    """Makes a drawn scene and its judge, which reads none of its files; None if nothing of it can move or is checked."""
    with tempfile.TemporaryDirectory() as folder:
        scene = extricate.Scene.load(write(drawn, folder))
    if scene.nq == 0 or not scene.pairs:
        return None
    oracle = Oracle(drawn, scene.joints)
    geometry, bodies = pin.GeometryModel(), []
    for name, (joint, parts) in zip(oracle.names, oracle.parts):
        for g, at in parts:
            geometry.addGeometryObject(pin.GeometryObject(f"{name}_{len(bodies)}", joint, at, g))
            bodies.append(name)
    pairs = [(oracle.names[a], oracle.names[b]) for a, b in oracle.pairs]
    judge = Judge(scene, oracle.model, geometry, bodies, pairs, oracle.full, drawn.scale)
    # A hollow box is one mesh that is not convex here, and six walls there: their depths are different estimates.
    shapes = drawn.links + [[one] for one in drawn.obstacles]
    hollow = {name for name, parts in zip(oracle.names, shapes) if any(part.kind == "hollow" for part in parts)}
    judge.has_depth &= np.array([body not in hollow for body in bodies])
    return scene, judge


def of_builtin(name, scene):
    """Makes the judge of a built-in scene from the files that it exports."""
    with tempfile.TemporaryDirectory() as folder:
        for file, data in extricate.Scene.builtin_files(name).items():
            path = Path(folder) / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        spec = tomllib.loads((Path(folder) / f"{name}.toml").read_text())
        robots = [(r.get("name"), (Path(folder) / r["urdf"]).read_text(), r.get("base", "fixed"), r.get("pose", {})) for r in spec["robot"]]
        hulls = spec["robot"][0].get("geometry") == "convex-hull"
        obstacles = [(o["name"], pin_scene.se3(o.get("pose", {})), pin_scene.shape(o["shape"], Path(folder), False)) for o in spec.get("obstacle", [])]
        return of_urdfs(scene, robots, obstacles, folder, hulls)


def of_humanoid(scene):
    return of_urdfs(scene, [(None, humanoid.urdf(), "fixed", {})], disable=humanoid.JOINED)


def of_urdfs(scene, robots, obstacles=(), folder=".", hulls=False, disable=()):
    """Makes the judge of robots, (name or None, text of the URDF, base, pose), among obstacles, (name, pose, geometry of coal)."""
    world = ET.fromstring('<robot name="world"><link name="universe_"/></robot>')
    mimics, kinds = {}, {}
    for name, text, base, pose in robots:
        prefix = f"{name}/" if name else ""
        root = ET.fromstring(text)
        children = {c.get("link") for c in root.iter("child")}
        for e in [*root.iter("link"), *root.iter("joint")]:
            e.set("name", prefix + e.get("name"))
        for e in [*root.iter("parent"), *root.iter("child")]:
            e.set("link", prefix + e.get("link"))
        for e in root.findall("joint"):
            m = e.find("mimic")
            if m is not None:
                mimics[e.get("name")] = (prefix + m.get("joint"), float(m.get("multiplier", 1)), float(m.get("offset", 0)))
                e.remove(m)
        first = next(e for e in root.iter("link") if e.get("name")[len(prefix):] not in children)
        joint = ET.SubElement(world, "joint", {"name": prefix + "base", "type": base})
        ET.SubElement(joint, "parent", {"link": "universe_"})
        ET.SubElement(joint, "child", {"link": first.get("name")})
        ET.SubElement(joint, "origin", {key: " ".join(map(str, pose.get(key, [0, 0, 0]))) for key in ("xyz", "rpy")})
        world.extend(root)
    # urdfdom does not know capsules, so the geometries are read here.
    collisions = [(link.get("name"), e) for link in world.iter("link") for e in link.findall("collision")]
    for link in world.iter("link"):
        for e in link.findall("collision"):
            link.remove(e)
    model = pin.buildModelFromXML(ET.tostring(world, encoding="unicode"))
    geometry, bodies = pin.GeometryModel(), []
    for body, e in collisions:
        frame = model.frames[model.getFrameId(body, pin.FrameType.BODY)]
        origin = e.find("origin")
        place = {key: [float(x) for x in value.split()] for key, value in origin.attrib.items()} if origin is not None else {}
        shape = pin_scene.shape(entry(e.find("geometry")[0]), Path(folder), hulls)
        geometry.addGeometryObject(pin.GeometryObject(f"{body}_{len(bodies)}", frame.parentJoint, frame.placement * pin_scene.se3(place), shape))
        bodies.append(body)
    links = set(bodies)
    for name, pose, shape in obstacles:
        geometry.addGeometryObject(pin.GeometryObject(name, 0, 0, pose, shape))
        bodies.append(name)
    off, seat, pairs = {frozenset(p) for p in disable}, {}, []
    for g, body in zip(geometry.geometryObjects, bodies):
        seat[body] = g.parentJoint
    for a, b in combinations(seat, 2):
        i, j = seat[a], seat[b]
        joined = {a, b} <= links and (model.parents[i] == j or model.parents[j] == i) and (i and j or same_robot(a, b))
        if i != j and not joined and frozenset((a, b)) not in off:
            pairs.append((a, b))
    own, theirs = ({frozenset(p) for p in given} for given in (pairs, scene.pairs))
    if own != theirs:
        raise ValueError(f"checked pairs differ: {sorted(map(sorted, own ^ theirs))}")

    def full(q):
        x = pin.neutral(model)
        values = {joint.name: np.asarray(q[joint.start:joint.stop]) for joint in scene.joints}
        for follower, (lead, factor, offset) in mimics.items():
            values[follower] = factor * values[lead] + offset
        for name, value in values.items():
            joint = model.joints[model.getJointId(name)]
            if joint.nq == 2:
                value = np.array([np.cos(value[0]), np.sin(value[0])])
            x[joint.idx_q:joint.idx_q + joint.nq] = value
        return x

    return Judge(scene, model, geometry, bodies, pairs, full)


def entry(element):
    """Returns a geometry of a URDF as scene files write shapes."""
    if element.tag == "mesh":
        return {"mesh": element.get("filename").removeprefix("package://")}
    if element.tag == "box":
        return {"box": [float(x) for x in element.get("size").split()]}
    if element.tag == "sphere":
        return {"sphere": float(element.get("radius"))}
    return {element.tag: [float(element.get("radius")), float(element.get("length"))]}


def same_robot(a, b):
    """Whether two links are of one robot; the names of several robots begin with it."""
    return a.split("/")[0] == b.split("/")[0] if "/" in a or "/" in b else True
