"""What cannot be right, and must be refused by name."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.errors import SimulationError
from gearblocks.hard.judging import RTOL, Check, Meter, below, fact, largest, refusal
from gearblocks.hard.parts import driven, line


def nan_torque(meter: Meter) -> Iterator[Check]:
    """The torque is NaN after t = 1: as an input, and as an expression."""
    yield from _stops(meter, driven("nan", tau=gb.Input("tau")), inputs={"tau": lambda t: 1.0 if t <= 1 else math.nan})
    yield from _stops(meter, driven("nan", tau=(1 - gb.time) ** 0.5))


def pole(meter: Meter) -> Iterator[Check]:
    """A torque of 1e-3/(t - 1)^2."""
    yield from _stops(meter, driven("pole", tau=1e-3 / (gb.time - 1) ** 2))


def _stops(meter: Meter, rig: gb.Drivetrain, **arguments: Any) -> Iterator[Check]:
    """The run must end with an error that names a part, and with finite numbers up to t = 1 at most. (The time in the
    error is that of the first value that was no number, looked for within a step.)"""
    try:
        run = meter.simulate(rig, t_end=5.0, **arguments)
    except SimulationError as error:
        found = error.trajectory
        finite = found is not None and all(np.isfinite(found[name]).all() for name in found)
        yield fact(f"stops: {error}", bool(error.component))
        yield fact("finite samples, none after t = 1", finite and found.t[-1] <= 1.0)
        return
    yield fact(f"goes on to t = {run.t[-1]:g} s", False)


NONSENSE: tuple[tuple[Callable[[], Any], str], ...] = (
    (lambda: gb.Inertia(J=-1.0), "J"),
    (lambda: gb.Inertia(J=math.nan), "J"),
    (lambda: gb.Inertia(J=math.inf), "J"),
    (lambda: gb.Inertia(J=1.0, w0=math.nan), "w0"),
    (lambda: gb.Shaft(k=-1.0), "k"),
    (lambda: gb.Shaft(k=math.nan), "k"),
    (lambda: gb.Shaft(k=1.0, c=math.inf), "c"),
    (lambda: gb.Shaft(k=1.0, c=-1.0), "c"),
    (lambda: gb.IdealGear(ratio=0.0), "ratio"),
    (lambda: gb.IdealGear(ratio=math.nan), "ratio"),
    (lambda: gb.Lash(k=1.0, half_gap=-1e-3), "half_gap"),
    (lambda: gb.Lash(k=1.0, half_gap=math.nan), "half_gap"),
    (lambda: gb.Clutch(capacity=-1.0), "capacity"),
    (lambda: gb.Clutch(capacity=math.nan), "capacity"),
    (lambda: gb.Brake(capacity=-1.0), "capacity"),
    (lambda: gb.Torque(tau=math.nan), "tau"),
    (lambda: gb.Torque(tau=math.inf), "tau"),
)


def nonsense_values(meter: Meter) -> Iterator[Check]:
    """Values that no machine has; J = 0 is one that a train may have."""
    for make, field in NONSENSE:
        yield refusal(partial(_with, make), "odd", field)
    yield refusal(lambda: gb.Parameter("tau", math.nan), "tau")
    rig = gb.Drivetrain("node")
    rig.chain(
        rig.add("one", gb.Inertia(J=1.0, w0=1.0)), rig.add("left", gb.Shaft(k=1.0)), rig.add("node", gb.Inertia(J=0.0)),
        rig.add("right", gb.Shaft(k=1.0)), rig.add("two", gb.Inertia(J=1.0)),
    )  # fmt: skip
    run = meter.simulate(rig, t_end=1.0)
    yield fact("J = 0 is a node without inertia", bool(np.isfinite(run["node.phi"]).all()))


def _with(make: Callable[[], Any]) -> gb.Model:
    """A train with the block under the name 'odd' on the first flange that it has, built."""
    rig = gb.Drivetrain("odd values")
    body, odd = rig.add("body", gb.Inertia(J=1.0)), rig.add("odd", make())
    rig.connect(body.a, getattr(odd, odd.flanges[0]))
    return gb.build(rig)


def self_locking_worm(meter: Meter) -> Iterator[Check]:
    """A worm that its wheel cannot drive, turning: J2 + ratio^2 J1/eta2 = -4 with a screw of 1e-3 kg m2, 0.455 with 1e-5.

    By Coulomb friction on its flanks (decision 24) the first has one acceleration: along the motion the load presses on the
    flank that brakes, load/-4, against it load/(J2 + ratio^2 J1 eta1). The second has none with a load along the motion (it
    jams) and two with one against it (Painleve): both are refused where they begin. In either direction.
    """
    for direction in (1.0, -1.0):
        for words, load, effective in (("pushed on", direction, -4.0), ("held back", -direction, 0.77)):
            run = meter.simulate(_worm(1e-3, direction, load), t_end=0.1)
            off = largest(run["wheel.alpha"] * effective / load - 1)
            yield below(f"w = {direction:+g}, {words}: off load/{effective:g} by", off, 1e-9)
            yield fact(
                "loses power, books no more than that",
                bool((run["worm.loss_power"] > 0).all()) and run.energy.residual < RTOL,
            )
        for words, load in (("no acceleration", direction), ("two accelerations", -direction)):
            case = f"w = {direction:+g}, light screw, {words}"
            try:
                run = meter.simulate(_worm(1e-5, direction, load), t_end=0.1)
            except SimulationError as error:
                yield fact(f"{case}: refused: {error}", error.component == "worm" and error.time == 0.0)
            else:
                yield fact(f"{case}: goes on with {run['wheel.alpha'][0]:.4g} rad/s2", False)


def _worm(screw: float, direction: float, load: float) -> gb.Drivetrain:
    """The worm between a screw of that inertia and a wheel that turns in a direction at 1 rad/s, under a load."""
    return line(
        "worm",
        ("screw", gb.Inertia(J=screw)), ("worm", gb.LossyGear(ratio=30.0, efficiency=(0.3, -0.2))),
        ("wheel", gb.Inertia(J=0.5, w0=direction)), ("load", gb.Torque(tau=load)),
    )  # fmt: skip
