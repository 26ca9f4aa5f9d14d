"""Orders of run-ups: amplitudes that are given, on lines and between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb


@pytest.fixture(scope="module")
def run() -> gb.Trajectory:
    """A shaft that runs up from 20 to 60 rad/s, and one that shakes with orders 7 and 12.5 of it beside the same."""
    rig, t = gb.Drivetrain("run-up"), gb.time
    w, angle = 20 + 4 * t, 20 * t + 2 * t**2
    rig.chain(rig.add("even", gb.Speed(w=w)), rig.add("shaft", gb.Inertia(J=1.0)))
    shaken = 0.3 * gb.cos(7 * angle) + 0.001 * w * gb.sin(12.5 * angle)
    rig.chain(rig.add("shaken", gb.Speed(w=shaken)), rig.add("disc", gb.Inertia(J=1.0)))
    return gb.simulate(rig, t=[0.0, 10.0], max_step=2e-3)


@pytest.mark.long
def test_tracks_are_the_amplitudes_that_were_given_at_every_speed(run: gb.Trajectory, tmp_path: Path) -> None:
    found = gb.orders(run, "disc.w", "shaft.w")
    assert found.speed[0] > 20 and found.speed[-1] < 60 and (np.diff(found.speed) > 0).all()
    # parts are 16 revolutions long: lines under Hann's window 1/16 apart, what changes within a part is a mean
    assert found.track(7.0) == pytest.approx(np.full(len(found.speed), 0.3), rel=1e-4)
    assert found.track(12.5) == pytest.approx(0.001 * found.speed, rel=0.04)  # w grows by half in the first part
    assert found.largest(2) == pytest.approx([7.0, 12.5])
    assert found.track(10.0).max() < 1e-5
    times = (found.speed - 20) / 4  # where the mean speed of a part is, which begins slower and lasts
    assert found.time == pytest.approx(times, abs=0.02)
    data = found.to_xarray()
    assert data.sizes == {"speed": len(found.speed), "order": 32 * 16 + 1} and data["speed"].attrs["units"] == "rad/s"
    found.plot(tmp_path / "orders.png")
    assert (tmp_path / "orders.png").stat().st_size > 10_000 and "largest 7, 12.5" in repr(found)


def test_an_order_between_two_lines_is_told_as_large(run: gb.Trajectory) -> None:
    found = gb.orders(run, "disc.w", "shaft.w", revolutions=15, highest=16, overlap=0.0)
    assert found.order[1] == pytest.approx(1 / 15)
    assert found.track(12.5).mean() == pytest.approx(0.001 * found.speed.mean(), rel=0.02)  # 187.5 lines


def test_what_has_no_orders_is_refused_by_name(run: gb.Trajectory) -> None:
    with pytest.raises(gb.ParameterError, match=r"'disc\.w' must keep its sign"):
        gb.orders(run, "disc.w", "disc.w")
    with pytest.raises(gb.ParameterError, match="less than revolutions = 16"):
        gb.orders(run, "disc.w", "shaft.w", before=1.0)
    with pytest.raises(gb.UnknownNameError, match=r"no output 'shaft\.speed'"):
        gb.orders(run, "disc.w", "shaft.speed")
    with pytest.raises(gb.ParameterError, match=r"overlap = 1.0 in \[0, 1\)"):
        gb.orders(run, "disc.w", "shaft.w", overlap=1.0)
    with pytest.raises(gb.ParameterError, match="order = 99 must lie between"):
        gb.orders(run, "disc.w", "shaft.w").track(99)
