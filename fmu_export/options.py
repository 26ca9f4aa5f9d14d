"""What travels with the model into an FMU besides its equations: the solver's settings and the default experiment."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gearblocks.errors import ParameterError
from gearblocks.simulation.arguments import method_options
from gearblocks.solver.structures import Method, Options

RTOL_RANGE = (1e-14, 0.1)
"""Tolerances that an FMU accepts; c/gb_fmu_internal.h holds the same limits."""


@dataclass(frozen=True, slots=True)
class SolverOptions:
    """Settings of the solver inside the FMU. `step` is the fixed step [s], or None for adaptive steps."""

    method: str
    rtol: float
    step: float | None
    max_step: float | None
    locate: bool

    def to_core(self, stop: float | None) -> Options:
        """The structure of c/gb_core.h; stop: a time [s] that no step passes, or None."""
        method = int(Method[self.method.upper()])
        limits = (self.step or 0.0, self.max_step or math.inf, math.inf if stop is None else stop)
        return Options(method, int(self.locate), self.rtol, *limits)


def solver_options(
    method: str, rtol: float, step: float | str | None, max_step: float | str | None, locate: bool
) -> SolverOptions:
    """Settings as simulate() would choose them for these arguments. Raises ParameterError."""
    chosen, _ = method_options(method, rtol, step, max_step, locate, math.inf)
    longest = chosen.max_step if math.isfinite(chosen.max_step) else None
    return SolverOptions(Method(chosen.method).name.lower(), chosen.rtol, chosen.step or None, longest, bool(locate))


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
