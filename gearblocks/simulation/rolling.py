"""Rolling starts: speeds and angles of the rigid train, for a train whose compliant elements are to begin undeformed.

    speeds   rate of every deflection = 0, slip of every lossy tie = 0, v = named; then, as far as these leave it free, slip = 0
             of what is engaged, the strongest first; v = given by bodies; slip = 0 elsewhere; then min v' M v (Kelvin: set
             going by impacts on the given bodies alone)
    angles   deflection = 0, phi = given; lossy ties as far as these leave them free; then the first free body at 0

Where ratios vary with the angles, their tangents stand in: the angles are found by Newton's method, the speeds at these.
Answers a parameter vector, in which the start values are these. Knows nothing of runs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearblocks.codegen.program import UNKNOWN, GroupStart, ParameterInfo, Program, RigidRow
from gearblocks.errors import ParameterError, SimulationError
from gearblocks.language.expression import finite_number
from gearblocks.language.starts import Rolling, is_rolling
from gearblocks.simulation.arguments import resolve, start_number
from gearblocks.simulation.failures import reason
from gearblocks.simulation.held_slips import Held, engaged, ties
from gearblocks.simulation.rolling_rows import RowsTaken
from gearblocks.simulation.varying_ratios import VaryingRatios, varies, varying_ratios
from gearblocks.solver.binding import Simulation
from gearblocks.solver.kinematics import kinematics
from gearblocks.solver.library import Model
from gearblocks.solver.matrix_algebra import algebra_of
from gearblocks.solver.point import Point, opened
from gearblocks.solver.rigid_motion import AGREES
from gearblocks.solver.structures import Array, Code

_NONE = VaryingRatios((), {})
_ROUNDS, _MET = 60, 1e-9  # of Newton's method; a change of angles below which it may end, where it gets no smaller


def rolled(model: Model, sim: Simulation, t: float, initial: Any) -> Array:
    """The parameters of `sim`, with start values as a rolling start asks for; others as they are. The inputs of `sim` are
    those of the start. Raises ParameterError for values that contradict each other, UnknownNameError."""
    vector = np.array(sim.parameters)
    if not is_rolling(initial):
        return vector
    if fixed := [row.component for row in model.program.bodies if row.gives_acceleration]:
        raise ParameterError(
            f"initial: {', '.join(fixed)} gives a start acceleration, which a train that rolls undeformed does not have: leave "
            "it out, or give start values by name"
        )
    given = _named(model, vector, initial.values if isinstance(initial, Rolling) else {})
    angles, speeds = _rolling(model.program, sim, t, vector, given)
    for g, start in enumerate(model.program.groups):
        if start.angle >= 0:
            _write(model, vector, start.angle, start.angle_gain * angles[g])
        if start.speed >= 0:
            _write(model, vector, start.speed, start.speed_gain * speeds[g])
    vector.setflags(write=False)
    return vector


def _rolling(
    program: Program, sim: Simulation, t: float, vector: Array, given: _Given
) -> tuple[list[float], list[float]]:
    """Angles and speeds of all groups."""
    trial, before, last = vector, [np.nan] * len(program.groups), np.inf
    for _ in range(_ROUNDS):
        with _at_rest(sim, program, t, trial) as point:
            ratios = varying_ratios(point, trial) if varies(program) else None
            angles = _angles(program, vector, given, point, ratios)
            change = float(np.max(np.abs(np.subtract(angles, before)), initial=0.0))
            if (
                ratios is None
                or change == 0
                or (change >= last and change <= _MET * np.max(np.abs(angles), initial=1.0))
            ):
                return angles, _speeds(program, vector, given, point, ratios)
        trial, before, last = np.array(vector), angles, change if np.isfinite(change) else np.inf
        for start, angle in zip(program.groups, angles, strict=True):
            if start.angle >= 0:
                trial[start.angle] = start.angle_gain * angle
    raise ParameterError(
        "initial: no angles were found in which nothing is twisted, beside gears whose ratios vary; give start values by name"
    )


def turning_along(sim: Simulation, program: Program, t: float, *, means: bool) -> Array:
    """The state at the start of `sim` with the speeds that nobody gave as a rolling start has them, with given motions at their
    means or as at t; angles as they are. Raises ParameterError for speeds that contradict each other."""
    given = np.array(sim.parameters)
    with _at_rest(sim, program, t, given) as point:
        if varies(program):
            raise ParameterError("initial: a gear whose ratio varies has no steady rotation; give start values by name")
        speeds = _speeds(program, given, _Given({}, {}), point.at(means=means))
    for g, start in enumerate(program.groups):
        if start.speed >= 0:
            sim.parameters[start.speed] = start.speed_gain * speeds[g]
    try:
        with opened(sim, program, t) as point:
            return point.y
    finally:
        sim.parameters[:] = given


@dataclass(frozen=True, slots=True)
class _Given:
    """Start angles and speeds that are named, by body row."""

    angles: Mapping[int, float]
    speeds: Mapping[int, float]


def _named(model: Model, vector: Array, values: Mapping[str, float | str]) -> _Given:
    """What is named; states of blocks go into the vector."""
    program = model.program
    names = {row.angle: i for i, row in enumerate(program.bodies)}
    first = len(program.bodies)
    names |= {row.speed: first + i for i, row in enumerate(program.bodies)}
    states = {s.name: 2 * first + s.offset for s in program.starts if s.of == "state"}
    found: tuple[dict[int, float], dict[int, float]] = ({}, {})
    for name, value in values.items():
        i = resolve(name, {**names, **states}, "initial value")
        full = next(n for n, k in (*names.items(), *states.items()) if k == i)
        number = finite_number(full, start_number(program, full, value))
        if i >= 2 * first:
            vector[i - 2 * first] = number
        else:
            found[i // first][i % first] = number
    return _Given(*found)


@contextmanager
def _at_rest(sim: Simulation, program: Program, t: float, vector: Array) -> Iterator[Point]:
    """The train at its start without start speeds. SimulationError where it has none."""
    still = np.array(vector)
    still[[g.speed for g in program.groups if g.speed >= 0 and program.parameters[g.speed].start]] = 0.0
    sim.parameters[:] = still
    try:
        with opened(sim, program, t) as point:
            yield point.at(algebra=algebra_of(program.n))
    except RuntimeError:
        words = reason(program, Code(sim.report.code), sim)
        raise SimulationError(sim.report.t, *words) from sim.error
    finally:
        sim.parameters[:] = vector


def _write(model: Model, vector: Array, offset: int, value: float) -> None:
    """A start value into the vector; one that a Parameter gives must be what it says, where that stands elsewhere too."""
    info: ParameterInfo = model.program.parameters[offset]
    if abs(value - vector[offset]) <= 1e-12 * abs(value):
        return
    if model.start_parameters.get(info.path, 1) > 1:
        raise ParameterError(
            f"initial: a start value is the Parameter '{info.path}', which stands elsewhere too, and would have to be "
            f"{value:.9g}: give parameters={{'{info.path}': ...}}, or the block a number"
        )
    vector[offset] = value


# -- angles and speeds of groups --------------------------------------------------------------------------------------


def _give_named(solving: RowsTaken, named: Mapping[int, float], names: list[str]) -> None:
    for i, value in named.items():
        solving.give(names[i], solving.program.bodies[i], value)


def _give_own(
    solving: RowsTaken, own: Mapping[int, float], named: Mapping[int, float], names: list[str], held: Iterable[int] = ()
) -> None:  # fmt: skip
    """Values of bodies, where the named ones, and the friction that holds beside them in the groups `held`, leave them free."""
    told = solving.told() | {solving.joined.root(g) for g in held}
    before = solving.motion.copied()
    for i, value in own.items():
        row = solving.program.bodies[i]
        follows = not before.left(solving.factors(row))[0]
        if i not in named and not (follows and solving.is_told(row, told)):
            solving.give(names[i], row, value)


def _own(program: Program, vector: Array, speeds: bool) -> dict[int, float]:
    """The start values that bodies give themselves, by row."""
    found: dict[int, float] = {}
    for i, row in enumerate(program.bodies):
        if not (row.gives_speed if speeds else row.gives_angle):
            continue
        if all((program.groups[g].speed if speeds else program.groups[g].angle) >= 0 for g in row.groups):
            found[i] = _present(program, row, vector, speeds=speeds)
    return found


def _present(program: Program, row: RigidRow, vector: Array, *, speeds: bool) -> float:
    """The value of a form, or of its rate, by the start values of the vector."""
    starts = [program.groups[g] for g in row.groups]
    places = [(s.speed, s.speed_gain) if speeds else (s.angle, s.angle_gain) for s in starts]
    terms = [f * vector[o] / gain for f, (o, gain) in zip(row.factors, places, strict=True)]
    return float(sum(terms)) + (0.0 if speeds else _constant(row, vector))


def _constant(row: RigidRow, vector: Array) -> float:
    return float(sum(f * vector[o] for o, f in zip(row.offsets, row.offset_factors, strict=True)))


def _natural(row: RigidRow, vector: Array) -> float:
    """The deflection at which an element carries nothing, the nearest to its rest."""
    if UNKNOWN in (row.rest, row.lower, row.upper):
        raise ParameterError(
            f"initial: '{row.component}' carries nothing at a deflection that an expression gives: give it a number or a "
            "Parameter for a rolling start"
        )
    rest, lower, upper = (0.0 if i < 0 else float(vector[i]) for i in (row.rest, row.lower, row.upper))
    return row.scale * (rest + max(lower, 0.0) + min(upper, 0.0))


def _angles(
    program: Program, vector: Array, given: _Given, point: Point, ratios: VaryingRatios | None = None
) -> list[float]:
    varying = ratios or _NONE
    solving = RowsTaken(program, "nothing is twisted")
    found = point.outputs()
    for g, start in enumerate(program.groups):
        if start.prescribed and start.angle < 0 and not start.varying:
            solving.motion.take({g: 1.0}, _shown(program, start, found, angle=True))
    _take_shared(solving)
    for tangent in varying.groups:
        if np.isfinite(tangent.constant):
            solving.take(tangent.row, tangent.constant)
    for i, row in enumerate(program.deflections):
        if i in varying.deflections:
            solving.take(varying.deflections[i].row, varying.deflections[i].constant)
            continue
        wanted = _present(program, row, vector, speeds=False) if row.gives_angle else _natural(row, vector)
        solving.take(row, wanted - _constant(row, vector))  # a loop that is under tension by itself stays so
    own = _own(program, vector, speeds=False)
    named = {i: x - _constant(program.bodies[i], vector) for i, x in given.angles.items()}
    own = {i: x - _constant(program.bodies[i], vector) for i, x in own.items()}
    names = [row.angle for row in program.bodies]
    _give_named(solving, named, names)
    _give_own(solving, own, named, names)
    for row in ties(point):
        solving.take(row, 0.0)
    for row in program.bodies:
        if not any(program.groups[g].varying for g in row.groups):
            solving.motion.take(solving.factors(row), -_constant(row, vector))
    return solving.values()


def _take_shared(solving: RowsTaken) -> None:
    """Groups whose angles one start value gives, through a lossy gear of which one side alone is given."""
    first: dict[int, int] = {}
    for g, start in enumerate(solving.program.groups):
        if start.angle < 0 or start.varying or start.prescribed:
            continue
        other = first.setdefault(start.angle, g)
        if other != g:
            solving.joined.join(g, other)
            solving.motion.take({other: solving.program.groups[other].angle_gain, g: -start.angle_gain}, 0.0)


def _shown(program: Program, start: GroupStart, outputs: Array, *, angle: bool) -> float:
    """The speed of a group that something moves, or its angle."""
    name = start.output
    if angle:
        flange, _, speed = name.rpartition(".")
        name = f"{flange}.{'phi' if speed == 'w' else 's'}"
    return float(outputs[program.output_numbers[name]]) / start.output_gain


def _speeds(
    program: Program, vector: Array, given: _Given, point: Point, ratios: VaryingRatios | None = None
) -> list[float]:
    varying = ratios or _NONE
    solving = RowsTaken(program, "nothing is twisted at a rate")
    found = point.outputs()
    for g, start in enumerate(program.groups):
        if start.prescribed and not start.varying:
            solving.motion.take({g: 1.0}, _shown(program, start, found, angle=False))
    for tangent in varying.groups:
        solving.take(tangent.row, tangent.rate)
    moving = {i: tangent.rate for i, tangent in varying.deflections.items()}
    deflections = [varying.deflections[i].row if i in moving else row for i, row in enumerate(program.deflections)]
    for i, row in enumerate((*deflections, *ties(point))):
        wanted = _present(program, row, vector, speeds=True) if row.gives_speed else moving.get(i, 0.0)
        if not solving.take(row, wanted):
            left = solving.motion.left(solving.factors(row))[1] - wanted
            if abs(left) > AGREES * _size(solving, row):
                raise ParameterError(
                    f"initial: what moves the shafts beside '{row.component}' winds it up at {left:.6g} rad/s (m/s): the "
                    "train cannot roll; change the prescribed speeds, or give start values by name"
                )
    own = _own(program, vector, speeds=True)
    names = [row.speed for row in program.bodies]
    _give_named(solving, given.speeds, names)
    held = _hold(solving, point, beside_named=True)
    _give_own(solving, own, given.speeds, names, held)
    _hold(solving, point)
    return solving.values(_least_energy(solving, point))


def _size(solving: RowsTaken, row: RigidRow) -> float:
    """The largest speed that a row compares."""
    terms = (abs(c * solving.motion.left({g: 1.0})[1]) for g, c in solving.factors(row).items())
    return max(terms, default=0.0)


def _hold(solving: RowsTaken, point: Point, *, beside_named: bool = False) -> set[int]:
    """No slip in what is engaged, the strongest first; stops between two bodies take each other along last. beside_named: only
    in what is joined with a named value. Answers the groups of all rows that were looked at."""
    waiting = engaged(point)
    if beside_named:
        reached = solving.reached([held.row for held in waiting])
        waiting = [held for held in waiting if solving.is_told(held.row, reached)]
    for held in waiting:
        if not solving.take(held.row, 0.0) and not held.stop:
            _refuse_impact(solving, held)
    return {g for held in waiting for g in held.row.groups}


def _refuse_impact(solving: RowsTaken, held: Held) -> None:
    """ParameterError where a lock without limit would have to close on a slip."""
    slip = solving.motion.left(solving.factors(held.row))[1]
    most = AGREES * _size(solving, held.row)
    if (slip < -most and held.upper == np.inf) or (slip > most and held.lower == -np.inf):
        raise ParameterError(
            f"initial: '{held.row.component}' is locked, but the speeds that follow from "
            f"{solving.sources(held.row) or 'others'} would "
            f"make it slip at {slip:.6g} rad/s (m/s); leave one of them out, or give start values by name"
        )


def _least_energy(solving: RowsTaken, point: Point) -> dict[int, float]:
    """Speeds of the free groups that follow others in some share: those of the least kinetic energy."""
    free = list(solving.motion.moved())
    if not free:
        return {}
    kin = kinematics(point)
    n = len(kin.speeds)
    before = np.array(solving.values()[:n])
    shape = np.zeros((n, len(free)))
    for k, g in enumerate(free):
        shape[:, k] = np.array(solving.values({g: 1.0})[:n]) - before
    M: Any = kin.M
    found = np.linalg.lstsq(shape.T @ (M @ shape), -shape.T @ (M @ before), rcond=1e-12)[0]
    return dict(zip(free, found.tolist(), strict=True))
