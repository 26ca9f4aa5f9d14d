"""What `gearblocks run` prints of a run, and what it refuses to write before it starts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gearblocks.cli.terminal import say
from gearblocks.errors import ParameterError
from gearblocks.files import check_place
from gearblocks.plurals import singular

if TYPE_CHECKING:
    from gearblocks.analysis.scenes.scene import Scene
    from gearblocks.simulation.trajectory import Trajectory

SMOOTH = 4001


def check_endings(out: Path | None, plot: Path | None) -> None:
    """Refuse before the run what could not be written after it."""
    for option, path, endings in (("--out", out, (".csv", ".nc", ".json")), ("--plot", plot, (".png", ".svg", ".pdf"))):
        if path is None:
            continue
        if path.suffix.lower() not in endings:
            raise ParameterError(f"{option} {path}: the ending must be one of {', '.join(endings)}")
        check_place(option, path)


def grid(t_end: float, t_start: float = 0.0) -> Any:
    """Times for a smooth picture: accepted steps of a high order lie too far apart for straight lines between them."""
    import numpy as np

    return np.linspace(t_start, t_end, SMOOTH)


def report(result: Trajectory, shown: Sequence[str]) -> None:
    """Print what the run was, and the range of the outputs named."""
    from gearblocks.train.summary import span_text

    if not len(result.t):
        say(f"{result.name}: no samples")
        return
    say(singular(f"{result.name}: {len(result.t)} samples up to t = {result.t[-1]:.6g} s"))
    say(f"{result.stats}")
    say(f"energy residual {result.energy.residual:.1e} of a turnover of {result.energy.turnover:.4g} J")
    width = max((len(name) for name in shown), default=0)
    for name in shown:
        unit = "" if result.units[name] == "1" else result.units[name]
        say(f"  {name:<{width}}  {span_text(result[name].min(), result[name].max())} {unit}".rstrip())


def answers(result: Trajectory, scene: Scene) -> None:
    """Print the quantities of a scene."""
    from gearblocks.analysis.quantity import Quantity
    from gearblocks.analysis.span import span_of_run

    span = span_of_run(result)
    for name, measure in zip(scene.names, scene.measures, strict=True):
        value = measure.of(result) if isinstance(measure, Quantity) else measure(result)
        unit = measure.unit(span) if isinstance(measure, Quantity) else ""
        say(f"{name} = {value:.6g} {'' if unit == '1' else unit}".rstrip())


def telling(names: Sequence[str]) -> tuple[str, ...]:
    """The outputs that tell most, at most a dozen: deflections and forces of elements, speeds of bodies."""
    kinds = ("deflection", "twist", "force", "torque", "w", "v")
    own = [name for name in names if name.count(".") == 1]
    chosen = [name for kind in kinds for name in own if name.endswith("." + kind)]
    return tuple(chosen[:12]) or tuple(names[:12])
