"""Unusual motions: dry friction, rest upside down, slip at a frequency of its own, a hill, and growth too slow to see."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes.strobe import strobe

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


@pytest.mark.parametrize(("own", "friction"), [(1.7, 0.3), (0.7, 0.5)])
def test_dry_friction_has_the_amplitude_of_den_hartog(own: float, friction: float) -> None:
    rig, drive = gb.Drivetrain("dry"), gb.Parameter("drive", 1.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=gb.cos(drive * gb.time))), rig.add("disc", gb.Inertia(J=1.0)),
        rig.add("spring", gb.Shaft(k=own**2)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    rig.connect(rig.add("brake", gb.Brake(capacity=friction)).a, rig["disc"].b)
    found = gb.classify(rig, SECTION)
    assert found.label == "period 1" and found.orbit is not None, found.evidence
    run = gb.simulate(rig, initial=found.orbit.starts[0], t_end=found.orbit.starts[0].t[0] + 2 * np.pi, rtol=1e-10)
    b = 1 / own  # Den Hartog 1931: motion without stops
    turns = np.sin(np.pi / b) / (b * (1 + np.cos(np.pi / b)))
    amplitude = np.sqrt((1 / (1 - b**2)) ** 2 - (friction * turns) ** 2) / own**2
    assert run.extremes("disc.phi").high == pytest.approx(amplitude, rel=1e-6)


def test_a_pendulum_whose_pivot_shakes_rests_upside_down(oscillator: Oscillator) -> None:
    # Kapitza 1951: where (40/20)^2 > 2; with 20 in place of 40 it falls
    for shaking, up in ((40, True), (20, False)):
        rig = oscillator(
            lambda drive, x, v, a=shaking: (1 + a * gb.cos(20 * drive * gb.time)) * gb.sin(x) - 0.1 * v, k=1e-12, c=0.0,
            phi0=0.2,
        )  # fmt: skip
        run = gb.simulate(rig, t=2 * np.pi * np.arange(300.0, 310.0), rtol=1e-9)
        assert bool(np.abs(run["disc.phi"]).max() < 0.1) is up
        if up:
            found = gb.classify(rig, SECTION)
            assert found.label == "period 1", found.evidence


def test_a_drive_whose_size_comes_and_goes_in_100_periods_has_these(oscillator: Oscillator) -> None:
    rig = oscillator(
        lambda drive, x, v: (1 + 0.5 * gb.cos(drive * gb.time / 100)) * gb.cos(drive * gb.time), k=3.0, c=0.2
    )
    found = gb.classify(rig, SECTION)
    assert found.label == "period 100", found.evidence


def test_two_drives_that_never_repeat_together_hide_no_chaos(oscillator: Oscillator) -> None:
    rig = oscillator(  # Ueda's oscillator, with a little of another frequency
        lambda drive, x, v: 7.5 * gb.cos(drive * gb.time) + 0.01 * gb.cos(2**0.5 * gb.time) - x**3, k=1e-12
    )
    found = gb.classify(rig, SECTION)
    assert found.label == "chaotic" and found.exponents is not None, found.evidence
    off = found.exponents.values[0] - 0.1034
    assert abs(off) < 4 * found.exponents.errors[0]


def test_a_block_on_a_belt_slips_at_a_frequency_of_its_own() -> None:
    rig, drive = gb.Drivetrain("belt"), gb.Parameter("drive", 1.0, "rad/s")
    disc = rig.add("block", gb.Inertia(J=1.0))
    rig.chain(
        rig.add("source", gb.Torque(tau=0.0 * gb.cos(drive * gb.time))), disc, rig.add("spring", gb.Shaft(k=2.0, c=0.01)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    rig.chain(
        rig.add("motor", gb.Speed(w=0.3)), rig.add("roll", gb.Inertia(J=1.0)),
        rig.add("friction", gb.Clutch(capacity=1.0, peak=1.6)), disc,
    )  # fmt: skip
    run = gb.simulate(rig, t_end=600.0, rtol=1e-9)
    sticks = [ev.t for ev in run.events if ev.component == "friction" and ev.after == 0.0]
    own = 2 * np.pi * 20 / (sticks[-1] - sticks[-21])
    assert np.diff(sticks[-21:]) == pytest.approx(2 * np.pi / own, rel=1e-6)
    found = gb.classify(rig, SECTION)
    assert found.label == "quasi-periodic", found.evidence
    told = float(found.evidence[0].split("frequency, ")[1].split(" ")[0])
    turned = own % 1.0
    assert min(abs(told - turned), abs(told - 1 + turned)) < 1e-4


def test_a_motion_that_stands_on_a_hill_is_not_chaotic(oscillator: Oscillator) -> None:
    # x'' + 0.1 x' = sin x from x = 0, where differences grow as exp(0.951 t)
    found = gb.classify(oscillator(lambda drive, x, v: gb.sin(x) - 0.1 * v + 0 * drive, k=1e-15, c=0.0), SECTION)
    assert found.label == "unresolved" and "stands on an orbit of period 1 that is not stable" in found.evidence[0]
    assert found.orbit is not None
    assert found.orbit.exponents[0] == pytest.approx(-0.05 + np.sqrt(1.0025), rel=1e-8)


def test_what_grows_too_slowly_to_see_is_no_torus(oscillator: Oscillator) -> None:
    # x'' - 1e-5 x' + 2 x = cos t grows by 3e-5 a period
    found = gb.classify(oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + 1e-5 * v, k=2.0, c=0.0), SECTION)
    assert found.label == "unresolved" and "moves away from an orbit of period 1" in found.evidence[0], found.evidence
    assert found.orbit is not None and abs(found.orbit.multipliers[0]) == pytest.approx(np.exp(1e-5 * np.pi), abs=1e-9)


def test_a_contact_that_begins_as_it_did_a_period_ago_has_the_multipliers_of_its_runs() -> None:
    # one side alone is met: what Hunt and Crossley's damping holds is set to what it is, and forgets what it was all the same
    rig, drive = gb.Drivetrain("contact"), gb.Parameter("drive", 1.0, "rad/s")
    teeth = gb.Lash(k=30.0, half_gap=3.0, contact_damping=gb.HuntCrossley(restitution=0.6))
    rig.chain(
        rig.add("source", gb.Torque(tau=0.45 + 0.5 * gb.cos(drive * gb.time))), rig.add("disc", gb.Inertia(J=1.0)),
        rig.add("teeth", teeth), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    model = gb.build(rig)
    found = gb.classify(model, SECTION)
    assert found.label == "period 1" and found.orbit is not None, found.evidence
    seen, y = strobe(model, SECTION, None, None, 1e-12), found.orbit.points[0]
    steps = 1e-5 * np.eye(seen.n)
    runs = [(seen.follow(y + e, 1).states[-1] - seen.follow(y - e, 1).states[-1]) / 2e-5 for e in steps]
    # a corner of the contact passes through what a difference is taken over: 1e-5
    assert seen.map(y, 1).maps[-1] == pytest.approx(np.array(runs).T, abs=1e-4)
