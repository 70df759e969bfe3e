#!/usr/bin/env python3
"""What queries find among meshes with hollows, beside closed forms, for docs/benchmarks/meshes.md.

    python3 bench/hollow.py                               every shape; a minute
    python3 bench/hollow.py shelf-4 pipe                  some shapes
    python3 bench/hollow.py --programs OTHER/target/release     a built program; else cargo builds it

Needs cargo and Python alone. A ball on three sliders overlaps one wall of a mesh a little, deep inside one of its hollows; the nearest free
place is back in that hollow, no farther than the way straight back. Forty such places a shape, `refined` and `exhaustive`."""
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
    """Collects the corners and faces of a mesh."""

    def __init__(self):
        self.lines, self.count = [], 0

    def corners(self, points):
        self.lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points]
        self.count += len(points)
        return range(self.count - len(points) + 1, self.count + 1)

    def face(self, corners):
        self.lines.append("f " + " ".join(map(str, corners)))


def grid(cells, thick, depth):
    """Makes a shelf of square cells, open in front (y = 0), as the closed surface of the union of its walls."""
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
    """Makes a bin of 1 m with walls of 2 mm: one closed solid, open above."""
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
    """Makes a pipe along z; a thickness of 0 makes a surface. The ball overlaps the middle of a stave."""
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
    # Staves are flat, so that their middle is nearer than their corners.
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


def revolved(profile, sides, closed=True):
    """Revolves a profile (r, z) around z; the solid lies to the left of the profile."""
    obj = Obj()
    rings = [obj.corners([(r * math.cos(2 * math.pi * k / sides), r * math.sin(2 * math.pi * k / sides), z) for k in range(sides)]) if r else obj.corners([(0.0, 0.0, z)]) for r, z in profile]
    for low, high in zip(rings, rings[1:]):
        for k in range(sides):
            m = (k + 1) % sides
            corners = [low[k % len(low)], low[m % len(low)], high[m % len(high)], high[k % len(high)]]
            obj.face(list(dict.fromkeys(corners)))
    return obj


def cup(rng):
    """Makes a cup of 48 sides with a round bottom and walls of 10 mm."""
    def bowl(r, low):
        return [(r * math.sin(math.pi / 2 * k / 12), low - r * math.cos(math.pi / 2 * k / 12)) for k in range(13)]

    outer, inner = bowl(0.31, 0.0) + [(0.31, 0.4)], bowl(0.3, 0.0) + [(0.3, 0.4)]
    obj = revolved(outer + inner[::-1], 48)
    places = []
    for _ in range(COUNT):
        turn, overlap = rng.uniform(0, 2 * math.pi), rng.uniform(0.002, 0.03)
        if rng.random() < 0.5:
            tilt = rng.uniform(0.2, 1.3)
            outward = (math.sin(tilt) * math.cos(turn), math.sin(tilt) * math.sin(turn), -math.cos(tilt))
            middle = (0.0, 0.0, 0.0)
        else:
            outward, middle = (math.cos(turn), math.sin(turn), 0.0), (0.0, 0.0, rng.uniform(0.05, 0.3))
        places.append((along(middle, outward, 0.3 - RADIUS + overlap), outward))
    return obj, places


def bend(rng, sides=32, steps=24, major=0.6, inner=0.25, thick=0.01):
    """Makes a pipe bent by a quarter circle, open at both ends."""
    obj, rings = Obj(), []
    for r in (inner + thick, inner):
        rings.append([])
        for step in range(steps + 1):
            turn = math.pi / 2 * step / steps
            around = [2 * math.pi * k / sides for k in range(sides)]
            rings[-1].append(obj.corners([((major + r * math.cos(a)) * math.cos(turn), (major + r * math.cos(a)) * math.sin(turn), r * math.sin(a)) for a in around]))
    outer, hollow = rings
    for k in range(sides):
        m = (k + 1) % sides
        for step in range(steps):
            obj.face([outer[step][k], outer[step + 1][k], outer[step + 1][m], outer[step][m]])
            obj.face([hollow[step][m], hollow[step + 1][m], hollow[step + 1][k], hollow[step][k]])
        obj.face([outer[0][k], outer[0][m], hollow[0][m], hollow[0][k]])
        obj.face([outer[-1][m], outer[-1][k], hollow[-1][k], hollow[-1][m]])
    places = []
    for _ in range(COUNT):
        turn, a, overlap = rng.uniform(0.3, 1.27), rng.uniform(0, 2 * math.pi), rng.uniform(0.002, 0.03)
        outward = (math.cos(a) * math.cos(turn), math.cos(a) * math.sin(turn), math.sin(a))
        places.append((along((major * math.cos(turn), major * math.sin(turn), 0.0), outward, inner - RADIUS + overlap), outward))
    return obj, places


