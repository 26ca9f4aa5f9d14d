"""Mathematics as it is set: the nodes of a tree, which text, LaTeX and MathML show each in its way.

Knows nothing of sympy, nor of characters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias, final

from gearblocks.equations.names import Name


@final
@dataclass(frozen=True, slots=True)
class Sym:
    """A symbol."""

    name: Name


@final
@dataclass(frozen=True, slots=True)
class Num:
    """A number, in digits."""

    digits: str


@final
@dataclass(frozen=True, slots=True)
class Words:
    """Words between symbols."""

    text: str


@final
@dataclass(frozen=True, slots=True)
class Op:
    """A sign between terms, or a relation: + - = < > <= >= and or. A line may break before it."""

    sign: str


@final
@dataclass(frozen=True, slots=True)
class Row:
    """Terms and the signs between them."""

    items: tuple[Any, ...]


@final
@dataclass(frozen=True, slots=True)
class Times:
    """A product."""

    factors: tuple[Any, ...]


@final
@dataclass(frozen=True, slots=True)
class Fraction:
    """A fraction."""

    top: Any
    bottom: Any


@final
@dataclass(frozen=True, slots=True)
class Power:
    """A power."""

    base: Any
    exponent: Any


@final
@dataclass(frozen=True, slots=True)
class Root:
    """A square root."""

    inner: Any


@final
@dataclass(frozen=True, slots=True)
class Fence:
    """What stands between ( ), | | or floor signs."""

    left: str
    right: str
    inner: Any


@final
@dataclass(frozen=True, slots=True)
class Call:
    """A function of arguments; function: a Sym, or words such as cos; primes: how often it is differentiated."""

    function: Any
    arguments: tuple[Any, ...]
    primes: int = 0


@final
@dataclass(frozen=True, slots=True)
class Cases:
    """(value, condition) pairs; the condition None: otherwise."""

    rows: tuple[tuple[Any, Any], ...]


@final
@dataclass(frozen=True, slots=True)
class Sum:
    """A sum of alike terms over an index."""

    index: str
    first: int
    last: int
    inner: Any


@final
@dataclass(frozen=True, slots=True)
class Matrix:
    """Rows of entries between brackets."""

    rows: tuple[tuple[Any, ...], ...]


Node: TypeAlias = "Sym | Num | Words | Op | Row | Times | Fraction | Power | Root | Fence | Call | Cases | Sum | Matrix"
