"""`learn`, with a progress bar where one is wanted."""

from __future__ import annotations

import importlib
import sys
from typing import Any, Callable, Optional, Union

from . import _extricate
from ._extricate import Model, Progress, Scene


def learn(
    scene: Scene,
    *,
    labels: Optional[int] = None,
    seconds: Optional[float] = None,
    seed: int = 0,
    threads: int = 0,
    progress: Union[bool, Callable[[Progress], Optional[bool]]] = False,
) -> Model:
    """Learns a scene: all that queries need.

    labels: most exact collision checks to spend; 2,000,000 where None.
    seconds: most seconds to spend; where None, 90, or without limit where `labels` is given. Without a limit in seconds the
        model depends on scene, labels and seed alone.
    seed: of all random numbers.
    threads: 0 for one per core. The model does not depend on it.
    progress: True for a bar (tqdm's, where it is installed), or a function that is called with a `Progress` about twenty times
        a second, on the calling thread; where it returns False, learning ends early and what was learned is kept.

    Ctrl-C ends learning with KeyboardInterrupt, and what was learned is lost.
    Raises RuntimeError where no free configuration was found, ValueError for options that make no sense.
    """
    if callable(progress):
        return _extricate.learn(scene, labels=labels, seconds=seconds, seed=seed, threads=threads, progress=progress)
    bar = _Bar() if progress else None
    try:
        return _extricate.learn(scene, labels=labels, seconds=seconds, seed=seed, threads=threads, progress=bar)
    finally:
        if bar is not None:
            bar.close()


class _Bar:
    """Percent of the budget: tqdm's bar, or a line where that is not installed."""

    def __init__(self) -> None:
        self._percent = 0
        self._bar: Any = None
        try:
            tqdm = importlib.import_module("tqdm.auto")
        except ImportError:
            return
        self._bar = tqdm.tqdm(total=100, unit="%")

    def __call__(self, state: Progress) -> None:
        percent = int(100 * state.fraction)
        if self._bar is not None:
            self._bar.set_description_str(state.stage, refresh=False)
            self._bar.update(percent - self._percent)
        elif percent != self._percent:
            print(f"\r{percent:3d} %  {state.stage:<24}", end="", file=sys.stderr, flush=True)
        self._percent = percent

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()
        else:
            print(file=sys.stderr)
