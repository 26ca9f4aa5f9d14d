"""A branch of periodic orbits over a parameter, stable and not, through folds and period doublings, and what is marked on it.

Found by pseudo-arclength continuation (`arclength.py`). Knows nothing of motions that are not periodic.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.arclength import BRANCH, DOUBLING, FOLD, GRAZING, Between, followed
from gearblocks.analysis.regimes.carried import output_of
from gearblocks.analysis.regimes.neutral import Neutral, neutral_directions, without_records
from gearblocks.analysis.regimes.orbit import PeriodicOrbit, no_period, shoot
from gearblocks.analysis.regimes.orbit_equation import OrbitEquation, Solved
from gearblocks.analysis.regimes.response import response
from gearblocks.analysis.regimes.sizes import settled, sized
from gearblocks.analysis.regimes.stiff_trains import warn_if_stiff
from gearblocks.analysis.regimes.strobe import Change, Strobe, change_of, strobe
from gearblocks.analysis.sections import Section
from gearblocks.codegen.program import ParameterInfo
from gearblocks.drivetrain import Drivetrain
from gearblocks.errors import ParameterError, SimulationError, by_name_only
from gearblocks.language.expression import finite_number
from gearblocks.plurals import singular
from gearblocks.running import build
from gearblocks.simulation.arguments import number_of, resolve
from gearblocks.simulation.plausibility import warn_of_parameters, warn_of_rows
from gearblocks.simulation.start_states import standing_run
from gearblocks.simulation.trajectory import Trajectory
from gearblocks.solver.library import Model

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
At = Callable[[float], Strobe]
ByParameter = Callable[[Strobe, float], Change]

_UNSURE = 30.0  # tolerances
_PARTS = ("mean", "rms", "low", "high")


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Mark:
    """What lies on a branch: kind "fold", "period doubling", "branch point", "torus" or "grazing". value: of the parameter;
    bracket: two values that it lies between (of a fold: the last one with an orbit, and where the tangents beside it meet,
    beyond which there is none); words: what happens; number: of the orbit of the branch that it lies behind; states: at the
    section, shape (n,); multipliers: there; start: a run of no length that stands there, which `initial=` takes.

    periods, direction: of the branch that leaves at a doubling or branch point, which `continue_orbit(start=mark)` follows.
    """

    kind: str
    value: float
    bracket: tuple[float, float]
    words: str
    number: int
    states: Array
    multipliers: NDArray[np.complex128]
    periods: int
    start: Trajectory
    direction: Array | None = None

    def __repr__(self) -> str:
        return f"<{self.kind} at {self.value:.9g}: {self.words}>"


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OrbitBranch:
    """Orbits of `periods` periods of the section along a branch over the parameter `path` [unit]: values, shape (k,).

    states: at the section, by `names`, shape (k, n); starts: runs of no length that stand there, each at its value of the
    parameter: `gb.simulate(train, initial=branch.starts[0], t_end=...)` goes on from one; multipliers: without neutral
    directions, whose words are in `neutral`, the largest first, shape (k, m); mean, rms (about the mean), low, high: of
    output `of` [of_unit] over an orbit, shape (k,); corners: where no derivative exists, in words, or ""; marks: folds,
    doublings and more, in their order; ended: why it ends.
    """

    path: str
    unit: str
    periods: int
    values: Array
    names: tuple[str, ...]
    states: Array
    starts: tuple[Trajectory, ...]
    multipliers: NDArray[np.complex128]
    of: str
    of_unit: str
    mean: Array
    rms: Array
    low: Array
    high: Array
    corners: tuple[str, ...]
    marks: tuple[Mark, ...]
    neutral: tuple[str, ...]
    ended: str

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether motions beside each orbit come nearer, shape (k,)."""
        found: NDArray[np.bool_] = (np.abs(self.multipliers) < 1.0).all(axis=1) & (np.array(self.corners) == "")
        return found

    @property
    def peak_to_peak(self) -> Array:
        """From the lowest to the highest value, shape (k,)."""
        return self.high - self.low

    def marked(self, kind: str) -> tuple[Mark, ...]:
        """The marks of a kind."""
        return tuple(mark for mark in self.marks if mark.kind == kind)

    def __repr__(self) -> str:
        listed = ", ".join(f"{mark.kind} at {mark.value:.6g}" for mark in self.marks)
        size = f"{len(self.values)} orbits of period {self.periods} over {self.path}, {int(self.stable.sum())} stable"
        return singular(f"<{size}; {listed or 'nothing marked'}; {self.ended}>")

    @by_name_only
    def plot(self, path: str | os.PathLike[str] | None = None) -> Figure:
        """Root mean square of the output over the parameter, unstable orbits dashed, marks; saved where a path is given."""
        from gearblocks.analysis.regimes.response_pictures import draw_branch

        return draw_branch(self, path)

    def to_xarray(self) -> xarray.Dataset:
        """Along the dimension `orbit`, with units."""
        import xarray

        data: dict[str, Any] = {name: ("orbit", getattr(self, name), {"units": self.of_unit}) for name in _PARTS}
        data |= {"stable": ("orbit", self.stable), "states": (("orbit", "state"), self.states)}
        data |= {"multipliers": (("orbit", "multiplier"), self.multipliers)}
        coords = {self.path: ("orbit", self.values, {"units": self.unit}), "state": [*self.names]}
        return xarray.Dataset(data, coords=coords, attrs={"of": self.of, "periods": self.periods, "ended": self.ended})


