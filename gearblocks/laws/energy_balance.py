"""Energy balance of a law: supplied = d stored/dt + loss + sum tau_f w_f over the flanges.

What neither a stored energy nor a loss explains of the power of all torques is exchange with sources. Whether a rest vanishes
is asked at fixed points. Knows nothing of kinetic energy, nor of trains.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, fsum, prod, sin
from random import Random
from typing import Any

import sympy as sp

from gearblocks.laws.functions import Table2At, TableAt
from gearblocks.laws.law import Law
from gearblocks.laws.symbols import Pool, time_symbol


def vanishes(expr: Any, pool: Pool) -> bool:
    """Whether an expression is zero at a handful of fixed points (modes 0 or 1); expanding it would take far longer."""
    if expr == 0 or not expr.free_symbols:
        return bool(expr == 0)
    # a table and its derivatives are as good as independent values
    tables = sorted(expr.atoms(TableAt, Table2At), key=str)
    values_of_tables = {x: sp.Symbol(f"table value {i}", real=True) for i, x in enumerate(tables)}
    expr = expr.xreplace(values_of_tables)
    free = set(values_of_tables.values())
    symbols = sorted(expr.free_symbols, key=lambda x: str(x.name))
    random = Random(20)
    good = 0
    for _ in range(40):
        point: dict[Any, float] = {
            x: float(random.randint(0, 1))
            if x not in free and pool.roles[x].role in ("mode", "direction", "stuck")
            else random.uniform(0.2, 1.2)
            for x in symbols
        }
        try:
            values = [_number(term, point) for term in sp.Add.make_args(expr)]
        except (TypeError, ValueError, ArithmeticError):  # the point lies outside of what the law is defined for
            continue
        if abs(fsum(values)) > 1e-12 * max(abs(v) for v in values):
            return False
        good += 1
        if good == 4:
            return True
    return good > 0 or bool(sp.expand(expr) == 0)


def _number(expr: Any, known: dict[Any, float]) -> float:
    """Value of an expression at a point; `known` grows by every part that was computed."""
    if expr in known:
        return known[expr]
    if expr.is_Number or expr.is_NumberSymbol:
        value = float(expr)
    elif expr.is_Add:
        value = fsum(_number(a, known) for a in expr.args)
    elif expr.is_Mul:
        value = prod(_number(a, known) for a in expr.args)
    elif expr.is_Pow:
        value = _number(expr.args[0], known) ** _number(expr.args[1], known)
    elif isinstance(expr, (sp.sin, sp.cos)):
        value = (sin if isinstance(expr, sp.sin) else cos)(_number(expr.args[0], known))
    elif isinstance(expr, sp.Heaviside):
        value = float(_number(expr.args[0], known) >= 0)
    else:
        value = float(expr.func(*(sp.Float(_number(a, known)) for a in expr.args)))
    if isinstance(value, complex):
        raise ValueError(f"{expr} is no real number")
    known[expr] = value
    return value


def add_energy_balance(law: Law, flanges: Mapping[str, Any]) -> None:
    """supplied = d stored/dt + loss + power given to the flanges: what neither stored nor lost energy explains."""
    parametric: Any = sp.Integer(0)
    rest = sum((tau.xreplace(law.forces) * flanges[n].w for n, tau in law.torques.items()), sp.Integer(0))
    rest += law.loss if law.loss is not None else 0
    if law.stored is not None:
        parametric = sp.diff(law.stored, time_symbol())
        for form, u in zip(law.forms, law.coordinates, strict=True):
            rate = sum(c * flanges[n].w for n, c in form.coefficients.items())
            rest += sp.diff(law.stored, u) * rate
        rest += sum(sp.diff(law.stored, f.phi) * f.w for f in flanges.values())
        for name, rate in law.rates.items():
            rest += sp.diff(law.stored, law.pool.symbol("state", name, name)) * rate
    supplied = parametric + (0 if vanishes(rest, law.pool) else rest)
    law.supplied = None if supplied == 0 else supplied
