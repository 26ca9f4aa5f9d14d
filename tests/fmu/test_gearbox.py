"""The automatic gearbox packed: shifts, clutches and brakes at any communication step."""

from __future__ import annotations

import importlib.util
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import Instance, Unpacked


def _shipped() -> Any:
    path = Path(__file__).parents[2] / "models" / "automatic_gearbox.py"
    spec = importlib.util.spec_from_file_location("automatic_gearbox_packed", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def model() -> gb.Model:
    """The car with its driver, built once."""
    return gb.build(_shipped().build())


@pytest.fixture(scope="module")
def packed(model: gb.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its FMU."""
    return fmu_export.export(model, tmp_path_factory.mktemp("gearbox") / "gearbox.fmu", t_end=60.0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("t_end", "steps"),
    [
        pytest.param(60.0, 600, id="100 ms"),
        pytest.param(60.0, 6000, id="10 ms", marks=pytest.mark.long),
        pytest.param(6.0, 6000, id="1 ms", marks=pytest.mark.long),
    ],
)
def test_it_passes_every_check_at_any_step(packed: Path, t_end: float, steps: int) -> None:
    report = fmu_export.check(packed, t_end=t_end, steps=steps)
    assert all(item.ok is not False for item in report.items), str(report)
    assert max(difference for _, difference in report.differences) == 0.0


@pytest.mark.long
def test_steps_that_end_exactly_on_an_event_change_nothing(model: gb.Model, packed: Path, tmp_path: Path) -> None:
    run = gb.simulate(model, t_end=12.0)
    events = sorted({e.t for e in run.events if e.component in ("c1", "c2", "b1", "b2", "brake")})
    times = np.array([0.0, *events, 12.0])
    assert len(events) > 5
    names = ["crank.w", "ring.w", "car.v", "b1.w_rel", "c2.torque"]
    exact = gb.simulate(
        model, t=np.array([*times, 60.0]), outputs=names
    )  # to the stop time of the FMU, for equal steps
    fmpy.extract(str(packed), str(tmp_path))
    unpacked = Unpacked(tmp_path, fmpy.read_model_description(str(tmp_path)))
    by_name = {v.name: v.valueReference for v in unpacked.description.modelVariables}
    with Instance(unpacked) as instance:
        instance.start(stop=60.0)
        for before, now in pairwise(times):
            instance.step(before, now - before)
            values = instance.get([by_name[n] for n in names])
            at = np.flatnonzero(exact.t == now)[-1]
            assert values == [exact[n][at] for n in names], now
