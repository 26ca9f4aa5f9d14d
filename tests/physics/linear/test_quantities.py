"""Quantities of runs against closed forms: peaks between steps, integrals over time, energy that friction takes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gearblocks as gb

K, C, J, W0 = 100.0, 0.4, 1.0, 1.0
RATE = C / (2 * J)
SWING = math.sqrt(K / J - RATE**2)


def _oscillator() -> gb.Model:
    """An inertia that starts with speed W0 on a damped shaft to the ground."""
    rig = gb.Drivetrain("damped oscillator")
    ground, shaft = rig.add("ground", gb.Fixed()), rig.add("shaft", gb.Shaft(k=K, c=C))
    rig.connect(ground.flange, shaft.a)
    rig.connect(shaft.b, rig.add("body", gb.Inertia(J=J, w0=W0)).a)
    return gb.build(rig)


@pytest.fixture(scope="module")
def oscillator() -> gb.Model:
    return _oscillator()


def _turn(number: int) -> float:
    """phi at its turning point of that number (0: the first maximum): w = 0 at tan(wd t) = wd / rate."""
    t = (math.atan2(SWING, RATE) + number * math.pi) / SWING
    return math.exp(-RATE * t) * W0 * math.sin(SWING * t) / SWING


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize("method", ["auto", "rodas"])
@pytest.mark.few(3)
def test_a_peak_is_that_of_the_motion_wherever_the_steps_end(oscillator: gb.Model, rtol: float, method: str) -> None:
    found = []
    for longest in (None, 0.05, 0.013):
        run = gb.simulate(oscillator, t_end=5.0, rtol=rtol, max_step=longest, method=method)
        found.append((gb.peak("body.phi").of(run), gb.trough("body.phi", after=0.4).of(run)))
        assert gb.peak("body.phi").of(run) >= run["body.phi"].max()
    exact = np.array([_turn(0), _turn(1)])
    assert np.abs(np.array(found) / exact - 1).max() < 3 * rtol  # the error of the run itself


def test_a_peak_between_two_long_steps_is_far_above_the_samples(oscillator: gb.Model) -> None:
    run = gb.simulate(oscillator, t_end=5.0, rtol=1e-6)
    assert run["body.phi"].max() < 0.98 * _turn(0)
    assert gb.peak("body.phi").of(run) == pytest.approx(_turn(0), rel=1e-7)


def test_a_peak_at_the_edge_of_its_window_is_found_there(oscillator: gb.Model) -> None:
    run = gb.simulate(oscillator, t_end=5.0, rtol=1e-9)
    early = 0.1  # before the first maximum: phi still rises
    exact = math.exp(-RATE * early) * math.sin(SWING * early) / SWING
    assert gb.peak("body.phi", before=early).of(run) == pytest.approx(exact, rel=1e-8)


def _integral(t: float, n: int) -> float:
    """Integral of exp(-rate t) sin(wd t) (n = 1), or of its square (n = 2), from 0 to t."""
    a, w = n * RATE, SWING
    if n == 1:
        return (w - math.exp(-a * t) * (a * math.sin(w * t) + w * math.cos(w * t))) / (a * a + w * w)
    plain = (1 - math.exp(-a * t)) / a
    v = 2 * w
    return (plain - (a + math.exp(-a * t) * (v * math.sin(v * t) - a * math.cos(v * t))) / (a * a + v * v)) / 2


@pytest.mark.parametrize(("after", "before"), [(None, None), (0.333, 2.718), (1.0, 1.001)])
def test_mean_and_rms_are_integrals_over_the_window_not_over_samples(
    oscillator: gb.Model, after: float | None, before: float | None
) -> None:
    run = gb.simulate(oscillator, t_end=5.0, rtol=1e-8)
    a, b = after or 0.0, before or 5.0
    mean = (_integral(b, 1) - _integral(a, 1)) / (b - a) * W0 / SWING
    rms = math.sqrt((_integral(b, 2) - _integral(a, 2)) / (b - a)) * W0 / SWING
    assert gb.mean("body.phi", after=after, before=before).of(run) == pytest.approx(mean, abs=1e-8 * _turn(0))
    assert gb.rms("body.phi", after=after, before=before).of(run) == pytest.approx(rms, rel=1e-7)


@pytest.mark.long
def test_rms_of_a_torque_that_is_a_sine_over_whole_periods() -> None:
    rig = gb.Drivetrain("shaker")
    body = rig.add("body", gb.Inertia(J=1.0))
    drive = rig.add("drive", gb.Torque(tau=3.0 + 2.0 * gb.sin(50 * gb.time)))
    rig.connect(drive.flange, body.a)
    run = gb.simulate(rig, t_end=10 * 2 * math.pi / 50, rtol=1e-8)
    # steps are chosen for the motion to 1e-8, a torque of time alone sits on the same ones: quadrature of order 8 likewise
    assert gb.rms("drive.torque").of(run) == pytest.approx(math.sqrt(9 + 2), rel=5e-8)
    assert gb.mean("drive.torque").of(run) == pytest.approx(3.0, rel=5e-8)
    assert gb.peak("drive.torque").of(run) == pytest.approx(5.0, rel=1e-12)
    assert gb.trough("drive.torque").of(run) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.long
def test_a_square_wave_has_its_exact_mean_and_peak_whatever_the_steps() -> None:
    rig = gb.Drivetrain("square")
    body = rig.add("body", gb.Inertia(J=1.0))
    drive = rig.add("drive", gb.Torque(tau=gb.Table([0.0, 0.3, 0.7], [1.0, 5.0, -2.0], kind="step")(gb.time)))
    rig.connect(drive.flange, body.a)
    run = gb.simulate(rig, t_end=1.0)
    assert gb.mean("drive.torque").of(run) == pytest.approx(0.3 + 5 * 0.4 - 2 * 0.3, rel=1e-12)
    assert gb.rms("drive.torque").of(run) == pytest.approx(math.sqrt(0.3 + 25 * 0.4 + 4 * 0.3), rel=1e-12)
    assert (gb.peak("drive.torque").of(run), gb.trough("drive.torque").of(run)) == (5.0, -2.0)
    assert gb.peak("drive.torque", after=0.7).of(run) == -2.0  # the value just before the jump is not in the window


@pytest.fixture(scope="module")
def clutched() -> gb.Model:
    """Two discs brought together by a clutch: it slips until both have the common speed."""
    rig = gb.Drivetrain("two discs")
    left, clutch = rig.add("left", gb.Inertia(J=2.0, w0=100.0)), rig.add("clutch", gb.Clutch(capacity=50.0))
    rig.chain(left, clutch, rig.add("right", gb.Inertia(J=3.0)))
    return gb.build(rig)


@pytest.mark.long
def test_a_clutch_takes_the_energy_of_an_inelastic_impact_and_locks_when_speeds_meet(clutched: gb.Model) -> None:
    run = gb.simulate(clutched, t_end=5.0, rtol=1e-9)
    reduced = 2.0 * 3.0 / 5.0
    assert gb.energy_lost("clutch").of(run) == pytest.approx(0.5 * reduced * 100.0**2, rel=1e-9)
    lock = 100.0 * reduced / 50.0
    assert gb.event_time("clutch").of(run) == pytest.approx(lock, rel=1e-9)
    assert gb.event_time("clutch", number=-1).of(run) == gb.event_time("clutch").of(run)
    assert math.isnan(gb.event_time("clutch", number=1).of(run))
    assert gb.count("clutch").of(run) == gb.count().of(run) == gb.count("clutch", "state").of(run) == 1
    assert gb.count("clutch", before=lock / 2).of(run) == gb.count("clutch", "impact").of(run) == 0
    assert gb.last("right.w").of(run) == pytest.approx(40.0, rel=1e-9)
    assert gb.at("right.w", 1.2).of(run) == pytest.approx(50.0 / 3.0 * 1.2, rel=1e-9)


def test_energy_lost_in_a_part_of_the_run(clutched: gb.Model) -> None:
    run = gb.simulate(clutched, t_end=5.0, rtol=1e-9)

    def lost(t: float) -> float:  # 50 N m on a slip of 100 - 50 t (1/2 + 1/3)
        return 50.0 * (100.0 * t - 50.0 * (1 / 2 + 1 / 3) * t * t / 2)

    assert gb.energy_lost("clutch", after=0.5, before=1.5).of(run) == pytest.approx(lost(1.5) - lost(0.5), rel=1e-9)


def test_points_of_a_section_are_the_outputs_once_per_period() -> None:
    rig = gb.Drivetrain("driven")
    speed = gb.Parameter("speed", 40.0, "rad/s")
    drive = rig.add("drive", gb.Torque(tau=gb.sin(speed * gb.time)))
    body, damper = rig.add("body", gb.Inertia(J=1.0)), rig.add("damper", gb.Damper(c=3.0))
    rig.chain(drive, body, damper, rig.add("ground", gb.Fixed()))
    run = gb.simulate(rig, t_end=4.0, rtol=1e-9)
    t = 2 * np.pi / 40.0 * np.arange(26)
    exact = 40.0 / 1609.0 * (np.exp(-3 * t) - 1.0)  # of w' = sin(40 t) - 3 w from rest, where the sine is zero
    found = gb.points("body.w", gb.stroboscopic("speed")).of(run)
    assert found == pytest.approx(exact, abs=1e-10)
    assert gb.points("body.w", gb.stroboscopic("speed"), keep=3).of(run).tolist() == found[-3:].tolist()
