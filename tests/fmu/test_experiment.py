"""What an experiment asks for: its start time, the largest step inside, and which messages are wanted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import Instance, Unpacked
from gearblocks.solver.library import Model

WINDOW = 0.01
"""Over a period of the torque on the wheel, sin(800 t)."""


def _true(model: Model, begin: float) -> tuple[float, float]:
    """Angle and speed of the wheel after the window, to many digits."""
    run = gb.simulate(model, t=[begin + WINDOW], t_start=begin, rtol=1e-12)
    return float(run["wheel.phi"][0]), float(run["wheel.w"][0])


@pytest.mark.parametrize("begin", [0.0, 0.0013, -2.5, 40.0])
def test_a_run_begins_at_the_start_time(
    model: Model, unpacked: Unpacked, references: dict[str, int], begin: float
) -> None:
    true = _true(model, begin)
    if begin == 0.0013:
        assert true != pytest.approx(_true(model, 0.0), rel=1e-2)
    with Instance(unpacked) as instance:
        instance.set([references["solver.rtol"]], [1e-10])
        instance.start(begin)
        assert instance.get([references["time"]]) == [begin]
        instance.step(begin, WINDOW)
        found = instance.get([references[name] for name in ("wheel.phi", "wheel.w", "time")])
    assert found == pytest.approx([*true, begin + WINDOW], rel=1e-7)


def test_no_step_inside_is_longer_than_the_largest_one(
    model: Model, tmp_path: Path, unpacker: Callable[[Path, Path], Unpacked]
) -> None:
    off = []
    for name, largest in (("free", None), ("short", 2e-5)):
        path = fmu_export.export(model, tmp_path / f"{name}.fmu", t_end=0.1, rtol=1e-3, max_step=largest)
        unpacked = unpacker(path, tmp_path / name)
        refs = {v.name: v.valueReference for v in unpacked.description.modelVariables}
        with Instance(unpacked) as instance:
            instance.start()
            instance.step(0.0, WINDOW)
            found = np.array(instance.get([refs["wheel.phi"], refs["wheel.w"]]))
        off.append(np.abs(found / _true(model, 0.0) - 1).max())
    assert off[1] < 1e-9 and off[0] > 1e3 * off[1]


def test_messages_come_in_the_categories_that_are_turned_on(unpacked: Unpacked) -> None:
    with Instance(unpacked) as instance:

        def lines() -> int:
            before = len(instance.log)
            instance.status_of(lambda: instance.fmu.doStep(0.0, 1.0))  # before the initialization
            return len(instance.log) - before

        assert lines() == 1
        for on, categories, expected in (
            (False, ["logStatusError"], 0), (True, ["logEvents"], 0), (True, ["logStatusError"], 1),
            (False, ["logEvents"], 1), (False, [], 0), (True, ["logAll"], 1),
        ):  # fmt: skip
            instance.fmu.setDebugLogging(on, categories)
            assert lines() == expected, (on, categories)
