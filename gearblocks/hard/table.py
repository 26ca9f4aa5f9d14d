"""The table of the hard cases, printed row by row as they end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gearblocks.hard.suite import Case, Outcome, judge

if TYPE_CHECKING:
    from rich.console import Console, Group

SOLVERS = ("RK45", "Radau", "LSODA")
WIDTH = 80
"""Columns where the output is no terminal; the figures fit, longer texts are wrapped."""
INDENT = 5


def run(cases: Sequence[Case]) -> bool:
    """Judges the cases and prints a row for each; whether all passed. What was printed stays when it is stopped.

    A terminal shows below which case is at work.
    """
    from rich.console import Console

    console = Console(highlight=False)
    if not console.is_terminal:
        console = Console(highlight=False, width=WIDTH)
    done: list[Outcome] = []
    try:
        for case in cases:
            with console.status(f"{case.id}, {len(done) + 1} of {len(cases)}: {_plain(case.title)}"):
                done.append(judge(case))
            console.print(_row(done[-1], first=len(done) == 1))
    finally:
        _total(console, done)
    return all(outcome.passed for outcome in done)


def _row(outcome: Outcome, *, first: bool) -> Group:
    """Figures in columns of the same widths in all rows, and under them what is promised and what was measured."""
    from rich.console import Group
    from rich.padding import Padding
    from rich.table import Column, Table

    names = ("case", "", "steps", "CPU s", "of it runs", *SOLVERS)
    widths = (4, 4, 10, 7, 10, 9, 9, 9)
    columns = [
        Column(name, width=width, justify="right" if i > 1 else "left", overflow="fold")
        for i, (name, width) in enumerate(zip(names, widths, strict=True))
    ]
    table = Table(*columns, box=None, show_header=first, padding=(0, 1, 0, 0))
    case = outcome.case
    figures = (f"{outcome.steps:,}", f"{outcome.seconds:.2f}", f"{outcome.solver_seconds:.3f}")
    verdict = "[green]pass[/]" if outcome.passed else "[red]FAIL[/]"
    table.add_row(case.id, verdict, *figures, *(_attempt(case, solver) for solver in SOLVERS))
    texts = (f"{_plain(case.title)}: {_plain(case.promise)}", f"measured: {_plain(outcome.measured)}")
    return Group(table, *(Padding(text, (0, 0, 0, INDENT)) for text in texts))


def _attempt(case: Case, solver: str) -> str:
    """How a solver of scipy fared, and its seconds."""
    tried = case.scipy.get(solver)
    return "-" if tried is None else f"{'pass' if tried.ok else 'fail'} {tried.seconds:.3g}"


def _plain(text: str) -> str:
    """Text in which square brackets are brackets."""
    from rich.markup import escape

    return escape(text)


def _total(console: Console, done: list[Outcome]) -> None:
    passed, seconds = sum(outcome.passed for outcome in done), sum(outcome.seconds for outcome in done)
    console.print(f"{passed} of {len(done)} passed in {seconds:.1f} s of CPU time")
