"""The start of a train that effects were taken from: the state of the full train, by name, as far as its new ties allow.

    speeds   v = argmin sum J (w - w_full)^2     over its bodies: what a plastic impact of the new ties would leave; momentum
                                                 along every motion that is left is that of the full train
    angles   deflections of its elements as in the full train (least squares, where loops contradict), then
             argmin sum J (phi - phi_full)^2 among what turns freely; gap >= 0 before both, where a stop has become rigid
    states   of blocks: those of the full train

w, phi: outputs of bodies; a deflection is an output in rad or m of any other element that follows the angles and that no
free rotation changes. Both are linear about a point; prescribed and non-circular motions take a few rounds. Static values
of the full train serve where the other one has no static equilibrium of its own. Knows nothing of effects, nor of blocks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from gearblocks.errors import GearblocksError, SimulationError
from gearblocks.language.fields import ANGLE, SPEED
from gearblocks.language.starts import is_rolling
from gearblocks.simulation.arguments import (
    InputSource,
    Start,
    begin_of,
    is_static,
    parameter_vector,
    set_inputs,
)
from gearblocks.simulation.equilibrium import static_state
from gearblocks.simulation.failures import reason
from gearblocks.simulation.input_series import with_tables
from gearblocks.simulation.records import FinalState
from gearblocks.simulation.rolling import rolled
from gearblocks.simulation.start_states import start_state
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.active_set import reduced
from gearblocks.solver.kinematics import kinds
from gearblocks.solver.library import Model
from gearblocks.solver.matrix_algebra import DENSE
from gearblocks.solver.point import Point, derivative, opened, steps_of
from gearblocks.solver.sparse_maps import Indices
from gearblocks.solver.structures import Array, Code
from gearblocks.solver.switched_constraints import ConstraintKind

_Key: TypeAlias = tuple[ConstraintKind, str, str]
_SAME = 1e-9  # of the largest value of one unit: start values that are solved for are found to so much
_ROUNDS = 8  # of Newton's method for angles; one where all relations are linear
_ROUNDING, _RANK = 1e-14, 1e-9
_FOLLOWS = 0.1  # of its largest factor: below, an output does not change with a free rotation


def carried_start(
    full: Model, variant: Model, initial: Start = None, *, t_start: float | str | None = None,
    parameters: Mapping[str, float | str] | None = None, inputs: Mapping[str, InputSource] | None = None,
) -> Start:  # fmt: skip
    """What `initial` a variant is to be run with, so that it starts in the state that the full train starts in.

    `initial` itself where it gives the variant that state, or asks for an equilibrium that the variant has. Else start
    values by name; for an earlier run of the full train, a run of no length in the state of its end.
    parameters, inputs, t_start: of the run; those that only the full train has are left out for the variant.

    Raises what a run of the full train raises where that does not start, and ParameterError, ModelError or
    SimulationError where the variant starts from no state at all.
    """
    begin = begin_of(t_start, initial)
    sources = with_tables(inputs)
    asked = _Asked(begin, parameters or {}, sources)
    if is_static(initial) and _has_equilibrium(variant, initial, asked):
        return initial
    with _started(full, initial, asked) as point:
        aim = _Aim.of(point)
    if not isinstance(initial, Trajectory) and not is_static(initial) and _starts_so(variant, initial, asked, aim):
        return initial
    earlier = initial if isinstance(initial, Trajectory) else None
    asked = asked.after(earlier)
    with _started(variant, _base(variant, asked), asked, beyond=True) as point:
        y = _carried(point, aim)
        if earlier is None:
            return _named(variant, asked, point.at(y=y), aim)
        state = FinalState(begin, y, point.modes, variant.program.key)
    meta = {"train": variant.program.name, "parameters": dict(earlier.meta.get("parameters", {})), "complete": True}
    return Trajectory([begin], {}, meta=meta, final_state=state)


def carried_values(variant: Model, values: Mapping[str, Any], *, inputs: bool = False) -> dict[str, Any]:
    """The parameters, or the inputs, of a run of the full train that the variant has too: by path or the end of one."""
    names = variant.program.input_numbers if inputs else variant.program.parameter_numbers
    return {k: v for k, v in values.items() if k in names or sum(n.endswith(f".{k}") for n in names) == 1}


# -- both trains at the start -----------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _Asked:
    """Start time, parameters and inputs of a run."""

    begin: float
    parameters: Mapping[str, float | str]
    inputs: Mapping[str, Any]

    def after(self, earlier: Trajectory | None) -> _Asked:
        """The same with the parameters of an earlier run."""
        if earlier is None:
            return self
        before = dict(earlier.meta.get("parameters", {}))
        return _Asked(self.begin, {**before, **self.parameters}, self.inputs)


@contextmanager
def _started(model: Model, initial: Start, asked: _Asked, *, beyond: bool = False) -> Iterator[Point]:
    """The model at its start. Raises what a run raises; beyond: but passes one that lies beyond stops or slips in ties."""
    program = model.program
    with model.library.reopen() as sim:
        own = asked.parameters if not isinstance(initial, Trajectory) else {}
        given = {k: v for k, v in carried_values(model, own).items() if k not in program.structural_paths}
        sim.parameters[:] = parameter_vector(model, given, initial)
        set_inputs(sim, program, carried_values(model, asked.inputs, inputs=True))
        if is_rolling(initial):
            sim.parameters[:] = rolled(model, sim, asked.begin, initial)
        try:
            static = is_static(initial)
            y0 = static_state(sim, program, asked.begin, means=initial == "static") if static else None
            y0 = y0 if static else start_state(program, initial)
            with opened(sim, program, asked.begin, y0, beyond=beyond) as point:
                yield point
        except RuntimeError:
            words = reason(program, Code(sim.report.code), sim)
            raise SimulationError(sim.report.t, *words) from sim.error


def _base(model: Model, asked: _Asked) -> Start:
    """Start values that the model starts with: its own, or at rest where the new ties contradict those."""
    try:
        with _started(model, None, asked, beyond=True):
            return None
    except SimulationError:
        return {x.name: 0.0 for x in model.program.starts if x.of == SPEED}


def _has_equilibrium(model: Model, initial: Start, asked: _Asked) -> bool:
    try:
        with _started(model, initial, asked):
            return True
    except GearblocksError:
        return False


def _starts_so(model: Model, initial: Start, asked: _Asked, aim: _Aim) -> bool:
    """Whether the bodies and blocks of the model start in the wanted state by themselves."""
    try:
        with _started(model, initial, asked) as point:
            rows, found = _Rows.of(point, aim), point.outputs()
            names = [s.name for s in point.program.states]
            for of in ("state", "coordinate"):
                same = [i for i, s in enumerate(point.program.states) if s.kind == of and s.name in aim.states]
                wanted = np.array([aim.states[names[i]] for i in same])
                if np.abs(point.y[same] - wanted).max(initial=0.0) > _SAME * np.abs(wanted).max(initial=0.0):
                    return False
            return rows.met(found, rows.speeds) and rows.met(found, rows.angles)
    except GearblocksError:
        return False


@dataclass(frozen=True, slots=True)
class _Aim:
    """Outputs and states of the full train at its start, by name (one that several states have stands for none), and the
    active ones of its switched constraints."""

    outputs: Mapping[str, float]
    states: Mapping[str, float]
    active: frozenset[_Key]

    @staticmethod
    def of(point: Point) -> _Aim:
        names, states = point.program.outputs.names(), [s.name for s in point.program.states]
        found = dict(zip(names, point.outputs().tolist(), strict=True))
        count = Counter(states)
        own = {name: float(v) for name, v in zip(states, point.y, strict=False) if count[name] == 1}
        keys = _constraint_names(point)
        return _Aim(found, own, frozenset(keys[i] for i in point.active_set()))


@dataclass(frozen=True, slots=True)
class _Rows:
    """Outputs that both trains have and that are to be met: speeds and angles of bodies, deflections of elements without a
    relative angle of the same name among the states of both; their wanted values, and the inertias of the bodies."""

    speeds: Indices
    angles: Indices
    deflections: Indices
    wanted: Array
    inertias: Array

    @staticmethod
    def of(point: Point, aim: _Aim) -> _Rows:
        names, units = list(point.program.outputs.names()), list(point.program.outputs.units())
        bodies = {e.component: e.offset for e in point.program.energies if e.part == "kinetic"}
        settled = {
            s.name.rpartition(".")[0] for s in point.program.states if s.kind == "coordinate" and s.name in aim.states
        }
        rows: tuple[list[int], list[int], list[int]] = ([], [], [])
        for i, (name, unit) in enumerate(zip(names, units, strict=True)):
            owner = name.rpartition(".")[0]
            if not np.isfinite(aim.outputs.get(name, np.nan)):
                continue
            if owner in bodies and unit in ("rad/s", "m/s"):
                rows[0].append(i)
            elif unit in ("rad", "m"):
                if owner in bodies:
                    rows[1].append(i)
                elif owner not in settled:
                    rows[2].append(i)
        wanted = np.array([aim.outputs.get(name, np.nan) for name in names])
        inertias = _inertias(point, names, bodies)
        speeds, angles, deflections = (np.array(r, dtype=np.intp) for r in rows)
        return _Rows(speeds, angles, deflections, wanted, inertias)

    def met(self, found: Array, kind: Indices) -> bool:
        """Whether outputs of one kind have their values."""
        wanted = self.wanted[kind]
        return bool(np.abs(found[kind] - wanted).max(initial=0.0) <= _SAME * np.abs(wanted).max(initial=0.0))


def _inertias(point: Point, names: Sequence[str], bodies: Mapping[str, int]) -> Array:
    """By output: inertia of the body that it belongs to, as far as a speed of it in rad/s or m/s asks, 2 E/w^2; else 0."""
    v, y = kinds(point.program)[3], point.y.copy()
    y[v] = 1.0 + np.modf(np.arange(1, len(v) + 1) * 0.6180339887498949)[0]
    found, energies = point.outputs(y), point.energies(y)
    inertias, units = np.zeros(len(names)), list(point.program.outputs.units())
    for unit in ("rad", "m"):
        of = {n.rpartition(".")[0]: i for i, n in enumerate(names) if units[i] == f"{unit}/s"}
        for i, name in enumerate(names):
            owner = name.rpartition(".")[0]
            if owner in bodies and owner in of and units[i] in (unit, f"{unit}/s") and found[of[owner]] != 0:
                inertias[i] = 2 * energies[bodies[owner]] / found[of[owner]] ** 2
    return inertias


# -- the state of the variant -----------------------------------------------------------------------------------------


def _carried(point: Point, aim: _Aim) -> Array:
    """The state vector of the variant."""
    rows, program = _Rows.of(point, aim), point.program
    q, angles, z, v = kinds(program)
    y = point.y.copy()
    count = Counter(s.name for s in program.states)  # groups beside a lossy tie may bear the name of one body
    for i in (*q, *z, *v):
        name = program.states[i].name
        y[i] = aim.states.get(name, aim.outputs.get(name, y[i])) if count[name] == 1 else y[i]
    names = {i: program.states[i].name for i in angles if i < len(program.states)}
    names |= {x.offset: f"{x.component}.phi" for x in program.integrals if x.part == "angle"}
    for i, name in names.items():
        y[i] = aim.outputs.get(name, aim.outputs.get(f"{name.removesuffix('.phi')}.s", aim.states.get(name, y[i])))
    turning = derivative(lambda y: point.rates(y)[angles], y, v, np.ones(program.n_total), algebra=DENSE)
    places = np.concatenate([q, angles[np.abs(turning).max(axis=1, initial=0.0) > 0]])  # others have a prescribed angle
    reached = np.zeros(0, dtype=np.intp)
    for _ in range(_ROUNDS):
        before = y.copy()
        y = _turned(point.at(y=y), rows, places, aim, reached)
        beyond = np.setdiff1d(_beyond(point.at(y=y)), reached)
        reached = np.concatenate([reached, beyond])
        if not len(beyond) and np.abs(y - before).max(initial=0.0) <= _ROUNDING * np.abs(y).max(initial=0.0):
            break
    if not rows.met(point.outputs(y), rows.speeds) or _slips_in_ties(point.at(y=y)):
        found = point.outputs(y)
        y[v] += _impact(point.at(y=y), rows, aim, rows.wanted[rows.speeds] - found[rows.speeds])
    return y


def _impact(point: Point, rows: _Rows, aim: _Aim, missing: Array) -> Array:
    """The change of the speeds: towards what bodies miss, in the metric of their inertias, with the active set of the full
    train kept: what is stuck, closed or a lossy tie gets no slip."""
    v = kinds(point.program)[3]
    keys, switched = _constraint_names(point), point.sim.constraints().constraints
    kept = [i for i, x in enumerate(switched) if x.kind is ConstraintKind.TIE or keys[i] in aim.active]
    change: Any = np.zeros(len(v))
    free = np.eye(len(v))
    if kept:
        at = point.constraints()
        G = at.rows[kept]
        rubs = np.array([switched[i].kind in (ConstraintKind.FRICTION, ConstraintKind.TIE) for i in kept])
        # of others, slip is no speed
        slips = np.where(rubs, at.slip[kept], G @ point.y[v])
        change, free = -np.linalg.lstsq(G, slips, rcond=_RANK)[0], reduced(G).basis(DENSE)
    A, size = _slopes(point, rows.speeds, v), np.sqrt(rows.inertias[rows.speeds])
    left = size * (missing - A @ change)
    return np.asarray(change + free @ np.linalg.lstsq(size[:, None] * A @ free, left, rcond=_RANK)[0])


def _constraint_names(point: Point) -> list[_Key]:
    """Kind, component and switch of each switched constraint."""
    switches, switched = point.program.switches, point.sim.constraints().constraints
    return [(x.kind, switches[x.active].component, switches[x.active].name) for x in switched]


def _beyond(point: Point) -> Indices:
    """Switches of the stops that it lies beyond, by more than rounding."""
    gaps = {x.slip for x in point.sim.constraints().constraints if x.is_stop}
    y, surfaces = point.y[np.concatenate(kinds(point.program)[:2])], point.surfaces()
    size = np.abs(y).max(initial=0.0)
    return np.array(sorted(i for i in gaps if surfaces[i] < -_ROUNDING * size), dtype=np.intp)


def _slips_in_ties(point: Point) -> bool:
    """Whether a lossy tie slips by more than rounding."""
    ties = [i for i, x in enumerate(point.sim.constraints().constraints) if x.kind is ConstraintKind.TIE]
    v = point.y[kinds(point.program)[3]]
    return bool(ties) and bool(np.abs(point.constraints().slip[ties]).max() > _SAME * np.abs(v).max(initial=0.0))


def _turned(point: Point, rows: _Rows, places: Indices, aim: _Aim, reached: Indices) -> Array:
    """One step to the stops that are reached, in what they leave free towards the wanted deflections, and to the wanted
    angles in what those leave free."""
    y, states, found = point.y.copy(), point.program.states, point.outputs()
    relative = np.array([i < len(states) and states[i].kind == "coordinate" for i in places], dtype=np.bool_)
    own = [k for k in np.flatnonzero(relative) if states[places[k]].name in aim.states]
    A = _slopes(point, rows.deflections, places)
    size = np.abs(A).max(axis=1, initial=0.0)
    follows = (size > 0) & (np.abs(A[:, ~relative]).max(axis=1, initial=0.0) <= _FOLLOWS * size)
    A = np.vstack([np.eye(len(places))[own], A[follows] / size[follows, None]])
    missing = (rows.wanted - found)[rows.deflections[follows]] / size[follows]
    left = np.concatenate([[aim.states[states[places[k]].name] - y[places[k]] for k in own], missing])
    step: Any = np.zeros(len(places))
    free: Any = np.eye(len(places))
    if len(reached):
        to_stops = derivative(
            lambda y: point.surfaces(y)[reached], y, places, steps_of(point.program, y), algebra=DENSE
        )  # fmt: skip
        step, free = -np.linalg.lstsq(to_stops, point.surfaces()[reached], rcond=_RANK)[0], _null_space(to_stops)
    if np.abs(left - A @ step).max(initial=0.0) > 0:
        step = step + free @ np.linalg.lstsq(A @ free, left - A @ step, rcond=_RANK)[0]
    free = free @ _null_space(A @ free)
    of_bodies, weights = _slopes(point, rows.angles, places), np.sqrt(rows.inertias[rows.angles])
    behind = (rows.wanted - found)[rows.angles] - of_bodies @ step
    if free.shape[1] and np.abs(behind).max(initial=0.0) > _SAME * np.abs(rows.wanted[rows.angles]).max(initial=0.0):
        step = step + free @ np.linalg.lstsq(weights[:, None] * of_bodies @ free, weights * behind, rcond=_RANK)[0]
    y[places] += step
    return y


def _null_space(A: Array) -> Array:
    """Columns that A takes to 0, orthonormal."""
    _, values, rows = np.linalg.svd(A) if len(A) else (None, np.zeros(0), np.eye(A.shape[1]))
    return np.asarray(rows[int((values > _RANK * values.max(initial=0.0)).sum()) :].T)


def _slopes(point: Point, rows: Indices, columns: Indices) -> Array:
    """Derivatives of outputs by states."""
    steps = steps_of(point.program, point.y)
    found = derivative(lambda y: point.outputs(y)[rows], point.y, columns, steps, algebra=DENSE)
    return np.asarray(found)


def _named(model: Model, asked: _Asked, point: Point, aim: _Aim) -> dict[str, float]:
    """Start values by name that give the variant this state."""
    program, count = model.program, Counter(s.name for s in model.program.states)
    found = {s.name: float(v) for s, v in zip(program.states, point.y, strict=False) if count[s.name] == 1}
    found |= dict(zip(program.outputs.names(), point.outputs().tolist(), strict=True))
    values: dict[str, float] = {}
    offsets: set[int] = set()
    for info in program.starts:
        if info.of in (ANGLE, SPEED):
            value = found.get(info.name)
            if value is not None and info.offset not in offsets:
                values[info.name] = value
                offsets.add(info.offset)
        elif info.name in aim.states:
            values[info.name] = aim.states[info.name]
    open_ones = {x.offset: x.name for x in program.starts if x.of in (ANGLE, SPEED) and x.offset not in offsets}
    return values | _fitted(model, asked, point.y, values, list(dict.fromkeys(open_ones.values())))


def _fitted(model: Model, asked: _Asked, y: Array, values: dict[str, float], names: list[str]) -> dict[str, float]:
    """Start values of bodies that show neither angle nor speed: by what each changes in the state at the start."""
    if not names:
        return {}

    def start(more: Mapping[str, float]) -> Array:
        with _started(model, {**values, **more}, asked) as point:
            return point.y[: model.program.n].copy()

    base = dict.fromkeys(names, 0.0)
    at_rest = start(base)
    columns = np.column_stack([start({**base, name: 1.0}) - at_rest for name in names])
    found = np.linalg.lstsq(columns, y[: model.program.n] - at_rest, rcond=_RANK)[0]
    return dict(zip(names, found.tolist(), strict=True))
