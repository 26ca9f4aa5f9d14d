"""Angles of a train that hangs on the ground, beside one that is a million times as large: no rounding of that in them."""

import itertools

import numpy as np
import pytest

import gearblocks as gb

SPIN = 1e7


def _rig(order, between):
    """A body that turns fast behind a shaft that is next to nothing, one that swings on the ground, one behind it."""
    rig = gb.Drivetrain("spin")
    parts = {
        "spin": lambda: rig.add("spin", gb.Inertia(J=1.0, w0=SPIN)),
        "body": lambda: rig.add("body", gb.Inertia(J=1.0)),
        "behind": lambda: rig.add("behind", gb.Inertia(J=1.0)),
        "thread": lambda: rig.add("thread", gb.Shaft(k=1e-30)),
        "shaft": lambda: rig.add("shaft", gb.Shaft(k=3.0)),
        "bed": lambda: rig.add("bed", gb.Shaft(k=1.0)),
    }
    made = {name: parts[name]() for name in order}
    if between == "gear":
        gear = rig.add("gear", gb.IdealGear(ratio=-2.0))
        rig.connect(made["thread"].b, gear.a)
        rig.connect(gear.b, made["body"].a)
    else:
        rig.connect(made["thread"].b, made["body"].a)
    rig.connect(made["spin"].a, made["thread"].a)
    rig.connect(made["body"].b, made["shaft"].a, made["bed"].a, rig.add("load", gb.Torque(tau=1.0)).flange)
    rig.connect(made["shaft"].b, made["behind"].a)
    rig.connect(made["bed"].b, rig.add("ground", gb.Fixed()).flange)
    return rig


ORDERS = [
    ("spin", "body", "behind", "thread", "shaft", "bed"),
    ("behind", "body", "spin", "bed", "thread", "shaft"),
    ("body", "spin", "behind", "shaft", "thread", "bed"),
    *itertools.islice(itertools.permutations(("thread", "bed", "shaft", "spin", "behind", "body")), 100, 700, 150),
]


@pytest.mark.parametrize("between", ["shaft", "gear"])
@pytest.mark.parametrize("order", ORDERS, ids=["-".join(order) for order in ORDERS])
@pytest.mark.few(1)
def test_what_turns_far_leaves_no_rounding_in_the_angles_of_others(order, between):
    """Modes of J phi'' = 1 - (1 + 3) phi + 3 psi, J psi'' = 3 phi - 3 psi, from rest."""
    run = gb.simulate(_rig(order, between), t=np.linspace(0.0, 10.0, 101), rtol=1e-12, outputs=["*.phi"])
    stiff = np.array([[4.0, -3.0], [-3.0, 3.0]])
    squares, modes = np.linalg.eigh(stiff)
    force = modes.T @ np.array([1.0, 0.0])
    right = modes @ (force[:, None] / squares[:, None] * (1 - np.cos(np.sqrt(squares)[:, None] * run.t)))
    assert np.abs(run["body.phi"] - right[0]).max() < 1e-10
    assert np.abs(run["behind.phi"] - right[1]).max() < 1e-10
    assert run["spin.phi"][-1] == pytest.approx(10 * SPIN, rel=1e-14)
