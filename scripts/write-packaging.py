#!/usr/bin/env python3
"""Fills in the recipes of packaging/: version, addresses, and the sums of the files that they download.

    python3 scripts/write-packaging.py --artefacts FOLDER --out FOLDER [--allow-missing]

A file that a recipe downloads and that is not in the folder of artefacts is an error; with --allow-missing it gets a sum of zeros, and
a note.
"""
from __future__ import annotations

import argparse
import email.utils
import hashlib
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
MANIFEST = (ROOT / "Cargo.toml").read_text(encoding="utf-8")
PLACE = re.compile(r"@(SHA256:)?([A-Z][A-Z0-9]*|(?<=:)[\w.\-]+)@")


def of_manifest(key: str) -> str:
    found = re.search(rf'^{key} = "(.*)"', MANIFEST, re.MULTILINE)
    return found[1] if found else sys.exit(f"Cargo.toml: got no {key}, expected one")


def licence_of_debian() -> str:
    """Returns the text of the licence with a space before each line, and a dot in empty ones."""
    text = (ROOT / "LICENSE-MIT").read_text(encoding="utf-8").strip()
    return "\n".join(f" {line}" if line.strip() else " ." for line in text.splitlines())


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--artefacts", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--allow-missing", action="store_true")
    given = parser.parse_args()
    words = {
        "VERSION": of_manifest("version"),
        "REPOSITORY": of_manifest("repository"),
        "HOMEPAGE": of_manifest("homepage"),
        "SUMMARY": of_manifest("description"),
        "DATE": email.utils.formatdate(localtime=False).replace("-0000", "+0000"),
        "MIT": licence_of_debian(),
    }
    missing: set[str] = set()

    def filled(place: re.Match[str]) -> str:
        if not place[1]:
            return words.get(place[2]) or sys.exit(f"{place[0]}: expected one of {', '.join(words)}")
        file = given.artefacts / place[2]
        if not file.exists():
            missing.add(place[2])
            return "0" * 64
        return hashlib.sha256(file.read_bytes()).hexdigest()

    shutil.rmtree(given.out, ignore_errors=True)
    for source in sorted((ROOT / "packaging").rglob("*")):
        if source.is_dir() or source.name == "README.md":
            continue
        target = given.out / source.relative_to(ROOT / "packaging")
        target.parent.mkdir(parents=True, exist_ok=True)
        # The version stands in the names of files too, so that it is filled in first.
        text = source.read_text(encoding="utf-8").replace("@VERSION@", words["VERSION"])
        target.write_text(PLACE.sub(filled, text), encoding="utf-8")
        shutil.copymode(source, target)
    for name in sorted(missing):
        print(f"NOT THERE: {name}, whose sum is zeros", file=sys.stderr)
    if missing and not given.allow_missing:
        sys.exit(f"{len(missing)} files are not in {given.artefacts}")
    print(given.out)


main()
