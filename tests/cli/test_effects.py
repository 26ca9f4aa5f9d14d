"""gearblocks effects: the price of each effect of a scene, the fitted train, and what it writes."""

from __future__ import annotations

from pathlib import Path

import pytest

import gearblocks as gb
from gearblocks.cli.main import main

SCRIPT = '''"""Two discs: a gap that a preload keeps closed, a shaft whose damping decides how it rings."""

import gearblocks as gb


def build() -> gb.Drivetrain:
    rig = gb.Drivetrain("discs")
    left, right = rig.add("left", gb.Inertia(J=0.5, w0=0.1)), rig.add("right", gb.Inertia(J=0.5))
    drive, shaft = rig.add("drive", gb.Torque(tau=3.0)), rig.add("shaft", gb.Shaft(k=200.0, c=0.5))
    rig.chain(drive, left, shaft, right, rig.add("wall", gb.Damper(c=1.0)), rig.add("ground", gb.Fixed()))
    rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=1e-4, viscous=1e-7)).a, left.b)
    return rig


def rings() -> gb.Scene:
    """How far the shaft is twisted."""
    return gb.Scene(build(), t_end=0.5, quantity=gb.peak("left.w"), within=0.01)
'''


def test_effects_are_priced_and_the_fitted_train_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script, lean = tmp_path / "discs.py", tmp_path / "lean.json"
    script.write_text(SCRIPT, encoding="utf-8")
    assert main(["effects", str(script), "--out", str(lean)]) == 0
    out = capsys.readouterr().out
    assert "discs: peak(left.w) within 1 %, from 0 to 0.5 s" in out and "bearing.viscous" in out
    left = gb.Drivetrain.from_json(lean).effects()
    assert "bearing.viscous" not in left and "shaft.damping" in left
    assert main(["effects", str(script), "--no-fit", "--within", "0.5"]) == 0
    out = capsys.readouterr().out
    assert "within 50 %" in out and "trains built" not in out


def test_what_is_no_scene_or_no_share_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "discs.py").write_text(SCRIPT, encoding="utf-8")
    assert main(["effects", f"{tmp_path / 'discs.py'}:build"]) == 2
    assert "rings" in capsys.readouterr().err
    assert main(["effects", str(tmp_path / "discs.py"), "--within", "2"]) == 2
    assert "within = 2.0 must be a share of the value between 0 and 1" in capsys.readouterr().err
