"""Quantities of vibration: the dynamic factor of a mesh, a line of a spectrum, the period of a motion.

Frozen values, as those in `quantities.py`. Window [after, before]: the part of the run that counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.quantity import Quantity, text_of, time_of
from gearblocks.analysis.sections import LONGEST, RELATIVE, Section, repeats, stroboscopic
from gearblocks.analysis.span import Span
from gearblocks.errors import ParameterError, UnknownNameError, by_name_only, did_you_mean
from gearblocks.language.expression import finite_number
from gearblocks.language.units import has_unit, number_in_si
from gearblocks.model.listing import matches
from gearblocks.simulation.needs import Along, Needs, Solution

Array = NDArray[np.float64]

_FACTORS = ("contact", "print")
_EXTREMES = {"peak": "trough", "trough": "peak", "mean": "mean"}
_LEAST_SAMPLES, _MOST_SAMPLES, _PER_PERIOD = 1 << 12, 1 << 18, 32


@final
@dataclass(frozen=True, slots=True)
class DynamicFactor(Quantity):
    """Peak, trough or mean of N/F ("contact") or of (F + k x)/F ("print") in the window: N the force of a mesh, k its
    stiffness, x its deflection, F its force in the static equilibrium with every excitation at its mean. samples: so many
    equal distances from the begin of the window are looked at instead of the motion between them."""

    component: str
    kind: str = "contact"
    which: str = "peak"
    samples: int | None = None
    after: float | None = None
    before: float | None = None
    word: ClassVar[str] = "dynamic_factor"
    positional: ClassVar[tuple[str, ...]] = ("component",)

    def _outputs(self) -> tuple[str, ...]:
        """The force, or deflection and stiffness."""
        names = ("force",) if self.kind == "contact" else ("deflection", "stiffness")
        return tuple(f"{self.component}.{name}" for name in names)

    def _along(self, span: Span) -> tuple[Along, Along]:
        """What is asked for, of a force along F and of one against it."""
        output, factor = (*self._outputs(), "")[:2]
        start, end = self.window(span)
        kinds = (self.which, _EXTREMES[self.which])
        return Along(kinds[0], output, start, end, factor), Along(kinds[1], output, start, end, factor)

    def _times(self, span: Span) -> Array:
        start, end = self.window(span)
        times: Array = start + (end - start) * np.arange(self.samples or 0) / (self.samples or 1)
        return times

    def unit(self, span: Span) -> str:
        """A number."""
        for what, value, known in (("kind", self.kind, _FACTORS), ("which", self.which, (*_EXTREMES,))):
            if value not in known:
                words = f"{self.name}: {what} = {value!r} must be one of {', '.join(known)}"
                raise ParameterError(f"{words}{did_you_mean(value, known)}")
        if self.samples is not None and (not isinstance(self.samples, int) or self.samples < 2):
            raise ParameterError(f"{self.name}: samples = {self.samples!r} must be a whole number >= 2")
        for output in (f"{self.component}.force", *self._outputs()):
            if output not in span.units:
                meshes = [x.rpartition(".")[0] for x in span.units if x.endswith(".force")]
                component = str(self.component)
                near = f"; name the part, '{part}'" if (part := component.rpartition(".")[0]) in meshes else ""
                name = output.rpartition(".")[2]
                raise UnknownNameError(
                    f"{self.name}: '{component}' is no part with an output '{name}', as meshes have"
                    f"{near or did_you_mean(component, meshes)}"
                )
        self.window(span)
        return "1"

    def needs(self, span: Span) -> Needs:
        """The force in the equilibrium, and what it is related to."""
        static = (f"{self.component}.force",)
        if self.samples is not None:
            return Needs(self._outputs(), tuple(self._times(span).tolist()), static=static)
        return Needs(along=self._along(span), static=static)

    def measure(self, run: Solution, span: Span) -> float:
        """The factor. Raises ParameterError where the equilibrium has no force."""
        static = run.static_value(f"{self.component}.force")
        if self.samples is not None:
            force = run.table(self._outputs(), self._times(span)).prod(axis=1)
            known = {"peak": force.max(), "trough": force.min(), "mean": force.mean()}
            along, against = (float(known[which]) for which in (self.which, _EXTREMES[self.which]))
        else:
            along, against = (run.along_run(one) for one in self._along(span))
        if abs(static) <= 1e-9 * max(abs(along), abs(against)):
            raise ParameterError(
                f"{self.name}: '{self.component}' carries no force in the static equilibrium ({static:.3g} N), so there is "
                f"nothing to relate to; gb.peak('{self.component}.force') needs none"
            )
        factor = (along if static > 0 else against) / static
        return factor if self.kind == "contact" else 1.0 + factor


@final
@dataclass(frozen=True, slots=True)
class Line(Quantity):
    """Amplitude of the part of an output at a frequency f [Hz], as in `run.spectrum`, under the window of Hann h:

    2/T |int (y(t) - m) h(t) exp(-2 pi i f t) dt|,  h = 1 - cos(2 pi (t - after)/T),  m = 1/T int y h dt,  T = before - after

    by sums over equal distances. Parts nearer than 4/T are not told apart.
    """

    output: str
    frequency: float
    after: float | None = None
    before: float | None = None
    word: ClassVar[str] = "line"
    positional: ClassVar[tuple[str, ...]] = ("output", "frequency")

    def _times(self, span: Span) -> Array:
        start, end = self.window(span)
        periods = self.frequency * (end - start)
        if not periods >= 4.0:
            raise ParameterError(
                f"{self.name}: the window of {end - start:g} s holds {periods:.3g} periods of {self.frequency:g} Hz; "
                f"it takes 4 to tell the part from the mean"
            )
        n = 1 << int(np.ceil(np.log2(max(_LEAST_SAMPLES, _PER_PERIOD * periods))))
        if n > _MOST_SAMPLES:
            raise ParameterError(
                f"{self.name}: the window of {end - start:g} s holds {periods:.3g} periods of {self.frequency:g} Hz, more "
                f"than are summed; give a later after="
            )
        times: Array = start + (end - start) * np.arange(n) / n
        return times

    def unit(self, span: Span) -> str:
        """That of the output."""
        unit = self.output_unit(span)
        self._times(span)
        return unit

    def needs(self, span: Span) -> Needs:
        """The output at equal distances."""
        return Needs((self.output,), tuple(self._times(span).tolist()))

    def measure(self, run: Solution, span: Span) -> float:
        """The amplitude."""
        times = self._times(span)
        values = run.table([self.output], times)[:, 0]
        shape = 1 - np.cos(2 * np.pi * np.arange(len(times)) / len(times))
        wave = shape * np.exp(-2j * np.pi * self.frequency * (times - times[0]))
        return float(2 * abs((values - values @ shape / len(times)) @ wave) / len(times))


@final
@dataclass(frozen=True, slots=True)
class Period(Quantity):
    """Number of periods of a section after which the motion repeats, at most `longest`; 0 where it does not.

    Judged by the points within the window, of one accuracy; `of`: outputs, or patterns of them. Knows nothing of orbits:
    `gb.classify` finds them, and gives its evidence.
    """

    section: Section | None = None
    of_outputs: tuple[str, ...] = ()
    longest: int = LONGEST
    after: float | None = None
    before: float | None = None
    word: ClassVar[str] = "period"
    positional: ClassVar[tuple[str, ...]] = ("section",)

    @property
    def name(self) -> str:
        """How it is written."""
        words = [self.section.frequency] if self.section else []
        words += [f"of={' '.join(self.of_outputs)}"] if self.of_outputs else []
        words += [f"longest={self.longest}"] if self.longest != LONGEST else []
        words += [f"{n}={x:.12g}" for n, x in (("after", self.after), ("before", self.before)) if x is not None]
        return f"period({', '.join(words)})"

    def _asked(self, span: Span) -> tuple[tuple[str, ...], Array]:
        """Outputs, and times of the points."""
        section = self.section or span.section
        if section is None:
            raise ParameterError(f"{self.name} needs a section: give gb.stroboscopic(...) to it or to the study")
        start, end = self.window(span)
        times = span.section_times(section)
        times = times[(times >= start) & (times <= end)]
        if len(times) <= 2 * self.longest:
            raise ParameterError(
                f"{self.name}: there are {len(times)} points from {start:g} to {end:g} s; more than twice longest = "
                f"{self.longest} show that a motion repeats"
            )
        patterns = self.of_outputs or tuple(f"*.{name}" for name in RELATIVE)
        names = tuple(name for name in span.units if any(matches(name, pattern) for pattern in patterns))
        if not names:
            raise UnknownNameError(f"{self.name}: no output matches {', '.join(patterns)}; rig.outputs() lists them")
        return names, times

    def unit(self, span: Span) -> str:
        """A number."""
        self._asked(span)
        return "1"

    def _extents(self, span: Span) -> list[tuple[Along, Along]]:
        """Highest and lowest value of each output while the last periods go by."""
        names, times = self._asked(span)
        start, end = float(times[max(len(times) - 5, 0)]), float(times[-1])
        return [(Along("peak", name, start, end), Along("trough", name, start, end)) for name in names]

    def needs(self, span: Span) -> Needs:
        """The outputs at the points, and how far they go between them."""
        names, times = self._asked(span)
        along = tuple(one for pair in self._extents(span) for one in pair)
        return Needs(names, tuple(times.tolist()), along=along)

    def measure(self, run: Solution, span: Span) -> float:
        """The period, 0 where there is none within the longest."""
        names, times = self._asked(span)
        extent = np.array([max(abs(run.along_run(one)) for one in pair) for pair in self._extents(span)])
        extent[extent == 0.0] = 1.0
        return float(repeats(run.table(names, times), self.longest, extent)[0] or 0)


@by_name_only
def dynamic_factor(
    component: str, kind: str = "contact", which: str = "peak", *, samples: int | None = None,
    after: float | str | None = None, before: float | str | None = None,
) -> DynamicFactor:  # fmt: skip
    """Dynamic factor of a mesh or spline between the times after and before [s]: its force over that of the static
    equilibrium at mean excitations, F.

    kind: "contact", N/F with the mesh force N; or "print", (F + k x)/F with stiffness k and deflection x, gap included, as
    some papers print it. which: its "peak", "trough" or "mean". samples: of so many values at equal distances from `after`
    (as tables of papers have them), not of the motion between.
    """
    return DynamicFactor(
        text_of("component", component), kind, which, samples, time_of("after", after), time_of("before", before)
    )  # fmt: skip


@by_name_only
def line(
    output: str, frequency: float | str, *, after: float | str | None = None, before: float | str | None = None
) -> Line:
    """Amplitude, in its unit, of the part of an output at a frequency [Hz, or such as "1.15 kHz"], between the times after and
    before [s]."""
    what = "line: frequency"
    number = number_in_si(what, frequency, "Hz") if has_unit(frequency) else finite_number(what, frequency)
    if not number > 0:
        raise ParameterError(f"line: frequency = {frequency!r} Hz must be > 0; gb.mean(output) is the part at 0")
    return Line(text_of("output", output), number, time_of("after", after), time_of("before", before))


@by_name_only
def period(
    section: Section | str | None = None, *, of: str | Sequence[str] = (), longest: int = LONGEST,
    after: float | str | None = None, before: float | str | None = None,
) -> Period:  # fmt: skip
    """Number of periods of a section (gb.stroboscopic("speed"), or the frequency alone) after which the motion repeats, at most
    `longest`; 0 where it does not. section: default that of the study. of: outputs or patterns that have to repeat (default:
    all deflections, twists and their rates)."""
    if isinstance(longest, bool) or not isinstance(longest, int) or longest < 1:
        raise ParameterError(f"period: longest = {longest!r} must be a whole number of periods >= 1")
    if not (section is None or isinstance(section, (Section, str))):
        raise ParameterError(f"period: section = {section!r:.80} must be one, such as gb.stroboscopic('speed')")
    where: Any = stroboscopic(section) if isinstance(section, str) else section
    chosen = tuple(of.split()) if isinstance(of, str) else tuple(text_of("of", one) for one in of)
    return Period(where, chosen, longest, time_of("after", after), time_of("before", before))
