"""Options of every command that takes a train or a scene: FILE[:NAME], --set and --without, and what they mean."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from gearblocks.errors import ParameterError, did_you_mean

if TYPE_CHECKING:
    from gearblocks.analysis.scenes.scene import Scene
    from gearblocks.drivetrain import Drivetrain
    from gearblocks.solver.library import Model

Train = Annotated[str, typer.Argument(metavar="FILE[:NAME]", help="A script or shipped model; NAME: a function in it.")]
Change = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="PATH=VALUE", help="A parameter; repeatable. `gearblocks parameters` lists them."),
]
Without = Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave effects out; repeatable.")]


def number(text: str | float) -> float:
    """A number of an option."""
    try:
        return float(text)
    except ValueError:
        raise typer.BadParameter(f"'{text}' is no number; give one such as 0.5 or 1e-6") from None


def threads(text: str | int) -> int:
    """The number of threads of an option."""
    try:
        if int(text) >= 1:
            return int(text)
    except ValueError:
        pass
    raise typer.BadParameter(f"{text} must be a whole number >= 1; without --jobs all cores work")


SceneName = Annotated[
    str, typer.Argument(metavar="FILE[:NAME]", help="A script or shipped model; NAME: a scene in it.")
]
Within = Annotated[
    float | None, typer.Option(parser=number, metavar="SHARE", help="Accuracy wanted; else that of the scene.")
]


def scene_named(text: str, within: float | None) -> Scene:
    """The scene that FILE[:NAME] means, with the accuracy that is wanted."""
    from gearblocks.cli import scripts

    found = scripts.scene(text)
    return found if within is None else found.changed(within=within)


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
End = Annotated[
    float | None, typer.Option(parser=seconds, metavar="TIME", help="End of a run in s, or such as 20ms; else 1 s.")
]
Initial = Annotated[str | None, typer.Option(help="rolling, static or static_at_start.")]


def named(text: str, change: Sequence[str] | None = None, without: Sequence[str] | None = None) -> Drivetrain:
    """The train that FILE[:NAME] means, without the effects that were left out and with the values that were set."""
    return asked(text, change, without)[0]


def asked(
    text: str, change: Sequence[str] | None = None, without: Sequence[str] | None = None
) -> tuple[Drivetrain, Scene | None]:
    """The same, and the scene that it was made for, of the train as it is then."""
    from gearblocks.cli import scripts
    from gearblocks.drivetrain import Drivetrain

    changes = assigned(change)
    thing = scripts.made(text)
    rig = thing if isinstance(thing, Drivetrain) else thing.drivetrain
    rig = rig.without(*without) if without else rig
    rig = rig.set(changes) if changes else rig
    return rig, None if isinstance(thing, Drivetrain) else thing.changed(drivetrain=rig)


class Built(NamedTuple):
    """A model with what is structural changed; the rest of the changes, which need no other model; the scene, if one was
    named."""

    model: Model
    tuned: dict[str, float | str]
    scene: Scene | None

    def arguments(self, t_end: float | None, initial: str | None) -> dict[str, Any]:
        """The drive of a run: that of the scene, where one was named, with what is given here."""
        from gearblocks.language.starts import ROLLING
        from gearblocks.simulation.arguments import STATIC

        scene = self.scene
        if initial is not None and initial not in (*STATIC, ROLLING):
            kinds = (ROLLING, *STATIC)
            raise ParameterError(
                f"--initial {initial}: must be one of {', '.join(kinds)}{did_you_mean(initial, kinds)}; a start value is set, "
                "such as --set motor.w0=300rpm"
            )
        if scene is None:
            return {"t_end": 1.0 if t_end is None else t_end, "initial": initial, "parameters": self.tuned}
        return {
            "t_start": scene.begin, "t_end": scene.end if t_end is None else t_end, "inputs": dict(scene.inputs),
            "initial": scene.initial if initial is None else initial, "parameters": {**scene.parameters, **self.tuned},
        }  # fmt: skip


def built(text: str, change: Sequence[str] | None, without: Sequence[str] | None) -> Built:
    """The model that FILE[:NAME] means, and what it is run with."""
    from gearblocks.running import build

    changes = assigned(change)
    rig, scene = asked(text, (), without)
    model = build(rig)
    structural = {path for path, _ in model.program.structural}
    tunable = [one.path for one in model.program.parameters if one.path not in structural]
    tuned = {
        path: value
        for path, value in changes.items()
        if path in tunable or sum(name.endswith("." + path) for name in tunable) == 1
    }
    rest = {path: value for path, value in changes.items() if path not in tuned}
    rig.set(
        {path: value for path, value in tuned.items() if path in rig.field_paths()}
    )  # warns of what is hardly meant
    return Built(build(rig.set(rest)) if rest else model, tuned, scene)


def unit_apart(arguments: Sequence[str]) -> str:
    """What is wrong where a value and its unit stand apart, as in --t-end 10 ms; else empty."""
    for option, value, unit in zip(arguments, arguments[1:], arguments[2:], strict=False):
        number = value.rpartition("=")[2]
        if option.startswith("--") and not unit.startswith("-") and not Path(unit).exists():
            from gearblocks.language.units import parse_unit

            try:
                float(number)
                parse_unit(unit)
            except (ValueError, ParameterError):
                continue
            return f"{option} {value} {unit}: a value and its unit stand together: {option} {value}{unit}"
    return ""


def given_twice(arguments: Sequence[str], app: typer.Typer) -> str:
    """What is wrong where an option stands twice of which the last one alone would count; else empty."""
    options = [x.partition("=")[0] for x in arguments if x.startswith("-") and x[1:2] in "-o"]
    repeated = [x for i, x in enumerate(options) if x in options[:i]]
    if not repeated:
        return ""
    command = getattr(typer.main.get_command(app), "commands", {}).get(arguments[0])
    once = (
        {name for one in command.params if not getattr(one, "multiple", False) for name in one.opts} if command else ()
    )
    return next((f"{x} is given twice; leave one of them out" for x in repeated if x in once), "")


def assigned(texts: Sequence[str] | None) -> dict[str, float | str]:
    """Values by path of options such as mesh.k=1.5e8 or mesh.k=150MN/m."""
    pairs = [_assignment(text) for text in texts or ()]
    if twice := [path for i, (path, _) in enumerate(pairs) if path in dict(pairs[:i])]:
        given = " and ".join(f"{path}={value}" for path, value in pairs if path == twice[0])
        raise ParameterError(f"--set {twice[0]} is given twice, {given}; leave one of them out")
    return dict(pairs)


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
