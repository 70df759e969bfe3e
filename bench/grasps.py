"""Squeezed grasps released, beside opening the hand and opening and closing it: what penetrates, which fingers still touch.

    python3 -m venv target/peers && target/peers/bin/pip install -r bench/requirements.txt example-robot-data extricate
    target/peers/bin/python bench/grasps.py                     # the Allegro hand, twelve objects, 200 grasps each: an hour
    target/peers/bin/python bench/grasps.py --grasps 20 --objects ball,box
    target/peers/bin/python bench/grasps.py --hand dex3         # the three-fingered hand of Unitree's G1

A good grasp is made by closing the fingers of a random posture until they touch; its flexion joints are then squeezed by 0.05,
0.15 and 0.3 rad. Each side gets the same squeezed hands. Penetration is judged by pinocchio + coal, on the same geometry.
Writes target/bench/grasps-HAND.json and the tables of docs/benchmarks/grasps.md (`--write` only the latter)."""
import argparse
import json
import time
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np

import extricate
from page import put
from pin_scene import PinScene

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "target" / "bench"
SQUEEZES = [0.05, 0.15, 0.3]
TOUCH, CLEARANCE = 2e-3, 1e-4


class HandOf:
    """A hand: its file, which joints flex and in which sense, and how a grasp begins.

    root: the link of a larger robot with which the hand begins.
    turns: roll, pitch and yaw of objects that fit the hand only so.
    finger: a function from the name of a link to its finger; None for the palm."""

    def __init__(self, name, urdf, center, flex, open_, spread, finger, root=None, turns=()):
        self.name, self.urdf, self.center, self.finger, self.root, self.turns = name, urdf, center, finger, root, dict(turns)
        self.flex, self.open, self.spread = np.array(flex, float), np.array(open_, float), np.array(spread, float)

    def file(self, folder, robots):
        """The URDF of the hand alone."""
        if self.root is None:
            return robots / self.urdf
        robot = ET.parse(robots / self.urdf).getroot()
        kept, joints = {self.root}, robot.findall("joint")
        for _ in joints:
            kept |= {j.find("child").get("link") for j in joints if j.find("parent").get("link") in kept}
        for element in list(robot):
            link = element.find("parent").get("link") if element.tag == "joint" else element.get("name")
            if element.tag not in ("link", "joint") or link not in kept:
                robot.remove(element)
        path = folder / f"{self.name}.urdf"
        path.write_bytes(ET.tostring(robot))
        return path

    def scene_file(self, folder, title, shape, robots):
        text = f"""clearance = {CLEARANCE}
[[robot]]
urdf = "{self.file(folder, robots)}"
packages = ["{robots.parent.parent}"]
geometry = "convex-hull"
[[obstacle]]
name = "object"
shape = {shape}
pose = {{ xyz = {list(self.center)}, rpy = {list(self.turns.get(title, (0, 0, 0)))} }}
"""
        path = folder / f"{self.name}-{title}.toml"
        path.write_text(text)
        scene = extricate.Scene.load(path)
        always = scene.disabled([]).always_colliding(200)
        # Pairs of links whose hulls always overlap are disabled, but no pair with the object.
        off = [list(pair) for pair in always if "object" not in pair]
        if off:
            path.write_text(text + f"[pairs]\ndisable = {json.dumps(off)}\n")
            scene = extricate.Scene.load(path)
        return path, scene


def allegro_finger(link):
    """Returns the finger of a link: each has four links, numbered one after another."""
    words = link.replace("_tip", "").split("_")
    return int(float(words[-1])) // 4 if words[0] == "link" else None


def dex3_finger(link):
    return next((name for name in ("thumb", "middle", "index") if name in link), None)


HANDS = {
    "allegro": HandOf("allegro", "allegro_hand_description/urdf/allegro_right_hand.urdf", (0.09, 0, 0.08),
                      [0, 1, 1, 1] * 3 + [0, 0, 1, 1], [0.0] * 12 + [1.1, 0.5, 0.0, 0.0], [0.15, 0, 0, 0] * 3 + [0.3, 0.3, 0, 0],
                      allegro_finger),
    # The fingers are thumb, middle and index; negative angles close the thumb.
    "dex3": HandOf("dex3", "g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf", (0.09, 0.06, 0),
                   [0, -1, -1, 1, 1, 1, 1], [0, 0.6, 0, 0, 0, 0, 0], [0.3, 0.3, 0.3, 0.1, 0.1, 0.1, 0.1],
                   dex3_finger, "right_hand_palm_link", {"box": (np.pi / 2, 0, 0), "torus": (np.pi / 2, 0, 0)}),
}
TITLES = {"allegro": "Allegro", "dex3": "Dex3-1 (Unitree G1)"}


