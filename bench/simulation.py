"""Simulations that start in penetration, and a device that is pushed through obstacles: with and without extricate.

    pip install extricate mujoco numpy
    python3 bench/simulation.py                    # some minutes; --states 200 --paths 4: less
    python3 bench/simulation.py --long 3600        # as many moves of continuous streams as fit in an hour

*Reset*: random colliding states of four MuJoCo models at rest, without gravity; how much kinetic energy appears within half a
second, as they are and after `MujocoRobot.reset`. *Stream*: frames of 4 mrad through obstacles; how often the answer jumps, and
whether its moves are free, of single queries, a stream with hysteresis, and a continuous stream.
Writes target/bench/simulation.json and docs/benchmarks/simulation.md (`--write` only the latter)."""
import argparse
import json
import time
import warnings
from pathlib import Path

import numpy as np

import extricate
from page import number, put, table

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "target" / "bench"
PAGE = ROOT / "docs" / "benchmarks" / "simulation.md"
SCENES = ("planar-arm", "shelf-arm", "dual-arm")
STEP = 4e-3
JUMP, TURN = 0.04, np.cos(np.deg2rad(30))
DEEP = 0.02


def chain(links, length, radius, axis):
    """Makes an arm of capsules with one hinge each, whose axes alternate."""
    text, close = "", ""
    for k in range(links):
        turn = axis[k % len(axis)]
        position = f"0 0 {length if k else 0}"
        text += f'<body name="l{k}" pos="{position}"><joint name="j{k}" axis="{turn}" range="-150 150" damping="0.1"/>' \
                f'<geom type="capsule" fromto="0 0 {2.2 * radius} 0 0 {length - 2.2 * radius}" size="{radius}"/>'
        close += "</body>"
    return text + close


def model(body, world):
    return f'<mujoco><compiler angle="degree" autolimits="true"/><option gravity="0 0 0" timestep="0.001"/><worldbody>{body}{world}</worldbody></mujoco>'


MODELS = {
    "arm among boxes": model(chain(6, 0.3, 0.04, ["0 0 1", "0 1 0", "0 1 0", "1 0 0", "0 1 0", "1 0 0"]),
                             '<geom name="a" type="box" size="0.1 0.3 0.2" pos="0.45 0 0.5"/><geom name="b" type="box" size="0.3 0.05 0.4" pos="0 0.5 0.4"/>'),
    "planar arm": model(chain(4, 0.3, 0.03, ["0 1 0"]), '<geom name="a" type="cylinder" size="0.12 0.4" euler="90 0 0" pos="0.6 0 0.3"/>'
                        '<geom name="b" type="cylinder" size="0.15 0.4" euler="90 0 0" pos="0.1 0 0.8"/>'),
    "boxes in a bin": model("".join(f'<body name="free{k}" pos="{0.15 * k} 0 0.2"><freejoint name="f{k}"/><geom type="box" size="0.08 0.06 0.04" mass="1"/></body>' for k in range(3)),
                            '<geom name="floor" type="box" size="0.4 0.4 0.02" pos="0.15 0 -0.02"/><geom name="wall" type="box" size="0.02 0.4 0.2" pos="-0.25 0 0.2"/>'),
    "gripper and ball": model('<body name="palm" pos="0 0 0"><joint name="lift" type="slide" axis="0 0 1" range="-0.1 0.3"/><geom type="box" size="0.06 0.03 0.02" mass="1"/>'
                              + "".join(f'<body name="finger{k}" pos="{0.05 * s} 0 0.035"><joint name="curl{k}" axis="0 {s} 0" range="-80 40"/>'
                                        '<geom type="capsule" fromto="0 0 0.012 0 0 0.09" size="0.008" mass="0.1"/></body>' for k, s in enumerate((1, -1))) + "</body>",
                              '<geom name="ball" type="sphere" size="0.035" pos="0 0 0.1"/>'),
}


def energy(mujoco, mj, states, steps=500):
    """Returns the largest kinetic energy [J] within half a second from rest."""
    data, found = mujoco.MjData(mj), []
    mj.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    for qpos in states:
        mujoco.mj_resetData(mj, data)
        data.qpos[:] = qpos
        most = 0.0
        for _ in range(steps):
            mujoco.mj_step(mj, data)
            most = max(most, data.energy[1])
        found.append(most)
    return found


