"""Results of motions: plain data, so that they pickle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._answer import NamePair


@dataclass(eq=False)
class Escape:
    """A path out of collision.

    points: configurations, the query first, (n, nq); between two of them the geodesic. None where no path was found.
    free_from: index into `points` from which on the path is proved free.
    method: which step found it: "free" (the query is free), "nearest" (straight to the nearest exit), "exit" (straight to another
        one), "pushed" (parted little by little) or "grown" (trees); None where none did.
    colliding: the pairs that collide at the query, and their signed distances there [m].
    deepening: most that any of these was found deeper than at the query [m]; proved to be at most the tolerance.
    length: of the path, in the scene's metric.
    max_displacement: largest displacement of any point of the robot between the query and any of `points` [m].
    checks: configurations at which the exact checker evaluated anything.
    """

    points: Optional[npt.NDArray[np.float64]]
    free_from: int
    method: Optional[str]
    colliding: List[Tuple[NamePair, float]]
    deepening: float
    length: float
    max_displacement: float
    checks: int


@dataclass(eq=False)
class Plan:
    """A path between two free configurations.

    points: configurations from start to goal, (n, nq); between two of them the geodesic, proved free. None where no path was
        found.
    method: which step found it: "straight", "trees" or "roadmap"; None where none did.
    length: of the path, in the scene's metric.
    checks: configurations at which the exact checker evaluated anything.
    nodes: configurations of the roadmap.
    """

    points: Optional[npt.NDArray[np.float64]]
    method: Optional[str]
    length: float
    checks: int
    nodes: int


@dataclass(eq=False)
class Repaired:
    """A path that was made free.

    points: configurations, (n, nq); between two of them the geodesic, proved free. None where no path was found.
    places: of each point, the place on the old path that it stands for, (n,): 2.25 is a quarter of the edge from row 2 to row 3,
        so time stamps of rows give those of points. Ascending; whole numbers for rows that stay.
    deviation: largest distance of a point from that place, in the scene's metric.
    length: of the path, in the scene's metric.
    length_before: of the old one.
    stretches: how many stretches of the old path were replaced.
    gaps: how many gaps in them trees had to close.
    checks: configurations at which the exact checker evaluated anything.
    """

    points: Optional[npt.NDArray[np.float64]]
    places: npt.NDArray[np.float64]
    deviation: float
    length: float
    length_before: float
    stretches: int
    gaps: int
    checks: int
