"""A law that jumps against the motion on both sides of a limit: the motion stays there, as with a law that has a width."""

import pytest

import gearblocks as gb

TYRE = gb.TyreSlip(stiffness=1e5, grip=1.0, low_speed=0.1)


def _pushed(torque, w0=0.0):
    rig = gb.Drivetrain("two levels")
    rig.chain(rig.add("push", gb.Torque(tau=torque)), rig.add("j", gb.Inertia(J=1.0, w0=w0)))
    return rig


def _car(torque, **more):
    rig = gb.Drivetrain("car at rest")
    car = gb.Vehicle(mass=1000.0, wheel_radius=0.3, rolling=0.01, tyre=TYRE, **more)
    rig.chain(rig.add("push", gb.Torque(tau=torque)), rig.add("axle", gb.Inertia(J=1.0)), rig.add("car", car))
    return rig


W = gb.sense("j.w")


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize(
    ("torque", "w0", "at", "limit"),
    [
        (gb.piecewise((2, W < 1), (-1, True)), 0.0, 0.5, lambda t: 1.0),
        (gb.piecewise((3, W < 1), (-2, True)), 5.0, 2.0, lambda t: 1.0),
        (gb.piecewise((4 + gb.time, gb.time + W < 2), (-4, True)), 0.0, -5.0 + 29.0**0.5, lambda t: 2.0 - t),
    ],
)
@pytest.mark.few(1)
def test_a_torque_of_two_levels_holds_its_limit(torque, w0, at, limit, method):
    run = gb.simulate(_pushed(torque, w0), t_end=4.0, method=method)
    assert [e.after for e in run.events] == [0.5]
    assert run.events[0].t == pytest.approx(at, rel=1e-6)
    assert run["j.w"][-1] == pytest.approx(limit(4.0), abs=1e-8)


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
def test_a_jump_with_a_width_holds_the_speed(method):
    run = gb.simulate(_pushed(gb.Table([0.999, 1.001], [2.0, -1.0])(W)), t_end=2.0, method=method)
    assert run["j.w"][-1] == pytest.approx(0.999 + 0.002 * 2 / 3, rel=1e-6)  # where the line is 0


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", pytest.param("dp5", marks=pytest.mark.long), "dp8", "rodas"])
@pytest.mark.parametrize("torque", [0.0, pytest.param(20.0, marks=pytest.mark.long), -20.0])
@pytest.mark.few(1)
def test_a_car_on_slipping_tyres_is_held_by_rolling_resistance(torque, method):
    run = gb.simulate(_car(torque), t_end=1.0, method=method)
    assert abs(run["car.v"][-1]) < 1e-15
    # the tyres carry the torque at the slip that their stiffness asks for
    assert run["axle.w"][-1] * 0.3 / 0.1 == pytest.approx(torque / 0.3 / 1e5, rel=1e-3, abs=1e-12)


@pytest.mark.long
def test_a_car_on_slipping_tyres_moves_off_when_the_torque_is_above_its_rolling_resistance():
    run = gb.simulate(_car(60.0), t_end=1.0)
    rolling = 0.01 * 1000.0 * 9.80665
    assert run.events[-1].after == 1.0
    # once the tyres carry, mass and axle move as one
    assert run["car.v"][-1] == pytest.approx((60.0 / 0.3 - rolling) / (1000.0 + 1.0 / 0.09), rel=2e-2)


@pytest.mark.parametrize("torque", [20.0, -20.0, 25.0])
def test_a_car_on_slipping_tyres_creeps_as_its_rolling_speed_says(torque):
    run = gb.simulate(_car(torque, rolling_speed=1e-3), t_end=2.0)
    share = torque / 0.3 / (0.01 * 1000.0 * 9.80665)  # F = rolling m g v/sqrt(v^2 + rolling_speed^2)
    assert run["car.v"][-1] == pytest.approx(1e-3 * share / (1 - share**2) ** 0.5, rel=1e-4)


def test_where_a_friction_finds_no_mode_beside_a_relay_at_rest_the_relay_is_named_and_its_width_helps():
    """Relay, brake and bearing hold a body together; a load passes what both frictions hold of the relay's torque."""

    def run(relay):
        rig = gb.Drivetrain("three that hold")
        a, b = rig.add("a", gb.Inertia(J=0.712, phi0=0.0, w0=0.0)), rig.add("b", gb.Inertia(J=1.06, w0=0.93))
        rig.chain(a, rig.add("damper", gb.Damper(c=1.05)), b)
        push = gb.Torque(tau=gb.piecewise((1.56, gb.sin(5.01 * gb.time) < 0.0), (0.0, True)))
        holds = (rig.add("brake", gb.Brake(capacity=3.86)), rig.add("bearing", gb.BearingFriction(coulomb=0.0997)))
        rig.connect(rig.add("relay", gb.Torque(tau=relay)).flange, a.a, *(x.a for x in holds))
        rig.connect(rig.add("push", push).flange, b.b)
        return gb.simulate(rig, t_end=5.0)

    phi = gb.sense("a.phi")
    with pytest.raises(gb.SimulationError, match="the law of 'relay' jumps against the motion on both sides"):
        run(gb.piecewise((4.66, phi < 0), (-4.66, True)))
    assert abs(run(gb.Table([-1e-4, 1e-4], [4.66, -4.66])(phi))["a.phi"][-1]) < 1e-4
