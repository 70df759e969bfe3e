"""The progress bar of `learn`, of fleets and of runs over rows."""

from __future__ import annotations

import importlib
import sys
from typing import Any

from ._extricate import Progress


class Bar:
    """Shows the percentage of the budget with tqdm, or as a line if tqdm is not installed."""

    def __init__(self) -> None:
        self._percent = 0
        self._bar: Any = None
        try:
            tqdm = importlib.import_module("tqdm.auto")
        except ImportError:
            return
        self._bar = tqdm.tqdm(total=100, unit="%")

    def __call__(self, state: Progress) -> None:
        # Steps after the budget is spent, such as measuring, take an unknown time.
        percent = min(99, int(100 * state.fraction))
        if self._bar is not None:
            self._bar.set_description_str(state.stage, refresh=False)
            self._bar.update(percent - self._percent)
        elif percent != self._percent:
            print(f"\r{percent:3d} %  {state.stage:<24}", end="", file=sys.stderr, flush=True)
        self._percent = percent

    def close(self, done: bool) -> None:
        if self._bar is not None:
            if done:  # The last report was below 100 %.
                self._bar.update(100 - self._percent)
            self._bar.close()
        else:
            print("\r100 %" if done else "", file=sys.stderr)
