"""What accuracy costs in a scene: points of work and precision, the cheapest of them, and the sentences that they say."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Effort
from gearblocks.analysis.scenes.reference import CHANGE, Reference
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.errors import ParameterError, UnknownNameError, did_you_mean
from gearblocks.files import write_text
from gearblocks.pages import small_table
from gearblocks.simulation.records import Stats

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_DIGITS = 6  # further digits, at most, that the price of one is told from


@final
@dataclass(frozen=True, slots=True, eq=False)
class Point:
    """One run: values of the quantities and their relative errors, shape (Q,); stats: of the run without its outputs;
    failure: why it did not come to its end, or ""."""

    effort: Effort
    values: Array
    errors: Array
    stats: Stats = field(default_factory=Stats)
    failure: str = ""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Verified:
    """How the reference was verified: by a run of another method, whose quantities differ from it by so much, relative."""

    effort: Effort
    errors: Array


@final
@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """The cheapest way to an accuracy: how the run is made, errors and their bound, and what it is predicted to cost."""

    effort: Effort
    errors: Array
    rhs_calls: float
    seconds: float
    stats: Stats

    def __str__(self) -> str:
        return f"{self.effort}: {self.rhs_calls:,.0f} right-hand sides, {1e3 * self.seconds:.3g} ms"


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class WorkPrecision:
    """What accuracy costs in a scene. points: all runs; verified: the run of another method beside the reference (None: there
    is none); late: share of the right-hand sides in the second half of the window; quantities_cost: CPU seconds that
    measuring the quantities takes besides the cheapest run.

    print() shows sentences and table, .plot(path) draws it, .to_csv(path) writes it, .cheapest(within) chooses.
    """

    scene: Scene
    reference: Reference
    verified: Verified | None
    points: tuple[Point, ...]
    late: float = 0.5
    quantities_cost: float = 0.0

    @property
    def scattered(self) -> tuple[str, ...]:
        """Names of the quantities that no single run answers: a change of the parameters by 1e-9, or another method, moves
        them by more than is wanted."""
        apart = self.reference.moved if self.verified is None else self.verified.errors
        moved = np.maximum(self.reference.noise, apart)
        return tuple(name for name, x in zip(self.scene.names, moved, strict=True) if not x <= self.scene.within)

    def cheapest(
        self, within: float | None = None, *, quantity: str | None = None, t_end: float | None = None
    ) -> Choice:
        """The cheapest run whose errors are at most `within` (default: that of the scene), as are those of all tighter ones of
        its method, of one quantity or of all. t_end: for a window that ends there [s], by the price of its second half.

        Raises ParameterError where no run is as accurate, and for a scene whose quantities scatter.
        """
        which = self._number(quantity)
        asked = self.scene.within if within is None else within
        names = self.scene.names[which]
        if lost := [name for name in names if name in self.scattered]:
            raise ParameterError(f"{self.scattered_words(lost[0])}; give a wider within= or a shorter window")
        found = self.cheapest_or_none(asked, which)
        if found is None:
            best = min((float(p.errors[which].max()) for p in self.points if not p.failure), default=np.inf)
            least = max(best, float(self.reference.noise[which].max()))
            raise ParameterError(
                f"no run is within {_share(asked)} of {', '.join(names)}: the best is {_share(least)} off"
            )
        times = 1.0
        if t_end is not None:
            window = self.scene.end - self.scene.begin
            more = (t_end - self.scene.end) / window
            times = 1.0 + 2.0 * self.late * more if more >= 0 else 1.0 + more
        return Choice(
            found.effort, found.errors, times * found.stats.rhs_calls, times * found.stats.cpu_seconds, found.stats
        )

    def cheapest_or_none(self, within: float | None = None, which: slice = slice(None)) -> Point | None:
        """The point that `cheapest` chooses; None where no run is as accurate."""
        asked = self.scene.within if within is None else within
        sure: list[Point] = []
        for line in self.lines():
            for point in reversed(line):
                if point.failure or not (point.errors[which] + self.reference.noise[which] <= asked).all():
                    break
                sure.append(point)
        return min(sure, key=lambda point: point.stats.cpu_seconds, default=None)

    def lines(self) -> list[list[Point]]:
        """Points by method and whether events are located, from loose to tight."""
        found: dict[tuple[str, bool], list[Point]] = {}
        for point in self.points:
            found.setdefault((point.effort.method, point.effort.locate), []).append(point)
        return [*found.values()]

    def _number(self, quantity: str | None) -> slice:
        names = self.scene.names
        if quantity is None:
            return slice(None)
        if quantity not in names:
            raise UnknownNameError(
                f"the scene asks for {', '.join(names)}, not for '{quantity}'{did_you_mean(quantity, names)}"
            )
        i = names.index(quantity)
        return slice(i, i + 1)

    # -- words --------------------------------------------------------------------------------------------------------

    @property
    def sentence(self) -> str:
        """What the wanted accuracy of each quantity costs, what a further digit costs, and how far that holds."""
        return "\n".join(self._sentence(i, name) for i, name in enumerate(self.scene.names))

    def scattered_words(self, name: str) -> str:
        """Why no single run answers."""
        i = self.scene.names.index(name)
        moved, wanted = float(self.reference.noise[i]), _share(self.scene.within)
        if self.verified is not None and self.verified.errors[i] > max(moved, self.scene.within):
            apart = _share(float(self.verified.errors[i]))
            return (
                f"{name} is not known to {wanted}: {self.reference.effort} and {self.verified.effort} are {apart} apart"
            )
        what = f"a change of the parameters by {CHANGE:g}"
        what = what if self.reference.moved[i] == self.reference.noise[i] else "a tenth of the tolerance"
        return (
            f"{name} is scattered: {what} moves it by {_share(moved)}, more than the {wanted} wanted, so that a mean over runs "
            f"can be asked for and no single run"
        )

    def _sentence(self, i: int, name: str) -> str:
        wanted = self.scene.within
        if name in self.scattered:
            return self.scattered_words(name)
        which = slice(i, i + 1)
        best = self.cheapest_or_none(wanted, which)
        if best is None:
            return f"No run is within {_share(wanted)} of {name}."
        first = (
            f"{_share(wanted)} of {name} costs {1e3 * best.stats.cpu_seconds:.2g} ms with {_words(best.effort)} "
            f"({best.stats.rhs_calls:,} right-hand sides)"
        )
        further = [self.cheapest_or_none(wanted * 10.0**-k, which) for k in range(1, _DIGITS + 1)]
        reached = [(k, p) for k, p in enumerate(further, 1) if p is not None]
        if not reached:
            return f"{first}; a further digit is not to be had: {_share(float(self.reference.noise[i]))} is noise."
        digits, last = reached[-1]
        price = (last.stats.cpu_seconds / best.stats.cpu_seconds) ** (1 / digits)
        return f"{first}; each further digit costs x {price:.2g}, down to {_share(wanted * 10.0**-digits)}."

    def _table(self) -> list[tuple[str, ...]]:
        rows = [("method", *(f"error of {name}" for name in self.scene.names), "right-hand sides", "CPU ms")]
        for p in self.points:
            if p.failure:
                rows.append((str(p.effort), *("-" for _ in p.errors), "-", "stopped"))
            else:
                shown = (f"{x:.1e}" for x in p.errors)
                rows.append((str(p.effort), *shown, f"{p.stats.rhs_calls:,}", f"{1e3 * p.stats.cpu_seconds:.3g}"))
        return rows

    @property
    def notes(self) -> list[str]:
        """How the reference was made and verified, and what the quantities cost."""
        values = ", ".join(f"{n} = {x:.9g}" for n, x in zip(self.scene.names, self.reference.values, strict=True))
        notes = [f"Reference: {values}, by {self.reference.effort}, to {self.reference.noise.max():.0e}"]
        if self.verified is not None:
            notes.append(f"{self.verified.effort} differs from it by {self.verified.errors.max():.0e}")
        if self.points:
            notes.append(f"Measuring the quantities costs {1e3 * self.quantities_cost:.2g} ms besides the run")
        return notes

    def __str__(self) -> str:
        if not self.points:
            return f"{self.scene}\n{self.sentence}"
        rows = self._table()
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join([f"{row[0]:<{widths[0]}}", *(f"{x:>{w}}" for x, w in zip(row[1:], widths[1:], strict=True))])
            for row in rows
        ]
        return "\n".join([str(self.scene), *lines, *self.notes, self.sentence])

    def __repr__(self) -> str:
        return f"<WorkPrecision of {self.scene.name}: {len(self.points)} runs; {self.sentence.splitlines()[0]}>"

    def _repr_html_(self) -> str:
        head, *rows = self._table()
        return small_table(
            str(self.scene),
            rows,
            head=head,
            numbers=tuple(range(1, len(head))),
            notes=[*self.notes, *self.sentence.splitlines()],
        )

    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """CPU time against the error of each quantity; saved to `path` where given."""
        from gearblocks.analysis.scenes.work_precision_picture import picture

        return picture(self, path)

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """All runs, a line each."""
        head = ["method", "rtol", "step", "located", *(f'"error of {name}"' for name in self.scene.names)]
        rows = [",".join([*head, "rhs_calls", "steps", "events", "cpu_seconds"])]
        for p in self.points:
            e, s = p.effort, p.stats
            asked = [e.method, "" if e.step else repr(e.rtol), repr(e.step) if e.step else "", str(int(e.locate))]
            shown = [repr(float(x)) for x in p.errors]
            rows.append(",".join([*asked, *shown, *map(str, (s.rhs_calls, s.steps, s.events)), repr(s.cpu_seconds)]))
        write_text(Path(path), "\n".join([*rows, ""]))
        return Path(path)


def _share(x: float) -> str:
    """A share in words: "1 %", or "1e-05" where it is small."""
    return f"{100 * x:.2g} %" if 1e-4 <= x < 10 else f"{x:.0e}"


def _words(effort: Effort) -> str:
    asked = f"steps of {effort.step:g} s" if effort.step is not None else f"rtol {effort.rtol:g}"
    return f"{effort.method} at {asked}" + ("" if effort.locate else ", events not located")
