"""Answers of queries: plain data, so that they pickle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Dict, List, Literal, Optional, Tuple

import numpy as np
import numpy.typing as npt

from ._options import Effort
from ._page import Page, PathLike, table

NamePair = Tuple[str, str]
FREE = "free: nothing to be done"


@dataclass(eq=False)
class Contact:
    """A place where two bodies touch at the witness.

    pair: names of the two bodies.
    distance: signed distance between them at the witness [m]; negative if they overlap.
    points: the nearest point on the first and on the second body, (2, 3), world coordinates [m].
    normal: unit normal, (3,), world coordinates, from the second body toward the first.
    """

    pair: NamePair
    distance: float
    points: npt.NDArray[np.float64]
    normal: npt.NDArray[np.float64]


@dataclass(eq=False)
class Exit:
    """One of several distinct exits.

    depth: distance from the query, in the scene's metric.
    witness: a verified free configuration at that distance, (nq,).
    touching: pairs of bodies that touch at the witness.
    """

    depth: float
    witness: npt.NDArray[np.float64]
    touching: List[NamePair]


@dataclass(eq=False)
class Answer:
    """The nearest free configuration found, and what is known about it.

    depth: distance from the query to the witness in the scene's metric; 0 if the query is free. It is an upper bound of the
        true penetration depth.
    lower_bound: proved: no free configuration is nearer to the query than this.
    gap: share of the depth that is not proved, 1 - lower_bound / depth; 0 if the query is free, 1 if nothing is proved. "quick"
        and "refined" stop once it is at most 0.15, unless the query sets another gap.
    unproved: if nothing is proved, the reason: "surfaces" (what collides encloses nothing) or "shallow" (the overlap is too
        shallow for a proof) or "off" (nothing collides: a kept link is off); else None.
    witness: a free configuration at distance `depth`, (nq,).
    verified: whether the exact checker called the witness free during this query. If false, it did so when the model was
        learned.
    clearance: clearance that the witness keeps, for pairs without one of their own [m]: the one that the query aims at, or less
        (at least the scene's) if the witness would otherwise be far away. In a continuous stream: at most the aim.
    unseen: estimated share of starts that would lead to an exit which the query has not met, in [0, 1]; None if the query is
        free, or with effort "nearest".
    max_displacement: largest displacement of any point of the robot between the query and the witness [m].
    colliding: pairs of bodies that collide at the query. With effort "nearest" only one of them, unless the query requests
        contacts.
    outside: joints of the query that are beyond their limits. Such a query is not free, whether or not anything collides. The
        witness is within all limits; `depth` is measured from the query as it is.
    off: which of the kept links are off at the query by more than their tolerances, as indices into `keep`. Such a query is not
        free, whether or not anything collides.
    kept: for each kept link, how far it is off at the witness: its origin [m] and its orientation [rad].
    touching: pairs of bodies that touch at the witness. With effort "nearest" none, unless the query requests contacts.
    contacts: places where these pairs touch; a pair of meshes may have several.
    gradient: how the distance to the witness changes with the query, (nv,): a small tangent step t at the query changes it by
        gradient @ t. Zero if the query is free.
    unique: false if another exit is about as near. Beside such a query the nearest exit changes, and the gradient jumps.
    cut_short: whether a limit of checks or seconds ended the search before it was done.
    exits: the nearest distinct exits by depth, the witness first, if the query requests more than one.
    segment: if requested, two fractions of the straight segment from the query (0) to the witness (1): the last one at which a
        collision was found, and the one from which on every configuration is proved free.
    free_radius: if requested and the query collides, a proved distance from the witness in the scene's metric: no two checked
        bodies touch at any configuration nearer to the witness than this. Joint limits do not matter.
    nearest: depth of the nearest exit found, if the witness is the proxy of a continuous stream, which may be farther; 0 if the
        query is free. Else None.
    detour: whether that proxy goes back to the nearest exit along a path that was proved free.
    checks: number of collision and distance evaluations spent.
    effort: "nearest", "quick", "refined", "exhaustive" or "proved".
    """

    depth: float
    lower_bound: float
    gap: float
    unproved: Optional[Literal["surfaces", "shallow"]]
    witness: npt.NDArray[np.float64]
    verified: bool
    clearance: float
    unseen: Optional[float]
    max_displacement: float
    colliding: List[NamePair]
    outside: List[str]
    off: List[int]
    kept: List[Tuple[float, float]]
    touching: List[NamePair]
    contacts: List[Contact]
    gradient: npt.NDArray[np.float64]
    unique: bool
    cut_short: bool
    exits: List[Exit]
    segment: Optional[Tuple[float, float]]
    free_radius: Optional[float]
    nearest: Optional[float]
    detour: bool
    checks: int
    effort: Effort

    # The object, configuration and options of the query, for `show`. Pickles leave it out, because it holds a whole scene.
    _asked: ClassVar[Any] = None

    def __getstate__(self) -> Dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_asked"}

    def show(self, *, path: Optional[PathLike] = None, open: Optional[bool] = None, live: bool = False) -> Page:
        """Shows the query and this answer as a page, in a browser or a notebook, as `Scene.show` does. It runs the query again.

        Raises RuntimeError for an answer that was unpickled or that a stream returned.
        """
        source, q, options = self._question()
        given = dict(options or {})
        if "options" not in given:
            given.setdefault("exits", max(1, len(self.exits)))
        page: Page = source.show(q, path=path, open=open, live=live, **given)
        return page

    def plot(self) -> Any:
        """Draws depth, lower bound and the joints before and after, as a figure of matplotlib (`pip install extricate[plot]`).

        Raises ImportError without matplotlib, and RuntimeError for an answer that was unpickled or that a stream returned.
        """
        from ._plot import plotted

        source, q, _ = self._question()
        return plotted(self, getattr(source, "scene", source), np.asarray(q, dtype=float))

    def _question(self) -> Any:
        """Returns the object, the configuration and the options of the query."""
        if self._asked is None:
            raise RuntimeError("this answer does not know its scene: show the configuration, scene.show(q)")
        return self._asked

    @property
    def free(self) -> bool:
        """Whether the query itself is free."""
        return not self.colliding and not self.outside and not self.off

    def __str__(self) -> str:
        """Returns the most important facts of the answer, for people."""
        if self.free:
            return FREE
        return "\n".join(f"{name:<10} {text}" for name, text in self._rows())

    def _repr_html_(self) -> str:
        return table([("query", FREE)] if self.free else self._rows())

    def _rows(self) -> List[Tuple[str, str]]:
        # All digits, because only the exact configuration was checked.
        witness = str((self.witness + 0.0).tolist())  # without -0.0
        rows = [
            ("depth", f"{self.depth:.4g}, at least {self.lower_bound:.4g}"),
            ("witness", witness + (", verified" if self.verified else ", free when the model was learned")),
            ("moves by", f"{self.max_displacement:.4g} m at most"),
            ("colliding", _listed(self.colliding)),
        ]
        if self.outside:
            rows.append(("outside", "limits of " + ", ".join(self.outside)))
        if self.kept:
            rows.append(("kept", ", ".join(f"off by {position:.2g} m, {rotation:.2g} rad" for position, rotation in self.kept)))
        if self.touching or self.effort != "nearest":
            rows.append(("touching", _listed(self.touching)))
        rows += [("exit", f"{other.depth:.4g}, touching {_listed(other.touching)}") for other in self.exits[1:]]
        return rows


def _listed(pairs: List[NamePair]) -> str:
    return ", ".join(f"{first} - {second}" for first, second in pairs) or "nothing"
