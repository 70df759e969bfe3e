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

    points: configurations, the query first, (n, nq), joined by geodesics; None if no path was found.
    free_from: index into `points` from which on the path is proved free.
    method: the step that found the path: "free" (the query is free), "nearest" (straight to the nearest exit), "exit" (straight
        to another exit), "pushed" (colliding pairs parted little by little) or "grown" (trees); None if none did.
    colliding: pairs that collide at the query, and their signed distances there [m].
    deepening: most that any of these pairs was found deeper than at the query [m]; proved to be at most the tolerance.
    needed_tolerance: if no path was found: the least of 1, 2, 5 and 10 mm [m] with which, as a larger tolerance, there is one;
        None if none of these has one.
    length: length of the path in the scene's metric.
    max_displacement: largest displacement of any point of the robot between the query and any of `points` [m].
    checks: number of configurations at which the exact checker evaluated anything.
    """

    points: Optional[npt.NDArray[np.float64]]
    free_from: int
    method: Optional[str]
    colliding: List[Tuple[NamePair, float]]
    deepening: float
    needed_tolerance: Optional[float]
    length: float
    max_displacement: float
    checks: int


@dataclass(eq=False)
class Plan:
    """A path between two configurations.

    points: configurations from start to goal, (n, nq), joined by proved geodesics; None if no path was found.
    free_from: index into `points` from which on the path is proved free; 0 if the start is free.
    free_to: index into `points` up to which it is proved free; the last one if the goal is free.
    start_escape: path from a colliding start to the free part, an `Escape`; None if the start is free. If it has no points, it
        says why there is no plan.
    goal_escape: the same from a colliding goal; the plan takes it in reverse.
    method: the step that found the free part: "straight", "trees" or "roadmap"; None if none did.
    length: length of the path in the scene's metric.
    checks: number of configurations at which the exact checker evaluated anything.
    nodes: number of configurations in the roadmap.
    """

    points: Optional[npt.NDArray[np.float64]]
    free_from: int
    free_to: int
    start_escape: Optional[Escape]
    goal_escape: Optional[Escape]
    method: Optional[str]
    length: float
    checks: int
    nodes: int


@dataclass(eq=False)
class Repaired:
    """A free path in place of one that collides.

    points: configurations, (n, nq), joined by geodesics that are proved free; None if no path was found.
    places: for each point, its place on the old path, (n,): 2.25 is a quarter of the edge from row 2 to row 3. Places convert
        time stamps of rows to those of points. They ascend, and are whole numbers for rows that stay.
    deviation: largest distance of a point from its place, in the scene's metric.
    length: length of the path in the scene's metric.
    length_before: length of the old path, in the same metric.
    stretches: number of stretches of the old path that were replaced.
    gaps: number of gaps in these stretches that trees had to close.
    touched: number of pairs that touch, summed over the rows; 0 without `touch`.
    kept: number of these that touch in the result.
    checks: number of configurations at which the exact checker evaluated anything.
    """

    points: Optional[npt.NDArray[np.float64]]
    places: npt.NDArray[np.float64]
    deviation: float
    length: float
    length_before: float
    stretches: int
    gaps: int
    touched: int
    kept: int
    checks: int
