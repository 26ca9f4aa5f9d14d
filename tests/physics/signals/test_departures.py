"""Switches that stand on their limit while the motion begins: they leave it like a high power of time.

The evidence is a chain in numpy, integrated piece by piece with the law on one side at a time; the side on which it begins is
that of the torque, because every term of the solution's series has its sign.
"""

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import gearblocks as gb

T_END, LATE = 1.5, 0.4
LAWS = {  # over the last angle: gearblocks' law, and the same by side (1 above a crossing, 0 below)
    "condition": (lambda phi: gb.piecewise((0.8, gb.sin(phi) > 0), (0.2, True)), np.sin, lambda phi, up: 0.8 if up else 0.2),
    "sign": (lambda phi: 0.5 * sp.sign(phi), lambda phi: phi, lambda phi, up: 0.5 if up else -0.5),
    "joint": (lambda phi: gb.Table([-1, 0, 1], [0.4, 0.2, 1.4])(phi), lambda phi: phi,
              lambda phi, up: 0.2 + (1.2 * min(phi, 1.0) if up else -0.2 * max(phi, -1.0))),
    "size": (lambda phi: sp.Abs(gb.sin(phi)), np.sin, lambda phi, up: np.sin(phi) if up else -np.sin(phi)),
}  # fmt: skip


def _chain(springs, tau, law, damping):
    rig = gb.Drivetrain("train")
    bodies = [rig.add(f"j{i}", gb.Inertia(J=0.1 + 0.05 * i)) for i in range(springs + 1)]
    for i, (left, right) in enumerate(pairwise(bodies)):
        shaft = rig.add(f"s{i}", gb.Shaft(k=5.0 + i, c=damping))
        rig.connect(left.b, shaft.a)
        rig.connect(shaft.b, right.a)
    drive = rig.add("drive", gb.Torque(tau=tau))
    reads = rig.add("reads", gb.Torque(tau=law(gb.sense(f"j{springs}.phi"))))
    rig.connect(bodies[0].a, drive.flange, reads.flange)
    return rig


def _last_angle(springs, tau, name, damping):
    """Angle of the last body at T_END after the torque has begun, piece by piece."""
    _, crossing, law = LAWS[name]
    J, k = 0.1 + 0.05 * np.arange(springs + 1), 5.0 + np.arange(springs)
    y, t, up, n = np.zeros(2 * springs + 2), 0.0, tau > 0, springs + 1

    def rates(_, y, up):
        pull = k * np.diff(y[:n]) + damping * np.diff(y[n:])
        tau_all = np.concatenate([pull, [0.0]]) - np.concatenate([[0.0], pull])
        tau_all[0] += tau + law(y[n - 1], up)
        return np.concatenate([y[n:], tau_all / J])

    def crossed(_, y, up):
        return crossing(y[n - 1])

    while t < T_END:
        found = solve_ivp(rates, (t, T_END), y, "DOP853", rtol=1e-12, atol=1e-14, args=(up,), dense_output=True)
        looks = np.linspace(t, T_END, 3001)
        side = np.array([crossed(0, x, up) for x in found.sol(looks).T])
        wrong = np.flatnonzero((side < 0 if up else side > 0) & (looks > t + 0.1))
        if not wrong.size:
            return found.y[n - 1, -1]
        a, b = looks[wrong[0] - 1], looks[wrong[0]]
        t = brentq(lambda x, f=found, up=up: crossed(0, f.sol(x), up), a, b, xtol=1e-14)
        y, up = found.sol(t), not up
    return y[n - 1]


@pytest.mark.long
@pytest.mark.parametrize("springs", [*(pytest.param(n, marks=pytest.mark.long) for n in (2, 3)), 5])
@pytest.mark.parametrize("name", LAWS)
@pytest.mark.few(1)
def test_a_law_far_from_the_load_begins_on_the_side_to_which_it_moves(name, springs):
    for tau in (4.0, -4.0):
        for damping, method in ((0.0, "dp5"), (0.01, "dp8"), (0.01, "rodas")):
            rig = _chain(springs, tau, LAWS[name][0], damping)
            run = gb.simulate(rig, t_end=T_END, rtol=1e-8, method=method)
            true = _last_angle(springs, tau, name, damping)
            assert run[f"j{springs}.phi"][-1] == pytest.approx(true, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (name in ("sign", "size"))) for name in LAWS]
)
def test_the_same_where_the_train_rests_before(name):
    for tau in (4.0, -4.0):
        late = gb.piecewise((0, gb.time < LATE), (tau, True))
        law = LAWS[name][0]
        asleep = gb.piecewise((0, gb.time < LATE), (1, True))
        rig = _chain(3, late, lambda phi: asleep * law(phi), 0.01)  # noqa: B023
        run = gb.simulate(rig, t_end=LATE + T_END, rtol=1e-8)
        assert run["j3.phi"][-1] == pytest.approx(_last_angle(3, tau, name, 0.01), rel=1e-6)


