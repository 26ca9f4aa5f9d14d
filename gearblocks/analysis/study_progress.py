"""Progress of a study: on a terminal a bar with points done, points per second and time left; elsewhere words now and then."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from gearblocks.progress import Progress

_PATIENCE = 1.0  # seconds before anything is shown


@contextmanager
def progress(
    total: int, done: int, tell: Callable[[int, int], Any] | None, what: str = "study", items: str = "points"
) -> Iterator[Callable[..., None]]:
    """A function that takes how many points are done, and words about them if there are; tell(done, total) is called instead
    where it is given. what, items: words for a study and its points."""
    if tell is not None:
        yield lambda count, _="": tell(count, total)
    elif total < 2:
        yield lambda _count, _="": None
    elif not sys.stderr.isatty():
        said = Progress(what)
        try:
            yield lambda count, found="": said(
                (count - done) / (total - done), f"{count} of {total} {items}{': ' * bool(found)}{found}"
            )
        finally:
            said.close()
    else:
        with _bar(total, done, items) as show:
            yield show


@contextmanager
def _bar(total: int, before: int, items: str) -> Iterator[Callable[..., None]]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    words = TextColumn("{task.fields[rate]}")
    bar = Progress(
        BarColumn(), MofNCompleteColumn(), TextColumn(items), words, TimeRemainingColumn(), TextColumn("left"),
        console=Console(stderr=True), transient=True,
    )  # fmt: skip
    task = bar.add_task("", total=total, completed=before, rate="")
    began = time.monotonic()

    def show(done: int, found: str = "") -> None:
        spent = time.monotonic() - began
        if spent > _PATIENCE and not bar.live.is_started:
            bar.start()
        bar.update(task, completed=done, rate=f"{(done - before) / max(spent, 1e-9):.3g} {items}/s  {found}")

    try:
        yield show
    finally:
        bar.stop()
