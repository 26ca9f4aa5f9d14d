"""Laws that change at speed 0 on a shaft that a brake holds there: rounding of the speed is no reversal."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas", "auto"]
RATIO, J_CARRIER, J_RING = 2.5, 0.5, 0.4


def _planetary(capacity=7.0, *, w0=0.0):
    """A planetary set whose sun is braked, 3 sin(5 t) N m on its carrier."""
    rig = gb.Drivetrain("planetary")
    gear = rig.add("gear", gb.IdealPlanetary(ratio=RATIO))
    sun, carrier, ring = (
        rig.add(name, gb.Inertia(J=J)) for name, J in (("sun", 0.2), ("carrier", J_CARRIER), ("ring", J_RING))
    )
    for body, flange in ((sun, gear.sun), (carrier, gear.carrier), (ring, gear.ring)):
        rig.connect(body.b, flange)
    rig.connect(rig.add("brake", gb.Brake(capacity=capacity)).a, sun.a)
    rig.connect(rig.add("drive", gb.Torque(tau=3 * gb.sin(5 * gb.time))).flange, carrier.a)
    return rig, sun


def _carrier_speed(t, extra=0.0):
    """With the sun at rest the ring turns (1 + ratio)/ratio times as fast as the carrier."""
    return 3 * (1 - np.cos(5 * t)) / (5 * (J_CARRIER + J_RING * (1 + 1 / RATIO) ** 2 + extra))


LOADS = {
    "without a dry part": gb.SpeedLoad(coeffs=(0.0, 0.75, 0.125)),
    "square alone": gb.SpeedLoad(coeffs=(0.0, 0.0, 2.0)),
    "with a dry part": gb.SpeedLoad(coeffs=(0.3, 0.0, 0.5)),
    "vehicle": gb.Vehicle(mass=50.0, wheel_radius=0.3, drag_area=0.7, rolling=0.01),
    "condition": gb.Torque(tau=gb.piecewise((-0.5, gb.sense("sun.w") > 0), (0.5, True))),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", LOADS)
@pytest.mark.few(1)
def test_a_load_on_a_held_sun_sees_no_reversal(name, method):
    rig, sun = _planetary()
    rig.connect(rig.add("load", LOADS[name]).flange, sun.a)
    t = np.linspace(0.0, 5.0, 26)
    run = gb.simulate(rig, t=t, method=method, rtol=1e-7)
    assert run.events == ()
    assert run["carrier.w"] == pytest.approx(_carrier_speed(t), abs=1e-5)
    assert np.max(np.abs(run["sun.w"])) < 1e-14


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_load_on_a_sun_that_comes_loose_and_is_caught_again_turns_each_way_once(method):
    """The brake holds until 1 s, is open until 2 s and catches the sun again; the load's mode changes with its speed alone."""
    capacity = gb.piecewise((7.0, gb.time < 1), (0.0, gb.time < 2), (7.0, True))
    rig, sun = _planetary(capacity)
    rig.connect(rig.add("load", gb.SpeedLoad(coeffs=(0.0, 0.75, 0.125))).flange, sun.a)
    run = gb.simulate(rig, t_end=5.0, method=method, rtol=1e-8)
    fine = gb.simulate(rig, t_end=5.0, method="dp8", rtol=1e-10, max_step=1e-2)
    assert run["carrier.w"][-1] == pytest.approx(fine["carrier.w"][-1], rel=1e-5)
    turns = [e for e in run.events if e.component.startswith("load")]
    free = (fine.t > 1) & (fine.t < 2.5)
    signs = np.sign(fine["sun.w"][free][np.abs(fine["sun.w"][free]) > 1e-9])
    assert len(turns) <= 2 + np.count_nonzero(np.diff(signs))


@pytest.mark.long
@pytest.mark.parametrize(("capacity", "coeffs"), [(7.0, (0.75, 0.125)), (11.3, (0.31, 0.0)), (5.9, (0.0, 0.47))])
@pytest.mark.parametrize(("method", "rtol"), [("dp8", 1e-9), ("dp8", 1e-10), ("dp8", 1e-11), ("dp5", 1e-10)])
def test_a_sun_that_comes_loose_starts_at_any_tolerance(capacity, coeffs, method, rtol):
    """What lets go at a given time has no scale and no rounding of its own yet: own equations of the free sun from there."""
    rig, sun = _planetary(gb.piecewise((capacity, gb.time < 1), (0.0, True)))
    rig.connect(rig.add("load", gb.SpeedLoad(coeffs=(0.0, *coeffs))).flange, sun.a)
    run = gb.simulate(rig, t=[0.0, 1.0, 1.4], method=method, rtol=rtol)
    of_carrier, of_sun = 1 + 1 / RATIO, -1 / RATIO
    coupled = J_RING * of_carrier * of_sun
    mass = [[J_CARRIER + J_RING * of_carrier**2, coupled], [coupled, 0.2 + J_RING * of_sun**2]]

    def rates(t, w):
        load = np.sign(w[1]) * (coeffs[0] * abs(w[1]) + coeffs[1] * w[1] ** 2)
        return np.linalg.solve(mass, [3 * np.sin(5 * t), -load])

    free = solve_ivp(rates, (1.0, 1.4), [_carrier_speed(1.0), 0.0], method="DOP853", rtol=1e-11, atol=1e-13)
    assert [run["carrier.w"][-1], run["sun.w"][-1]] == pytest.approx(free.y[:, -1], rel=1e-7)
