"""Makes meshes for shapes of other programs that a scene does not have."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Tuple

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]


def ellipsoid(semiaxes: Any) -> Tuple[Array, Array]:
    """Makes a mesh that contains the ellipsoid and is about half a percent larger: a grid of 32 meridians and 15 parallels,
    scaled until no face cuts the ellipsoid."""
    turns, heights = np.meshgrid(np.arange(32) * np.pi / 16, np.arange(1, 16) * np.pi / 16)
    ring = np.stack([np.cos(turns) * np.sin(heights), np.sin(turns) * np.sin(heights), np.cos(heights)], -1)
    points = np.concatenate([ring.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    faces = []
    for k in range(32):
        after = (k + 1) % 32
        faces += [(480, k, after), (481, 448 + after, 448 + k)]
        for row in range(0, 448, 32):
            faces += [(row + k, row + 32 + k, row + 32 + after), (row + k, row + 32 + after, row + after)]
    corners = points[np.array(faces)]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = np.abs((normals * corners[:, 0]).sum(1)) / np.linalg.norm(normals, axis=1)
    return points / inside.min() * np.asarray(semiaxes), np.array(faces)


def write_obj(path: Path, vertices: Any, triangles: Any) -> None:
    lines = ["v " + " ".join(f"{x:.17g}" for x in v) for v in vertices] + ["f %d %d %d" % tuple(t + 1) for t in triangles]
    path.write_text("\n".join(lines) + "\n")
