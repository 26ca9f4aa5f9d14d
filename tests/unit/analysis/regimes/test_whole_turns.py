"""Motions that go on by whole turns: what they are beside these."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes.sizes import turned
from gearblocks.analysis.regimes.strobe import strobe

SECTION = gb.stroboscopic("drive")


def _disc(
    torque: Callable[[Any, Any], Any], c: float, drive: float = 1.0, behind: Any = None, **start: float
) -> gb.Drivetrain:
    """x'' + c x' = torque(drive, x)."""
    rig, given = gb.Drivetrain("disc"), gb.Parameter("drive", drive, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=torque(given, gb.sense("disc.phi")))), rig.add("disc", gb.Inertia(J=1.0, **start)),
        rig.add("damper", gb.Damper(c=c)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    if behind is not None:
        behind(rig)
    return rig


def _pendulum(g: float | gb.Parameter) -> gb.Drivetrain:
    """x'' + 0.5 x' + sin x = g cos 2t/3 (Baker and Gollub 1990): goes round by a turn a period from 1.35 on."""
    return _disc(lambda drive, x: g * gb.cos(drive * gb.time) - gb.sin(x), 0.5, 2 / 3, phi0=0.2)


def _by_scipy(g: float, periods: int) -> tuple[int, float]:
    """After how many periods the pendulum repeats but for turns, and by how many turns it goes on in these."""
    from scipy.integrate import solve_ivp

    end = 3 * np.pi
    run = solve_ivp(
        lambda t, y: (y[1], g * np.cos(2 * t / 3) - 0.5 * y[1] - np.sin(y[0])), (0, periods * end), (0.2, 0.0),
        "DOP853", t_eval=end * np.arange(periods - 40, periods + 1), rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    x, v = run.y
    for m in range(1, 17):
        off = x[m:] - x[:-m]
        turns = np.round(off / (2 * np.pi))
        if max(np.abs(off - 2 * np.pi * turns).max(), np.abs(v[m:] - v[:-m]).max()) < 1e-6:
            return m, float(turns[-1])
    raise AssertionError("it does not repeat")


@pytest.mark.few(1)
@pytest.mark.parametrize(("g", "period"), [(1.35, 1), (1.45, 2), (1.47, 4), (0.9, 1), (1.07, 2)])
def test_a_pendulum_that_goes_round_repeats_beside_its_turns(g: float, period: int) -> None:
    known, turns = _by_scipy(g, 400)
    found = gb.classify(_pendulum(g), SECTION)
    assert known == period and found.label == f"period {period}", found.evidence
    orbit = found.orbit
    assert orbit is not None and orbit.ahead.tolist() == pytest.approx([2 * np.pi * turns, 0.0])
    assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(-0.5 * 3 * np.pi * period), rel=1e-6)
    assert turns == 0 or f"it goes on by turns: disc by {turns:+g}" in found.evidence[0]


@pytest.mark.long
@pytest.mark.parametrize("g", [1.15, 1.5])
def test_one_that_goes_round_at_random_is_chaotic(g: float) -> None:
    assert gb.classify(_pendulum(g), SECTION).label == "chaotic"


def _machine(pairs: int, behind: Any = None) -> gb.Drivetrain:
    """A synchronous machine in step: x'' + 0.1 x' = 2 sin(drive t - pairs x) - 0.4, at drive = 6 rad/s."""
    behind_by = np.arcsin(0.2 + 0.05 * 6.0 / pairs) + 0.1
    start = {"w0": 6.0 / pairs, "phi0": -behind_by / pairs}
    return _disc(lambda drive, x: 2.0 * gb.sin(drive * gb.time - pairs * x) - 0.4, 0.1, 6.0, behind, **start)


@pytest.mark.parametrize("pairs", [1, 3])
@pytest.mark.few(1)
def test_a_synchronous_machine_in_step_has_the_multipliers_of_its_equation(pairs: int) -> None:
    # x = (drive t - a)/pairs with 2 sin a = 0.4 + 0.1 drive/pairs; beside it z'' + 0.1 z' + 2 pairs cos(a) z = 0
    a, turn = np.arcsin(0.2 + 0.05 * 6.0 / pairs), 2 * np.pi / pairs
    found = gb.classify(_machine(pairs), SECTION)
    assert found.label == "period 1", found.evidence
    orbit = found.orbit
    assert orbit is not None and (orbit.ahead[0], orbit.turns[0]) == pytest.approx((turn, turn))
    rates = np.roots([1.0, 0.1, 2 * pairs * np.cos(a)])
    assert np.sort_complex(orbit.multipliers) == pytest.approx(
        np.sort_complex(np.exp(rates * 2 * np.pi / 6.0)), abs=1e-7
    )
    left = (orbit.points[0, 0] + a / pairs) / turn
    assert abs(left - np.round(left)) < 1e-9


@pytest.mark.long
@pytest.mark.parametrize(("pairs", "period"), [(1, 1), (3, 3)])
def test_teeth_that_go_round_with_it_repeat_when_they_are_back(pairs: int, period: int) -> None:
    # 23 teeth: 23/3 of a tooth in each period of three pole pairs; whole turns are taken off by the solver itself
    def teeth(rig: gb.Drivetrain) -> None:
        mesh = gb.GearMesh(
            teeth=(23, 41), module=3e-3, pressure_angle=np.radians(20), external=True, k=2e6, damping_ratio=0.05,
            stiffness_variation=gb.Fourier(cos=(0.2,)),
        )  # fmt: skip
        wheel, load = (
            rig.add("wheel", gb.Inertia(J=0.5, w0=-6.0 / pairs * 23 / 41)),
            rig.add("load", gb.Torque(tau=0.1)),
        )
        rig.chain(rig["disc"], rig.add("mesh", mesh), wheel, load)

    found = gb.classify(_machine(pairs, teeth), SECTION)
    assert found.label == f"period {period}", found.evidence
    assert found.orbit is not None and found.orbit.stable
    assert found.orbit.ahead.max() == pytest.approx(2 * np.pi)


def test_a_disc_that_goes_round_at_a_speed_of_its_own_is_a_torus() -> None:
    # a constant torque and a drive that is felt by nothing: x'' + 0.5 x' + sin x = 2 + 1e-9 cos t
    from scipy.integrate import solve_ivp

    rig = _disc(lambda drive, x: 2.0 + 1e-9 * gb.cos(drive * gb.time) - gb.sin(x), 0.5)
    found = gb.classify(rig, SECTION)
    assert found.label == "quasi-periodic", found.evidence
    run = solve_ivp(
        lambda t, y: (y[1], 2.0 - 0.5 * y[1] - np.sin(y[0])),
        (0, 3000),
        (0, 4),
        "DOP853",
        rtol=1e-10,
        t_eval=(2000, 3000),
    )
    share = np.diff(run.y[0])[0] / 1000 % 1.0  # turns a period of the section, beside whole ones
    told = float(found.evidence[0].partition("frequency, ")[2].split()[0])
    assert min(abs(told - share), abs(told - (1 - share))) < 2e-3, (told, share)
    # 2000 periods without a new begin: 0.0016 for 0, told to a part of 50,000 rad
    assert gb.lyapunov(rig, SECTION, periods=2000).values == pytest.approx([0.0, -0.5], abs=1e-6)


def test_exponents_branches_lines_and_quick_labels_know_of_turns() -> None:
    g = gb.Parameter("g", 1.35)
    model = gb.build(_pendulum(g))
    orbit = gb.periodic_orbit(model, SECTION)
    found = gb.lyapunov(model, SECTION, periods=40)
    assert found.orbit is not None and found.values == pytest.approx(orbit.exponents, abs=1e-6)
    diagram = gb.bifurcation(model, "g", [1.35, 1.45, 1.47], section=SECTION, of="disc.w", transient=400)
    assert diagram.labels[0] == ("quick: period 1", "quick: period 2", "quick: period 4")
    branch = gb.continue_orbit(model, "g", (1.40, 1.47), section=SECTION, of="disc.w", parameters={"g": 1.40})
    (mark,) = branch.marked("period doubling")
    assert 1.40 < mark.value < 1.45
    lines = gb.spectrum(model, section=SECTION, of="disc.w")
    assert lines.periods == 1 and lines.amplitude[0] == pytest.approx(2 / 3, rel=1e-6)  # a turn a period


@pytest.mark.parametrize(
    ("torque", "turn"),
    [
        (lambda drive, x: 2 - gb.sin(x), 2 * np.pi),
        (lambda drive, x: 2 - gb.sin(6 * x) - gb.sin(10 * x), np.pi),
        (lambda drive, x: 2 - gb.sin(x / 5), 10 * np.pi),
        (lambda drive, x: 2 - gb.sin(2 * x / 3) - gb.sin(drive * gb.time - x), 6 * np.pi),
        (lambda drive, x: 2 + 0 * drive, 0.0),  # no angle is read: that is a neutral direction
        (lambda drive, x: 2 - 0.01 * x, 0.0),
        (lambda drive, x: 2 - gb.sin(x) - gb.tanh(x / 1000), 0.0),
        (lambda drive, x: gb.piecewise((0.0, x > 1e3), (2.0, True)) - gb.sin(x), 0.0),
    ],
)  # fmt: skip
def test_the_least_turn_is_that_of_the_law(torque: Any, turn: float) -> None:
    seen = strobe(
        gb.build(_disc(lambda drive, x: torque(drive, x) + 1e-9 * gb.cos(drive * gb.time), 0.5)),
        SECTION,
        None,
        None,
        1e-9,
    )
    assert turned(seen, seen.start(None), 0).turns.max() == pytest.approx(turn)