def house(rng, thick=0.0, rooms=3):
    """Rooms with doors between them: walls left and right of each door and above it, sheets of their own, or boxes."""
    obj = Obj()

    def wall(axis, at, low, high, foot, head):
        """Across `axis` (0 or 1) at `at`, from `low` to `high` along the other one."""
        def point(off, along_, z):
            return (at + off, along_, z) if axis == 0 else (along_, at + off, z)

        if thick == 0:
            steps = 4
            grid_ = [obj.corners([point(0.0, low + (high - low) * k / steps, z) for k in range(steps + 1)]) for z in (foot, head)]
            for k in range(steps):
                obj.face([grid_[0][k], grid_[0][k + 1], grid_[1][k + 1], grid_[1][k]])
            return
        c = obj.corners([point(off, u, z) for off in (-thick / 2, thick / 2) for u in (low, high) for z in (foot, head)])
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        for face in faces:
            corners = [c[k] for k in face]
            obj.face(corners if axis == 0 else corners[::-1])

    walls = []
    for axis in (0, 1):
        for at in range(rooms + 1):
            for k in range(rooms):
                spans = [(k, k + 0.4), (k + 0.6, k + 1)] if 0 < at < rooms else [(k, k + 1)]
                for low, high in spans:
                    walls.append((axis, float(at), low + thick, high - thick))
                    wall(*walls[-1], 0.0, 1.0)
                if 0 < at < rooms:
                    wall(axis, float(at), k + 0.4 + thick, k + 0.6 - thick, 0.8, 1.0)
    places = []
    for _ in range(COUNT):
        axis, at, low, high = rng.choice(walls)
        side, overlap = rng.choice((-1, 1)), rng.uniform(0.002, 0.03)
        off = at + side * (thick / 2 + RADIUS - overlap)
        u = rng.uniform(low + 2 * RADIUS, high - 2 * RADIUS)
        outward = (-side, 0.0, 0.0) if axis == 0 else (0.0, -side, 0.0)
        places.append(((off, u, rng.uniform(0.2, 0.7)) if axis == 0 else (u, off, rng.uniform(0.2, 0.7)), outward))
    return obj, places


