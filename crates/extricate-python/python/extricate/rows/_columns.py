"""Columns of numbers, and calls for many rows of which some are spoiled."""

from __future__ import annotations

import re
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from .._tensors import to_numpy

Array = npt.NDArray[Any]
# By the place of a row, why it is spoiled.
Reasons = Dict[int, str]


def column(batch: Mapping[str, Any], name: str) -> Any:
    """Returns a column. Raises ValueError if there is none of this name."""
    if name not in batch:
        raise ValueError(f"columns: got {', '.join(batch) or 'none'}, expected {name!r} among them")
    return batch[name]


def length(values: Any) -> int:
    """Returns the number of rows of a column."""
    return int(values.shape[0] if hasattr(values, "shape") else len(values))


def objects(values: Sequence[Any]) -> Array:
    """Returns values as an array (n,) of objects, whatever shapes they have."""
    found = np.empty(len(values), dtype=object)
    for place, value in enumerate(values):
        found[place] = value
    return found


def table(name: str, values: Any, shape: Tuple[int, ...]) -> Tuple[Array, Reasons]:
    """Returns a column as float64 (n, *shape), and which rows are spoiled; these are nan.

    Raises ValueError if no row could fit, because the whole column has another shape or no numbers.
    """
    given = to_numpy(name, values)
    if given.dtype != object:
        if given.shape[1:] != shape:
            raise ValueError(f"{name}: got rows of shape {given.shape[1:]}, expected {shape}")
        if given.dtype.kind not in "fiub":
            raise ValueError(f"{name}: got {given.dtype}, expected numbers")
        return np.ascontiguousarray(given, dtype=np.float64), {}
    found, reasons = np.full((len(given), *shape), np.nan), {}
    for place, row in enumerate(given):
        try:
            if row is None:
                raise ValueError("got nothing")
            numbers = np.asarray(row, dtype=np.float64)
            if numbers.shape != shape:
                raise ValueError(f"got shape {numbers.shape}")
            found[place] = numbers
        except (TypeError, ValueError) as error:
            reasons[place] = f"{name}: {error}, expected numbers of shape {shape}"
    return found, reasons


def sifted(call: Callable[[Array], Any], places: Array) -> Tuple[List[Tuple[Array, Any]], Reasons]:
    """Calls a function with the places of rows; if it raises ValueError, with halves of them, down to the rows that are spoiled.

    Returns the places and the result of each call that went well, in order, and which rows are spoiled.
    """
    good: List[Tuple[Array, Any]] = []
    reasons: Reasons = {}
    waiting = [places]
    while waiting:
        some = waiting.pop()
        try:
            good.append((some, call(some)))
        except ValueError as error:
            if len(some) < 2:
                reasons.update((int(place), reason_of(error)) for place in some)
            else:
                middle = len(some) // 2
                waiting += [some[middle:], some[:middle]]
    return good, reasons


def reason_of(error: Exception) -> str:
    """Returns the message of an error of a call for one row, without the number that the row has there."""
    return re.sub(r"\[0(\]|, )", lambda found: "" if found[1] == "]" else "[", str(error), count=1)
