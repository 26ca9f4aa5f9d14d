"""Locks that nothing loads, beside one that carries everything, while a part of the train that asks nothing of them moves.

Closed form: a one-way clutch holds one side of a differential against its torque; the freewheel that would hold the other
side carries nothing, and neither of them ever moves. Shaft and body beside them swing as if alone.
"""

import math

import numpy as np
import pytest

import gearblocks as gb

PAIRS = {
    "ellipse": gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.4, order=2), external=False),
    "joint": gb.UniversalJoint(angle=0.6),
    "gear": gb.IdealGear(ratio=-2.0),
}


def _held(pair: str, ratio: float) -> gb.Drivetrain:
    """The held train alone."""
    rig = gb.Drivetrain("held")
    near, left, right, carrier = (
        rig.add(n, gb.Inertia(J=J)) for n, J in (("near", 1.0), ("left", 1.26), ("right", 1.0), ("carrier", 0.25))
    )
    tie, differential = rig.add("pair", PAIRS[pair]), rig.add("differential", gb.Differential(ratio=ratio))
    lock, free, ground = (
        rig.add("lock", gb.OneWayClutch(capacity=0.0)),
        rig.add("free", gb.Freewheel()),
        rig.add("ground", gb.Fixed()),
    )
    rig.connect(near.a, tie.a)
    rig.connect(left.a, tie.b, differential.left)
    rig.connect(right.a, differential.right, free.a)
    rig.connect(carrier.a, differential.carrier)
    held, holds = (lock.b, lock.a) if pair == "gear" else (lock.a, lock.b)  # which way it would turn
    rig.connect(held, near.b)
    rig.connect(ground.flange, free.b, holds)
    rig.connect(left.b, rig.add("load", gb.Torque(tau=126.0 * gb.cos(4.0 * gb.time))).flange)
    return rig


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize("ratio", [1.0, 3.5])
@pytest.mark.few(4)
def test_a_freewheel_that_nothing_loads_stays_as_it_is_whatever_moves_elsewhere(
    pair: str, ratio: float, method: str
) -> None:
    rig = _held(pair, ratio)
    driven, swings = rig.add("driven", gb.Inertia(J=1.0)), rig.add("swings", gb.Inertia(J=1.0))
    rig.chain(driven, rig.add("shaft", gb.Shaft(k=10.0)), swings)
    rig.connect(driven.b, rig.add("push", gb.Torque(tau=0.8 * gb.time)).flange)
    t = np.linspace(0.0, 0.35, 8)  # before the load turns around
    run = gb.simulate(rig, t=t, method=method, rtol=1e-6)
    assert not np.any([run[f"{name}.w"] for name in ("near", "left", "right", "carrier")])
    assert np.max(np.abs(run["free.torque"])) < 1e-12 < 50.0 < np.max(np.abs(run["lock.torque"]))
    assert not [e for e in run.events if e.t > 0.0] and run.stats.steps < 40
    # together they are accelerated by 0.8 t / 2; their twist swings at sqrt(2 k / J)
    omega = math.sqrt(20.0)
    twist = 0.04 * (t - np.sin(omega * t) / omega)
    assert run["driven.w"] + run["swings.w"] == pytest.approx(0.4 * t**2, rel=1e-6)
    assert run["driven.phi"] - run["swings.phi"] == pytest.approx(twist, abs=1e-6)
