"""The shell: demo, new, copy, list, doc, describe, outputs, parameters, inputs, run, cost, effects, sweep,
equations, draw, export, check, hard.

Exit status: 0 done; 1 it ran and the answer is no; 2 bad input. Errors are one message on standard error.
"""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gearblocks import __version__
from gearblocks.cli import beginnings, listings, run_report
from gearblocks.cli.costs import cost
from gearblocks.cli.drawing import draw
from gearblocks.cli.effects import effects
from gearblocks.cli.terminal import accept_every_character, complain, in_the_shell, progress, say, say_page
from gearblocks.cli.trains import (
    Change,
    End,
    Initial,
    Method,
    Rtol,
    Step,
    Train,
    Without,
    asked,
    built,
    given_twice,
    named,
    threads,
    unit_apart,
)
from gearblocks.cli.typed import called
from gearblocks.errors import CompileError, GearblocksError, SimulationError

NO, BAD_INPUT, STOPPED = 1, 2, 130

app = typer.Typer(
    help="Drivetrains from blocks: equations of motion, fast runs, FMUs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _version(asked: bool) -> None:
    if asked:
        say(f"gearblocks {__version__}")
        raise typer.Exit


@app.callback()
def _shell(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Its version.")] = False,
) -> None:
    """Drivetrains from blocks: equations of motion, fast runs, FMUs."""


class Form(StrEnum):
    """How equations are written."""

    text = "text"
    latex = "latex"
    html = "html"
    mathml = "mathml"
    c = "c"


@app.command()
def demo(out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("gearblocks-demo")) -> None:
    """The main job on a spline coupling: equations, four speeds, pictures, cost, FMU, check, report."""
    from gearblocks.cli.demo import demo as run_demo

    sound = run_demo(out, say=say)
    say(f"open {out / 'index.html'} in a browser")
    if not sound:
        raise typer.Exit(NO)


@app.command()
def new(file: Annotated[Path, typer.Argument(metavar="FILE", help="The script to write: X.py.")]) -> None:
    """Write a commented script to start from."""
    _begun(beginnings.new(file))


@app.command()
def copy(
    model: Annotated[str, typer.Argument(metavar="MODEL", help="A shipped model; `gearblocks list` shows them.")],
    file: Annotated[Path | None, typer.Argument(metavar="FILE", help="Where to; without: MODEL.py here.")] = None,
) -> None:
    """Copy a shipped model, to change it."""
    _begun(beginnings.copy(model, file))


def _begun(script: Path) -> None:
    say(f"wrote {script}; next: gearblocks run {script}, gearblocks equations {script}")


@app.command("list")
def list_models(file: Annotated[str | None, typer.Argument(metavar="FILE", help="A script.")] = None) -> None:
    """Shipped models, or the trains and scenes in FILE."""
    from gearblocks.cli import scripts

    if file is None:
        rows = [(name, "", scripts.first_line(path)) for name, path in scripts.shipped().items()]
    else:
        path, _ = scripts.locate(file)
        rows = [(f"{file}:{maker.name}", f"{maker.kind}  ", maker.words) for maker in scripts.makers(path)]
    width = max((len(name) for name, _, _ in rows), default=0)
    for name, kind, words in rows:
        say(f"{name:<{width}}  {kind}{words}".rstrip())
    if not rows:
        complain("nothing here makes a train" if file else "no model is shipped")
        raise typer.Exit(NO)


@app.command()
def doc(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="A public name, such as GearMesh.")] = None,
) -> None:
    """Fields, flanges, outputs and an example of a block; without NAME: all public names, a line each."""
    from gearblocks.cli import block_help

    say(block_help.listing() if name is None else block_help.page(name))


@app.command()
def run(
    train: Train,
    t_end: End = None,
    initial: Initial = None,
    change: Change = None,
    without: Without = None,
    rtol: Rtol = 1e-6,
    method: Method = "auto",
    step: Step = None,
    outputs: Annotated[list[str] | None, typer.Option(metavar="PATTERN", help="What to record.")] = None,
    out: Annotated[Path | None, typer.Option(help="Store the run: .csv, .nc or .json.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture over time: .png, .svg or .pdf.")] = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say what limited the steps, and what would help.")
    ] = False,
) -> None:
    """Simulate a train, or a scene as it says."""
    run_report.check_endings(out, plot)
    it = built(train, change, without)
    from gearblocks.running import simulate

    model, options = it.model, {"rtol": rtol, "method": method, "step": step, **it.arguments(t_end, initial)}
    chosen = tuple(outputs) if outputs else "*"
    failure: SimulationError | None = None
    try:
        with progress() as show:
            result = simulate(model, outputs=chosen, progress=show, **options)
    except SimulationError as error:
        if error.trajectory is None or not len(error.trajectory.t):
            raise
        result, failure = error.trajectory, error
    shown = result.names if outputs else run_report.telling(result.names)
    run_report.report(result, shown)
    if it.scene is not None and result.complete:
        run_report.answers(result, it.scene)
    if explain and result.complete:
        say(str(result.explain()))
    if out is not None:
        result.save(out)
        say(f"wrote {out}")
    if plot is not None:
        sparse = result.complete and len(result.t) < run_report.SMOOTH
        t = run_report.grid(options.pop("t_end"), options.get("t_start", 0.0))
        drawn = simulate(model, t=t, outputs=shown, watch=False, **options) if sparse else result
        drawn.plot(*shown, path=plot)
        say(f"wrote {plot}")
    if failure is not None:
        raise failure
    if not result.complete:
        complain(f"stopped at t = {result.t[-1]:.6g} s; what was done until then is kept")
        raise typer.Exit(NO)


