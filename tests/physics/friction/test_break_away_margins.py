"""Break-aways by a small margin: what is held exceeds its bound by a millionth, at every tolerance. Closed forms in mpmath."""

import mpmath as mp
import pytest

import gearblocks as gb

mp.mp.dps = 40
EXCESS = gb.Parameter("excess", 1e-3)


def _held(torque, capacity):
    rig = gb.Drivetrain("held")
    brake = rig.add("b", gb.Brake(capacity=capacity))
    rig.chain(rig.add("t", gb.Torque(tau=torque)), rig.add("j", gb.Inertia(J=1.0)), brake)
    return rig


def _swing(e):
    """w from the break-away of (1 + e) sin t over 1 until its peak."""
    begin = mp.asin(1 / (1 + e))
    return (1 + e) * mp.cos(begin) - (mp.pi / 2 - begin)


CASES = {
    "the torque comes to rest above": (
        _held(gb.piecewise((gb.time, gb.time < 1 + EXCESS), (1 + EXCESS, True)), 1.0), 3.0, lambda e: e**2 / 2 + e * (2 - e),
    ),
    "the torque swings above": (_held((1 + EXCESS) * gb.sin(gb.time), 1.0), mp.pi / 2, _swing),
    "the capacity swings below": (_held(1.0, 2 + (1 + EXCESS) * gb.cos(gb.time)), mp.pi, _swing),
    "the capacity goes slowly below": (_held(-1.0, 1 + EXCESS * gb.cos(gb.time)), 3.0, lambda e: -e * (1 - mp.sin(3))),
}  # fmt: skip


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("case", [pytest.param(case, marks=[pytest.mark.long] * ("slowly" in case)) for case in CASES])
@pytest.mark.few(1)
def test_a_break_away_by_a_small_margin_is_right_at_every_tolerance(case, method):
    rig, t_end, speed = CASES[case]
    model = gb.build(rig)
    for excess in (1e-2, 1e-4, 1e-6):
        for rtol in (1e-3, 1e-4, 1e-6, 1e-9, 1e-10):
            run = gb.simulate(model, t_end=float(t_end), method=method, rtol=rtol, parameters={"excess": excess})
            rounding = 1e-15 / excess  # of torques of 1 that cancel
            assert run["j.w"][-1] == pytest.approx(float(speed(mp.mpf(excess))), rel=30 * rtol + rounding)
