#!/usr/bin/env python3
"""Queries of five named scenes of raw meshes, with models, beside their hulls and what is aimed at, for docs/benchmarks/meshes.md.

    python3 scripts/fetch-robots.py all
    python3 bench/meshes_named.py [--labels 100000] [--queries 60]     a few minutes
    python3 bench/meshes_named.py --programs OTHER/target/release      built programs; else cargo builds them
    python3 bench/meshes_named.py --write                              and write the page

Needs cargo and Python alone. Times are processor time of one thread, each query's second one; learning's is that of all threads."""
import argparse
import statistics
import sys
from pathlib import Path

import page
import programs
from meshes import FOLDER, KINDS, ROBOT, ring, robot, scenes
from sides import ROBOTS, ROOT

BAXTER = """srdf = "{robots}/baxter_description/srdf/baxter_manipulation.srdf"
locked = {{ head_pan = 0, l_gripper_l_finger_joint = 0, l_gripper_r_finger_joint = 0, r_gripper_l_finger_joint = 0, r_gripper_r_finger_joint = 0 }}
"""
PANDA = 'srdf = "{robots}/panda_description/srdf/panda.srdf"\nlocked = {{ panda_finger_joint1 = 0.02 }}\n'
TABLE = '[[obstacle]]\nname = "table"\nshape = { box = [1.2, 1.6, 0.05] }\npose = { xyz = [0.3, 0, -0.03] }\n'
BALL = '[[obstacle]]\nname = "ball"\nshape = { sphere = 0.035 }\npose = { xyz = [0.09, 0, 0.05] }\n'
# Robot, the rest of its entry, obstacles around it (`None`: those of the first drawn scene), and the target of the median [us].
NAMED = {
    "a Panda before a ring (panda-torus)": ("panda", PANDA, (0.25, 0.05, 0.45, 0.5, TABLE), 120),
    "an xArm 7 inside a ring (xarm7-ring)": ("xarm7", "", (0.18, 0.06, 0.3, 0.35, ""), 500),
    "Baxter's two arms (baxter-self)": ("baxter", BAXTER, "", 5000),
    "an Allegro hand and a ball": ("allegro", "", BALL, 3000),
    "ANYmal among what is drawn": ("anymal", "", None, 2000),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=int, default=100_000, help="of a model of each scene")
    parser.add_argument("--queries", type=int, default=60, help="of each scene")
    parser.add_argument("--programs", type=Path, help="folder of a built extricate and extricate-bench")
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks/meshes.md")
    options = parser.parse_args()
    if options.programs:
        programs.folder = options.programs
    else:
        programs.build()
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows = []
    for title in NAMED:
        rows.append(measured(title, options))
        print(*rows[-1], sep=" | ", flush=True)
    head = ["scene", "aim, us", "raw meshes, us", "mean", "checks", "learning, s", "hulls, us", "mean", "checks", "ratio"]
    text = f"Models of {options.labels:,} labels, {options.queries} queries each.\n\n{page.table(head, rows)}"
    print(text)
    if options.write:
        page.put(ROOT / "docs" / "benchmarks" / "meshes.md", "bench/meshes_named.py", text, "Raw meshes beside hulls")


def measured(title, options):
    """Measures a scene and returns its row."""
    name, *_, aim = NAMED[title]
    row, medians = [title, page.number(aim)], []
    for kind in KINDS:
        scene = written(title, kind)
        model = scene.with_suffix(".model")
        learning = programs.learn(scene, model, options.labels)["cpu_seconds"]
        queries = programs.sample(scene, options.queries, 7)
        answers = programs.answers(model, queries + queries)[len(queries):]
        seconds = [1e6 * answer["seconds"] for answer in answers]
        medians.append(statistics.median(seconds))
        checks = statistics.median(answer["checks"] for answer in answers)
        row += [*map(page.number, (medians[-1], statistics.mean(seconds), checks)), *([page.number(learning)] if kind == "mesh" else [])]
    return [*row, page.number(medians[0] / medians[1])]


def written(title, kind):
    """Writes the file of a scene with its links as they are, or as hulls."""
    name, entry, around, _ = NAMED[title]
    if around is None:
        return scenes(name, 1)[kind]
    if not isinstance(around, str):
        major, minor, x, z, rest = around
        ring(FOLDER / f"{name}-ring.stl", major, minor, 64, 24)
        around = f'[[obstacle]]\nname = "ring"\nshape = {{ mesh = "{name}-ring.stl" }}\npose = {{ xyz = [{x}, 0, {z}], rpy = [0, 1.5707963, 0] }}\n{rest}'
    path = FOLDER / f"named-{name}-{kind}.toml"
    path.write_text(robot(name, kind) + entry.format(robots=ROBOTS) + around)
    return path


if __name__ == "__main__":
    missing = [urdf for urdf, *_ in ROBOT.values() if not (ROBOTS / urdf).exists()]
    if missing:
        sys.exit(f"{ROBOTS / missing[0]}: not found; python3 scripts/fetch-robots.py all")
    main()
