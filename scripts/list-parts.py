#!/usr/bin/env python3
"""Lists what a program or library is linked from: with the texts of the licences, and as a CycloneDX list (SBOM).

    scripts/list-parts.py PACKAGE [--target TARGET] [--licences FILE] [--sbom FILE]

PACKAGE is one of this workspace. Without --target, the parts are those of every platform. Build scripts, macros and tests are not linked.
Needs cargo, with its crates fetched or a network.
"""
from __future__ import annotations

import argparse
import html
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, Dict, Iterator, List, Optional, Tuple

ROOT = Path(__file__).resolve().parent.parent
THREE = ROOT / "crates/extricate-view/page/three"
FILES = re.compile(r"(licen[cs]e|copying|copyright|notice|unlicense)", re.IGNORECASE)


def output(*command: str) -> str:
    return subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True, encoding="utf-8").stdout


def linked(package: str, target: str) -> List[Dict[str, Any]]:
    """Returns the packages that are linked, as `cargo metadata` describes them; `package` itself comes first."""
    known = {f"{p['name']} v{p['version']}": p for p in json.loads(output("cargo", "metadata", "--locked", "--format-version=1"))["packages"]}
    tree = ("cargo", "tree", "--locked", f"--package={package}", f"--target={target}", "--edges=normal,no-proc-macro", "--prefix=none")
    names = [" ".join(line.split(" ")[:2]) for line in output(*tree, "--format={p}").splitlines() if line]
    return [known[name] for name in dict.fromkeys(names)]


def texts(part: Dict[str, Any]) -> List[str]:
    """Returns the licence texts in the package's folder; if it has none, the general text of a licence that it is under."""
    folder = Path(part["manifest_path"]).parent
    found = sorted(path for path in folder.iterdir() if path.is_file() and FILES.match(path.name) and path.suffix != ".rs")
    if found:
        return [path.read_text(encoding="utf-8", errors="replace") for path in found]
    if re.search(r"\bMIT\b", part["license"] or ""):
        holders = ", ".join(part["authors"]) or f"the authors of {part['repository']}"
        return [re.sub(r"Copyright .*", f"Copyright (c) {holders}", (ROOT / "LICENSE-MIT").read_text(encoding="utf-8"), count=1)]
    sys.exit(f"{folder}: got no licence text for {part['name']} ({part['license']}), expected a file LICENSE")


def of_rust() -> Iterator[Tuple[str, str]]:
    """Yields notice and text of what the standard library holds, as the toolchain has them; distributions may leave them out."""
    page = Path(output("rustc", "--print=sysroot").strip()) / "share/doc/rust/COPYRIGHT-library.html"
    parts = re.split(r"<pre>(.*?)</pre>", page.read_text(encoding="utf-8") if page.exists() else "", flags=re.DOTALL)
    for notice, text in zip(parts[::2], parts[1::2]):
        names = re.findall(r"<h3>\W*(.*?)</h3>", notice)
        yield (f"Rust's standard library: {names[-1]}" if names else ""), html.unescape(text)


def licences(parts: List[Dict[str, Any]]) -> str:
    """Returns every text once, below the names of the parts that have it."""
    users: Dict[str, Tuple[str, List[str]]] = {}

    def add(name: str, text: str) -> None:
        users.setdefault(" ".join(text.split()), (text, []))[1].append(name)

    for part in parts:
        if part["source"]:
            for text in texts(part):
                add(f"{part['name']} {part['version']} ({part['license']})", text)
        elif part["name"] == "extricate-view":
            add("three.js (MIT)", (THREE / "LICENSE").read_text(encoding="utf-8"))
    for licence in ("MIT", "APACHE"):
        text = (ROOT / f"LICENSE-{licence}").read_text(encoding="utf-8")
        add("Rust's standard library (MIT OR Apache-2.0)", re.sub(r"Copyright .*contributors", "Copyright (c) The Rust Project Developers", text))
    name = ""
    for found, text in of_rust():
        name = found or name
        add(name or "Rust's standard library", text)
    out = ["What is linked into this program or library, and the licences of it. Each text stands below the names of all that have it.\n"]
    for text, names in users.values():
        out.append("=" * 100 + "\n" + "\n".join(dict.fromkeys(names)) + "\n" + "-" * 100 + "\n" + text.strip("\r\n") + "\n")
    return "\n".join(out)


def sbom(parts: List[Dict[str, Any]]) -> Dict[str, Any]:
    """Returns the parts as CycloneDX 1.5. It has neither time nor number, so that the same sources give the same bytes."""
    lock = (ROOT / "Cargo.lock").read_text(encoding="utf-8")
    sums = {(n, v): s for n, v, s in re.findall(r'name = "(.*)"\nversion = "(.*)"\nsource = .*\nchecksum = "(.*)"', lock)}

    def component(part: Dict[str, Any], kind: str) -> Dict[str, Any]:
        purl = f"pkg:cargo/{part['name']}@{part['version']}"
        made = {"type": kind, "bom-ref": purl, "name": part["name"], "version": part["version"], "purl": purl}
        made["licenses"] = [{"expression": part["license"].replace("/", " OR ")}]
        found: Optional[str] = sums.get((part["name"], part["version"]))
        return {**made, "hashes": [{"alg": "SHA-256", "content": found}]} if found else made

    components = [component(part, "library") for part in parts[1:]]
    if any(part["name"] == "extricate-view" for part in parts):
        version = re.findall(r"three\.js (\d+(?:\.\d+)+)", (THREE / "README.md").read_text(encoding="utf-8"))[0]
        purl, mit = f"pkg:npm/three@{version}", [{"expression": "MIT"}]
        components.append({"type": "library", "bom-ref": purl, "name": "three", "version": version, "purl": purl, "licenses": mit})
    head = {"$schema": "http://cyclonedx.org/schema/bom-1.5.schema.json", "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1}
    return {**head, "metadata": {"component": component(parts[0], "application")}, "components": components}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("package")
    parser.add_argument("--target", default="all")
    parser.add_argument("--licences", type=Path)
    parser.add_argument("--sbom", type=Path)
    given = parser.parse_args()
    parts = linked(given.package, given.target)
    if given.licences:
        given.licences.write_bytes(licences(parts).encode())
    if given.sbom:
        given.sbom.write_bytes(json.dumps(sbom(parts), indent=1).encode() + b"\n")


main()
