"""Means of excitations by time alone, for static starts and linear tools.

Excitations are averaged one by one, not their products: a sum has the mean of each term, a product the product of the
means of its factors. A harmonic has the mean 0, its powers their own; a square wave its share of the cycle; a periodic
Table over a running phase the mean of its curve. Everything else (steps, ramps, inputs, other functions of time) keeps
the value that it has at the instant asked for. A frequency of 0 leaves the excitation as it stands.
"""

from __future__ import annotations

from math import comb, fsum
from typing import Any

import sympy as sp

from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.event_functions import line
from gearblocks.codegen.hoisting import HoistedTerm
from gearblocks.language.signals import Table
from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.functions import TableAt
from gearblocks.laws.switching import Mode
from gearblocks.laws.symbols import time_symbol

_LARGEST_POWER = 8  # of sums, which are written out term by term


def mean_of_term(code: BatchCode, item: HoistedTerm) -> Any:
    """The mean of a time term in constants, inputs and time; no other time term stands in it."""
    return mean_of(code.hoister.written_out(item.expr), code)


def mean_of(expr: Any, code: BatchCode) -> Any:
    """The mean of an expression in time, inputs and constants; see above for the rules."""
    if not _runs(expr, code):
        return expr
    if expr.is_Symbol:
        return _mean_of_mode(expr, code)
    if expr.is_Add:
        return sp.Add(*(mean_of(a, code) for a in expr.args))
    if expr.is_Mul:
        return sp.Mul(*(mean_of(a, code) for a in expr.args))
    if expr.is_Pow:
        return _mean_of_power(expr, code)
    if isinstance(expr, (sp.sin, sp.cos)):
        return _mean_of_wave(expr, 1)
    if isinstance(expr, TableAt):
        return _mean_of_table(expr, code)
    return expr


def _runs(expr: Any, code: BatchCode) -> bool:
    """Whether time or a switch of time stands in the expression."""
    return any(x == time_symbol() or code.law.pool.roles[x].role == "mode" for x in symbols_in(expr))


def _standing(rate: Any) -> Any:
    """1 where a frequency is 0, else 0."""
    return sp.Heaviside(-sp.Abs(rate), 1)


def _mean_of_wave(wave: Any, power: int) -> Any:
    """Mean of a power of sin or cos over time."""
    found = line(wave.args[0])
    if found is None:
        return wave**power
    rate, offset = found
    mean = sp.Rational(comb(power, power // 2), 2**power) if power % 2 == 0 else sp.Integer(0)
    standing = _standing(rate)
    return mean + standing * (wave.func(offset) ** power - mean)


def _mean_of_power(expr: Any, code: BatchCode) -> Any:
    base, exponent = expr.as_base_exp()
    if not exponent.is_Integer or exponent < 2:
        return expr
    if isinstance(base, (sp.sin, sp.cos)):
        return _mean_of_wave(base, int(exponent))
    if base.is_Add and exponent <= _LARGEST_POWER:
        return mean_of(sp.expand_multinomial(expr), code)
    if base.is_Symbol and code.law.pool.roles[base].role == "mode":
        return _mean_of_mode(base, code)  # 0 or 1, as its powers
    return mean_of(base, code) ** exponent


def _mean_of_mode(mode: Any, code: BatchCode) -> Any:
    """The share of the cycle in which a square wave is on; other modes as they are."""
    if mode == time_symbol():
        return mode
    meaning = code.law.pool.roles[mode]
    assert isinstance(meaning.of, Mode)
    if code.events.sorts[meaning.of.number] != "wave":
        return mode
    size, rate, _, offset = code.events.wave(meaning.of.number)
    share = sp.acos(sp.Min(1, sp.Max(-1, -offset / sp.Abs(size)))) / sp.pi
    return share + _standing(rate) * (mode - share)


def _mean_of_table(expr: Any, code: BatchCode) -> Any:
    table = code.law.pool.roles[expr.args[0]].of
    stepped = len(expr.args) == 4 and expr.args[1] == 0  # a step needs its mode alone
    found = line(code.law.switches[code.law.pool.roles[expr.args[3]].of.number].surface if stepped else expr.args[1])
    if found is None or not table.periodic:
        return expr
    mean = sp.Float(mean_of_cycle(table)) if expr.args[2] == 0 else sp.Integer(0)
    return mean + _standing(found[0]) * (expr - mean)


def mean_of_cycle(table: Table) -> float:
    """Integral mean of a periodic table over one period."""
    x, y, second = (list(map(float, row)) for row in (table.x, table.y, table.second))
    parts = []
    for i in range(len(x) - 1):
        h = x[i + 1] - x[i]
        between = y[i] if table.kind == "step" else 0.5 * (y[i] + y[i + 1])
        parts.append(h * (between - h * h * (second[i] + second[i + 1]) / 24))
    return fsum(parts) / (x[-1] - x[0])
