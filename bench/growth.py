#!/usr/bin/env python3
"""How a query grows with joints, with points of a cloud, with triangles and with obstacles, for docs/benchmarks/query.md.

    python3 bench/growth.py [--queries 100] [--program DIR] [--only joints|points|triangles|boxes] [--write]

Draws its own scenes: chains of 6 to 60 joints among boxes, and an arm of six joints beside a cloud of 100 to 100,000 points, a torus of 100 to
100,000 triangles, or 1 to 1,000 boxes. Every scene gets the same number of random colliding queries, without a model, on one thread. Times are processor time; compare the
rows of one run alone.
"""
import argparse
import json
import math
import pathlib
import random
import subprocess

from page import put
from sides import BUILD, ROOT

FOLDER = BUILD / "growth"
LINK = 0.12


def chain(joints, length):
    """The URDF of a chain whose axes turn about y and z one after the other."""
    parts = ['<robot name="chain"><link name="l0"/>']
    for k in range(joints):
        axis, limit = ("0 0 1" if k % 2 == 0 else "0 1 0"), 2.6 if joints <= 10 else 0.7
        shape = f'<collision><origin xyz="{length / 2} 0 0" rpy="0 1.5708 0"/><geometry><cylinder radius="{length / 4}" length="{length * 0.9}"/></geometry></collision>'
        parts.append(f'<link name="l{k + 1}">{shape}</link>')
        parts.append(f'<joint name="j{k + 1}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="{length if k else 0} 0 0"/>'
                     f'<axis xyz="{axis}"/><limit lower="-{limit}" upper="{limit}" effort="1" velocity="1"/></joint>')
    return "".join(parts) + "</robot>"


def box(name, size, at):
    return f'\n[[obstacle]]\nname = "{name}"\nshape = {{ box = {size} }}\npose = {{ xyz = {[round(x, 4) for x in at]} }}\n'


def around(rng, least, most):
    """A point in a shell about the origin."""
    while True:
        point = [rng.uniform(-most, most) for _ in range(3)]
        if least < math.dist(point, [0, 0, 0]) < most:
            return point


def scene(name, joints, obstacles, length=LINK):
    folder = FOLDER / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "chain.urdf").write_text(chain(joints, length))
    (folder / "scene.toml").write_text(f'clearance = 1e-4\nmetric = {{ kind = "joint" }}\n[[robot]]\nurdf = "chain.urdf"\n{obstacles}')
    return folder


def of_joints(joints):
    """The chain is as long whatever its number of joints, and the boxes stay."""
    rng, length = random.Random(1), 1.2 / joints
    boxes = "".join(box(f"box{k}", [0.2] * 3, around(rng, 0.45, 1.1)) for k in range(12))
    return scene(f"joints-{joints}", joints, boxes, length)


def of_points(points):
    """A sphere of points, each a ball whose radius lets neighbours overlap."""
    rng = random.Random(2)
    folder = scene(f"points-{points}", 6, '[[obstacle]]\nname = "cloud"\nshape = { points = "cloud.txt", radius = 0.005 }\npose = { xyz = [0.4, 0, 0.1] }\n')
    rows = []
    for _ in range(points):
        at = [rng.gauss(0, 1) for _ in range(3)]
        rows.append(" ".join(f"{0.15 * x / math.hypot(*at):.5f}" for x in at))
    (folder / "cloud.txt").write_text("\n".join(rows) + "\n")
    return folder


def of_triangles(triangles):
    """A torus that the arm can reach through."""
    across = max(4, round(math.sqrt(triangles / 8)))
    along = triangles // (2 * across)
    folder = scene(f"triangles-{triangles}", 6, '[[obstacle]]\nname = "torus"\nshape = { mesh = "torus.obj" }\npose = { xyz = [0.4, 0, 0.1] }\n')
    lines = []
    for i in range(along):
        for j in range(across):
            u, v = 2 * math.pi * i / along, 2 * math.pi * j / across
            radius = 0.2 + 0.05 * math.cos(v)
            lines.append(f"v {radius * math.cos(u):.6f} {radius * math.sin(u):.6f} {0.05 * math.sin(v):.6f}")
    corner = lambda i, j: (i % along) * across + j % across + 1
    for i in range(along):
        for j in range(across):
            a, b, c, d = corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)
            lines += [f"f {a} {b} {c}", f"f {a} {c} {d}"]
    (folder / "torus.obj").write_text("\n".join(lines) + "\n")
    return folder


def of_boxes(boxes):
    rng = random.Random(3)
    return scene(f"boxes-{boxes}", 6, "".join(box(f"box{k}", [0.1] * 3, [0.4, 0, 0.1] if k == 0 else around(rng, 0.4, 2.0)) for k in range(boxes)))


SERIES = {
    "joints": (of_joints, [6, 10, 15, 30, 60]),
    "points": (of_points, [100, 1_000, 10_000, 100_000]),
    "triangles": (of_triangles, [100, 1_000, 10_000, 100_000]),
    "boxes": (of_boxes, [1, 10, 100, 1_000]),
}


def measure(folder, options):
    """CPU milliseconds and checks of each query."""
    queries = folder / f"queries-{options.queries}.jsonl"
    file = folder / "scene.toml"
    drawn = subprocess.run([options.program / "extricate", "sample", file, "-n", str(options.queries), "--colliding", "--seed", "5"], check=True, capture_output=True, text=True)
    queries.write_text(drawn.stdout)
    answers = subprocess.run([options.program / "extricate-bench", "query", file, queries, "refined"], check=True, capture_output=True, text=True)
    rows = [json.loads(line) for line in answers.stdout.splitlines() if line.strip()]
    return sorted(1e3 * row["seconds"] for row in rows), sorted(row["checks"] for row in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--queries", type=int, default=100, help="of each scene")
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "target/release", help="folder of extricate and extricate-bench")
    parser.add_argument("--only", choices=SERIES, action="append", help="a series; all by default")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks/query.md")
    options = parser.parse_args()
    lines = ["| | size | checks, mean | CPU ms: median | 95 % | largest | median over the first row's |", "|---|---|---|---|---|---|---|"]
    for name in options.only or SERIES:
        draw, sizes = SERIES[name]
        first = None
        for size in sizes:
            times, checks = measure(draw(size), options)
            median = times[len(times) // 2]
            first = first or median
            lines.append(f"| {name} | {size:,} | {sum(checks) / len(checks):.1f} | {median:.2f} | {times[int(0.95 * len(times))]:.2f} | {times[-1]:.2f} | {median / first:.1f} |")
            print(lines[-1], flush=True)
    if options.write:
        about = f"{options.queries} random colliding queries of each scene, no model, one thread. `bench/growth.py` draws the scenes."
        put(ROOT / "docs" / "benchmarks" / "query.md", "bench/growth.py", "## Growth, drawn scenes\n\n" + about + "\n\n" + "\n".join(lines), "Queries, measured")


if __name__ == "__main__":
    main()
