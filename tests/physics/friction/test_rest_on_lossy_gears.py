"""A law that jumps about an angle and a lossy gear that takes a part of each swing: at rest on the jump, by its losses."""

from math import sqrt
from random import Random

import numpy as np
import pytest

import gearblocks as gb

METHODS = ("dp5", "dp8", "rodas", "auto")
LONG = pytest.mark.long


def _drive(up=1.0, down=1.0, target=1.0):
    return gb.Torque(tau=gb.piecewise((up, gb.sense("body.phi") < target), (-down, True)))


def _to_load(between, J, load, up=1.0, down=1.0, pull=0.0, w=0.0):
    """The law on a body, and a load behind `between`."""
    rig = gb.Drivetrain("positioner with a load")
    body, behind = rig.add("body", gb.Inertia(J=J)), rig.add("load", gb.Inertia(J=load, w0=w))
    rig.chain(rig.add("drive", _drive(up, down)), body, rig.add("between", between), behind)
    rig.chain(behind, rig.add("pull", gb.Torque(tau=pull)))
    return rig


def _geared_rest(J, up, down, load, ratio, eta):
    """When swings from rest, 1 rad away, have ended: a gear makes the load heavier as it is driven, lighter as it drives."""
    slow, fast = J + load / (ratio**2 * eta[0]), J + load * eta[1] / ratio**2
    first = sqrt(2 * up / slow)
    returned = first * sqrt(fast / slow)
    swing = (
        first * fast / down + returned * slow / down + returned * fast / up + returned * sqrt(fast / slow) * slow / up
    )
    return first * slow / up + swing / (1 - fast / slow)


@pytest.mark.parametrize("seed", [pytest.param(s, marks=() if s in (1, 4) else LONG) for s in range(8)])
def test_losses_of_a_gear_end_the_swings_at_every_tolerance(seed):
    """Of weak losses (4, 2, 7) rounding keeps swings up that are wider than the tolerance of the others' last ones."""
    draw = Random(f"gear {seed}")
    J, up, down, load = (draw.uniform(0.5, 3.0) for _ in range(4))
    ratio, eta = draw.choice((-3.0, -1.0, 0.5, 1.0, 2.0)), (draw.uniform(0.5, 0.9), draw.uniform(0.4, 0.9))
    ends = _geared_rest(J, up, down, load, ratio, eta)
    model = gb.build(_to_load(gb.LossyGear(ratio=ratio, efficiency=eta), J, load, up, down))
    for method in METHODS:
        for rtol in (1e-4, 1e-6, 1e-8, 1e-9):
            run = gb.simulate(model, t=[0.5 * ends, ends + 0.01, ends + 100.0], method=method, rtol=rtol)
            assert np.abs(run["body.phi"][1:] - 1.0).max() < 1e-2 * rtol
            assert run["body.w"][1:].tolist() == run["load.w"][1:].tolist() == [0.0, 0.0]
            assert run.events[-1].t == pytest.approx(ends, abs=300 * sqrt(1e-4 * rtol) + 1e-3)  # 64 settled swings
            assert run.stats.events < 3000
            assert run.energy.residual < 10 * rtol


def test_a_gear_holds_what_its_losses_hold():
    """At b the load of the law, less what driving loses: 2/0.7 N m forward, before the gear drives backward."""
    pull = gb.piecewise((0.0, gb.time < 30.0), (0.1 * (gb.time - 30.0), True))
    rig = _to_load(gb.LossyGear(ratio=2.0, efficiency=(0.7, 0.7)), 1.0, 2.0, pull=pull)
    run = gb.simulate(rig, t=[29.9, 58.0, 60.0])
    leaves, gone = 30 + 10 * 2 / 0.7, 60 - 30 - 10 * 2 / 0.7
    assert next(e.t for e in run.events if e.component == "between" and e.t > 31) == pytest.approx(leaves, abs=1e-9)
    assert run["body.w"][:2].tolist() == [0.0, 0.0]
    assert run["body.w"][2] == pytest.approx(0.05 * gone**2 * 0.35 / (1 + 0.35), rel=1e-6)  # 0.7/2 on 1 + 2 * 0.7/4


def test_a_condition_that_the_law_reads_no_more_holds_nothing():
    """Its set point has stepped on: what gear and brake hold of 18 N m together tells nothing of a jump that is gone."""
    target = gb.piecewise((-1.0, gb.time < 12.0), (0.5, True))
    rig = gb.Drivetrain("stepped on")
    drive = gb.Torque(tau=gb.piecewise((18.0, gb.sense("body.phi") < target), (-18.0, True)))
    body = rig.add("body", gb.Inertia(J=1.0))
    gear = rig.add("gear", gb.LossyGear(ratio=3.0, efficiency=(0.785, 0.785)))
    rig.chain(rig.add("load", gb.Inertia(J=0.3)), gear, body, rig.add("brake", gb.Brake(capacity=2.0)))
    rig.chain(rig.add("drive", drive), body)
    run = gb.simulate(rig, t=[11.9, 12.2, 30.0])
    assert run["body.phi"][[0, 2]] == pytest.approx([-1.0, 0.5], abs=1e-6) and run["body.w"][[0, 2]].tolist() == [
        0.0,
        0.0,
    ]
    rate = (18.0 - 2.0) / (1.0 + 0.3 * 9 / 0.785)  # the body drives, at b
    assert run["body.w"][1] > 0.2 * 0.8 * rate
