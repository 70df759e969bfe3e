#!/usr/bin/env python3
"""What raw meshes cost beside their hulls: the same robots among the same obstacles drawn at random, for docs/benchmarks/meshes.md.

    python3 scripts/fetch-robots.py all
    python3 bench/meshes.py                                     every robot, three draws; half an hour
    python3 bench/meshes.py panda icub --draws 1                some robots
    python3 bench/meshes.py --labels 20000                      models of so many labels; without it nothing is learned
    python3 bench/meshes.py --programs OTHER/target/release     built programs; else cargo builds them
    python3 bench/meshes.py --write                             and write the page

Needs cargo and Python alone. A draw is 2 to 5 boxes, cylinders and rings around what the robot reaches. Pairs that collide in every other
random configuration, of raw meshes or of hulls, are not checked in either. Every scene is asked --queries random colliding configurations of
its own. Times are processor time of one thread; every query is asked twice, and the second time counts: the first one also pays for
what is prepared of a mesh once."""
import argparse
import collections
import json
import math
import random
import statistics
import struct
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import page
import programs
from sides import BUILD, ROBOTS, ROOT

FOLDER = BUILD / "meshes"
# URDF, whether its <visual> meshes are used, the point around which obstacles are drawn, and the reach [m].
ROBOT = {
    "panda": ("panda_description/urdf/panda.urdf", False, (0, 0, 0.4), 0.85),
    "talos-arm": ("talos_data/robots/talos_left_arm.urdf", False, (0, 0.2, 0.2), 0.9),
    "tiago": ("tiago_description/robots/tiago.urdf", False, (0.1, 0, 0.7), 0.9),
    "icub": ("icub_description/robots/icub_reduced.urdf", False, (0, 0, 0), 0.6),
    "allegro": ("allegro_hand_description/urdf/allegro_right_hand.urdf", True, (0.03, 0, 0.04), 0.15),
    "anymal": ("anymal_b_simple_description/robots/anymal.urdf", True, (0, 0, -0.1), 0.7),
    "solo12": ("solo_description/robots/solo12.urdf", True, (0, 0, -0.1), 0.35),
    "go1": ("go1_description/urdf/go1.urdf", True, (0, 0, -0.1), 0.45),
    "hyq": ("hyq_description/robots/hyq_no_sensors.urdf", True, (0, 0, -0.2), 0.9),
    "z1": ("z1_description/urdf/z1.urdf", False, (0, 0, 0.2), 0.7),
    "kinova": ("kinova_description/robots/kinova.urdf", False, (0, 0, 0.3), 0.8),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", False, (0, 0, 0.3), 0.7),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", True, (0, 0, 0.2), 0.9),
    "so100": ("so_arm_description/urdf/so100.urdf", False, (0, 0, 0.1), 0.35),
    "baxter": ("baxter_description/urdf/baxter.urdf", False, (0.3, 0, 0.4), 1.2),
}
KINDS = {"mesh": "raw meshes", "convex-hull": "hulls"}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=f"of {', '.join(ROBOT)}; all")
    parser.add_argument("--draws", type=int, default=3, help="scenes a robot")
    parser.add_argument("--queries", type=int, default=40, help="of each scene")
    parser.add_argument("--labels", type=int, help="of a model of each scene")
    parser.add_argument("--programs", type=Path, help="folder of a built extricate and extricate-bench")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks/meshes.md")
    options = parser.parse_args()
    unknown = [name for name in options.robots if name not in ROBOT]
    if unknown:
        parser.error(f"no such robot: {', '.join(unknown)}")
    return options


def main():
    options = arguments()
    if options.programs:
        programs.folder = options.programs
    else:
        programs.build()
    rows = []
    for name in options.robots or ROBOT:
        for draw in range(1, options.draws + 1):
            row = measured(name, draw, options)
            rows.append(row)
            print(json.dumps(row), flush=True)
    text = report(rows, options)
    print(text)
    if options.write:
        page.put(ROOT / "docs" / "benchmarks" / "meshes.md", "bench/meshes.py", text, "Raw meshes beside hulls")


def measured(name, draw, options):
    """Returns median time and checks of the queries of one draw, by kind."""
    row = {"robot": name, "draw": draw}
    for kind, scene in scenes(name, draw).items():
        asked = scene
        if options.labels:
            asked = scene.with_suffix(".model")
            row[f"{kind} learning"] = programs.learn(scene, asked, options.labels, "--threads", 1)["cpu_seconds"]
        queries = programs.sample(scene, options.queries, 7)
        answers = programs.answers(asked, queries + queries)[len(queries):]
        row[kind] = statistics.median(answer["seconds"] for answer in answers)
        row[f"{kind} mean"] = statistics.mean(answer["seconds"] for answer in answers)
        row[f"{kind} checks"] = statistics.median(answer["checks"] for answer in answers)
    row["ratio"] = row["mesh"] / row["convex-hull"]
    return row


