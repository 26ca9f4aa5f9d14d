"""Progress of long work on standard error: a line written anew on a terminal, an output replaced in a notebook, and in a log
a line every so often."""

from __future__ import annotations

import sys
import time
from typing import Any, final

_PATIENCE = 2.0
"""Seconds before anything is shown to who looks on."""
_FIRST, _LONGEST = 10.0, 300.0
"""Seconds before the first line of a log, and at most between two of them; the distance doubles from the one to the other."""

_TELLING, _REPORTS = 0.1, 5
"""The share that tells how long the rest takes, or so many reports before it."""


@final
class Progress:
    """Says how far some work is; called with the share done, 0 .. 1, and words about it. began: when it did, on the monotonic
    clock, where that is not now."""

    def __init__(self, name: str, hint: str = "", began: float | None = None) -> None:
        self._name, self._hint = name, hint
        self._start = time.monotonic() if began is None else began
        self._told: list[tuple[float, float]] = []
        self._next, self._distance = _FIRST, _FIRST
        self._width = 0
        self._shown: Any = None

    def __call__(self, share: float, words: str = "") -> None:
        spent = time.monotonic() - self._start
        if share <= 0:
            return
        text = f"{self._name}: {words or f'{100 * share:.0f} % done'}{self._left(share, spent)}"
        if sys.stderr.isatty():
            if spent > _PATIENCE:
                self._line(text + self._hint)
        elif (display := _notebook()) is not None:
            if spent > _PATIENCE:
                self._replace(display, text + self._hint)
        elif spent >= self._next:
            self._distance = min(2 * self._distance, _LONGEST)
            self._next = spent + self._distance
            print(text, file=sys.stderr, flush=True)

    def _left(self, share: float, spent: float) -> str:
        """How long the rest takes, where enough is done to tell; the first bit of work has its preparations in it."""
        if len(self._told) < _REPORTS:
            self._told.append((share, spent))
        first, then = (0.0, 0.0) if share >= _TELLING else self._told[0]
        if (share < _TELLING and len(self._told) < _REPORTS) or share <= first:
            return ""
        return f", {_duration((spent - then) * (1 - share) / (share - first))} left"

    def close(self) -> None:
        """Clears what was shown; lines of a log stay."""
        if self._width:
            self._line("")
            print("\r", end="", file=sys.stderr, flush=True)
        if self._shown is not None:
            self._shown.update({"text/plain": ""}, raw=True)
        self._shown = None

    def _line(self, text: str) -> None:
        """The line of a terminal, written over what stood there."""
        print(f"\r{text:<{self._width}}", end="", file=sys.stderr, flush=True)
        self._width = len(text)

    def _replace(self, display: Any, text: str) -> None:
        if self._shown is None:
            self._shown = display({"text/plain": text}, raw=True, display_id=True)
        else:
            self._shown.update({"text/plain": text}, raw=True)


def _notebook() -> Any:
    """What displays in the notebook that this process serves, else None."""
    module = sys.modules.get("IPython")
    shell = None if module is None else module.get_ipython()
    if getattr(shell, "kernel", None) is None:
        return None
    from IPython.display import display  # type: ignore[import-not-found, unused-ignore]

    return display


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
