"""Signals that stay exactly on the limit of a condition: a pedal at 0 asked for > 0, a gear number asked for >= 2."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas", "auto"]
t = gb.time
pedal, gear, share, up, fades, clipped, other = (
    gb.Input(name) for name in ("pedal", "gear", "share", "up", "fades", "clipped", "other")
)
none = gb.Parameter("none", 0.0)


def _on(condition: Any) -> Any:
    return gb.piecewise((10, condition), (0, True))


def _held(*levels: float) -> gb.Table:
    """A signal that is one level for a second each, and jumps between."""
    times = [x for i in range(len(levels)) for x in (float(i), float(i + 1))]
    return gb.Table(times, [x for level in levels for x in (level, level)])


INPUTS = {
    "pedal": _held(0, 1, 0),
    "gear": _held(1, 2, 3),
    "share": _held(0.9, 1.8, 0.9),  # 0.3 and 0.7 of 0.9 are more
    "up": _held(-1, 0, 1),
    "other": _held(1, 1, 0),
    "fades": lambda time: max(0.0, 1.0 - time / 0.7),
    "clipped": lambda time: min(1.0, time / 0.7),
}
step = gb.Table([1, 2, 3], [10.0, 20.0, 30.0], "step")
ramp = gb.Table([0, 1, 2, 3], [1, 0, 0, 1])(t)
"""It comes to 0, stays, and leaves it again."""
rise = gb.Table([0, 1, 2, 3], [-1, 0, 0, -1])(t)

swings = gb.Table([0, 0.5, 1, 1.5, 3], [0, 1, -1, 1, 1])(t)

# law, speed after 3 s from rest, with an inertia of 1
HELD = {
    "pressed": (_on(pedal > 0), 10),
    "not below": (_on(pedal >= 0), 30),
    "below": (_on(pedal < 0), 0),
    "not above": (_on(pedal <= 0), 20),
    "at least the second": (_on(gear >= 2), 20),
    "above the first": (_on(gear > 1), 20),
    "up to the second": (_on(gear <= 2), 20),
    "below the second": (_on(gear < 2), 10),
    "not above a share": (_on(share <= 0.9), 20),
    "above a share": (_on(share > 0.9), 10),
    "forward, backward, neither": (gb.piecewise((10, up > 0), (-7, up < 0), (5, True)), 8),
    "sign": (10 * np.sign(up) + 2, 6),
    "sign of a pedal": (10 * np.sign(pedal), 10),
    "between": (_on((gear > 1) & (gear < 3)), 10),
    "either side": (_on((up > 0) | (up < 0)), 20),
    "neither side": (_on(~((up > 0) | (up < 0))), 10),
    "of a Parameter": (_on(none > 0) + 2 * _on(none >= 0) + np.sign(none), 60),
    "two signals": (_on(pedal > other), 0),
    "times a wave": (_on(pedal * gb.sin(t + 0.1) > 0), 10),
    "a size": (_on(abs(up) > 0), 20),
    "the larger of both": (_on(gb.maximum(up, 0) > 0), 10),
    "no larger than the larger": (_on(gb.maximum(t / 3.1, gear) > gear), 0),
    "unit step": (10 * gb.Heaviside(gear - 2), 20),
    "a step table": (step(gear), 60),
    "a step table over one": (step(gb.Table([0, 1, 2], [1, 2, 3], "step")(t)), 60),
    "a condition on a step table": (_on(step(gear) >= 20), 20),
    "comes to 0": (_on(ramp > 0), 20),
    "comes to 0, which counts": (_on(ramp >= 0), 30),
    "rises to 0": (_on(rise >= 0), 10),
    "rises to 0, which does not count": (_on(rise > 0), 0),
    "begins to rise": (_on(gb.maximum(t - 1, 0) > 0), 20),
    "has come down": (_on(gb.maximum(1 - t, 0) <= 0), 20),
    "touches 0": (_on(abs(t - 1) > 0), 30),
    "passes 0": (_on(t - 1 > 0), 20),
    "carried back as it comes there": (_on(swings > gb.Heaviside(swings)), 0),
    "two thresholds at one speed": (_on(ramp + 2 * gb.Heaviside(1 - t) >= 2 + ramp * gb.Heaviside(1 - t)), 10),
    "a difference of nothing": (_on(gb.Heaviside(pedal - pedal) >= 1), 30),
    "falls off a step as the run begins": (_on(gb.Table([0, 1], [0, 5], "step")(1 - pedal * t - t / 9) < 5), 30),
    "a function that fades": (_on(fades > 0), 7),
    "a function that is clipped": (_on(clipped >= 1), 23),
}


def _run(**options: Any) -> gb.Run:
    rig = gb.Drivetrain("held")
    for i, (law, _) in enumerate(HELD.values()):
        rig.chain(rig.add(f"drive{i}", gb.Torque(tau=law)), rig.add(f"disc{i}", gb.Inertia(J=1.0)))
    return gb.simulate(rig, t_end=3.0, inputs=INPUTS, **options)


@pytest.mark.parametrize("method", METHODS)
def test_what_stays_on_its_limit_is_as_the_condition_says(method: str) -> None:
    run = _run(method=method)
    found = {name: float(run[f"disc{i}.w"][-1]) for i, name in enumerate(HELD)}
    assert found == pytest.approx({name: float(speed) for name, (_, speed) in HELD.items()}, abs=1e-5)


def test_so_it_is_where_sides_are_told_in_every_stage() -> None:
    run = _run(method="dp5", step=1 / 64, locate=False)
    for i, (name, (_, speed)) in enumerate(HELD.items()):
        assert run[f"disc{i}.w"][-1] == pytest.approx(speed, abs=30 / 64), name


BRAKED = {
    "goes forward": (lambda w: _on(w > 0), 0),
    "does not go back": (lambda w: _on(w >= 0), 10),
    "goes back": (lambda w: _on(w < 0), 0),
    "does not go forward": (lambda w: _on(w <= 0), 10),
    "goes forward fast enough": (lambda w: _on(0.3 * w > 0), 0),
    "stands on a step": (lambda w: gb.Table([-5, 0], [0.0, 10.0], "step")(w), 10),
}


@pytest.mark.parametrize("w0", [3.0, -3.0, 0.0])
@pytest.mark.parametrize("method", METHODS)
def test_what_friction_holds_at_rest_goes_neither_way(method: str, w0: float) -> None:
    rig = gb.Drivetrain("braked")
    for i, (law, _) in enumerate(BRAKED.values()):
        disc = rig.add(f"disc{i}", gb.Inertia(J=1.0, w0=w0))
        drive = rig.add(f"drive{i}", gb.Torque(tau=-law(gb.sense(f"disc{i}.w"))))
        rig.chain(drive, disc, rig.add(f"bearing{i}", gb.BearingFriction(coulomb=20.0)))
    run = gb.simulate(rig, t_end=1.0, method=method)
    for i, (name, (_, torque)) in enumerate(BRAKED.items()):
        assert run[f"disc{i}.w"][-1] == 0.0, name
        assert run[f"drive{i}.torque"][-1] == -torque, name


@pytest.mark.parametrize("w0", [3.0, -3.0, 0.0])
@pytest.mark.parametrize("method", METHODS)
def test_a_law_that_leaves_its_limit_wherever_it_stands_there_ends(method: str, w0: float) -> None:
    w, waves = gb.sense("disc.w"), gb.Table(list(np.linspace(0, 3, 31)), [0.1, -0.1] * 15 + [0.1])(t)
    rig = gb.Drivetrain("restless")
    drive = rig.add("drive", gb.Torque(tau=waves - gb.piecewise((10, w >= 0), (0, True))))
    rig.chain(drive, rig.add("disc", gb.Inertia(J=1.0, w0=w0)), rig.add("bearing", gb.BearingFriction(coulomb=5.0)))
    run = gb.simulate(rig, t_end=3.0, method=method)
    assert abs(run["disc.w"][-1]) < 1e-9
    assert len(run.events) < 150


@pytest.mark.parametrize("method", METHODS)
def test_a_guarded_law_with_a_pole_where_its_guard_ends(method: str) -> None:
    load = 1 - 3 * t
    slip = gb.sense("disc.w") - 2
    force = gb.piecewise((load * gb.sin(np.arctan(2e3 * slip / load)), load > 0), (0, True))
    rig = gb.Drivetrain("lifted")
    rig.chain(rig.add("grip", gb.Torque(tau=-force)), rig.add("disc", gb.Inertia(J=1.0, w0=20.0)))
    run = gb.simulate(rig, t_end=0.5, method=method)
    assert run["disc.w"][-1] == pytest.approx(20 - 1 / 6, rel=1e-8)
