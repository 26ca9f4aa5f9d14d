"""Where an FMU starts from: what `initial` takes in a run it takes here, with the parameters that belong to it."""

from __future__ import annotations

import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree

import fmu_export
import gearblocks as gb


def _rig(torque: Any = None) -> gb.Drivetrain:
    rig = gb.Drivetrain("wound up")
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", start=2.0, unit="N m") if torque is None else torque))
    shaft = rig.add("shaft", gb.Shaft(k=200.0, c=0.1))
    rig.chain(drive, rig.add("disc", gb.Inertia(J=0.1)), shaft, rig.add("wall", gb.Fixed()))
    return rig


def _starts(path: Path) -> dict[str, float]:
    with zipfile.ZipFile(path) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    return {v.get("name"): float(v[0].get("start")) for v in root.find("ModelVariables") if v[0].get("start")}


def test_an_fmu_of_a_run_has_the_parameters_of_the_run_and_those_given_instead(tmp_path: Path) -> None:
    rig = _rig()
    run = gb.simulate(rig, t_end=0.1, parameters={"shaft.k": 100.0, "disc.J": 0.2})
    starts = _starts(fmu_export.export(rig, tmp_path / "later.fmu", initial=run, platforms=()))
    assert (starts["shaft.k"], starts["disc.J"], starts["disc.w.start"]) == (100.0, 0.2, run["disc.w"][-1])
    given = {"shaft.k": "300 N m/rad"}
    starts = _starts(fmu_export.export(rig, tmp_path / "given.fmu", initial=run, parameters=given, platforms=()))
    assert (starts["shaft.k"], starts["disc.J"]) == (300.0, 0.2)


def test_an_fmu_goes_on_as_a_run_does_with_other_parameters(tmp_path: Path) -> None:
    from fmpy import simulate_fmu

    rig = _rig(2.0 + gb.sin(30.0 * gb.time))
    before = gb.simulate(rig, t_end=0.1, parameters={"shaft.k": 100.0})
    with pytest.warns(gb.GearblocksWarning, match=r"ended at t = 0\.1 s.*give 0\.1 s as its start time"):
        path = fmu_export.export(rig, tmp_path / "later.fmu", initial=before, outputs="disc.*")
    found = simulate_fmu(str(path), start_time=0.1, stop_time=0.3, output_interval=0.02)
    run = gb.simulate(rig, t=found["time"], initial=before)
    for name in ("disc.phi", "disc.w"):
        # the importer's sum of its steps misses the end by a rounding of time, which the last step inside sees
        np.testing.assert_allclose(found[name], run[name], rtol=0, atol=1e-13, err_msg=name)


@pytest.mark.parametrize("torque", [2.0, gb.Table([0.0, 0.5, 0.6], [1.0, 1.0, 2.0])], ids=["always", "later"])
def test_the_time_of_a_run_is_spoken_of_where_it_matters_alone(tmp_path: Path, torque: Any) -> None:
    rig = _rig(torque)
    run = gb.simulate(rig, t_end=0.1)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        fmu_export.export(rig, tmp_path / "later.fmu", initial=run, platforms=())
    assert len([w for w in told if "the train follows time" in str(w.message)]) == (torque != 2.0)


def test_an_fmu_of_a_train_starts_in_its_equilibrium(tmp_path: Path) -> None:
    path = fmu_export.export(
        _rig(), tmp_path / "static.fmu", initial="static", parameters={"shaft.k": 100.0}, platforms=()
    )
    assert _starts(path)["shaft.coordinate.start"] == pytest.approx(-2.0 / 100.0)


@pytest.mark.parametrize("initial", ["statik", 3.0, [1.0, "a"], object()])
def test_what_says_no_start_is_refused_by_words(tmp_path: Path, initial: Any) -> None:
    with pytest.raises(
        gb.ParameterError, match=r"initial = .* must be start values such as .* an earlier run, 'static'"
    ):
        fmu_export.export(_rig(), tmp_path / "rig.fmu", initial=initial, platforms=())
    with pytest.raises(
        gb.ParameterError, match=r"initial has shape .* a state vector has .* entries: give an earlier run"
    ):
        fmu_export.export(_rig(), tmp_path / "rig.fmu", initial=[1.0], platforms=())
