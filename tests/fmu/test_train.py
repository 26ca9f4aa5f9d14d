"""A train from blocks, packed: the file gives the same numbers as gearblocks itself."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import Instance, Unpacked


@pytest.fixture(scope="module")
def rig() -> gb.Drivetrain:
    """A spur pair on a test rig with play, varying stiffness, a torque input and a tunable speed."""
    speed = gb.Parameter("speed", 300.0, "rad/s")
    rig = gb.Drivetrain("spur pair on a test rig")
    mesh = gb.GearMesh(
        teeth=(23, 41),
        module=3e-3,
        pressure_angle=np.deg2rad(20),
        external=True,
        k=2.0e8,
        damping_ratio=0.05,
        stiffness_variation=gb.Fourier(cos=(0.2,)),
        backlash=gb.Backlash(half_gap=30e-6),
    )
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=20.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02)),
        rig.add("shaft", gb.Shaft(k=2.0e4, c=3.0)),
        rig.add("pinion", gb.Inertia(J=2.0e-4)),
        rig.add("mesh", mesh),
        rig.add("wheel", gb.Inertia(J=0.05)),
        rig.add("load", gb.Torque(tau=35.0 + 5.0 * gb.sin(speed * gb.time))),
    )
    return rig


def test_a_train_passes_every_check(rig: gb.Drivetrain, tmp_path: Path) -> None:
    report = fmu_export.check(fmu_export.export(rig, tmp_path / "rig.fmu", t_end=0.05))
    assert all(item.ok for item in report.items), str(report)
    assert max(difference for _, difference in report.differences) == 0.0


@pytest.mark.long
def test_fmpy_and_simulate_give_equal_bits(rig: gb.Drivetrain, tmp_path: Path) -> None:
    changed = {"mesh.backlash.half_gap": 40e-6, "speed": 450.0}
    path = fmu_export.export(rig, tmp_path / "rig.fmu", parameters=changed, initial={"motor.w": 50.0}, rtol=1e-8)
    result = fmpy.simulate_fmu(str(path), stop_time=0.05, output_interval=1e-4)
    run = gb.simulate(rig, t=result["time"], parameters=changed, initial={"motor.w": 50.0}, rtol=1e-8)
    for name in result.dtype.names[1:]:
        np.testing.assert_array_equal(result[name], run[name], err_msg=name)


@pytest.mark.long
def test_the_unknown_acceleration_of_a_shaft_without_inertia_is_left_out(tmp_path: Path) -> None:
    rig = gb.Drivetrain("row")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=1.0, phi0=0.3))
    left, right = rig.add("left", gb.Shaft(k=100.0)), rig.add("right", gb.Shaft(k=200.0))
    rig.chain(one, left, rig.add("node", gb.Inertia(J=0.0)), right, two)
    path = fmu_export.export(rig, tmp_path / "row.fmu", rtol=1e-8)
    result = fmpy.simulate_fmu(str(path), stop_time=0.05, output_interval=1e-3)
    run = gb.simulate(rig, t=result["time"], rtol=1e-8)
    assert set(run.names) - set(result.dtype.names) == {"node.alpha"}
    for name in result.dtype.names[1:]:
        np.testing.assert_array_equal(result[name], run[name], err_msg=name)
    with pytest.raises(gb.ParameterError, match=r"'node\.alpha' is not known: its shaft has no inertia"):
        fmu_export.export(rig, tmp_path / "other.fmu", outputs=["node.alpha"])


@pytest.mark.long
def test_parameters_set_in_the_fmu_are_those_of_the_train(rig: gb.Drivetrain, tmp_path: Path) -> None:
    path = fmu_export.export(rig, tmp_path / "rig.fmu", outputs=["mesh.*"])
    values = {"mesh.k": 1.5e8, "shaft.k": 1.8e4, "tau": 25.0, "motor.w0": 10.0}
    result = fmpy.simulate_fmu(str(path), stop_time=0.02, output_interval=1e-3, start_values=values)
    run = gb.simulate(
        rig,
        t=result["time"],
        parameters={"mesh.k": 1.5e8, "shaft.k": 1.8e4},
        inputs={"tau": 25.0},
        initial={"motor.w": 10.0},
    )
    np.testing.assert_array_equal(result["mesh.force"], run["mesh.force"])


@pytest.mark.long
def test_a_run_goes_on_inside_the_fmu(rig: gb.Drivetrain, tmp_path: Path) -> None:
    """The file starts where an earlier run ended."""
    before = gb.simulate(rig, t_end=0.03)
    with pytest.warns(gb.GearblocksWarning, match="give 0.03 s as its start time to go on with the run"):
        path = fmu_export.export(rig, tmp_path / "later.fmu", initial=before, outputs=["mesh.*", "*.phi", "*.w"])
    result = fmpy.simulate_fmu(str(path), stop_time=0.01, output_interval=1e-3)
    for name in ("mesh.deflection", "motor.phi", "wheel.w"):
        assert result[name][0] == before[name][-1], name


CUBIC = gb.Table(np.linspace(0, 1, 7), (0.0, 0.2, 0.1, -0.1, -0.2, 0.05, 0.0), kind="cubic", periodic=True)


@pytest.mark.long
@pytest.mark.parametrize(
    "variation", [pytest.param(gb.Fourier(cos=(0.2,)), marks=pytest.mark.long), gb.Profile(table=CUBIC)]
)
def test_turns_that_are_counted_apart_survive_saving_and_restoring(
    tmp_path: Path, variation: Any, unpacker: Callable[[Path, Path], Unpacked]
) -> None:
    rig = gb.Drivetrain("pair")
    mesh = gb.GearMesh(
        teeth=(23, 41), r_base=(0.023, 0.041), external=True, k=1e4, damping_ratio=0.05, stiffness_variation=variation
    )
    rig.chain(rig.add("pinion", gb.Inertia(J=1e-3)), rig.add("mesh", mesh), rig.add("wheel", gb.Inertia(J=4e-3)))
    start = {"pinion.w": 90.0, "wheel.w": -90.0 * 23 / 41 + 1.0}
    path = fmu_export.export(rig, tmp_path / "pair.fmu", initial=start, t_end=2.0)
    result = fmpy.simulate_fmu(str(path), stop_time=2.0, output_interval=0.01)
    run = gb.simulate(rig, t=result["time"], initial=start)
    assert run["pinion.phi"][-1] > 100
    for name in result.dtype.names[1:]:
        np.testing.assert_array_equal(result[name], run[name], err_msg=name)
    refs = [v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables if v.causality == "output"]
    with Instance(unpacker(path, tmp_path / "unpacked")) as instance:
        instance.start()
        state, kept = None, []
        for i in range(100):
            if i == 37:
                state = instance.fmu.getFMUstate()
            instance.step(0.01 * i, 0.01)
            kept.append(instance.get(refs))
        instance.fmu.setFMUstate(state)
        for i in range(37, 100):
            instance.step(0.01 * i, 0.01)
            assert instance.get(refs) == kept[i]
        instance.fmu.freeFMUstate(state)