def scan(rng, count=40):
    """The floor and the walls of a room of two metres as a scanner sees them: 2 mm of noise, no thickness."""
    obj, places = Obj(), []
    for axis, at, side in ((2, 0.0, 1), (0, 0.0, 1), (0, 2.0, -1), (1, 0.0, 1), (1, 2.0, -1)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        rows = []
        for i in range(count + 1):
            row = []
            for k in range(count + 1):
                point = [0.0, 0.0, 0.0]
                point[axis], point[u], point[v] = at + rng.uniform(-0.002, 0.002), 2 * i / count, 2 * k / count
                row.append(tuple(point))
            rows.append(obj.corners(row))
        for i in range(count):
            for k in range(count):
                obj.face([rows[i][k], rows[i + 1][k], rows[i + 1][k + 1], rows[i][k + 1]][:: side])
        for _ in range(COUNT // 5):
            point = [0.0, 0.0, 0.0]
            point[axis], point[u], point[v] = at + side * (RADIUS - rng.uniform(0.004, 0.03)), rng.uniform(0.3, 1.7), rng.uniform(0.3, 1.7)
            outward = [0.0, 0.0, 0.0]
            outward[axis] = -side
            places.append((tuple(point), tuple(outward)))
    return obj, places


def along(point, direction, far):
    return tuple(x + far * d for x, d in zip(point, direction))


def way_back(obj, place, outward):
    """How far the ball has to go back into the hollow, straight away from the wall: no exit that is nearer is wrong, one that is farther is."""
    corners = [tuple(map(float, line.split()[1:])) for line in obj.lines if line.startswith("v")]
    near = []
    for line in obj.lines:
        if line.startswith("f"):
            face = [corners[int(k) - 1] for k in line.split()[1:]]
            near += [triangle for triangle in ((face[0], b, c) for b, c in zip(face[1:], face[2:])) if all(min(p[k] for p in triangle) - 0.2 < place[k] < max(p[k] for p in triangle) + 0.2 for k in range(3))]

    def is_free(far):
        there = along(place, outward, -far)
        return all(squared(there, *triangle) >= (RADIUS + CLEARANCE) ** 2 for triangle in near)

    low, high = 0.0, 0.08
    if is_free(low) or not is_free(high):
        sys.exit(f"{place}: not in collision, or no way back")
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (low, middle) if is_free(middle) else (middle, high)
    return high


def squared(p, a, b, c):
    """Returns the squared distance of a point and a triangle."""
    def sub(x, y):
        return (x[0] - y[0], x[1] - y[1], x[2] - y[2])

    def dot(x, y):
        return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]

    def of_edge(x, y):
        edge, offset = sub(y, x), sub(p, x)
        length = dot(edge, edge)
        t = max(0.0, min(1.0, dot(edge, offset) / length)) if length else 0.0
        rest = sub(offset, tuple(t * e for e in edge))
        return dot(rest, rest)

    u, v, w = sub(b, a), sub(c, a), sub(p, a)
    uu, uv, vv, wu, wv = dot(u, u), dot(u, v), dot(v, v), dot(w, u), dot(w, v)
    area = uu * vv - uv * uv
    if area > 0:
        s, t = (vv * wu - uv * wv) / area, (uu * wv - uv * wu) / area
        if s >= 0 and t >= 0 and s + t <= 1:
            rest = sub(w, tuple(s * x + t * y for x, y in zip(u, v)))
            return dot(rest, rest)
    return min(of_edge(a, b), of_edge(b, c), of_edge(c, a))


SHAPES = {
    "shelf-2": lambda rng: shelf(2, rng),
    "shelf-3": lambda rng: shelf(3, rng),
    "shelf-4": lambda rng: shelf(4, rng),
    "shelf-6": lambda rng: shelf(6, rng),
    "bin": bin_,
    "pipe": pipe,
    "pipe-surface": lambda rng: pipe(rng, 0.0),
    "channel": channel,
    "cup": cup,
    "bend": bend,
    "house of sheets": house,
    "house of boxes": lambda rng: house(rng, 0.04),
    "scan": scan,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shapes", nargs="*", metavar="SHAPE", help=f"of {', '.join([*SHAPES, ARM])}; all")
    parser.add_argument("--programs", type=Path, help="folder of a built extricate")
    options = parser.parse_args()
    names = [*SHAPES, ARM]
    unknown = [name for name in options.shapes if name not in names]
    if unknown:
        parser.error(f"no such shape: {', '.join(unknown)}")
    if options.programs:
        programs.folder = options.programs
    else:
        programs.build()
    rows = [row for name in options.shapes or names for row in (measured_arm() if name == ARM else [measured(name)])]
    print(page.table(["shape", "triangles", "`refined` within 5 %", "largest ratio", "`exhaustive` within 5 %", "largest ratio", "checks, median"], rows))


ARM = "arm in a shelf of 3x3"


def arm(folder):
    """The built-in arm of seven joints before a shelf of 3x3 cells, as one mesh and as boxes: scene files."""
    programs.extricate("demo", "--export", folder / "cell")
    side, thick, depth, front, foot = 0.9, 0.02, 0.35, 0.42, 0.02

    def placed(x, y, z):
        return (front + y, side * (0.5 - x), foot + thick / 2 + side * z)

    obj = grid(3, thick / side, depth)
    corners = [placed(*map(float, line.split()[1:])) for line in obj.lines if line.startswith("v")]
    faces = [line for line in obj.lines if line.startswith("f")]
    # A rotation about z keeps the orientation, so that faces still look outward.
    mesh = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners] + faces
    (folder / "cell" / "shelf.obj").write_text("\n".join(mesh) + "\n")
    head = "clearance = 1e-4\n[[robot]]\nurdf = 'robot/arm.urdf'\npackages = ['.']\n"

    def box(name, size, at):
        return f"[[obstacle]]\nname = '{name}'\nshape = {{ box = {list(size)} }}\npose = {{ xyz = {list(at)} }}\n"

    walls, long, back = "", side + thick, depth - thick / side
    for k in range(4):
        y, z = side * (0.5 - k / 3), foot + thick / 2 + side * k / 3
        walls += box(f"upright_{k}", (back, thick, long), (front + back / 2, y, foot + long / 2))
        walls += box(f"board_{k}", (back, long, thick), (front + back / 2, 0.0, z))
    walls += box("back", (thick / side, long, long), (front + depth - thick / side / 2, 0.0, foot + long / 2))
    scenes = [folder / "cell" / "mesh.toml", folder / "cell" / "boxes.toml"]
    scenes[0].write_text(head + "[[obstacle]]\nname = 'shelf'\nshape = { mesh = 'shelf.obj' }\n")
    scenes[1].write_text(head + walls)
    return scenes


def measured_arm():
    """The mesh beside the boxes, and both beside the nearest that any of the two found, `exhaustive`."""
    with tempfile.TemporaryDirectory() as folder:
        mesh, boxes = arm(Path(folder))
        queries = programs.extricate("sample", mesh, "-n", 2 * COUNT, "--seed", 1, "--colliding")
        (Path(folder) / "q.jsonl").write_text(queries)

        def answers(scene, effort):
            found = [json.loads(line) for line in programs.extricate("query", scene, "--input", Path(folder) / "q.jsonl", "--json", "--effort", effort).splitlines()]
            return [answer["depth"] for answer in found], [answer["checks"] for answer in found], [answer["seconds"] for answer in found]

        found = {(scene.stem, effort): answers(scene, effort) for scene in (mesh, boxes) for effort in ("refined", "exhaustive")}
        best = [min(depths) for depths in zip(*(depths for depths, _, _ in found.values()))]
        rows = []
        for kind in ("mesh", "boxes"):
            row = [f"{ARM}, {kind}", "-"]
            for effort in ("refined", "exhaustive"):
                ratios = [depth / least for depth, least in zip(found[kind, effort][0], best)]
                row += [f"{sum(ratio <= 1.05 for ratio in ratios) / len(ratios):.2f}", page.number(max(ratios))]
            rows.append(row + [str(sorted(found[kind, "refined"][1])[COUNT])])
        seconds = [sorted(found[kind, "refined"][2])[COUNT] for kind in ("mesh", "boxes")]
        rows[0][1] = str(sum(len(line.split()) - 3 for line in mesh.with_name("shelf.obj").read_text().splitlines() if line.startswith("f")))
        print(f"The arm in the mesh takes {page.number(seconds[0] / seconds[1])} of the time of the boxes.")
        return rows


def measured(name):
    obj, places = SHAPES[name](random.Random(name))
    known = [way_back(obj, place, found) if isinstance(found, tuple) else found + CLEARANCE for place, found in places]
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
            ratios = [answer["depth"] / least for answer, least in zip(answers, known)]
            row += [f"{sum(ratio <= 1.05 for ratio in ratios) / COUNT:.2f}", page.number(max(ratios))]
            checks += [sorted(answer["checks"] for answer in answers)[COUNT // 2]] if effort == "refined" else []
    return row + [str(checks[0])]


if __name__ == "__main__":
    main()
