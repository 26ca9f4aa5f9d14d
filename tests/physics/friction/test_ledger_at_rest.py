"""Trains that friction holds under load: what moves behind them is rounding of forces that balance, and so is its energy."""

import numpy as np
import pytest

import gearblocks as gb


def _differential(rig, tau):
    """The left wheel is held by the dry part of its load; right wheel and carrier are unloaded."""
    left, right, carrier = (rig.add(name, gb.Inertia(J=1.0)) for name in ("left", "right", "carrier"))
    gear = rig.add("gear", gb.Differential(ratio=1))
    rig.connect(left.a, gear.left, rig.add("drive", gb.Torque(tau=tau)).flange)
    rig.connect(left.b, rig.add("load", gb.SpeedLoad(coeffs=(4.0, 0.0, 0.01))).flange)
    rig.connect(right.a, gear.right)
    rig.connect(carrier.a, gear.carrier)


def _behind_a_lossy_gear(rig, tau):
    first, second = rig.add("first", gb.Inertia(J=0.3)), rig.add("second", gb.Inertia(J=0.1))
    gear = rig.add("lossy", gb.LossyGear(ratio=-3.0, efficiency=(0.7, 0.6), bearing=(8.0, 8.0)))
    rig.connect(first.a, gear.a, rig.add("drive", gb.Torque(tau=tau)).flange)
    rig.connect(second.a, gear.b)
    differential = rig.add("differential", gb.Differential(ratio=1))
    rig.connect(second.b, differential.left)
    rig.connect(rig.add("right", gb.Inertia(J=0.05)).a, differential.right)
    rig.connect(rig.add("carrier", gb.Inertia(J=0.07)).a, differential.carrier)


def _brake_and_clutch(rig, tau):
    left, right, carrier = (
        rig.add(name, gb.Inertia(J=J)) for name, J in (("left", 0.3), ("right", 0.7), ("carrier", 0.11))
    )
    gear = rig.add("gear", gb.Differential(ratio=-2.3))
    brake, clutch = rig.add("brake", gb.Brake(capacity=3.0)), rig.add("clutch", gb.Clutch(capacity=2.0))
    rig.connect(left.a, gear.left, brake.a, clutch.a, rig.add("drive", gb.Torque(tau=tau)).flange)
    rig.connect(brake.housing, rig.add("ground", gb.Fixed()).flange)
    rig.connect(clutch.b, rig.add("other", gb.Inertia(J=0.9)).a)
    rig.connect(right.a, gear.right)
    rig.connect(carrier.a, gear.carrier)


HELD = [_differential, _behind_a_lossy_gear, _brake_and_clutch]


@pytest.mark.parametrize(("method", "rtol"), [("dp5", 1e-8), ("dp8", 1e-6), ("rodas", 1e-6), ("auto", 1e-4)])
@pytest.mark.parametrize("tau", [0.2, 0.226 * gb.sin(6.27 * gb.time)])
@pytest.mark.parametrize("train", HELD)
@pytest.mark.few(1)
def test_the_ledger_of_a_train_at_rest_closes(train, tau, method, rtol):
    """Nothing moves, whatever the load; no run that asks for a residual is refused for what rounding leaves."""
    rig = gb.Drivetrain("held")
    train(rig, tau)
    run = gb.simulate(rig, t_end=3.0, method=method, rtol=rtol, residual=10 * rtol)
    assert run.energy.residual <= 10 * rtol
    speeds = [name for name in run.names if name.endswith(".w")]
    assert max(np.max(np.abs(run[name])) for name in speeds) < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("load", [1e-6, 1e-9, 3.0])
def test_what_moves_is_held_to_its_balance_however_slow(load):
    """As soon as the load is more than friction holds, by however little, nothing counts as rounding."""
    rig = gb.Drivetrain("slow")
    _differential(rig, 4.0 + load)
    run = gb.simulate(rig, t_end=3.0, rtol=1e-6)
    assert run.energy.rounding == 0.0
    assert run.energy.residual < 1e-5


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.parametrize("capacity", [0.861, 40.0])
def test_a_brake_that_comes_and_goes_beside_what_nothing_loads_leaves_rounding(capacity, method):
    """Its capacity passes 0 as that of a clutch does: for 1e-14 s it slides, with forces of 1e-14 N m."""
    rig = gb.Drivetrain("at rest")
    body = {name: rig.add(name, gb.Inertia(J=J)) for name, J in (("one", 0.228), ("two", 1.63), ("ring", 0.5))}
    capacities = 1 + 2 * gb.cos(9 * gb.time), abs(2 * gb.sin(7 * gb.time))
    for i, comes in enumerate(capacities):
        clutch = rig.add(f"clutch{i}", gb.Clutch(capacity=comes))
        rig.connect(body["one"].b, clutch.a)
        rig.connect(clutch.b, body["two"].a)
    teeth = gb.Table([0.0, 0.3, 0.7], [-1.0, 1.0, -1.0], kind="step")
    sync = rig.add("sync", gb.Synchronizer(engaged=teeth, capacity=1.8))
    rig.connect(body["two"].b, sync.a)
    rig.connect(sync.b, body["ring"].a)
    planetary = rig.add("set", gb.IdealPlanetary(ratio=3.0))
    rig.connect(body["ring"].b, planetary.ring, rig.add("brake", gb.Brake(capacity=capacity * gb.sin(14 * gb.time))).a)
    rig.connect(rig.add("carrier", gb.Inertia(J=1.0)).a, planetary.carrier)
    rig.connect(rig.add("sun", gb.Inertia(J=0.5)).a, planetary.sun)
    for rtol in (1e-4, 1e-6, 1e-9):
        run = gb.simulate(rig, t_end=1.0, method=method, rtol=rtol, residual=10 * rtol)
        assert max(np.max(np.abs(run[f"{name}.w"])) for name in (*body, "carrier", "sun")) < 1e-20
