"""What a run says about its steps: what limited them, by component and by count, and what would help."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

from gearblocks.pages import small_table
from gearblocks.plurals import singular

_SHOWN = 8
"""Rows that are printed."""


class Limit(NamedTuple):
    """What limited steps: the cause, the component (the element that moves the state, or the owner of the switch; "" where it
    is none), accepted steps, refused trials, events, and words."""

    cause: str
    component: str
    steps: int
    rejected: int
    events: int
    words: str


@final
@dataclass(frozen=True, repr=False)
class RunExplanation:
    """What limited the steps of a run, most first. remedies: what would help."""

    name: str
    method: str
    rows: tuple[Limit, ...]
    remedies: tuple[str, ...]

    @property
    def steps(self) -> int:
        """Accepted steps."""
        return sum(row.steps for row in self.rows)

    @property
    def rejected(self) -> int:
        """Refused trials."""
        return sum(row.rejected for row in self.rows)

    @property
    def limiting(self) -> str:
        """The component that limited most steps and trials."""
        return next((row.component for row in self.rows if row.component and row.steps + row.rejected), "")

    @property
    def switching(self) -> str:
        """The component with most events; "" without events."""
        return max((row for row in self.rows if row.events), key=lambda row: row.events, default=_NOBODY).component

    def sentences(self) -> list[str]:
        """What there is to say."""
        total = max(self.steps + self.rejected, 1)
        events = sum(row.events for row in self.rows)
        found = [
            singular(
                f"'{self.name}' took {self.steps} steps and {self.rejected} refused trials ({self.method}), {events} events."
            )
        ]
        first = self.rows[0] if self.rows else None
        if first is not None and first.steps + first.rejected:
            named = f"'{first.component}'"
            where = f" ({named})" if first.component and named not in first.words else ""
            found.append(f"{100 * (first.steps + first.rejected) / total:.0f} % of them: {first.words}{where}.")
        if self.switching:
            most = next(row for row in self.rows if row.component == self.switching and row.events)
            found.append(f"{100 * most.events / events:.0f} % of the events are of '{most.component}'.")
        found += [f"What would help: {'; '.join(self.remedies)}."] * bool(self.remedies)
        return found

    def _table(self) -> list[tuple[str, ...]]:
        def shown(number: int) -> str:
            return f"{number:,}" if number else ""

        return [(x.component, shown(x.steps), shown(x.rejected), shown(x.events), x.words) for x in self.rows]

    def __str__(self) -> str:
        head = ("component", "steps", "refused", "events", "limited by")
        rows = [head, *self._table()[:_SHOWN]]
        widths = [max(len(row[i]) for row in rows) for i in range(4)]
        lines = [
            f"  {row[0]:<{widths[0]}}  {row[1]:>{widths[1]}}  {row[2]:>{widths[2]}}  {row[3]:>{widths[3]}}  {row[4]}".rstrip()
            for row in rows
        ]
        return "\n".join([*self.sentences(), *lines])

    def __repr__(self) -> str:
        return f"<explanation of a run of '{self.name}': limited by '{self.limiting}', switched by '{self.switching}'>"

    def _repr_html_(self) -> str:
        head = ("component", "steps", "refused", "events", "limited by")
        title = f"What limited the run of '{self.name}'"
        return small_table(title, self._table(), head=head, numbers=(1, 2, 3), notes=self.sentences())


_NOBODY = Limit("", "", 0, 0, 0, "")
