"""Start values: those that nobody gives are solved for from those given on dependent groups; contradictions are said."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import numpy as np

from gearblocks.codegen.program import LOSSY, LOSSY_VARYING, DependentStart, Program, StartInfo
from gearblocks.errors import ModelError
from gearblocks.language.block import Block, given_start, start_fields
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.fields import ANGLE, SPEED
from gearblocks.solver.binding import Simulation
from gearblocks.solver.library import Model
from gearblocks.solver.structures import Array, Options
from gearblocks.solver.switched_constraints import ConstraintKind
from gearblocks.train.graph import Train
from gearblocks.train.translational import flange_names

_START = Options(2, 1, 1e-6, 0.0, np.inf, np.inf)
_ROUNDING = 1e-9  # of the size of a start value: balances of torque are found by Newton steps


def start_of(block: Block, of: str) -> float | None:
    """The number of the start angle or speed that a block gives."""
    value = given_start(block, of)
    if isinstance(value, Expr):
        return evaluate(value, parameter_value)
    value = getattr(value, "si", value)
    return float(value) if isinstance(value, (int, float)) else None


def parameter_value(leaf: Expr) -> float:
    """The value of a Parameter in a start value. ModelError for anything else."""
    if leaf.op != "parameter":
        raise ModelError(f"a start value cannot depend on '{leaf}'; use numbers and Parameters")
    return float(leaf.args[0].si)


def contradictions(program: Program, train: Train) -> Iterator[str]:
    """Start values of one rigid group that contradict each other."""
    starts = {s.name: s for s in program.starts if s.of in (ANGLE, SPEED)}
    given: dict[int, tuple[str, str, float, float]] = {}
    for c in train.components:
        for of, field in start_fields(type(c.block)).items():
            value = start_of(c.block, of) if of in (ANGLE, SPEED) else None
            start = None if value is None else _start_at(starts, c.path, of)
            if value is not None and start is not None:
                scaled = value * start.factor
                before = given.setdefault(start.offset, (c.path, field, value, scaled))
                if abs(before[3] - scaled) > 1e-12 * max(abs(before[3]), abs(scaled)):
                    yield (
                        f"'{before[0]}': {before[1]} = {before[2]!r} and '{c.path}': {field} = {value!r} contradict each "
                        f"other through their ties; give one of them"
                    )


def _start_at(starts: Mapping[str, StartInfo], path: str, of: str) -> StartInfo | None:
    """The start angle or speed of a component, on a turning shaft or on a slider."""
    turning, sliding = (f"{path}.{flange_names(slides)[of == SPEED]}" for slides in (False, True))
    return starts.get(turning) or starts.get(sliding)


def solve_dependent(program: Program, train: Train, values: dict[str, float]) -> Iterator[str]:
    """Start values given on dependent groups, and those beside lossy ties: open ones of independent groups are solved for (into
    `values`); yields contradictions (those of lossy ties a run says)."""
    blocks = {c.path: c.block for c in train.components}
    rows = _given_dependents(program, blocks)
    asked = [(info, value) for info, _, _, value in rows]
    asked += [(info, 0.0) for info in program.dependent_starts if info.of == LOSSY]
    if not asked:
        return
    _solve(program, blocks, asked, values)
    for info, path, field, value in rows:
        paths = [program.parameters[i].path for i in info.offsets]
        terms = [f * values.get(p, 0.0) for p, f in zip(paths, info.factors, strict=True)]
        if abs(value - sum(terms)) > 1e-12 * (abs(value) + sum(map(abs, terms))):
            yield (
                f"'{path}': {field} = {value!r} contradicts the {sum(terms):.9g} that follows through its ties from "
                f"{', '.join(paths)}; leave one of them out"
            )


def _given_dependents(program: Program, blocks: dict[str, Block]) -> list[tuple[DependentStart, str, str, float]]:
    """Start values that are given on dependent groups: with path, field and value."""
    rows = []
    for info in (x for x in program.dependent_starts if x.of in (ANGLE, SPEED)):
        path = info.name.rpartition(".")[0]
        value = start_of(blocks[path], info.of)
        if value is not None:
            rows.append((info, path, start_fields(type(blocks[path]))[info.of], value))
    return rows


def _solve(
    program: Program, blocks: dict[str, Block], rows: list[tuple[DependentStart, float]], values: dict[str, float]
) -> None:  # fmt: skip
    """Open start values of minimum norm that fulfil the rows: sum of factor times value = the given one."""
    offsets = dict.fromkeys(i for info, _ in rows for i in info.offsets if is_open(program, blocks, i))
    unknown = {i: k for k, i in enumerate(offsets)}
    if not unknown:
        return
    A, b = np.zeros((len(rows), len(unknown))), np.zeros(len(rows))
    for k, (info, value) in enumerate(rows):
        b[k] = value
        for i, factor in zip(info.offsets, info.factors, strict=True):
            if i in unknown:
                A[k, unknown[i]] += factor
            else:
                b[k] -= factor * values.get(program.parameters[i].path, 0.0)
    found = np.linalg.lstsq(A, b, rcond=None)[0]
    values.update({program.parameters[i].path: float(found[k]) for i, k in unknown.items()})


def is_open(program: Program, blocks: dict[str, Block], offset: int) -> bool:
    """Whether a parameter is an open start value: one that nobody gives."""
    info = program.parameters[offset]
    path = info.path.rpartition(".")[0]
    return info.start in (ANGLE, SPEED) and (path not in blocks or start_of(blocks[path], info.start) is None)


def fitted_later(program: Program, train: Train) -> frozenset[int]:
    """Offsets of the open start values that `fit_prescribed` and `fit_lossy` may choose, for which a model must be compiled."""
    blocks: dict[str, Block] = {c.path: c.block for c in train.components}
    given = any(start_of(blocks[x.name.rpartition(".")[0]], x.of) is not None for x in program.prescribed_starts)
    if not given and all(x.of != LOSSY_VARYING for x in program.dependent_starts):
        return frozenset()
    starts = (s.offset for s in program.starts if s.of in (ANGLE, SPEED))
    return frozenset(i for i in starts if is_open(program, blocks, i))


def fit_prescribed(model: Model, train: Train) -> None:
    """The same for groups with a prescribed motion, compared with their outputs at t = 0: open start values are found (into
    model.values). ModelError for given start values that cannot be."""
    infos = model.program.prescribed_starts
    blocks: dict[str, Block] = {c.path: c.block for c in train.components} if infos else {}
    given = []
    for info in infos:
        path = info.name.rpartition(".")[0]
        value = start_of(blocks[path], info.of)
        if value is not None:
            given.append((info, path, start_fields(type(blocks[path]))[info.of], value))
    if not given:
        return
    asked = np.array([value for *_, value in given])
    names = [info.output for info, *_ in given]
    found = _at_start(model, names, model.values)
    if found is None:
        return  # a run says what is wrong
    if (np.abs(asked - found) > _ROUNDING * np.abs(asked)).any():
        tied = np.array([info.tied for info, *_ in given])
        found = _fitted(model, names, np.where(tied, asked, found), found, blocks)
    problems = [
        f"'{path}': {field} = {value!r}, but {info.by} it: {x:.9g} at t = 0; leave {field} out"
        for (info, path, field, value), x in zip(given, found, strict=True)
        if abs(value - x) > _ROUNDING * max(abs(value), abs(x))
    ]
    if problems:
        raise ModelError(problems)


def _at_start(model: Model, names: list[str], values: Array) -> Array | None:
    """Outputs at t = 0 with these parameters; None where the start fails."""
    offsets = {q.name: i for i, q in enumerate(model.program.outputs)}
    with started(model, values) as sim:
        return None if sim is None else sim.outputs()[[offsets[n] for n in names]]


@contextmanager
def started(model: Model, values: Array) -> Iterator[Simulation | None]:
    """A run at t = 0 with these parameters; None where the start fails."""
    with model.library.open() as sim:
        sim.parameters[:] = values
        sim.inputs[:] = [x.start for x in model.program.inputs]
        sim.changed()
        yield None if sim.start(_START, 0.0) < 0 else sim


def _fitted(model: Model, names: list[str], asked: Array, found: Array, blocks: dict[str, Block]) -> Array:
    """Chooses the open start values. One linear step: nonlinear constraints may leave a difference."""
    starts = [s.offset for s in model.program.starts if s.of in (ANGLE, SPEED)]
    free = [i for i in dict.fromkeys(starts) if is_open(model.program, blocks, i)]
    columns = []
    for i in free:
        moved = model.values.copy()
        moved[i] += 1.0
        there = _at_start(model, names, moved)
        columns.append(np.zeros(len(asked)) if there is None else there - found)
    if not columns:
        return found
    values = model.values.copy()
    values[free] += np.linalg.lstsq(np.column_stack(columns), asked - found, rcond=None)[0]
    fitted = _at_start(model, names, values)
    if fitted is None or np.abs(asked - fitted).max() > np.abs(asked - found).max():
        return found
    model.values.setflags(write=True)
    model.values[free] = values[free]
    model.values.setflags(write=False)
    return fitted


def fit_lossy(model: Model, train: Train) -> None:
    """The same for lossy ties behind gains that vary with angles: with the gains at the start, open start speeds that are 0,
    or that other lossy ties and speeds given on dependent groups share, are chosen so that no tie slips (into model.values).
    What is left a run says."""
    varying = next((x for x in model.program.dependent_starts if x.of == LOSSY_VARYING), None)
    if varying is None:
        return
    blocks: dict[str, Block] = {c.path: c.block for c in train.components}
    given = [(x, value) for x, *_, value in _given_dependents(model.program, blocks) if x.of == SPEED]
    ties = [x for x in model.program.dependent_starts if x.of == LOSSY]
    shared = {i for x in (*ties, *(x for x, _ in given)) for i in x.offsets}
    offsets = list(dict.fromkeys((*varying.offsets, *shared)))
    rows = _tie_rows(model, offsets) if model.values[offsets].any() else None
    if rows is None:
        return
    asked = np.zeros((len(rows) + len(given), len(offsets)))  # per start value: both sides of a relation may have one
    for column, i, gain in zip(rows.T, varying.offsets, varying.factors, strict=True):
        asked[: len(rows), offsets.index(i)] += gain * column
    for row, (info, _) in zip(asked[len(rows) :], given, strict=True):
        for i, factor in zip(info.offsets, info.factors, strict=True):
            row[offsets.index(i)] += factor
    free = [
        k
        for k, i in enumerate(offsets)
        if (model.values[i] == 0.0 or i in shared) and is_open(model.program, blocks, i)
    ]
    free = [k for k in free if asked[:, k].any()]
    if not free:
        return
    kept = [k for k in range(len(offsets)) if k not in free]
    right = np.array([0.0] * len(rows) + [value for _, value in given]) - asked[:, kept] @ model.values[offsets][kept]
    found = np.linalg.lstsq(asked[:, free], right, rcond=None)[0]
    model.values.setflags(write=True)
    model.values[[offsets[k] for k in free]] = found
    model.values.setflags(write=False)


def _tie_rows(model: Model, offsets: list[int]) -> Array | None:
    """Rows of all lossy ties over the independent speeds, at the angles of the start; None where even a start at rest fails."""
    values = model.values.copy()
    values[offsets] = 0.0
    with started(model, values) as sim:
        if sim is None:
            return None
        ties = [x.kind is ConstraintKind.TIE for x in sim.constraints().constraints]
        return sim.constraints_at(0.0, sim.state(), sim.modes()).rows[ties]
