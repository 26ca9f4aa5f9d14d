"""Products of multipliers: exp(integral of the trace of the rates), times the determinants of the jumps (Liouville)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes.strobe import strobe

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")
T = 2 * np.pi


def test_where_damping_is_linear_the_product_is_that_of_its_trace_whatever_corners_there_are() -> None:
    rig, drive = gb.Drivetrain("gap"), gb.Parameter("drive", 1.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=0.3 + gb.cos(drive * gb.time))), rig.add("disc", gb.Inertia(J=0.5)),
        rig.add("lash", gb.Lash(k=40.0, c=0.1, half_gap=0.1, contact_damping="always")),
        rig.add("wheel", gb.Inertia(J=2.0)), rig.add("spring", gb.Shaft(k=3.0, c=0.2)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    seen = strobe(gb.build(rig), SECTION, None, None, 1e-11)
    y, trace, events = seen.start(None), -(0.1 / 0.5 + 0.1 / 2.0 + 0.2 / 2.0), 0
    for period in range(6):  # the gap, the spring, two speeds
        run = seen.map(y, 1, after=period)
        assert np.linalg.det(run.maps[-1]) == pytest.approx(np.exp(trace * T), rel=1e-7)
        y, events = run.states[-1], events + run.events
    assert events >= 8
    orbit = gb.periodic_orbit(rig, SECTION, transient=3000, periods=12)
    assert np.prod(orbit.multipliers).real == pytest.approx(np.exp(trace * orbit.periods * T), rel=1e-6)


@pytest.mark.parametrize(("k", "c"), [(1.0, 3.0), (8.0, 4.4)])  # overdamped, and a pair
def test_small_multipliers_of_two_periods_are_those_of_the_equation(oscillator: Oscillator, k: float, c: float) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(drive * gb.time / 2), k=k, c=c)
    orbit = gb.periodic_orbit(rig, SECTION, periods=2, parameters={"drive": 2.0})
    exponents = np.sort(np.roots([1.0, c, k]).real)[::-1]
    assert orbit.periods == 2 and np.abs(orbit.multipliers).min() < 1e-5
    assert orbit.exponents == pytest.approx(
        exponents, abs=1e-9
    )  # of 1e-7 with derivatives to 1e-10 six digits are lost
    found = gb.lyapunov(rig, SECTION, periods=40, rtol=1e-11, parameters={"drive": 2.0})
    assert found.values == pytest.approx(exponents, abs=1e-9)


@pytest.mark.parametrize("restitution", [0.6, 0.8])
def test_each_impact_of_a_body_has_the_square_of_its_restitution(restitution: float) -> None:
    rig, drive = gb.Drivetrain("stop"), gb.Parameter("drive", 1.0, "rad/s")
    stop = gb.HardStop(lower=-0.3, upper=0.4, restitution=restitution)
    rig.chain(
        rig.add("source", gb.Torque(tau=gb.cos(drive * gb.time) + 0.1)), rig.add("disc", gb.Inertia(J=1.0, w0=0.5)),
        rig.add("stop", stop), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    rig.chain(rig["disc"], rig.add("damper", gb.Damper(c=0.1)), rig.add("other_ground", gb.Fixed()))
    seen = strobe(gb.build(rig), SECTION, None, None, 1e-11)
    moved = [i for i, q in enumerate(seen.model.program.states) if not q.name.endswith(("impulse", "impacts"))]
    y, strikes = seen.start(None), 0
    for period in range(5):
        run = seen.map(y, 1, after=period)
        assert run.corner == "" and len(moved) == 2
        expected = restitution ** (2 * run.events) * np.exp(-0.1 * T)
        assert np.linalg.det(run.maps[-1][np.ix_(moved, moved)]) == pytest.approx(expected, rel=1e-6)
        y, strikes = run.states[-1], strikes + run.events
    assert strikes >= 5
