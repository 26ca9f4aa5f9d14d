"""Hoisting: parameter terms are computed once, time terms once per instant; the law keeps what moves with the state.

A term is shared by all instances where no number of an instance stands in it. Knows nothing of where terms are stored.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import sympy as sp

from gearblocks.laws.free_symbols import symbols_in
from gearblocks.laws.symbols import CONSTANT, MOVING, TIMED, Pool, SymbolRole


@dataclass(frozen=True, slots=True)
class HoistedTerm:
    """One hoisted expression of a batch; shared: no number of an instance stands in it."""

    symbol: Any
    expr: Any
    level: int
    shared: bool


@dataclass
class Hoister:
    """Replaces the constant and the timed parts of expressions of one batch by parameter terms and time terms."""

    pool: Pool
    terms: list[HoistedTerm] = field(default_factory=list)
    _known: dict[tuple[int, Any], Any] = field(default_factory=dict)
    _inside: dict[Any, Any] = field(default_factory=dict)

    def hoist(self, expr: Any) -> Any:
        """The expression with terms in place of everything that does not move with the state."""
        level = self.pool.level(expr)
        if level == CONSTANT:
            return expr if _is_plain(expr) else self._term(expr, CONSTANT)
        if level == TIMED:
            return self._term(self._inside_timed(expr), TIMED)
        if not expr.args:
            return expr
        if isinstance(expr, (sp.Add, sp.Mul)):
            return self._split(expr, self.hoist)
        return expr.func(*(self.hoist(a) if symbols_in(a) else a for a in expr.args))

    def written_out(self, expr: Any) -> Any:
        """The expression with no other time term in it."""
        timed = {c.symbol: c.expr for c in self.terms if c.level == TIMED}
        while any(x in timed for x in expr.free_symbols):
            expr = expr.xreplace(timed)
        return expr

    def spread(self, expr: Any) -> Any:
        """Carries factors that do not move into sums: each summand then has one hoisted term, and the longest chain of
        operations gets shorter. r (c v + k(t) g) becomes (r c) v + (r k(t)) g."""
        if not expr.args or self.pool.level(expr) != MOVING:
            return expr
        if expr.is_Add:
            return expr.func(*(self.spread(a) for a in expr.args))
        if not expr.is_Mul:
            return expr.func(*(self.spread(a) for a in expr.args))
        still = [a for a in expr.args if self.pool.level(a) != MOVING]
        moving = [self.spread(a) for a in expr.args if self.pool.level(a) == MOVING]
        factor = sp.Mul(*still)
        if len(moving) == 1 and moving[0].is_Add and factor != -1 and any(map(self._is_scaled_sum, moving[0].args)):
            return sp.Add(*(self.spread(factor * a) for a in moving[0].args))
        return sp.Mul(factor, *moving)

    def _is_scaled_sum(self, term: Any) -> bool:
        """A sum with a factor that another one can join. Bare terms such as w_a - w_b stay together: taken apart, they
        would lose the digits they have in common."""
        return bool(
            term.is_Mul
            and any(a.is_Add for a in term.args)
            and any(not a.is_Number and self.pool.level(a) != MOVING for a in term.args)
        )

    def _inside_timed(self, expr: Any) -> Any:
        """A timed expression with its constant parts as parameter terms."""
        if expr not in self._inside:
            self._inside[expr] = self._with_constants(expr)
        return self._inside[expr]

    def _with_constants(self, expr: Any) -> Any:
        if self.pool.level(expr) == CONSTANT:
            return expr if _is_plain(expr) else self._term(expr, CONSTANT)
        if not expr.args:
            return expr
        if expr.is_Add and (exact := self._without_cancellation(expr)) != expr:
            return self._inside_timed(exact)
        if isinstance(expr, (sp.Add, sp.Mul)):
            constant = [a for a in expr.args if self.pool.level(a) == CONSTANT]
            rest = list(map(self._inside_timed, (a for a in expr.args if self.pool.level(a) != CONSTANT)))
            whole = expr.func(*constant)
            return expr.func(whole if _is_plain(whole) else self._term(whole, CONSTANT), *rest)
        if isinstance(expr, (sp.sin, sp.cos)):
            return self._wave(expr)
        return expr.func(*(self._inside_timed(a) if symbols_in(a) else a for a in expr.args))

    def _without_cancellation(self, expr: Any) -> Any:
        """c - c cos x as 2 c sin^2(x/2): a load that starts softly keeps its digits, which is all that moves a train from
        rest."""
        constant = sp.Add(*(a for a in expr.args if self.pool.level(a) == CONSTANT))
        for term in expr.args:
            factor, wave = term.as_independent(sp.cos, as_Add=False)
            if constant != 0 and isinstance(wave, sp.cos) and factor == -constant:
                return 2 * constant * sp.sin(wave.args[0] / 2) ** 2 + (expr - constant - term)
        return expr

    def _wave(self, expr: Any) -> Any:
        """The time term of a sine or cosine of time. A constant phase that belongs to the instance is taken out by the
        addition theorem, so that instances with other phases share one sine and one cosine."""
        summands = sp.Add.make_args(sp.expand(expr.args[0]))
        phase = sp.Add(*(a for a in summands if self.pool.level(a) == CONSTANT))
        running = sp.Add(*(a for a in summands if self.pool.level(a) != CONSTANT))
        if self._is_common(phase) or not self._is_common(running):
            return self._term(expr.func(self._inside_timed(expr.args[0])), TIMED)
        c, s = (self._term(f(self._inside_timed(running)), TIMED) for f in (sp.cos, sp.sin))
        c0, s0 = (self._term(f(phase), CONSTANT) for f in (sp.cos, sp.sin))
        return self._term(s * c0 + c * s0 if isinstance(expr, sp.sin) else c * c0 - s * s0, TIMED)

    def _split(self, expr: Any, moving: Callable[[Any], Any]) -> Any:
        groups: dict[int, list[Any]] = {CONSTANT: [], TIMED: [], MOVING: []}
        for a in expr.args:
            groups[self.pool.level(a)].append(a)
        if groups[TIMED]:
            still = [expr.func(*groups[CONSTANT], *groups[TIMED])]
        else:
            still = [expr.func(*groups[CONSTANT])] if groups[CONSTANT] else []
        return expr.func(*(self.hoist(a) for a in still), *(moving(a) for a in groups[MOVING]))

    def _term(self, expr: Any, level: int) -> Any:
        if (level, expr) not in self._known:
            symbol = sp.Symbol(f"column{len(self.terms)}", real=True)
            shared = self._is_common(expr)
            self.pool.roles[symbol] = SymbolRole("hoisted", (level, shared))
            self.terms.append(HoistedTerm(symbol, expr, level, shared))
            self._known[level, expr] = symbol
        return self._known[level, expr]

    def _is_common(self, expr: Any) -> bool:
        """Whether no number of an instance stands in it."""
        return all(self._is_shared(x) for x in symbols_in(expr))

    def _is_shared(self, symbol: Any) -> bool:
        meaning = self.pool.roles[symbol]
        if meaning.role == "hoisted":
            return bool(meaning.of[1])
        return meaning.role not in ("own", "exact", "mobility", "mode")


def _is_plain(expr: Any) -> bool:
    """A number, a symbol, or a number times a symbol: not worth a term."""
    if expr.is_Atom:
        return True
    if expr.is_Mul:
        return len([a for a in expr.args if not a.is_Number]) == 1 and all(a.is_Atom for a in expr.args)
    return False
