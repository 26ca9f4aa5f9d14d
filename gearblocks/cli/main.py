"""The shell: demo, list, doc, run, sweep, equations, draw, export, check, hard.

Exit status: 0 done; 1 it ran and the answer is no; 2 bad input. Errors are one message on standard error.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gearblocks.cli.arguments import Train
from gearblocks.cli.drawing import draw
from gearblocks.errors import CompileError, GearblocksError, ParameterError, SimulationError

if TYPE_CHECKING:
    from gearblocks.drivetrain import Drivetrain
    from gearblocks.simulation.trajectory import Trajectory
    from gearblocks.solver.library import Model

NO, BAD_INPUT = 1, 2
SMOOTH = 4001

app = typer.Typer(
    help="Drivetrains from blocks: equations of motion, fast runs, FMUs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


class Form(StrEnum):
    """How equations are written."""

    text = "text"
    latex = "latex"
    html = "html"
    c = "c"


@app.command()
def demo(out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("gearblocks-demo")) -> None:
    """The main job on a spline coupling: equations, four speeds, pictures, cost, FMU, check, report."""
    from gearblocks.cli.demo import demo as run_demo

    sound = run_demo(out, say=typer.echo)
    typer.echo(f"open {out / 'index.html'} in a browser")
    if not sound:
        raise typer.Exit(NO)


@app.command("list")
def list_models(file: Annotated[str | None, typer.Argument(metavar="[FILE]", help="A script.")] = None) -> None:
    """Shipped models, or the trains in FILE."""
    from gearblocks.cli import scripts

    if file is None:
        rows = [(name, scripts.first_line(path)) for name, path in scripts.shipped().items()]
    else:
        path, _ = scripts.locate(file)
        rows = [(f"{file}:{maker.name}", maker.words) for maker in scripts.makers(path)]
    width = max((len(name) for name, _ in rows), default=0)
    for name, words in rows:
        typer.echo(f"{name:<{width}}  {words}".rstrip())
    if not rows:
        _say("nothing here makes a train" if file else "no model is shipped")
        raise typer.Exit(NO)


@app.command()
def doc(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="A public name, such as GearMesh.")] = None,
) -> None:
    """Fields, flanges, outputs and an example of a block; without NAME: all blocks, a line each."""
    from gearblocks.cli import block_help

    typer.echo(block_help.listing() if name is None else block_help.page(name))


@app.command()
def run(
    train: Train,
    t_end: Annotated[float, typer.Option(help="End of the run in s.")] = 1.0,
    initial: Annotated[str | None, typer.Option(help="static or static_at_start.")] = None,
    change: Annotated[list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="A parameter.")] = None,
    without: Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave effects out.")] = None,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 1e-6,
    method: Annotated[str, typer.Option(help="auto, rk4, dp5, dp8 or rodas.")] = "auto",
    step: Annotated[float | None, typer.Option(help="Fixed step in s.")] = None,
    outputs: Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="What to record.")] = None,
    out: Annotated[Path | None, typer.Option(help="Store the run: .csv, .nc or .json.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture over time: .png, .svg or .pdf.")] = None,
) -> None:
    """Simulate a train."""
    _check_endings(out, plot)
    changes = dict(_assignment(item) for item in change or [])
    rig = _train(train, without or [])
    from gearblocks.drivetrain import simulate

    model, tuned = _changed(rig, changes)
    options: dict[str, Any] = {"rtol": rtol, "method": method, "step": step, "initial": initial, "parameters": tuned}
    chosen = tuple(outputs) if outputs else "*"
    failure: SimulationError | None = None
    try:
        with _progress() as progress:
            result = simulate(model, t_end=t_end, outputs=chosen, progress=progress, **options)
    except SimulationError as error:
        if error.trajectory is None or not len(error.trajectory.t):
            raise
        result, failure = error.trajectory, error
    shown = result.names if outputs else _telling(result.names)
    _report(result, shown)
    if out is not None:
        result.save(out)
        typer.echo(f"wrote {out}")
    if plot is not None:
        sparse = result.complete and len(result.t) < SMOOTH
        drawn = simulate(model, t=_grid(t_end), outputs=shown, **options) if sparse else result
        drawn.plot(*shown, path=plot)
        typer.echo(f"wrote {plot}")
    if failure is not None:
        raise failure
    if not result.complete:
        _say(f"stopped at t = {result.t[-1]:.6g} s; what was done until then is kept")
        raise typer.Exit(NO)


@app.command()
def sweep(
    train: Train,
    over: Annotated[list[str], typer.Option(metavar="PATH=FROM:TO:N", help="What varies; several make a grid.")],
    of: Annotated[
        list[str] | None, typer.Option(metavar="OUTPUT", help="An output, or peak(OUTPUT), rms(OUTPUT) ...")
    ] = None,
    t_end: Annotated[float, typer.Option(help="End of each run in s.")] = 1.0,
    initial: Annotated[str | None, typer.Option(help="static or static_at_start.")] = None,
    change: Annotated[list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="A parameter.")] = None,
    without: Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="Leave effects out.")] = None,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 1e-6,
    method: Annotated[str, typer.Option(help="auto, rk4, dp5, dp8 or rodas.")] = "auto",
    step: Annotated[float | None, typer.Option(help="Fixed step in s.")] = None,
    out: Annotated[Path | None, typer.Option(help="A folder, or a file: .csv, .nc, .zarr, .png ...")] = None,
    store: Annotated[Path | None, typer.Option(help="A folder (Zarr) from which a stopped sweep goes on.")] = None,
    jobs: Annotated[int | None, typer.Option(help="Threads; without: all cores.")] = None,
) -> None:
    """Run a train over a grid of values, and tell what each run comes to."""
    from gearblocks.cli import studies

    values = studies.grid(over)
    studies.check_place(out)
    rig = _train(train, without or [])
    model, tuned = _changed(rig, dict(_assignment(item) for item in change or []))
    from gearblocks.analysis import parameter_study

    found = parameter_study.sweep(
        model, values, quantity=studies.quantities(model.program, of or (), _telling([*model.program.output_numbers])[:1]),
        t_end=t_end, initial=initial, parameters=tuned, rtol=rtol, method=method, step=step, store=store, threads=jobs,
    )  # fmt: skip
    typer.echo(repr(found)[1:-1])
    for path in studies.written(found, out) if out is not None and found.done.any() else []:
        typer.echo(f"wrote {path}")
    for failure in found.failures[:10]:
        _say(f"{', '.join(f'{path} = {x:.6g}' for path, x in failure.point.items())}: {failure.message}")
    if not found.complete or len(found.failures) == len(found):
        raise typer.Exit(NO)


@app.command()
def equations(
    train: Train, form: Annotated[Form, typer.Option("--format", help="How they are written.")] = Form.text
) -> None:
    """Print the equations of motion."""
    rig = _train(train)
    if form is Form.c:
        from gearblocks.drivetrain import build

        typer.echo(build(rig).program.source)
    elif form is Form.html:
        typer.echo(rig.equations().html(rig._repr_svg_() or ""))
    else:
        eq = rig.equations()
        typer.echo(eq.latex() if form is Form.latex else str(eq))


@app.command()
def export(
    train: Train,
    out: Annotated[Path, typer.Option("-o", "--out", help="The FMU to write.")],
    fmi: Annotated[str, typer.Option(help="Version of the standard.")] = "2.0",
    platform: Annotated[list[str] | None, typer.Option(help="Platform of a binary; repeatable.")] = None,
    rtol: Annotated[float, typer.Option(help="Relative tolerance.")] = 1e-6,
    method: Annotated[str, typer.Option(help="auto, rk4, dp5, dp8 or rodas.")] = "auto",
    step: Annotated[float | None, typer.Option(help="Fixed step in s.")] = None,
) -> None:
    """Write a train as an FMU."""
    rig = _train(train)
    import fmu_export

    path = fmu_export.export(
        rig, out, fmi=fmi, platforms=tuple(platform or ("native",)), rtol=rtol, method=method, step=step
    )
    typer.echo(f"wrote {path} ({path.stat().st_size / 1024:.0f} KiB)")


app.command()(draw)


@app.command()
def check(fmu: Annotated[Path, typer.Argument(metavar="X.fmu", help="The FMU to check.")]) -> None:
    """Check an FMU: validity, a run, comparison with the run in this process."""
    if not fmu.is_file():
        raise ParameterError(f"there is no file '{fmu}'")
    import fmu_export

    report = fmu_export.check(fmu)
    typer.echo(str(report))
    if not report.ok:
        raise typer.Exit(NO)


@app.command()
def hard(
    case: Annotated[
        list[str] | None, typer.Argument(metavar="[CASE]...", help="Names such as H07; without: all.")
    ] = None,
) -> None:
    """The hard-case suite: each case, what is promised, what is measured, what it costs; scipy's solvers beside it."""
    from gearblocks.hard import suite, table

    chosen = suite.cases(case or ())
    try:
        passed = table.run(chosen)
    except KeyboardInterrupt:
        _say("stopped; the rows printed so far stand")
        passed = False
    if not passed:
        raise typer.Exit(NO)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the shell with `arguments` (those of the process where None); the answer is the exit status."""
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: _say(f"warning: {message}")
        try:
            app(args=None if arguments is None else list(arguments), prog_name="gearblocks")
        except SystemExit as stop:
            return stop.code if isinstance(stop.code, int) else NO
        except GearblocksError as error:
            _say(str(error))
            return NO if isinstance(error, (SimulationError, CompileError)) else BAD_INPUT
        except KeyboardInterrupt:
            _say("stopped")
            return NO
        except Exception as error:
            if os.environ.get("GEARBLOCKS_DEBUG"):
                raise
            _say(f"a fault in gearblocks itself: {type(error).__name__}: {error} (GEARBLOCKS_DEBUG=1 shows where)")
            return NO
    return 0


def _say(words: str) -> None:
    print(f"gearblocks: {words}", file=sys.stderr)


def _train(text: str, without: Sequence[str] = ()) -> Drivetrain:
    from gearblocks.cli import scripts

    rig = scripts.make(text)
    return rig.without(*without) if without else rig


def _changed(rig: Drivetrain, changes: dict[str, float | str]) -> tuple[Model, dict[str, float | str]]:
    """The model with what is structural changed, and the rest of the changes, which need no other model."""
    from gearblocks.drivetrain import build

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


def _check_endings(out: Path | None, plot: Path | None) -> None:
    """Refuse before the run what could not be written after it."""
    for option, path, endings in (("--out", out, (".csv", ".nc", ".json")), ("--plot", plot, (".png", ".svg", ".pdf"))):
        if path is None:
            continue
        if path.suffix.lower() not in endings:
            raise ParameterError(f"{option} {path}: the ending must be one of {', '.join(endings)}")
        if not path.parent.is_dir():
            raise ParameterError(f"{option} {path}: there is no folder '{path.parent}'")


@contextmanager
def _progress() -> Iterator[Callable[[float], None]]:
    """A function that takes the share done, 0 .. 1; a bar appears on a terminal when the run takes long."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("simulating"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn(), TextColumn("left"))
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task("", total=1.0)
    began = time.monotonic()

    def show(share: float) -> None:
        if time.monotonic() - began > 0.5 and not bar.live.is_started:
            bar.start()
        bar.update(task, completed=share)

    try:
        yield show
    finally:
        bar.stop()


