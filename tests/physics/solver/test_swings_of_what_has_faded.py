"""What a stiff force brings to rest passes zero with the error of implicit steps: on which side of a condition it is
there depends on nothing, and nothing depends on it."""

import pytest

import gearblocks as gb

CHANGES = -0.332
W = gb.sense("disc.w")
LOADS = {
    "fan": gb.SpeedLoad(coeffs=(0.0, 0.0, 0.05)),
    "square of speed": gb.Torque(tau=-0.05 * W * abs(W)),
    "corner over speed": gb.Torque(tau=gb.piecewise((-0.02 * W, W > 0), (-0.05 * W, True))),
}
RUNS = [("rodas", 1e-3), ("rodas", 1e-6), ("rodas", 1e-8), ("auto", 1e-6)]


def braked_hub() -> tuple[gb.Drivetrain, gb.Inertia]:
    """A hub with dry friction that pulses drive, and a motion that shakes it through a spring."""
    rig = gb.Drivetrain("hub")
    hub = rig.add("hub", gb.Inertia(J=0.798))
    bearing = rig.add("bearing", gb.BearingFriction(coulomb=10.3))
    pulses = rig.add("pulses", gb.Torque(tau=gb.pulse(-42.1, period=1.23, duty=0.912, start=0.369)))
    steps = gb.piecewise((2.67, gb.sin(12.5 * gb.time) < CHANGES), (0.0, True))
    turn = rig.add("turn", gb.Angle(phi=steps, filter=14.1, filter_type="bessel"))
    shaft = rig.add("shaft", gb.Shaft(k=20.2))
    rig.connect(turn.flange, shaft.a)
    rig.connect(shaft.b, hub.a, bearing.a, pulses.flange)
    return rig, hub


def assert_runs_agree(rig: gb.Drivetrain, name: str, method: str, rtol: float) -> None:
    fine = gb.simulate(rig, t_end=2.0, method="dp8", rtol=1e-9)
    run = gb.simulate(rig, t_end=2.0, method=method, rtol=rtol)
    assert run[name][-1] == pytest.approx(fine[name][-1], rel=100 * rtol)
    assert len(run.events) < 80
    assert run.stats.steps < 1000


@pytest.mark.parametrize(("method", "rtol"), RUNS)
@pytest.mark.parametrize("stiffness", [40.0, 81.3, 300.0])
@pytest.mark.few(2)
def test_a_car_that_its_tyre_brings_to_rest_has_no_side_of_its_drag(stiffness, method, rtol):
    rig, hub = braked_hub()
    car = rig.add("car", gb.Chassis(mass=0.5, drag_area=1.0))
    tyre = rig.add("tyre", gb.Tyre(radius=0.3, grip=0.224, normal_force=4.9, stiffness=stiffness, low_speed=0.111))
    rig.connect(hub.b, tyre.wheel)
    rig.connect(car.a, tyre.vehicle)
    assert_runs_agree(rig, "car.s", method, rtol)


@pytest.mark.parametrize(("method", "rtol"), RUNS)
@pytest.mark.parametrize("c", [1.0, 20.0, 100.0])
@pytest.mark.parametrize("load", LOADS)
@pytest.mark.few(2)
def test_a_disc_that_oil_brings_to_rest_has_no_side_of_its_load(load, c, method, rtol):
    rig, hub = braked_hub()
    disc = rig.add("disc", gb.Inertia(J=0.045))
    oil = rig.add("oil", gb.Damper(c=c))
    rig.connect(hub.b, oil.a)
    rig.connect(oil.b, disc.a, rig.add("load", LOADS[load]).flange)
    assert_runs_agree(rig, "disc.phi", method, rtol)
