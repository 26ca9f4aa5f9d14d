"""What a train is: components with paths, and nodes that join their flanges. Frozen; found without sympy."""

from __future__ import annotations

import functools
import hashlib
import inspect
import math
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, get_args

from gearblocks.errors import ModelError, did_you_mean
from gearblocks.language.block import Block, Effect, Field, _Declared
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.train.nesting import localised
from gearblocks.train.translational import sliders_of, sliding_nodes

GROUND = -1
"""The node number of a flange that means the ground because nothing is connected to it."""


@dataclass(frozen=True, slots=True)
class Coordinate:
    """A relative coordinate for reading: an output, and the unknown of the relative form of the equations."""

    name: str
    expr: Expr
    unit: str


@dataclass(frozen=True, slots=True)
class Tree:
    """A train as composed: parts may be trains themselves. A link joins (part, flange) pairs."""

    name: str
    parts: tuple[tuple[str, Any], ...]
    links: tuple[tuple[tuple[str, str], ...], ...]
    exposed: tuple[tuple[str, tuple[str, str]], ...] = ()
    coordinates: tuple[Coordinate, ...] = ()


@dataclass(frozen=True, slots=True)
class Component:
    """One block with its full path and the node of each flange (GROUND where it means the ground)."""

    path: str
    block: Block
    nodes: tuple[int, ...]
    sliders: frozenset[str] = frozenset()  # flanges that slide
    slides: bool = False  # whether those slide that take both: units are then those of sliders


@dataclass(frozen=True, slots=True)
class Train:
    """All components of a train, flat, and how many nodes join them."""

    name: str
    components: tuple[Component, ...]
    n_nodes: int
    coordinates: tuple[Coordinate, ...] = ()


def flatten(tree: Tree, *, complete: bool = True) -> Train:
    """The train with full paths. All problems are gathered into one ModelError; complete=False accepts open ends."""
    blocks: list[tuple[str, Block]] = []
    flanges: dict[tuple[str, str], int] = {}
    parents: list[int] = []

    def find(i: int) -> int:
        while parents[i] != i:
            parents[i] = parents[parents[i]]
            i = parents[i]
        return i

    def enter(node: Tree, prefix: str) -> dict[str, int]:
        local: dict[tuple[str, str], int] = {}
        names = {name for name, _ in node.parts}
        for name, part in node.parts:
            path = prefix + name
            if prefix and isinstance(part, Block):
                part = localised(part, prefix, names)
            inner = _inside(name, part)
            if inner is not None:
                for flange, i in enter(inner, path + ".").items():
                    local[name, flange] = i
                continue
            blocks.append((path, part))
            for flange in type(part).flanges:
                local[name, flange] = flanges[path, flange] = len(parents)
                parents.append(len(parents))
        for link in node.links:
            first = find(local[link[0]])
            for end in link[1:]:
                parents[find(local[end])] = first
                joined.update((first, find(local[end])))
            joined.update(local[end] for end in link)
        return {name: local[end] for name, end in node.exposed}

    joined: set[int] = set()
    for name, i in enter(tree, "").items():
        flanges["", name] = i
    return _number(tree, blocks, flanges, joined, find, complete)


def _inside(name: str, part: Any) -> Tree | None:
    """The tree inside a nested train or a composite block, None for a plain block."""
    if isinstance(part, Tree):
        return part
    parts = part.parts()
    if parts is None:
        return None
    return Tree(name, tuple(parts.blocks.items()), tuple(parts.links), tuple(parts.flanges.items()))


