"""One URDF, loaded by extricate and by pinocchio + coal, and their verdicts compared; prints one line of JSON.

    python3 bench/robots_one.py ROBOT.urdf ROOT

ROOT is the folder in which packages are looked for. `bench/robots.py` runs it for many files, each in a process of its own."""
import functools
import json
import os
import re
import sys
import time
import warnings
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

import extricate

CONFIGS = 100
# Time after which no more configurations are compared, for large robots of fine meshes.
SECONDS = 30
# Tolerance of the iterative algorithms of both sides [m].
TOLERANCE = 1e-5


def package_folders(urdf, root):
    """Returns the folders of the packages that a URDF names, and those that it lies in."""
    text = urdf.read_text(errors="replace")
    names = set(re.findall(r"(?:package|model):/*([^/\"']+)/", text))
    found = list(urdf.parents[: len(urdf.relative_to(root).parts)])
    for folder, subfolders, _ in os.walk(root):
        found += [Path(folder) for name in subfolders if name in names]
    return list(dict.fromkeys(str(folder) for folder in found))


def message(error):
    return f"{type(error).__name__}: {' '.join(str(error).split())[:300]}"


def theirs(urdf, packages):
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(urdf))
    return model, pin.buildGeomFromUrdf(model, str(urdf), pin.GeometryType.COLLISION, package_dirs=packages)


def ours(urdf, packages):
    """Loads the scene; None for a robot without moving joints, which counts as an obstacle."""
    try:
        return extricate.Scene(extricate.Robot(urdf, packages=packages))
    except ValueError as error:
        if "every joint is fixed" not in str(error):
            raise
        slider = """<robot name="slider"><link name="rail"/><link name="far"/><joint name="slide" type="prismatic">
            <parent link="rail"/><child link="far"/><limit lower="0" upper="1"/></joint></robot>"""
        try:
            extricate.Scene(slider, [extricate.Fixture(urdf, packages=packages)])
        except ValueError as error:
            if "no collision geometry" not in str(error):
                raise
        return None


class Positions:
    """Converts configurations of extricate to those of pinocchio: joints by name, with mimic joints where they follow."""

    def __init__(self, urdf, scene, model):
        self.scene, self.model = scene, model
        self.mimic = {}
        # This parser refuses undeclared XML prefixes.
        text = re.sub(r"(</?)\w+:", r"\1", re.sub(r"\s\w+:(\w+\s*=)", r" _\1", urdf.read_text(errors="replace")))
        joints = ET.fromstring(re.sub(r"^\s*<\?xml[^>]*>", "", text)).findall("joint")
        names = {joint.get("name") for joint in joints}
        for joint in joints:
            follows = joint.find("mimic")
            if follows is not None and follows.get("joint") in names:
                number = lambda name, otherwise: float(follows.get(name, otherwise))
                self.mimic[joint.get("name")] = (follows.get("joint"), number("multiplier", 1), number("offset", 0))

    def full(self, q):
        import pinocchio as pin

        x = pin.neutral(self.model)
        own = {joint.name: (joint, q[joint.start : joint.stop]) for joint in self.scene.joints}

        def position(name):
            if name in self.mimic:
                followed, multiplier, offset = self.mimic[name]
                return multiplier * position(followed) + offset
            return float(own[name][1][0]) if name in own else 0.0

        for number in range(1, self.model.njoints):
            joint, name = self.model.joints[number], self.model.names[number]
            if name in own and own[name][0].kind == "planar":
                a = own[name][1]
                value = [a[0], a[1], np.cos(a[2]), np.sin(a[2])]
            elif name in own and own[name][0].kind in ("floating", "spherical"):
                value = own[name][1]
            else:
                angle = position(name)
                value = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
            x[joint.idx_q : joint.idx_q + joint.nq] = value
        return x


