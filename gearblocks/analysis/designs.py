"""Designs of studies: which points of a space of values are run - grids, lists of cases, random and Latin-hypercube samples.

Knows nothing of trains and runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearblocks.errors import ParameterError, by_name, by_name_only
from gearblocks.language.expression import finite_number
from gearblocks.language.units import check_unit, has_unit, in_unit, unit_written

Array = NDArray[np.float64]
Bounds: TypeAlias = "tuple[float, float] | tuple[str, str]"


@final
@dataclass(frozen=True, slots=True, eq=False)
class Design:
    """Points of a study, shape (points, paths). levels: the values along each dimension of a grid; None: a list of cases."""

    paths: tuple[str, ...]
    points: Array
    levels: tuple[Array, ...] | None

    @property
    def shape(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return (len(self.points),) if self.levels is None else tuple(map(len, self.levels))

    def __repr__(self) -> str:
        words = " x ".join(map(str, self.shape))
        return f"<Design: {words} {'cases' if self.levels is None else 'points'} over {', '.join(self.paths)}>"


def grid(values: Mapping[str, ArrayLike]) -> Design:
    """Every combination of the values by path; the last path varies fastest. Raises ParameterError."""
    levels = tuple(_row(path, given) for path, given in _named(values).items())
    mesh = np.meshgrid(*levels, indexing="ij")
    return Design(tuple(values), np.column_stack([axis.ravel() for axis in mesh]), levels)


def cases(given: Sequence[Mapping[str, float]] | Mapping[str, ArrayLike]) -> Design:
    """A list of cases (dicts with the same paths), or columns of equal length by path. Raises ParameterError."""
    if isinstance(given, Mapping):
        columns = {path: _row(path, column) for path, column in _named(given).items()}
    else:
        columns = _columns(given)
    lengths = {path: len(column) for path, column in columns.items()}
    if len(set(lengths.values())) > 1:
        listed = ", ".join(f"{path}: {n}" for path, n in lengths.items())
        raise ParameterError(f"cases: the columns must be of equal length, not {listed}; a grid is what gb.sweep takes")
    return Design(tuple(columns), np.column_stack([*columns.values()]), None)


def with_numbers(given: Any, number: Callable[[str, Any], float]) -> Any:
    """Values by path (rows, or dicts of a case each) with number(path, value) in place of those that bring their unit."""

    def row(path: Any, values: Any) -> Any:
        if isinstance(values, str):
            raise ParameterError(f"'{path}': {values!r:.80} is one value; a row is needed, such as [{values!r:.80}]")
        cells = [*values] if has_unit(values) or _has_texts(values) else values
        return [number(path, x) if has_unit(x) else x for x in cells] if isinstance(cells, (list, tuple)) else cells

    if isinstance(given, Mapping):
        return {path: row(path, values) for path, values in given.items()}
    if not isinstance(given, Sequence) or not all(isinstance(case, Mapping) for case in given):
        return given
    return [{path: number(path, x) if has_unit(x) else x for path, x in case.items()} for case in given]


def paths_of(given: Any) -> set[str]:
    """Paths of values, or of dicts of a case each."""
    listed = [given] if isinstance(given, Mapping) else given if isinstance(given, Sequence) else []
    return {path for case in listed if isinstance(case, Mapping) for path in case if isinstance(path, str)}


def rows_of(given: Any) -> Mapping[str, Any]:
    """Rows of values by path, of dicts of a case each, too."""
    if isinstance(given, Mapping):
        return given
    return {path: [case[path] for case in given if path in case] for path in sorted(paths_of(given))}


def _has_texts(values: Any) -> bool:
    return isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "UO"


@by_name_only
def latin_hypercube(bounds: Mapping[str, Bounds], number: int, *, seed: int = 0) -> dict[str, NDArray[Any]]:
    """Cases for `gb.study`: `number` values of every path between (low, high), one in each of as many equal slices of it.

    Bounds may bring their unit ("100 MN/m", "200 MN/m"); so do the values then. Returns columns of shape (number,) by path;
    the same seed gives the same ones (scipy.stats.qmc.LatinHypercube).
    """
    from scipy.stats import qmc

    return _scaled(bounds, lambda d, n: qmc.LatinHypercube(d, seed=np.random.default_rng(seed)).random(n), number)


@by_name_only
def random_cases(bounds: Mapping[str, Bounds], number: int, *, seed: int = 0) -> dict[str, NDArray[Any]]:
    """Cases for `gb.study`: `number` independent values of every path, uniform between (low, high).

    Bounds may bring their unit; so do the values then. Returns columns of shape (number,) by path; the same seed gives the
    same ones.
    """
    return _scaled(bounds, lambda d, n: np.random.default_rng(seed).random((n, d)), number)


def _scaled(bounds: Mapping[str, Bounds], unit_points: Any, number: int) -> dict[str, NDArray[Any]]:
    if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or number < 1:
        raise ParameterError(f"number = {number!r} must be a whole number of cases, >= 1")
    lows: list[float] = []
    highs: list[float] = []
    units: list[str | None] = []
    for path, pair in _named(bounds).items():
        try:
            low, high = pair
        except (TypeError, ValueError):
            raise ParameterError(f"'{path}': {pair!r:.80} must be the pair (low, high)") from None
        unit = unit_written(low)
        names = (f"the lower bound of '{path}'", f"the upper bound of '{path}'")
        if (unit is None) != (unit_written(high) is None):
            raise ParameterError(
                f"'{path}': the bounds {low!r} and {high!r} must both bring their unit, or none of them"
            )
        for name, bound, row in zip(names, (low, high), (lows, highs), strict=True):
            row.append(finite_number(name, bound) if unit is None else in_unit(name, bound, check_unit(name, unit)))
        units.append(unit)
        if not lows[-1] < highs[-1]:
            raise ParameterError(f"'{path}': the lower bound {low!r} must be below the upper one, {high!r}")
    points = unit_points(len(lows), int(number))
    return {
        path: _column(low + (high - low) * points[:, i], unit)
        for i, (path, low, high, unit) in enumerate(zip(bounds, lows, highs, units, strict=True))
    }


def _column(numbers: Array, unit: str | None) -> NDArray[Any]:
    """Numbers, or texts of them with their unit."""
    return numbers if unit is None else np.array([f"{x!r} {unit}" for x in numbers.tolist()])


def _named(values: Any) -> Mapping[str, Any]:
    found = by_name("the values by path", values)
    if not found:
        raise ParameterError("a study needs at least one path with values, such as {'mesh.k': [1e8, 2e8]}")
    for path in found:
        if not isinstance(path, str):
            raise ParameterError(f"the values by path: {path!r:.80} must be text such as 'mesh.k'")
    return found


def _row(path: str, values: Any) -> Array:
    try:
        row = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, ParameterError):
        raise ParameterError(f"'{path}': {values!r:.80} must be a row of numbers") from None
    if row.ndim != 1 or not len(row):
        shown = f"{values!r:.80}" if row.ndim == 0 else f"an array of shape {row.shape}"
        way = f"[{values!r:.60}]" if row.ndim == 0 else "[1.0, 2.0]"
        raise ParameterError(f"'{path}': {shown} must be a row of numbers, such as {way}")
    if not np.isfinite(row).all():
        i = int(np.argmin(np.isfinite(row)))
        raise ParameterError(f"'{path}': value [{i}] = {row[i]} must be a finite number; leave it out or repair it")
    return row


def _columns(given: Any) -> dict[str, Array]:
    try:
        rows = [dict(by_name(f"case {i}", case)) for i, case in enumerate(given)]
    except TypeError:
        raise ParameterError(f"cases = {given!r:.80} must be a list of dicts, or a dict of columns") from None
    if not rows or not rows[0]:
        raise ParameterError("a study needs at least one case with values, such as [{'mesh.k': 1e8}]")
    for i, row in enumerate(rows):
        if row.keys() != rows[0].keys():
            odd = sorted(map(str, row.keys() ^ rows[0].keys()))
            raise ParameterError(f"case {i} and case 0 differ in {', '.join(odd)}: every case gives the same paths")
    return {path: _row(path, [row[path] for row in rows]) for path in _named(rows[0])}
