"""Xacro files to URDF texts, by the package xacrodoc."""

from __future__ import annotations

import importlib
import os
from pathlib import Path
from typing import Any, List, Mapping, Sequence, Tuple


def packages_around(path: Any) -> List[str]:
    """The folders that a file lies in and that say that they are a package, of ROS or of Gazebo, the innermost first."""
    parents = Path(os.path.abspath(os.fspath(path))).parents
    return [str(p) for p in parents if (p / "package.xml").is_file() or (p / "model.config").is_file()]


def expanded(path: Any, args: Mapping[str, Any], packages: Sequence[Any]) -> Tuple[str, Sequence[Any]]:
    """The URDF text, and the folders of packages, those that the file lies in among them, as a text lies nowhere. Paths of meshes
    that are relative are those of the xacro file."""
    try:
        xacrodoc: Any = importlib.import_module("xacrodoc")
        finder: Any = importlib.import_module("xacrodoc.packages")
    except ImportError as error:
        raise ImportError("Robot.from_xacro needs the package xacrodoc: pip install 'extricate[xacro]'") from error
    folders = [os.path.abspath(os.fspath(folder)) for folder in packages]
    if folders:
        finder.look_in(folders)
    texts = {name: str(value).lower() if isinstance(value, bool) else str(value) for name, value in args.items()}
    try:
        document = xacrodoc.XacroDoc.from_file(os.fspath(path), subargs=texts, resolve_packages=False)
        return document.to_urdf_string(use_protocols=True, pretty=False), folders + packages_around(path)
    except Exception as error:
        # What it raises depends on what is wrong: errors of XML, of Python in ${..}, of packages that are missing.
        raise ValueError(f"{os.fspath(path)}: xacro cannot expand it: {type(error).__name__}: {error}") from error
