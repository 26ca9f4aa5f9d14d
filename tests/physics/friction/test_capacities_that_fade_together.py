"""Locks that share a load, one of which fades: they let go just before its capacity is gone, and hold again at the next look.

Closed form: brakes of capacities c and a + b cos(n t) hold a body under a load up to the instant at which their sum is the
load; then the load drives it against what is left of both, the second of which never pushes.
"""

import numpy as np
import pytest

import gearblocks as gb

J, STEADY, MEAN, SWING = 0.7, 1.5, 2.69, 5.38


def _train(load: float, pace: float, brakes: str) -> gb.Drivetrain:
    rig = gb.Drivetrain("two brakes")
    body = rig.add("body", gb.Inertia(J=J))
    fades = MEAN + SWING * gb.cos(pace * gb.time)
    if brakes == "clutch":
        rig.chain(body, rig.add("fading", gb.Clutch(capacity=fades)), rig.add("wall", gb.Fixed()))
    else:
        rig.chain(body, rig.add("fading", gb.Brake(capacity=fades)))
    rig.chain(body, rig.add("steady", gb.Brake(capacity=STEADY)))
    rig.chain(rig.add("load", gb.Torque(tau=load)), body)
    return rig


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("brakes", ["brake", "clutch"])
@pytest.mark.parametrize("pace", [0.8, 3.0, 20.0])
@pytest.mark.few(1)
def test_they_let_go_before_the_second_is_gone(pace: float, brakes: str, method: str) -> None:
    for share in (0.3, 0.1, 0.03, 0.01):  # of the mean capacity that the second is to hold
        excess = share * MEAN
        opens, gone = np.arccos((excess - MEAN) / SWING) / pace, np.arccos(-MEAN / SWING) / pace
        end = np.pi / pace
        swept = (excess - MEAN) * (gone - opens) - SWING / pace * (np.sin(pace * gone) - np.sin(pace * opens))
        run = gb.simulate(_train(STEADY + excess, pace, brakes), t_end=end, method=method, rtol=1e-8)
        assert run["body.w"][-1] == pytest.approx((swept + excess * (end - gone)) / J, rel=1e-6), share
        assert any(e.t == pytest.approx(opens, rel=1e-8) for e in run.events), share