def winding(triangles, point):
    """Returns the winding number of closed triangles (n, 3, 3) around a point (van Oosterom and Strackee 1983)."""
    a, b, c = (triangles[:, k] - point for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    top = np.einsum("ij,ij->i", a, np.cross(b, c))
    below = la * lb * lc + np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la
    below += np.einsum("ij,ij->i", c, a) * lb
    return np.arctan2(top, below).sum() / (2 * np.pi)


def is_inside(first, second):
    """Whether a corner of one is inside the other, if that is a mesh; each is (geometry, placement)."""
    import coal

    for (outer, outer_at), (inner, inner_at) in ((first, second), (second, first)):
        if not isinstance(outer, coal.BVHModelBase):
            continue
        points = np.array(outer.vertices())
        triangles = np.array([[t[0], t[1], t[2]] for t in (outer.tri_indices(k) for k in range(outer.num_tris))])
        if isinstance(inner, coal.BVHModelBase):
            corner = np.array(inner.vertices())[0]
        else:
            corner = np.zeros(3)
        if abs(winding(points[triangles], outer_at.inverse().transform(inner_at.transform(corner)))) > 0.5:
            return True
    return False


def area(vertices, triangles):
    a, b, c = (np.asarray(vertices)[np.asarray(triangles)[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


def is_misread(part):
    """Whether the areas of a file's mesh in coal and trimesh differ: coal mixes up indices in files with several meshes."""
    import coal
    import trimesh

    if not isinstance(part.geometry, coal.BVHModelBase) or not Path(part.meshPath).is_file():
        return False
    try:
        mesh = trimesh.load(part.meshPath, force="mesh")
    except Exception:
        return False
    expected = area(mesh.vertices * np.asarray(part.meshScale).ravel(), mesh.faces)
    indices = [part.geometry.tri_indices(k) for k in range(part.geometry.num_tris)]
    found = area(part.geometry.vertices(), [[t[0], t[1], t[2]] for t in indices])
    return abs(found - expected) > 0.01 * expected


class Judge:
    def __init__(self, urdf, scene, model, geometry):
        self.positions = Positions(urdf, scene, model)
        self.scene, self.model, self.geometry, self.data = scene, model, geometry, model.createData()
        self.placed = geometry.createData()
        self.misread = functools.lru_cache(None)(lambda k: is_misread(geometry.geometryObjects[k]))
        self.of_link = {}
        for number, part in enumerate(geometry.geometryObjects):
            self.of_link.setdefault(model.frames[part.parentFrame].name, []).append(number)

    def parts(self, a, b):
        """Yields all pairs of shapes, with poses, of two links."""
        import coal

        def placed(k):
            at = self.placed.oMg[k]
            return self.geometry.geometryObjects[k].geometry, coal.Transform3s(at.rotation, at.translation)

        of_b = [placed(j) for j in self.of_link.get(b, ())]
        return [(*placed(i), *other) for i in self.of_link.get(a, ()) for other in of_b]

    def collides(self, parts):
        import coal

        request = coal.CollisionRequest()
        request.security_margin, request.enable_contact = self.scene.clearance, False
        return any(coal.collide(*pair, request, coal.CollisionResult()) for pair in parts)

    def nearest(self, parts):
        import coal

        distance = lambda pair: coal.distance(*pair, coal.DistanceRequest(), coal.DistanceResult())
        return min(((distance(pair), k) for k, pair in enumerate(parts)), default=(np.inf, -1))

    def disagreements(self):
        import pinocchio as pin

        found, compared, begun = [], 0, time.monotonic()
        pairs = [tuple(pair) for pair in self.scene.pairs]
        for q in self.scene.sample(CONFIGS, seed=1):
            if time.monotonic() - begun > SECONDS:
                break
            pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.placed, self.positions.full(q))
            colliding = {tuple(pair) for pair in self.scene.colliding_pairs(q)}
            for pair in pairs:
                parts = self.parts(*pair)
                compared += 1
                if (pair in colliding) != self.collides(parts):
                    found.append(self.kind(pair, pair in colliding, parts))
        return compared, found

    def kind(self, pair, collides, parts):
        distance, nearest = self.nearest(parts)
        if not parts:
            # urdfdom drops links whose inertia it does not like.
            return "not there"
        if abs(distance - self.scene.clearance) < TOLERANCE:
            return "within"
        if collides and any(is_inside(part[:2], part[2:]) for part in parts):
            return "inside"
        if any(self.misread(k) for link in pair for k in self.of_link[link]):
            return "misread"
        return f"other: {pair[0]} - {pair[1]}: {'collides' if collides else 'free'} here, {distance:.6f} m there"


def main():
    urdf, root = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    packages, told = package_folders(urdf, root), {"file": str(urdf.relative_to(root))}
    scene = model = None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            model, geometry = theirs(urdf, packages)
        except Exception as error:
            told["theirs"] = message(error)
        try:
            scene = ours(urdf, packages)
            told["coordinates"] = scene.nq if scene else 0
        except Exception as error:
            told["ours"] = message(error)
            told["length"] = len(str(error))
    print(json.dumps(told), flush=True)
    if scene is not None and model is not None:
        told["compared"], told["found"] = Judge(urdf, scene, model, geometry).disagreements()
        print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main()
