"""What the effects of a scene cost and change, as a table and in sentences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from gearblocks.analysis.scenes.scatter import Estimate
from gearblocks.analysis.scenes.scene import Scene
from gearblocks.analysis.scenes.trials import Judgement, Trial, Verdict, percent, relative_cost, work_of
from gearblocks.errors import UnknownNameError, did_you_mean
from gearblocks.pages import small_table
from gearblocks.plurals import singular
from gearblocks.simulation.records import Stats

GAIN = 0.05
"""Share of work and CPU time below which nothing is gained: timings scatter by as much."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """One effect, or several that are taken away together.

    states, switches: how many fewer there are without. stats: counters of a run without, None where there was none; fastest:
    shortest time constant without [s]; message: why it does not run; together: whether it is a set of other rows.
    """

    name: str
    effects: frozenset[str]
    judgement: Judgement
    states: int
    switches: int
    stats: Stats | None
    fastest: float
    message: str
    together: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class Price:
    """What each effect of a scene costs and changes. rows: effects, elements, and sets that matter together; full: the
    quantities with everything, and their errors; whole: the train with everything; trains, runs: how many were built and
    made; untried: what no train, or no time, was left for; complete: whether Ctrl-C did not end it.
    """

    scene: Scene
    full: Estimate
    whole: Trial
    rows: tuple[Row, ...]
    trains: int
    runs: int
    untried: tuple[str, ...] = ()
    complete: bool = True

    def __getitem__(self, name: str) -> Row:
        """The row of that name. Raises UnknownNameError."""
        for row in self.rows:
            if row.name == name:
                return row
        names = [row.name for row in self.rows]
        raise UnknownNameError(f"there is no row '{name}'; there are {', '.join(names)}{did_you_mean(name, names)}")

    def share(self, row: Row) -> float:
        """Share of the CPU time of the whole train that is saved without; below 0 where it takes longer without."""
        seconds = self.whole.stats.cpu_seconds
        return math.nan if row.stats is None or not seconds > 0 else 1 - row.stats.cpu_seconds / seconds

    def saves(self, row: Row) -> bool:
        """Whether work and CPU time are saved without, beyond what timings scatter by."""
        whole = self.whole
        if row.stats is None or not self.share(row) > GAIN:
            return False
        left = whole.n_states - row.states, whole.n_switches - row.switches
        work = work_of(row.stats, *left) / whole.work
        return relative_cost(work, row.stats.cpu_seconds, whole.stats.cpu_seconds) < 1 - GAIN

    @property
    def sentence(self) -> str:
        """What is needed, what is not, and what would be saved."""
        kinds: dict[Verdict, list[str]] = {}
        for row in self._told():
            kinds.setdefault(row.judgement.verdict, []).append(self._said(row))
        lead = f"{', '.join(self.scene.names)} within {100 * self.scene.within:g} %"
        words = [f"{_HEADS[kind]}: {', '.join(kinds[kind])}" for kind in _HEADS if kind in kinds]
        words += [f"together {row.judgement.verdict}: {self._said(row)}" for row in self.rows if row.together]
        words += [f"not tried: {', '.join(self.untried)}"] if self.untried else []
        words += [] if self.complete else ["stopped before the end: what matters together is not known"]
        return f"{lead}: {'; '.join(words) or 'the train has no effects'}"

    def _told(self) -> list[Row]:
        """Single effects that are needed, and elements that are where none of theirs is by itself; of what is not needed, that
        which no other one contains."""
        rows = [row for row in self.rows if not row.together]

        def told(row: Row) -> bool:
            alike = [o for o in rows if o.judgement.verdict is row.judgement.verdict]
            if row.judgement.verdict is Verdict.needed:
                return not (row.name.endswith(".*") and any(o.effects < row.effects for o in alike))
            return not any(row.effects < o.effects for o in alike)

        return [row for row in rows if told(row)]

    def _said(self, row: Row) -> str:
        share = self.share(row)
        if row.judgement.verdict in (Verdict.no_quantity, Verdict.no_run, Verdict.no_influence):
            return row.name
        change = row.judgement.worst(self.scene.names) + row.judgement.made_of
        if row.judgement.verdict is Verdict.not_needed and not math.isnan(share):
            gain = f"saves {_saved(share)}" if self.saves(row) else "saves nothing"
            return f"{row.name} ({change}, {gain})"
        return f"{row.name} ({change})"

    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head and rows as text."""
        names = self.scene.names
        head = ("taken away", *(names if len(names) > 1 else ("change",)), "verdict", "states", "switches", "events",
                "right-hand sides", "CPU ms", "saved", "fastest")  # fmt: skip
        whole = self.whole
        values = (_value(v, e) for v, e in zip(self.full.values, self.full.errors, strict=True))
        first = ("nothing", *self.scene.with_units(values), "",
                 str(whole.n_states), str(whole.n_switches), *_counts(whole.stats), "", "")  # fmt: skip
        return head, [first, *(self._line(row) for row in self.rows)]

    def _line(self, row: Row) -> tuple[str, ...]:
        found = row.judgement
        changes = [percent(c, e) for c, e in zip(found.changes, found.errors, strict=True)]
        if row.message:
            changes = [""] * len(changes)
        said = found.verdict + found.made_of
        share = self.share(row)
        saved = "" if math.isnan(share) else _saved(share)
        fastest = "" if math.isnan(row.fastest) else f"{row.fastest:.2g} s"
        fewer = ("", "") if row.stats is None else tuple(f"{-n}" for n in (row.states, row.switches))
        return (row.name, *changes, said, *fewer, *_counts(row.stats), saved, fastest)

    def __str__(self) -> str:
        head, rows = self.table()
        widths = [max(len(line[i]) for line in (head, *rows)) for i in range(len(head))]
        lines = [
            "  ".join(text.ljust(w) for text, w in zip(line, widths, strict=True)).rstrip() for line in (head, *rows)
        ]
        told = [f"{row.name}: {row.message}" for row in self.rows if row.message]
        return "\n".join([str(self.scene), *lines, *told, self.sentence])

    def __repr__(self) -> str:
        end = "" if self.complete else ", stopped"
        return singular(
            f"<Price of '{self.scene.name}': {len(self.rows)} rows, {self.trains} trains, {self.runs} runs{end}>"
        )

    def _repr_html_(self) -> str:
        head, rows = self.table()
        verdict = len(self.scene.names) + 1
        numbers = [i for i in range(1, len(head)) if i != verdict]
        return small_table(str(self.scene), rows, head=head, numbers=numbers, notes=[self.sentence])


_HEADS = {
    Verdict.needed: "needed",
    Verdict.undecided: "undecided",
    Verdict.not_needed: "not needed by itself",
    Verdict.no_influence: "without influence",
    Verdict.no_quantity: "part of the quantity",
    Verdict.no_run: "not to be taken away",
}


def _saved(share: float) -> str:
    """A share of the time; never all of it."""
    return f"{math.floor(1e4 * share) / 100:g} %" if share > 0.99 else f"{100 * share:.0f} %"


def _value(value: float, error: float) -> str:
    return f"{value:.6g} +- {error:.1g}" if error > 1e-5 * abs(value) else f"{value:.6g}"


def _counts(stats: Stats | None) -> Sequence[str]:
    if stats is None:
        return ("", "", "")
    return (str(stats.events), str(stats.rhs_calls), f"{1e3 * stats.cpu_seconds:.3g}")
