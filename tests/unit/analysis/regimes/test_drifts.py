"""Motions that repeat but for what goes on along a neutral direction: slip that adds up, an angle that nothing reads."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

SECTION = gb.stroboscopic("drive")


def _train(*behind: tuple[str, gb.Block], mean: Any, swing: float = 1.0) -> gb.Drivetrain:
    """A disc under mean + swing cos(drive t), and what is behind it."""
    rig, drive = gb.Drivetrain("drift"), gb.Parameter("drive", 1.0, "rad/s")
    source = rig.add("source", gb.Torque(tau=mean + swing * gb.cos(drive * gb.time)))
    rig.chain(source, rig.add("disc", gb.Inertia(J=1.0)), *(rig.add(name, part) for name, part in behind))
    return rig


def test_a_brake_that_slips_more_in_each_period_leaves_a_motion_that_repeats() -> None:
    # w' = 2 + cos t - 1 - 0.3 w: slip adds up by 2 pi/0.3 a period
    rig = _train(("damper", gb.Damper(c=0.3)), ("ground", gb.Fixed()), mean=2.0)
    rig.connect(rig.add("brake", gb.Brake(capacity=1.0)).a, rig["disc"].b)
    found = gb.classify(rig, SECTION)
    assert found.label == "period 1" and "free angle of brake: neutral" in found.evidence[0], found.evidence
    orbit = found.orbit
    assert orbit is not None and orbit.exponents == pytest.approx([-0.3], abs=1e-9)
    assert gb.lyapunov(rig, SECTION, periods=40).values == pytest.approx([-0.3], abs=1e-9)
    w = dict(zip(orbit.names, orbit.points[0], strict=True))["disc.w"]
    assert w == pytest.approx(1 / 0.3 + 0.3 / (1 + 0.3**2), abs=1e-8)
    run = gb.simulate(rig, t_end=2 * np.pi, initial=orbit.starts[0], rtol=1e-10)
    assert run["disc.w"][-1] == pytest.approx(w, abs=1e-8)


def _ratchet() -> gb.Drivetrain:
    load = ("free", gb.Freewheel()), ("load", gb.Inertia(J=1.0)), ("drag", gb.Damper(c=0.5)), ("ground", gb.Fixed())
    rig = _train(*load, mean=0.0, swing=2.0)
    rig.chain(rig["disc"], rig.add("spring", gb.Shaft(k=2.0, c=0.1)), rig.add("held", gb.Fixed()))
    return rig


def test_a_ratchet_repeats_while_its_load_goes_on() -> None:
    rig = _ratchet()
    run = gb.simulate(rig, t=2 * np.pi * np.arange(301), rtol=1e-9)
    speeds = np.column_stack([run["disc.w"], run["load.w"], run["disc.phi"]])
    assert np.abs(np.diff(speeds[-10:], axis=0)).max() < 1e-6  # the truth
    assert (np.diff(run["load.phi"][-10:]) > 1.0).all()
    found = gb.classify(rig, SECTION)
    assert found.label == "period 1" and found.orbit is not None and found.orbit.stable, found.evidence


@pytest.mark.long
def test_slip_that_adds_up_hides_no_doubling() -> None:
    # a torque of half the frequency beside it
    rig, drive = gb.Drivetrain("drift"), gb.Parameter("drive", 1.0, "rad/s")
    tau: Any = 2.0 + gb.cos(drive * gb.time) + 0.5 * gb.cos(drive * gb.time / 2)
    rig.chain(
        rig.add("source", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=1.0)), rig.add("damper", gb.Damper(c=0.3)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    rig.connect(rig.add("brake", gb.Brake(capacity=1.0)).a, rig["disc"].b)
    assert gb.classify(rig, SECTION).label == "period 2"


@pytest.mark.parametrize(("mean", "label"), [(0.0, "period 1"), (0.1, "unresolved")])
def test_a_free_disc_repeats_where_its_speed_does(mean: float, label: str) -> None:
    # beside a disc that swings: with a mean torque the free one is ever faster
    rig = _train(("spring", gb.Shaft(k=2.0, c=0.3)), ("ground", gb.Fixed()), mean=0.0)
    rig.chain(rig.add("push", gb.Torque(tau=mean + 0.1 * gb.sense("disc.w"))), rig.add("free", gb.Inertia(J=1.0)))
    assert gb.classify(rig, SECTION).label == label


@pytest.mark.parametrize(
    ("rate", "mean", "label"), [(0.0, 0.0, "period 1"), (1e-9, 0.0, "unresolved"), (0.0, 1e-10, "unresolved")]
)
def test_a_free_disc_that_grows_faster_by_less_than_a_map_tells_has_no_period(
    rate: float, mean: float, label: str
) -> None:
    # w' = mean + cos t + rate w, beside a disc that swings
    rig = _train(("spring", gb.Shaft(k=2.0, c=0.3)), ("ground", gb.Fixed()), mean=0.0)
    push = gb.Torque(tau=mean + gb.cos(gb.time) + rate * gb.sense("free.w"))
    rig.chain(rig.add("push", push), rig.add("free", gb.Inertia(J=1.0, w0=1.0)))
    found = gb.classify(rig, SECTION)
    assert found.label == label, found.evidence


@pytest.mark.parametrize(("k", "label"), [(-1e-9, "unresolved"), (-1e-10, "unresolved"), (1e-6, "period 1")])
def test_an_angle_that_creeps_is_no_free_one(k: float, label: str) -> None:
    # x'' + x' + k x = cos t from x = 1: e^(-k t)
    rig = _train(("damper", gb.Damper(c=1.0)), ("ground", gb.Fixed()), mean=-k * gb.sense("disc.phi"))
    found = gb.classify(rig, SECTION, initial={"disc.phi": 1.0})
    assert found.label == label, found.evidence


@pytest.mark.parametrize(("off", "label"), [(0.0, "period 1"), (1e-10, "unresolved"), (1e-9, "unresolved")])
def test_an_undamped_disc_beside_the_section_s_frequency_does_not_repeat(off: float, label: str) -> None:
    # x'' + 4 (1 + off) x = cos t beside a damped disc: its own swing is a second frequency
    rig = _train(("spring", gb.Shaft(k=2.0, c=0.3)), ("ground", gb.Fixed()), mean=0.0)
    push = gb.Torque(tau=gb.cos(gb.time) - 4 * (1 + off) * gb.sense("other.phi"))
    rig.chain(rig.add("push", push), rig.add("other", gb.Inertia(J=1.0, phi0=1.0)))
    found = gb.classify(rig, SECTION)
    assert found.label == label, found.evidence
