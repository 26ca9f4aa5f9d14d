"""The outputs that a block may show, read off the source of its `physics`: name, unit and words of every `Shows` in it.

Which of them a block shows depends on its fields, so no single block could tell them all. Functions that yield are followed;
of a condition on an argument that is a constant where it is called, the side that holds. Without a source, none is found.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Iterator, Mapping
from types import FunctionType
from typing import Any, NamedTuple

from gearblocks.language.annotations import effect_classes
from gearblocks.language.contributions import Shows


class WrittenOutput(NamedTuple):
    """One output as it stands in the source."""

    name: str
    unit: str
    words: str


def written_outputs(kind: Any) -> tuple[WrittenOutput, ...]:
    """Every output that blocks of a class may show, by its own name, in the order of the source.

    Where several share a name, their words stand beside each other. Those that effects bring come last.
    """
    found: dict[str, WrittenOutput] = {}
    brought = [
        x for name in kind.fields for effect in effect_classes(kind, name) for x in getattr(effect, "brings", ())
    ]
    of_effects = (WrittenOutput(x.name, x.unit, x.words) for x in dict.fromkeys(brought))
    for output in (*_Source(kind).outputs(kind.physics, {}), *of_effects):
        before = found.setdefault(output.name, output)
        if output.words not in before.words:
            found[output.name] = before._replace(words=f"{before.words} / {output.words}".removeprefix(" / "))
    return tuple(found.values())


class _Source:
    """The functions of a class that have been read."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        self.read: set[Any] = set()

    def outputs(self, function: FunctionType, known: Mapping[str, Any]) -> Iterator[WrittenOutput]:
        """Outputs in a function and in those that it calls; known: arguments that are constants."""
        mark = (function.__code__, tuple(known.items()))
        if mark in self.read:
            return
        self.read.add(mark)
        try:
            (tree,) = ast.parse(textwrap.dedent(inspect.getsource(function))).body
        except (OSError, TypeError, SyntaxError, ValueError):  # made where no source is kept
            return
        assert isinstance(tree, ast.FunctionDef | ast.AsyncFunctionDef)
        names = [a.arg for a in tree.args.args]
        defaults = zip(reversed(names), reversed([_constant(x, {}) for x in tree.args.defaults]), strict=False)
        env = {name: value for name, value in defaults if value is not _UNKNOWN} | dict(known)
        for statement in tree.body:
            yield from self._walk(statement, function, env)

    def _walk(self, node: ast.AST, function: FunctionType, env: dict[str, Any]) -> Iterator[WrittenOutput]:
        if isinstance(node, ast.FunctionDef | ast.Lambda):
            return
        if isinstance(node, ast.If) and (test := _constant(node.test, env)) is not _UNKNOWN:
            for statement in node.body if test else node.orelse:
                yield from self._walk(statement, function, env)
            return
        if isinstance(node, ast.For) and (rounds := _rounds(node, env)):
            for known in rounds:
                for statement in node.body:
                    yield from self._walk(statement, function, {**env, **known})
            return
        if isinstance(node, ast.Call):
            yield from self._called(node, function, env)
        for child in ast.iter_child_nodes(node):
            yield from self._walk(child, function, env)

    def _called(self, node: ast.Call, function: FunctionType, env: dict[str, Any]) -> Iterator[WrittenOutput]:
        called = self._value(node.func, function)
        if called is Shows:
            given = dict(zip(("name", "expr", "unit", "words"), node.args, strict=False))
            given |= {k.arg: k.value for k in node.keywords if k.arg}
            texts = [_constant(given.get(part, ast.Constant("1" if part == "unit" else "")), env) for part in
                     ("name", "unit", "words")]  # fmt: skip
            if isinstance(texts[0], str) and texts[0]:
                yield WrittenOutput(*(x if isinstance(x, str) else "" for x in texts))
        elif isinstance(called, FunctionType) and inspect.isgeneratorfunction(called):
            names = inspect.getfullargspec(called).args
            given = dict(zip(names, node.args, strict=False)) | {k.arg: k.value for k in node.keywords if k.arg}
            known = {name: x for name, part in given.items() if (x := _constant(part, env)) is not _UNKNOWN}
            yield from self.outputs(called, known)

    def _value(self, node: ast.expr, function: FunctionType) -> Any:
        """What a name in a function stands for: something of its module, or a method of the block."""
        if isinstance(node, ast.Name):
            return function.__globals__.get(node.id)
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            owner = self.kind if node.value.id == "self" else function.__globals__.get(node.value.id)
            return getattr(owner, node.attr, None)
        return None


def _rounds(node: ast.For, env: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The names of a loop in each of its rounds, some of them unknown; none where it runs over what only a block knows."""
    if isinstance(node.target, ast.Name):
        values = _constant(node.iter, env)
        return [{node.target.id: x} for x in values] if isinstance(values, tuple) else []
    if not isinstance(node.target, ast.Tuple) or not isinstance(node.iter, ast.Tuple | ast.List):
        return []
    rounds = []
    for row in node.iter.elts:
        pairs = zip(node.target.elts, row.elts, strict=False) if isinstance(row, ast.Tuple | ast.List) else ()
        rounds.append({name.id: _constant(part, env) for name, part in pairs if isinstance(name, ast.Name)})
    return rounds


_UNKNOWN: Any = object()


def _constant(node: ast.expr, env: Mapping[str, Any]) -> Any:
    """The value of a constant, a known name, a tuple of such or a text with such in it; else _UNKNOWN."""
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Name):
        return env.get(node.id, _UNKNOWN)
    if isinstance(node, ast.Tuple | ast.List):
        values = tuple(_constant(x, env) for x in node.elts)
        return _UNKNOWN if _UNKNOWN in values else values
    if isinstance(node, ast.JoinedStr):
        values = tuple(_constant(x.value if isinstance(x, ast.FormattedValue) else x, env) for x in node.values)
        return _UNKNOWN if _UNKNOWN in values else "".join(map(str, values))
    return _UNKNOWN
