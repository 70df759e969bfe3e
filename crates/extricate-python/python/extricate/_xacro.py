"""Expands xacro files to URDF texts with the package xacrodoc."""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Any, List, Mapping, Sequence, Tuple

from ._extricate import _find_package


def packages_around(path: Any) -> List[str]:
    """Returns the folders that contain a file, the innermost first. Packages are looked up in them, as for a URDF."""
    return [str(parent) for parent in Path(os.path.abspath(os.fspath(path))).parents]


def expanded(path: Any, args: Mapping[str, Any], packages: Sequence[Any]) -> Tuple[str, Sequence[Any]]:
    """Returns the URDF text, and the folders in which its packages are looked up. The folders of the file are among them,
    because the text has none. Relative paths of meshes start from the xacro file."""
    try:
        xacrodoc: Any = importlib.import_module("xacrodoc")
        finder: Any = importlib.import_module("xacrodoc.packages")
    except ImportError as error:
        raise ImportError("Robot.from_xacro needs the package xacrodoc: pip install 'extricate[xacro]'") from error
    folders = [os.path.abspath(os.fspath(folder)) for folder in packages]
    if folders:
        finder.look_in(folders)
    texts = {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in args.items()}
    found: List[str] = []
    while True:
        try:
            document = xacrodoc.XacroDoc.from_file(os.fspath(path), subargs=texts, resolve_packages=False)
            return document.to_urdf_string(use_protocols=True, pretty=False), folders + packages_around(path)
        except Exception as error:
            # xacro raises errors of XML, of Python in ${..}, and of missing packages.
            cause = getattr(error, "exc", None) or error
            missing = str(cause.args[0]) if isinstance(cause, finder.PackageNotFoundError) and cause.args else ""
            place = _find_package(missing, os.path.abspath(os.fspath(path)), folders) if missing not in found else None
            if place is None:
                problem = f"xacro cannot expand it: {type(error).__name__}: {error}"
                raise ValueError(f"{os.fspath(path)}: {problem}") from error
            found.append(missing)
            finder.update_package_cache({missing: place})
