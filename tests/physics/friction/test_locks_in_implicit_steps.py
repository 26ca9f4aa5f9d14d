"""Locks in implicit steps, as ties between neighbours and otherwise: the same motion as by explicit steps, far finer.

The trains cover what decides which way is taken: ratios, speeds at rest, rings, ties across a spring, inertias that are not
diagonal, states that nothing reads.
"""

import numpy as np
import pytest

import gearblocks as gb

TIMES = np.linspace(0.0, 1.0, 21)


def _row(*between, w0=2.0):
    """Bodies b0 b1 ... with these blocks between, driven at the first and damped at the last."""
    rig = gb.Drivetrain("row")
    parts = [rig.add("drive", gb.Torque(tau=30 * gb.sin(7 * gb.time) + 3)), rig.add("b0", gb.Inertia(J=0.5, w0=w0))]
    for i, block in enumerate(between):
        parts += [rig.add(f"c{i}", block), rig.add(f"b{i + 1}", gb.Inertia(J=0.2 + 0.1 * i, w0=w0))]
    rig.chain(*parts, rig.add("damper", gb.Damper(c=0.7)), rig.add("ground", gb.Fixed()))
    return rig


def _lock():
    return gb.Clutch(capacity=1e4)


def _spring():
    return gb.Shaft(k=4e3, c=0.5)


def _row_of_locks():
    return _row(_lock(), _lock(), _spring(), _lock())


def _beside_losses():
    """A lossy gear, which always drives: what it takes is no row of its own kind."""
    rig = _row(_lock(), _spring(), _lock())
    rig.connect(rig["b3"].b, rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.85))).a)
    rig.connect(rig["gear"].b, rig.add("load", gb.Inertia(J=0.6, w0=1.0)).a)
    rig.connect(rig["load"].b, rig.add("brake", gb.SpeedLoad(coeffs=(0.0, 3.0, 0.0))).flange)
    return rig


def _behind_ratios():
    """The clutch ties bodies behind gears: speeds as 2 to 3."""
    rig = gb.Drivetrain("ratios")
    rig.chain(
        rig.add("drive", gb.Torque(tau=20 * gb.sin(5 * gb.time) + 2)), rig.add("b0", gb.Inertia(J=0.5)),
        rig.add("g0", gb.IdealGear(ratio=2.0)), _lock_of(rig, "lock"), rig.add("g1", gb.IdealGear(ratio=1 / 3)),
        rig.add("b1", gb.Inertia(J=0.3)), rig.add("s", _spring()), rig.add("b2", gb.Inertia(J=0.1)),
        rig.add("damper", gb.Damper(c=0.4)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    return rig


def _lock_of(rig, name):
    return rig.add(name, _lock())


def _braked():
    """A brake holds the middle one of three."""
    rig = _row(_spring(), _lock(), _spring(), w0=0.0)
    rig.connect(rig["b1"].b, rig.add("brake", gb.Brake(capacity=1e4)).a)
    return rig


def _side_by_side():
    """Two clutches tie the same bodies, and a third one across a spring."""
    rig = _row(_lock(), _spring(), _lock())
    rig.connect(rig["b0"].b, rig.add("other", _lock()).a)
    rig.connect(rig["other"].b, rig["b1"].b)
    rig.connect(rig["b1"].b, rig.add("across", gb.Clutch(capacity=1e4)).a)
    rig.connect(rig["across"].b, rig["b2"].b)
    return rig


def _across():
    """A clutch over two springs in a row: a ring, whose ends are no neighbours."""
    rig = _row(_spring(), _spring(), _lock())
    rig.connect(rig["b0"].b, rig.add("across", _lock()).a)
    rig.connect(rig["across"].b, rig["b2"].b)
    return rig


def _planetary():
    """The mass matrix is not diagonal; sun and ring are locked to each other."""
    rig = _row(_spring(), _lock())
    gear = rig.add("gear", gb.IdealPlanetary(ratio=70 / 30))
    rig.connect(rig["b2"].b, gear.sun)
    rig.connect(gear.carrier, rig.add("out", gb.Inertia(J=0.4, w0=2.0)).a)
    rig.connect(gear.ring, rig.add("rim", gb.Inertia(J=0.3, w0=2.0)).a)
    rig.connect(gear.ring, rig.add("bridge", _lock()).a)
    rig.connect(rig["bridge"].b, gear.sun)
    return rig


@pytest.mark.parametrize(
    "make", [_row_of_locks, _beside_losses, _behind_ratios, _braked, _side_by_side, _across, _planetary]
)
def test_they_move_as_by_explicit_steps(make):
    """Fixed steps, too: of a matrix that is not that of the motion they lose their order (five)."""
    model = gb.build(make())
    bodies = [name for name in model.program.output_numbers if name.endswith(".w") and name.count(".") == 1]
    slips = [name for name in model.program.output_numbers if name.endswith(".w_rel") and name != "damper.w_rel"]
    fine = gb.simulate(model, t=TIMES, method="dp8", rtol=1e-12)

    def error(**options):
        run = gb.simulate(model, t=TIMES, method="rodas", **options)
        assert slips and not any(run[name].any() for name in slips)  # to the last bit
        assert make is not _across or (run["b0.w"] == run["b2.w"]).all()
        return max(np.abs(run[name] - fine[name]).max() / max(np.abs(fine[name]).max(), 1.0) for name in bodies)

    for rtol in (1e-5, 1e-8):
        assert error(rtol=rtol) <= 10 * rtol
    long, short = error(step=2e-3), error(step=1e-3)
    assert short < max(long / 12, 1e-11), (long, short)