@by_name_only
def continue_orbit(
    train: Drivetrain | Model, parameter: str, span: Sequence[float | str], *, section: Section, periods: int = 1,
    start: Mark | PeriodicOrbit | None = None, of: str | None = None, transient: int = 300, step: float = 0.03,
    most: int = 1000, rtol: float = 1e-10, parameters: Mapping[str, float | str] | None = None, initial: Any = None,
) -> OrbitBranch:  # fmt: skip
    """The branch of periodic orbits over a parameter, from the orbit at the begin of the span until the parameter leaves it.

    span: begin and end of the parameter, in its unit as `sweep` takes values, or texts with a unit (the branch is in SI);
    periods: of the section, that the orbit repeats after. It begins with the
    orbit near the motion after `transient` periods; with start= an orbit at the begin of the span, or with a mark of
    another branch (a doubling, a branch point), from which the branch that leaves there is followed. of: an output whose
    mean, rms and extremes are told along the branch (default: the first deflection or twist). step: the longest, where the
    span and the sizes of the states are 1; most: points. rtol, parameters and initial: as for `simulate`. Raises
    SimulationError where there is no orbit to begin with.
    """
    model = build(train)
    if periods < 1 or transient < 0 or most < 2 or not 0 < finite_number("step", step) <= 1:
        raise ParameterError(
            f"periods = {periods} must be >= 1, transient = {transient} >= 0, most = {most} >= 2 and step = {step} in (0, 1]"
        )
    output = output_of(model.program, of)
    number = resolve(parameter, model.program.parameter_numbers, "parameter")
    info = model.program.parameters[number]
    begin, end = _span(span, info)

    def at(value: float) -> Strobe:  # in SI, as derivatives by it are
        return strobe(model, section, {**(parameters or {}), info.path: f"{value!r} {info.unit or '1'}"}, initial, rtol)

    warn_of_parameters(model, parameters)
    warn_of_rows(model, {info.path: span})
    warn_if_stiff(at(begin), initial)

    def change(seen: Strobe, unit: float) -> Change:
        return change_of(seen, section, number, unit)

    if isinstance(start, Mark):
        equation, first = _from_mark(at, change, begin, end, start)
    else:
        equation, first = _from_orbit(at, change, begin, end, start, initial, periods, transient)
    low, high = sorted((x - equation.value) / equation.size for x in (begin, end))
    points, marks, ended = [], [], ""
    for found in followed(equation, first, low, high, step, most, leaves=isinstance(start, Mark)):
        if isinstance(found, Solved):
            points.append(found)
        elif isinstance(found, Between):
            marks.append(_mark(equation, found, len(points) - 1))
        else:
            ended = _words(points, found)
    if isinstance(start, Mark):  # where it begins is marked already
        marks = [mark for mark in marks if mark.number or mark.kind == GRAZING]
    quantity = model.program.outputs[output]
    swings = np.array([response(p.seen, p.y, equation.periods, quantity.name) for p in points])
    return OrbitBranch(
        info.path, info.unit, equation.periods, np.array([p.value for p in points]),
        tuple(q.name for q in model.program.states), np.array([p.y for p in points]),
        tuple(_start(p) for p in points), np.array([p.multipliers for p in points]), quantity.name, quantity.unit,
        swings[:, 0], swings[:, 1], swings[:, 2], swings[:, 3], tuple(p.run.corner for p in points), tuple(marks),
        equation.neutral.words, ended,
    )  # fmt: skip


def _span(span: Sequence[float | str], info: ParameterInfo) -> tuple[float, float]:
    """Begin and end in SI."""
    try:
        low, high = span
    except (TypeError, ValueError):
        raise ParameterError(f"span = {span!r:.80} must be two numbers, begin and end of '{info.path}'") from None
    begin, end = (finite_number("span", number_of("span", x, info)) for x in (low, high))
    if begin == end:
        raise ParameterError(f"span = {span!r:.80} must be two different numbers")
    return begin, end


