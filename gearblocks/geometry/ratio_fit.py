"""Ratio laws from their descriptions: periodic polynomial or trigonometric curves F(phi) with F(T) - F(0) = 2 pi/n2.

A line m = k phi + b with a transition; functions, as Fourier sums (exact) or by Chebyshev interpolation on halved
segments; points, joined by a periodic cubic spline. Knows nothing of the law itself, nor of pitch curves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from gearblocks.errors import ParameterError
from gearblocks.geometry.ratio_curves import (
    TURN,
    Array,
    Curve,
    Pieces,
    RatioLawError,
    Waves,
    derivatives,
    extremes,
)
from gearblocks.language.expression import Expr, as_expr, evaluate, is_sympy, leaf_symbol_class, to_sympy

FIT_DEGREE = 12
FIT_WANTED, FIT_ALLOWED = 1e-13, 1e-10
"""Errors of m, relative to its largest value: what the fit goes for, and what it is refused at."""


@dataclass(frozen=True, slots=True)
class Fit:
    """The periodic curve of a law, the recipe that it was made from, and what the fit did; see `RatioLaw` for the fields."""

    recipe: tuple[str, tuple[Any, ...]]
    n1: int
    n2: int
    curve: Curve
    fit_error: float = 0.0
    scaled: float = 1.0


def parts_of_turn(what: str, angle: float) -> int:
    """Whole number of times that an angle [rad] goes into a turn."""
    n = round(TURN / angle) if angle > 0 else 0
    if n < 1 or abs(TURN / angle - n) > 1e-9 * n:
        raise RatioLawError(
            f"{what} = {angle!r} rad must be 2 pi or 2 pi over a whole number: else the pitch curve does not close"
        )
    return n


# -- a line and a transition ------------------------------------------------------------------------------------------


def segments(k: float, b: float, X: float, T: float, G: float) -> Fit:
    """Fit of `RatioLaw.segments`; m may still fall to 0 or below."""
    n1, n2 = parts_of_turn("RatioLaw.segments: T", T), parts_of_turn("RatioLaw.segments: G", G)
    if not 0 < X < T:
        raise RatioLawError(f"RatioLaw.segments: X = {X!r} rad must be > 0 and < T = {T!r} rad")
    return Fit(("segments", (k, b, X, T, G)), n1, n2, _line_and_transition(k, b, X, n1, n2))


def transition_size(k: float, b: float, X: float, T: float, G: float) -> float:
    """C: how much the transition must add to close the curve."""
    return 140 * (G - T * (b + k * X / 2)) / (T - X)


def _line_and_transition(k: float, b: float, X: float, n1: int, n2: int) -> Pieces:
    """The ripple. With v in [-1, 1] over the transition of half width h about c,

    m = b + k (c + h v) - k T (1/2 + 15/16 v - 5/8 v^3 + 3/16 v^5) + C (1 - v^2)^3/64.
    """
    T, ratio = TURN / n1, n1 / n2
    C = transition_size(k, b, X, T, TURN / n2)
    working = np.zeros(7)
    working[:2] = b - ratio + k * X / 2, k * X / 2
    c, h = (X + T) / 2, (T - X) / 2
    rest = np.array([b - ratio + k * c, k * h, 0, 0, 0, 0, 0])
    rest += -k * T * np.array([1 / 2, 15 / 16, 0, -5 / 8, 0, 3 / 16, 0]) + C / 64 * np.array([1, 0, -3, 0, 3, 0, -1])
    return integrated(np.array([0.0, X, T]), np.array([working, rest]), joints=True)


def integrated(x: Array, slopes: Array, *, joints: bool) -> Pieces:
    """The periodic curve with the given slope polynomials (over v in [-1, 1]) that is 0 at x[0]."""
    half = np.diff(x) / 2
    y = np.zeros((len(slopes), slopes.shape[1] + 1))
    y[:, 1:] = half[:, None] * slopes / np.arange(1, slopes.shape[1] + 1)
    signs = (-1.0) ** np.arange(y.shape[1])
    start = 0.0
    for row in y:
        row[0] = start - float(row @ signs)
        start = math.fsum(row)
    return Pieces(x, y, joints)


def largest_segment(k: float, b: float, n1: int, n2: int) -> float | None:
    """The longest working segment [rad] for which m > 0, to 1e-12; None where there is none."""
    T = TURN / n1

    def smallest(X: float) -> float:
        curve = _line_and_transition(k, b, X, n1, n2)
        return extremes(lambda x: n1 / n2 + curve.value(x, 1), lambda x: curve.value(x, 2), T, 720).smallest

    def seems_feasible(X: float) -> bool:
        curve = _line_and_transition(k, b, X, n1, n2)
        return bool((n1 / n2 + curve.value(np.concatenate([[0.0], np.linspace(X, T, 500)]), 1)).min() > 0)

    tried = np.linspace(0.0, T, 721)
    for i in range(719, 0, -1):
        if seems_feasible(tried[i]) and smallest(tried[i]) > 0:
            low, high = float(tried[i]), float(tried[i + 1])
            break
    else:
        return None
    while high - low > 1e-12:
        middle = (low + high) / 2
        low, high = (middle, high) if smallest(middle) > 0 else (low, middle)
    return low


# -- functions --------------------------------------------------------------------------------------------------------


def from_function(m: Any, T: float, normalise: bool) -> Fit:
    """Fit of `RatioLaw.from_function`."""
    expr = _of_driver_angle(m)
    n1 = parts_of_turn("RatioLaw.from_function: T", T)
    recipe = ("from_function", (str(expr), T, normalise))
    waves = _as_waves(expr, n1)
    if waves is not None:
        mean, curve = waves
        return closed(recipe, n1, mean, curve, normalise, 0.0)

    def ratio(phi: float) -> float:
        try:
            return float(evaluate(expr, lambda _: phi))
        except (ArithmeticError, ValueError, TypeError):
            raise RatioLawError(f"{recipe[0]}: m = '{expr}' has no value at phi = {phi:.9g} rad") from None

    values = np.vectorize(ratio, otypes=[float])
    _check_period(str(expr), values, T)
    x, slopes, error = _fitted(str(expr), values, T)
    powers = 1 / np.arange(1, slopes.shape[1] + 1)
    mean = float((slopes[:, ::2] @ powers[::2]).mean())
    slopes[:, 0] -= mean
    return closed(recipe, n1, mean, integrated(x, slopes, joints=False), normalise, error)


def _of_driver_angle(m: Any) -> Expr:
    """m as an expression whose only leaf is the driver angle."""
    if is_sympy(m):
        symbols = [x for x in m.free_symbols if not hasattr(x, "leaf")]
        if len(symbols) > 1:
            raise ParameterError(
                f"m = '{m}' has the symbols {', '.join(sorted(map(str, symbols)))}; leave one, the angle"
            )
        m = m.xreplace({x: leaf_symbol_class()(driver_angle) for x in symbols})
    expr = as_expr(m)
    for leaf in expr.leaves():
        if leaf.op != "local" or leaf.args[0] != "driver_angle":
            raise ParameterError(f"m = '{expr}' contains '{leaf}': a ratio law depends on gb.driver_angle alone")
    return expr


def _as_waves(expr: Expr, n1: int) -> tuple[float, Waves] | None:
    """(mean of m, ripple of F) where m is a sum of sines and cosines of multiples of n1 phi."""
    import sympy as sp
    from sympy.simplify.fu import TR8

    phi = sp.Symbol("phi", real=True)
    m = sp.expand(to_sympy(expr, lambda _: phi))
    if m.has(sp.Piecewise, sp.Abs, sp.Heaviside) or not all(a.args[0].has(phi) for a in m.atoms(sp.sin, sp.cos)):
        return None
    terms = sp.Add.make_args(sp.expand(sp.expand_trig(m) if m.has(sp.tan) else TR8(m)))
    mean, found = 0.0, dict[int, list[float]]()
    for term in terms:
        factor, wave = term.as_independent(phi)
        if wave == 1:
            mean += float(factor)
            continue
        if not isinstance(wave, (sp.sin, sp.cos)):
            return None
        w, offset = sp.diff(wave.args[0], phi), wave.args[0].subs(phi, 0)
        if not w.is_Integer or int(w) % n1 or offset != 0:
            return None
        row = found.setdefault(abs(int(w)) // n1, [0.0, 0.0])
        if isinstance(wave, sp.sin):
            row[0] -= float(factor) / int(w)
        else:
            row[1] += float(factor) / abs(int(w))
    orders = range(1, max(found, default=0) + 1)
    rows = [found.get(j, [0.0, 0.0]) for j in orders]
    return mean, Waves(n1, tuple(r[0] for r in rows), tuple(r[1] for r in rows))


def _check_period(text: str, m: Callable[[Any], Array], T: float) -> None:
    jump = float(m(T) - m(0.0))
    size = float(np.abs(m(np.linspace(0, T, 65))).max())
    if abs(jump) > 1e-9 * size:
        raise RatioLawError(f"m = '{text}' does not repeat after T = {T!r} rad: m(T) - m(0) = {jump:.3g}")


def _fitted(text: str, m: Callable[[Any], Array], T: float) -> tuple[Array, Array, float]:
    """(joints, polynomials over v, error of m): Chebyshev interpolation on halved segments until it is exact."""
    nodes, between = chebyshev.chebpts1(FIT_DEGREE + 1), np.linspace(-1, 1, 4 * FIT_DEGREE + 1)
    for n in (16, 32, 64, 128, 256):
        x = np.linspace(0.0, T, n + 1)
        middle, half = (x[1:] + x[:-1])[:, None] / 2, T / n / 2
        rows = chebyshev.chebfit(nodes, m(middle + half * nodes).T, FIT_DEGREE).T
        true = m(middle + half * between)
        wrong = np.abs(chebyshev.chebval(between, rows.T) - true).max(axis=1)
        size = float(np.abs(true).max())
        if wrong.max() <= FIT_WANTED * size:
            break
    if wrong.max() > FIT_ALLOWED * size:
        at = float(x[int(wrong.argmax())])
        raise RatioLawError(
            f"m = '{text}' is not smooth near phi = {math.degrees(at):.4g} deg (a fit is off by {wrong.max():.2g}); "
            "give segments or a table with points at its kinks"
        )
    slopes = np.array([power_series(row) for row in rows])
    _check_joints(text, x, slopes)
    return x, slopes, float(wrong.max())


def power_series(row: Array) -> Array:
    """Coefficients of a Chebyshev series as those of a power series of the same length.

    cheb2poly drops trailing coefficients that are exactly 0; whether rounding leaves a 0 depends on the processor.
    """
    powers = chebyshev.cheb2poly(row)
    return np.pad(powers, (0, len(row) - len(powers)))


def _check_joints(text: str, x: Array, slopes: Array) -> None:
    """Refuses kinks that happen to lie at a joint of the fit, where no polynomial shows them."""
    for order in (1, 2):
        rows = derivatives(slopes, order) / (np.diff(x)[:, None] / 2) ** order
        ends, starts = rows.sum(axis=1), rows @ (-1.0) ** np.arange(rows.shape[1])
        jumps = starts - np.roll(ends, 1)  # the first one: where the period closes
        worst = int(np.abs(jumps).argmax())
        if abs(jumps[worst]) > 1e-3 * (1 + np.abs(ends).max()):  # of a smooth m the fit leaves less than 1e-5
            raise RatioLawError(
                f"m = '{text}': its derivative of order {order} jumps by {jumps[worst]:.3g} "
                f"at phi = {math.degrees(x[worst]):.4g} deg; give segments or a table with points at its kinks"
            )


def closed(
    recipe: tuple[str, tuple[Any, ...]], n1: int, mean: float, curve: Curve, normalise: bool, error: float
) -> Fit:
    """The fit, if gear 2 closes, or is made to. mean: of m; curve: the ripple that goes with it."""
    what = f"RatioLaw.{recipe[0]}"
    if mean <= 0:
        raise RatioLawError(f"{what}: m has the mean {mean:.9g}, but m must stay > 0")
    n2 = max(1, round(n1 / mean))
    scaled = n1 / n2 / mean
    if abs(scaled - 1) > 0.1:
        raise RatioLawError(
            f"{what}: gear 2 turns by {math.degrees(TURN * mean / n1):.6g} deg over a period of {360 / n1:.6g} deg; "
            f"its pitch curve closes only with 360 deg over a whole number ({360 / n2:.6g} deg is nearest)"
        )
    if abs(scaled - 1) > 1e-12 and not normalise:
        drift = math.degrees(TURN * mean) * n2 / n1 - 360
        raise RatioLawError(
            f"{what}: the pitch curve of gear 2 does not close: it drifts by {drift:+.6g} deg a turn; "
            f"scale m by {scaled:.12g}, or give normalise=True to have that done"
        )
    if isinstance(curve, Pieces):
        curve = Pieces(curve.x, curve.y * scaled, curve.joints)
    elif isinstance(curve, Waves):
        curve = Waves(curve.frequency, tuple(a * scaled for a in curve.cos), tuple(b * scaled for b in curve.sin))
    return Fit(recipe, n1, n2, curve, error, scaled)


# -- tables -----------------------------------------------------------------------------------------------------------


def from_table(phi: ArrayLike, m: ArrayLike, normalise: bool) -> Fit:
    """Fit of `RatioLaw.from_table`."""
    from scipy.interpolate import CubicSpline

    x, y = np.array(phi, dtype=float), np.array(m, dtype=float)
    if x.ndim != 1 or x.shape != y.shape or len(x) < 4 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ParameterError(f"RatioLaw.from_table: phi {x.shape} and m {y.shape} must be two rows of >= 4 numbers")
    if not (np.diff(x) > 0).all() or x[0] != 0:
        raise ParameterError("RatioLaw.from_table: phi must begin with 0 and increase")
    if y[0] != y[-1]:
        raise RatioLawError(f"RatioLaw.from_table: m must end where it begins, but m[0] = {y[0]}, m[-1] = {y[-1]}")
    n1 = parts_of_turn("RatioLaw.from_table: phi[-1]", float(x[-1]))
    spline = CubicSpline(x, y, bc_type="periodic")
    mean = float(spline.integrate(0.0, x[-1])) / float(x[-1])
    middle, half = (x[1:] + x[:-1]) / 2, np.diff(x) / 2
    slopes = np.array([spline(middle, j) * half**j / math.factorial(j) for j in range(4)]).T
    slopes[:, 0] -= mean
    recipe = ("from_table", (tuple(x.tolist()), tuple(y.tolist()), normalise))
    return closed(recipe, n1, mean, integrated(x, slopes, joints=True), normalise, 0.0)


driver_angle = Expr("local", "driver_angle")  # angle of gear 1 from its carrier in rad, for laws and stiffnesses
