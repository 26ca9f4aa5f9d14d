"""Random calls of small FMUs under sanitizers; `python tests/fmu/fuzz.py` makes those of the shipped models."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

from gearblocks.solver.library import Model

sys.path.insert(0, str(Path(__file__).parent))
import fuzz

pytestmark = pytest.mark.skipif(not shutil.which("gcc"), reason="the sanitizers' libraries come with gcc")


@pytest.mark.long
@pytest.mark.parametrize("name", ["oscillator", "inertia", "clutches"])
def test_no_call_ends_in_a_report_a_long_wait_or_a_number_that_is_none(name: str, model: Model, tmp_path: Path) -> None:
    train = model if name == "oscillator" else fuzz.MODELS[name]()
    program = fuzz.build(train, tmp_path / name, tmp_path / "objects", patience=0.02)
    for seed in (1, 2):
        answer = fuzz.called(program, 10_000, seed, 100)
        assert answer.good, answer.words
        assert " 0 of them wrong" in answer.words
