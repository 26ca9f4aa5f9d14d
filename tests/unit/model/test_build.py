"""Models are built in hostile surroundings: a cache that is damaged, full, gone or shared costs only time."""

import multiprocessing
import os
import shutil
import warnings
from pathlib import Path
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.errors import GearblocksWarning


def _speed(name: str = "cached") -> float:
    rig = gb.Drivetrain(name)
    rig.chain(rig.add("t", gb.Torque(tau=1.0)), rig.add("i", gb.Inertia(J=1.0)))
    return float(gb.simulate(rig, t_end=1.0)["i.w"][-1])


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "cache"
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(place))
    return place


def test_a_cache_that_cannot_be_written_is_named_once_and_the_run_is_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.warns(GearblocksWarning, match="cannot be written.*GEARBLOCKS_CACHE") as caught:
        assert _speed() == pytest.approx(1.0, rel=1e-12)
    assert len([w for w in caught if issubclass(w.category, GearblocksWarning)]) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _speed() == pytest.approx(1.0, rel=1e-12)


@pytest.mark.long
def test_a_full_disk_under_the_cache_is_named_and_the_run_is_right(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = os.replace

    def full(source: Any, target: Any) -> None:
        if str(target).startswith(str(cache)):
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    with pytest.warns(GearblocksWarning, match="no space left on device"):
        assert _speed() == pytest.approx(1.0, rel=1e-12)


def _elsewhere(processes: int = 1) -> list[float]:
    """The speed from as many fresh processes at once."""
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        return pool.map(_speed, ["elsewhere"] * processes, chunksize=1)


@pytest.mark.long
def test_damaged_entries_of_the_cache_are_made_anew(cache: Path) -> None:
    assert _elsewhere() == [pytest.approx(1.0, rel=1e-12)]
    for damage in (b"", b"\0" * 4096):
        entries = [path for path in cache.rglob("*") if path.is_file()]
        assert len(entries) > 4
        for path in entries:
            path.write_bytes(damage)
        assert _elsewhere() == [pytest.approx(1.0, rel=1e-12)]


@pytest.mark.long
def test_a_cache_that_vanishes_is_made_anew(cache: Path) -> None:
    for _ in range(2):
        assert _speed() == pytest.approx(1.0, rel=1e-12)
        shutil.rmtree(cache)


@pytest.mark.long
def test_two_processes_that_build_one_model_at_once_both_run(cache: Path) -> None:
    assert _elsewhere(2) == [pytest.approx(1.0, rel=1e-12)] * 2
