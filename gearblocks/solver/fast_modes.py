"""Modes of a model at a point with the elements that they strain and the states that have a part in them.

    A x = s x;   part of state i: abs(l_i x_i), with the left vector l, l x = 1

An element holds the share of the strain energy (of the losses, where nothing swings) that its second differences along the
shape have in those of all. Knows nothing of trains.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import NDArray

from gearblocks.solver.point import Point, state_matrix
from gearblocks.solver.structures import Array

MOST = 400
"""States of a model whose modes are looked for."""
_REAL = 1e-9  # a smaller imaginary part, relative to the eigenvalue, is rounding


@final
@dataclass(frozen=True, slots=True, eq=False)
class FastMode:
    """One mode: its eigenvalue [1/s], shares of components, and the part of every state, shape (n,)."""

    value: complex
    shares: dict[str, float]
    parts: Array

    @property
    def swings(self) -> bool:
        """Whether it is a vibration, and does not only decay."""
        return abs(self.value.imag) > _REAL * abs(self.value)

    @property
    def rate(self) -> float:
        """abs(s) [1/s]."""
        return abs(self.value)

    @property
    def element(self) -> str:
        """The component with the largest share; "" where none has one."""
        return max(self.shares, key=self.shares.__getitem__, default="")


def fast_modes(point: Point) -> list[FastMode]:
    """Modes from the fastest down, one of each pair; none of a long train, or where the matrix has no vectors."""
    n = point.program.n
    if not 0 < n <= MOST:
        return []
    values, vectors = np.linalg.eig(np.asarray(state_matrix(point).toarray(), dtype=np.float64))
    try:
        left = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        left = np.linalg.pinv(vectors)
    fastest = np.abs(values).max(initial=0.0)
    kept = [
        i for i in np.argsort(-np.abs(values), kind="stable") if values[i].imag >= 0 and abs(values[i]) > 1e-9 * fastest
    ]
    return [
        FastMode(complex(values[i]), shares_of(point, vectors[:, i], values[i]), np.abs(left[i] * vectors[:, i]))
        for i in kept
    ]


def shares_of(point: Point, shape: NDArray[np.complex128], value: complex) -> dict[str, float]:
    """Shares of the components in a mode: of its strain energy, or of its losses where it decays without swinging."""
    swings = abs(value.imag) > _REAL * abs(value)
    found = _strain(point, shape) if swings else _losses(point, shape)
    found = found or _strain(point, shape)
    total = sum(found.values())
    return {c: x / total for c, x in found.items() if x > 0} if total > 0 else {}


def _steps(point: Point, shape: NDArray[np.complex128]) -> Sequence[Array]:
    """Both parts of a shape as steps in the state, small beside the deflections at the point."""
    coordinates = [i for i, s in enumerate(point.program.states) if s.kind == "coordinate"]
    size = float(np.abs(point.y[coordinates]).max(initial=0.0)) or 1e-3
    largest = float(np.abs(shape[coordinates]).max(initial=0.0)) or float(np.abs(shape).max(initial=0.0))
    steps = np.zeros((2, point.program.n_total))
    if largest > 0:
        steps[:, : point.program.n] = np.array([shape.real, shape.imag]) * (1e-3 * size / largest)
    return list(steps)


def _strain(point: Point, shape: NDArray[np.complex128]) -> dict[str, float]:
    """Energy that the shape stores in each component."""
    places = [(e.component, e.offset) for e in point.program.energies if e.part == "stored"]
    return _curvatures(point, shape, point.energies, places)


def _losses(point: Point, shape: NDArray[np.complex128]) -> dict[str, float]:
    """Power that each component loses while the train moves as the shape does."""
    places = [(x.component, x.offset) for x in point.program.integrals if x.part == "loss"]
    return _curvatures(point, shape, point.rates, places)


def _curvatures(
    point: Point, shape: NDArray[np.complex128], values: Callable[..., Array], places: Sequence[tuple[str, int]]
) -> dict[str, float]:
    """Second differences of values along both parts of a shape, at the places of each component added up, where > 0."""
    base, found = values(), dict[str, float]()
    for step in _steps(point, shape):
        change = values(point.y + step) - 2 * base + values(point.y - step)
        for component, offset in places:
            found[component] = found.get(component, 0.0) + float(change[offset])
    return {c: x for c, x in found.items() if x > 0}
