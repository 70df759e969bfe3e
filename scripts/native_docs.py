"""Griffe extension: what the site shows of the native half of the Python package.

The stub `_extricate.pyi` has the types of it, and the Rust sources its docs. This puts the docs to the types. It also makes lists of
the lines `name: text` of docs, which Markdown would join.
"""
from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any, Iterator

import griffe

ROOT = Path(__file__).resolve().parent.parent
SOURCES = ROOT / "crates/extricate-python/src"
STUB = "extricate._extricate"
# Classes that get the calls of `macro_rules! calls`, and the name of their call for many queries.
BATCHES = {"Scene": "query_batch", "Model": "query_batch", "Solver": "batch"}

DOC = re.compile(r"\s*/// ?(.*)$")
ATTRIBUTE = re.compile(r"\s*#\[")
OWNER = re.compile(r"\s*impl (\$?\w+) \{")
ITEM = re.compile(r"\s*(?:pub )?(?:fn|struct) (\$?\w+)|    (?:pub )?(\w+): ")
STRUCT = re.compile(r"pub struct (\w+) \{")
RENAMED = re.compile(r'#\[pyo3\(.*?\bname = "(\w+)"')
# `name: text` or `first, second: text`, at the beginning of a line.
NAMED = re.compile(r"(\*?\w+(?:, \*?\w+)*): (.*)")


def docs_of(text: str) -> Iterator[tuple[str, str]]:
    """Yields the path of every documented item of a source of Rust, such as `Scene.check`, and its doc."""
    owner, doc, name, in_attribute = "", [], "", False
    for line in text.splitlines():
        if line.startswith("}"):
            owner = ""
        elif in_attribute:
            in_attribute = not line.endswith("]")
        elif found := OWNER.match(line):
            owner, doc = found[1].replace("$class", "_Calls"), []
        elif found := DOC.match(line):
            doc.append(found[1])
        elif ATTRIBUTE.match(line):
            in_attribute = not line.endswith("]")
            if found := RENAMED.search(line):
                name = found[1]
        elif doc and (found := ITEM.match(line)):
            path = name or found[1] or found[2]
            yield (f"{owner}.{path}" if owner else path), "\n".join(doc)
            doc, name = [], ""
        elif line.strip():
            doc, name = [], ""
        if found := STRUCT.match(line):
            owner = found[1]


def native_docs() -> dict[str, str]:
    found: dict[str, str] = {}
    for source in sorted(SOURCES.rglob("*.rs")):
        found.update(docs_of(source.read_text(encoding="utf-8")))
    for owner, batch in BATCHES.items():
        found[f"{owner}.{batch}"] = found["_Calls.$batch"]
        found[f"{owner}.query"] = found["_Calls.query"]
    return found


def with_lists(doc: str) -> str:
    """Returns a doc in which lines `name: text` are items of a list."""
    out: list[str] = []
    in_item = False
    for line in doc.splitlines():
        if named := NAMED.match(line):
            if not in_item and out and out[-1]:
                out.append("")
            out.append(f"- `{named[1]}`: {named[2]}")
            in_item = True
        elif in_item and line.startswith("    "):
            out.append(line)
        else:
            if in_item and line:
                out.append("")
            in_item = in_item and not line
            out.append(line)
    return "\n".join(out)


class NativeDocs(griffe.Extension):
    """Fills the docs of the stub, and refuses a public name without one."""

    def on_package(self, *, pkg: griffe.Module, **_: Any) -> None:
        if pkg.path != "extricate":
            return
        native = native_docs()
        missing = []
        for thing in walk(pkg):
            if thing.path.startswith(STUB + ".") and thing.docstring is None:
                path = thing.path[len(STUB) + 1 :]
                if path in native:
                    thing.docstring = griffe.Docstring(native[path], parent=thing)
                elif thing.name == "__version__":
                    thing.docstring = griffe.Docstring("Version of the library.", parent=thing)
                elif not thing.name.startswith("_") and not path.startswith("_"):
                    missing.append(path)
            if thing.docstring is not None:
                thing.docstring.value = with_lists(thing.docstring.value)
        if missing:
            sys.exit(f"no doc in {SOURCES.relative_to(ROOT)}: {', '.join(missing)}")


def walk(module: Any) -> Iterator[Any]:
    """Yields everything that a module defines itself."""
    for member in module.members.values():
        if member.is_alias:
            continue
        yield member
        if member.is_module or member.is_class:
            yield from walk(member)
