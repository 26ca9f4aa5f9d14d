"""A row of locks that nothing loads, behind a planetary set of which a brake holds the loaded shaft.

What the brake leaves for them is rounding; the bodies that they tie move as one, and so does their rounding. Evidence: the same
train with rigid shafts in place of the locks.
"""

import numpy as np
import pytest

import gearblocks as gb

METHODS = pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
INERTIAS = (0.581, 0.5, 1.0, 0.3)
T = np.linspace(0.0, 1.0, 21)


def train(lock, count, *, outwards, ratio=3.0, at="carrier"):
    """Bodies in a row from the shaft `at` of the set; the locks are added from there or towards there."""
    rig = gb.Drivetrain("row")
    rows = range(count + 1) if outwards else range(count, -1, -1)
    bodies = {i: rig.add(f"row{i}", gb.Inertia(J=INERTIAS[i], w0=0.0)) for i in rows}
    for i in range(count) if outwards else range(count - 1, -1, -1):
        part = rig.add(f"lock{i}", lock())
        near, far = (part.a, part.b) if outwards else (part.b, part.a)
        rig.connect(bodies[i].b, near)
        rig.connect(far, bodies[i + 1].a)
    planetary = rig.add("set", gb.IdealPlanetary(ratio=ratio))
    held, free = rig.add("held", gb.Inertia(J=1.0, w0=0.0)), rig.add("free", gb.Inertia(J=0.5))
    other = "sun" if at == "carrier" else "carrier"
    rig.connect(bodies[0].a, getattr(planetary, at))
    rig.connect(free.a, getattr(planetary, other))
    load, brake = (
        rig.add("load", gb.Torque(tau=2.48 * gb.sin(6.67 * gb.time))),
        rig.add("brake", gb.Brake(capacity=2.2)),
    )
    rig.connect(held.a, planetary.ring, load.flange)
    rig.connect(held.b, brake.a)
    return rig


LOCKS = {
    "clutches": lambda: gb.Clutch(capacity=3.7),
    "pulsing": lambda: gb.Clutch(capacity=3.0 + 0.5 * gb.cos(9 * gb.time)),
    "synchronizers": lambda: gb.Synchronizer(engaged=1.0, capacity=3.7),
}


@METHODS
@pytest.mark.parametrize(
    ("name", "count", "outwards", "at"),
    [
        ("clutches", 2, False, "carrier"),
        pytest.param("clutches", 3, False, "carrier", marks=pytest.mark.long),
        pytest.param("clutches", 1, True, "sun", marks=pytest.mark.long),
        pytest.param("pulsing", 2, False, "carrier", marks=pytest.mark.long),
        pytest.param("pulsing", 3, False, "sun", marks=pytest.mark.long),
        pytest.param("synchronizers", 2, True, "carrier", marks=pytest.mark.long),
    ],
)
@pytest.mark.few(1)
def test_they_rest_until_the_brake_lets_go_and_move_as_one(name, count, outwards, at, method):
    tied = gb.build(train(lambda: gb.Shaft(rigid=True), count, outwards=outwards, at=at))
    right = gb.simulate(tied, t=T, rtol=1e-11, method="dp8")
    model = gb.build(train(LOCKS[name], count, outwards=outwards, at=at))
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(model, t=T, rtol=rtol, method=method)
        for body in (*(f"row{i}.w" for i in range(count + 1)), "held.w", "free.w"):
            assert np.max(np.abs(run[body] - right[body])) < 30 * rtol * max(np.max(np.abs(right[body])), 0.1), body
        assert run.stats.steps < 600
