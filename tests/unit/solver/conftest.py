"""The hand-written model of oscillator.c, compiled and begun."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from gearblocks.codegen.output_list import OutputList, Quantity
from gearblocks.codegen.program import EnergyInfo, InputInfo, ParameterInfo, Program
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Library, compile_program
from gearblocks.solver.structures import Code, Method, Options

SOURCE = Path(__file__).with_name("oscillator.c").read_text(encoding="utf-8")
EXACT = Options(method=Method.DP8, locate=1, rtol=1e-10, step=0.0, max_step=math.inf, t_stop=math.inf)


def _program(note: str = "") -> Program:
    return Program(
        name="oscillator",
        source=SOURCE + note,
        key="oscillator",
        parameters=(ParameterInfo("spring.w", "rad/s", "angular frequency", 0.0, None, True),),
        inputs=(InputInfo("u", "m/s2", 0.0),),
        states=(Quantity("x", "m", "deflection"), Quantity("v", "m/s", "its rate")),
        switches=(),
        outputs=OutputList.of([Quantity("x", "m", "deflection"), Quantity("v", "m/s", "its rate")]),
        energies=(EnergyInfo("mass", "kinetic", 0), EnergyInfo("spring", "stored", 1)),
        integrals=(),
        n=2,
        n_padded=8,
        n_total=8,
    )


def _begin(sim: Simulation, w: float = 2.0) -> None:
    sim.parameters[0] = w
    sim.changed()
    assert sim.start(EXACT, 0.0) == Code.DONE


@pytest.fixture(scope="session")
def program() -> Callable[..., Program]:
    """program(note): the model; a note makes another text of it."""
    return _program


@pytest.fixture(scope="session")
def oscillator() -> Library:
    return compile_program(_program())


@pytest.fixture(scope="session")
def options() -> Options:
    """A tight tolerance, every switch located."""
    return EXACT


@pytest.fixture(scope="session")
def begin() -> Callable[..., None]:
    """begin(sim, w): starts at t = 0 with that angular frequency."""
    return _begin
