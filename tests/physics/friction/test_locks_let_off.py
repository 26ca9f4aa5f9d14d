"""Locks and lossy gears behind a contact that parts: all that held them ends at one instant, and is rounding from there on.

By hand, integrated by scipy: pinion and wheel of a mesh that parts, each with what its lock or its gear ties to it; after that
nothing changes a speed any more.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

R1, R2, GAP, K, C = 0.05, 0.1, 0.00178, 14700.0, 4.51


def _rig(kind, J, w0, ratio, efficiency, lock):
    rig = gb.Drivetrain("let off")
    pinion, wheel = rig.add("pinion", gb.Inertia(J=J[0], w0=w0)), rig.add("wheel", gb.Inertia(J=J[1]))
    mesh = gb.GearMesh(
        teeth=(23, 46),
        external=True,
        r_base=(R1, R2),
        k=K,
        c=C,
        backlash=gb.Backlash(half_gap=GAP),
        contact_damping=kind,
    )
    rig.chain(pinion, rig.add("mesh", mesh), wheel)
    between = rig.add("lock", lock())
    rig.connect(wheel.b, between.a)
    rig.connect(rig.add("carried", gb.Inertia(J=J[2])).a, between.b)
    gear = rig.add("gear", gb.LossyGear(ratio=ratio, efficiency=efficiency))
    rig.connect(pinion.a, gear.a)
    rig.connect(gear.b, rig.add("far", gb.Inertia(J=J[3])).a)
    return rig


def _parted(kind, J, w0, ratio, efficiency):
    """Speeds of pinion and wheel once they have parted, and how long the wheel takes from there to the other flank."""
    near, carried = J[0] + efficiency[1] * J[3] / ratio**2, J[1] + J[2]  # the far end drives: it is slowed down

    def force(y):
        x, rate = R1 * y[0] + R2 * y[1], R1 * y[2] + R2 * y[3]
        elastic = K * (x + GAP)
        bound = -elastic
        damping = C * rate if kind == "clipped_force" else np.clip(C * rate, -bound, bound)
        return elastic + damping

    def rates(_, y):
        N = force(y)
        return [y[2], y[3], -R1 * N / near, -R2 * N / carried]

    def parts(_, y):
        return force(y) if kind == "clipped_force" else R1 * y[0] + R2 * y[1] + GAP + 1e-15

    parts.terminal, parts.direction = True, 1
    begin = -GAP / (R1 * w0)
    run = solve_ivp(
        rates,
        (begin, begin + 2.0),
        [-GAP / R1, 0.0, w0, 0.0],
        "DOP853",
        rtol=1e-12,
        atol=1e-15,
        events=[parts],
        max_step=1e-3,
    )
    y = run.y[:, -1]
    room = GAP - R1 * y[0] - R2 * y[1]
    return run.t[-1], y[2:], room / (R1 * y[2] + R2 * y[3])


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize(
    ("J", "w0", "ratio", "efficiency", "lock"),
    [
        ((2.87, 0.059, 0.29, 1.0), -4.05, 0.25, (0.486, 0.746), gb.Freewheel),
        ((1.0, 0.2, 0.4, 0.5), -3.0, 0.5, (0.8, 0.9), lambda: gb.OneWayClutch(capacity=0.0)),
        ((0.7, 0.03, 0.11, 0.05), -6.0, 0.2, (0.9, 0.6), gb.Freewheel),
        ((2.0, 0.4, 0.3, 3.0), -2.0, 1.5, (0.55, 0.7), gb.Freewheel),
    ],
)
@pytest.mark.parametrize("kind", ["clipped_force", "clipped"])
@pytest.mark.few(1)
def test_what_a_contact_held_goes_on_as_it_is_once_it_parts(kind, J, w0, ratio, efficiency, lock, method):
    at, speeds, flight = _parted(kind, J, w0, ratio, efficiency)
    t = at + 0.5 * flight
    run = gb.simulate(_rig(kind, J, w0, ratio, efficiency, lock), t=[0.0, t], method=method, rtol=1e-9)
    assert [run["pinion.w"][-1], run["wheel.w"][-1]] == pytest.approx(list(speeds), rel=1e-7)
    assert run["carried.w"][-1] == pytest.approx(speeds[1], rel=1e-7)
    assert run["far.w"][-1] == pytest.approx(speeds[0] / ratio, rel=1e-7)
