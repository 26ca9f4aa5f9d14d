"""A torque that jumps over a speed or an angle, beside lossy gears: each side of the jump has its own losses (Filippov)."""

import numpy as np
import pytest

import gearblocks as gb

LONG = pytest.mark.long
METHODS = [pytest.param(m, marks=() if m == "dp5" else LONG) for m in ("dp5", "dp8", "rodas", "auto")]
W, ETA, RATIO, J = gb.sense("body.w"), (0.8, 0.7), 2.0, (1.0, 1.5)


def _geared(tau, pull=0.0, w0=0.0, gears=1):
    """A torque on a body, with gears to loads that something pulls."""
    rig = gb.Drivetrain("relay and gears")
    body = rig.add("body", gb.Inertia(J=J[0], w0=w0))
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), body)
    for k in range(gears):
        load = rig.add(f"load{k}", gb.Inertia(J=J[1], w0=w0 / RATIO))
        rig.chain(body, rig.add(f"gear{k}", gb.LossyGear(ratio=RATIO, efficiency=ETA)), load)
        rig.chain(load, rig.add(f"pull{k}", gb.Torque(tau=pull)))
    return rig


def _acceleration(tau, pull, gears=1):
    """Of the body: a gear takes in what leaves it, over eta where it drives and times eta where it is driven."""
    for gain in (1 / ETA[0], ETA[1]):
        found = (tau + gears * gain * pull / RATIO) / (J[0] + gears * gain * J[1] / RATIO**2)
        if (J[1] * found / RATIO - pull > 0) == (gain > 1):
            return found
    raise AssertionError


def _mean(up, down, pull, gears=1):
    """The torque that holds the speed, of two that jump."""
    below, above = _acceleration(up, pull, gears), _acceleration(down, pull, gears)
    share = below / (below - above)
    return (1 - share) * up + share * down if 0 <= share <= 1 else np.nan


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("gears", "rtol"), [(1, 1e-6), (1, 1e-9), (3, 1e-6)])
def test_a_governor_holds_its_speed_through_gears_whatever_drives(gears, rtol, method):
    """Pulls of either sign: gears drive on both sides, on one of them, or on none."""
    pull = 0.5 / gears * gb.sin(gb.time)
    rig = _geared(gb.piecewise((1.0, W < 1.0), (-1.5, True)), pull, gears=gears)
    run = gb.simulate(rig, t=np.linspace(8.0, 20.0, 49), method=method, rtol=rtol)
    assert run["body.w"] == pytest.approx(1.0, abs=10 * rtol)
    mean = [_mean(1.0, -1.5, 0.5 / gears * np.sin(t), gears) for t in run.t]
    assert run["drive.torque"] == pytest.approx(np.array(mean), abs=max(100 * rtol, 1e-7))
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize("method", METHODS)
def test_a_pull_beyond_both_sides_takes_it_along(method):
    """Pulled by 0.1 N m/s the loads drive, and overcome 1.5 N m less what is lost."""
    rig = _geared(gb.piecewise((1.0, W < 1.0), (-1.5, True)), 0.2 * gb.maximum(gb.time - 10.0, 0.0))
    run = gb.simulate(rig, t=[10.0, 35.0], method=method)
    leaves = 10.0 + 1.5 * RATIO / ETA[1] / 0.2
    assert run.events[-1].t == pytest.approx(leaves, rel=1e-6)
    rate = 0.2 * ETA[1] / RATIO / (J[0] + ETA[1] * J[1] / RATIO**2)
    assert run["body.w"] == pytest.approx([1.0, 1.0 + 0.5 * rate * (35.0 - leaves) ** 2], rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_gear_goes_with_a_limit_over_an_angle(method):
    """On its way from the start; the set point turns and turns back, and the direction of the losses with it."""
    phi = gb.sense("body.phi")
    steady = gb.simulate(
        _geared(gb.piecewise((1.0, phi < 0.3 * gb.time), (-1.0, True)), w0=0.3), t=[50.0], method=method
    )
    assert steady["body.phi"][0] == pytest.approx(15.0, rel=1e-6) and steady["body.w"][0] == pytest.approx(
        0.3, rel=1e-6
    )
    target = 0.3 * gb.sin(gb.time)
    run = gb.simulate(
        _geared(gb.piecewise((1.0, phi < target), (-1.0, True)), w0=0.3), t=np.arange(0.0, 20.0), method=method
    )
    assert run["body.phi"] == pytest.approx(0.3 * np.sin(run.t), abs=1e-5)
    assert run.energy.residual < 1e-5


@pytest.mark.parametrize("method", METHODS)
def test_a_set_point_of_a_speed_that_jumps_lets_it_off_and_catches_it_again(method):
    """A clutch beside it is stuck in between: one inertia of 3 kg m2, 1 N m up and 1.5 down."""
    rig = gb.Drivetrain("governed")
    target = gb.piecewise((1.0, gb.time < 10.0), (0.5, gb.time < 15.0), (2.0, True))
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((1.0, target > W), (-1.5, True))))
    body, other = rig.add("body", gb.Inertia(J=1.0)), rig.add("other", gb.Inertia(J=2.0))
    rig.chain(drive, body, rig.add("clutch", gb.Clutch(capacity=1.2)), other)
    run = gb.simulate(rig, t=[9.0, 10.5, 14.0, 16.0, 30.0], method=method)
    assert run["body.w"] == pytest.approx([1.0, 0.75, 0.5, 0.5 + 1 / 3, 2.0], abs=1e-9)
    assert run["other.w"] == pytest.approx(run["body.w"], abs=1e-9)