def _from_orbit(
    at: At, change: ByParameter, begin: float, end: float, start: Any, initial: Any, periods: int, transient: int
) -> tuple[OrbitEquation, Solved]:  # fmt: skip
    """The equation at an orbit, and its point there, whose tangent leads into the span."""
    if start is None:
        seen, y, passed, acts = settled(at(begin), initial, transient)
        if not acts.periods:
            raise no_period(seen, passed, acts)
    elif isinstance(start, PeriodicOrbit):
        y, periods = start.points[0], start.periods
        seen = sized(at(begin), y, 0)
    else:
        raise ParameterError(
            f"start = {start!r:.80} must be an orbit of gb.periodic_orbit, or a mark of another branch"
        )
    if seen.begun or (isinstance(start, PeriodicOrbit) and start.states[0].t):
        raise SimulationError(
            seen.begun * seen.period, "", "what acts on the train at its begin is not what acts later",
            "a branch is followed over times from 0 on: take away what acts at the begin alone (a ramp, a step)", None,
        )  # fmt: skip
    neutral = _directions(seen, y)
    orbit = shoot(seen, y, periods, neutral)
    if orbit is not None:
        equation = OrbitEquation(at, change, seen, neutral, orbit.points[0], begin, abs(end - begin), orbit.periods)
        zero = np.zeros(neutral.rest.shape[1] + 1)
        along = zero.copy()
        along[-1] = np.sign(end - begin)
        first = equation.solved(zero, along)
        if first is not None:
            return equation, first
    raise SimulationError(
        transient * seen.period, "", f"no orbit that repeats after {periods} periods was found near the motion",
        "give another number of periods, a start nearer to it, or a longer transient", None,
    )  # fmt: skip


def _from_mark(
    at: At, change: ByParameter, begin: float, end: float, start: Mark
) -> tuple[OrbitEquation, Solved]:  # fmt: skip
    """The equation at a mark, and a point there whose tangent leads into the branch that leaves."""
    if start.direction is None or not min(begin, end) <= start.value <= max(begin, end):
        raise ParameterError(
            f"start = {start!r:.80}: a branch leaves at a period doubling or a branch point within the span"
        )
    seen = sized(at(start.value), start.states, 0)
    neutral = _directions(seen, start.states)
    equation = OrbitEquation(at, change, seen, neutral, start.states, start.value, abs(end - begin), start.periods)
    leads = np.append(neutral.apart(start.direction / seen.scale), 0.0)
    leads /= np.linalg.norm(leads)
    return equation, replace(equation.point(np.zeros(len(leads)), leads), tangent=leads)


def _directions(seen: Strobe, y: Array) -> Neutral:
    neutral = without_records(seen, y, neutral_directions(seen, y))
    if not neutral.rest.shape[1]:
        raise ParameterError(
            f"every motion of this train is neutral ({', '.join(neutral.words)}): no orbit stands apart"
        )
    return neutral


def _mark(equation: OrbitEquation, found: Between, number: int) -> Mark:
    a, b = found.before, found.behind
    bracket = min(a.value, b.value), max(a.value, b.value)
    periods, direction = equation.periods, None
    if found.kind == FOLD:
        bracket, words = _fold(equation, a, b)
    elif found.kind == DOUBLING:
        periods = 2 * equation.periods
        direction, words = _leaving(a, -2.0), f"a branch of period {periods} leaves"
    elif found.kind == BRANCH:
        direction, words = _leaving(a, 0.0), f"another branch of period {periods} leaves"
    elif found.kind == GRAZING:
        words = f"{a.run.events} events in {periods} periods of the section, then {b.run.events}"
        words += f"; {a.run.corner or b.run.corner}" if a.run.corner or b.run.corner else ""
    else:
        words = "a pair of multipliers crosses the unit circle"
    return Mark(
        found.kind, 0.5 * sum(bracket), bracket, words, number, a.y, a.multipliers, periods, _start(a), direction
    )


def _start(point: Solved) -> Trajectory:
    """A run of no length that stands at a point."""
    return standing_run(point.seen.standing(point.y), point.seen.model.program.name, point.seen.values)


def _fold(equation: OrbitEquation, a: Solved, b: Solved) -> tuple[tuple[float, float], str]:
    """The last value with an orbit, and where the tangents beside the fold meet, told to the tolerance; rising."""
    length = float(np.linalg.norm(b.u - a.u))
    slopes = [float(p.tangent[-1] / (p.tangent @ (b.u - a.u))) * length for p in (a, b)]
    meets = np.clip((b.u[-1] - a.u[-1] - slopes[1] * length) / (slopes[0] - slopes[1]), 0.0, length)
    outer, unsure = a.value + equation.size * slopes[0] * float(meets), _UNSURE * a.seen.rtol * equation.size
    if slopes[0] > 0:
        inner = max(a.value, b.value)
        return (inner - unsure, max(outer, inner) + unsure), "two orbits meet, there is none above"
    inner = min(a.value, b.value)
    return (min(outer, inner) - unsure, inner + unsure), "two orbits meet, there is none below"


def _leaving(at: Solved, eigenvalue: float) -> Array:
    """The direction over the states along which orbits leave: the eigenvector of the map less 1."""
    values, vectors = np.linalg.eig(at.jacobian[:, :-1])
    vector = vectors[:, int(np.argmin(np.abs(values - eigenvalue)))].real
    found: Array = at.directions @ (vector / np.linalg.norm(vector))
    return found


def _words(points: Sequence[Solved], ended: str) -> str:
    last = points[-1]
    words = f"ends at {last.value:.6g}: {ended}"
    return f"{words}; {last.run.corner}" if last.run.corner else words
