"""Results of `Scene.release`: plain data, so that they pickle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
import numpy.typing as npt


@dataclass(eq=False)
class GraspContact:
    """A place where a hand touches the object.

    link: name of the link.
    distance: signed distance between link and object [m].
    point: point on the object, (3,), world coordinates [m].
    normal: unit normal into the object, (3,), world coordinates.
    """

    link: str
    distance: float
    point: npt.NDArray[np.float64]
    normal: npt.NDArray[np.float64]


@dataclass(eq=False)
class Grasp:
    """A hand that holds an object and penetrates nothing.

    config: configuration of the hand, (nq,).
    moved: distance of the configuration from the query, in the scene's metric.
    verified: whether the exact checker called the configuration free during this call: every checked pair keeps the clearance,
        and every joint its limits.
    contacts: places where the hand touches the object.
    touched: names of the links that touched the object, or were in it, at the query.
    kept: names of those links that still touch the object.
    fingers: number of fingers that touched, and of those that still do.
    kept_sides: whether every contact is on its side of the object: its normal differs by less than 90 degrees from that at the
        finger's first touch when the finger closes from open.
    depth_before: greatest depth [m] of a link in the object at the query; 0 if none was in it.
    epsilon: Ferrari and Canny's quality Q1 of the contacts (doi:10.1109/ROBOT.1992.219918), with round friction cones and
        moments about the centre of the object's bounding box in units of half its longest side; None without friction.
    force_closure: whether the contacts resist any wrench: epsilon is above 0; None without friction.
    checks: number of exact checks and contact evaluations spent.
    """

    config: npt.NDArray[np.float64]
    moved: float
    verified: bool
    contacts: List[GraspContact]
    touched: List[str]
    kept: List[str]
    fingers: Tuple[int, int]
    kept_sides: bool
    depth_before: float
    epsilon: Optional[float]
    force_closure: Optional[bool]
    checks: int
