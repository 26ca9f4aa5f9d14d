"""Heat ports, thermal masses and conductances in an FMU: heat flow and temperature are variables with units, and right."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

import fmu_export
import gearblocks as gb


@pytest.mark.long
def test_an_fmu_shows_heat_flow_and_temperature(tmp_path: Path) -> None:
    rig = gb.Drivetrain("stop on a disc brake")
    wheel = rig.add("wheel", gb.Inertia(J=2.0, w0=100.0))
    brake = gb.Brake(capacity=200.0 * (1 - 1e-3 * (gb.temperature - 293.15)), heat=gb.HeatPort(T="disc"))
    rig.chain(wheel, rig.add("brake", brake))
    rig.add("disc", gb.ThermalMass(C=450.0, T0=293.15))
    rig.add("air", gb.ThermalConductance(G=5.0, a="disc", b=gb.Input("T_air", start=293.15, unit="K")))
    path = tmp_path / "brake.fmu"
    fmu_export.export(rig, path, rtol=1e-8)
    known = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
    assert (
        known["disc.T"].unit == "K" and known["brake.heat_flow"].unit == "W" and known["brake.temperature"].unit == "K"
    )
    assert known["T_air"].causality == "input" and known["disc.C"].causality == "parameter"
    report = fmu_export.check(path)
    assert report.ok, report
    t = np.linspace(0.0, 2.0, 21)
    found = fmpy.simulate_fmu(
        str(path),
        stop_time=2.0,
        output_interval=0.1,
        start_values={"T_air": 283.15},
        output=["disc.T", "air.heat_flow"],
    )
    run = gb.simulate(rig, t=t, rtol=1e-8, inputs={"T_air": 283.15})
    assert np.allclose(found["disc.T"], run["disc.T"], rtol=1e-9, atol=0)
    assert run["disc.T"][-1] > 310.0