TABLES = {  # evaluated from the lower joint, each leaves rounding at the joint 0, which drives the twist back
    "spline": gb.Table([-0.2, 0, 0.2], [-0.222, 0, 0.111], kind="cubic"),
    "more points": gb.Table([-0.7, -0.3, 0, 0.2, 0.9], [-1.1, -0.31, 0, 0.17, 1.3], kind="cubic"),
    "lines": gb.Table([-0.3, 0, 0.3], [-0.7, 0, 0.9]),
}


def _behind_a_table(tau, table, springs):
    """The last angle behind springs and a shaft with a table, of which the twist stays on one side."""
    x, y = np.asarray(table.x), np.asarray(table.y)
    law = (lambda d: np.interp(d, x, y)) if table.kind == "linear" else CubicSpline(x, y)
    n = springs + 2

    def rates(_, q):
        pull = np.append(4.0 * np.diff(q[: n - 1]), law(q[n - 1] - q[n - 2]))
        load = np.append(pull, 0.0) - np.append(-tau, pull)
        return np.concatenate([q[n:], load])

    return solve_ivp(rates, (0.0, 1.0), np.zeros(2 * n), "DOP853", rtol=1e-12, atol=1e-15).y[n - 1, -1]


@pytest.mark.parametrize("springs", [1, 2])
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.few(1)
def test_a_shaft_rests_on_a_joint_of_its_table(name, springs):
    for tau in (0.5, -0.5):
        rig = gb.Drivetrain("train")
        bodies = [rig.add(f"j{i}", gb.Inertia(J=1.0)) for i in range(springs + 2)]
        for i, (left, right) in enumerate(pairwise(bodies)):
            shaft = rig.add(f"s{i}", gb.Shaft(k=4.0) if i < springs else gb.Shaft(torque=TABLES[name]))
            rig.chain(left, shaft, right)
        rig.connect(rig.add("drive", gb.Torque(tau=tau)).flange, bodies[0].a)
        true = _behind_a_table(tau, TABLES[name], springs)
        for method in ("dp5", "dp8", "rodas"):
            run = gb.simulate(rig, t_end=1.0, rtol=1e-8, method=method)
            assert run[f"j{springs + 1}.phi"][-1] == pytest.approx(true, rel=1e-6)


@pytest.mark.parametrize("push", [0.0, 0.5])
def test_what_every_side_drives_back_over_an_angle_is_held(push):
    back = gb.piecewise((-2, gb.sin(gb.sense("j2.phi")) > 0), (2, True))
    rig = gb.Drivetrain("train")
    body = rig.add("j2", gb.Inertia(J=1.0))
    rig.connect(body.a, rig.add("back", gb.Torque(tau=back)).flange, rig.add("push", gb.Torque(tau=push)).flange)
    run = gb.simulate(rig, t_end=1.0)
    assert np.abs(run["j2.w"]).max() == np.abs(run["j2.phi"]).max() == 0.0
    assert run["back.torque"][-1] == pytest.approx(-push, abs=1e-9)


def test_what_every_side_drives_back_over_a_speed_is_held():
    loose = gb.Drivetrain("loose")
    wheel = loose.add("wheel", gb.Inertia(J=1.0, w0=3.0))
    loose.connect(wheel.a, loose.add("rubs", gb.Torque(tau=-5 * sp.sign(gb.sense("wheel.w")))).flange)
    run = gb.simulate(loose, t_end=1.0)
    assert run["wheel.w"][-1] == 0.0
    assert run["wheel.phi"][-1] == pytest.approx(0.9, rel=1e-9)