def report(rows, options):
    def of(name, key, scale=1.0):
        return page.number(statistics.median(scale * row[key] for row in rows if row["robot"] == name))

    names = list(dict.fromkeys(row["robot"] for row in rows))
    head = ["robot", "raw meshes, us", "checks", "hulls, us", "checks", "ratio, median", "largest"]
    if options.labels:
        head += ["learning, raw meshes, s", "hulls, s"]
    lines = []
    for name in names:
        ratios = [row["ratio"] for row in rows if row["robot"] == name]
        line = [name, of(name, "mesh", 1e6), of(name, "mesh checks"), of(name, "convex-hull", 1e6), of(name, "convex-hull checks")]
        line += [page.number(statistics.median(ratios)), page.number(max(ratios))]
        if options.labels:
            line += [of(name, "mesh learning"), of(name, "convex-hull learning")]
        lines.append(line)
    every = [row["ratio"] for row in rows]
    model = f"models of {options.labels:,} labels" if options.labels else "no model"
    return (
        f"{len(rows)} scenes of {len(names)} robots, {options.queries} queries each, {model}; medians over queries, then over scenes.\n\n"
        f"{page.table(head, lines)}\n\n"
        f"Median ratio of all scenes {page.number(statistics.median(every))}, largest {page.number(max(every))}."
    )


def scenes(name, draw):
    """Writes the scene file of each kind of geometry once, and returns the paths."""
    found = {kind: FOLDER / f"{name}-{draw}-{kind}.toml" for kind in KINDS}
    if all(path.exists() for path in found.values()):
        return found
    FOLDER.mkdir(parents=True, exist_ok=True)
    around = obstacles(name, draw)
    overlapping = set()
    for kind in KINDS:
        path = FOLDER / f"{name}-{draw}-{kind}-all.toml"
        path.write_text(robot(name, kind) + around)
        overlapping |= often_colliding(path)
        path.unlink()
    pairs = f"[pairs]\ndisable = {json.dumps(sorted(map(list, overlapping)))}\n"
    for kind, path in found.items():
        path.write_text(robot(name, kind) + around + pairs)
    return found


def often_colliding(scene):
    """Returns pairs that collide in more than half of 200 random configurations."""
    drawn = FOLDER / "drawn.jsonl"
    drawn.write_text(programs.extricate("sample", scene, "-n", 200, "--seed", 5))
    counts = collections.Counter()
    for line in programs.extricate("check", scene, "--json", "--input", drawn).splitlines():
        counts.update(map(tuple, json.loads(line)["colliding"]))
    return {pair for pair, count in counts.items() if count > 100}


def robot(name, kind):
    urdf, is_visual, _, _ = ROBOT[name]
    path = ROBOTS / urdf
    if not path.exists():
        sys.exit(f"{path}: not found; python3 scripts/fetch-robots.py all")
    text = f'clearance = 1e-4\n[[robot]]\nurdf = "{path}"\npackages = ["{ROBOTS.parent.parent}"]\n'
    if not is_visual:
        return text + f'geometry = "{kind}"\n'
    text += 'geometry = "visual"\n'
    links = [link.get("name") for link in ET.parse(path).getroot().findall("link") if link.find("visual/geometry/mesh") is not None]
    hulls = ", ".join(f'"{link}" = "convex-hull"' for link in links)
    return text + (f"links = {{ {hulls} }}\n" if kind == "convex-hull" else "")


def obstacles(name, draw):
    """Draws boxes, cylinders and rings, below the trunk if the robot has legs."""
    _, _, middle, reach = ROBOT[name]
    rng = random.Random(f"{name}-{draw}")
    text = ""
    for k in range(rng.randint(2, 5)):
        direction = [rng.gauss(0, 1) for _ in range(3)]
        direction[2] = math.copysign(direction[2], 1 if middle[2] >= 0 else -1)
        away = reach * rng.uniform(0.35, 0.9) / math.hypot(*direction)
        at = [m + away * d for m, d in zip(middle, direction)]
        turn = [rng.uniform(-3, 3) for _ in range(3)]
        kind = rng.choice(["box", "box", "cylinder", "ring"])
        if kind == "box":
            shape = f"box = {[reach * rng.uniform(0.08, 0.4) for _ in range(3)]}"
        elif kind == "cylinder":
            shape = f"cylinder = {[reach * rng.uniform(0.03, 0.1), reach * rng.uniform(0.4, 1.2)]}"
        else:
            file = FOLDER / f"{name}-{draw}-ring-{k}.stl"
            ring(file, reach * rng.uniform(0.15, 0.4), reach * rng.uniform(0.03, 0.1))
            shape = f'mesh = "{file.name}"'
        text += f'[[obstacle]]\nname = "{kind}_{k}"\nshape = {{ {shape} }}\npose = {{ xyz = {at}, rpy = {turn} }}\n'
    return text


def ring(path, major, minor, around=48, across=16):
    """A torus as binary STL."""
    def point(i, k):
        u, v = 2 * math.pi * i / around, 2 * math.pi * k / across
        radius = major + minor * math.cos(v)
        return radius * math.cos(u), radius * math.sin(u), minor * math.sin(v)

    triangles = []
    for i in range(around):
        for k in range(across):
            a, b, c, d = point(i, k), point(i + 1, k), point(i + 1, k + 1), point(i, k + 1)
            triangles += [(a, b, c), (a, c, d)]
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *(x for corner in t for x in corner), 0) for t in triangles)
    path.write_bytes(b"ring".ljust(80) + struct.pack("<I", len(triangles)) + rows)


if __name__ == "__main__":
    main()
