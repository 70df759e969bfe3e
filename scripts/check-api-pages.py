#!/usr/bin/env python3
"""Checks that the site describes every public name of the Python package.

    python3 scripts/check-api-pages.py SITE
"""
from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent.parent / "crates/extricate-python/python/extricate"

def public(source: Path) -> list[str]:
    """Returns `__all__` of a module."""
    for node in ast.parse(source.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and any(isinstance(target, ast.Name) and target.id == "__all__" for target in node.targets):
            return list(ast.literal_eval(node.value))
    sys.exit(f"{source}: expected __all__")


def public_names() -> list[str]:
    """Returns every public name, with those of public modules."""
    names = []
    for name in public(PACKAGE / "__init__.py"):
        names.append(f"extricate.{name}")
        for module in (PACKAGE / f"{name}.py", PACKAGE / name / "__init__.py"):
            if module.exists():
                names += [f"extricate.{name}.{inner}" for inner in public(module)]
    return names


def main(site: str) -> None:
    page = (Path(site) / "reference/python.html").read_text(encoding="utf-8")
    described = set(re.findall(r'id="(extricate\.[\w.]+)"', page))
    names = public_names()
    missing = [name for name in names if name not in described]
    if missing:
        sys.exit(f"docs/reference/python.md describes {len(names) - len(missing)} of {len(names)} names, not {', '.join(missing)}")
    print(f"docs/reference/python.md: {len(names)} names of the package, and {len(described) - len(names)} members")


main(sys.argv[1])
