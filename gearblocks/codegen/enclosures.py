"""Enclosures of event functions: what the location of those that are not affine in the states asks of a model.

    g(t, x) over a piece of a step, from enclosures of its arguments x: time, inputs, states, angles, speeds

The arguments move as smoothly as the solution does; what is sharp stands in the expressions, which are printed in interval
arithmetic. Knows nothing of how crossings are located.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.function import Function, Names
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.operands import Local, Operand, Role, Statement
from gearblocks.codegen.parts import Call, Enclosures
from gearblocks.codegen.symbol_names import by_name
from gearblocks.laws.enclosure_printer import EnclosureError, enclosure_texts
from gearblocks.laws.symbols import TIMED

_NUMBERS = {"own", "exact", "shared", "mobility", "gain", "mode", "direction", "stuck", "hoisted", "table", "table2"}
"""Roles of symbols that stand still along a step."""


def lay_out_enclosures(g: Generator) -> Enclosures | None:
    """The enclosures of all event functions that have one (None: there are none); what they read is laid out by then."""
    lay, n_groups = g.lay, g.assembly.n_groups
    first = {"inputs": 1, "states": 1 + len(lay.inputs)}
    first["loops"] = first["states"] + lay.n
    first["angles"] = first["loops"] + len(g.assembly.dependents)
    first["speeds"] = first["angles"] + n_groups
    first["end"] = first["speeds"] + n_groups
    found = Enclosures(first)
    known: set[str] = set()
    wanted = _signals(g)
    for path, signal in g.feedback.items():
        code = g.codes[signal.batch]
        enclosing = _enclosed(g, code, [signal.expr], known, found) if path in wanted else None
        if enclosing is not None:
            body = enclosing.body([Operand(Role.FEEDBACK_ENCLOSURES, signal.index)])
            function = _function(code, f"feedback_enclosure_{signal.index}", enclosing.names, body)
            g.keep("feedback_enclosures", function)
            found.feedback.append(Call(function, signal.instance))
            known.add(path)
    for code in g.codes:
        _event_functions(g, code, known, found)
    if _has_linear_forces(g):
        _forces(g, known, found)
    if found.switches or found.forces:
        return found
    g.functions.pop("feedback_enclosures", None)  # made for forces of which another has none
    return None


def _has_linear_forces(g: Generator) -> bool:
    """Whether constraint forces follow from the torques by constant numbers."""
    constraints = g.constraints
    changing = constraints.dynamic or constraints.lossy or constraints.prescribed
    return bool(constraints.members) and not changing and not g.assembly.n_massless


def _forces(g: Generator, known: set[str], found: Enclosures) -> None:
    """Torques on groups and force bounds, if all of them are enclosed: one function of each batch."""
    functions = []
    for code in g.codes:
        torques = {flange: x for flange, x in code.torques.items() if code.batch.groups[flange][0] != GROUND_GROUP}
        bounds = [_bounds(code, name) for name in code.law.constraints]
        known_bounds = [x for pair in bounds for x in pair if x is not None]
        enclosing = _enclosed(g, code, [*torques.values(), *known_bounds], known, found)
        if enclosing is None:
            return
        names, texts = enclosing.names, iter(enclosing.texts)
        body = enclosing.shared
        for flange in torques:
            target, text = Operand(Role.GROUP_TORQUES, code.symbols.group_key(flange, names)), next(texts)
            gain = code.symbols.gain(flange, names)
            text = f"gb_enclosed_scale({text}, {gain})" if gain else text
            body.append(Statement(target, "=", f"gb_enclosed_add({target}, {text})"))
        for name, pair in zip(code.law.constraints, bounds, strict=True):
            first = g.constraints.first[code.number, name]
            for k, expr in enumerate(pair):
                target = Operand(Role.BOUNDS_OVER_PIECE, f"2 * ({first} + e) + {k}")
                nothing = f"gb_enclosed_number({'-' if k == 0 else ''}HUGE_VAL)"
                body.append(Statement(target, "=", nothing if expr is None else next(texts)))
        functions.append(_function(code, "force_enclosures", names, body))
    for function in functions:
        g.keep("force_enclosures", function)
    found.forces = True


def _bounds(code: BatchCode, name: str) -> tuple[Any, Any]:
    """Lower and upper bound of the force of a constraint; None: there is none."""
    values = code.constraint_values[name]
    return values.get("lower"), values.get("upper")


def _signals(g: Generator) -> set[str]:
    """Feedback signals that event functions read, with what they read in turn."""
    wanted: set[str] = set()
    todo = [(code, x) for code in g.codes for expr in _read(g, code) for x in expr.free_symbols]
    while todo:
        code, symbol = todo.pop()
        meaning = code.law.pool.roles[symbol]
        if meaning.role == "sense" and meaning.of not in wanted:
            wanted.add(meaning.of)
            signal = g.feedback[meaning.of]
            todo += [(g.codes[signal.batch], x) for x in signal.expr.free_symbols]
        elif meaning.role in ("hoisted", "force"):
            todo += [(code, x) for x in _inner(code, symbol).free_symbols]
    return wanted


def _read(g: Generator, code: BatchCode) -> list[Any]:
    """The expressions of a batch that enclosures read."""
    exprs = [code.surfaces[i] for i in _general(code)]
    if _has_linear_forces(g):
        exprs += code.torques.values()
        exprs += [v[k] for v in code.constraint_values.values() for k in ("lower", "upper") if k in v]
    return exprs


def _general(code: BatchCode) -> list[int]:
    return [i for i, sort in enumerate(code.events.sorts) if sort == "general"]


def _event_functions(g: Generator, code: BatchCode, known: set[str], found: Enclosures) -> None:
    """Those of a batch that have an enclosure: one function."""
    enclosed = [i for i in _general(code) if _enclosed(g, code, [code.surfaces[i]], known, found) is not None]
    enclosing = _enclosed(g, code, [code.surfaces[i] for i in enclosed], known, found)
    if enclosed and enclosing is not None:
        firsts = [code.offsets.switches[i] for i in enclosed]
        body = enclosing.body([Operand(Role.ENCLOSURES, first, instance=True) for first in firsts])
        g.keep("event_enclosures", _function(code, "event_enclosures", enclosing.names, body))
        found.switches += [(first, code.n) for first in firsts]


def _function(code: BatchCode, name: str, names: Names, body: list[Statement]) -> Function:
    arguments, constants = list(names.arguments.values()), list(names.constants.items())
    return Function(f"{name}_{code.batch.name}", arguments, constants, body, names.reads, code.n, code.words)


def _inner(code: BatchCode, symbol: Any) -> Any:
    """What a hoisted term or a force stands for."""
    if code.law.pool.roles[symbol].role == "force":
        return code.forces[symbol]
    return next(term.expr for term in code.hoister.terms if term.symbol == symbol)


def _spelled_out(code: BatchCode, expr: Any) -> Any:
    """An expression with time terms and forces written out."""
    roles = code.law.pool.roles
    while True:
        inner = {
            x: _inner(code, x)
            for x in expr.free_symbols
            if roles[x].role == "force" or (roles[x].role == "hoisted" and roles[x].of[0] == TIMED)
        }
        if not inner:
            return expr
        expr = expr.xreplace(inner)


@dataclass(slots=True)
class _Enclosing:
    """C of the enclosures of expressions, the names in it, and what they share, which goes first."""

    names: Names
    shared: list[Statement]
    texts: list[str]

    def body(self, targets: list[Operand]) -> list[Statement]:
        return [*self.shared, *(Statement(at, "=", x) for at, x in zip(targets, self.texts, strict=True))]


def _enclosed(
    g: Generator, code: BatchCode, exprs: list[Any], known: set[str], found: Enclosures
) -> _Enclosing | None:  # fmt: skip
    """Enclosures of expressions of a batch; None where one of them has none."""
    exprs = [_spelled_out(code, x) for x in exprs]
    names, moving = Names(Role.STATES), {}
    used: set[int] = set()
    try:
        for symbol in by_name(*exprs):
            meaning = code.law.pool.roles[symbol]
            if meaning.role in _NUMBERS:
                names.text[symbol] = code.symbols.name(symbol, names)
            elif meaning.role == "sense" and meaning.of not in known:
                return None
            else:
                reading = _Reading(g, code, found.first, names, used)
                moving[symbol] = reading.argument(meaning.role, meaning.of)
        shared, texts = enclosure_texts(exprs, moving, names.text)
    except EnclosureError:
        return None
    found.used |= used
    return _Enclosing(names, [Statement(Local(x.name), "share", x.text, kind=x.kind) for x in shared], texts)


@dataclass(slots=True)
class _Reading:
    """C of the arguments that one function reads; used: their offsets."""

    g: Generator
    code: BatchCode
    first: dict[str, int]
    names: Names
    used: set[int]

    def argument(self, role: str, of: Any) -> str | tuple[str, str]:
        """C of a moving symbol: an enclosure, or one and its factor."""
        if role == "sense":
            return self.names.place(Operand(Role.FEEDBACK_ENCLOSURES, self.g.feedback[of].index))
        if role == "time":
            return self._at("0", [0])
        if role == "input":
            at = self.first["inputs"] + list(self.g.lay.inputs).index(of.name)
            return self._at(str(at), [at])
        if role == "state":
            at = self.first["states"] + self.g.lay.state0[self.code.number, of]
            self.used |= {at + e for e in range(self.code.n)}
            return self.names.place(Operand(Role.ARGUMENTS, at, instance=True))
        if role == "coordinate":
            return self._coordinate(of)
        if role in ("phi", "w"):
            return self._flange(role, of)
        raise EnclosureError(role)

    def _at(self, offset: str, used: list[int]) -> str:
        self.used |= set(used)
        return self.names.place(Operand(Role.ARGUMENTS, offset))

    def _column(self, first: int, key: str) -> str:
        """The argument at an index of the instance."""
        values = self.names.arguments[key].column.values
        return self._at(f"{first} + {key}", [first + int(i) for i in values])

    def _coordinate(self, j: int) -> str:
        batch = self.code.batch
        if batch.used and not batch.used[j]:
            return self._from_angles(j)
        key = self.code.symbols.argument(self.names, "int", f"q{j}", lambda: batch.sources[j])
        return self._column(self.first["loops" if batch.dependent[j] else "states"], key)

    def _from_angles(self, j: int) -> str:
        """A coordinate that is no state."""
        total = ""
        for flange, values in self.code.symbols.form(j).items():
            key = self.code.symbols.argument(self.names, "double", f"c{j}_{flange}", partial(list, values))
            at = self._flange("phi", flange)
            angle = at if isinstance(at, str) else f"gb_enclosed_scale({', '.join(at)})"
            term = f"gb_enclosed_scale({angle}, {key})"
            total = f"gb_enclosed_add({total}, {term})" if total else term
        return total

    def _flange(self, role: str, flange: str) -> str | tuple[str, str]:
        symbols, plain = self.code.symbols, self.g.assembly.plain
        if self.code.batch.groups[flange][0] == GROUND_GROUP:
            held = symbols.held_angle(flange, self.names) if role == "phi" else "0.0"
            return f"gb_enclosed_number({held})"
        if role == "phi":
            text = self._column(self.first["angles"], symbols.group_key(flange, self.names))
        else:
            text = self._column(self.first["states" if plain else "speeds"], symbols.speed_key(flange, self.names))
        gain = symbols.gain(flange, self.names)
        return (text, gain) if gain else text
