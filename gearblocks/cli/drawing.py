"""The command that draws a train."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gearblocks.cli.arguments import Train


def draw(
    train: Train,
    out: Annotated[Path, typer.Option("-o", "--out", help="The picture to write: .svg.")],
    values: Annotated[bool, typer.Option("--values", help="Print values beside the symbols.")] = False,
) -> None:
    """Draw a train as a kinematic scheme."""
    from gearblocks.cli import scripts
    from gearblocks.drawing.drawing import check_ending

    check_ending(out)  # before the train is made
    scripts.make(train).draw(out, values=values)
    typer.echo(f"wrote {out}")
