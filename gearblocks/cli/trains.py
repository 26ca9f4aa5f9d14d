"""Options of every command that takes a train: FILE[:NAME], --set and --without, and the train they mean."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from gearblocks.errors import ParameterError

if TYPE_CHECKING:
    from gearblocks.drivetrain import Drivetrain
    from gearblocks.solver.library import Model

Train = Annotated[str, typer.Argument(metavar="FILE[:NAME]", help="A script or shipped model; NAME: a function in it.")]
Change = Annotated[list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="A parameter; repeatable.")]
Without = Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave effects out; repeatable.")]


def number(text: str | float) -> float:
    """A number of an option."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"'{text}' is no number; give one such as 0.5 or 1e-6") from None


def seconds(text: str | float) -> float:
    """A time of an option, in s or with its unit."""
    from gearblocks.language.units import is_quantity, number_in_si

    try:
        return number_in_si("the time", text, "s") if isinstance(text, str) and is_quantity(text) else number(text)
    except ParameterError as error:
        raise typer.BadParameter(str(error)) from None


Rtol = Annotated[float, typer.Option(parser=number, metavar="NUMBER", help="Relative tolerance.")]
Method = Annotated[str, typer.Option(help="auto, rk4, dp5, dp8 or rodas.")]
Step = Annotated[float | None, typer.Option(parser=seconds, metavar="TIME", help="Fixed step in s.")]
End = Annotated[float, typer.Option(parser=seconds, metavar="TIME", help="End of a run in s, or such as 20ms.")]
Initial = Annotated[str | None, typer.Option(help="static or static_at_start.")]


def named(text: str, change: Sequence[str] | None = None, without: Sequence[str] | None = None) -> Drivetrain:
    """The train that FILE[:NAME] means, without the effects that were left out and with the values that were set."""
    from gearblocks.cli import scripts

    changes = assigned(change)
    rig = scripts.make(text)
    rig = rig.without(*without) if without else rig
    return rig.set(changes) if changes else rig


def built(
    text: str, change: Sequence[str] | None, without: Sequence[str] | None
) -> tuple[Model, dict[str, float | str]]:
    """The model with what is structural changed, and the rest of the changes, which need no other model."""
    from gearblocks.running import build

    changes = assigned(change)
    rig = named(text, (), without)
    model = build(rig)
    structural = {path for path, _ in model.program.structural}
    tunable = [one.path for one in model.program.parameters if one.path not in structural]
    tuned = {
        path: value
        for path, value in changes.items()
        if path in tunable or sum(name.endswith("." + path) for name in tunable) == 1
    }
    rest = {path: value for path, value in changes.items() if path not in tuned}
    return (build(rig.set(rest)) if rest else model), tuned


def assigned(texts: Sequence[str] | None) -> dict[str, float | str]:
    """Values by path of options such as mesh.k=1.5e8 or mesh.k=150MN/m."""
    return dict(_assignment(text) for text in texts or ())


def _assignment(text: str) -> tuple[str, float | str]:
    from gearblocks.language.units import is_quantity

    path, equals, value = text.partition("=")
    try:
        if equals and path.strip():
            return path.strip(), value if is_quantity(value) else float(value)
    except ValueError:
        pass
    raise ParameterError(
        f"--set {text}: what is asked for is path=number, for example --set mesh.k=1.5e8 or --set mesh.k=150MN/m"
    )
