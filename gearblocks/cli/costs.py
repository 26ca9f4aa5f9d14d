"""The command that tells what accuracy costs in a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gearblocks.cli.terminal import complain, say
from gearblocks.cli.trains import SceneName, Within, number, scene_named
from gearblocks.errors import ParameterError
from gearblocks.files import check_place


def cost(
    scene: SceneName,
    within: Within = None,
    budget: Annotated[
        float, typer.Option(parser=number, metavar="SECONDS", help="CPU time for all runs, about.")
    ] = 60.0,
    plot: Annotated[Path | None, typer.Option(help="Picture: .png, .svg or .pdf.")] = None,
    out: Annotated[Path | None, typer.Option(help="All runs: .csv.")] = None,
) -> None:
    """Tell what accuracy costs in a scene: error and CPU time by method, tolerance, and events located or not."""
    for option, path, endings in (("--out", out, (".csv",)), ("--plot", plot, (".png", ".svg", ".pdf"))):
        if path is not None:
            if path.suffix.lower() not in endings:
                raise ParameterError(f"{option} {path}: the ending must be one of {', '.join(endings)}")
            check_place(option, path)
    asked = scene_named(scene, within)
    from gearblocks.analysis.scenes.work_precision import work_precision

    found = work_precision(asked, budget=budget)
    say(str(found))
    if plot is not None:
        found.plot(plot)
        say(f"wrote {plot}")
    if out is not None:
        found.to_csv(out)
        say(f"wrote {out}")
    if found.cheapest_or_none() is None:
        complain("no way to run it is known to be as accurate as that")
        raise typer.Exit(1)
