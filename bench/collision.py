#!/usr/bin/env python3
"""The collision benchmark: ours, coal, fcl, and pinocchio + coal, in turns in one run, on the same poses and configurations.

    python3 -m venv target/peers && target/peers/bin/pip install -r bench/requirements.txt
    sudo apt-get install g++ libeigen3-dev libfcl-dev                     # what is absent is left out and said to be
    python3 scripts/fetch-robots.py panda_description ur_description z1_description talos_data b1_description go1_description \
        xarm_description baxter_description
    target/peers/bin/python bench/collision.py                            # about ten minutes; --quick: about two

Writes target/bench/collision.json, and from that the tables and plots of docs/benchmarks/collision.md (`--write` does only the
latter, from the last figures). Meshes and poses are handed to all sides as the same files. Each round times every side once, one
right after another, so ratios hold on a machine whose speed drifts; what is reported is the median over rounds.
"""
import argparse
import json
import statistics
import subprocess
import sys
import time

import collision_report
from sides import BUILD, ROBOTS, ROOT, Side, machine, ours_command, peer_commands

# Pairs of link meshes from the robots' files, the smallest first.
PAIRS = [
    ("ur5 forearm, upper arm", "ur_description/meshes/ur5/collision/forearm.stl", "ur_description/meshes/ur5/collision/upperarm.stl"),
    ("talos gripper, torso", "talos_data/meshes/gripper/base_link.STL", "talos_data/meshes/torso/torso_2.STL"),
    ("panda hand, link 0", "panda_description/meshes/visual/hand.dae", "panda_description/meshes/visual/link0.dae"),
    ("panda link 5, link 6", "panda_description/meshes/visual/link5.dae", "panda_description/meshes/visual/link6.dae"),
    ("ur5 forearm, upper arm (visual)", "ur_description/meshes/ur5/visual/forearm.dae", "ur_description/meshes/ur5/visual/upperarm.dae"),
    ("z1 link 1, link 0", "z1_description/meshes/collision/z1_Link01.STL", "z1_description/meshes/collision/z1_Link00.STL"),
    ("go1 thigh, b1 thigh", "go1_description/meshes/thigh.dae", "b1_description/meshes/thigh.dae"),
]
KINDS = ["random", "contact"]
CLEARANCE = 1e-4

PANDA = """clearance = 1e-4
[[robot]]
urdf = "{robots}/panda_description/urdf/panda.urdf"
srdf = "{robots}/panda_description/srdf/panda.srdf"
packages = ["{packages}"]
geometry = "{geometry}"
locked = {{ panda_finger_joint1 = 0.02 }}
"""
BOX = """[[obstacle]]
name = "box"
shape = { box = [0.2, 0.6, 0.4] }
pose = { xyz = [0.45, 0, 0.45] }
"""
RING = """[[obstacle]]
name = "ring"
shape = { mesh = "torus.stl" }
pose = { xyz = [0.45, 0, 0.5], rpy = [0, 1.5707963, 0] }
[[obstacle]]
name = "table"
shape = { box = [1.2, 1.6, 0.05] }
pose = { xyz = [0.3, 0, -0.03] }
"""


# Bars around the arm: [size], [place].
CAGE = [([0.04, 0.04, 1.2], [x, y, 0.6]) for x in (-0.5, 0.7) for y in (-0.6, 0, 0.6)]
CAGE += [([1.24, 0.04, 0.04], [0.1, y, z]) for y in (-0.6, 0.6) for z in (0.7, 1.2)]
CAGE += [([0.04, 1.24, 0.04], [x, 0, z]) for x in (-0.5, 0.7) for z in (0.7, 1.2)]
XARM = """clearance = 1e-4
[[robot]]
urdf = "{robots}/xarm_description/urdf/xarm7.urdf"
packages = ["{packages}"]
[[obstacle]]
name = "ring"
shape = {{ mesh = "torus.stl" }}
pose = {{ xyz = [0.3, 0, 0.35], rpy = [0, 1.5707963, 0] }}
"""
BAXTER = """clearance = 1e-4
[[robot]]
urdf = "{robots}/baxter_description/urdf/baxter.urdf"
srdf = "{robots}/baxter_description/srdf/baxter_manipulation.srdf"
packages = ["{packages}"]
locked = {{ head_pan = 0, l_gripper_l_finger_joint = 0, l_gripper_r_finger_joint = 0, r_gripper_l_finger_joint = 0, r_gripper_r_finger_joint = 0 }}
"""


