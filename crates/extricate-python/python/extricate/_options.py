"""Options of queries as one object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Mapping, Optional, Sequence, Tuple, Union

import numpy.typing as npt

Effort = Literal["nearest", "quick", "refined", "exhaustive", "proved"]
LimitRule = Literal["forgive", "refuse"]


@dataclass(frozen=True, eq=False)
class QueryOptions:
    """Options of queries, batches and streams, passed as `options=`. A keyword of the same call overrides its field here.

    effort: "nearest" (a stored sample), "quick" (fewer starts), "refined", "exhaustive" or "proved".
    exits: number of distinct exits to find.
    gap: share of the depth that need not be proved: the search stops as soon as the rest is proved. None is 0.15 with "quick"
        and "refined", 0.05 with "proved", and does not stop "exhaustive". With 0, no proof stops the search.
    starts: number of starts of descents, stored samples and around the query; None leaves it to the effort.
    max_checks: end after about this many checks, with the best answer so far.
    max_seconds: end after about this many seconds, likewise.
    segment: report where the straight segment to the witness collides.
    contacts: with effort "nearest", report all colliding pairs and the contacts at the witness.
    clearance: clearance to aim at, in place of the scene's [m].
    locked: joints that stay where the query has them.
    free: the joints that may move, in place of `locked`.
    keep: links that stay where they are, or that are brought to a pose, as in `Scene.query`.
    touch: pairs of bodies that just touch at the witness, as in `Scene.query`.
    weights: weights of the joint metric, by joint.
    toward: a configuration: among exits about as near as the nearest, the witness is the one nearest to it.
    toward_share: how much farther than the nearest these exits may be, as a share of its depth.
    free_radius: report how far around the witness nothing touches.
    limits: "forgive" answers configurations beyond the joint limits, "refuse" raises ValueError for them.
    """

    effort: Effort = "refined"
    exits: int = 1
    gap: Optional[float] = None
    starts: Optional[int] = None
    max_checks: Optional[int] = None
    max_seconds: Optional[float] = None
    segment: bool = False
    contacts: bool = False
    clearance: Optional[float] = None
    locked: Optional[Sequence[str]] = None
    free: Optional[Sequence[str]] = None
    keep: Optional[Union[str, Mapping[str, Any], Sequence[Union[str, Mapping[str, Any]]]]] = None
    touch: Optional[Sequence[Tuple[str, str]]] = None
    weights: Optional[Mapping[str, Union[float, Tuple[float, float]]]] = None
    toward: Optional[npt.ArrayLike] = None
    toward_share: float = 0.25
    free_radius: bool = False
    limits: LimitRule = "forgive"
