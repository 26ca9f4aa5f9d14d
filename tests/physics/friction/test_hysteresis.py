"""Shafts with inner friction: loops of torque over twist."""

import numpy as np
import pytest

import gearblocks as gb


def _driven(hysteresis, x, speed=1.0):
    """A shaft whose end is swung by x sin(speed t)."""
    rig = gb.Drivetrain("loop")
    parts = (
        rig.add("drive", gb.Angle(phi=x * gb.sin(speed * gb.time))),
        rig.add("body", gb.Inertia(J=1.0)),
        rig.add("shaft", gb.Shaft(k=100.0, hysteresis=hysteresis)),
        rig.add("ground", gb.Fixed()),
    )
    rig.chain(*parts)
    return rig


@pytest.mark.parametrize("speed", [0.1, 1.0, 50.0])
@pytest.mark.parametrize(("friction", "stiffness"), [(2.0, 50.0), (1.0, 400.0), (0.3, 20.0)])
@pytest.mark.few(1)
def test_a_loop_loses_four_frictions_times_its_slip_at_any_speed(friction, stiffness, speed):
    x = 0.1
    rig = _driven(gb.Hysteresis(friction=friction, stiffness=stiffness), x, speed)
    lost = [
        gb.simulate(rig, t_end=2 * np.pi * turns / speed, rtol=1e-9).energy.dissipated["shaft"]
        for turns in (1.25, 2.25)
    ]
    assert lost[1] - lost[0] == pytest.approx(4 * friction * (x - friction / stiffness), rel=1e-8)
    run = gb.simulate(rig, t=np.linspace(0, 12 / speed, 301), rtol=1e-9)
    assert np.abs(run["shaft.torque"]).max() == pytest.approx(100.0 * x + friction, rel=1e-3)  # at a sample
    assert run.energy.residual < 1e-8


@pytest.mark.long
def test_below_its_slip_inner_friction_only_stiffens():
    rig = _driven(gb.Hysteresis(friction=10.0, stiffness=60.0), 0.1)
    run = gb.simulate(rig, t=np.linspace(0, 20, 101), rtol=1e-10)
    assert run["shaft.torque"] == pytest.approx(-160.0 * run["shaft.twist"], abs=1e-8)
    assert run.energy.dissipated["shaft"] == 0.0


@pytest.mark.long
def test_a_swing_against_dry_friction_loses_the_same_amount_in_every_half_turn():
    J, k, friction, x = 2.0, 50.0, 1.0, 0.25
    rig = gb.Drivetrain("swing")
    shaft = gb.Shaft(k=k, hysteresis=gb.Hysteresis(friction=friction))
    rig.chain(rig.add("body", gb.Inertia(J=J, phi0=x)), rig.add("shaft", shaft), rig.add("ground", gb.Fixed()))
    run = gb.simulate(rig, t_end=10.0)
    half = np.pi * np.sqrt(J / k)
    turns = [e.t for e in run.events]
    ends = x - 2 * friction / k * np.arange(1, 7)  # 0.21, 0.17, ..., 0.01: the spring then holds no more than friction
    assert turns == pytest.approx(half * np.arange(1, 7), rel=1e-6)  # the default tolerance
    assert run["body.phi"][-1] == pytest.approx(ends[-1], abs=1e-6)
    assert run["body.w"][-1] == 0.0
    assert run.energy.dissipated["shaft"] == pytest.approx(k / 2 * (x**2 - ends[-1] ** 2), rel=1e-6)
    assert run["shaft.torque"][-1] == pytest.approx(0.0, abs=1e-15)  # at rest nothing acts on the body


def test_inner_friction_can_be_taken_away():
    rig = _driven(gb.Hysteresis(friction=1.0), 0.1)
    assert "shaft.hysteresis" in rig.effects()
    bare = rig.without("shaft.hysteresis")
    assert "hysteresis" not in gb.build(bare).program.source
    assert set(rig.without("shaft.compliance").effects()) == set()
