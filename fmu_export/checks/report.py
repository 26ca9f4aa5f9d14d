"""What check() found, as a table for people and as plain values."""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path

from gearblocks.language.tidy import Tidy
from gearblocks.plurals import singular


@dataclass(frozen=True, slots=True)
class Item(metaclass=Tidy):
    """One check. ok is None where it could not be made here; `words` says what was seen."""

    name: str
    ok: bool | None
    words: str


@dataclass(frozen=True, slots=True)
class Report(metaclass=Tidy):
    """All checks of one FMU. differences: (output, largest difference from the run in-process over its peak)."""

    path: Path
    items: tuple[Item, ...]
    differences: tuple[tuple[str, float], ...] = ()

    @property
    def ok(self) -> bool:
        """True when no check failed."""
        return all(item.ok is not False for item in self.items)

    def __str__(self) -> str:
        width = max((len(item.name) for item in self.items), default=0)
        lines = [f"{self.path.name}: {'passed' if self.ok else 'FAILED'}"]
        lines += [f"  {_mark(item):<6}  {item.name:<{width}}  {singular(item.words)}" for item in self.items]
        return "\n".join(lines)

    def to_html(self) -> str:
        """An HTML fragment: one table."""
        rows = "\n".join(
            f'<tr class="{_mark(item)}"><td>{_mark(item)}</td><td>{html.escape(item.name)}</td>'
            f"<td>{html.escape(singular(item.words))}</td></tr>"
            for item in self.items
        )
        return f'<table style="text-align: left"><tr><th></th><th>check</th><th>seen</th></tr>\n{rows}\n</table>'

    def _repr_html_(self) -> str:
        return self.to_html()


def _mark(item: Item) -> str:
    return "-" if item.ok is None else "ok" if item.ok else "FAIL"