def objects():
    """Makes twelve objects: six shapes and six closed meshes."""
    shapes = {"ball": "{ sphere = 0.035 }", "small-ball": "{ sphere = 0.025 }", "cylinder": "{ cylinder = [0.03, 0.16] }",
              "rod": "{ cylinder = [0.015, 0.2] }", "box": "{ box = [0.05, 0.14, 0.05] }", "capsule": "{ capsule = [0.028, 0.06] }"}
    meshes = {"torus": torus(0.035, 0.012), "bumps": bumpy(0.035, 0.15, 5), "smooth-bumps": bumpy(0.032, 0.3, 3),
              "egg": bumpy(0.03, 0.0, 1) * [1, 1, 1.4], "bracket": None, "star": bumpy(0.035, 0.35, 4)}
    for name, points in meshes.items():
        file = BUILD / f"object-{name}.obj"
        file.write_text(bracket() if points is None else grid_mesh(points, closed_v=name == "torus"))
        shapes[name] = f'{{ mesh = "{file}" }}'
    return shapes


def torus(radius, tube, n=48, m=24):
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n, endpoint=False), np.linspace(0, 2 * np.pi, m, endpoint=False), indexing="ij")
    ring = radius + tube * np.cos(v)
    return np.stack([ring * np.cos(u), ring * np.sin(u), tube * np.sin(v)], -1)


def bumpy(radius, height, waves, n=48, m=25):
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, n, endpoint=False), np.linspace(0, np.pi, m), indexing="ij")
    r = radius * (1 + height * np.sin(v) ** 2 * np.cos(waves * u))
    return np.stack([r * np.sin(v) * np.cos(u), r * np.sin(v) * np.sin(u), radius * np.cos(v)], -1)


def grid_mesh(points, closed_v):
    """Returns the OBJ of a grid that is closed in u, and in v or by its poles; faces look outward."""
    n, m = points.shape[:2]
    flat = points.reshape(-1, 3)
    corner = lambda i, j: (i % n) * m + j % m
    quads = [(corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)) for i in range(n) for j in range(m if closed_v else m - 1)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    x, y, z = flat[faces].transpose(1, 0, 2)
    faces = faces[np.linalg.norm(np.cross(y - x, z - x), axis=1) > 1e-12]
    x, y, z = flat[faces].transpose(1, 0, 2)
    if np.einsum("ij,ij->i", x, np.cross(y, z)).sum() < 0:
        faces = faces[:, ::-1]
    lines = [f"v {a:.9g} {b:.9g} {c:.9g}" for a, b, c in flat] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return "\n".join(lines) + "\n"


def bracket():
    """Returns the OBJ of an L of 2 cm thickness."""
    outline = np.array([(-0.03, -0.03), (0.03, -0.03), (0.03, -0.01), (-0.01, -0.01), (-0.01, 0.03), (-0.03, 0.03)])
    lines = [f"v {x} {y} {z}" for z in (-0.02, 0.02) for x, y in outline]
    k = len(outline)
    lines.append("f " + " ".join(str(i) for i in range(k, 0, -1)))
    lines.append("f " + " ".join(str(i + k) for i in range(1, k + 1)))
    lines += [f"f {i + 1} {(i + 1) % k + 1} {(i + 1) % k + 1 + k} {i + 1 + k}" for i in range(k)]
    return "\n".join(lines) + "\n"


class Trial:
    """One hand and one object: grasps made, squeezed, released, judged."""

    def __init__(self, hand, path, scene, seed):
        self.hand, self.scene, self.judge = hand, scene, PinScene(path)
        self.rng, self.checks = np.random.default_rng(seed), 0
        self.low, self.high = scene.lower, scene.upper

    def free(self, q):
        self.checks += 1
        return bool(self.scene.check(q, threads=1))

    def close(self, q, most=1.2, steps=40):
        """Closes flexion joints one after another until each touches."""
        q, moving = q.copy(), self.hand.flex != 0
        step = self.hand.flex * most / steps
        for _ in range(steps):
            for joint in np.flatnonzero(moving):
                ahead = q.copy()
                ahead[joint] = np.clip(q[joint] + step[joint], self.low[joint], self.high[joint])
                if ahead[joint] == q[joint]:
                    moving[joint] = False
                elif self.free(ahead):
                    q = ahead
                else:
                    q[joint] = bisect(lambda x: self.free(at(q, joint, x)), q[joint], ahead[joint])
                    moving[joint] = False
        return q

    def opened(self, q):
        """Moves all joints toward open, as far as needed."""
        way = lambda t: np.clip(q + t * (self.hand.open - q), self.low, self.high)
        if not self.free(way(1.0)):
            return None
        return way(bisect(lambda t: self.free(way(t)), 1.0, 0.0, 20))

    def touching(self, q):
        contacts = self.scene.contacts(q, within=CLEARANCE + TOUCH, threads=1)
        pairs = [self.scene.pairs[k] for k in contacts["pair"]]
        return {self.hand.finger(name) for pair in pairs if "object" in pair for name in pair if name != "object"} - {None}

    def good(self):
        """Draws a random grasp of at least three fingers, or None."""
        q = np.clip(self.hand.open + self.hand.spread * self.rng.normal(size=self.scene.nq), self.low, self.high)
        if not self.free(q):
            return None
        q = self.close(q)
        return q if len(self.touching(q)) >= 3 else None

    def squeezed(self, good, by):
        q = good + self.hand.flex * by * (0.5 + self.rng.random(len(good))) + 0.02 * self.rng.normal(size=len(good))
        return np.clip(q, self.low, self.high)


