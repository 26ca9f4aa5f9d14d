"""Pseudo-arclength continuation (Keller 1977): a branch of F(u) = 0 step by step along its tangent, and what lies on it.

    fold              the tangent's part along the parameter changes its sign
    period doubling   prod (mu_i + 1) changes its sign
    branch point      prod (mu_i - 1) does without a fold
    torus             two multipliers leave or enter the unit circle (Neimark and Sacker)
    grazing           the number of events in a period changes

Each is closed in by bisection along the branch. Knows nothing of trains.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.orbit_equation import OrbitEquation, Solved
from gearblocks.errors import SimulationError

Array = NDArray[np.float64]

FOLD, DOUBLING, BRANCH, TORUS, GRAZING = "fold", "period doubling", "branch point", "torus", "grazing"

_LEAST = 1e-7  # step, of the sizes
_TURN = 0.94  # cosine of the angle that the tangent may turn by in a step
_EASY = 3  # steps of Newton's method after which the next step is longer
_LONGER, _SHORTER = 1.5, 0.5
_NEAR = 1e-6  # of the sizes: what marks are closed in to
_REACH = 0.01  # along the tangent, in which a graze is looked for
_BEGUN = 8  # points after which a branch may have come back to its begin


class Between(NamedTuple):
    """What lies between two points of a branch, which are next to it."""

    kind: str
    before: Solved
    behind: Solved


def followed(
    equation: OrbitEquation, first: Solved, low: float, high: float, step: float, most: int, *, leaves: bool
) -> Iterator[Solved | Between | str]:
    """Points of a branch with what lies between them, from `first` along its tangent, until its parameter (as in u) leaves
    [low, high]; at last why it ends. Sizes follow the orbits.
    leaves: the branch leaves another one at `first`."""
    point, longest, length, count = first, step, step if leaves else 0.1 * step, 1
    yield point
    while count < most:
        found = _next(equation, point, min(length, longest))
        if found is None:
            grazed = _grazed(equation, point)
            yield from grazed
            yield "it grazes, and no further orbit is found" if grazed else "no further orbit is found"
            return
        length, other = found
        edge = low if other.u[-1] < low else high if other.u[-1] > high else None
        if edge is not None:
            other = _at_edge(equation, point, other, edge) or other
        yield from _between(equation, point, other)
        yield other
        count += 1
        if edge is not None:
            yield "the end of the range"
            return
        if count > _BEGUN and _is_back(equation, first, point, other):
            yield "it is closed"
            return
        length *= _LONGER if other.steps <= _EASY else 1.0
        equation, point = equation.resized(other)
    yield f"{most} points"


def _next(equation: OrbitEquation, point: Solved, length: float) -> tuple[float, Solved] | None:
    """The step that was taken, and the point behind it."""
    while length > _LEAST:
        other = equation.solved(point.u + length * point.tangent, point.tangent)
        if other is not None and other.tangent @ point.tangent > _TURN:
            return length, other
        length *= _SHORTER
    return None


def _grazed(equation: OrbitEquation, point: Solved) -> list[Between]:
    """The graze next to a point beyond which none is found: an impact that is only just met bends the map without bound."""
    distance = _LEAST
    while distance < _REACH:
        try:
            other = equation.point(point.u + distance * point.tangent, point.tangent)
        except SimulationError:
            break
        if other.run.events != point.run.events:
            return [Between(GRAZING, point, other)]
        distance *= 2.0
    return []


def _at_edge(equation: OrbitEquation, point: Solved, other: Solved, edge: float) -> Solved | None:
    share = (edge - point.u[-1]) / (other.u[-1] - point.u[-1])
    along = np.zeros_like(point.u)
    along[-1] = np.sign(other.u[-1] - point.u[-1])
    return equation.solved(point.u + share * (other.u - point.u), along)


def _is_back(equation: OrbitEquation, first: Solved, point: Solved, other: Solved) -> bool:
    """Whether the begin lies between two points."""
    way, back = other.u - point.u, equation.coordinates(first.y, first.value) - point.u
    share = float(back @ way / (way @ way))
    return 0.0 <= share <= 1.0 and bool(np.linalg.norm(back - share * way) < 0.1 * np.linalg.norm(way))


def _between(equation: OrbitEquation, a: Solved, b: Solved) -> list[Between]:
    """What lies between two points, in their order."""
    tests: dict[str, Callable[[Solved], Hashable]] = {
        FOLD: lambda p: bool(p.tangent[-1] > 0),
        DOUBLING: lambda p: bool(np.prod(p.multipliers + 1.0).real > 0),
        BRANCH: lambda p: bool(np.prod(p.multipliers - 1.0).real * p.tangent[-1] > 0),
        GRAZING: lambda p: p.run.events,
    }
    changed = [kind for kind, test in tests.items() if test(a) != test(b)]
    if abs(a.outside - b.outside) == 2 and not {FOLD, DOUBLING, BRANCH} & {*changed}:
        tests[TORUS] = lambda p: p.outside
        changed.append(TORUS)
    found = [Between(kind, *_closed_in(equation, a, b, tests[kind])) for kind in changed]
    way = b.u - a.u
    return sorted(found, key=lambda one: float((one.before.u - a.u) @ way))


def _closed_in(
    equation: OrbitEquation, a: Solved, b: Solved, test: Callable[[Solved], Hashable]
) -> tuple[Solved, Solved]:
    """Two points nearer to each other that differ in the test as these do."""
    first = test(a)
    while np.linalg.norm(b.u - a.u) > _NEAR:
        way = (b.u - a.u) / np.linalg.norm(b.u - a.u)
        middle = equation.solved(0.5 * (a.u + b.u), way)
        if middle is None:
            break
        if test(middle) == first:
            a = middle
        else:
            b = middle
    return a, b
