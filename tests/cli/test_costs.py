"""gearblocks cost: the table and sentence of a scene, what it writes, and what it says where there is no scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from gearblocks.cli.main import main

SCRIPT = '''"""A motor that swings against the ground through a shaft with a gap."""

import gearblocks as gb


def build() -> gb.Drivetrain:
    rig = gb.Drivetrain("swing")
    lash = rig.add("lash", gb.Lash(k=200.0, half_gap=1e-3, c=0.2))
    rig.chain(rig.add("load", gb.Torque(tau=3.0)), rig.add("motor", gb.Inertia(J=0.5)), lash, rig.add("wall", gb.Fixed()))
    return rig
'''
SCENE = '''

def swings() -> gb.Scene:
    """How far it swings."""
    return gb.Scene(build(), t_end=0.5, quantity=gb.peak("motor.phi"), within=0.01)
'''


def _said(capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    streams = capsys.readouterr()
    return streams.out, streams.err


def test_the_only_scene_of_a_script_is_told_drawn_and_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "swing.py").write_text(SCRIPT + SCENE, encoding="utf-8")
    picture, table = tmp_path / "cost.png", tmp_path / "cost.csv"
    options = ["--budget", "1", "--plot", str(picture), "--out", str(table)]
    assert main(["cost", str(tmp_path / "swing.py"), *options]) == 0
    out, _ = _said(capsys)
    assert "swing: peak(motor.phi) within 1 %, from 0 to 0.5 s" in out and "1 % of peak(motor.phi) costs " in out
    assert picture.is_file() and table.read_text(encoding="utf-8").startswith("method,rtol,step,located,")
    assert main(["cost", f"{tmp_path / 'swing.py'}:swings", "--within", "1e-13", "--budget", "1"]) == 1
    out, err = _said(capsys)
    assert "No run is within 1e-13" in out and "no way to run it" in err


def test_a_script_without_a_scene_is_told_what_to_write(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "swing.py").write_text(SCRIPT, encoding="utf-8")
    assert main(["cost", str(tmp_path / "swing.py")]) == 2
    assert "'build' in swing.py makes no scene: write" in _said(capsys)[1]
    assert main(["cost", "spline_coupling"]) == 2
    assert "several scenes; name one: spline_coupling:period_5, spline_coupling:chaos" in _said(capsys)[1]
    assert main(["cost", "spline_coupling:build"]) == 2
    assert "its scenes are period_5, chaos" in _said(capsys)[1]
    assert main(["cost", "spline_coupling:chaos", "--plot", "cost.txt"]) == 2
    assert "the ending must be one of" in _said(capsys)[1]


def test_a_run_of_a_scene_starts_and_ends_as_it_says(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "swing.py").write_text(SCRIPT + SCENE, encoding="utf-8")
    assert main(["run", f"{tmp_path / 'swing.py'}:swings"]) == 0
    out, _ = _said(capsys)
    assert "up to t = 0.5 s" in out and "peak(motor.phi) = 0.0" in out
    assert main(["run", f"{tmp_path / 'swing.py'}:swings", "--t-end", "0.1"]) == 0
    assert "up to t = 0.1 s" in _said(capsys)[0]
    assert main(["sweep", f"{tmp_path / 'swing.py'}:swings", "--over", "lash.k=150:250:2"]) == 0
    assert "peak(motor.phi): " in _said(capsys)[0]


def _rows(path: Path) -> list[str]:
    return path.read_text(encoding="utf-8").splitlines()[1:]


def test_a_budget_is_what_all_runs_together_may_take(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "swing.py").write_text(SCRIPT + SCENE, encoding="utf-8")
    script, few, many = str(tmp_path / "swing.py"), tmp_path / "few.csv", tmp_path / "many.csv"
    assert main(["cost", script, "--budget", "1e-9", "--out", str(few)]) == 1  # of which the reference leaves nothing
    assert "no way to run it" in _said(capsys)[1]
    assert main(["cost", script, "--budget", "20", "--out", str(many)]) == 0
    assert _rows(few) == []
    methods = {row.split(",")[0] for row in _rows(many)}
    assert methods == {"auto", "dp8", "dp5", "rodas", "rk4"}


@pytest.mark.parametrize("budget", ["0", "-3", "nan", "much"])
def test_a_budget_that_is_no_time_is_refused(budget: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "swing.py").write_text(SCRIPT + SCENE, encoding="utf-8")
    assert main(["cost", str(tmp_path / "swing.py"), "--budget", budget]) == 2
    assert "budget" in _said(capsys)[1]
