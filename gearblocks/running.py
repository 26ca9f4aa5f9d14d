"""Building and running, on top of the stages: a train becomes a model, a model a trajectory."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import GearblocksError, by_name_only
from gearblocks.model.build import build_tree, without_collector
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    from gearblocks.simulation.arguments import InputSource, Start
    from gearblocks.simulation.trajectory import Trajectory


@by_name_only
def build(train: Drivetrain | Model) -> Model:
    """Equations, program and compiled library of a train, for repeated use: simulate(model, ...), export(model, ...)."""
    if isinstance(train, Model):
        return train
    if not isinstance(train, Drivetrain):
        raise GearblocksError(f"{train!r:.200} is no Drivetrain and no Model (as gb.Drivetrain and gb.build make them)")
    with without_collector():
        model, left_out = build_tree(train.tree()), train.left_out()
    return model if left_out is None else replace(model, left_out=left_out)


@by_name_only
def simulate(
    train: Drivetrain | Model, *, t_end: float | str | None = None, t: ArrayLike | None = None,
    t_start: float | str | None = None, method: str = "auto", rtol: float = 1e-6, step: float | str | None = None,
    max_step: float | str | None = None, locate: bool = True, inputs: Mapping[str, InputSource] | None = None,
    parameters: Mapping[str, float | str] | None = None, initial: Start = None,
    outputs: str | Sequence[str] = "*", progress: Callable[[float], None] | None = None, residual: float | None = None,
    watch: bool = True,
) -> Trajectory:  # fmt: skip
    """Runs a train or model.

    t_end: end of the run [s], or such as "20 ms"; the samples are the accepted steps with both sides of each event. Or t:
    sample times [s].
    t_start: start [s], default 0. method: "auto", "rk4" (needs step), "dp5", "dp8", "rodas". rtol: tolerance relative to the
    largest value of each state so far. step: fixed step [s] for any method. max_step: longest step [s].
    Each of these times may be text with its unit, such as "20 ms".
    locate: False locates nothing: every stage of a step takes the side it is on, as an `if` in the right-hand side does (to see
    what that costs); friction, stops and lossy gears then change at the ends of steps.
    inputs: by name a number, a `Table` over time, a pair (t, y) or a Series of pandas over time [s] (straight lines between
    the samples), or a function of time (called per stage: slow; a Table is fast).
    parameters: other values by path ("mesh.k"), without recompiling; what a block refuses when it is built, it refuses here
    too. initial: start values by name ("motor.w",
    "motor.phi", states of blocks), an earlier run to continue or a point of an orbit (`orbit.starts[0]` of
    `gb.periodic_orbit`), "rolling" or `gb.rolling({"motor.w": 300})` (the train turns as
    one piece), "static" (the equilibrium with every excitation by time at its mean, contact side from the load; absolute
    angles and start speeds stay, bodies without one turn along) or "static_at_start" (under everything as it is
    at t_start). outputs: a pattern or several ("mesh.*").
    residual: the run stops where its energy residual (run.energy.residual), looked at between samples about every 50 ms of
    CPU time and at the end, exceeds this.
    watch: of a train from which effects were left out (rig.without, rig.only), whether the run watches if they would have
    acted: run.watched says how often and when first, and a GearblocksWarning names those that would; likewise friction and
    loss tables that are held beyond their last point where their last line is not level (run.watched.tables).
    progress: called with the share done (0..1), five times a second at most; without it a long run says how far it is, on
    a terminal and in a notebook after two seconds, in a log by a line every so often.

    Raises UnknownNameError and ParameterError for bad arguments, SimulationError (with the trajectory so far) when the
    run cannot go on. Ctrl-C returns what is done; run.complete is then False.
    """
    from gearblocks.simulation.run import run_model

    return run_model(
        build(train), t_end=t_end, t=t, t_start=t_start, method=method, rtol=rtol, step=step, max_step=max_step,
        locate=locate, inputs=inputs, parameters=parameters, initial=initial, outputs=outputs, progress=progress,
        residual=residual, watch=watch,
    )  # fmt: skip


@by_name_only
def carried_start(
    full: Drivetrain | Model, variant: Drivetrain | Model, *,
    initial: Start = None, t_start: float | str | None = None,
    parameters: Mapping[str, float | str] | None = None, inputs: Mapping[str, InputSource] | None = None,
) -> Start:  # fmt: skip
    """What `initial` a train without some effects is to be run with, so that it starts where the full train starts.

    `initial` itself where that does it, or where it asks for an equilibrium that the variant has; else start values by name,
    or for an earlier run of the full train a run of no length. Speeds that new ties contradict keep the momentum of the full
    train, angles the deflections that are left, blocks their states. Other arguments: those of the run.

    Example:
        lean = rig.without("shaft.*")
        run = gb.simulate(lean, t_end=0.1, initial=gb.carried_start(rig, lean, initial="static"))
    """
    from gearblocks.simulation.carried_start import carried_start

    return carried_start(build(full), build(variant), initial, t_start=t_start, parameters=parameters, inputs=inputs)
