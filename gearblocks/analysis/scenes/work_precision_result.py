"""What accuracy costs in a scene: points of work and precision, the cheapest of them, and the sentences that they say."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.scenes.bench import Effort
from gearblocks.analysis.scenes.reference import Reference
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.analysis.scenes.work_precision_points import Point, Verified
from gearblocks.errors import ParameterError, UnknownNameError, by_name_only, did_you_mean
from gearblocks.files import as_path, write_text
from gearblocks.pages import small_table
from gearblocks.plurals import singular

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

_DIGITS = 6  # further digits, at most, that the price of one is told from


@final
@dataclass(frozen=True, slots=True, eq=False)
class Choice:
    """The cheapest way to an accuracy: how a run is made and how many (members), errors, and what all of them are predicted to
    cost."""

    effort: Effort
    members: int
    errors: Array
    rhs_calls: float
    seconds: float

    def __str__(self) -> str:
        many = f"{self.members} runs with " if self.members > 1 else ""
        return f"{many}{self.effort}: {self.rhs_calls:,.0f} right-hand sides, {1e3 * self.seconds:.3g} ms"


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class WorkPrecision:
    """What accuracy costs in a scene. points: all runs; verified: the run of another method beside the reference (None: there
    is none); after: right-hand sides of a window as long that follows, relative to those of the window, by method and whether
    events are located, of those that `cheapest` chooses (NaN: the run does not come to its end); quantities_cost: CPU seconds
    that measuring the quantities takes besides the cheapest run.

    print() shows sentences and table, .plot(path) draws it, .to_csv(path) writes it, .cheapest(within) chooses.
    """

    scene: Scene
    reference: Reference
    verified: Verified | None
    points: tuple[Point, ...]
    after: Mapping[tuple[str, bool], float] = field(default_factory=dict)
    quantities_cost: float = 0.0

    @property
    def scattered(self) -> bool:
        """Whether no single run answers, so that errors are those of means over runs."""
        return self.reference.scattered

    def cheapest(
        self, within: float | None = None, *, quantity: str | None = None, t_end: float | None = None
    ) -> Choice:
        """The cheapest run whose errors are at most `within` (default: that of the scene), as are those of all tighter ones of
        its method, of one quantity or of all. t_end: for a window that ends there [s], by what the window that follows costs,
        in which its method was run; where that one does not come to its end there, another method is chosen.

        Raises ParameterError where no run is as accurate, or none that is goes on after the window.
        """
        which = self._number(quantity)
        asked = self.scene.within if within is None else within
        more = 0.0 if t_end is None else (t_end - self.scene.end) / (self.scene.end - self.scene.begin)
        found = self.cheapest_or_none(asked, which, lasting=more > 0)
        if found is None:
            none = self.cheapest_or_none(asked, which) is None
            raise ParameterError(self._none(asked, which) if none else self._none_after(t_end))
        times = 1.0 + (self._after(found, t_end) if more > 0 else 1.0) * more
        members = found.needed(asked, which)
        times *= members
        stats = found.stats
        return Choice(found.effort, members, found.errors, times * stats.rhs_calls, times * stats.cpu_seconds)

    def cheapest_or_none(
        self, within: float | None = None, which: slice = slice(None), lasting: bool = False
    ) -> Point | None:
        """The point that `cheapest` chooses; None where no run is as accurate. lasting: of methods that are not known to stop
        in the window that follows."""
        asked = self.scene.within if within is None else within
        sure: list[Point] = []
        for line in self.lines():
            if lasting and math.isnan(self.after.get(line[0].line, 0.0)):
                continue
            for point in reversed(line):
                if not point.within(asked, which):
                    break
                sure.append(point)
        return min(sure, key=lambda point: point.needed(asked, which) * point.stats.cpu_seconds, default=None)

    def _after(self, point: Point, t_end: float | None) -> float:
        after = self.after.get(point.line)
        if after is None:
            wanted = _share(self.scene.within)
            raise ParameterError(
                f"t_end = {t_end:g} s cannot be priced: it is for what is within the {wanted} of the scene; "
                f"ask for within <= {wanted}"
            )
        return after

    def _none_after(self, t_end: float | None) -> str:
        return f"t_end = {t_end:g} s cannot be priced: after {self.scene.end:g} s, no run as accurate comes to its end"

    def offered(self) -> list[Point]:
        """The loosest point of each line that `cheapest` chooses from, for any accuracy up to that of the scene."""
        found: dict[tuple[str, bool], Point] = {}
        for point in self.chosen():
            found.setdefault(point.line, point)
        return [*found.values()]

    def chosen(self) -> list[Point]:
        """The points that `cheapest` chooses, for any accuracy up to that of the scene, loosest first."""
        found: dict[Point, None] = {}
        for which in (slice(None), *(slice(i, i + 1) for i in range(len(self.scene.names)))):
            known = {float((p.errors[which] + p.noise[which]).max()) for p in self.points}
            for asked in sorted({self.scene.within, *(x for x in known if x <= self.scene.within)}, reverse=True):
                for lasting in (False, True):
                    point = self.cheapest_or_none(asked, which, lasting)
                    if point is not None:
                        found[point] = None
        return [*found]

    def _none(self, asked: float, which: slice) -> str:
        known = [float((p.errors[which] + p.noise[which]).max()) for p in self.points if not p.failure]
        none = "none came to its end" if self.points else "the reference alone took the budget"
        best = f"the best is known to {_share(min(known))}" if known else none
        return f"no run is within {_share(asked)} of {', '.join(self.scene.names[which])}: {best}"

    def lines(self) -> list[list[Point]]:
        """Points by method and whether events are located, from loose to tight."""
        found: dict[tuple[str, bool], list[Point]] = {}
        for point in self.points:
            found.setdefault(point.line, []).append(point)
        return [*found.values()]

    def _number(self, quantity: str | None) -> slice:
        names = self.scene.names
        if quantity is None:
            return slice(None)
        if quantity not in names:
            near = did_you_mean(quantity, names)
            raise UnknownNameError(f"the scene asks for {', '.join(names)}, not for '{quantity}'{near}")
        i = names.index(quantity)
        return slice(i, i + 1)

    # -- words --------------------------------------------------------------------------------------------------------

    @property
    def sentence(self) -> str:
        """What the wanted accuracy of each quantity costs, what a further digit costs, and how far that holds."""
        return "\n".join(self._sentence(i, name) for i, name in enumerate(self.scene.names))

    def _sentence(self, i: int, name: str) -> str:
        wanted, which = self.scene.within, slice(i, i + 1)
        of = f"the mean of {name}" if self.scattered else name
        best = self.cheapest_or_none(wanted, which)
        if best is None:
            words = self._none(wanted, which)
            return f"{words[0].upper()}{words[1:]}."
        runs = best.needed(wanted, which)
        costs = f"{_share(wanted)} of {name if runs == 1 else of} costs {_price(best, runs)} with {_words(best.effort)}"
        if best.scatter is not None and runs == 1:
            return f"{costs}; the motion scatters, but this quantity of single runs by {_share(float(best.scatter[i]))} only."
        if self.scattered:
            return f"{costs}; the motion scatters, so that no single run answers."
        further = [self.cheapest_or_none(wanted * 10.0**-k, which) for k in range(1, _DIGITS + 1)]
        reached = [(k, p) for k, p in enumerate(further, 1) if p is not None]
        if not reached:
            return (
                f"{costs}; a further digit is not to be had: the reference is known to {_share(float(best.noise[i]))}."
            )
        digits, last = reached[-1]
        price = (last.seconds / best.seconds) ** (1 / digits)
        return f"{costs}; each further digit costs x {price:.2g}, down to {_share(wanted * 10.0**-digits)}."

    def _table(self) -> list[tuple[str, ...]]:
        of = "error of the mean of" if self.scattered else "error of"
        rows = [("method", *(f"{of} {name}" for name in self.scene.names), "right-hand sides", "CPU ms")]
        for p in self.points:
            if p.failure:
                rows.append((str(p.effort), *("-" for _ in p.errors), "-", "stopped"))
            else:
                shown = (f"{x:.1e}" for x in p.errors)
                rows.append((str(p.effort), *shown, f"{p.rhs_calls:,}", f"{1e3 * p.seconds:.3g}"))
        return rows

    @property
    def notes(self) -> list[str]:
        """How the reference was made and verified, and what the quantities cost."""
        told = (f"{n} = {x:.9g}" for n, x in zip(self.scene.names, self.reference.values, strict=True))
        values = ", ".join(self.scene.with_units(told))
        notes = [f"Reference: {values}, {self._made()}, to {self.reference.noise.max():.0e}"]
        if self.verified is not None:
            notes.append(f"{self.verified.effort} differs from it by {self.verified.errors.max():.0e}")
        if self.points:
            notes.append(f"Measuring the quantities costs {1e3 * self.quantities_cost:.2g} ms besides the run")
        return notes

    def _made(self) -> str:
        one = f"by {self.reference.effort}"
        return f"the means of {self.reference.members} runs {one}" if self.scattered else one

    def __str__(self) -> str:
        rows = self._table()
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join([f"{row[0]:<{widths[0]}}", *(f"{x:>{w}}" for x, w in zip(row[1:], widths[1:], strict=True))])
            for row in rows
        ]
        return "\n".join([str(self.scene), *lines, *self.notes, self.sentence])

    def __repr__(self) -> str:
        return singular(
            f"<WorkPrecision of {self.scene.name}: {len(self.points)} runs; {self.sentence.splitlines()[0]}>"
        )

    def _repr_html_(self) -> str:
        head, *rows = self._table()
        return small_table(
            str(self.scene),
            rows,
            head=head,
            numbers=tuple(range(1, len(head))),
            notes=[*self.notes, *self.sentence.splitlines()],
        )

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """CPU time against the error of each quantity; saved to `path` where given."""
        from gearblocks.analysis.scenes.work_precision_picture import picture

        return picture(self, path)

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """All runs, a line each."""
        head = ["method", "rtol", "step", "located", *(f'"error of {name}"' for name in self.scene.names)]
        rows = [",".join([*head, "members", "rhs_calls", "steps", "events", "cpu_seconds"])]
        for p in self.points:
            e, s = p.effort, p.stats
            asked = [e.method, "" if e.step else repr(e.rtol), repr(e.step) if e.step else "", str(int(e.locate))]
            shown = [repr(float(x)) for x in p.errors]
            rows.append(
                ",".join([*asked, *shown, *map(str, (p.members, s.rhs_calls, s.steps, s.events)), repr(s.cpu_seconds)])
            )
        write_text(as_path(path), "\n".join([*rows, ""]))
        return Path(path)


def _share(x: float) -> str:
    """A share in words: "1 %", or "1e-05" where it is small."""
    return f"{100 * x:.2g} %" if 1e-4 <= x < 10 else f"{x:.0e}"


def _price(point: Point, members: int) -> str:
    one = f"{1e3 * point.stats.cpu_seconds:.2g} ms"
    return f"{f'{members} runs of ' if members > 1 else ''}{one} ({members * point.stats.rhs_calls:,} right-hand sides)"


def _words(effort: Effort) -> str:
    asked = f"steps of {effort.step:g} s" if effort.step is not None else f"rtol {effort.rtol:g}"
    return f"{effort.method} at {asked}" + ("" if effort.locate else ", events not located")
