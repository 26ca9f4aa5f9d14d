"""Freewheels, one-way clutches, dogs and synchronisers: closed forms of locking and letting go."""

import numpy as np
import pytest

import gearblocks as gb

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode before, mode after) of one element."""
    return [(e.t, e.before, e.after) for e in run.events if e.component == name]


# -- one way ----------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_a_freewheel_rectifies_an_oscillating_torque():
    rig = _chain(
        drive=gb.Torque(tau=gb.cos(gb.time)), one=gb.Inertia(J=1.0), wheel=gb.Freewheel(), two=gb.Inertia(J=1.0)
    )
    run = gb.simulate(rig, t=np.linspace(0, 20, 201), rtol=1e-11)
    # together until pi/2 with w = sin(t)/2; then b keeps 1/2, a falls back to sin(t) - 1/2 and meets it at 5 pi/2
    times = [np.pi / 2, 5 * np.pi / 2, 5 * np.pi / 2]
    found = [t for t, _, _ in _modes(run, "wheel")]
    assert found[0] == pytest.approx(times[0], rel=1e-9)
    after = run.t > np.pi / 2
    assert run["two.w"][after] == pytest.approx(0.5, abs=1e-9)
    assert run["one.w"][after] == pytest.approx(np.sin(run.t[after]) - 0.5, abs=1e-9)
    assert (run["wheel.w_rel"] >= -1e-9).all()


@pytest.mark.long
def test_a_one_way_clutch_drives_forward_whatever_the_torque():
    clutch = gb.OneWayClutch(mu=0.5, force_max=1.0, engagement=0.0)
    rig = _chain(drive=gb.Torque(tau=1e6), one=gb.Inertia(J=1.0), clutch=clutch, two=gb.Inertia(J=3.0))
    run = gb.simulate(rig, t=[1.0])
    assert run["clutch.torque"][0] == pytest.approx(0.75e6, rel=EXACT)
    assert run["clutch.w_rel"][0] == 0.0


@pytest.mark.long
@pytest.mark.parametrize("engagement", [0.0, 0.8])
def test_a_one_way_clutch_lets_b_ahead_beyond_its_break_away_torque(engagement):
    clutch = gb.OneWayClutch(mu=0.5, force_max=4.0, engagement=engagement, geometry=2.0, peak=1.5)
    rig = _chain(
        one=gb.Inertia(J=1.0), clutch=clutch, two=gb.Inertia(J=1.0), drive=gb.Torque(tau=gb.time)
    )  # half of the torque on b passes to a
    run = gb.simulate(rig, t=[10.0], rtol=1e-10)
    most = 1.5 * 0.5 * 2.0 * 4.0 * engagement if engagement else 1e-4 * 0.5 * 2.0 * 4.0
    ((t, before, after),) = _modes(run, "clutch")
    assert (before, after) == (0.0, 1.0)
    assert t == pytest.approx(2 * most, rel=1e-9)
    drag = 0.5 * 2.0 * 4.0 * engagement
    assert run["clutch.torque"][0] == -drag
    assert run["one.w"][0] == pytest.approx(t**2 / 4 + drag * (10 - t), rel=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("peak", [1.0, 1.6])
def test_a_one_way_clutch_of_a_given_capacity_lets_b_ahead_beyond_its_peak(peak):
    rig = _chain(
        one=gb.Inertia(J=1.0), clutch=gb.OneWayClutch(capacity=2.0, peak=peak),
        two=gb.Inertia(J=1.0), drive=gb.Torque(tau=gb.time),
    )  # fmt: skip
    run = gb.simulate(rig, t=[10.0], rtol=1e-10)
    ((t, before, after),) = _modes(run, "clutch")
    assert (before, after) == (0.0, 1.0)
    assert t == pytest.approx(2 * 2.0 * peak, rel=1e-9)  # half of the torque on b passes to a
    assert run["clutch.torque"][0] == -2.0
    assert run["one.w"][0] == pytest.approx(t**2 / 4 + 2.0 * (10 - t), rel=1e-8)


@pytest.mark.long
def test_a_one_way_clutch_with_a_capacity_and_none_breaks_away_at_zero():
    rig = _chain(
        one=gb.Inertia(J=1.0), clutch=gb.OneWayClutch(capacity=gb.piecewise((0.0, gb.time < 1), (2.0, True))),
        two=gb.Inertia(J=1.0), drive=gb.Torque(tau=1.0),
    )  # fmt: skip
    run = gb.simulate(rig, t=[0.5, 2.0])
    assert list(run["clutch.mode"]) == [1.0, 0.0]  # w_rel = 1 at 1 s falls by 3 per second
    assert run["clutch.torque"] == pytest.approx([0.0, -0.5], rel=EXACT)


# -- teeth ------------------------------------------------------------------------------------------------------------


def test_dogs_close_with_the_impulse_that_momentum_asks():
    J1, J2, w1, w2 = 1.0, 3.0, 10.0, -2.0
    engaged = gb.piecewise((0.0, gb.time < 1), (1.0, gb.time < 2), (0.0, True))
    rig = _chain(
        one=gb.Inertia(J=J1, w0=w1),
        dog=gb.DogClutch(engaged=engaged),
        two=gb.Inertia(J=J2, w0=w2),
        load=gb.Torque(tau=8.0),
    )
    run = gb.simulate(rig, t=[0.5, 1.5, 3.0])
    before = w2 + 8.0 / J2
    common = (J1 * w1 + J2 * before) / (J1 + J2)
    assert run["one.w"][1] == run["two.w"][1] == pytest.approx(common + 8.0 / 4 * 0.5, rel=EXACT)
    assert run["dog.impulse"] == pytest.approx([0.0, J2 * (common - before), J2 * (common - before)], rel=EXACT)
    assert run["dog.torque"] == pytest.approx([0.0, -8.0 / 4, 0.0], rel=EXACT)  # b is held back, a is taken along
    assert list(run["dog.mode"]) == [2.0, 0.0, 2.0]
    reduced = J1 * J2 / (J1 + J2)
    assert run.energy.dissipated["dog"] == pytest.approx(reduced * (w1 - before) ** 2 / 2, rel=EXACT)
    assert run.energy.residual < EXACT


def test_a_synchroniser_brings_to_one_speed_before_its_teeth_lock():
    cone = gb.piecewise((0.0, gb.time < 0.5), (4.0, gb.time < 3), (0.0, True))
    block = gb.Synchronizer(capacity=cone, engaged=gb.piecewise((0.0, gb.time < 1), (1.0, gb.time < 4), (0.0, True)))
    load = gb.Torque(tau=gb.piecewise((0.0, gb.time < 3), (900.0, True)))
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), sleeve=block, two=gb.Inertia(J=3.0), load=load)
    run = gb.simulate(rig, t=[0.4, 1.5, 2.0, 2.5, 3.5, 4.5])
    slip = -10.0 + 4.0 * (1 + 1 / 3) * (run.t[1:3] - 0.5)
    assert run["sleeve.w_rel"][:3] == pytest.approx([-10.0, *slip], rel=EXACT)  # the teeth wait
    assert list(run["sleeve.mode"]) == [2.0, -1.0, -1.0, 0.0, 0.0, 2.0]
    assert list(run["sleeve.w_rel"][3:5]) == [0.0, 0.0]
    assert run["sleeve.locked"][4] == 1.0
    assert run["sleeve.torque"][4] == pytest.approx(-900.0 / 4, rel=EXACT)  # far beyond the cone, which is gone
    assert run["one.w"][4] == pytest.approx(2.5 + 900.0 / 4 * 0.5, rel=EXACT)
    assert run.energy.dissipated["sleeve"] == pytest.approx(0.75 * 100 / 2, rel=1e-9)  # no impact