def _number(
    tree: Tree, blocks: list[tuple[str, Block]], flanges: dict[Any, int], joined: set[int], find: Any, complete: bool
) -> Train:
    """Numbers the nodes in the order of the components and refuses open ends."""
    numbers, components, problems = dict[int, int](), [], []
    for path, block in blocks:
        nodes, who = [], f"{type(block).__name__} '{path}'"
        for flange, spec in type(block).flanges.items():
            i = flanges[path, flange]
            if i not in joined and spec.ground:
                nodes.append(GROUND)
                continue
            if i not in joined and not spec.spare:
                problems.append(f"flange '{flange}' of {who} is open: connect it (to an Inertia, a Fixed, ...)")
            nodes.append(numbers.setdefault(find(i), len(numbers)))
        if len({n for n in nodes if n != GROUND}) < sum(n != GROUND for n in nodes) and len(nodes) > 1:
            problems.append(f"{who} is connected to itself: two of its flanges share one node")
        components.append((path, block, tuple(nodes)))
    sliding, mixed = sliding_nodes(components, len(numbers))
    if (problems or mixed) and complete:
        raise ModelError(problems + mixed)
    if not components:
        raise ModelError(f"the drivetrain '{tree.name}' is empty: add blocks")
    flat = tuple(Component(*c, *(sliders_of(c[1], c[2], sliding) if sliding else ())) for c in components)
    return Train(tree.name, flat, len(numbers), tree.coordinates)


# -- structure --------------------------------------------------------------------------------------------------------


def structure_of(value: Any, *, exact: bool = False) -> Any:
    """What decides the law of a block: its class, which fields are present, choices, signals; no numbers.

    exact=True adds the values that enter ratios, and which numbers are zero (an inertia that is not there). Plain tuples
    and text, equal for equal structure.
    """
    parts: list[Any] = [f"{type(value).__module__}.{type(value).__qualname__}"]
    store = value.__dict__
    for name, field in type(value).fields.items():
        parts.append(_structure(store[name], field, exact))
    return tuple(parts)


def _structure(value: Any, field: Field, exact: bool) -> Any:
    if value is None:
        return None
    if isinstance(value, tuple):
        return tuple(_structure(v, field, exact) for v in value)
    if field.role == "exact":
        return repr(value) if exact else "exact"
    if isinstance(value, (float, int)) and field.role in ("param", "signal"):
        return "zero" if exact and value == 0 and field.ge == 0 else "number"
    if isinstance(value, _Declared):
        return structure_of(value, exact=exact)
    if isinstance(value, Parameter):
        zero = exact and value.value == 0 and field.ge == 0
        return ("parameter", value.name, value.unit, *(["zero"] if zero else []))
    if isinstance(value, Input):
        return ("input", value.name, value.start, value.unit)
    if isinstance(value, (Table, Table2)):
        return ("table", value.digest())
    if isinstance(value, Expr):
        leaves = sorted({repr(leaf.args[0]) for leaf in value.leaves() if leaf.op == "input"})
        return ("expression", str(value), *leaves)
    return repr(value)


def structural_text(train: Train) -> str:
    """Canonical text of the whole structure: equal text, equal program."""
    lines = [train.name, str(train.n_nodes)]
    memo: dict[Any, str] = {}
    for c in train.components:
        structure = structure_of(c.block, exact=True)
        if structure not in memo:
            memo[structure] = hashlib.sha256(repr(structure).encode()).hexdigest()[:16]
        lines.append(f"{c.path} {memo[structure]} {c.nodes}")
    lines += [f"{c.name} {c.expr} {c.unit}" for c in train.coordinates]
    return "\n".join(lines)


# -- values -----------------------------------------------------------------------------------------------------------


def numbers_of(owner: Any, prefix: str) -> Iterator[tuple[str, Any, Field]]:
    """(path, number or Parameter or expression, field) of every numeric field that is present, effects included."""
    store = owner.__dict__
    for name, field in type(owner).fields.items():
        value = store[name]
        if isinstance(value, _Declared):
            yield from numbers_of(value, f"{prefix}{name}.")
        elif value is None or field.role == "option":
            continue
        elif isinstance(value, tuple):
            for i, v in enumerate(value):
                yield f"{prefix}{name}[{i}]", v, field
        elif field.role != "effect" and not isinstance(value, str):
            yield prefix + name, value, field


def leaves_of(block: Any) -> Iterator[Parameter | Input]:
    """Every Parameter and Input that a block or its effects refer to."""
    for _, value, _ in numbers_of(block, ""):
        if isinstance(value, (Parameter, Input)):
            yield value
        elif isinstance(value, Expr):
            for leaf in value.leaves():
                if leaf.op in ("parameter", "input"):
                    yield leaf.args[0]


