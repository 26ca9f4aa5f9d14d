"""What acts on a train over time: how often it repeats with the section, and whether it does so from the begin on.

    dy/dt at (t, y) and at (t + m T, y) are one for all t and y

A ramp, a step and what fades repeat with nothing until they have ended. Knows nothing of motions.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.strobe import Strobe

Array = NDArray[np.float64]

DRIVES = 128
"""Periods of the section within which drives may repeat together, however short periods are asked for."""
_INSTANTS = 40
_WINDOW = 100.0  # periods, that instants are drawn from
_DENSE = 4  # power of even numbers: instants near the begin, where a short ramp may be
_ALIKE = 1e-9  # of what time alone changes of a rate
_FAR = (1e4, 1e6, 1e8)  # periods later, that what acts is looked at again
_BEYOND = 10.0  # times what time changes of a rate now: more is no drive that comes back


class Drives(NamedTuple):
    """periods: of the section after which all of them repeat, 0: none that are looked for; changing: in words, where what acts
    goes on changing or has not come to an end, so that it is no second frequency."""

    periods: int
    changing: str = ""


def drives(seen: Strobe, y: Array, longest: int, after: int) -> Drives:
    """Those that act after so many periods, at the states y."""
    if periods := drive_periods(seen, y, longest, after):
        return Drives(periods)
    here = _rates(seen, y, after, 0.0)
    middle, reach = 0.5 * (here.max(axis=0) + here.min(axis=0)), 0.5 * np.ptp(here, axis=0)
    reach = _BEYOND * reach + 1e-6 * np.abs(here).max(axis=0)
    for far in _FAR:
        if (np.abs(_rates(seen, y, after, far) - middle) > reach).any():
            return Drives(0, "what acts on the train over time goes on growing: it repeats with nothing")
        if drive_periods(seen, y, longest, after + int(far)):
            return Drives(
                0, f"what acts on the train over time is still changing after {after} periods, and repeats later"
            )
    return Drives(0)


def drive_periods(seen: Strobe, y: Array, longest: int, after: int) -> int:
    """The number of periods of the section after which all drives repeat, at most `longest`; 0: none that small."""
    here = _rates(seen, y, after, 0.0)
    allowed = _allowed(here)
    return next((m for m in range(1, longest + 1) if (np.abs(_rates(seen, y, after, m) - here) <= allowed).all()), 0)


def begun_at(seen: Strobe, y: Array, after: int) -> Strobe:
    """The same, begun after so many periods where other things act on the train before."""
    here = _rates(seen, y, after, 0.0, _DENSE)
    alike = (np.abs(_rates(seen, y, 0, 0.0, _DENSE) - here) <= _allowed(here)).all()
    return seen if alike else replace(seen, begun=after)


def repeating(seen: Strobe, y: Array, after: int) -> tuple[int, bool]:
    """The number of periods of the section after which all drives repeat, when so many have passed, 0: none that is looked for;
    and whether they act so from the time 0 on."""
    periods = drive_periods(seen, y, DRIVES, after)
    whole = after + -after % max(1, periods)
    return periods, begun_at(seen, y, whole) is seen


def _allowed(rates: Array) -> Array:
    found: Array = np.maximum(_ALIKE * np.ptp(rates, axis=0), 1e-12 * np.abs(rates).max(axis=0))
    return found


def _rates(seen: Strobe, y: Array, after: int, later: float, dense: int = 1) -> Array:
    """At instants of a window that begins `later` than after so many periods; dense: power that crowds them at its begin."""
    instants = _WINDOW * np.random.default_rng(0).uniform(0.0, 1.0, _INSTANTS) ** dense
    times = seen.period * (after + instants) + later * seen.period
    full, found = np.zeros(seen.model.program.n_total), []
    full[: seen.n] = y
    with seen.opened(y, seen.period * after) as sim:
        for t in times.tolist():
            modes = sim.probe(t, full, None, "modes")
            found.append(sim.probe(t, full, modes, "rates")[: seen.n])
    return np.array(found)
