"""What a run says about effects that were left out of its train: which of them would have acted, how often, and when first;
and about tables that it left."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, final, overload

from gearblocks.pages import small_table
from gearblocks.plurals import singular


class WatchedEffect(NamedTuple):
    """An effect that was left out, the output that shows whether it would have acted, how often it did, when first [s] (NaN:
    never), the least and the largest value of the output [its unit], and what it means."""

    effect: str
    output: str
    times: int
    first: float
    low: float
    high: float
    words: str

    def __str__(self) -> str:
        if not self.times:
            return f"{self.effect}: never ({self.output} from {self.low:.4g} to {self.high:.4g})"
        times = "once" if self.times == 1 else f"{self.times} times, first"
        span = f"({self.output} from {self.low:.4g} to {self.high:.4g})"
        return f"{self.effect}: {times} at {self.first:.6g} s {self.words} {span}"


@final
@dataclass(frozen=True, repr=False)
class Watched(Sequence[WatchedEffect]):
    """What a run watched of effects that were left out. unwatched: those that nothing shows. tables: rows of the same form for
    tables that are held beyond their last point, by the field that they stand in."""

    rows: tuple[WatchedEffect, ...] = ()
    unwatched: tuple[str, ...] = ()
    tables: tuple[WatchedEffect, ...] = ()

    @overload
    def __getitem__(self, at: int) -> WatchedEffect: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[WatchedEffect, ...]: ...
    def __getitem__(self, at: int | slice) -> WatchedEffect | tuple[WatchedEffect, ...]:
        return self.rows[at]

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def active(self) -> tuple[WatchedEffect, ...]:
        """Those that would have acted."""
        return tuple(row for row in self.rows if row.times)

    def __str__(self) -> str:
        lines = [str(row) for row in (*self.rows, *self.tables)] or ["nothing that was left out was watched"]
        return "\n".join([*lines, *([f"not watched: {', '.join(self.unwatched)}"] * bool(self.unwatched))])

    def __repr__(self) -> str:
        return singular(f"<Watched: {len(self.rows)} outputs, {len(self.active)} of them active>")

    def _repr_html_(self) -> str:
        rows = [
            (x.effect, x.output, f"{x.times:,}", f"{x.first:.6g} s" if x.times else "", f"{x.low:.4g} .. {x.high:.4g}", x.words)
            for x in (*self.rows, *self.tables)
        ]  # fmt: skip
        head = ("effect left out, or table", "output", "times", "first", "range", "what it means")
        notes = [f"not watched: {', '.join(self.unwatched)}"] if self.unwatched else ()
        return small_table("Effects left out", rows, head=head, numbers=(2, 3), notes=notes)

    def warning(self) -> str:
        """What would have acted and which tables were left, in one sentence for each; "" where nothing is to be said."""
        found: dict[str, list[WatchedEffect]] = {}
        for row in self.active:
            found.setdefault(row.effect, []).append(row)
        left = (_left(row) for row in self.tables if row.times)
        return "; ".join([*(_sentence(effect, rows) for effect, rows in found.items()), *left])


def _left(row: WatchedEffect) -> str:
    far = max(row.high, -row.low)
    rows = row.effect.endswith(".loss_table")
    way = "draw its last row on" if rows else "give it points there, or extrapolate='linear'"
    return f"the table of '{row.effect}' is left first at {row.first:.6g} s, up to {far:.4g} ({row.output}): {row.words}; {way}"


def _sentence(effect: str, rows: Sequence[WatchedEffect]) -> str:
    first, count = min(rows, key=lambda row: row.first), sum(row.times for row in rows)
    others = len({row.output for row in rows}) - 1
    where = first.output + (f" and {others} more" if others else "")
    times = "once" if count == 1 else f"{count} times, first"
    return f"'{effect}' was left out and would have acted {times} at {first.first:.6g} s: {first.words} ({where})"


NOTHING = Watched()
"""What a run has watched of whose train nothing was left out."""
