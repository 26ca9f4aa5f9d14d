"""The variables of an FMU, independent of the FMI version: one table for descriptions, C tables and checks.

A value reference is kind * 2**24 + position among the variables of that kind:

    0 solver (time, rtol, step)   1 parameter   2 input   3 output   4 start value of a state

Positions follow the program, so a reference changes only when the model or the choice of outputs does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmu_export.options import RTOL_RANGE, SolverOptions
from fmu_export.start import start_offsets
from gearblocks.codegen.program import Program
from gearblocks.errors import ParameterError, UnknownNameError
from gearblocks.model.listing import matches, near_patterns

KINDS = ("solver", "parameter", "input", "output", "start")
KIND_SHIFT = 24
TIME, RTOL, STEP = 0, 1, 2
"""Indices of the solver's variables, as in c/gb_fmu.h."""


@dataclass(frozen=True, slots=True)
class Variable:
    """One real variable. `index` points into the model's vector of its kind; `start` is None for computed ones.

    open_lower, open_upper: the bound itself is refused. display: the unit in which it is shown, where that is none of SI.
    """

    name: str
    kind: str
    position: int
    index: int
    unit: str
    words: str
    start: float | None = None
    lower: float | None = None
    upper: float | None = None
    tunable: bool = False
    open_lower: bool = False
    open_upper: bool = False
    display: str = ""

    @property
    def reference(self) -> int:
        """The value reference."""
        return (KINDS.index(self.kind) << KIND_SHIFT) + self.position


def variables_of(
    program: Program,
    values: NDArray[np.float64],
    outputs: str | Sequence[str],
    solver: SolverOptions,
    start: NDArray[np.float64] | None = None,
) -> tuple[Variable, ...]:
    """All variables of the FMU: solver, parameters, inputs, outputs, and start values of the states where given.

    An output that shares its name with a tunable parameter or an input is shown as NAME_output; a start value that shares
    its name with an output, as those of states that a block shows do, is NAME.start.
    start: state vector to start from. Its entries take the place of the start parameters, which would have no effect
    beside them. Raises ParameterError where two variables would carry one name.
    """
    table = [*_solver(program, solver), *_parameters(program, values, start is not None), *_inputs(program)]
    table += _outputs(program, outputs, {v.name for v in table})
    if start is not None:
        table += [
            Variable(f"{name}.start", "start", position, i, unit, f"start value of {name}", float(start[i]))
            for position, (name, unit, i) in enumerate(start_offsets(program))
        ]
    _check_names(table)
    return tuple(table)


def _solver(program: Program, solver: SolverOptions) -> list[Variable]:
    names = {p.path.split(".")[0] for p in program.parameters} | {q.name.split(".")[0] for q in program.outputs}
    prefix = "solver"
    while prefix in names:
        prefix += "_"
    table = [Variable("time", "solver", 0, TIME, "s", "time")]
    if solver.step is None:
        words = "relative tolerance of the solver inside"
        table.append(Variable(f"{prefix}.rtol", "solver", 1, RTOL, "", words, solver.rtol, *RTOL_RANGE))
    else:
        words = "fixed step of the solver inside"
        table.append(Variable(f"{prefix}.step", "solver", 1, STEP, "s", words, solver.step, np.finfo(float).tiny))
    return table


def _parameters(program: Program, values: NDArray[np.float64], tunable_only: bool) -> list[Variable]:
    chosen = [(i, p) for i, p in enumerate(program.parameters) if p.tunable or not tunable_only]
    shown = {q.name for q in program.outputs}
    table = []
    for position, (i, p) in enumerate(chosen):
        value = float(values[i])
        if not math.isfinite(value):
            raise ParameterError(f"parameter '{p.path}' = {value!r} {p.unit} must be finite")
        name = p.path if p.tunable or p.path not in shown else f"{p.path}.start"
        bounds = (p.lower, p.upper, p.tunable, p.open_lower, p.open_upper, p.given_in)
        table.append(Variable(name, "parameter", position, i, p.unit, p.words, value, *bounds))
    return table


def _inputs(program: Program) -> list[Variable]:
    return [
        Variable(u.name, "input", i, i, u.unit, f"input {u.name}", u.start, tunable=True, display=u.given_in)
        for i, u in enumerate(program.inputs)
    ]


def _outputs(program: Program, patterns: str | Sequence[str], taken: set[str]) -> list[Variable]:
    chosen: set[int] = set()
    unknown = {name for (name,) in program.unknown}
    for pattern in (patterns,) if isinstance(patterns, str) else tuple(patterns):
        found = [i for i, q in enumerate(program.outputs) if matches(q.name, pattern)]
        if not found and pattern != "*":
            near = near_patterns(pattern, [q.name for q in program.outputs])
            raise UnknownNameError(f"no output of '{program.name}' matches '{pattern}'{near}; rig.outputs() lists them")
        if pattern in unknown:
            raise ParameterError(
                f"outputs: '{pattern}' is not known: its shaft has no inertia, so no equation gives the acceleration; leave "
                f"it out"
            )
        chosen.update(i for i in found if program.outputs[i].name not in unknown)
    table = []
    for position, i in enumerate(sorted(chosen)):
        q = program.outputs[i]
        name = f"{q.name}_output" if q.name in taken else q.name
        table.append(Variable(name, "output", position, i, q.unit, q.words))
    return table


def _check_names(table: Sequence[Variable]) -> None:
    seen: dict[str, Variable] = {}
    for variable in table:
        other = seen.setdefault(variable.name, variable)
        if other is not variable:
            raise ParameterError(
                f"two variables of the FMU would be called '{variable.name}' ({other.kind} and {variable.kind}): "
                f"rename a block or an input"
            )
