"""What stands in several equations of a part gets a symbol of its own: the phase of its waves, the slope of what they make.

    k = k0 (1 + a cos(z (φ_sun - φ_carrier)))      k = k0 (1 + a cos ψ),   ψ = z (φ_sun - φ_carrier)
    -N (r - a z cos(z (φ_sun - φ_carrier)))       -N (r - e_φ),           e_φ = a z cos ψ

Knows nothing of how it is shown, nor of derivations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import sympy as sp

from gearblocks.laws.functions import TableAt

_FEWEST = 2
_LONG = 2
"""Operations of a phase that is worth a symbol: z φ is none."""


class Part(NamedTuple):
    """What one part of the train says: its definitions, and its terms of the balances by their place in these."""

    definitions: dict[Any, Any]
    terms: dict[int, Any]

    def mapped(self, change: Callable[[Any], Any]) -> Part:
        """With every expression changed."""
        return Part({s: change(e) for s, e in self.definitions.items()}, {i: change(e) for i, e in self.terms.items()})

    def expressions(self) -> Iterator[Any]:
        """Those that are printed: rates are not, where what they are the rates of is."""
        yield from (e for s, e in self.definitions.items() if "'" not in s.name)
        yield from self.terms.values()


def with_symbols(part: Part, angles: Iterable[Any], phase: Callable[..., Any], slope: Callable[[Any], Any]) -> Part:
    """A part with its phases and slopes as symbols; phase: the symbol of one by its number (0: the only one) and whether it is
    counted in cycles; slope: of that of a definition."""
    moving = [*angles]
    part, phases = _with_phases(part, {*moving}, phase)
    return _with_slopes(part, moving, phases, slope)


def _with_phases(part: Part, angles: set[Any], name: Callable[..., Any]) -> tuple[Part, dict[Any, Any]]:
    """Phases that stand in several functions as symbols, defined before what reads them; and what they stand for."""
    waves = [f for e in part.expressions() for f in _waves(e, angles)]
    bases: dict[Any, bool] = {}
    for phase in map(_phase, waves):
        alike = {f: times for f in waves if (times := _times(_phase(f), phase))}
        known = any(_times(phase, base) for base in bases)
        if not known and sum(f in alike for f in waves) >= _FEWEST and sp.count_ops(phase) >= _LONG:
            base = _phase(min(alike, key=lambda f: abs(alike[f])))
            bases[base] = all(isinstance(f, TableAt) for f in alike)
    defined = {e: s for s, e in part.definitions.items() if "'" not in s.name}
    new = [base for base in bases if base not in defined]
    named = {base: name(n if len(new) > 1 else 0, bases[base]) for n, base in enumerate(new, 1)}
    phases = {named.get(base) or defined[base]: base for base in bases}
    for symbol, base in phases.items():
        part = part.mapped(lambda e, base=base, symbol=symbol: _over(e, base, symbol))  # type: ignore[misc]
        if base in named:
            part = part._replace(definitions=_inserted(part.definitions, symbol, base))
    return part, phases


def _with_slopes(part: Part, angles: list[Any], phases: Mapping[Any, Any], name: Callable[[Any], Any]) -> Part:
    """Slopes of definitions over an angle that stand in the balances as symbols."""
    own = sp.Dummy()
    for symbol, expr in [*part.definitions.items()]:
        waves = _waves(expr, {*angles, *phases})
        if "'" in symbol.name or not waves:
            continue
        for q in _forward_first(angles, _phase(waves[0]).xreplace(phases)):
            slope = sp.diff(expr.xreplace(phases), q)
            for short, base in phases.items():
                slope = _over(slope, base, short)
            terms = {i: _without(e, slope, own) for i, e in part.terms.items()}
            if sp.count_ops(slope) >= _LONG and any(e.has(own) for e in terms.values()):
                new = name(symbol)
                terms = {i: e.xreplace({own: new}) for i, e in terms.items()}
                part = Part(_inserted(part.definitions, new, slope, behind=symbol), terms)
                break
    return part


def _forward_first(angles: Iterable[Any], phase: Any) -> list[Any]:
    """The angles of a phase, before those with which it falls those with which it rises."""
    found = [q for q in angles if phase.has(q)]
    return sorted(found, key=lambda q: bool(sp.diff(phase, q).could_extract_minus_sign()))


def _waves(expr: Any, angles: set[Any]) -> list[Any]:
    """The periodic functions and tables of an angle in an expression."""
    found = [f for f in sp.sympify(expr).atoms(sp.sin, sp.cos, TableAt) if _phase(f).free_symbols & angles]
    return sorted(found, key=sp.default_sort_key)


def _phase(wave: Any) -> Any:
    return wave.args[1] if isinstance(wave, TableAt) else wave.args[0]


def _times(phase: Any, base: Any) -> Any:
    """How often a phase is another one, where that is a rational number; else 0."""
    if phase == base:
        return sp.Integer(1)
    if phase.free_symbols != base.free_symbols:
        return sp.Integer(0)
    one, other = sp.expand(phase), sp.expand(base)
    ratio = one.as_ordered_terms()[0] / other.as_ordered_terms()[0]
    return ratio if ratio.is_Rational and sp.expand(one - ratio * other) == 0 else sp.Integer(0)


def _over(expr: Any, base: Any, symbol: Any) -> Any:
    """With the functions of multiples of a phase as those of its symbol."""
    new = {}
    for f in _waves(expr, base.free_symbols):
        if times := _times(_phase(f), base):
            args = list(f.args)
            args[isinstance(f, TableAt)] = times * symbol
            new[f] = f.func(*args)
    return expr.xreplace(new)


def _without(expr: Any, slope: Any, symbol: Any) -> Any:
    """With a symbol for the terms of a slope in sums, or for those of its opposite."""
    terms = {*sp.Add.make_args(slope)}

    def over(total: Any) -> Any:
        for sign in (1, -1):
            found = {sign * x for x in terms}
            if found < {*total.args}:
                return sp.Add(*(x for x in total.args if x not in found), sign * symbol)
        return total

    return expr.replace(lambda e: e.is_Add, over)


def _inserted(definitions: Mapping[Any, Any], symbol: Any, expr: Any, behind: Any = None) -> dict[Any, Any]:
    """Definitions with one more, behind one or before the first that reads it."""
    found: dict[Any, Any] = {}
    for s, e in definitions.items():
        if behind is None and symbol not in found and symbol in e.free_symbols:
            found[symbol] = expr
        found[s] = e
        if s == behind:
            found[symbol] = expr
    found.setdefault(symbol, expr)
    return found
