"""States of a run as colours: stuck, sliding or free friction, and the side on which teeth, play and stops are in contact."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from gearblocks.drawing.scheme import Scheme
from gearblocks.errors import ParameterError

STUCK, SLIDING, FREE = "#0072b2", "#d55e00", "#999999"
DRIVE, COAST = "#00845f", "#b0457f"
_MODES = {0: (STUCK, "stuck"), 1: (SLIDING, "slides forward"), -1: (SLIDING, "slides backward"), 2: (FREE, "free")}
_CONTACTS = {1: (DRIVE, "contact on the drive side"), -1: (COAST, "contact on the coast side"), 0: (FREE, "no contact")}
LEGEND = {
    STUCK: "stuck", SLIDING: "slides", FREE: "free or open", DRIVE: "contact, drive side", COAST: "contact, coast side"
}  # fmt: skip


def colours(scheme: Scheme, run: Any, at: float | None) -> dict[int, tuple[str, str]]:
    """(colour, words) of every element with a mode or a contact side among the outputs of a run, at a time (its end)."""
    index = _sample(run, at)
    found = {}
    for i, e in enumerate(scheme.elements):
        told = [_told(run, name, index) for path, _ in e.blocks for name in _names(run, path)]
        if told:
            words = "; ".join(dict.fromkeys(f"{name}: {state}" for name, _, state in told))
            shown = [colour for _, colour, _ in told]
            busy = [colour for colour in shown if colour != FREE]
            found[i] = (busy or shown)[0], words
    return found


def _names(run: Any, path: str) -> list[str]:
    inner = re.compile(re.escape(path) + r"(\..+)?\.(mode|contact)")
    return [name for name in run.names if inner.fullmatch(name)]


def _told(run: Any, name: str, index: int) -> tuple[str, str, str]:
    """Name, colour and words of one output."""
    value = round(float(run[name][index]))
    table = _MODES if name.endswith(".mode") else _CONTACTS
    return name.rpartition(".")[0], *table[value]


def _sample(run: Any, at: float | None) -> int:
    """The last sample at or before a time; ParameterError where there is none."""
    times: Sequence[float] = [float(t) for t in run.t]
    if not times:
        raise ParameterError("draw: the run has no samples, so it has no state to show")
    if at is None:
        return len(times) - 1
    if not times[0] <= at <= times[-1]:
        raise ParameterError(f"draw: at = {at!r} s must lie within the run, {times[0]:.6g} .. {times[-1]:.6g} s")
    return max(i for i, t in enumerate(times) if t <= at)
