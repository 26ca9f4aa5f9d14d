"""The hand-made model of oscillator.c as a Program, so that FMUs are tested without the stages above, and its FMU."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import fmu_export
from fmu_export.checks.instance import Unpacked
from gearblocks.codegen.output_list import OutputList, Quantity
from gearblocks.codegen.program import (
    EnergyInfo,
    InputInfo,
    IntegralInfo,
    ParameterInfo,
    Program,
    SwitchInfo,
)
from gearblocks.solver.library import Model, compile_program

SOURCE = Path(__file__).with_name("oscillator.c").read_text(encoding="utf-8")

VALUES = (0.02, 2.0e4, 0.4, 1.0e-3, 15.0, 800.0, 2.0e-3)


def oscillator(name: str = "play and spring") -> Program:
    """One inertia on a spring with play; see oscillator.c."""
    return Program(
        name=name,
        source=SOURCE,
        key="oscillator-1",
        parameters=(
            ParameterInfo("wheel.J", "kg m2", "moment of inertia", 0.0, None, True),
            ParameterInfo("spring.k", "N m/rad", "stiffness", 0.0, None, True),
            ParameterInfo("spring.c", "N m s/rad", "damping", 0.0, None, True),
            ParameterInfo("spring.backlash.half_gap", "rad", "half of the play", 0.0, None, True),
            ParameterInfo("drive.amplitude", "N m", "amplitude of the torque", None, None, True),
            ParameterInfo("speed", "rad/s", "frequency of the torque", None, None, True),
            ParameterInfo("wheel.phi0", "rad", "start angle", None, None, False),
        ),
        inputs=(InputInfo("tau", "N m", 5.0),),
        states=(Quantity("wheel.phi", "rad", "angle", "angle"), Quantity("wheel.w", "rad/s", "speed", "speed")),
        switches=(SwitchInfo("spring", "contact", "state"),),
        outputs=OutputList.of(
            [
                Quantity("wheel.phi", "rad", "angle"),
                Quantity("wheel.w", "rad/s", "speed"),
                Quantity("wheel.alpha", "rad/s2", "acceleration"),
                Quantity("spring.torque", "N m", "torque"),
                Quantity("spring.contact", "1", "side of the contact"),
            ]
        ),
        energies=(EnergyInfo("wheel", "kinetic", 0), EnergyInfo("spring", "stored", 1)),
        integrals=(IntegralInfo("spring", "loss", 8), IntegralInfo("drive", "supplied", 9)),
        n=2,
        n_padded=8,
        n_total=16,
    )


def oscillator_model(name: str = "play and spring") -> Model:
    """The oscillator compiled, with its start values."""
    program = oscillator(name)
    return Model(program, compile_program(program), np.array(VALUES))


@pytest.fixture(scope="session")
def make_model() -> Callable[[str], Model]:
    return oscillator_model


@pytest.fixture(scope="session")
def model() -> Model:
    return oscillator_model()


@pytest.fixture(scope="session")
def packed(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The oscillator as an FMU with the default settings."""
    return fmu_export.export(model, tmp_path_factory.mktemp("fmu") / "oscillator.fmu", t_end=0.1)


def unpack(path: Path, folder: Path) -> Unpacked:
    """The FMU unzipped into `folder`."""
    from fmpy import read_model_description

    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    return Unpacked(folder, read_model_description(str(folder)))


@pytest.fixture(scope="session")
def unpacked(packed: Path, tmp_path_factory: pytest.TempPathFactory) -> Unpacked:
    return unpack(packed, tmp_path_factory.mktemp("unpacked"))


@pytest.fixture(scope="session")
def unpacker() -> Callable[[Path, Path], Unpacked]:
    return unpack


@pytest.fixture(scope="session")
def references(unpacked: Unpacked) -> dict[str, int]:
    """Value references by name."""
    return {v.name: v.valueReference for v in unpacked.description.modelVariables}
