"""What is known of a run before quantities are measured on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.sections import Section, section_period
from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError
from gearblocks.simulation.records import NamedValues
from gearblocks.simulation.trajectory import Trajectory

Array = NDArray[np.float64]


@final
@dataclass(frozen=True, slots=True)
class Span:
    """The run that quantities are asked of: begin and end [s], units of its outputs by name, components with events and
    with losses (None: not known), and values of its parameters. after: start of windows that do not say one [s];
    section, most: that of points which do not say one, and how many there are at most."""

    begin: float
    end: float
    units: Mapping[str, str]
    components: tuple[str, ...] | None
    losses: tuple[str, ...] | None
    parameters: Mapping[str, float]
    after: float | None = None
    section: Section | None = None
    most: int | None = None

    def section_times(self, section: Section) -> Array:
        """Times of the points of a section within the run [s]."""
        period = section_period(section, self.parameters)
        first = self.begin if self.after is None else self.after
        numbers = np.arange(np.ceil(first / period * (1 - 1e-12)), np.floor(self.end / period * (1 + 1e-12)) + 1)
        times: Array = np.minimum(np.maximum(period * numbers, self.begin), self.end)
        return times[: self.most]


def program_span(program: Program, begin: float, end: float, vector: Array, section: Section | None) -> Span:
    """A run of a program from begin to end [s]."""
    return Span(
        begin, end, program.output_units, program.event_table.components, program.integral_components["loss"][0],
        NamedValues(program.parameter_numbers, vector), section=section,
    )  # fmt: skip


def span_of_run(run: Trajectory) -> Span:
    """What is known of a run that is there. Raises ParameterError for one without samples."""
    if len(run.t) < 1:
        raise ParameterError("a run without samples has no quantities")
    if run.case is None:
        parameters = dict(run.meta.get("parameters", {}))
        return Span(float(run.t[0]), float(run.t[-1]), run.units, None, (*run.energy.dissipated,), parameters)
    case = run.case
    return program_span(case.library.program, case.begin, float(run.t[-1]), case.parameters, None)
