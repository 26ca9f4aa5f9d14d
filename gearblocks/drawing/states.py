"""States of a run as colours: stuck, sliding or free friction, and the side on which teeth, play and stops are in contact.

Colours are told apart by people with any colour vision (Okabe and Ito 2008). A gear with losses is shown where it is stuck; the
direction in which it turns is no state of friction.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gearblocks.blocks import HardStop, LossyGear, Worm
from gearblocks.drawing.scheme import Scheme
from gearblocks.errors import ParameterError
from gearblocks.language.block import Block

STUCK, SLIDING, FREE = "#0072b2", "#d55e00", "#999999"
DRIVE, COAST = "#00845f", "#b0457f"
_MODES = {0: (STUCK, "stuck"), 1: (SLIDING, "slides forward"), -1: (SLIDING, "slides backward"), 2: (FREE, "free")}
_CONTACTS = {1: (DRIVE, "contact on the drive side"), -1: (COAST, "contact on the coast side"), 0: (FREE, "no contact")}
_STOPS = {1: (DRIVE, "at the upper stop"), -1: (COAST, "at the lower stop"), 0: (FREE, "between the stops")}
_LOSSES = {0: (STUCK, "stuck")}
LEGEND = {
    STUCK: "stuck", SLIDING: "slides", FREE: "free or open", DRIVE: "contact, drive side (stop: upper)",
    COAST: "contact, coast side (stop: lower)",
}  # fmt: skip


def colours(scheme: Scheme, run: Any, at: float | None) -> dict[str, tuple[str, str]]:
    """(colour, words) by name of every element with a mode or a contact side among the outputs of a run, at a time (its end).

    Raises ParameterError for a time outside of the run, and for a run of another train.
    """
    index = _sample(run, at)
    outputs = _outputs(run.names)
    paths = [path for e in scheme.elements for path, _ in e.blocks]
    if len(run.names) and not any(name.startswith(f"{path}.") for path in paths for name in run.names):
        raise ParameterError(f"draw: the run is of another train: none of its outputs is of a part of '{scheme.name}'")
    found = {}
    for e in (one for whole in scheme.elements for one in (whole.parallel or (whole,))):
        told = [
            (name.rpartition(".")[0], *state) for path, block in e.blocks for name in outputs[path]
            if (state := _state(block, name, float(run[name][index]))) is not None
        ]  # fmt: skip
        if told:
            words = "\n".join(dict.fromkeys(f"{name}: {state}" for name, _, state in told))
            shown = [colour for _, colour, _ in told]
            found[e.name] = next((colour for colour in shown if colour != FREE), FREE), words
    return found


def _outputs(names: Sequence[str]) -> Mapping[str, list[str]]:
    """Modes and contact sides among outputs, by the path of their block and of all that it is a part of."""
    found = defaultdict[str, list[str]](list)
    for name in names:
        path, _, last = name.rpartition(".")
        while last in ("mode", "contact") and path:
            found[path].append(name)
            path = path.rpartition(".")[0]
    return found


def _state(block: Block, name: str, value: float) -> tuple[str, str] | None:
    """Colour and words of one output; None for a value that means something else."""
    table = _CONTACTS if name.endswith(".contact") else _MODES
    if isinstance(block, HardStop):
        table = _STOPS
    elif isinstance(block, (LossyGear, Worm)):
        table = _LOSSES
    return table.get(value)  # type: ignore[call-overload, no-any-return]  # whole numbers as floats


def _sample(run: Any, at: Any) -> int:
    """The last sample at or before a time; ParameterError where there is none, or what is given is no run or no time."""
    if not hasattr(run, "names") or not hasattr(run, "t"):
        raise ParameterError(f"draw: run = {run!r:.80} must be a run, as gb.simulate answers with")
    times: Sequence[float] = [float(t) for t in run.t]
    if not times:
        raise ParameterError("draw: the run has no samples, so it has no state to show")
    if at is None:
        return len(times) - 1
    if isinstance(at, bool) or not isinstance(at, (int, float, np.number)):
        raise ParameterError(f"draw: at = {at!r:.80} must be a time in s")
    if not times[0] <= at <= times[-1]:
        raise ParameterError(f"draw: at = {at!r} s must lie within the run, {times[0]:.6g} .. {times[-1]:.6g} s")
    return max(i for i, t in enumerate(times) if t <= at)
