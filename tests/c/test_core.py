"""The solver core against trains written by hand in C: orders, tolerances, events, saved states, bad numbers."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gearblocks.solver.methods import render_tables

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "gearblocks" / "solver" / "c"
CHECKS = Path(__file__).resolve().parent
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-ffp-contract=off")
FAST = ("-O3", "-fno-math-errno", "-fno-trapping-math")


def _compiler() -> list[str]:
    found = shlex.split(os.environ.get("CC", "")) or [shutil.which("cc") or ""]
    return found if found[0] else [sys.executable, "-m", "ziglang", "cc"]


def _build_and_run(folder: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    (folder / "gb_methods.h").write_text(render_tables(), encoding="utf-8")
    sources = [str(path) for path in (*sorted(CORE.glob("gb_*.c")), *sorted(CHECKS.glob("*.c")))]
    program = folder / ("check.exe" if os.name == "nt" else "check")
    include = (f"-I{folder}", f"-I{CORE}", f"-I{CHECKS}")
    built = subprocess.run(
        [*_compiler(), *FLAGS, *flags, *include, *sources, "-lm", "-o", str(program)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    return subprocess.run([str(program)], capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    "flags",
    [
        pytest.param(("-O0",), id="unoptimized", marks=pytest.mark.long),  # the sanitizers of .ci/run have it
        pytest.param(FAST, id="fast", marks=pytest.mark.long),
        pytest.param(("-O2",), id="plain", marks=pytest.mark.long),
    ],
)
def test_the_core_passes_its_checks(tmp_path: Path, flags: tuple[str, ...]) -> None:
    ran = _build_and_run(tmp_path, *flags)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert ran.stdout.endswith("all checks hold\n")


@pytest.mark.long
@pytest.mark.skipif(not shutil.which("gcc"), reason="the sanitizers' libraries come with gcc")
def test_the_core_passes_its_checks_under_sanitizers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "gcc")
    ran = _build_and_run(tmp_path, "-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    assert ran.returncode == 0, ran.stdout + ran.stderr
