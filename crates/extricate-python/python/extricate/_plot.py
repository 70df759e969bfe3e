"""The figure that `Answer.plot` draws."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, List

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ._answer import Answer

# The colours of pages: the query, the exit, what is proved, what is not.
_QUERY, _EXIT, _PROVED, _OPEN = "#d55e00", "#2f86c1", "#2f3b4c", "#dfe4eb"


def plotted(answer: Answer, scene: Any, q: npt.NDArray[np.float64]) -> Any:
    """Draws an answer to the query `q` of a scene; see `Answer.plot`."""
    try:
        plt: Any = importlib.import_module("matplotlib.pyplot")
    except ImportError as error:
        raise ImportError("plot needs matplotlib: pip install 'extricate[plot]'") from error
    names: List[str] = []
    for joint in scene.joints:
        count = joint.stop - joint.start
        names += [joint.name] if count == 1 else [f"{joint.name}.{k}" for k in range(count)]
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(7, 2.2 + 0.28 * len(names)), height_ratios=[1, max(2.0, 0.45 * len(names))], layout="constrained"
    )
    above.barh(0, answer.depth, color=_OPEN, hatch="///", edgecolor="#9aa4b2", label="depth")
    above.barh(0, answer.lower_bound, color=_PROVED, label="lower bound, proved")
    share = f"{100 * (1 - answer.gap):.0f} % proved" if answer.depth > 0 else "free"
    above.set(yticks=[], xlabel="distance from the query", title=f"depth {answer.depth:.4g}, at least {answer.lower_bound:.4g}: {share}")
    above.set_xlim(0, 1.05 * answer.depth if answer.depth > 0 else 1)
    above.legend(loc="center right", fontsize="small")
    rows = np.arange(len(names))
    below.hlines(rows, q, answer.witness, color="#9aa4b2", zorder=1)
    below.scatter(q, rows, color=_QUERY, marker="s", label="query", zorder=2)
    below.scatter(answer.witness, rows, color=_EXIT, label="witness", zorder=3)
    below.set(yticks=rows, yticklabels=names, xlabel="rad or m", ylim=(len(names) - 0.5, -0.5))
    below.grid(axis="x", alpha=0.3)
    below.legend(fontsize="small")
    return figure