@app.command()
def sweep(
    train: Train,
    over: Annotated[list[str], typer.Option(metavar="PATH=FROM:TO:N", help="What varies; several make a grid.")],
    of: Annotated[
        list[str] | None, typer.Option(metavar="OUTPUT", help="An output, or peak(OUTPUT), rms(OUTPUT) ...")
    ] = None,
    t_end: End = None,
    initial: Initial = None,
    change: Change = None,
    without: Without = None,
    rtol: Rtol = 1e-6,
    method: Method = "auto",
    step: Step = None,
    out: Annotated[Path | None, typer.Option(help="A folder, or a file: .csv, .nc, .zarr, .png ...")] = None,
    store: Annotated[Path | None, typer.Option(help="A folder (Zarr) from which a stopped sweep goes on.")] = None,
    jobs: Annotated[int | None, typer.Option(parser=threads, metavar="N", help="Threads; without: all cores.")] = None,
) -> None:
    """Run a train or a scene over a grid of values, and tell what each run comes to."""
    from gearblocks.cli import studies

    values = studies.grid(over)
    studies.check_place(out)
    it = built(train, change, without)
    from gearblocks.analysis import parameter_study

    model, options = it.model, it.arguments(t_end, initial)
    usual = run_report.telling([*model.program.output_numbers])[:1]
    asks = it.scene.measures if it.scene and not of else studies.quantities(model.program, of or (), usual)
    found = parameter_study.sweep(
        model, values, quantity=asks, rtol=rtol, method=method, step=step, store=store, threads=jobs, **options
    )
    say(repr(found)[1:-1])
    for path in studies.written(found, out) if out is not None and found.done.any() else []:
        say(f"wrote {path}")
    for failure in found.failures[:10]:
        complain(
            in_the_shell(f"{', '.join(f'{path} = {x:.6g}' for path, x in failure.point.items())}: {failure.message}")
        )
    if not found.complete or len(found.failures) == len(found):
        raise typer.Exit(NO)


@app.command()
def equations(
    train: Train,
    form: Annotated[Form, typer.Option("--format", help="How they are written.")] = Form.text,
    change: Change = None,
    without: Without = None,
) -> None:
    """Print the equations of motion."""
    rig = named(train, change, without)
    if form is Form.c:
        from gearblocks.running import build

        say(build(rig).program.source)
    elif form is Form.html:
        say_page(rig.equations().html(rig._repr_svg_() or ""))
    else:
        eq = rig.equations()
        say({Form.latex: eq.latex, Form.mathml: eq.mathml}.get(form, eq.__str__)())


@app.command()
def export(
    train: Train,
    out: Annotated[Path, typer.Option("-o", "--out", help="The FMU to write.")],
    fmi: Annotated[str, typer.Option(metavar="2.0", help="Version of the standard; there is 2.0.")] = "2.0",
    platform: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Platform of a binary: native (default).")
    ] = None,
    change: Change = None,
    without: Without = None,
    rtol: Rtol = 1e-6,
    method: Method = "auto",
    step: Step = None,
) -> None:
    """Write a train as an FMU."""
    rig, scene = asked(train, change, without)
    import fmu_export

    path = fmu_export.export(
        scene or rig, out, fmi=fmi, platforms=tuple(platform or ("native",)), rtol=rtol, method=method, step=step
    )
    say(f"wrote {path} ({path.stat().st_size / 1024:.0f} KiB)")


for listing in (listings.describe, listings.outputs, listings.parameters, listings.inputs):
    app.command()(listing)
app.command()(draw)
app.command()(cost)
app.command()(effects)


@app.command()
def check(fmu: Annotated[Path, typer.Argument(metavar="X.fmu", help="The FMU to check.")]) -> None:
    """Check an FMU: validity, a run, comparison with the run in this process."""
    import fmu_export

    report = fmu_export.check(fmu)
    say(str(report))
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
        complain("stopped; the rows printed so far stand")
        passed = False
    if not passed:
        raise typer.Exit(NO)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the shell with `arguments` (those of the process where None); the answer is the exit status."""
    accept_every_character()
    given = sys.argv[1:] if arguments is None else list(arguments)
    if wrong := unit_apart(given) or given_twice(given, app):
        complain(wrong)
        return BAD_INPUT
    with warnings.catch_warnings():
        warnings.showwarning = lambda message, *_, **__: complain(in_the_shell(f"warning: {message}"))
        try:
            status = called(app, arguments)
            if status == STOPPED:
                complain("stopped by Ctrl-C; what had been written until then is kept")
            return status
        except SystemExit as stop:
            return stop.code if isinstance(stop.code, int) else NO
        except GearblocksError as error:
            complain(in_the_shell(str(error)))
            return NO if isinstance(error, (SimulationError, CompileError)) else BAD_INPUT
        except KeyboardInterrupt:
            complain("stopped")
            return NO
        except MemoryError:
            complain("the memory of this machine is too small for that: ask for fewer points, outputs or samples")
            return NO
        except Exception as error:
            if os.environ.get("GEARBLOCKS_DEBUG"):
                raise
            complain(f"a fault in gearblocks itself: {type(error).__name__}: {error} (GEARBLOCKS_DEBUG=1 shows where)")
            return NO
