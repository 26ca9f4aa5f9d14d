"""What travels with the model into an FMU besides its equations: the solver's settings and the default experiment."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gearblocks.errors import ParameterError

METHODS = {"rk4": 0, "dp5": 1, "dp8": 2}
"""Numbers of the methods in c/gb_core.h."""

RTOL_RANGE = (1e-14, 0.1)
"""Tolerances that an FMU accepts; c/gb_fmu.c holds the same limits."""


@dataclass(frozen=True, slots=True)
class SolverOptions:
    """Settings of the solver inside the FMU. `step` is the fixed step [s], or None for adaptive steps."""

    method: str
    rtol: float
    step: float | None
    max_step: float | None
    locate: bool


def solver_options(method: str, rtol: float, step: float | None, max_step: float | None, locate: bool) -> SolverOptions:
    """Checked settings; "auto" becomes the order-8 pair, with fixed steps RK4. Raises ParameterError."""
    if method != "auto" and method not in METHODS:
        raise ParameterError(f"method '{method}' is not available in an FMU; it can be auto, {', '.join(METHODS)}")
    if not RTOL_RANGE[0] <= rtol <= RTOL_RANGE[1]:
        raise ParameterError(f"rtol = {rtol!r} must lie in [{RTOL_RANGE[0]}, {RTOL_RANGE[1]}]")
    for name, value in (("step", step), ("max_step", max_step)):
        if value is not None and not (value > 0 and math.isfinite(value)):
            raise ParameterError(f"{name} = {value!r} s must be positive and finite")
    chosen = method if method != "auto" else ("dp8" if step is None else "rk4")
    if chosen == "rk4" and step is None:
        raise ParameterError("method 'rk4' has fixed steps: give step= in s, or take dp5 or dp8")
    return SolverOptions(chosen, float(rtol), step, max_step, locate)


@dataclass(frozen=True, slots=True)
class Experiment:
    """The default experiment of the description: times [s], tolerance, communication step [s]."""

    stop: float
    tolerance: float
    step: float | None

    def __post_init__(self) -> None:
        if not (self.stop > 0 and math.isfinite(self.stop)):
            raise ParameterError(f"t_end = {self.stop!r} s must be positive and finite")
        if self.step is not None and not 0 < self.step <= self.stop:
            raise ParameterError(f"communication_step = {self.step!r} s must lie in (0, t_end = {self.stop!r}]")
