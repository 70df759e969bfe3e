#!/usr/bin/env python3
"""What queries find among meshes with hollows, beside closed forms, for docs/benchmarks/meshes.md.

    python3 bench/hollow.py                               every shape; a minute
    python3 bench/hollow.py shelf-4 pipe                  some shapes
    python3 bench/hollow.py --programs OTHER/target/release     a built program; else cargo builds it

Needs cargo and Python alone. A ball on three sliders overlaps one wall of a mesh a little, deep inside one of its hollows; the nearest free
place is back in that hollow, the overlap and the clearance away. Forty such places a shape, `refined` and `exhaustive`."""
import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import page
import programs

CLEARANCE = 1e-4
RADIUS = 0.05
COUNT = 40
ROBOT = "<robot name='ball'><link name='w'/><link name='a'/><link name='b'/><link name='ball'><collision><geometry><sphere radius='{}'/></geometry></collision></link>{}</robot>"
JOINT = "<joint name='{}' type='prismatic'><parent link='{}'/><child link='{}'/><axis xyz='{}'/><limit lower='-9' upper='9' effort='1' velocity='1'/></joint>"


class Obj:
    """Corners and faces of a mesh."""

    def __init__(self):
        self.lines, self.count = [], 0

    def corners(self, points):
        self.lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points]
        self.count += len(points)
        return range(self.count - len(points) + 1, self.count + 1)

    def face(self, corners):
        self.lines.append("f " + " ".join(map(str, corners)))


def grid(cells, thick, depth):
    """A closed shelf of square cells, open in front (y = 0): one surface of squares of a grid of planes, as a union of walls has it."""
    at = sorted({round(k / cells + side * thick / 2, 9) for k in range(cells + 1) for side in (-1, 1)})
    deep = [0.0, depth - thick, depth]
    solid = {}
    for i in range(len(at) - 1):
        for k in range(len(at) - 1):
            for j in range(2):
                solid[i, j, k] = i % 2 == 0 or k % 2 == 0 or j == 1
    obj, known = Obj(), {}

    def corner(i, j, k):
        if (i, j, k) not in known:
            known[i, j, k] = obj.corners([(at[i], deep[j], at[k])])[0]
        return known[i, j, k]

    for (i, j, k), is_solid in solid.items():
        if not is_solid:
            continue
        for axis in range(3):
            for side in (0, 1):
                beside = [i, j, k]
                beside[axis] += 2 * side - 1
                if solid.get(tuple(beside), False):
                    continue
                low = [i, j, k]
                low[axis] += side
                u, v = (axis + 1) % 3, (axis + 2) % 3
                square = []
                for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    there = list(low)
                    there[u] += a
                    there[v] += b
                    square.append(corner(*there))
                obj.face(square if side else square[::-1])
    return obj


def shelf(cells, rng):
    thick = 0.02
    obj = grid(cells, thick, 0.4)
    places = []
    for _ in range(COUNT):
        column, row, overlap = rng.randrange(cells), rng.randrange(cells), rng.uniform(0.002, 0.02)
        x = (column + 1) / cells - thick / 2 - RADIUS + overlap
        places.append(((x, 0.2, (row + 0.5) / cells), overlap))
    return obj, places


def bin_(rng):
    """Walls of 2 mm around a metre, one closed solid, open above."""
    obj, thick = Obj(), 0.002
    outer, inner = ([(x * h, y * h, z) for z in (low, 0.5) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))] for h, low in ((0.5, -0.5), (0.5 - thick, thick - 0.5)))
    a, b = obj.corners(outer), obj.corners(inner)
    for ring, outward in ((a, True), (b, False)):
        faces = [[ring[3], ring[2], ring[1], ring[0]]] + [[ring[k], ring[(k + 1) % 4], ring[4 + (k + 1) % 4], ring[4 + k]] for k in range(4)]
        for face in faces:
            obj.face(face if outward else face[::-1])
    for k in range(4):
        m = (k + 1) % 4
        obj.face([a[4 + k], a[4 + m], b[4 + m], b[4 + k]])
    places = []
    for _ in range(COUNT):
        overlap = rng.uniform(0.002, 0.03)
        places.append(((0.5 - thick - RADIUS + overlap, rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.1)), overlap))
    return obj, places


