"""Lossy gears at rest with nothing to carry, several springs from the load: which way they begin to slide is in no force yet.

The evidence is linear: a gear that drives throughout is an inertia J/(ratio^2 eta) on its shaft a, and the chain is integrated
in numpy, from the corner of the load on.
"""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

T_END, RATIO, ETA, DRIVEN = 0.15, 0.5, 0.89, 0.278
LOADS = {  # of gearblocks, the same in numpy, and where it begins
    "constant": (-5.0, lambda t: -5.0, 0.0),
    "ramp": (-50.0 * gb.time, lambda t: -50.0 * t, 0.0),
    "soft": (5.0 * (1.0 - gb.cos(20.0 * gb.time)), lambda t: 10.0 * np.sin(10.0 * t) ** 2, 0.0),
    "later": (gb.Table([0, 0.07, 1], [0, 0, -18.6]), lambda t: -20.0 * max(t - 0.07, 0.0), 0.07),
}
METHODS = (("auto", 1e-6), ("dp5", 1e-9), ("dp8", 1e-10), ("rodas", 1e-8))


def _chain(springs, tau, last, stop=None):
    rig = gb.Drivetrain("train")
    bodies = [rig.add(f"j{i}", gb.Inertia(J=0.2 if i == 0 else 0.02)) for i in range(springs + 1)]
    for i, (left, right) in enumerate(pairwise(bodies)):
        rig.chain(left, rig.add(f"s{i}", gb.Shaft(k=290.0, c=0.25)), right)
    rig.connect(rig.add("motor", gb.Torque(tau=tau)).flange, bodies[0].a)
    driven = rig.add("driven", gb.Inertia(J=DRIVEN))
    rig.chain(bodies[-1], rig.add("gear", last), driven)
    if stop:
        rig.connect(rig.add("stop", stop).a, driven.b)
    return rig


def _in_numpy(springs, tau, begins, eta):
    inertia = np.array([0.2] + springs * [0.02])
    inertia[-1] += DRIVEN / (RATIO**2 * eta)
    n = len(inertia)

    def rates(t, y):
        torque = 290.0 * np.diff(y[:n]) + 0.25 * np.diff(y[n:])
        return np.concatenate([y[n:], (np.concatenate([torque, [0]]) - np.concatenate([[-tau(t)], torque])) / inertia])

    run = solve_ivp(rates, (begins, T_END), np.zeros(2 * n), method="DOP853", rtol=1e-12, atol=1e-18)
    return run.y[-1, -1] / RATIO


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("springs", [1, *(pytest.param(n, marks=pytest.mark.long) for n in (2, 3)), 5])
@pytest.mark.few(1)
def test_a_gear_begins_to_slide_the_way_that_the_load_comes(springs, load):
    tau, same, begins = LOADS[load]
    rig = _chain(springs, tau, gb.LossyGear(ratio=RATIO, efficiency=(ETA, 0.76)))
    true = _in_numpy(springs, same, begins, ETA)
    for method, rtol in METHODS:
        run = gb.simulate(rig, t_end=T_END, method=method, rtol=rtol)
        assert abs(run["driven.w"][-1] / true - 1.0) < 20.0 * rtol, method
        first = [event for event in run.events if event.t == begins and event.component == "gear"]
        assert len(first) <= (begins > 0.0), method


@pytest.mark.long
@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("limits", [{"upper": 0.0, "lower": -3.0}, {"upper": 3.0, "lower": 0.0}])
def test_a_stop_beside_it_opens_or_holds(sign, limits):
    gear, stop = gb.LossyGear(ratio=RATIO, efficiency=(ETA, 0.76)), gb.HardStop(restitution=0.0, **limits)
    rig = _chain(2, 5.0 * sign, gear, stop)
    opens = sign > 0.0 if limits["upper"] > 0.0 else sign < 0.0
    true = _in_numpy(2, lambda t: 5.0 * sign, 0.0, ETA) if opens else 0.0
    for method, rtol in METHODS:
        run = gb.simulate(rig, t_end=T_END, method=method, rtol=rtol)
        assert abs(run["driven.w"][-1] - true) <= 20.0 * rtol * abs(true), method


