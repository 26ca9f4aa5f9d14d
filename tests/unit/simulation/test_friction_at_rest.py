"""Static starts with friction and stops: what is stuck carries what balance asks of it, within its limit."""

import numpy as np
import pytest

import gearblocks as gb

EXACT = 1e-12
"""Of balances of a few torques."""


def _held_shaft(capacity, load=10.0, **start):
    """A brake, a disc, a shaft, a disc and a load in a row."""
    rig = gb.Drivetrain("held")
    one, two = rig.add("one", gb.Inertia(J=1.0, **start)), rig.add("two", gb.Inertia(J=2.0, **start))
    shaft = rig.add("shaft", gb.Shaft(k=1e3, c=1.0))
    rig.chain(rig.add("brake", gb.Brake(capacity=capacity)), one, shaft, two, rig.add("load", gb.Torque(tau=load)))
    return rig


def test_a_held_brake_carries_the_load_and_the_shaft_is_wound_up():
    run = gb.simulate(_held_shaft(20.0), t_end=100.0, initial="static")
    assert run.events == ()
    assert run["shaft.twist"] == pytest.approx(0.01, rel=EXACT)
    assert run["brake.torque"] == pytest.approx(10.0, rel=EXACT)
    for still in ("one.w", "two.w", "brake.phi_rel"):
        assert np.all(run[still] == 0.0), still
    assert run["one.phi"][-1] == run["one.phi"][0] == 0.0
    assert run["two.phi"][-1] == run["two.phi"][0]  # nothing drifts, not by a bit


@pytest.mark.long
def test_a_shaft_that_a_brake_holds_by_its_far_end_turns_its_near_end():
    rig = gb.Drivetrain("far")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    load, brake = rig.add("load", gb.Torque(tau=10.0)), rig.add("brake", gb.Brake(capacity=20.0))
    rig.chain(load, one, rig.add("shaft", gb.Shaft(k=1e3)), two, brake)
    run = gb.simulate(rig, t_end=1.0, initial="static")
    assert run["two.phi"] == pytest.approx(0.0, abs=1e-17)
    assert run["one.phi"] == pytest.approx(0.01, rel=EXACT)
    assert run["brake.torque"] == pytest.approx(10.0, rel=EXACT)


def test_a_brake_that_is_too_weak_is_named_with_what_it_would_have_to_carry():
    with pytest.raises(gb.SimulationError, match=r"'brake'.*would have to carry 10 N m to stay stuck, and holds 5 N m"):
        gb.simulate(_held_shaft(5.0), t_end=1.0, initial="static")


def test_what_slides_at_the_start_acts_with_its_friction():
    run = gb.simulate(_held_shaft(4.0, w0=3.0), t_end=0.1, initial="static")
    acceleration = (10.0 - 4.0) / 3.0
    assert run["brake.torque"] == pytest.approx(4.0, rel=EXACT)
    assert run["shaft.twist"][0] == pytest.approx((4.0 + 1.0 * acceleration) / 1e3, rel=EXACT)
    assert run["shaft.twist"][-1] == pytest.approx(run["shaft.twist"][0], rel=1e-9)  # a steady state of deflections
    assert run["two.alpha"][0] == pytest.approx(acceleration, rel=EXACT)


@pytest.mark.long
def test_a_stuck_clutch_in_a_loop_of_shafts_keeps_what_it_has_and_shares_by_stiffness():
    rig = gb.Drivetrain("loop")
    one, two, three = (rig.add(n, gb.Inertia(J=1.0)) for n in ("one", "two", "three"))
    rig.chain(rig.add("load", gb.Torque(tau=12.0)), one, rig.add("near", gb.Shaft(k=100.0)), two)
    rig.chain(two, rig.add("far", gb.Shaft(k=300.0)), three)
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=50.0)), three)
    rig.chain(three, rig.add("ground", gb.Shaft(k=60.0)), rig.add("wall", gb.Fixed()))
    run = gb.simulate(rig, t_end=0.5, initial="static")
    assert run["ground.twist"] == pytest.approx(-0.2, rel=EXACT)
    assert run["near.twist"] == pytest.approx(0.0, abs=1e-15)  # the load goes through the clutch, past the second disc
    assert run["clutch.torque"] == pytest.approx(12.0, rel=EXACT)


