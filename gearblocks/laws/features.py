"""Narrow features of a law: arguments of functions that are flat but for a part of their range.

exp(-(w/s)^2), tanh(w/s), w/sqrt(w^2 + s^2): over most w they are constants, and a step whose stages all lie there does not
know of the rest. The law announces the argument in units of the width of the feature,

    x = (u - centre) / width,   or u itself inside a narrow function of sin(u) or cos(u),

and the solver ends a step where x has moved through too much of it. Kinks are no features: they are switches.
Knows nothing of how long a step may be.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import sympy as sp

from gearblocks.laws.law import Law
from gearblocks.laws.symbols import CONSTANT, Pool

_FLAT = (sp.exp, sp.tanh, sp.atan, sp.asinh, sp.cosh, sp.sinh)
"""Functions with a scale of 1 in their argument: flat, or without surprise, at a distance from 0."""

_STILL = frozenset({"mode", "direction", "stuck"})
"""Roles of symbols that keep their value within a step."""


@dataclass(frozen=True, slots=True)
class Feature:
    """The argument x in widths; bounded: flat where abs(x) is large, else a period of 2 pi goes on for ever."""

    argument: Any
    bounded: bool


def narrow_features(law: Law) -> list[Feature]:
    """The narrow features of what moves the train, each once."""
    found: dict[Feature, None] = {}
    for e in law.expressions("forces", "torques", "rates", "prescribed", "constraints"):
        for node in sorted(sp.sympify(e).atoms(*_FLAT, sp.Pow), key=sp.default_sort_key):
            for argument in _arguments(law.pool, node):
                found[Feature(argument, True)] = None
                for wave in argument.atoms(sp.sin, sp.cos):
                    if law.pool.level(wave) != CONSTANT:
                        found[Feature(wave.args[0], False)] = None
    return list(found)


def _arguments(pool: Pool, node: Any) -> Iterator[Any]:
    """Arguments in widths of one function."""
    moving = [x for x in node.free_symbols if pool.roles[x].role not in _STILL and pool.level(x) != CONSTANT]
    if not moving:
        return
    if isinstance(node, sp.Pow):
        if (node.exp.is_Integer and node.exp > 0) or node.exp.has(*moving):
            return
        constant, rest = node.base.as_independent(*moving, as_Add=True)
        if constant != 0:
            yield from _even(rest / constant, moving)
        return
    rest = node.args[0].as_independent(*moving, as_Add=True)[1]
    squares = list(_even(rest, moving))
    yield from squares if squares and isinstance(node, (sp.exp, sp.cosh)) else [node.args[0]]


def _even(expr: Any, moving: list[Any]) -> Iterator[Any]:
    """Arguments u of a sum of even powers k u^n, as k^(1/n) u; none where it is something else."""
    found = []
    for term in sp.Add.make_args(_completed(expr, moving)):
        factor, powers = term.as_independent(*moving, as_Add=False)
        order, root = _root(powers, moving)
        if order == 0:
            return
        found.append(sp.Pow(sp.Abs(factor), sp.Rational(1, order)) * root)
    yield from found


def _root(powers: Any, moving: list[Any]) -> tuple[int, Any]:
    """(n, u d) of (u d)^n, n even: u^n, or u^n d^n where d^m has no zero, as a slip that is relative to hypot(w, s).

    n = 0 where it is something else.
    """
    factors = [x.as_base_exp() for x in sp.Mul.make_args(powers)]
    if any(not n.is_Integer for _, n in factors):
        return 0, None
    signed = factors if len(factors) == 1 else [(x, n) for x, n in factors if not _has_no_zero(x, moving)]
    order = math.gcd(*(int(n) for _, n in signed))
    if order % 2 or order == 0 or any(n < 0 for _, n in signed):
        return 0, None
    return order, sp.Mul(*(sp.Pow(x, n / order) for x, n in factors))


def _has_no_zero(base: Any, moving: list[Any]) -> bool:
    """A constant and even powers of what moves: s^2 + w^2."""
    constant, rest = base.as_independent(*moving, as_Add=True)
    return constant != 0 and any(True for _ in _even(rest, moving))


def _completed(expr: Any, moving: list[Any]) -> Any:
    """a u^2 + b u as a (u + b/2a)^2, less its constant."""
    if len(moving) == 1 and expr.is_Add and expr.is_polynomial(*moving):
        u = moving[0]
        a, b, *more = (expr.expand().coeff(u, n) for n in (2, 1, 3, 4))
        if a != 0 and not any(more) and sp.degree(expr, u) == 2:
            return a * (u + b / (2 * a)) ** 2
    return expr