def at(q, joint, value):
    q = q.copy()
    q[joint] = value
    return q


def bisect(holds, good, bad, times=8):
    for _ in range(times):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


def run(hand, title, shape, grasps, seed, robots):
    path, scene = hand.scene_file(BUILD, title, shape, robots)
    trial, rows, tries = Trial(hand, path, scene, seed), [], 0
    good = []
    while len(good) < grasps and tries < 60 * grasps:
        tries += 1
        found = trial.good()
        if found is not None:
            good.append(found)
    for by in SQUEEZES:
        for start in good:
            q = trial.squeezed(start, by)
            before = trial.touching(q)
            if trial.free(q) or not before:
                continue
            closed = scene.release(start, object="object", threads=1).force_closure
            for side in SIDES:
                trial.checks, began = 0, time.thread_time()
                found, checks = SIDES[side](trial, q)
                seconds = time.thread_time() - began
                row = {"hand": hand.name, "object": title, "squeeze": by, "side": side, "seconds": seconds, "closed_before": closed}
                if found is not None:
                    least = trial.judge.least_distance(found)
                    again = scene.release(found, object="object", threads=1)
                    row |= {"penetrates": bool(least < 0), "kept": len(trial.touching(found) & before), "touched": len(before),
                            "moved": float(np.linalg.norm(found - q)), "checks": checks or trial.checks,
                            "closed": bool(again.force_closure)}
                rows.append(row)
    print(hand.name, title, len(good), "good of", tries, "tries,", len(rows) // len(SIDES), "squeezed", flush=True)
    return rows


def release(trial, q):
    grasp = trial.scene.release(q, object="object", threads=1, open=trial.hand.open)
    return (None, 0) if grasp is None else (grasp.config, grasp.checks)


def nearest(trial, q):
    answer = trial.scene.query(q)
    return (None, 0) if answer is None else (answer.witness, answer.checks)


def opened(trial, q):
    return trial.opened(q), 0


def open_and_close(trial, q):
    found = trial.opened(q)
    return (None if found is None else trial.close(found, 0.4)), 0


SIDES = {"release": release, "nearest": nearest, "open": opened, "open and close": open_and_close}


def tables(rows):
    lines = ["| squeezed by | side | grasps | none | penetrate | fingers kept | force closure kept (balls) | moved, median [rad] | checks, median |",
             "|---|---|---|---|---|---|---|---|---|"]
    for by in SQUEEZES:
        for side in SIDES:
            own = [r for r in rows if r["squeeze"] == by and r["side"] == side]
            done = [r for r in own if "kept" in r]
            balls = [r for r in own if "ball" in r["object"] and r["closed_before"]]
            kept = sum(r["kept"] for r in done) / max(1, sum(r["touched"] for r in done))
            closed = sum(r.get("closed", False) for r in balls) / max(1, len(balls))
            median = lambda key: np.median([r[key] for r in done]) if done else np.nan
            lines.append(f"| {by} rad | {side} | {len(own)} | {len(own) - len(done)} | {sum(r['penetrates'] for r in done)} | {kept:.2f} |"
                         f" {closed:.2f} | {median('moved'):.3f} | {median('checks'):.0f} |")
    own = [r["seconds"] for r in rows if r["side"] == "release"]
    flat = [r["seconds"] for r in rows if r["side"] == "release" and not is_mesh(r["object"])]
    rate = lambda some: f"{1 / np.mean(some):.0f}" if some else "-"
    lines += ["", f"Releases a second and core, from Python one at a time: {rate(flat)} of shapes, {rate([s for s in own if s not in flat])} of meshes."]
    return "\n".join(lines)


def is_mesh(title):
    return title in {"torus", "bumps", "smooth-bumps", "egg", "bracket", "star"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--grasps", type=int, default=200, help="of each hand and object")
    parser.add_argument("--hand", choices=HANDS, default="allegro")
    parser.add_argument("--objects", help="some of them, between commas")
    parser.add_argument("--robots", type=Path, default=ROOT / "robots" / "example-robot-data" / "robots")
    parser.add_argument("--write", action="store_true", help="only write the page again")
    args = parser.parse_args()
    BUILD.mkdir(parents=True, exist_ok=True)
    figures = BUILD / f"grasps-{args.hand}.json"
    if not args.write:
        chosen = args.objects.split(",") if args.objects else None
        made = {title: shape for title, shape in objects().items() if chosen is None or title in chosen}
        rows = [row for seed, (title, shape) in enumerate(made.items())
                for row in run(HANDS[args.hand], title, shape, args.grasps, seed, args.robots)]
        figures.write_text(json.dumps(rows))
    text = tables(json.loads(figures.read_text()))
    print(text)
    part = "bench/grasps.py" + ("" if args.hand == "allegro" else f" --hand {args.hand}")
    put(ROOT / "docs" / "benchmarks" / "grasps.md", part, f"## {TITLES[args.hand]}\n\n{text}", "Grasps released")


if __name__ == "__main__":
    main()
