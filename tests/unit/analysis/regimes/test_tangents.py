"""Derivatives of the state by the start state and by parameters against central differences of plain runs, across all that a
motion meets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy

import gearblocks as gb
from gearblocks.analysis.regimes.neutral import neutral_directions
from gearblocks.analysis.regimes.strobe import change_of, strobe


def _train(
    name: str, tau: Any, *, after_disc: Callable[[gb.Drivetrain], Any] | None = None, **start: float
) -> gb.Drivetrain:
    rig = gb.Drivetrain(name)
    source, disc = rig.add("source", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=1.0, **start))
    rig.chain(source, disc)
    if after_disc is not None:
        after_disc(rig)
    return rig


def _beside(rig: gb.Drivetrain, *parts: tuple[str, Any]) -> None:
    rig.chain(rig["disc"], *(rig.add(name, part) for name, part in parts), rig.add("ground", gb.Fixed()))


def _corner(drive: Any) -> gb.Drivetrain:
    lash = gb.Lash(k=40.0, c=0.3, half_gap=0.1)
    return _train("corner", gb.cos(drive * gb.time), after_disc=lambda r: _beside(r, ("lash", lash)), w0=0.2)


def _jump(drive: Any) -> gb.Drivetrain:
    lash = gb.Lash(k=40.0, c=0.9, half_gap=0.1, contact_damping="clipped_force")  # begins with c x'
    return _train("jump", gb.cos(drive * gb.time), after_disc=lambda r: _beside(r, ("lash", lash)), w0=0.2)


def _impact(drive: Any) -> gb.Drivetrain:
    stop = gb.HardStop(lower=-0.3, upper=0.4, restitution=0.7)
    return _train("impact", gb.cos(drive * gb.time) + 0.3, after_disc=lambda r: _beside(r, ("stop", stop)), w0=0.5)


def _moving_stop(drive: Any) -> gb.Drivetrain:
    rig = _train("moving stop", gb.cos(drive * gb.time) + 0.3, w0=0.5)
    stop, wave = gb.HardStop(lower=-0.3, upper=0.4, restitution=0.7), gb.Parameter("wave", 3.0, "rad/s")
    wall = gb.Angle(phi=0.2 * gb.sin(wave * gb.time))
    rig.chain(rig["disc"], rig.add("stop", stop), rig.add("wall", wall))
    return rig


class _Passages(gb.Block):
    """Is pulled back by as much as the speed and the instant were at the last passage through `level`."""

    flange = gb.Flange("watched shaft")
    level: float = gb.param("angle that is passed", "rad", default=0.2)
    seen = gb.State("speed and time at the last passage", "rad/s", start=0.1)

    def physics(self, s: Any) -> Any:
        beyond = sympy.Heaviside(s.flange.phi - s.level, 1)
        yield gb.Hold(s.seen, s.flange.w * s.level + 0.3 * s.time**2, beyond)
        yield gb.Acts(s.flange, -s.seen * beyond)


def _held_value(drive: Any) -> gb.Drivetrain:
    rig = _train("held", 0.5 * gb.cos(drive * gb.time), w0=2.0)
    _beside(rig, ("spring", gb.Shaft(k=9.0)))
    rig.connect(rig.add("passages", _Passages()).flange, rig["disc"].b)
    return rig


def _clutch(drive: Any) -> gb.Drivetrain:
    rig = _train("clutch", 2.0 * gb.cos(drive * gb.time), w0=0.4)
    rig.chain(
        rig["disc"], rig.add("clutch", gb.Clutch(capacity=0.9)), rig.add("plate", gb.Inertia(J=0.5)),
        rig.add("spring", gb.Shaft(k=3.0, c=0.2)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    return rig


def _timed(drive: Any) -> gb.Drivetrain:
    change = gb.Parameter("change", 2.3, "s")
    tau = gb.piecewise((1.0, gb.time < change), (gb.cos(drive * gb.time), True)) - gb.sense("disc.phi") ** 3
    return _train("timed", tau, after_disc=lambda r: _beside(r, ("damper", gb.Damper(c=0.1))), phi0=0.3)


def _square(drive: Any) -> gb.Drivetrain:
    level = gb.Parameter("level", 0.3)
    tau = gb.piecewise((1.0, gb.cos(drive * gb.time) > level), (-0.8, True))
    return _train("square", tau, after_disc=lambda r: _beside(r, ("spring", gb.Shaft(k=3.0, c=0.2))), phi0=0.3)


def _massless(drive: Any) -> gb.Drivetrain:
    shafts = ("near", gb.Shaft(k=3.0, c=0.5)), ("brake", gb.Brake(capacity=0.4)), ("far", gb.Shaft(k=2.0))
    rig = _train("massless", gb.cos(drive * gb.time), w0=0.4)
    rig.chain(rig["disc"], rig.add(*shafts[0]), rig.add(*shafts[2]), rig.add("ground", gb.Fixed()))
    rig.connect(rig.add(*shafts[1]).a, rig["near"].b)
    return rig


def _turns(drive: Any) -> gb.Drivetrain:
    tau = gb.cos(drive * gb.time) + 2.0 * gb.sin(3 * gb.sense("disc.phi"))
    return _train("turns", tau, after_disc=lambda r: _beside(r, ("damper", gb.Damper(c=0.02))), w0=9.0)


def _lossy(drive: Any) -> gb.Drivetrain:
    rig = _train("lossy", 3.0 * gb.cos(drive * gb.time), w0=0.4)
    rig.chain(
        rig["disc"], rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8))), rig.add("wheel", gb.Inertia(J=0.5)),
        rig.add("spring", gb.Shaft(k=3.0, c=0.2)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    return rig


MADE = {
    _corner: ("drive", "lash.half_gap", "lash.k"),
    _jump: ("drive", "lash.half_gap", "lash.c"),
    _impact: ("drive", "stop.upper", "stop.restitution"),
    _moving_stop: ("wave", "stop.lower", "stop.restitution"),
    _held_value: ("drive", "passages.level"),
    _clutch: ("clutch.capacity", "disc.J"),
    _timed: ("drive", "change"),
    _square: ("drive", "level", "spring.c"),
    _massless: ("near.k", "far.k", "brake.capacity"),
    _turns: ("drive", "damper.c"),
    _lossy: ("drive", "spring.k", "wheel.J"),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("made", MADE)
def test_tangents_are_what_differences_of_runs_come_to(made: Callable[[Any], gb.Drivetrain]) -> None:
    rig = made(gb.Parameter("drive", 1.0, "rad/s"))
    seen = strobe(gb.build(rig), gb.stroboscopic("drive"), None, None, 1e-12)
    y = seen.start(None)
    run = seen.map(y, 2)
    assert run.corner == "" and (run.events >= 2 or made in (_turns, _timed, _massless))
    step = 1e-5
    for direction in neutral_directions(seen, y).allowed.T:
        ends = [seen.follow(y + h * direction, 2).states[-1] for h in (-2 * step, -step, step, 2 * step)]
        difference = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * step)
        tolerance = 1e-6 * max(1.0, float(np.abs(difference).max()))
        assert np.abs(run.maps[-1] @ direction - difference).max() <= tolerance


@pytest.mark.few(1)
@pytest.mark.parametrize(("made", "path"), [(made, path) for made, paths in MADE.items() for path in paths])
def test_the_tangent_by_a_parameter_is_what_differences_of_trains_come_to(
    made: Callable[[Any], gb.Drivetrain], path: str
) -> None:
    model, section = gb.build(made(gb.Parameter("drive", 1.0, "rad/s"))), gb.stroboscopic("drive")
    number = model.program.parameter_numbers[path]
    value = float(model.values[number])
    seen = strobe(model, section, None, None, 1e-12)
    y = seen.start(None)
    run = seen.follow(y, 2, by=change_of(seen, section, number, value))
    assert run.corner == "" and run.slope is not None
    step = 2e-5
    ends = [
        strobe(model, section, {path: value * (1 + h)}, None, 1e-12).follow(y, 2).states[-1]
        for h in (-2 * step, -step, step, 2 * step)
    ]
    difference = (ends[0] - 8 * ends[1] + 8 * ends[2] - ends[3]) / (12 * step)
    assert np.abs(difference).max() > 1e-3
    assert np.abs(run.slope - difference).max() <= 1e-6 * max(1.0, float(np.abs(difference).max()))


def test_a_grazing_impact_has_no_derivative() -> None:
    # thrown up at 1 against 1 rad/s2: it turns back at 0.5 exactly, where the stop is
    for height, corner in ((0.5 + 1e-13, True), (0.5 - 1e-13, True), (0.55, False), (0.45, False)):
        rig = gb.Drivetrain("graze")
        drive = gb.Parameter("drive", 3.0, "rad/s")
        source = rig.add("source", gb.Torque(tau=-1.0 + 1e-30 * gb.cos(drive * gb.time)))
        rig.chain(source, rig.add("disc", gb.Inertia(J=1.0, w0=1.0)))
        _beside(rig, ("stop", gb.HardStop(lower=-height, upper=50.0, restitution=0.5)))
        seen = strobe(gb.build(rig), gb.stroboscopic("drive"), None, None, 1e-12)
        run = seen.map(seen.start(None), 1)
        assert (run.corner != "") is corner, (height, run.corner)
        if corner:
            assert "stop" in run.corner and "t = 1" in run.corner
