"""The shipped spline coupling as an FMU at three communication steps, against a tight reference."""

import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest

import fmu_export
import gearblocks as gb

sys.path.insert(0, str(Path(__file__).parents[2] / "models"))
import spline_coupling

NAMES = ("x1", "x2", "x3")
END = 1.0


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(spline_coupling.build(300))


@pytest.fixture(scope="module")
def fmu(model: gb.Model, tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(fmu_export.export(model, tmp_path_factory.mktemp("spline") / "spline.fmu", outputs=["x*"], rtol=1e-6))


@pytest.mark.long
@pytest.mark.parametrize("step", [1e-3, 7e-4, 1e-5])
def test_the_communication_step_adds_nothing_to_the_error(model: gb.Model, fmu: str, step: float) -> None:
    result = fmpy.simulate_fmu(fmu, stop_time=END, step_size=step, output_interval=step)
    t = result["time"]
    assert abs(t[-1] - END) <= step
    own = gb.simulate(model, t=t, rtol=1e-6, outputs=NAMES)
    true = gb.simulate(model, t=t, rtol=1e-12, outputs=NAMES)
    for name in NAMES:
        scale = np.abs(true[name]).max()
        in_process = np.abs(own[name] - true[name]).max() / scale
        packed = np.abs(result[name] - true[name]).max() / scale
        assert in_process < 1e-5  # rtol 1e-6 over five periods
        assert packed <= 10 * in_process
