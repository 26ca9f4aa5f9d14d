"""A self-locking gear held against a screw with two flanks of stiff springs and Coulomb friction, integrated by scipy.

A screw of radius 1 and lead angle g turns by a, its nut (the wheel) by b, both pressed together by a normal force N1 on the
flank with which the screw drives, N2 on the other one:

    d = sin g (a - i b),    N1 = max(k d + c d', 0),    N2 = max(-k d - c d', 0)
    J1 a'' = -(N1 - N2) sin g - mu (N1 + N2) cos g,    J2 b'' = i tan g ((N1 - N2) cos g - mu (N1 + N2) sin g) + load

while both turn forward. With mu = tan p: eta1 = tan g/tan(g + p), eta2 = tan(g - p)/tan g. No law of the package is used.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gearblocks as gb

SPAN = 0.05


def _geometry(eta1, eta2):
    """Lead and friction angle of these efficiencies."""

    def friction(g):
        return np.arctan(np.tan(g) / eta1) - g

    def missed(g):
        return np.tan(g - friction(g)) - eta2 * np.tan(g)

    g = brentq(missed, 1e-3, 0.9)
    return g, friction(g)


def _screw(ratio, eta, J, load, k, pressed=0.0, span=SPAN):
    """(time, wheel speed) at the end, or where the screw comes to rest, from a wheel that turns at 1 rad/s; pressed: N2 at
    the start."""
    g, p = _geometry(*eta)
    mu, c = np.tan(p), 0.4 * np.sqrt(k * J[0])

    def rates(_t, y):
        a, b, wa, wb = y
        force = k * np.sin(g) * (a - ratio * b) + c * np.sin(g) * (wa - ratio * wb)
        one, two = max(force, 0.0), max(-force, 0.0)
        torque = ratio * np.tan(g) * ((one - two) * np.cos(g) - mu * (one + two) * np.sin(g))
        return [wa, wb, (-(one - two) * np.sin(g) - mu * (one + two) * np.cos(g)) / J[0], (torque + load) / J[1]]

    def rests(_t, y):
        return y[2]

    rests.terminal = True
    start = [0.0, pressed / (k * np.sin(g) * ratio), ratio, 1.0]
    found = solve_ivp(rates, (0.0, span), start, "Radau", events=rests, rtol=1e-9, atol=1e-13)
    return found.t[-1], found.y[3, -1]


def _train(ratio, eta, J, load, direction=1.0):
    rig = gb.Drivetrain("worm")
    screw, wheel = rig.add("screw", gb.Inertia(J=J[0])), rig.add("wheel", gb.Inertia(J=J[1], w0=direction))
    worm = rig.add("worm", gb.LossyGear(ratio=ratio, efficiency=eta))
    rig.chain(screw, worm, wheel, rig.add("load", gb.Torque(tau=load * direction)))
    return rig


WORMS = {
    "of the hard case": (30.0, (0.3, -0.2), 1e-3, 0.5),
    "of few starts": (10.0, (0.4, -0.3), 0.02, 1.0),
    "much friction": (15.0, (0.2, -0.8), 0.01, 0.8),
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.long] * (n == "of few starts")) for n in WORMS])
@pytest.mark.parametrize("load", [1.0, -1.0])
@pytest.mark.few(1)
def test_a_heavy_screw_has_the_one_motion_of_its_flanks(name, load):
    """J1 i^2 > -eta2 J2: also where the wheel pushes on, and J2 + i^2 J1/eta2 is below zero."""
    ratio, eta, *J = WORMS[name]
    alpha = load / (J[1] + ratio**2 * J[0] * eta[0]) if load < 0.0 else load / (J[1] + ratio**2 * J[0] / eta[1])
    assert alpha < 0.0  # a load along the motion brakes, since what it adds to the friction is more
    t, w = _screw(ratio, eta, J, load, k=1e7)
    assert t == SPAN and (w - 1.0) / t == pytest.approx(alpha, rel=2e-3)
    for direction in (1.0, -1.0):
        run = gb.simulate(_train(ratio, eta, J, load, direction), t_end=SPAN)
        assert direction * run["wheel.alpha"] == pytest.approx(alpha, rel=1e-9)
        assert (run["worm.loss_power"] > 0.0).all() and run.energy.residual < 1e-6


@pytest.mark.parametrize("name", WORMS)
@pytest.mark.few(1)
def test_a_light_screw_on_which_the_wheel_pushes_jams(name):
    """The stiffer its flanks the sooner it stands, as 1/sqrt(k): rigid ones have no acceleration."""
    ratio, eta, _, wheel = WORMS[name]
    J = (0.1 * -eta[1] * wheel / ratio**2, wheel)
    (soft, _), (stiff, _) = (_screw(ratio, eta, J, 1.0, k) for k in (1e8, 1e10))
    assert soft < SPAN and stiff < 0.15 * soft
    for direction in (1.0, -1.0):
        with pytest.raises(gb.SimulationError, match="'worm': no motion agrees with its losses: it jams") as caught:
            gb.simulate(_train(ratio, eta, J, 1.0, direction), t_end=SPAN)
        assert (caught.value.component, caught.value.time) == ("worm", 0.0)


@pytest.mark.parametrize("name", WORMS)
@pytest.mark.few(1)
def test_a_light_screw_against_a_load_has_two_motions_and_starts_in_neither(name):
    """By how its flanks are pressed at the start it is braked by the load alone, or stands at once."""
    ratio, eta, _, wheel = WORMS[name]
    J = (0.1 * -eta[1] * wheel / ratio**2, wheel)
    alpha = -1.0 / (wheel + ratio**2 * J[0] * eta[0])
    t, w = _screw(ratio, eta, J, -1.0, k=1e8)
    assert t == SPAN and (w - 1.0) / t == pytest.approx(alpha, rel=2e-3)
    assert _screw(ratio, eta, J, -1.0, k=1e8, pressed=50.0)[0] < 0.1 * SPAN
    for direction in (1.0, -1.0):
        with pytest.raises(gb.SimulationError, match="'worm': two motions agree with its losses") as caught:
            gb.simulate(_train(ratio, eta, J, -1.0, direction), t_end=SPAN)
        assert (caught.value.component, caught.value.time) == ("worm", 0.0)


@pytest.mark.long
def test_a_light_screw_that_begins_to_turn_by_its_own_drive_goes_on():
    """From rest the forces are continuous: the side that drives is the one that goes on, though the other would do."""
    ratio, eta, J, drive, load = 10.0, (0.4, -0.3), (3e-4, 1.0), 0.5, -1.0
    rig = gb.Drivetrain("hoist")
    rig.chain(rig.add("drive", gb.Torque(tau=drive * gb.time)), rig.add("screw", gb.Inertia(J=J[0])),
              rig.add("worm", gb.LossyGear(ratio=ratio, efficiency=eta)), rig.add("wheel", gb.Inertia(J=J[1])),
              rig.add("load", gb.Torque(tau=load)))  # fmt: skip
    run = gb.simulate(rig, t_end=1.0)
    begins = -load / (ratio * eta[0] * drive)
    rate = ratio * eta[0] * drive / (J[1] + ratio**2 * J[0] * eta[0])
    assert run["wheel.w"][-1] == pytest.approx(rate * (1.0 - begins) ** 2 / 2, rel=1e-6)