def resets(count):
    import mujoco
    rows = []
    for title, text in MODELS.items():
        mj = mujoco.MjModel.from_xml_string(text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            floats = {f"f{k}": (-0.3, 0.5) for k in range(3)} if "free0" in text else {}
            robot = extricate.Robot.from_mujoco(mj, limits=floats) if floats else extricate.Robot.from_mujoco(mj)
            scene = extricate.Scene(robot, clearance=1e-5)
        states = robot.qpos(scene.sample(count, seed=5, colliding=True))
        began = time.process_time()
        reset, moved = robot.reset(states, scene=scene)
        seconds = time.process_time() - began
        rows.append({"model": title, "states": count, "none": int(np.isinf(moved).sum()), "us": 1e6 * seconds / count,
                     "before": energy(mujoco, mj, states), "after": energy(mujoco, mj, reset)})
        print(title, "median before", np.median(rows[-1]["before"]), "after", np.max(rows[-1]["after"]), flush=True)
    return rows


def frames(scene, count, seed=5):
    """Makes frames of 4 mrad along straight segments between free configurations that pass through obstacles."""
    free = scene.sample(40 * count, seed=seed, colliding=False)
    paths = []
    for a, b in zip(free[::2], free[1::2]):
        if scene.check_segments([a], [b])[0]["contact"]:
            paths.append(a + (b - a) * np.linspace(0, 1, max(2, int(np.linalg.norm(b - a) / STEP)))[:, None])
        if len(paths) == count:
            return paths
    return paths


def streams(count):
    rows = []
    for name in SCENES:
        scene = extricate.Scene.builtin(name)
        paths = frames(scene, count)
        for side in ("single", "hysteresis 0.5", "continuous"):
            row = {"scene": name, "side": side, "frames": 0, "jumps": 0, "turns": 0, "moves": 0, "unproved": 0, "behind": [], "us": []}
            for path in paths:
                walk(scene, path, side, row)
            row["excess"] = float(np.median(row.pop("behind"))) if row["behind"] else 0.0
            us = np.array(row.pop("us"))
            row |= {"median_us": float(np.median(us)), "most_us": float(np.quantile(us, 0.999))}
            rows.append(row)
            print(row, flush=True)
    return rows


def walk(scene, path, side, row):
    stream = None if side == "single" else scene.stream(continuous=True) if side == "continuous" else scene.stream(hysteresis=0.5)
    last = None
    for q in path:
        began = time.thread_time()
        answer = scene.query(q) if stream is None else stream.query(q)
        row["us"].append(1e6 * (time.thread_time() - began))
        row["frames"] += int(answer.depth > 0)
        push, touching = answer.witness - q, set(answer.touching)
        if last is not None:
            before, pushed, touched = last
            row["moves"] += 1
            row["jumps"] += int(np.linalg.norm(answer.witness - before) > JUMP)
            row["unproved"] += bool(scene.check_segments([before], [answer.witness], resolution=2e-5)[0]["contact"])
            deep = min(np.linalg.norm(push), np.linalg.norm(pushed))
            if deep > DEEP and touching == touched:
                row["turns"] += int(push @ pushed < TURN * np.linalg.norm(push) * np.linalg.norm(pushed))
        if answer.nearest:
            row["behind"].append(answer.depth / answer.nearest - 1)
        last = (answer.witness, push, touching)


def long(seconds):
    """Runs continuous streams alone, for `seconds` shared evenly by the scenes."""
    rows = []
    for name in SCENES:
        scene, began, seed = extricate.Scene.builtin(name), time.monotonic(), 100
        row = {"scene": name, "frames": 0, "moves": 0, "jumps": 0, "collide": 0, "unproved": 0, "turns": 0, "short": 0, "us": []}
        while time.monotonic() - began < seconds / len(SCENES):
            for path in frames(scene, 1, seed=seed):
                followed(scene, path, row)
            seed += 1
        us = np.array(row.pop("us"))
        rows.append(row | {"median_us": float(np.median(us)), "most_us": float(np.quantile(us, 0.999))})
        print(rows[-1], flush=True)
    return rows


def followed(scene, path, row):
    """Follows one path; its moves are judged together at the end."""
    stream, asked = scene.stream(continuous=True), []
    for q in path:
        began = time.thread_time()
        asked.append(stream.query(q))
        row["us"].append(1e6 * (time.thread_time() - began))
    proxies = np.array([answer.witness for answer in asked])
    proved = scene.check_segments(proxies[:-1], proxies[1:], resolution=2e-5, threads=1)
    pushes, touching = proxies - path, [set(answer.touching) for answer in asked]
    lengths = np.linalg.norm(pushes, axis=1)
    same = np.array([a == b for a, b in zip(touching, touching[1:])])
    deep = np.minimum(lengths[1:], lengths[:-1]) > DEEP
    row["frames"] += sum(answer.depth > 0 for answer in asked)
    row["moves"] += len(proved)
    jumps = np.linalg.norm(np.diff(proxies, axis=0), axis=1) > JUMP
    turns = same & deep & ((pushes[1:] * pushes[:-1]).sum(1) < TURN * lengths[1:] * lengths[:-1])
    row["jumps"] += int(jumps.sum())
    row["collide"] += int(proved["contact"].sum())
    row["unproved"] += int((~proved["free"]).sum())
    row["turns"] += int(turns.sum())
    row["short"] += int((turns & ~jumps).sum())


def long_page(rows):
    total = {key: sum(r[key] for r in rows) for key in rows[0] if key not in ("scene", "median_us", "most_us")}
    rows = [[r["scene"], f"{r['moves']:,}", f"{r['frames']:,}", r["collide"], r["unproved"], f"{r['jumps']:,}", r["turns"], r["short"],
             number(r.get("median_us")), number(r.get("most_us"))] for r in [*rows, {"scene": "all"} | total]]
    head = ["scene", "moves", "frames in collision", "moves that collide", "moves not proved free", f"moves over {JUMP} rad",
            "turns over 30 degrees, contacts the same", "of these in shorter moves", "frame, median [us]", "99.9 % [us]"]
    return "## Continuous streams, many moves\n\n" + table(head, rows)


def page(found):
    quantile = lambda values, q: number(float(np.quantile(values, q)))
    calm = lambda values: f"{100 * np.mean(np.array(values) < 1e-6):.2f} %"
    rows = [[r["model"], r["states"], r["none"], quantile(r["before"], 0.5), quantile(r["before"], 1), calm(r["before"]),
             quantile(r["after"], 0.5), quantile(r["after"], 1), calm(r["after"])] for r in found["resets"]]
    head = ["model", "states", "not reset", "before, median [J]", "most", "below 1e-6 J", "after, median [J]", "most", "below 1e-6 J"]
    text = "## Start states\n\n" + table(head, rows)
    rows = [[r["scene"], r["side"], f"{r['frames']:,}", r["jumps"], f"{r['unproved']} of {r['moves']:,}", r["turns"],
             f"{100 * r['excess']:.1f} %" if r["side"] == "continuous" else "", number(r["median_us"]), number(r["most_us"])] for r in found["streams"]]
    head = ["scene", "asked by", "frames in collision", f"jumps over {JUMP} rad", "moves that collide", "turns over 30 degrees, contacts the same",
            "farther than the nearest exit, median", "frame, median [us]", "99.9 % [us]"]
    return text + "\n\n## Streams\n\n" + table(head, rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--states", type=int, default=2500, help="of each model")
    parser.add_argument("--paths", type=int, default=20, help="of each scene")
    parser.add_argument("--long", type=float, metavar="SECONDS", help="only the continuous streams, for about this long")
    parser.add_argument("--write", action="store_true", help="only write the page again")
    args = parser.parse_args()
    BUILD.mkdir(parents=True, exist_ok=True)
    if args.long:
        rows = long(args.long)
        (BUILD / "simulation-long.json").write_text(json.dumps(rows))
        put(PAGE, "bench/simulation.py --long", long_page(rows), "Simulations and devices")
        return
    figures = BUILD / "simulation.json"
    if not args.write:
        figures.write_text(json.dumps({"resets": resets(args.states), "streams": streams(args.paths)}))
    put(PAGE, "bench/simulation.py", page(json.loads(figures.read_text())), "Simulations and devices")


if __name__ == "__main__":
    main()
