"""The symbols of a whole train: each thing has one, with a name for print, a meaning, and the part it belongs to.

Knows nothing of equations.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, final

import sympy as sp

from gearblocks.equations import names, nomenclature
from gearblocks.language.signals import Input, Parameter
from gearblocks.language.units import unit_along
from gearblocks.laws.symbols import LawTable
from gearblocks.train.graph import Component
from gearblocks.train.translational import words_along

_SWITCHED = {
    "friction": ("T", "T", "torque of the constraint", "N m"),
    "slip": ("w_rel", "Δω", "slip, or rate of the gap", "rad/s"),
    "direction": ("direction", "σ", "direction of sliding: 1, -1, or 0 while it does not slide", "1"),
    "stuck": ("stuck", "s", "1 while stuck or closed, else 0", "1"),
    "constraint_force": ("held", "λ", "torque while stuck or closed, else 0", "N m"),
}
"""Spelling, letter, words and unit of the symbols of switched constraints, by role."""
_OF_SLIDERS = {"T": "F", "Δω": "Δv"}


def flat(path: str) -> str:
    """A path as part of a symbol's spelling."""
    return path.replace(".", "_").replace("[", "").replace("]", "")


@final
class Lexicon:
    """names, entries, owners: of each symbol what it is called, what it means, and to which part it belongs. parameters: paths
    of numbers, Parameters and Inputs. inputs: symbols of Inputs."""

    def __init__(self, paths: Iterable[str]) -> None:
        self._feet = names.owners(paths)
        self.names: dict[Any, names.Name] = {}
        self.entries: dict[Any, nomenclature.Entry] = {}
        self.owners: dict[Any, str] = {}
        self.parameters: dict[Any, str] = {}
        self.inputs: set[Any] = set()
        self._claimed: dict[str, Any] = {}
        self._defined: dict[Any, str] = {}

    def symbol(self, c: Component, role: str, of: Any) -> Any:
        """The symbol of one thing of a part by its role (see SymbolRole); None for a role that has none of its own."""
        if role in ("own", "exact"):
            return self._number(c, of)
        if role == "state":
            return self._state(c, of)
        if role == "named":
            return self._claim(_spelled(c, of), (role, c.path, of))
        if role in ("table", "table2"):
            return self._table(c, of)
        if role == "law_table":
            return self._law_table(c, of)
        return self._switched(c, role, of) if role in _SWITCHED else None

    def shared(self, leaf: Parameter | Input, text: str) -> Any:
        """The symbol of a Parameter or an Input."""
        symbol = self._claim(text, ("input" if isinstance(leaf, Input) else "shared", leaf.name))
        self.parameters[symbol] = leaf.name
        self.names[symbol], self.entries[symbol] = names.of_shared(leaf.name), nomenclature.of_shared(leaf)
        if isinstance(leaf, Input):
            self.inputs.add(symbol)
        return symbol

    def coordinate(self, q: Any, v: Any, owner: str, *, slides: bool) -> None:
        """The angle and the speed of a shaft, or position and speed of a slider."""
        letter, words, unit = ("s", "position", "m") if slides else ("φ", "angle", "rad")
        self._claimed |= {q.name: q, v.name: v}
        self.names[q] = names.Name(letter, "", self._feet.get(owner, names.whole(owner)))
        self.names[v] = self.names[q].rate()
        self.entries[q] = nomenclature.Entry(f"{words} of {names.whole(owner)}", "", unit)

    def body(self, c: Component) -> Any:
        """The angle of a body, or its position, that others give."""
        turning, sliding = ("phi", "φ", "angle", "rad"), ("s", "s", "position", "m")
        spelling, letter, words, unit = sliding if c.sliders else turning
        symbol = self._claim(f"{spelling}_{flat(c.path)}", ("body", c.path))
        self.names[symbol] = names.Name(letter, "", self._foot(c))
        self.entries[symbol] = nomenclature.Entry(f"{words} of {names.whole(c.path)}", "", unit)
        return symbol

    def define(self, c: Component, symbol: Any, name: str, words: str, unit: str) -> None:
        """Keeps what a symbol is that a law defines; a mean stiffness beside one that varies is k_0."""
        called = names.of_defined(name, self._foot(c), c.slides)
        self._defined[symbol] = name.rstrip("'")
        self._note(
            symbol, called, nomenclature.Entry(words_along(words, c.slides), "", unit_along(unit, c.slides), c.path), c
        )
        if name == "k_t":
            mean = self._claim(f"k_{flat(c.path)}", ("own", c.path, "k"))
            if mean in self.names:
                self.names[mean] = names.of_field("k", self._foot(c), varies=True)

    def offset(self, c: Component, name: str) -> Any:
        """The symbol of a ground angle."""
        symbol = self._number(c, name)
        self.names[symbol] = names.Name("φ", "0", self._foot(c))
        return symbol

    def deflection(self, c: Component, unit: str) -> Any:
        """The symbol of a deflection that its law does not name."""
        symbol = sp.Symbol(f"x_{flat(c.path)}", real=True)
        self._note(symbol, names.Name("x", "", self._foot(c)), nomenclature.Entry("deflection", "", unit), c)
        return symbol

    def phase(self, path: str, number: int, cycles: bool) -> Any:
        """The symbol of a phase that several functions of a part read."""
        symbol = self._claim(f"psi{number or ''}_{flat(path)}", ("phase", path, f"psi{number}"))
        self.names[symbol], self.owners[symbol] = names.Name("ψ", str(number or ""), self._feet[path]), path
        self.entries[symbol] = nomenclature.Entry("phase", "", "1" if cycles else "rad", path)
        return symbol

    def slope(self, defined: Any) -> Any:
        """The symbol of the slope over an angle of what a law defines."""
        path, of, entry = self.owners[defined], self.names[defined], self.entries[defined]
        symbol = self._claim(f"{of.letter}_slope_{flat(path)}", ("slope", path, defined.name))
        self.names[symbol], self.owners[symbol] = replace(of, number=f"{of.number}φ"), path
        words = f"{entry.words}: slope over the angle"
        self.entries[symbol] = nomenclature.Entry(words, "", entry.unit, path)
        return symbol

    def distinct(self) -> dict[Any, names.Name]:
        """The names; where two things would share one, tables as such, else each by its path in the block: numbers and tables
        before what laws define, their last word before the whole."""
        path = {s: self._inside(s) for s in self.names}
        given = [s for s in path if s in self.parameters or (s in self.entries and self.entries[s].table is not None)]
        last = {s: path[s].split(".")[-1].partition("[")[0] for s in given}
        whole = {s: re.sub(r"[.\[]", "_", inside).replace("]", "") for s, inside in path.items() if inside}
        tables = {s for s in given if s not in self.parameters}
        return names.distinct(names.with_tables(self.names, tables), last, {s: whole[s] for s in given}, whole)

    def _inside(self, symbol: Any) -> str:
        """The path of what a symbol stands for inside its part of the train; empty for angles and deflections."""
        if symbol in self._defined or symbol not in self.entries:
            return self._defined.get(symbol, "")
        path = self.entries[symbol].path
        return path.removeprefix(f"{self.owners[symbol]}.") if symbol in self.owners else path

    # -- one for each role --------------------------------------------------------------------------------------------

    def _number(self, c: Component, path: str) -> Any:
        symbol = self._claim(_spelled(c, path), ("own", c.path, path))
        self.parameters[symbol] = f"{c.path}.{path}"
        own = nomenclature.declared_symbol(c, path)
        called = names.of_field(path, self._foot(c), own, slides=c.slides)
        self._note(symbol, called, nomenclature.of_number(c, path), c)
        return symbol

    def _state(self, c: Component, path: str) -> Any:
        symbol = self._claim(_spelled(c, path), ("state", c.path, path))
        own = nomenclature.declared_symbol(c, path)
        called = names.of_state(path, self._foot(c), own, slides=c.slides)
        self._note(symbol, called, nomenclature.of_state(c, path), c)
        return symbol

    def _table(self, c: Component, table: Any) -> Any:
        """Named by the field that it stands in; a law may make one itself and say nothing of it."""
        paths = [p for p, own in nomenclature.tables_of(c.block) if _is_same(own, table)]
        if not paths:
            symbol = self._claim(f"table_{flat(c.path)}", ("table", c.path, table.digest()))
            entry = nomenclature.of_unnamed_table(c, table)
            before = [s for s, name in self.names.items() if name.letter == "table" and self.owners.get(s) == c.path]
            number = 1 + (before.index(symbol) if symbol in before else len(before))
            self._note(symbol, names.Name("table", str(number), self._foot(c)), entry, c)
            return symbol
        symbol = self._claim(f"{flat(paths[0].split('.')[-1])}_table_{flat(c.path)}", ("table", c.path, paths[0]))
        called = names.of_table(paths[0], self._foot(c), nomenclature.declared_symbol(c, paths[0]))
        self._note(symbol, called, nomenclature.of_table(c, paths, table), c)
        return symbol

    def _law_table(self, c: Component, made: LawTable) -> Any:
        symbol = self._claim(_spelled(c, made.name), ("law_table", c.path, made.name))
        self._note(symbol, names.of_defined(made.name, self._foot(c)), nomenclature.of_law_table(c, made), c)
        return symbol

    def _switched(self, c: Component, role: str, of: str) -> Any:
        spelling, letter, words, unit = _SWITCHED[role]
        if c.slides:
            letter, spelling = _OF_SLIDERS.get(letter, letter), _OF_SLIDERS.get(spelling, spelling)
        symbol = self._claim(f"{spelling}_{flat(c.path)}{'_' if of else ''}{flat(of)}", (role, c.path, of))
        owner = f"{self._foot(c)} {of}".rstrip()
        words = words_along(words, c.slides)
        entry = nomenclature.Entry(words, "", unit_along(unit, c.slides), c.path)
        self._note(symbol, names.Name(letter, "", owner), entry, c)
        return symbol

    def _foot(self, c: Component) -> str:
        """What stands at the foot of the symbols of a part."""
        return self._feet[c.path]

    def _note(self, symbol: Any, name: names.Name, entry: nomenclature.Entry, c: Component) -> None:
        self.names[symbol], self.entries[symbol], self.owners[symbol] = name, entry, c.path

    def _claim(self, text: str, meaning: Any) -> Any:
        """The symbol of one thing: its short name, with the path inside the block or a dash where that is taken."""
        longer = f"{flat(meaning[2])}_{flat(meaning[1])}" if len(meaning) == 3 else text
        while self._claimed.setdefault(text, meaning) != meaning:
            text = longer if text != longer and not text.startswith(longer) else text + "_"
        return sp.Symbol(text, real=True)


def _spelled(c: Component, path: str) -> str:
    return f"{flat(path.split('.')[-1])}_{flat(c.path)}"


def _is_same(own: Any, table: Any) -> bool:
    """Whether a table is that of a field, or what is left of it without its jumps."""
    smooth = own.continuous if getattr(own, "jumps", ()) else own
    return any(type(x) is type(table) and x.digest() == table.digest() for x in (own, smooth))
