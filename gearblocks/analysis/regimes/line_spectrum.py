"""Amplitude spectrum of a steady motion over whole periods: its Fourier coefficients, without a window.

    y(t) = a_0 + sum a_k cos(2 pi k t / (m T) + phi_k),   T: period of the section, m: periods after which the motion repeats

Knows nothing of motions that do not repeat; `run.spectrum` shows those, under a window.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.carried import output_of
from gearblocks.analysis.regimes.response import sampled
from gearblocks.analysis.regimes.sizes import turned
from gearblocks.analysis.regimes.strobe import strobe
from gearblocks.analysis.regimes.turns import around
from gearblocks.analysis.sections import LONGEST, Section, repeats
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, by_name_only
from gearblocks.running import build
from gearblocks.simulation.plausibility import warn_of_parameters
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class LineSpectrum:
    """Lines of output `of` [unit]: frequency [Hz], order (times that of the section), amplitude [unit] and phase [rad] of a
    cosine, shape (n,); the first one is the mean. periods: of the section, after which the motion repeats; miss: by how
    much of its swing the output misses itself after these: what the lines are right to."""

    frequency: Array
    order: Array
    amplitude: Array
    phase: Array
    of: str
    unit: str
    periods: int
    miss: float

    def __repr__(self) -> str:
        top = 1 + int(np.argmax(self.amplitude[1:]))
        largest = f"{self.amplitude[top]:.6g} {self.unit} at {self.frequency[top]:.6g} Hz (order {self.order[top]:.6g})"
        return f"<lines of {self.of}, period {self.periods}: largest {largest}, right to {self.miss:.1e} of the swing>"

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Amplitudes but the mean over the order; saved where a path is given."""
        from gearblocks.analysis.regimes.order_pictures import draw_lines

        return draw_lines(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """Over the order, with units."""
        import xarray

        data = {
            "amplitude": ("order", self.amplitude, {"units": self.unit}),
            "phase": ("order", self.phase, {"units": "rad"}),
            "frequency": ("order", self.frequency, {"units": "Hz"}),
        }
        return xarray.Dataset(data, coords={"order": self.order}, attrs={"of": self.of, "periods": self.periods})


@by_name_only
def spectrum(
    train: Drivetrain | Model, *, section: Section, of: str | None = None, transient: int = 300, longest: int = LONGEST,
    samples: int = 1024, rtol: float = 1e-9, parameters: Mapping[str, float | str] | None = None, initial: Any = None,
) -> LineSpectrum:  # fmt: skip
    """Amplitudes and phases of an output of the steady motion after `transient` periods of the section, line by line.

    of: an output (default: the first deflection or twist); samples: in each period of the section, a power of two; lines up
    to half as many stand out. longest: period that is looked for. rtol, parameters and initial: as for `simulate`. Raises
    ParameterError where the motion does not repeat.
    """
    model = build(train)
    if transient < 1 or longest < 1 or samples < 8 or samples & (samples - 1):
        raise ParameterError(
            f"transient = {transient} and longest = {longest} must be >= 1, samples = {samples} a power of two >= 8"
        )
    quantity = model.program.outputs[output_of(model.program, of)]
    seen = strobe(model, section, parameters, initial, rtol)
    warn_of_parameters(model, parameters)
    passed = seen.follow(seen.start(initial), transient + 2 * longest + 1).states
    y, after = passed[-1], len(passed)
    turns = turned(seen, y, after).turns
    between = seen.follow(y, longest, after=after, parts=16).states
    points, between = (around(np.where(turns > 0.0, 0.0, x), x, turns) for x in (passed[transient - 1 :], between))
    extent = np.abs(np.vstack([points[1:], between])).max(axis=0)
    period, off, _ = repeats(points, longest, np.where(extent > 0.0, extent, 1.0))
    if period is None:
        raise ParameterError(
            f"the motion misses itself by {off:.1e} of its size at the least within {longest} periods: give a longer "
            f"transient; a motion that does not repeat has run.spectrum('{quantity.name}')"
        )
    back = after % period  # so that phases are those of t = 0
    x = sampled(seen, passed[-1 - back], period, quantity.name, samples, after=after - back)
    n = len(x) - 1
    parts = np.fft.rfft(x[:-1]) / n
    parts[1 : n // 2] *= 2  # each part stands at a frequency and at its negative
    order = np.arange(n // 2 + 1) / period
    swing = float(np.ptp(x))
    miss = abs(float(x[-1] - x[0])) / swing if swing > 0 else 0.0
    return LineSpectrum(
        order / seen.period, order, np.abs(parts), np.angle(parts), quantity.name, quantity.unit, period, miss
    )