def pipe(rng, thick=0.01, sides=48):
    """A pipe along z; 0 for a surface. The ball overlaps the middle of a stave."""
    obj, inner = Obj(), 0.7
    radii = [inner, inner + thick] if thick else [inner]
    rings = [obj.corners([(r * math.cos(2 * math.pi * k / sides), r * math.sin(2 * math.pi * k / sides), z) for k in range(sides)]) for r in radii for z in (-1, 1)]
    for k in range(sides):
        m = (k + 1) % sides
        obj.face([rings[0][m], rings[0][k], rings[1][k], rings[1][m]])
        if thick:
            obj.face([rings[2][k], rings[2][m], rings[3][m], rings[3][k]])
            obj.face([rings[0][k], rings[0][m], rings[2][m], rings[2][k]])
            obj.face([rings[3][k], rings[3][m], rings[1][m], rings[1][k]])
    # Flat staves: nearer than the corners.
    apothem = inner * math.cos(math.pi / sides)
    places = []
    for _ in range(COUNT):
        turn, overlap = 2 * math.pi * (rng.randrange(sides) + 0.5) / sides, rng.uniform(0.002, 0.03)
        away = apothem - RADIUS + overlap
        places.append(((away * math.cos(turn), away * math.sin(turn), rng.uniform(-0.5, 0.5)), overlap))
    return obj, places


def channel(rng):
    """Two sheets and the floor between them."""
    obj = Obj()
    p = obj.corners([(x, y, z) for x in (0, 1.5) for y, z in ((-2, -1), (2, -1), (2, 1), (-2, 1))])
    for face in ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4)):
        obj.face([p[k] for k in face])
    places = []
    for _ in range(COUNT):
        overlap = rng.uniform(0.002, 0.045)
        places.append(((RADIUS - overlap, rng.uniform(-1, 1), rng.uniform(-0.5, 0.5)), overlap))
    return obj, places


SHAPES = {
    "shelf-2": lambda rng: shelf(2, rng),
    "shelf-3": lambda rng: shelf(3, rng),
    "shelf-4": lambda rng: shelf(4, rng),
    "shelf-6": lambda rng: shelf(6, rng),
    "bin": bin_,
    "pipe": pipe,
    "pipe-surface": lambda rng: pipe(rng, 0.0),
    "channel": channel,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shapes", nargs="*", metavar="SHAPE", help=f"of {', '.join(SHAPES)}; all")
    parser.add_argument("--programs", type=Path, help="folder of a built extricate")
    options = parser.parse_args()
    unknown = [name for name in options.shapes if name not in SHAPES]
    if unknown:
        parser.error(f"no such shape: {', '.join(unknown)}")
    if options.programs:
        programs.folder = options.programs
    else:
        programs.build()
    rows = [measured(name) for name in options.shapes or SHAPES]
    print(page.table(["shape", "triangles", "`refined` within 5 %", "largest ratio", "`exhaustive` within 5 %", "largest ratio", "checks, median"], rows))


def measured(name):
    obj, places = SHAPES[name](random.Random(name))
    row = [name, str(sum(len(line.split()) - 3 for line in obj.lines if line.startswith("f")))]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        joints = "".join(JOINT.format(*joint) for joint in (("x", "w", "a", "1 0 0"), ("y", "a", "b", "0 1 0"), ("z", "b", "ball", "0 0 1")))
        (folder / "ball.urdf").write_text(ROBOT.format(RADIUS, joints))
        (folder / "m.obj").write_text("\n".join(obj.lines) + "\n")
        (folder / "s.toml").write_text(f"clearance = {CLEARANCE}\n[[robot]]\nurdf = 'ball.urdf'\n[[obstacle]]\nname = 'm'\nshape = {{ mesh = 'm.obj' }}\n")
        (folder / "q.jsonl").write_text("".join(json.dumps(q) + "\n" for q, _ in places))
        checks = []
        for effort in ("refined", "exhaustive"):
            done = subprocess.run([str(programs.folder / "extricate"), "query", folder / "s.toml", "--input", folder / "q.jsonl", "--json", "--effort", effort], capture_output=True, text=True)
            answers = [json.loads(line) for line in done.stdout.splitlines()]
            if len(answers) != COUNT:
                sys.exit(f"{name}: {done.stderr}")
            ratios = [answer["depth"] / (overlap + CLEARANCE) for answer, (_, overlap) in zip(answers, places)]
            row += [f"{sum(ratio <= 1.05 for ratio in ratios) / COUNT:.2f}", page.number(max(ratios))]
            checks += [sorted(answer["checks"] for answer in answers)[COUNT // 2]] if effort == "refined" else []
    return row + [str(checks[0])]


if __name__ == "__main__":
    main()
