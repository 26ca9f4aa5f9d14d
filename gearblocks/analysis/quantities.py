"""Quantities: what one number says about a run. Frozen values that can be named, compared, sent and measured.

An extremum is that of the solution, not of the samples; an integral is taken over time, not over samples.
Window [after, before]: the part of the run that counts. Knows nothing of studies.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.dynamic_quantities import dynamic_factor, line, period
from gearblocks.analysis.quantity import Quantity, belongs, known, text_of, time_of
from gearblocks.analysis.sections import Section
from gearblocks.analysis.span import Span
from gearblocks.errors import ParameterError, by_name_only, did_you_mean
from gearblocks.language.units import seconds
from gearblocks.simulation.needs import Along, Needs, Solution

Array = NDArray[np.float64]


@final
@dataclass(frozen=True, slots=True)
class Extremum(Quantity):
    """Largest (`peak`) or smallest (`trough`) value of an output in the window, located on the solution."""

    output: str
    which: str = "peak"
    after: float | None = None
    before: float | None = None

    @property
    def name(self) -> str:
        """How it is written."""
        return f"{self.which}({_arguments(self.output, self.after, self.before)})"

    def unit(self, span: Span) -> str:
        """That of the output."""
        self.window(span)
        return self.output_unit(span)

    def needs(self, span: Span) -> Needs:
        """The output between the samples."""
        return Needs(along=(Along(self.which, self.output, *self.window(span)),))

    def measure(self, run: Solution, span: Span) -> float:
        """Value of the output there."""
        return run.along_run(Along(self.which, self.output, *self.window(span)))


@final
@dataclass(frozen=True, slots=True)
class Integral(Quantity):
    """Root mean square (`rms`), mean (`mean`) or standard deviation (`std`) over time of an output in the window."""

    output: str
    which: str = "rms"
    after: float | None = None
    before: float | None = None

    @property
    def name(self) -> str:
        """How it is written."""
        return f"{self.which}({_arguments(self.output, self.after, self.before)})"

    def unit(self, span: Span) -> str:
        """That of the output."""
        self.window(span)
        return self.output_unit(span)

    def needs(self, span: Span) -> Needs:
        """The output between the samples."""
        return Needs(along=(Along(self.which, self.output, *self.window(span)),))

    def measure(self, run: Solution, span: Span) -> float:
        """Quadrature of order 8 over every smooth segment."""
        return run.along_run(Along(self.which, self.output, *self.window(span)))


@final
@dataclass(frozen=True, slots=True)
class Value(Quantity):
    """An output at a time, at the end where there is none; the right limit at an event."""

    output: str
    time: float | None = None

    @property
    def name(self) -> str:
        """How it is written."""
        return f"last({self.output})" if self.time is None else f"at({self.output}, {self.time:.12g})"

    def _time(self, span: Span) -> float:
        if self.time is not None and not span.begin <= self.time <= span.end:
            raise ParameterError(
                f"{self.name}: {self.time:g} s must lie in the run, which goes from {span.begin:g} to {span.end:g} s"
            )
        return span.end if self.time is None else float(self.time)

    def unit(self, span: Span) -> str:
        """That of the output."""
        self._time(span)
        return self.output_unit(span)

    def needs(self, span: Span) -> Needs:
        """The output at that time."""
        return Needs((self.output,), (self._time(span),))

    def measure(self, run: Solution, span: Span) -> float:
        """The value."""
        return run.value(self.output, self._time(span))


@final
@dataclass(frozen=True, slots=True)
class Count(Quantity):
    """Number of events in the window, of a component and a kind where these are given."""

    component: str | None = None
    kind: str | None = None
    after: float | None = None
    before: float | None = None
    word: ClassVar[str] = "count"
    positional: ClassVar[tuple[str, ...]] = ("component",)

    def unit(self, span: Span) -> str:
        """A number."""
        self.window(span)
        self.check_events(span)
        return "1"

    def needs(self, span: Span) -> Needs:  # noqa: ARG002
        """The events, which are always known."""
        return Needs()

    def measure(self, run: Solution, span: Span) -> float:
        """How many there are."""
        return float(len(self.chosen(run.events, span)))


@final
@dataclass(frozen=True, slots=True)
class EventTime(Quantity):
    """Time of one event in the window: number 0 is the first one, -1 the last one; NaN where there is none."""

    component: str | None = None
    kind: str | None = None
    number: int = 0
    after: float | None = None
    before: float | None = None
    word: ClassVar[str] = "event_time"
    positional: ClassVar[tuple[str, ...]] = ("component",)

    def unit(self, span: Span) -> str:
        """Seconds."""
        self.window(span)
        self.check_events(span)
        return "s"

    def needs(self, span: Span) -> Needs:  # noqa: ARG002
        """The events, which are always known."""
        return Needs()

    def measure(self, run: Solution, span: Span) -> float:
        """Its time."""
        times = self.chosen(run.events, span)["t"]
        return float(times[self.number]) if -len(times) <= self.number < len(times) else float("nan")


@final
@dataclass(frozen=True, slots=True)
class EnergyLost(Quantity):
    """Energy dissipated in the window by a component with all its parts, by its quadratures [J]."""

    component: str
    after: float | None = None
    before: float | None = None
    word: ClassVar[str] = "energy_lost"
    positional: ClassVar[tuple[str, ...]] = ("component",)

    def unit(self, span: Span) -> str:
        """Joule."""
        self.window(span)
        known(self.name, self.component, span.losses, "losses")
        return "J"

    def needs(self, span: Span) -> Needs:
        """The losses at both ends of the window."""
        return Needs(times=self.window(span), losses=self._components(span))

    def measure(self, run: Solution, span: Span) -> float:
        """Change of the quadratures."""
        start, end = self.window(span)
        return math.fsum(run.lost(name, end) - run.lost(name, start) for name in self._components(span))

    def _components(self, span: Span) -> tuple[str, ...]:
        return tuple(name for name in span.losses or () if belongs(name, self.component))


@final
@dataclass(frozen=True, slots=True)
class SectionPoints(Quantity):
    """An output at the points of a section, those within the run (after its transient), the last `keep` where given."""

    output: str
    section: Section | None = None
    keep: int | None = None
    word: ClassVar[str] = "points"

    @property
    def name(self) -> str:
        """How it is written."""
        return f"points({self.output})"

    def _times(self, span: Span) -> Array:
        section = self.section or span.section
        if section is None:
            raise ParameterError(
                f"{self.name} needs a section: give section=gb.stroboscopic(...) to it or to the study"
            )
        times = span.section_times(section)
        return times if self.keep is None else times[-self.keep :]

    def unit(self, span: Span) -> str:
        """That of the output."""
        if self.keep is not None and self.keep < 1:
            raise ParameterError(f"{self.name}: keep = {self.keep} must be >= 1")
        if not len(self._times(span)):
            raise ParameterError(
                f"{self.name}: the run from {span.begin:g} to {span.end:g} s has no point of the section"
            )
        return self.output_unit(span)

    def length(self, span: Span) -> int:
        """As many as the run has."""
        return len(self._times(span))

    def needs(self, span: Span) -> Needs:
        """The output at these times."""
        return Needs((self.output,), tuple(self._times(span).tolist()))

    def measure(self, run: Solution, span: Span) -> Array:
        """Values of the output there."""
        return np.array([run.value(self.output, time) for time in self._times(span).tolist()])


def _arguments(output: str, after: float | None, before: float | None) -> str:
    words = [output, *(f"{name}={x:.12g}" for name, x in (("after", after), ("before", before)) if x is not None)]
    return ", ".join(words)


@by_name_only
def peak(output: str, *, after: float | str | None = None, before: float | str | None = None) -> Extremum:
    """The largest value of an output between the times after and before [s] (default: the whole run), in its unit.

    Located on the solution between the samples: it does not depend on where steps end.
    """
    return Extremum(text_of("output", output), "peak", time_of("after", after), time_of("before", before))


@by_name_only
def trough(output: str, *, after: float | str | None = None, before: float | str | None = None) -> Extremum:
    """The smallest value of an output between the times after and before [s], located as by `peak`."""
    return Extremum(text_of("output", output), "trough", time_of("after", after), time_of("before", before))


@by_name_only
def rms(output: str, *, after: float | str | None = None, before: float | str | None = None) -> Integral:
    """Root mean square over time of an output between the times after and before [s], in its unit."""
    return Integral(text_of("output", output), "rms", time_of("after", after), time_of("before", before))


@by_name_only
def mean(output: str, *, after: float | str | None = None, before: float | str | None = None) -> Integral:
    """Mean over time of an output between the times after and before [s], in its unit."""
    return Integral(text_of("output", output), "mean", time_of("after", after), time_of("before", before))


@by_name_only
def std(output: str, *, after: float | str | None = None, before: float | str | None = None) -> Integral:
    """Standard deviation over time of an output between the times after and before [s], in its unit: the root mean square
    of its distance to the mean."""
    return Integral(text_of("output", output), "std", time_of("after", after), time_of("before", before))


@by_name_only
def at(output: str, time: float | str) -> Value:
    """An output at a time [s], in its unit; at an event the value after it."""
    return Value(text_of("output", output), seconds("time", time))


@by_name_only
def last(output: str) -> Value:
    """An output at the end of the run, in its unit."""
    return Value(text_of("output", output))


@by_name_only
def count(
    component: str | None = None, kind: str | None = None, *, after: float | str | None = None,
    before: float | str | None = None,
) -> Count:  # fmt: skip
    """Number of events: of a component (a name or pattern, with its parts), of a kind ("state", "time", "impact"), or all.

    The parts of a mesh with a measured table have an event at each of its points; kind="contact_lost" or "contact_made" counts
    where a mesh, spline, lash or stop opens or closes (an impact that rebounds closes).
    """
    return Count(component, kind, time_of("after", after), time_of("before", before))


@by_name_only
def event_time(
    component: str | None = None, kind: str | None = None, *, number: int = 0, after: float | str | None = None,
    before: float | str | None = None,
) -> EventTime:  # fmt: skip
    """Time [s] of an event, chosen as by `count`: number 0 is the first one, -1 the last one. NaN where there is none."""
    if isinstance(number, bool) or not isinstance(number, int):
        raise ParameterError(f"event_time: number = {number!r} must be a whole number; -1 is the last event")
    return EventTime(component, kind, number, time_of("after", after), time_of("before", before))


@by_name_only
def energy_lost(component: str, *, after: float | str | None = None, before: float | str | None = None) -> EnergyLost:
    """Energy [J] that a component (with its parts, or a pattern) dissipates between the times after and before [s]."""
    return EnergyLost(text_of("component", component), time_of("after", after), time_of("before", before))


@by_name_only
def points(output: str, section: Section | None = None, *, keep: int | None = None) -> SectionPoints:
    """An output at the points of a section (gb.stroboscopic("speed")), an array of shape (points,) in its unit.

    section: default that of the study. keep: the last so many only.
    """
    if keep is not None and (isinstance(keep, bool) or not isinstance(keep, int)):
        raise ParameterError(f"points: keep = {keep!r} must be a whole number of points")
    return SectionPoints(text_of("output", output), section, keep)


_MAKERS: dict[str, Callable[..., Quantity]] = {
    f.__name__: f
    for f in (peak, trough, rms, mean, std, at, last, count, event_time, energy_lost, dynamic_factor, line, period)
}
_CALL = re.compile(r"\s*(\w+)\s*\((.*)\)\s*", re.DOTALL)


def parsed(text: str) -> Quantity:
    """The quantity that `name` writes: "rms(mesh.force)", "peak(mesh.force, after=0.2)". Raises ParameterError."""
    call = _CALL.fullmatch(text)
    if call is None or call[1] not in _MAKERS:
        near = did_you_mean(text.partition("(")[0].strip(), _MAKERS)
        raise ParameterError(
            f"'{text}' is no quantity; there are {', '.join(_MAKERS)}, written as rms(mesh.force){near}"
        )
    arguments: list[Any] = []
    named: dict[str, Any] = {}
    for part in filter(None, (part.strip() for part in call[2].split(","))):
        name, equals, value = part.rpartition("=")
        try:
            read: Any = int(value) if name.strip() in ("number", "longest", "samples") else float(value)
        except ValueError:
            read = value.strip()
        if equals:
            named[name.strip()] = read
        else:
            arguments.append(read)
    try:
        return _MAKERS[call[1]](*arguments, **named)
    except TypeError as error:
        raise ParameterError(f"'{text}': {error}") from None
