"""What is logged under the name "gearblocks", and that it is silent where nobody listens."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path

import pytest

import gearblocks as gb
from gearblocks.errors import GearblocksWarning


def swing(k: float = 100.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("swing")
    rig.chain(rig.add("disc", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=k)), rig.add("wall", gb.Fixed()))
    return rig


def test_builds_and_runs_are_logged(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    with caplog.at_level(logging.DEBUG, "gearblocks"):
        gb.build(swing())
        caplog.clear()
        gb.simulate(swing(200.0), t_end=0.1)
    said = [record.getMessage() for record in caplog.records if record.name == "gearblocks"]
    assert "'swing': equations and C text are in the cache" in said and "'swing': its library is in the cache" in said
    assert said[-1].startswith("run of 'swing' to t = 0.1 s: ") and "steps" in said[-1]


def test_what_is_made_anew_is_logged_with_its_seconds(caplog: pytest.LogCaptureFixture) -> None:
    from gearblocks.model.build import _build
    from gearblocks.solver.cache import Cache

    with caplog.at_level(logging.INFO, "gearblocks"), pytest.MonkeyPatch.context() as patch:
        patch.setattr(Cache, "read", lambda self, kind, key: None)
        _build(swing().train())
    assert any("'swing': equations and C text made in" in record.getMessage() for record in caplog.records)


def test_a_warning_is_logged_as_well(caplog: pytest.LogCaptureFixture) -> None:
    mesh = gb.GearMesh(teeth=(20, 30), external=True, module=3.0, pressure_angle=0.35, k=1e8)
    with pytest.warns(GearblocksWarning):
        gb.Drivetrain("rig").add("mesh", mesh)
    (record,) = [one for one in caplog.records if one.name == "gearblocks"]
    assert record.levelno == logging.WARNING and "module = 3 m (normal module) is implausible" in record.getMessage()


def test_a_warning_appears_once_where_nobody_listens_to_the_log() -> None:
    code = (
        "import gearblocks as gb\n"
        "gb.Drivetrain('rig').add('m', gb.GearMesh(teeth=(20, 30), external=True, module=3.0, pressure_angle=0.35, k=1e8))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stderr.count("is implausible") == 1 and "GearblocksWarning" in done.stderr
