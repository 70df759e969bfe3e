"""What queries give back. Made by `Model`; plain data, so it pickles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
import numpy.typing as npt

NamePair = Tuple[str, str]


@dataclass(eq=False)
class Contact:
    """Where two bodies touch at the witness."""

    pair: NamePair
    """Names of the two bodies."""
    distance: float
    """Signed distance between them there [m]; negative where they overlap."""
    points: npt.NDArray[np.float64]
    """The nearest point on the first and on the second body, (2, 3), world coordinates [m]."""
    normal: npt.NDArray[np.float64]
    """Unit, (3,), world coordinates, from the second body toward the first."""


@dataclass(eq=False)
class Exit:
    """One of several distinct ways out."""

    depth: float
    """Distance from the query, in the scene's metric."""
    witness: npt.NDArray[np.float64]
    """A free configuration at that distance, (nq,); verified."""
    touching: List[NamePair]
    """Pairs of bodies that touch there."""


@dataclass(eq=False)
class Answer:
    """The nearest free configuration that was found, and what is known about it."""

    depth: float
    """Distance from the query to the witness in the scene's metric; 0 where the query is free. An upper bound on the true
    penetration depth."""
    lower_bound: float
    """Proved: no free configuration is nearer to the query than this."""
    witness: npt.NDArray[np.float64]
    """A free configuration at distance `depth`, (nq,)."""
    verified: bool
    """Whether the exact checker called the witness free during this query; otherwise it did when the model was learned."""
    coverage: Optional[float]
    """How usual the query's distance to the nearest stored sample is among held-out colliding configurations, in (0, 1]: below
    0.01 the query lies far from what was learned. None where the query is free or nothing was held out."""
    max_displacement: float
    """Largest displacement of any point of the robot between the query and the witness [m]."""
    colliding: List[NamePair]
    """Pairs of bodies that collide at the query."""
    touching: List[NamePair]
    """Pairs of bodies that touch at the witness."""
    contacts: List[Contact]
    """Where they touch; several places a pair where meshes do."""
    gradient: npt.NDArray[np.float64]
    """How the distance to the witness changes with the query, (nv,): a small tangent step t at the query changes it by
    gradient @ t. Zero where the query is free."""
    unique: bool
    """False where another way out is about as near: beside such queries the nearest one changes, and the gradient jumps."""
    exits: List[Exit]
    """Where more than one was asked for: the nearest distinct ways out, by depth, the witness first."""
    way: Optional[Tuple[float, float]]
    """Where it was asked for, of the straight way from the query (0) to the witness (1): the last fraction at which a
    collision was found, and the fraction from which on every configuration is proved free."""
    checks: int
    """Collision and distance evaluations spent."""
    effort: str
    """"nearest", "refined" or "exhaustive"."""

    @property
    def free(self) -> bool:
        """Whether the query itself is free."""
        return not self.colliding