def value_problems(path: str, block: Block) -> Iterator[str]:
    """Numbers that are not finite or out of bounds, and what the block itself finds wrong."""
    kind = f"{type(block).__name__} '{path}'"
    found = [f"{kind}: {problem}" for problem in _field_problems(block, "")]
    yield from found
    if not found:
        yield from (f"{kind}: {p}" for p in block.problems())
        for part in block.__dict__.values():
            if isinstance(part, _Declared):
                yield from (f"{kind}: {p}" for p in part.problems())


def _field_problems(owner: _Declared, prefix: str) -> Iterator[str]:
    """What is wrong with the fields taken one by one, those of effects included."""
    for name, field in type(owner).fields.items():
        value = owner.__dict__[name]
        if field.role == "effect":
            if value is not None:
                problem = _effect_problem(owner, name, value)
                yield from [problem] if problem else _field_problems(value, f"{prefix}{name}.")
        elif field.role == "option":
            if isinstance(field.default, bool) and not isinstance(value, bool):
                yield f"{prefix}{name} = {value!r} must be True or False"
            elif isinstance(value, _Declared):
                yield from _field_problems(value, f"{prefix}{name}.")
        elif value is None:
            if field.default is not None and field.belongs_to is None:
                yield f"{prefix}{name} = None ({field.words}): a value must be given"
        elif field.many and not isinstance(value, tuple):
            yield f"{prefix}{name} = {value!r:.80} must be a row of numbers such as ({value!r:.40},)"
        elif field.many:
            yield from filter(None, (_problem(f"{prefix}{name}[{i}]", v, field) for i, v in enumerate(value)))
        elif not (isinstance(value, str) and value in (field.default, "angle")):  # the effect itself judges "angle"
            problem = _problem(prefix + name, value, field)
            if problem:
                yield problem


def _effect_problem(owner: _Declared, name: str, value: Any) -> str:
    """An effect that is no effect object, or not of a class that the field is annotated with."""
    if isinstance(value, Effect):
        kind: Any = type(owner)
        allowed = _annotated(kind, name)
        if not allowed or type(value) in allowed:
            return ""
        if not type(value).__module__.startswith("gearblocks.") and isinstance(value, allowed):
            return ""
        return f"{name} = {value!r:.80} must be {' or '.join(f'gb.{kind.__name__}(...)' for kind in allowed)}, or None"
    return f"{name} = {value!r:.80} must be an effect object such as gb.Backlash(...), or None"


@functools.cache
def _annotated(kind: type, name: str) -> tuple[type, ...]:
    """The effect classes that the annotation of a field names; empty where it names none."""
    for base in kind.__mro__:
        annotation = inspect.get_annotations(base).get(name)
        if annotation is not None:
            words = re.findall(r"\w+", annotation) if isinstance(annotation, str) else []
            known = vars(sys.modules[base.__module__])
            found = [known.get(word) for word in words] or [*get_args(annotation), annotation]
            return tuple(t for t in found if isinstance(t, type) and issubclass(t, Effect))
    return ()


def _problem(name: str, value: Any, field: Field) -> str:
    unit = "" if field.unit == "1" else f" {field.unit}"
    if isinstance(value, (Parameter, Input, Table, Expr)):
        problem = _signal_problem(name, value, field)
        if problem or isinstance(value, (Input, Table)) or (isinstance(value, Expr) and not _is_constant(value)):
            return problem
        number, shown = _constant(value), f" ({value!r})" if isinstance(value, Parameter) else f" ('{value}')"
    elif isinstance(value, Table2):
        return f"{name} = {value!r} is no signal by itself: call it with two quantities, such as table(gb.sense('motor.w'), u)"
    elif isinstance(value, bool) or not isinstance(value, (int, float, Fraction if field.role == "exact" else int)):
        return (
            f"{name} = {value!r:.80} is no number{', Parameter, Input, Table or expression' * (field.role == 'signal')}"
        )
    else:
        number, shown = _float(value), ""
    if not math.isfinite(number):
        return f"{name} = {number!r}{unit}{shown} must be a finite number"
    return bound_problem(name, number, unit + shown, (field.gt, field.ge, field.lt, field.le))


