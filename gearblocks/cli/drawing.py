"""The command that draws a train."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gearblocks.cli.terminal import say
from gearblocks.cli.trains import Change, Train, Without, named


def draw(
    train: Train,
    out: Annotated[Path, typer.Option("-o", "--out", help="The picture to write: .svg.")],
    change: Change = None,
    without: Without = None,
    values: Annotated[bool, typer.Option("--values", help="Print values beside the symbols.")] = False,
) -> None:
    """Draw a train as a kinematic scheme."""
    from gearblocks.drawing.drawing import check_ending

    check_ending(out)  # before the train is made
    named(train, change, without).draw(out, values=values)
    say(f"wrote {out}")
