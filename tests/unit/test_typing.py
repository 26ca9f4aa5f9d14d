"""Type checkers find wrong keywords, types, effects, flanges, fields and arguments, and nothing in what is right."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPTS = ROOT / "tests" / "data" / "typing"
PLANTED = {
    i: line.partition("  # ")[2]
    for i, line in enumerate((SCRIPTS / "planted.py").read_text(encoding="utf-8").splitlines(), 1)
    if "  # " in line
}

pytestmark = pytest.mark.long


def _checker(name: str, cache: Path) -> Sequence[str]:
    """The command of a type checker; skips the test where there is none."""
    path = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    if path is None:
        pytest.skip(f"{name} is not installed")
    return (
        (path, "--pythonpath", sys.executable) if name == "pyright" else (path, "--strict", "--cache-dir", str(cache))
    )


def _errors(name: str, script: str, folder: Path) -> dict[int, str]:
    """What a checker says about a script, by line. It lies outside of the checkout, as that of a user does."""
    shutil.copy(SCRIPTS / script, folder)
    found = subprocess.run(
        [*_checker(name, folder / "cache"), script], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    assert found.returncode in (0, 1), found.stdout + found.stderr
    return {int(at): words for at, words in re.findall(rf"{script}:(\d+)(?::\d+)?(?: -|:) error: (.*)", found.stdout)}


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_every_planted_mistake_is_found_and_nothing_else(checker: str, tmp_path: Path) -> None:
    found = _errors(checker, "planted.py", tmp_path)
    assert len(PLANTED) == 12
    assert {PLANTED[line] for line in PLANTED if line not in found} == set()
    assert set(found) == set(PLANTED)


@pytest.mark.parametrize("checker", ["mypy", "pyright"])
def test_nothing_is_said_about_what_is_right(checker: str, tmp_path: Path) -> None:
    assert _errors(checker, "right.py", tmp_path) == {}


def test_what_is_right_runs_as_it_is_typed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    text = (SCRIPTS / "right.py").read_text(encoding="utf-8")
    exec(compile(text, "right.py", "exec"), {"__name__": "right"})  # noqa: S102  our own script
    assert (tmp_path / "rig.fmu").is_file()
