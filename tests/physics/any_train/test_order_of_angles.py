"""Angles that no law reads are the same whichever of them is integrated: which one that is follows from the order of parts."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

T = np.linspace(0.0, 3.0, 151)


def _chain(make, order, flipped):
    """The blocks of `make` in a row, added in that order, each turned round or not."""
    rig = gb.Drivetrain("chain")
    blocks = make(flipped)
    made = {i: rig.add(f"p{i}", blocks[i]) for i in (order if order else range(len(blocks)))}
    a, b = ("b", "a") if flipped else ("a", "b")
    for left, right in itertools.pairwise(range(len(blocks))):
        rig.connect(
            getattr(made[left], b),
            made[right].flange if isinstance(blocks[right], gb.Speed) else getattr(made[right], a),
        )
    rig.connect(rig.add("torque", gb.Torque(tau=2.0 + 5.0 * gb.sin(4 * gb.time))).flange, getattr(made[0], a))
    return rig


def _gear(flipped):
    return gb.IdealGear(teeth=(60, 20) if flipped else (20, 60), external=False)


def _play(flipped):
    return [
        gb.Inertia(J=1.0), gb.Shaft(k=50.0, c=0.2), _gear(flipped), gb.Inertia(J=4.0),
        gb.Lash(k=300.0, half_gap=0.02, c=0.5), gb.Inertia(J=2.0),
    ]  # fmt: skip


def _slipping(flipped):
    return [
        gb.Inertia(J=1.0, w0=30.0), gb.Shaft(k=50.0, c=0.2), _gear(flipped), gb.Inertia(J=4.0, w0=10.0),
        gb.Clutch(capacity=2.0), gb.Inertia(J=2.0),
    ]  # fmt: skip


def _massless_ends(_flipped):
    return [
        gb.Inertia(J=0.0), gb.Shaft(k=50.0, c=0.2), gb.Inertia(J=4.0, w0=3.0), gb.Shaft(k=300.0, c=0.5),
        gb.Inertia(J=0.0), gb.Damper(c=0.3), gb.Inertia(J=2.0, w0=1.0),
    ]  # fmt: skip


def _paced(_flipped):
    return [
        gb.Inertia(J=1.0), gb.Shaft(k=50.0, c=0.2), gb.Inertia(J=4.0, w0=2.0), gb.Shaft(k=300.0, c=0.5),
        gb.Speed(w=3.0 * gb.sin(2 * gb.time)),
    ]  # fmt: skip


ORDERS = {
    _play: (5, 3, 1, 4, 2, 0),
    _slipping: (2, 0, 5, 4, 1, 3),
    _massless_ends: (5, 3, 1, 4, 2, 0, 6),
    _paced: (4, 1, 0, 3, 2),
}


@pytest.mark.long
@pytest.mark.parametrize("method", ["rodas", "dp8"])
@pytest.mark.parametrize(
    "make", [pytest.param(make, marks=[pytest.mark.long] * (make in (_paced, _slipping))) for make in ORDERS]
)
def test_every_angle_is_the_same_in_any_order_of_parts(make, method):
    plain = gb.simulate(_chain(make, (), False), t=T, method=method)
    for order, flipped in ((ORDERS[make], False), ((), True), (ORDERS[make], True)):
        run = gb.simulate(_chain(make, order, flipped), t=T, method=method)
        for name in (f"p{i}.phi" for i, block in enumerate(make(False)) if isinstance(block, gb.Inertia)):
            assert run[name] == pytest.approx(plain[name], abs=1e-12 * np.abs(plain[name]).max())


@pytest.mark.parametrize("method", ["rodas", "dp8"])
@pytest.mark.few(1)
def test_an_angle_that_no_law_reads_is_the_integral_of_its_speed(method):
    """Two bodies, a spring, one angle that is integrated, events that cut steps: held against scipy."""
    rig = gb.Drivetrain("two")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0, w0=4.0))
    rig.chain(one, rig.add("lash", gb.Lash(k=200.0, half_gap=0.05, c=1.0, contact_damping="always")), two)
    rig.connect(rig.add("torque", gb.Torque(tau=3.0 * gb.cos(5 * gb.time))).flange, one.a)

    def rates(t, y):
        twist = y[0] - y[1]
        torque = 200.0 * (twist - np.clip(twist, -0.05, 0.05)) + 1.0 * (y[2] - y[3])
        return [y[2], y[3], 3.0 * np.cos(5 * t) - torque, torque / 2.0]

    exact = solve_ivp(
        rates, (0.0, 3.0), [0.0, 0.0, 0.0, 4.0], "DOP853", t_eval=T, rtol=1e-11, atol=1e-12, max_step=0.01
    )
    run = gb.simulate(rig, t=T, rtol=1e-8, method=method)
    assert len(run.events) > 4
    for name, values in zip(("one.phi", "two.phi"), exact.y, strict=False):
        assert run[name] == pytest.approx(values, abs=1e-7 * np.abs(values).max())