def mesh_pairs(sides, rounds, count):
    """Times every pair, kind and side one after another; answers of the first round are compared, and brute force decides if they differ."""
    runs = [("ours", 0.0), ("coal", 0.0), ("fcl", 0.0), ("ours", CLEARANCE), ("coal", CLEARANCE)]
    runs = [run for run in runs if run[0] in sides]
    rows = []
    for number, (title, *paths) in enumerate(PAIRS):
        names, triangles = [f"a{number}", f"b{number}"], []
        for name, path in zip(names, paths):
            off = BUILD / f"{name}.off"
            sides["ours"]("convert", ROBOTS / path, off)
            triangles.append([side("load", name, off) for side in sides.values()][0]["triangles"])
        row = {"pair": title, "triangles": triangles, "kinds": {}}
        for kind in KINDS:
            poses = BUILD / f"{number}-{kind}.poses"
            made = sides["ours"]("poses", *names, kind, 0, count, number + 1, poses)["count"]
            figures = {f"{side}@{limit:g}": [] for side, limit in runs}
            for turn in range(rounds):
                for side, limit in runs[turn % len(runs):] + runs[:turn % len(runs)]:
                    out = [BUILD / f"{side}-{limit:g}.answers"] if turn == 0 else []
                    done = sides[side]("time", *names, poses, limit, *out)
                    figures[f"{side}@{limit:g}"].append(done["seconds"] / done["count"])
            row["kinds"][kind] = {"poses": made, "seconds": figures, "differences": differences(sides, runs, names, poses)}
        rows.append(row)
        print(f"{title}: {triangles}", *(f"{k} {1e6 * statistics.median(v):.1f}" for k, v in row["kinds"]["contact"]["seconds"].items()))
    return rows


def differences(sides, runs, names, poses):
    """Counts answers that differ from ours, per peer and limit; brute force decides the first twenty."""
    found = {}
    for side, limit in runs:
        if side == "ours":
            continue
        ours, theirs = ((BUILD / f"{s}-{limit:g}.answers").read_bytes() for s in ("ours", side))
        where = [k for k, (a, b) in enumerate(zip(ours, theirs)) if a != b]
        verdict = {"differ": len(where), "ours_right": 0, "theirs_right": 0, "within_1e-9": 0, "of_these_contained": 0}
        for k in where[:20]:
            truth = sides["ours"]("truth", *names, poses, limit, k)
            key = "within_1e-9" if truth["near"] is None else "ours_right" if truth["near"] == bool(ours[k]) else "theirs_right"
            verdict[key] += 1
            verdict["of_these_contained"] += truth["contained"]
        found[f"{side}@{limit:g}"] = verdict
    return found


def memory(commands, numbers):
    """Measures bytes per triangle and seconds to build. Each mesh has a process of its own, whose allocator returns freed memory."""
    rows = []
    for number in numbers:
        row = {}
        for name, command in commands.items():
            side = Side(command, MALLOC_MMAP_THRESHOLD_="65536", MALLOC_TRIM_THRESHOLD_="0")
            row[name] = side("load", "m", BUILD / f"b{number}.off")
            side.close()
        rows.append(row)
    return rows


def growth(sides, rounds, count, levels):
    triangles = []
    for level in levels:
        off = BUILD / "bumpy.off"
        sides["ours"]("make", "bumpy", level, off)
        sizes = [side("load", "g", off)["triangles"] for side in sides.values()]
        row = {"triangles": sizes[0]}
        for kind in KINDS:
            poses = BUILD / "growth.poses"
            sides["ours"]("poses", "g", "g", kind, 0, count, 3, poses)
            for turn in range(rounds):
                for name, side in sides.items():
                    done = side("time", "g", "g", poses, 0)
                    row.setdefault(f"{name} {kind}", []).append(done["seconds"] / done["count"])
        triangles.append(row)
        print("growth, triangles:", sizes[0])
    scenes = {"obstacles": [], "links": []}
    for key, sizes in [("obstacles", [1, 3, 10, 30, 100, 300, 1000]), ("links", [2, 4, 7, 10, 20, 30, 50])]:
        for size in sizes:
            links, obstacles = (7, size) if key == "obstacles" else (size, 10)
            ours, configs = sides["ours"], BUILD / "chain.configs"
            about = ours("chain", "c", links, obstacles)
            ours("configs", "c", "uniform", 4 * count, 1, configs)
            done = [ours("label", "c", configs) for _ in range(rounds)]
            mean = statistics.median(d["mean"] for d in done)
            scenes[key].append({"size": size, "pairs": about["pairs"], "mean": mean, "colliding": done[0]["colliding"]})
    return {"triangles": triangles, **scenes}


def robots(ours, rounds, count):
    """Times labels and near pairs of whole robots: hulls among boxes, raw meshes and a ring, two arms of raw meshes alone."""
    ours("make", "torus", 0.18, 0.06, 48, 48, BUILD / "torus.stl")
    panda = {"robots": ROBOTS, "packages": ROBOTS.parent.parent}
    hulls, meshes = (PANDA.format(geometry=geometry, **panda) for geometry in ("convex-hull", "mesh"))
    bars = "".join(f'[[obstacle]]\nname = "bar{k}"\nshape = {{ box = {size} }}\npose = {{ xyz = {at} }}\n' for k, (size, at) in enumerate(CAGE))
    scenes = {"panda-box": hulls + BOX, "panda-cage": hulls + bars, "panda-torus": meshes + RING, "xarm7-ring": XARM.format(**panda),
              "baxter-self": BAXTER.format(**panda)}
    return {name: robot(ours, name, text, rounds, count) for name, text in scenes.items()}