def _grid(t_end: float) -> Any:
    """Times for a smooth picture: accepted steps of a high order lie too far apart for straight lines between them."""
    import numpy as np

    return np.linspace(0.0, t_end, SMOOTH)


def _report(result: Trajectory, shown: Sequence[str]) -> None:
    """Print what the run was, and the range of the outputs named."""
    if not len(result.t):
        typer.echo(f"{result.name}: no samples")
        return
    typer.echo(f"{result.name}: {len(result.t)} samples up to t = {result.t[-1]:.6g} s")
    typer.echo(f"{result.stats}")
    typer.echo(f"energy residual {result.energy.residual:.1e} of a turnover of {result.energy.turnover:.4g} J")
    width = max((len(name) for name in shown), default=0)
    for name in shown:
        unit = "" if result.units[name] == "1" else result.units[name]
        typer.echo(f"  {name:<{width}}  {result[name].min(): .6g} .. {result[name].max(): .6g} {unit}".rstrip())


def _telling(names: Sequence[str]) -> tuple[str, ...]:
    """The outputs that tell most, at most a dozen: deflections and forces of elements, speeds of bodies."""
    kinds = ("deflection", "twist", "force", "torque", "w", "v")
    own = [name for name in names if name.count(".") == 1]
    chosen = [name for kind in kinds for name in own if name.endswith("." + kind)]
    return tuple(chosen[:12]) or tuple(names[:12])
