"""Arrays of other packages, such as torch and jax: their tensors in, tensors of the same kind out."""

from __future__ import annotations

import importlib
from typing import Any, Callable

import numpy as np
import numpy.typing as npt


def to_numpy(name: str, values: Any) -> npt.NDArray[Any]:
    """Returns values as an array of NumPy, without a copy if they speak DLPack or the buffer protocol.

    Rows of different shapes make an array of objects. Raises ValueError for a tensor that NumPy cannot read.
    """
    if isinstance(values, np.ndarray):
        return values
    if hasattr(values, "__dlpack__"):
        try:
            return np.from_dlpack(values)
        except (BufferError, RuntimeError, TypeError) as error:
            raise ValueError(f"{name}: got {type(values).__name__} ({error}), expected a tensor on the CPU without gradients") from None
    try:
        return np.asarray(values)
    except ValueError:
        found = np.empty(len(values), dtype=object)
        for place, row in enumerate(values):
            found[place] = row
        return found


def maker(values: Any) -> Callable[[npt.NDArray[Any]], Any]:
    """Returns a function that makes what `values` are of an array of NumPy; it shares the array's memory if it can."""
    if isinstance(values, np.ndarray) or not hasattr(values, "__dlpack__"):
        return lambda array: array
    if hasattr(values, "__array_namespace__"):
        space = values.__array_namespace__()
    else:
        space = importlib.import_module(type(values).__module__.partition(".")[0])
    # Arrays of objects, such as paths of different lengths, stay as they are.
    return lambda array: array if array.dtype == object else space.from_dlpack(array)
