"""Feedback of accelerations, constraint forces, reactions of ties, and powers: with a state between they are read behind the
motion; without one the algebraic loop is named."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb
from gearblocks.errors import ModelError


class Sum(gb.Block):
    """The integral of a signal."""

    u = gb.signal("what is added up")
    y = gb.State("sum")

    def physics(self, s):
        yield gb.Rate(s.y, s.u)
        yield gb.Shows("y", s.y)


def _with_sum(path, middle, *, behind=None):
    """A driven body, something in the middle, another body; and the integral of an output."""
    rig = gb.Drivetrain("summed")
    drive = rig.add("drive", gb.Torque(tau=5 * gb.sin(3 * gb.time)))
    one, two = rig.add("one", gb.Inertia(J=0.5)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(drive, one, rig.add("middle", middle), two)
    if behind is not None:
        rig.chain(two, rig.add("behind", behind), rig.add("three", gb.Inertia(J=0.3)))
    rig.add("sum", Sum(u=gb.sense(path)))
    return rig


# -- integrals that are known ---------------------------------------------------------------------------------------------


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "middle",
    [
        gb.Shaft(k=50.0, c=0.1),
        gb.Clutch(capacity=3.0),
        gb.IdealGear(ratio=2),
        gb.LossyGear(ratio=2, efficiency=(0.9, 0.8)),
    ],
)
def test_the_integral_of_an_acceleration_is_the_speed(middle):
    run = gb.simulate(_with_sum("one.alpha", middle), t_end=3.0, rtol=1e-10)
    assert np.allclose(run["sum.y"], run["one.w"], rtol=0, atol=2e-8)
    assert run.energy.residual < 1e-9


@pytest.mark.few(1)
@pytest.mark.parametrize(
    ("path", "middle"),
    [
        ("middle.b.tau", gb.Shaft(k=50.0, c=0.1)),
        ("middle.torque", gb.Clutch(capacity=3.0)),  # a constraint force while it is stuck
        ("middle.torque", gb.Shaft(rigid=True)),  # the reaction of a tie
        ("middle.torque", gb.IdealGear(ratio=2)),
        ("middle.torque", gb.LossyGear(ratio=2, efficiency=(0.9, 0.8))),
    ],
)
def test_the_integral_of_a_torque_is_the_momentum_behind_it(path, middle):
    run = gb.simulate(_with_sum(path, middle), t_end=3.0, rtol=1e-10)
    assert abs(run["two.w"]).max() > 1.0
    assert np.allclose(run["sum.y"], 1.0 * run["two.w"], rtol=0, atol=2e-8)


@pytest.mark.long
def test_the_torques_at_both_ends_of_a_body_take_away_its_momentum():
    """tau: what the body does to its flanges; of a vehicle at its one."""
    rig = _with_sum("two.alpha", gb.Shaft(k=50.0, c=0.1))
    car = rig.add("car", gb.Vehicle(mass=2.0, wheel_radius=0.5))
    rig.connect(rig["two"].b, rig.add("axle", gb.Shaft(k=80.0)).a)
    rig.connect(rig["axle"].b, car.flange)
    rig.add("both", Sum(u=gb.sense("two.a.tau") + gb.sense("two.b.tau")))
    rig.add("wheels", Sum(u=gb.sense("car.flange.tau")))
    run = gb.simulate(rig, t_end=3.0, rtol=1e-10)
    assert abs(run["two.w"]).max() > 1.0 and abs(run["car.flange.w"]).max() > 1.0
    assert np.allclose(run["both.y"], -1.0 * run["two.w"], rtol=0, atol=2e-8)
    assert np.allclose(run["wheels.y"], -2.0 * 0.25 * run["car.flange.w"], rtol=0, atol=2e-8)


@pytest.mark.parametrize("middle", [gb.Shaft(k=50.0, c=0.1), gb.Shaft(rigid=True), gb.Clutch(capacity=3.0)])
@pytest.mark.few(1)
def test_the_integral_of_a_power_is_the_energy_behind_it(middle):
    run = gb.simulate(_with_sum("middle.b.power", middle), t_end=3.0, rtol=1e-10)
    assert np.allclose(run["sum.y"], run["two.kinetic_energy"], rtol=0, atol=2e-8)


@pytest.mark.long
def test_a_reaction_passes_through_a_gear_while_a_clutch_behind_sticks_and_slips():
    run = gb.simulate(
        _with_sum("middle.torque", gb.IdealGear(ratio=2), behind=gb.Clutch(capacity=0.3)), t_end=3.0, rtol=1e-10
    )
    assert {0.0, 1.0} <= set(np.abs(run["behind.mode"]))
    assert np.allclose(run["sum.y"], run["two.w"] + 0.3 * run["three.w"], rtol=0, atol=2e-8)


# -- loops that a state opens ---------------------------------------------------------------------------------------------


def test_a_motor_whose_voltage_follows_an_acceleration_is_that_of_scipy():
    rig = gb.Drivetrain("motor")
    motor = gb.DCMotor(R=0.5, L=1e-2, k=0.1, u=12.0 - 0.01 * gb.sense("rotor.alpha"))
    rig.chain(rig.add("motor", motor), rig.add("rotor", gb.Inertia(J=0.01)))
    run = gb.simulate(rig, t_end=1.0, rtol=1e-10)

    def rates(_, y):
        i, w = y
        alpha = 0.1 * i / 0.01
        return [(12.0 - 0.01 * alpha - 0.5 * i - 0.1 * w) / 1e-2, alpha]

    found = solve_ivp(rates, (0, 1), [0, 0], "DOP853", rtol=1e-12, atol=1e-12)
    assert run["rotor.w"][-1] == pytest.approx(found.y[1, -1], rel=1e-9)
    assert run.energy.residual < 1e-9


def test_the_power_of_a_flange_that_a_law_gives_may_drive_a_torque_by_every_method():
    rig = gb.Drivetrain("power feedback")
    drive = rig.add("drive", gb.Torque(tau=5.0 - 0.01 * gb.sense("shaft.b.power")))
    one, two = rig.add("one", gb.Inertia(J=0.5)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(drive, one, rig.add("shaft", gb.Shaft(k=50.0, c=0.5)), two)

    def rates(_, y):
        twist, a, b = y
        torque = -50.0 * twist - 0.5 * (b - a)
        return [b - a, (5.0 - 0.01 * torque * b - torque) / 0.5, torque / 1.0]

    found = solve_ivp(rates, (0, 2), [0, 0, 0], "DOP853", rtol=1e-12, atol=1e-12)
    for method in ("dp8", "rodas"):
        run = gb.simulate(rig, t_end=2.0, rtol=1e-10, method=method)
        assert run["two.w"][-1] == pytest.approx(found.y[2, -1], rel=1e-8)
        assert np.array_equal(run["drive.torque"], 5.0 - 0.01 * run["shaft.b.power"])


# -- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", ["disc.alpha", "lock.torque", "disc.a.power"])
def test_an_algebraic_loop_is_named(path):
    rig = gb.Drivetrain("loop")
    drive, disc = rig.add("drive", gb.Torque(tau=5.0 - 0.1 * gb.sense(path))), rig.add("disc", gb.Inertia(J=0.5))
    rig.chain(drive, disc, rig.add("lock", gb.Clutch(capacity=2.0)), rig.add("end", gb.Inertia(J=1.0)))
    with pytest.raises(ModelError, match=rf"algebraic loop drive -> {path} -> drive; let a state stand between"):
        gb.build(rig)


def test_an_acceleration_beside_a_shaft_without_inertia_is_refused():
    rig = _with_sum("one.alpha", gb.Shaft(k=50.0, c=0.1), behind=gb.Shaft(k=10.0, c=0.1))
    end = rig.add("end", gb.Inertia(J=0.0))
    rig.chain(
        rig["three"],
        rig.add("spring", gb.Shaft(k=3.0, c=0.1)),
        end,
        rig.add("last", gb.Damper(c=1.0)),
        rig.add("wall", gb.Fixed()),
    )
    with pytest.raises(ModelError, match="shaft without inertia, which has no acceleration of its own"):
        gb.build(rig)


def test_an_output_that_no_block_shows_is_still_refused_with_the_near_one():
    with pytest.raises(ModelError, match=r"sense\('middle.b.powr'\): no block shows that output"):
        gb.build(_with_sum("middle.b.powr", gb.Shaft(k=1.0)))
