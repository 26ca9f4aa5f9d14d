"""Diagrams whose state is carried over, killed on the way and called again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import StorageError

Oscillator = Callable[..., gb.Drivetrain]
ASK: dict[str, Any] = {"section": gb.stroboscopic("drive"), "of": "disc.phi", "transient": 60, "keep": 33}
FORCES = [5.0, 5.28, 5.6, 8.0]  # of Ueda's oscillator: period 2, 4, chaos
GAINS = [0.0, 0.02, 1.0, 2.0]


def _ueda(oscillator: Oscillator) -> gb.Drivetrain:
    force = gb.Parameter("force", 5.0)
    return oscillator(lambda drive, x, v: force * gb.cos(drive * gb.time) - x**3, k=1e-12)


def _grows(oscillator: Oscillator) -> gb.Drivetrain:
    gain = gb.Parameter("gain", 0.0)
    return oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gain * v, k=2.0, c=0.1)


def _killed_after(number: int) -> Callable[[int, int], None]:
    def killed(done: int, total: int) -> None:
        if number <= done < total:
            raise ZeroDivisionError

    return killed


def _alike(one: Any, other: Any) -> bool:
    """Whether two regimes are the same, with all that they rest on."""
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    if hasattr(one, "__dataclass_fields__"):
        return all(_alike(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_alike, one, other))
    return bool(one == other)


@pytest.mark.parametrize("labels", ["quick", pytest.param("full", marks=pytest.mark.long)])
def test_a_carried_diagram_that_was_killed_goes_on_and_is_the_undisturbed_one(
    oscillator: Oscillator, tmp_path: Path, labels: str
) -> None:
    model = gb.build(_ueda(oscillator))
    ask = {**ASK, "labels": labels, **({"threads": 1} if labels == "full" else {})}
    whole = gb.bifurcation(model, "force", FORCES, **ask)
    with pytest.raises(ZeroDivisionError):
        gb.bifurcation(model, "force", FORCES, store=tmp_path / "d", progress=_killed_after(5), **ask)
    assert len([*(tmp_path / "d").glob("*.npz")]) == 5
    (tmp_path / "d" / "up-0001.npz").write_bytes(b"torn")  # and a file that is broken
    told: list[int] = []
    again = gb.bifurcation(model, "force", FORCES, store=tmp_path / "d", progress=lambda n, _: told.append(n), **ask)
    assert told == [5, 6, 7, 8]
    finished = gb.bifurcation(model, "force", FORCES, store=tmp_path / "d", progress=lambda n, _: told.append(n), **ask)
    assert len(told) == 4  # nothing is left to do
    for found in (again, finished):
        assert np.array_equal(found.points, whole.points) and found.labels == whole.labels
        assert all(map(_alike, found.regimes[0] + found.regimes[1], whole.regimes[0] + whole.regimes[1]))
    if labels == "full":
        assert {"chaotic", "period 4"} <= {label for row in whole.labels for label in row}


def test_a_diverging_point_is_named_again_from_the_store(oscillator: Oscillator, tmp_path: Path) -> None:
    model, ask = gb.build(_grows(oscillator)), {**ASK, "transient": 2000}
    whole = gb.bifurcation(model, "gain", GAINS, **ask)
    assert [row.count("diverged") for row in whole.labels] == [2, 2]
    with pytest.raises(ZeroDivisionError):
        gb.bifurcation(model, "gain", GAINS, store=tmp_path / "d", progress=_killed_after(3), **ask)
    again = gb.bifurcation(model, "gain", GAINS, store=tmp_path / "d", **ask)
    assert np.array_equal(again.points, whole.points, equal_nan=True)
    assert again.labels == whole.labels and again.messages == whole.messages


def test_a_store_of_something_else_is_left_alone(oscillator: Oscillator, tmp_path: Path) -> None:
    model = gb.build(_ueda(oscillator))
    gb.bifurcation(model, "force", FORCES[:1], store=tmp_path / "d", **ASK)
    with pytest.raises(StorageError, match=r"another diagram \(what differs: the values\)"):
        gb.bifurcation(model, "force", [5.1], store=tmp_path / "d", **ASK)
    with pytest.raises(StorageError, match=r"what differs: the periods"):
        gb.bifurcation(model, "force", FORCES[:1], store=tmp_path / "d", **{**ASK, "keep": 40})
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "a.txt").write_text("mine")
    with pytest.raises(StorageError, match="no store of a diagram and is left alone"):
        gb.bifurcation(model, "force", FORCES[:1], store=tmp_path / "notes", **ASK)
    assert [file.name for file in (tmp_path / "notes").iterdir()] == ["a.txt"]


def test_the_progress_says_which_labels_there_are(oscillator: Oscillator, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []

    class Heard:
        def __init__(self, name: str) -> None: ...
        def __call__(self, share: float, words: str) -> None:
            said.append(words)

        def close(self) -> None: ...

    monkeypatch.setattr("gearblocks.analysis.study_progress.Progress", Heard)
    monkeypatch.setattr("sys.stderr.isatty", lambda: False)
    gb.bifurcation(_ueda(oscillator), "force", FORCES[:2], **ASK)
    assert said == [f"{k} of 4 points: {k} quick: not periodic" for k in range(1, 5)]
