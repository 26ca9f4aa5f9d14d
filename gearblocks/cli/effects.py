"""The command that prices the effects of a scene, and tells what it calls for."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gearblocks.cli.terminal import say
from gearblocks.cli.trains import SceneName, Within, scene_named
from gearblocks.files import check_place


def effects(
    scene: SceneName,
    within: Within = None,
    fit: Annotated[bool, typer.Option(help="Look for the cheapest train, too.")] = True,
    out: Annotated[Path | None, typer.Option(help="Store the fitted train: .json.")] = None,
) -> None:
    """Price each effect in a scene: what it costs and changes; then the cheapest train that is accurate enough."""
    if out is not None:
        check_place("--out", out)
    asked = scene_named(scene, within)
    from gearblocks.analysis.scenes.fit import fitted
    from gearblocks.analysis.scenes.price import priced
    from gearblocks.analysis.scenes.trials import Trials

    trials = Trials(asked)
    prices = priced(trials)
    say(str(prices))
    if not prices.complete:
        raise KeyboardInterrupt
    if not fit:
        return
    best = fitted(trials, prices)
    say("")
    say(best.evidence)
    say(best.sentence)
    if out is not None:
        best.drivetrain.to_json(out)
        say(f"wrote {out}")
