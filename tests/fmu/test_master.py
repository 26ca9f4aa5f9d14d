"""The FMU run by a C program that knows the FMI headers and nothing else."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import pytest

from fmu_export import manifest
from fmu_export.binary import native_platform
from fmu_export.checks.instance import Unpacked
from fmu_export.checks.replay import replay
from fmu_export.templates import VERSION_FOLDERS
from gearblocks.solver.compiler import SHARED_SUFFIX, find_compiler

SHOWN = ("wheel.phi", "wheel.w", "spring.torque")


@pytest.fixture(scope="module")
def master(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("master")
    for source in (VERSION_FOLDERS["2.0"] / "fmi2.h", Path(__file__).with_name("master.c")):
        (folder / source.name).write_bytes(source.read_bytes())
    flags = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    find_compiler().run((*flags, "master.c", "-o", "master", "-ldl", "-lm"), folder)
    return folder / "master"


def called(
    master: Path, unpacked: Unpacked, references: dict[str, int], end: float, step: float, mode: str, *names: str
) -> list[str]:
    identifier = unpacked.description.coSimulation.modelIdentifier
    library = unpacked.folder / "binaries" / native_platform() / (identifier + SHARED_SUFFIX)
    shown = [str(references[name]) for name in names]
    command = [str(master), str(library), unpacked.description.guid, repr(end), repr(step), mode, *shown]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize("step", [1e-5, 1e-3, 0.7e-3])
def test_its_values_are_those_of_the_run_in_process(
    master: Path, unpacked: Unpacked, references: dict[str, int], step: float
) -> None:
    lines = called(master, unpacked, references, 0.02, step, "run", *SHOWN)
    table = np.array([[float.fromhex(word) for word in line.split()] for line in lines])
    data = (unpacked.folder / manifest.NAME).read_bytes()
    content = manifest.from_json(data, (unpacked.folder / "sources" / "model.c").read_text(encoding="utf-8"))
    pick = [[q.name for q in content.program.outputs].index(name) for name in SHOWN]
    np.testing.assert_array_equal(table[:, 1:], replay(content, table[:, 0], 0.02)[:, pick])


def test_two_runs_have_equal_bits(master: Path, unpacked: Unpacked, references: dict[str, int]) -> None:
    first, second = (called(master, unpacked, references, 0.02, 1e-4, "run", *SHOWN) for _ in range(2))
    assert first == second


def test_a_restored_run_has_equal_bits(master: Path, unpacked: Unpacked, references: dict[str, int]) -> None:
    assert len(called(master, unpacked, references, 0.05, 1e-3, "restore", *SHOWN)) == len(SHOWN)


def test_wrong_calls_answer_an_error_and_name_the_reason(
    master: Path, unpacked: Unpacked, references: dict[str, int]
) -> None:
    lines = called(master, unpacked, references, 0.02, 1e-3, "failures", "tau")
    assert len(lines) == 13
    for line in lines:
        what, status, reason = line.split(" | ")
        assert status == "3", what
        assert reason.startswith("fmi2"), what