def test_a_clutch_that_slides_lets_through_its_friction():
    rig = gb.Drivetrain("drag")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=5.0)), rig.add("two", gb.Inertia(J=2.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=3.0)), two)
    rig.chain(two, rig.add("shaft", gb.Shaft(k=60.0, c=1.0)), rig.add("wall", gb.Fixed()))
    with pytest.warns(gb.GearblocksWarning, match="'clutch' slips with 3 N m at 5 rad/s"):  # it brakes the one side
        run = gb.simulate(rig, t_end=0.2, initial="static")
    assert run["shaft.torque"][0] == pytest.approx(3.0, rel=EXACT)
    assert run["shaft.twist"] == pytest.approx(-0.05, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(("load", "one", "push"), [(2.0, 0.04, 0.0), (10.0, 0.1, -5.0), (-2.0, -0.04, 0.0)])
def test_a_load_presses_a_spring_as_far_as_a_stop(load, one, push):
    rig = gb.Drivetrain("stop")
    near, far = rig.add("near", gb.Inertia(J=1.0)), rig.add("far", gb.Inertia(J=2.0))
    stop = rig.add("stop", gb.HardStop(lower=-0.1, upper=0.1, restitution=0.5))
    rig.chain(
        rig.add("wall", gb.Fixed()), rig.add("soft", gb.Shaft(k=50.0)), near, rig.add("shaft", gb.Shaft(k=1e3)), far
    )
    rig.chain(far, rig.add("load", gb.Torque(tau=load)))
    rig.connect(stop.a, near.a)
    run = gb.simulate(rig, t_end=1.0, initial="static")
    assert run.events == ()
    assert run["near.phi"] == pytest.approx(one, rel=EXACT)
    assert run["shaft.twist"] == pytest.approx(load / 1e3, rel=EXACT)
    assert run["stop.torque"] == pytest.approx(push, rel=EXACT, abs=1e-12)


@pytest.mark.long
@pytest.mark.parametrize(("load", "twist"), [(6.0, 0.1), (-6.0, 0.0)])
def test_a_freewheel_carries_one_way_only(load, twist):
    """It drives b forward (w_b < w_a is prevented): a load on a goes through it, or turns a freely."""
    rig = gb.Drivetrain("one way")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    rig.chain(rig.add("load", gb.Torque(tau=load)), one, rig.add("wheel", gb.Freewheel()), two)
    rig.chain(two, rig.add("shaft", gb.Shaft(k=60.0)), rig.add("wall", gb.Fixed()))
    run = gb.simulate(rig, t_end=0.1, initial="static")
    assert abs(run["shaft.twist"][0]) == pytest.approx(twist, rel=EXACT)
    assert run["wheel.mode"][0] == (0.0 if twist else 1.0)
    assert run["shaft.twist"][-1] == pytest.approx(run["shaft.twist"][0], rel=1e-9)


def test_friction_alone_holds_a_train_without_drift():
    """Two discs on a slope of torques, held by a clutch and a brake that share nothing but the shaft."""
    rig = gb.Drivetrain("parked")
    one, two, three = (rig.add(n, gb.Inertia(J=1.0)) for n in ("one", "two", "three"))
    rig.chain(rig.add("push", gb.Torque(tau=7.0)), one, rig.add("clutch", gb.Clutch(capacity=20.0)), two)
    rig.chain(two, rig.add("shaft", gb.Shaft(k=90.0)), three, rig.add("pull", gb.Torque(tau=2.0)))
    rig.connect(rig.add("brake", gb.Brake(capacity=15.0)).a, three.a)
    run = gb.simulate(rig, t_end=1e4, initial="static")
    assert run.events == ()
    assert run["clutch.torque"] == pytest.approx(7.0, rel=EXACT)
    assert run["brake.torque"] == pytest.approx(9.0, rel=EXACT)
    for name in ("one.phi", "two.phi", "three.phi", "clutch.phi_rel", "brake.phi_rel"):
        assert np.ptp(run[name]) == 0.0, name


@pytest.mark.long
def test_static_at_start_balances_what_acts_at_that_instant():
    rig = gb.Drivetrain("driven")
    one = rig.add("one", gb.Inertia(J=1.0))
    two = rig.add("two", gb.Inertia(J=2.0))
    load = rig.add("load", gb.Torque(tau=5.0 + 3.0 * gb.cos(2 * gb.time)))
    rig.chain(rig.add("brake", gb.Brake(capacity=20.0)), one, rig.add("shaft", gb.Shaft(k=1e3)), two, load)
    mean, now = (gb.simulate(rig, t_end=1e-3, initial=x) for x in ("static", "static_at_start"))
    assert mean["shaft.twist"][0] == pytest.approx(5e-3, rel=EXACT)
    assert now["shaft.twist"][0] == pytest.approx(8e-3, rel=EXACT)
    assert now["brake.torque"][0] == pytest.approx(8.0, rel=EXACT)


@pytest.mark.long
def test_a_rigid_train_that_a_brake_cannot_hold_is_named():
    rig = gb.Drivetrain("rigid")
    one = rig.add("one", gb.Inertia(J=1.0))
    rig.chain(rig.add("load", gb.Torque(tau=5.0)), one, rig.add("brake", gb.Brake(capacity=3.0)))
    with pytest.raises(gb.SimulationError, match=r"'brake'.*carry 5 .*holds 3"):
        gb.simulate(rig, t_end=1.0, initial="static")


@pytest.mark.long
@pytest.mark.parametrize("torque", [1.0, -1.0, 20.0])
def test_where_all_is_stuck_everything_stays_where_it_stands(torque):
    rig = gb.Drivetrain("hoist")
    shaft, a = rig.add("shaft", gb.Shaft(k=10.0)), rig.add("a", gb.Inertia(J=1.0))
    worm, b = rig.add("worm", gb.Worm(ratio=10.0, lead_angle=0.1, friction=0.2)), rig.add("b", gb.Inertia(J=1.0))
    rig.chain(rig.add("ground", gb.Fixed()), shaft, a, worm, b, rig.add("load", gb.Torque(tau=torque)))
    run = gb.simulate(rig, t_end=1.0, initial="static")
    assert abs(run["b.phi"]).max() == 0.0
    assert abs(run["shaft.torque"]).max() == 0.0


@pytest.mark.long
def test_a_brake_on_a_single_body_has_nothing_to_solve():
    rig = gb.Drivetrain("block")
    rig.chain(
        rig.add("load", gb.Torque(tau=1.0)), rig.add("a", gb.Inertia(J=1.0)), rig.add("brake", gb.Brake(capacity=2.0))
    )
    run = gb.simulate(rig, t_end=1.0, initial="static")
    assert abs(run["a.phi"]).max() == 0.0
    assert abs(run["brake.torque"] - 1.0).max() < 1e-12


def test_a_static_start_behind_a_slipping_clutch_says_that_it_accelerates():
    def rig(w0, **clutch):
        rig = gb.Drivetrain("slips")
        motor, load = rig.add("motor", gb.Inertia(J=0.1, w0=w0)), rig.add("load", gb.Inertia(J=0.3, w0=0.0))
        far, clutch = rig.add("far", gb.Inertia(J=0.3, w0=0.0)), rig.add("clutch", gb.Clutch(**clutch))
        rig.chain(
            rig.add("drive", gb.Torque(tau=5.0)), motor, clutch, load, rig.add("shaft", gb.Shaft(k=500.0, c=1.0)), far
        )
        return rig

    with pytest.warns(
        gb.GearblocksWarning, match=r"'clutch' slips with 10 N m at 10 rad/s, .*accelerated from the start;"
    ):
        run = gb.simulate(rig(10.0, capacity=10.0), t_end=0.1, initial="static")
    assert run["shaft.twist"] == pytest.approx(-0.01)  # wound up by the half of the 10 N m that goes on to the far body
    gb.simulate(rig(0.0, capacity=10.0), t_end=0.1, initial="static")  # stuck
    gb.simulate(rig(10.0, capacity=0.0), t_end=0.1, initial="static")  # released
