"""One generated function of a batch: constants, statements, and a signature that follows from the roles in them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

from gearblocks.codegen.operands import NONE, Local, Operand, Role, Roles, Statement
from gearblocks.laws.printer import c_text
from gearblocks.laws.rational import Exact

UNROLLED = 8
"""Batches of at most this many instances are called one by one, with numbers in place of table columns."""
OUTPUTS = frozenset({"outputs", "unwrapped_outputs"})
SELDOM = OUTPUTS | {"scales", "mode_limits", "torques", "inertia_torques", "starts"}
"""What no step of a solver runs through: looped over from two instances on, which is less to compile."""


@dataclass(frozen=True)
class Column:
    """One number per instance of a batch: a constant, an arithmetic progression or a table."""

    name: str
    values: tuple[float | int, ...]

    @property
    def is_table(self) -> bool:
        """Whether it needs an array in C."""
        return self._progression is None

    @cached_property
    def _progression(self) -> tuple[Any, Any] | None:
        v: tuple[Any, ...] = self.values
        start = v[0]
        if v.count(start) == len(v) and start == start:  # no NaN
            return start, 0
        step = v[1] - start
        whole = set(map(type, v)) == {int} and step != 0
        return (start, step) if whole and v == (*range(start, start + len(v) * step, step),) else None

    def at(self, i: int) -> str:
        """C for the entry of instance i."""
        return repr(self.values[i])

    def text(self) -> str:
        """C for the entry of instance `e`."""
        found = self._progression
        if found is None:
            return f"{self.name}[e]"
        start, step = found
        if step == 0:
            return repr(start)
        return "e" if (start, step) == (0, 1) else f"{start} + {step} * e"


def column(name: str, values: Sequence[float | Exact]) -> Column:
    """A column with plain numbers."""
    return Column(name, tuple(v if isinstance(v, int) else float(v) for v in values))


class Argument(NamedTuple):
    """A number of the instance that a function is given: C type, name, value by instance."""

    kind: str
    name: str
    column: Column


_PLACES = {role: place for place, role in enumerate(Role)}
"""The order of signatures."""


@dataclass(slots=True)
class Names:
    """C of symbols and of common subexpressions, the arguments and constants that it needs, and the roles that it reads.

    vector: what coordinates and speeds are read from: STATES, UNWRAPPED_ANGLES (with whole angles), DIRECTION,
    GROUP_SPEEDS; or TIME_TERMS, where those of a lane are written.
    """

    vector: Role
    text: dict[Any, str] = field(default_factory=dict)
    arguments: dict[str, Argument] = field(default_factory=dict)
    constants: dict[str, str] = field(default_factory=dict)
    read: set[Role] = field(default_factory=set)
    n_common: int = 0

    def print(self, expr: Any) -> str:
        """C of an expression."""
        return c_text(expr, self.text)

    def common(self, expr: Any) -> Statement:
        """The definition of a subexpression, which is printed by its name from here on."""
        text, name = self.print(expr), f"common_{self.n_common}"
        self.n_common += 1
        self.text[expr] = name
        return Statement(Local(name), "define", text)

    def place(self, operand: Operand | Local) -> str:
        """C of a number of a vector, which is then read."""
        self.read |= operand.read
        return str(operand)

    def define(self, name: str, operand: Operand) -> str:
        """A constant of the function for a number of a vector."""
        self.constants[name] = self.place(operand)
        return name

    def take(self, argument: Argument) -> str:
        """A number of the instance."""
        self.arguments[argument.name] = argument
        return argument.name

    @property
    def states(self) -> Role:
        """The vector with the states."""
        return Role.STATES if self.vector is Role.UNWRAPPED_ANGLES else self.vector

    @property
    def per_instance(self) -> bool:
        """Whether they differ from one instance to the next."""
        return Role.INSTANCE in self.read

    @property
    def reads(self) -> Roles:
        """The roles read so far."""
        return frozenset(self.read)


@dataclass(slots=True)
class Function:
    """One function of a batch, called once per instance.

    constants: (name, C) of what it defines first; read: roles in its constants and expressions; count: instances;
    words: the components, for a comment; each: of outputs, what every one of them reads; unrolled: so many instances at most
    are called one by one; is_apart: where it is called in a loop it stays a function, as it is read one by one.
    """

    name: str
    arguments: list[Argument]
    constants: list[tuple[str, str]]
    body: list[Statement]
    read: Roles
    count: int
    words: str = ""
    each: tuple[tuple[Operand, Roles], ...] = ()
    unrolled: int = UNROLLED
    is_apart: bool = False

    @property
    def looped(self) -> bool:
        """Whether the calls stand in a loop."""
        return self.count > self.unrolled

    @property
    def tables(self) -> list[Argument]:
        """Arguments whose columns need an array."""
        return [x for x in self.arguments if self.looped and x.column.is_table]

    def take(self, arguments: Iterable[Argument]) -> None:
        """Adds arguments that it does not have yet."""
        known = {name for _, name, _ in self.arguments}
        self.arguments += [x for x in arguments if x.name not in known]

    # -- signature and calls ------------------------------------------------------------------------------------------

    @property
    def written(self) -> Roles:
        """The vectors that it changes."""
        return NONE.union(*(s.written for s in self.body))

    @property
    def roles(self) -> list[Role]:
        """All that it reads and writes but the instance, in the order of signatures."""
        found = self.read | self.written | NONE.union(*(s.read for s in self.body))
        return sorted(found - {Role.INSTANCE}, key=_PLACES.__getitem__)

    @property
    def signature(self) -> str:
        """Its parameters in C."""
        return self.signature_over("double")

    def signature_over(self, real: str) -> str:
        """Its parameters in C with vectors of this type; numbers of the instance are doubles."""
        written = self.written
        vectors = [role.declaration(written=role in written, real=real) for role in self.roles]
        numbers = [f"const {kind} {name}" for kind, name, _ in self.arguments]
        return ", ".join([*vectors, Role.INSTANCE.declaration(written=False), *numbers])

    @property
    def calls(self) -> list[str]:
        """Calls of all instances, or the single call inside a loop."""
        if not self.looped:
            return [self.call(e) for e in range(self.count)]
        return [self._call(["e", *(c.text() for _, _, c in self.arguments)])]

    def call(self, e: int) -> str:
        """The call of instance e."""
        return self._call([str(e), *(c.at(e) for _, _, c in self.arguments)])

    def _call(self, numbers: Sequence[str]) -> str:
        return f"{self.name}({', '.join([*(role.value for role in self.roles), *numbers])})"


def identifier(text: str) -> str:
    """A C identifier from a path."""
    return re.sub(r"\W+", "_", text).strip("_")


def texts_of(values: Sequence[Exact] | Sequence[float]) -> list[str]:
    """C of numbers, none of them -0.0; equal ones share theirs, as long trains have many."""
    texts = {x: repr(float(x)) for x in set(values)}
    return [texts[x] for x in values]
