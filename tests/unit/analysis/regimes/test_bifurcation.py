"""Diagrams: what is carried from value to value, points that fail, labels of both kinds."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def _duffing(oscillator: Oscillator) -> gb.Drivetrain:
    force = gb.Parameter("force", 0.3)
    return oscillator(lambda drive, x, v: force * gb.cos(drive * gb.time) - x**3, k=0.4, c=0.1)


def test_the_state_is_carried_so_that_both_ways_differ_where_two_motions_stand_side_by_side(
    oscillator: Oscillator,
) -> None:
    # a hardening spring driven above its resonance: a large and a small motion between two folds
    rig = _duffing(oscillator)
    found = gb.bifurcation(
        rig,
        "drive",
        np.linspace(0.9, 3.0, 15),
        section=SECTION,
        of="disc.phi",
        transient=60,
        keep=33,
        parameters={"force": 0.6},
    )
    apart = np.abs(found.points[0, :, -1] - found.points[1, :, -1]) > 0.3
    assert 2 <= apart.sum() <= 12 and not apart[0] and not apart[-1]
    assert np.isfinite(found.points).all() and not found.messages
    run = gb.simulate(rig, t=2 * np.pi / 0.9 * np.arange(94), rtol=1e-10, parameters={"force": 0.6, "drive": 0.9})
    assert found.points[0, 0] == pytest.approx(run["disc.phi"][-33:], abs=1e-6)


@pytest.mark.long
def test_labels_say_which_protocol_they_come_from(oscillator: Oscillator, tmp_path: Path) -> None:
    rig, values = _duffing(oscillator), [0.2, 0.25]
    quick = gb.bifurcation(rig, "force", values, section=SECTION, of="disc.phi", transient=200, keep=33)
    full = gb.bifurcation(rig, "force", values, section=SECTION, of="disc.phi", transient=200, keep=33, labels="full")
    assert quick.labels == (("quick: period 1",) * 2,) * 2 and quick.regimes == ((None, None),) * 2
    assert full.labels == (("period 1",) * 2,) * 2
    assert all(one is not None and one.orbit is not None for row in full.regimes for one in row)
    data = full.to_xarray()
    assert (
        data["disc.phi"].attrs["units"] == "rad"
        and data["label"].sel(direction="down").values.tolist() == ["period 1"] * 2
    )
    full.to_csv(tmp_path / "diagram.csv")
    assert len((tmp_path / "diagram.csv").read_text().splitlines()) == 5
    figure = full.plot(tmp_path / "diagram.png")
    assert figure.axes[0].get_ylabel() == "disc.phi in mrad"
    assert "2 values of force" in repr(full)


@pytest.mark.long
def test_full_labels_are_the_same_on_any_workers(oscillator: Oscillator) -> None:
    gain = gb.Parameter("gain", 0.0)
    model = gb.build(oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gain * v - x**3 * gain, k=2.0, c=0.1))
    ask: dict[str, Any] = {"section": SECTION, "of": "disc.phi", "transient": 100, "labels": "full"}
    told: list[int] = []
    one = gb.bifurcation(model, "gain", [-0.1, 0.0, 0.05], **ask, threads=1, progress=lambda done, _: told.append(done))
    assert told == [1, 2, 3, 4, 5, 6] and one.labels == (("period 1",) * 3,) * 2
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        for more in ({"threads": 3}, {"executor": pool}):
            other = gb.bifurcation(model, "gain", [-0.1, 0.0, 0.05], **ask, **more)
            assert np.array_equal(other.points, one.points) and other.labels == one.labels
            for a, b in zip(one.regimes[0] + one.regimes[1], other.regimes[0] + other.regimes[1], strict=True):
                assert a is not None and b is not None and a.evidence == b.evidence
    with pytest.raises(gb.ParameterError, match="threads: with the state carried over"):
        gb.bifurcation(model, "gain", [0.0], section=SECTION, threads=2)


@pytest.mark.long
def test_a_point_that_diverges_is_named_and_its_neighbours_are_as_they_were(oscillator: Oscillator) -> None:
    gain = gb.Parameter("gain", 0.0)
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gain * v, k=2.0, c=0.1)
    ask = {"section": SECTION, "of": "disc.phi", "transient": 2000, "keep": 33}
    found = gb.bifurcation(rig, "gain", [0.0, 1.0], **ask)
    alone = gb.bifurcation(rig, "gain", [0.0], **ask)
    assert [row[1] for row in found.labels] == ["diverged", "diverged"]
    assert set(found.messages) == {("up", 1.0), ("down", 1.0)}
    assert np.isnan(found.points[:, 1]).all() and np.array_equal(found.points[0, 0], alone.points[0, 0])


def test_what_cannot_be_drawn_is_refused_by_name(oscillator: Oscillator) -> None:
    rig = _duffing(oscillator)
    with pytest.raises(gb.ParameterError, match="must be finite and increase"):
        gb.bifurcation(rig, "force", [0.2, 0.1], section=SECTION)
    with pytest.raises(gb.ParameterError, match="labels = 'best' must be 'quick' or 'full'"):
        gb.bifurcation(rig, "force", [0.1], section=SECTION, labels="best")
    with pytest.raises(gb.UnknownNameError, match=r"disc\.fi"):
        gb.bifurcation(rig, "force", [0.1], section=SECTION, of="disc.fi")


def _grows(oscillator: Oscillator) -> gb.Drivetrain:
    gain = gb.Parameter("gain", 0.0)
    return oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gain * v, k=2.0, c=0.1)


GAINS = np.linspace(-0.2, 1.0, 10)
FREE: dict[str, Any] = {"section": SECTION, "of": "disc.phi", "transient": 2000, "keep": 33, "carry": False}


@pytest.mark.long
def test_a_diagram_from_the_start_is_a_study_whose_diverging_points_are_named(
    oscillator: Oscillator, tmp_path: Path
) -> None:
    rig = _grows(oscillator)
    found = gb.bifurcation(rig, "gain", GAINS, **FREE)
    grows = GAINS > 0.1
    assert found.directions == ("start",) and found.points.shape == (1, 10, 33)
    assert found.labels == (tuple("diverged" if g else "quick: period 1" for g in grows),)
    assert set(found.messages) == {("start", float(gain)) for gain in GAINS[grows]}
    assert all("grows without bound" in words for words in found.messages.values())
    alone = gb.bifurcation(rig, "gain", GAINS[~grows], **FREE)
    assert np.array_equal(found.points[0, ~grows], alone.points[0]) and np.isnan(found.points[0, grows]).all()
    carried = gb.bifurcation(rig, "gain", GAINS[~grows], **{**FREE, "carry": True})
    assert found.points[0, ~grows, -1] == pytest.approx(carried.points[0, :, -1], abs=1e-6)
    found.plot(tmp_path / "diagram.png")
    assert found.to_xarray().sizes["direction"] == 1 and "start: 7 diverged, 3 quick: period 1" in repr(found)


@pytest.mark.long
def test_a_diagram_that_was_killed_and_goes_on_is_the_undisturbed_one(oscillator: Oscillator, tmp_path: Path) -> None:
    rig = _grows(oscillator)
    whole = gb.bifurcation(rig, "gain", GAINS, **FREE)

    def killed(done: int, total: int) -> None:
        if 2 <= done < total:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        gb.bifurcation(rig, "gain", GAINS, threads=1, store=tmp_path / "d.zarr", progress=killed, **FREE)
    told: list[int] = []
    again = gb.bifurcation(
        rig, "gain", GAINS, threads=2, store=tmp_path / "d.zarr", progress=lambda done, total: told.append(done), **FREE
    )
    assert told[0] > 2  # what was done is not done again
    assert np.array_equal(again.points, whole.points, equal_nan=True)
    assert again.labels == whole.labels and again.messages == whole.messages


def test_what_cannot_be_carried_and_spread_is_refused_by_name(oscillator: Oscillator, tmp_path: Path) -> None:
    rig = _grows(oscillator)
    with pytest.raises(gb.ParameterError, match="threads: with the state carried over"):
        gb.bifurcation(rig, "gain", GAINS, section=SECTION, store=tmp_path / "d", threads=2)
    with pytest.raises(gb.ParameterError, match="labels = 'full' needs carry=True"):
        gb.bifurcation(rig, "gain", GAINS, **FREE, labels="full")