def _float(value: float | Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _is_constant(value: Expr) -> bool:
    return all(leaf.op == "parameter" for leaf in value.leaves())


def _constant(value: Parameter | Expr) -> float:
    """The number of a Parameter, or of an expression of Parameters; NaN where it has none."""
    if isinstance(value, Parameter):
        return value.value
    try:
        return evaluate(value, lambda leaf: float(leaf.args[0].value))
    except (ArithmeticError, ValueError, TypeError):
        return math.nan


def _signal_problem(name: str, value: Any, field: Field) -> str:
    if field.role == "exact":
        return f"{name} = {value!r:.80} enters a ratio: give a plain number, and another one with rig.set(...)"
    if isinstance(value, Expr) and value.op in ("<", "<=", ">", ">=", "And", "Or", "Not"):
        return f"{name} = '{value}' is a condition, not a value: give gb.piecewise((value, condition), (other, True))"
    if field.role == "signal":
        leaves = value.leaves() if isinstance(value, Expr) else ()
        local = next((x.args[0] for x in leaves if x.op == "local" and x.args[0] != field.over), None)
        by = {"twist": "the torque of a Shaft", "driver_angle": "the k of a NonCircularGear"}.get(
            str(local), "its block"
        )
        return "" if local is None else f"{name} = '{value}' contains gb.{local}, which only {by} knows"
    changing = not isinstance(value, (Expr, Parameter)) or (isinstance(value, Expr) and not _is_constant(value))
    return (
        f"{name} is a parameter: it takes a number, a gb.Parameter or an expression of Parameters" if changing else ""
    )


def bound_problem(name: str, x: float, unit: str, bounds: tuple[float | None, ...]) -> str:
    """What is wrong with x against (gt, ge, lt, le), or the empty text."""
    gt, ge, lt, le = bounds
    broken = [
        f"{sign} {limit:g}"
        for sign, limit, holds in (
            (">", gt, gt is None or x > gt), (">=", ge, ge is None or x >= ge),
            ("<", lt, lt is None or x < lt), ("<=", le, le is None or x <= le),
        ) if not holds
    ]  # fmt: skip
    return f"{name} = {x!r}{unit} must be {' and '.join(broken)}" if broken else ""


# -- paths ------------------------------------------------------------------------------------------------------------


def field_paths(owner: _Declared) -> Iterator[str]:
    """Paths of all fields inside a block, those of its effects and the entries of rows included."""
    for name in type(owner).fields:
        yield name
        value = owner.__dict__[name]
        if isinstance(value, _Declared):
            yield from (f"{name}.{rest}" for rest in field_paths(value))
        elif isinstance(value, tuple):
            yield from (f"{name}[{i}]" for i in range(len(value)))


def unique_path(path: str, known: set[str]) -> str:
    """The full path that a path, or a unique end of one, means."""
    if not isinstance(path, str):
        raise ModelError(f"path {path!r} must be text such as 'mesh.k'")
    if path in known:
        return path
    ends = sorted(p for p in known if p.endswith("." + path))
    if len(ends) == 1:
        return ends[0]
    if ends:
        raise ModelError(f"'{path}' is not unique: it could be {', '.join(ends)}")
    raise ModelError(f"'{path}' does not exist{did_you_mean(path, known)}")


def replaced(owner: Any, path: list[str], value: Any) -> Any:
    """A copy of a block or effect with another value at a path inside it."""
    name, *rest = path
    match = re.fullmatch(r"(\w+)\[(\d+)\]", name)
    if match:
        values = list(owner.__dict__[match[1]])
        values[int(match[2])] = value
        return owner.changed(**{match[1]: tuple(values)})
    return owner.changed(**{name: replaced(owner.__dict__[name], rest, value) if rest else value})
