"""Response of an output over whole periods: mean, root mean square about it, lowest and highest value.

Of the motion between the steps; or of samples, as tables of papers have them. Knows nothing of parameters.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.strobe import Strobe
from gearblocks.simulation.case import Case
from gearblocks.simulation.measured_runs import run_again
from gearblocks.simulation.needs import Along, Needs
from gearblocks.solver.structures import Method, Options

Array = NDArray[np.float64]

_KINDS = ("mean", "std", "trough", "peak")


class Response(NamedTuple):
    """mean, rms: root mean square about the mean, low, high."""

    mean: float
    rms: float
    low: float
    high: float


NONE = Response(np.nan, np.nan, np.nan, np.nan)
"""Of a motion that there is not."""


def response(
    seen: Strobe, y: Array, periods: int, output: str, *, after: int = 0, samples: int | None = None
) -> Response:
    """Of the motion from the states y over so many periods, when `after` of them have passed; samples: so many in each period,
    from its begin, in place of the motion itself. Raises SimulationError."""
    if samples is not None:
        x = sampled(seen, y, periods, output, samples, after=after)[:-1]
        return Response(float(x.mean()), float(x.std()), float(x.min()), float(x.max()))
    case = _case(seen, y, periods, after)
    along = [Along(kind, output, case.begin, case.end) for kind in _KINDS]
    with run_again(case, Needs(along=tuple(along))) as run:
        return Response(*(run.along_run(one) for one in along))


def sampled(seen: Strobe, y: Array, periods: int, output: str, samples: int, *, after: int = 0) -> Array:
    """The output at so many equal distances of each period, and at the end. Raises SimulationError."""
    case = _case(seen, y, periods, after)
    times = case.begin + (case.end - case.begin) * np.arange(periods * samples + 1) / (periods * samples)
    with run_again(case, Needs((output,), tuple(times.tolist()))) as run:
        return run.table([output], times)[:, 0]


def _case(seen: Strobe, y: Array, periods: int, after: int) -> Case:
    begin, end = after * seen.period, (after + periods) * seen.period
    full = np.zeros(seen.model.program.n_total)
    full[: seen.n] = y
    options = Options(Method.DP8, 1, seen.rtol, 0.0, np.inf, end)
    return Case(seen.model.library, seen.parameters, {}, options, begin, end, full)