def _play_in_numpy(tau, dry, eta):
    """The speed behind a gear that drives: play without a gap is a spring, a bearing that turns a torque."""
    inertia = np.array([1.0, 0.5, 0.4, 1.0 + 0.8 / eta])
    springs = np.array([[0, 1, 40.0], [1, 2, 2.0], [0, 3, 1.0], [2, 3, 3.0]])

    def rates(t, y):
        torque = np.array([tau(t) - dry, 0.0, 0.0, 0.0])
        for i, j, k in springs:
            pull = k * (y[int(j)] - y[int(i)])
            torque[int(i)] += pull
            torque[int(j)] -= pull
        return np.concatenate([y[4:], torque / inertia])

    return rates


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "eta"), [(1.0, 0.7), (-0.5, 0.674)])
@pytest.mark.parametrize("dry", [0.0, 0.2, 0.02])
def test_play_without_a_gap_beside_it_closes_the_way_that_it_begins_to_slide(dry, ratio, eta):
    """Which flank carries is told once the gear slides; that it slides, and that the bearing has let go, stays so."""
    rig = gb.Drivetrain("closed play")
    bodies = [rig.add(f"j{i}", gb.Inertia(J=J)) for i, J in enumerate((1.0, 0.5, 0.4, 1.0))]
    driven = rig.add("driven", gb.Inertia(J=0.8 * ratio**2))
    for i, j, part in ((0, 1, gb.Shaft(k=40.0)), (1, 2, gb.Shaft(k=2.0)), (0, 3, gb.Shaft(k=1.0)),
                       (2, 3, gb.Lash(k=3.0, half_gap=0.0))):  # fmt: skip
        rig.chain(bodies[i], rig.add(f"s{i}{j}", part), bodies[j])
    gear = rig.add("gear", gb.LossyGear(ratio=ratio, efficiency=(eta, eta)))
    rig.connect(gear.a, bodies[3].b)
    rig.connect(gear.b, driven.a)
    rig.connect(rig.add("motor", gb.Torque(tau=10.5 * gb.time if dry else 1.0)).flange, bodies[0].a)
    if dry:
        rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=dry)).a, bodies[0].b)
    rates = _play_in_numpy((lambda t: 10.5 * t) if dry else (lambda t: 1.0), dry, eta)
    true = solve_ivp(rates, (dry / 10.5, 0.3), np.zeros(8), "DOP853", rtol=1e-12, atol=1e-16).y[4:, -1]
    for method, rtol in METHODS:
        run = gb.simulate(rig, t_end=0.3, method=method, rtol=rtol)
        assert [run[f"j{i}.w"][-1] for i in range(4)] == pytest.approx(true, rel=30.0 * rtol), method
        assert run["driven.w"][-1] * ratio == pytest.approx(true[3], rel=30.0 * rtol), method


@pytest.mark.parametrize("springs", [2, pytest.param(3, marks=pytest.mark.long), 4])
@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(1)
def test_without_losses_a_ramp_later_on_is_no_matter_of_step_sizes(springs, method, rtol):
    tau, same, begins = LOADS["later"]
    run = gb.simulate(_chain(springs, tau, gb.IdealGear(ratio=RATIO)), t_end=T_END, method=method, rtol=rtol)
    assert abs(run["driven.w"][-1] / _in_numpy(springs, same, begins, 1.0) - 1.0) < 20.0 * rtol


@pytest.mark.long
@pytest.mark.parametrize(
    ("given", "first"),
    [
        ("driving", "pair"),
        pytest.param("driving", "joint", marks=pytest.mark.long),
        ("behind", "pair"),
        pytest.param("behind", "joint", marks=pytest.mark.long),
    ],
)
@pytest.mark.few(1)
def test_start_speeds_follow_through_a_gear_behind_gains_that_vary(first, given):
    rig = gb.Drivetrain("start")
    blocks = {
        "pair": gb.NonCircularGear(external=False, law=gb.RatioLaw.ellipse(0.25)),
        "joint": gb.UniversalJoint(angle=0.4),
    }
    driving = rig.add("driving", gb.Inertia(J=0.8, phi0=0.3, **({"w0": 18.6} if given == "driving" else {})))
    middle, last = rig.add("middle", gb.Inertia(J=0.1)), rig.add("last", gb.Inertia(J=0.3))
    behind = rig.add("behind", gb.Inertia(J=0.2, **({"w0": -4.0} if given == "behind" else {})))
    one, two = (
        rig.add(name, gb.LossyGear(ratio=ratio, efficiency=(0.8, 0.7))) for name, ratio in (("one", 2.0), ("two", -0.5))
    )
    rig.chain(driving, rig.add("gain", blocks[first]), middle, one, last, two, behind)
    run = gb.simulate(rig, t=[0.0, 1e-4])
    w = {name: run[f"{name}.w"][0] for name in ("driving", "middle", "last", "behind")}
    assert w[given] == pytest.approx({"driving": 18.6, "behind": -4.0}[given], rel=1e-12)
    assert (w["middle"], w["last"]) == pytest.approx((2.0 * w["last"], -0.5 * w["behind"]), rel=1e-12)
    turned = run["middle.phi"][1] - run["middle.phi"][0]  # the gain, by what a short time turns
    assert turned / (run["driving.phi"][1] - run["driving.phi"][0]) == pytest.approx(
        w["middle"] / w["driving"], rel=1e-3
    )


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "eta1", "peak", "tau"), [
    (2.0, 0.4, 1.3, 5.0), (2.0, 0.4, 1.3, -5.0), (3.0, 0.6, 1.5, 9.0), (2.5, 0.35, 2.0, 12.0)
])  # fmt: skip
@pytest.mark.few(1)
def test_a_clutch_with_a_static_peak_that_bridges_a_lossy_gear_breaks_away_beside_it(
    ratio: float, eta1: float, peak: float, tau: float
) -> None:
    """It slides with C from rest:  J w_a' = tau - C - u/eta1,  J w_b' = ratio u + C,  w_a = ratio w_b,  J = 1."""
    rig = gb.Drivetrain("bridged")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=1.0))
    gear = rig.add("gear", gb.LossyGear(ratio=ratio, efficiency=(eta1, 0.6)))
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), one, gear, two)
    rig.chain(two, rig.add("clutch", gb.Clutch(capacity=1.0, peak=peak)), one)
    u = (abs(tau) - (1 + ratio)) / (ratio**2 + 1 / eta1)
    assert u > 0
    run = gb.simulate(rig, t_end=0.1)
    assert run["one.w"][-1] == pytest.approx(0.1 * ratio * (ratio * u + 1) * tau / abs(tau), rel=1e-9)
