"""Basins of attraction: starts and the attractors that they end on, against another program."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")
STATES = ["disc.phi", "disc.w"]


def _wells(oscillator: Oscillator) -> gb.Drivetrain:
    """x'' + 0.15 x' - x + x^3 = 0.1 cos t: a small and a large motion in each of two wells."""
    return oscillator(lambda drive, x, v: 0.1 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.15)


@pytest.mark.long
def test_each_start_has_the_attractor_that_another_program_ends_on(oscillator: Oscillator, tmp_path: Path) -> None:
    from scipy.integrate import solve_ivp

    grid = {"disc.phi": np.linspace(-2, 2, 12), "disc.w": np.linspace(-1.5, 1.5, 9)}
    found = gb.basins(_wells(oscillator), grid, section=SECTION, of=STATES, transient=60)
    assert found.numbers.shape == (12, 9) and found.numbers.min() >= 0 and found.messages == {}
    assert [one.label for one in found.attractors] == ["period 1"] * 4
    assert sum(one.share for one in found.attractors) == pytest.approx(1.0)
    for i, j in [(0, 0), (2, 5), (4, 8), (5, 2), (7, 7), (9, 1), (10, 3), (11, 8)]:
        start = found.levels[0][i], found.levels[1][j]
        run = solve_ivp(
            lambda t, y: (y[1], 0.1 * np.cos(t) - 0.15 * y[1] + y[0] - y[0] ** 3), (0, 2 * np.pi * 92), start, "DOP853",
            rtol=1e-9, atol=1e-10,
        )  # fmt: skip
        off = [np.abs(one.points[0] - run.y[:, -1]).max() for one in found.attractors]
        assert int(np.argmin(off)) == found.numbers[i, j] and min(off) < 1e-2
    data = found.to_xarray()
    assert data.sizes == {"disc.phi": 12, "disc.w": 9} and data["disc.w"].attrs["units"] == "rad/s"
    found.plot(tmp_path / "basins.png")
    assert (tmp_path / "basins.png").stat().st_size > 10_000 and "period 1" in repr(found)


def test_motions_in_another_phase_of_one_orbit_end_on_one_attractor(oscillator: Oscillator) -> None:
    # x'' + 0.3 x' - x + x^3 = 0.28 cos 1.2 t: one motion of period 2 in each well, met in either phase
    rig = oscillator(lambda drive, x, v: 0.28 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.3)
    grid = {"disc.phi": np.linspace(-1.5, 1.5, 8), "disc.w": np.linspace(-0.9, 1.0, 4)}
    ask: dict[str, Any] = {"section": SECTION, "of": STATES, "labels": "quick", "parameters": {"drive": 1.2}}
    even, odd = (gb.basins(rig, grid, transient=transient, **ask) for transient in (300, 301))
    assert [one.label for one in even.attractors] == ["quick: period 2"] * 2
    assert np.array_equal(even.numbers, odd.numbers)
    assert even.attractors[0].points == pytest.approx(odd.attractors[0].points[::-1], abs=1e-5)


def test_starts_that_fail_or_do_not_settle_are_shown_for_what_they_are(oscillator: Oscillator) -> None:
    # x'' + 0.05 x' + x = 0.1 cos t + a (x^3 + ...): beyond the hill the motion escapes; undamped it does not settle
    c = gb.Parameter("c", 0.2)
    rig = oscillator(lambda drive, x, v: 0.1 * gb.cos(drive * gb.time) + 0.5 * x**3 - c * v, k=2.0, c=0.0)
    grid = {"disc.phi": [0.1, 5.0], "c": [0.0, 0.2]}
    found = gb.basins(rig, grid, section=SECTION, of=STATES, transient=60, labels="quick")
    assert found.numbers.tolist() == [[-1, 0], [-2, -2]] and set(found.messages) == {2, 3}
    assert [one.label for one in found.attractors] == ["quick: period 1", "quick: not periodic"]
    assert found.attractors[0].start == {"disc.phi": 0.1, "c": 0.2}


def test_a_study_of_basins_that_was_stopped_goes_on(oscillator: Oscillator, tmp_path: Path) -> None:
    grid = {"disc.phi": np.linspace(-2, 2, 8), "disc.w": [0.0, 0.5]}
    ask: dict[str, Any] = {"section": SECTION, "of": STATES, "transient": 60, "labels": "quick"}
    whole = gb.basins(_wells(oscillator), grid, **ask)

    def stop(done: int, total: int) -> None:
        if done >= 4:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        gb.basins(_wells(oscillator), grid, store=tmp_path / "b.zarr", threads=1, progress=stop, **ask)
    again = gb.basins(_wells(oscillator), grid, store=tmp_path / "b.zarr", **ask)
    assert np.array_equal(again.numbers, whole.numbers)
    assert all(np.array_equal(a.points, b.points) for a, b in zip(again.attractors, whole.attractors, strict=True))


def test_what_has_no_basins_is_refused_by_name(oscillator: Oscillator) -> None:
    rig = _wells(oscillator)
    with pytest.raises(gb.ParameterError, match="basins are over two paths, not 1"):
        gb.basins(rig, {"disc.phi": [0.0]}, section=SECTION)
    with pytest.raises(gb.UnknownNameError, match=r"disc\.fi"):
        gb.basins(rig, {"disc.fi": [0.0], "disc.w": [0.0]}, section=SECTION)
    with pytest.raises(gb.UnknownNameError, match=r"no output matches disc\.x"):
        gb.basins(rig, {"disc.phi": [0.0], "disc.w": [0.0]}, section=SECTION, of="disc.x")
