"""Typical mistakes in Python and in the shell end in a message that names thing, value, rule and way out."""

from __future__ import annotations

import re
import shlex
import tempfile
import textwrap
import tomllib
from pathlib import Path
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.cli.beginnings import TEMPLATE
from gearblocks.cli.main import BAD_INPUT, main
from gearblocks.errors import GearblocksError, GearblocksWarning

MISTAKES = tomllib.loads((Path(__file__).parent / "mistakes.toml").read_text(encoding="utf-8"))["mistake"]
PARTS = ("thing", "value", "rule", "way out")
ADMITTED = re.compile(r"must (be|lie) (>|>=|a finite number|between|two whole numbers|later than)")
"""Rules that say what is admitted, and so the way out."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files that mistakes are made about, and the user in it."""
    script = TEMPLATE.read_text(encoding="utf-8")
    texts = {
        "rig.py": script, "typo.py": script.replace("gb.Inertia(", "gb.Inertai(", 1), "notes.py": "x = 3\n",
        "notes.txt": "three\n", "notes.fmu": "three\n", "broken.json": "{ 3",
    }  # fmt: skip
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "locked").mkdir(mode=0o500)
    if writable(tmp_path / "locked"):  # no permission binds a superuser: a folder that nobody can write to
        (tmp_path / "locked").rmdir()
        (tmp_path / "locked").symlink_to("/sys", target_is_directory=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def writable(folder: Path) -> bool:
    try:
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def in_python(code: str) -> str:
    """What is raised, or warned of, by code that follows the train of the starting script."""
    script = TEMPLATE.read_text(encoding="utf-8")
    made = script[script.index("    rig = gb.Drivetrain") : script.index("    return rig")]
    names: dict[str, Any] = {"gb": gb}
    exec(textwrap.dedent(made), names)  # noqa: S102
    with pytest.raises((GearblocksError, GearblocksWarning, AttributeError)) as raised:
        exec(code, names)  # noqa: S102
    return str(raised.value)


@pytest.mark.parametrize("mistake", MISTAKES, ids=[one["name"] for one in MISTAKES])
def test_a_mistake_is_told_with_thing_value_rule_and_way_out(
    mistake: dict[str, Any], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if "locked" in mistake.get("shell", "") and writable(folder / "locked"):
        pytest.skip("every folder can be written to here")
    if "python" in mistake:
        message = in_python(mistake["python"])
    else:
        assert main(shlex.split(mistake["shell"])) == 2
        message = capsys.readouterr().err
    assert "Traceback" not in message
    missing = [f"{part}: {text}" for part, text in zip(PARTS, mistake["says"], strict=True) if text not in message]
    assert not missing, message


def test_the_table_holds_forty_mistakes_and_every_way_out_is_one() -> None:
    assert len(MISTAKES) >= 40 and len({one["name"] for one in MISTAKES}) == len(MISTAKES)
    for one in MISTAKES:
        rule, way_out = one["says"][2:]
        assert rule != way_out or ADMITTED.match(rule), f"{one['name']}: '{rule}' says what is wrong, not what to do"


def test_ctrl_c_is_answered_by_words_and_a_status(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped() -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr("gearblocks.cli.block_help.listing", stopped)
    assert main(["doc"]) != 0
    assert "stopped by Ctrl-C; what had been written until then is kept" in capsys.readouterr().err


def test_a_script_that_may_not_be_read_is_said_to_be_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "rig.py"
    script.write_text("x = 3\n", encoding="utf-8")

    def refused(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "read_bytes", refused)
    assert main(["run", str(script)]) == BAD_INPUT
    assert f"cannot read '{script}': permission denied; copy it to where you may read it" in capsys.readouterr().err


@pytest.mark.filterwarnings("default")
def test_a_value_in_another_unit_than_it_is_meant_in_is_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    script = tmp_path / "rig.py"
    assert main(["new", str(script)]) == 0
    assert main(["run", str(script), "--t-end", "1ms", "--set", "mesh.module=4"]) == 0
    told = capsys.readouterr()
    assert "warning: GearMesh mesh.module = 4 m (normal module) is implausible" in told.err
    assert "mesh.force  " in told.out and "e-2" not in told.out.split("mesh.force")[1].splitlines()[0]


def test_a_study_beyond_the_memory_is_said_to_be_so(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", "rig.py", "--over", "mesh.k=1e8:2e8:999999999999999", "--t-end", "0.01"]) == 1
    assert "the memory of this machine is too small for that: ask for fewer points" in capsys.readouterr().err