def robot(ours, name, text, rounds, count):
    import numpy as np
    import pinocchio as pin
    from pin_scene import PinScene
    path = BUILD / f"{name}.toml"
    path.write_text(text)
    about, peer = ours("scene", name, path), PinScene(path)
    assert about["joints"] == peer.joints, (about["joints"], peer.joints)
    row = {"pairs": [about["pairs"], len(peer.geometry.collisionPairs)], "kinds": {}, "call_overhead": call_overhead(pin)}
    for kind in ["uniform", "boundary"]:
        file = BUILD / f"{name}-{kind}.configs"
        ours("configs", name, kind, count, 7, file)
        rows = np.fromfile(file).reshape(-1, about["nq"])
        full = [peer.full(q) for q in rows]
        out = BUILD / f"{name}.labels"
        figures = {"ours": [], "pin": [], "contacts coarse": [], "contacts exact": [], "pin distances": [], "serial": [], "one": [], "two": []}
        for _ in range(rounds):
            figures["ours"].append(ours("label", name, file, out))
            mean = timed(lambda: [peer.collides(x) for x in full], clock=time.thread_time)[0] / len(full)
            each = [timed(peer.collides, x) for x in full]
            times = np.array([t for t, _ in each])
            figures["pin"].append({"median": float(np.median(times)), "mean": mean, "p95": float(np.quantile(times, 0.95))})
            for search in ["coarse", "exact"]:
                figures[f"contacts {search}"].append(ours("contacts", name, file, 0.02, search))
            figures["pin distances"].append(float(np.median([timed(distances, peer, x)[0] for x in full[:100]])))
            for key, threads in [("serial", 0), ("one", 1), ("two", 2)]:
                figures[key].append(ours("batch", name, file, threads)["seconds"] / len(rows))
        labels = np.fromfile(out, np.uint8).astype(bool)
        theirs = np.array([hit for _, hit in each])
        differ = np.flatnonzero(labels != theirs)
        gaps = [abs(peer.least_distance(rows[k]) - peer.clearance) for k in differ[:50]]
        row["kinds"][kind] = {"configurations": len(rows), "figures": figures, "colliding": float(labels.mean()), "differ": len(differ),
                              "only_ours_collide": int((labels & ~theirs).sum()), "farthest_from_margin": max(gaps, default=0.0)}
        print(name, kind, {k: v[-1] for k, v in figures.items()}, "differ:", len(differ))
    return row


def distances(peer, x):
    import pinocchio as pin
    pin.computeDistances(peer.model, peer.data, peer.geometry, peer.geometry_data, x)
    pin.computeJointJacobians(peer.model, peer.data, x)


def call_overhead(pin):
    """Returns the seconds of a call from Python by itself: the same function on a model without pairs."""
    model, geometry = pin.Model(), pin.GeometryModel()
    data, geometry_data, q = model.createData(), geometry.createData(), pin.neutral(pin.Model())
    return statistics.median(timed(pin.computeCollisions, model, data, geometry, geometry_data, q, True)[0] for _ in range(1000))


def timed(call, *arguments, clock=time.perf_counter):
    start = clock()
    answer = call(*arguments)
    return clock() - start, answer


def exactness(command, poses):
    done = subprocess.run([command[0], "exact", "--poses", str(poses)], capture_output=True, text=True)
    print("exactness:", done.stdout.strip())
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer rounds, poses and sizes")
    parser.add_argument("--only", choices=["robots"], help="measure this part again, and keep the last figures of the others")
    parser.add_argument("--write", action="store_true", help="only write the page again, from the last figures")
    args = parser.parse_args()
    figures = BUILD / "collision.json"
    if args.only:
        ours, found = Side(ours_command()), json.loads(figures.read_text())
        found["robots"] = robots(ours, 7, 2000)
        figures.write_text(json.dumps(found, indent=1))
    elif not args.write:
        missing = [p for _, *paths in PAIRS for p in paths if not (ROBOTS / p).exists()]
        if missing:
            sys.exit(f"not there: {', '.join(missing)}\nfetch them as the top of this file says")
        ours = ours_command()
        commands = {"ours": ours, **peer_commands()}
        sides = {name: Side(command) for name, command in commands.items()}
        rounds, count = (3, 200) if args.quick else (7, 1000)
        found = {"machine": machine(), "sides": sorted(commands), "rounds": rounds, "quick": args.quick}
        found["pairs"] = mesh_pairs(sides, rounds, count)
        found["memory"] = memory(commands, range(len(PAIRS)))
        found["growth"] = growth(sides, 3, count // 2, range(3, 7 if args.quick else 9))
        found["robots"] = robots(sides["ours"], rounds, 2 * count)
        found["exactness"] = exactness(ours, 5_000 if args.quick else 100_000)
        figures.write_text(json.dumps(found, indent=1))
    collision_report.write(json.loads(figures.read_text()), ROOT / "docs" / "benchmarks")


if __name__ == "__main__":
    main()
