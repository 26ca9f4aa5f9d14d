"""Scripts to start from: they run as they are, and nobody's file is overwritten."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from gearblocks.cli.main import main


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_starting_script_runs_in_python_and_in_the_shell(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["new", "rig"]) == 0
    assert "wrote rig.py; next: gearblocks run rig.py" in capsys.readouterr().out
    assert main(["run", "rig.py", "--t-end", "0.01", "--set", "mesh.k=150MN/m", "--without", "*.backlash"]) == 0
    # the core is there now: nothing has to be waited for, and nobody is told how far it is
    done = subprocess.run([sys.executable, "rig.py"], capture_output=True, text=True, check=True, timeout=300)
    assert "mesh" in done.stdout and not done.stderr
    assert (here / "run.png").read_bytes().startswith(b"\x89PNG")


def test_a_shipped_model_is_copied_and_its_trains_are_there(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "mine").mkdir()
    assert main(["copy", "planetary_sets"]) == 0
    assert main(["copy", "planetary_sets.py", "mine"]) == 0
    assert main(["copy", "planetary_sets", "mine/sets"]) == 0
    assert (here / "mine" / "sets.py").read_bytes() == (here / "planetary_sets.py").read_bytes()
    assert (here / "mine" / "planetary_sets.py").is_file()
    assert main(["list", "mine/sets.py"]) == 0
    assert "mine/sets.py:simpson" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["new", "rig.py"], ["copy", "spline_coupling", "rig.py"]])
def test_a_script_that_exists_is_left_alone(
    here: Path, arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    (here / "rig.py").write_text("mine", encoding="utf-8")
    assert main(arguments) == 2
    assert "'rig.py' exists and is left alone; name another file" in capsys.readouterr().err
    assert (here / "rig.py").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["copy", "spline_couplin"], "did you mean 'spline_coupling'"),
        (["copy", "rig"], "shipped are automatic_gearbox"),
        (["new", "nowhere/rig.py"], "there is no folder 'nowhere'; make it"),
        (["new", "rig.txt"], "a script ends in .py, such as rig.py"),
        (["new", "."], "is a folder; name the script in it"),
    ],
)
def test_what_cannot_be_begun_is_told(
    here: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    assert words in capsys.readouterr().err
    assert not list(here.iterdir())


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="permissions bind no superuser")
def test_a_folder_without_permission_is_told(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    here.chmod(0o500)
    try:
        assert main(["new", "rig"]) == 2
    finally:
        here.chmod(0o700)
    assert "cannot write 'rig.py': permission denied; choose another place" in capsys.readouterr().err
