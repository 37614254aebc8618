"""Recorders: called with every stored step while an analysis runs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from kirigami.words import counted


class ProgressBar:
    """Shows how far a path analysis has come: a tqdm bar where tqdm is installed, else lines of text."""

    def __init__(self, shown: bool, title: str) -> None:
        self.shown, self.title = shown, title
        self._bar: Any = None
        self._done = 0.0
        self._steps = 0

    def start(self, share: float | None) -> None:
        if not self.shown:
            return
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return
        layout = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}{postfix}"
        if share is None:
            self._bar = tqdm(desc=self.title, unit=" steps")
        else:
            self._bar = tqdm(total=1.0, desc=self.title, bar_format=layout)

    def move(self, share: float | None) -> None:
        """Note one more step, at `share` of the whole where that is known."""
        self._steps += 1
        if not self.shown:
            return
        if self._bar is None:
            at = "" if share is None else f", {100 * share:.0f} %"
            print(f"{self.title}: step {self._steps}{at}", file=sys.stderr)
        elif share is None:
            self._bar.update(1)
        else:
            self._bar.set_postfix_str(counted(self._steps, "step"), refresh=False)
            self._bar.update(max(share - self._done, 0.0))
            self._done = max(share, self._done)

    def close(self) -> None:
        if self._bar is not None:
            self._bar.close()


@contextmanager
def progress_bar(shown: bool, title: str) -> Iterator[ProgressBar]:
    """A progress bar that is closed whatever happens."""
    bar = ProgressBar(shown, title)
    try:
        yield bar
    finally:
        bar.close()
