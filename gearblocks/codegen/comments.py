"""Comments of generated C: names of trains and components, and hoisted terms in the symbols of their law.

Names may be any text; what stands in a comment is printable ASCII that cannot end it. Knows nothing of the code itself:
a text without comments is the same program.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import sympy as sp

from gearblocks.laws.printer import plain_text

_NAMED = 3  # components that a comment names
_LONGEST = 100  # characters of an expression

PARTS = {
    "lookup_tables": "lookup tables of one and two variables",
    "helpers": "limits of switches, rows of sparse matrices, numbers of the instances",
    "laws": "the laws, one function per batch of equal components",
    "static_tables": "coordinates, start values, dependent groups, mass matrix",
    "sizes": "numbers of everything",
    "kinematics": "loop closure, angles, speeds and accelerations of groups, mass matrix",
    "start": "parameter terms and the start state",
    "rates": "time terms and the right-hand side",
    "switched_constraints": "rows, constraint forces and impulses of switched constraints",
    "events": "event functions, limits of modes, time events",
    "outputs": "reactions, outputs, energies",
    "jacobian": "Jacobian, right side and kinematic states of implicit methods",
    "model": "what the solver calls",
}
"""The parts of the text in order, by template."""


def in_comment(text: str) -> str:
    """The text in printable ASCII without anything that ends a comment, opens one or is a trigraph."""
    plain = text.encode("unicode_escape").decode("ascii")
    return plain.replace("*", "\\x2a").replace("?", "\\x3f")


def of_components(kind: str, paths: Sequence[str]) -> str:
    """Kind and names of the components of a batch: all of them, or the first and how many more."""
    named = ", ".join(in_comment(path) for path in paths[:_NAMED])
    rest = f" and {len(paths) - _NAMED} more" if len(paths) > _NAMED else ""
    return f"{in_comment(kind)}: {named}{rest}"


def of_expression(expr: Any, inner: Mapping[Any, Any], names: Mapping[Any, str]) -> str:
    """A hoisted term in the symbols of its law; inner: the terms that stand in it; names: of tables in C."""
    while inner.keys() & expr.free_symbols:
        expr = expr.xreplace(dict(inner))
    tables = {x: sp.Symbol(names[x]) for x in names.keys() & expr.free_symbols}
    text = in_comment(plain_text(expr.xreplace(tables)).replace("**", "^").replace("*", " "))
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]} ..."


def tool() -> str:
    """This package and its version, where it is installed."""
    try:
        return f"gearblocks {version('gearblocks')}"
    except PackageNotFoundError:
        return "gearblocks"


_FIRST, _LAST = "\x01", "\x02"  # around each comment; names are printable
_COMMENT = re.compile(f"{_FIRST}[^{_LAST}]*{_LAST}")


def before(words: str) -> str:
    """A comment on a line of its own, for `with_comments` and `without_comments`."""
    return f"{_FIRST}/* {words} */\n{_LAST}"


def behind(words: str) -> str:
    """A comment behind a statement."""
    return f"{_FIRST} /* {words} */{_LAST}" if words else ""


def with_comments(text: str) -> str:
    """The text to read."""
    return text.replace(_FIRST, "").replace(_LAST, "")


def without_comments(text: str) -> str:
    """The bare program, which names do not change."""
    return _COMMENT.sub("", text)


def key_of(text: str) -> str:
    """Hash of the bare program, piece by piece: the text of a long train is long."""
    key, end = hashlib.sha256(), 0
    for comment in _COMMENT.finditer(text):
        key.update(text[end : comment.start()].encode())
        end = comment.end()
    key.update(text[end:].encode())
    return key.hexdigest()
