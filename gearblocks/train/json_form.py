"""Trains as JSON text and back. Values are data: classes come from the catalogue, expressions are parsed, never run."""

from __future__ import annotations

import ast
import json
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

import gearblocks.blocks as catalogue
import gearblocks.blocks.effects as effects
import gearblocks.language.heat as heat
from gearblocks.errors import GearblocksError, ModelError, StorageError, did_you_mean
from gearblocks.files import unreadable, write_text
from gearblocks.geometry.ratio_law import RatioLaw
from gearblocks.language.block import Block, Declared
from gearblocks.language.expression import FUNCTIONS, Expr, number
from gearblocks.language.signals import Input, Parameter, Table
from gearblocks.language.tables import Table2
from gearblocks.train.graph import Coordinate, Tree

FORMAT = "gearblocks train 1"


def write(tree: Tree, path: Path) -> None:
    """Writes a train. Raises ModelError for blocks that are not of the catalogue, StorageError where it cannot write."""
    leaves: dict[str, Any] = {}
    data = {"format": FORMAT, **_tree(tree, leaves), "leaves": leaves}
    write_text(path, json.dumps(data, indent=1, ensure_ascii=False) + "\n")


def read(path: Path) -> Tree:
    """The train in a file. Raises StorageError or ModelError with the reason."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise unreadable(path, error) from error
    except (ValueError, RecursionError) as error:
        raise StorageError(f"{path} is no JSON text: {error}; name a file that rig.to_json wrote") from error
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise StorageError(f"{path} is no train of format '{FORMAT}'; name a file that rig.to_json wrote")
    try:
        leaves = {name: _leaf(item) for name, item in data["leaves"].items()}
        return _read_tree(data, leaves)
    except GearblocksError as error:
        raise type(error)(f"{path}: {error}") from error
    except (KeyError, TypeError, AttributeError, IndexError, ValueError, ArithmeticError, RecursionError) as error:
        raise StorageError(f"{path} is damaged: {error!r}") from error


# -- writing ----------------------------------------------------------------------------------------------------------


def _tree(tree: Tree, leaves: dict[str, Any]) -> dict[str, Any]:
    parts = {}
    for name, part in tree.parts:
        parts[name] = {"train": _tree(part, leaves)} if isinstance(part, Tree) else _owner(name, part, leaves)
    return {
        "name": tree.name,
        "parts": parts,
        "links": [[f"{p}.{f}" for p, f in link] for link in tree.links],
        "exposed": {name: f"{p}.{f}" for name, (p, f) in tree.exposed},
        "coordinates": {c.name: [_expr(c.expr, leaves), c.unit] for c in tree.coordinates},
    }


def _owner(path: str, owner: Declared, leaves: dict[str, Any]) -> dict[str, Any]:
    kind = type(owner)
    if _class(kind.__name__) is not kind:
        raise ModelError(f"'{path}': {kind.__name__} is no block of the catalogue; only those can be stored")
    fields = {
        name: _value(f"{path}.{name}", owner.__dict__[name], leaves)
        for name, field in kind.fields.items()
        if owner.__dict__[name] != field.default
    }
    return {"type": kind.__name__, **fields}


def _value(path: str, value: Any, leaves: dict[str, Any]) -> Any:
    if isinstance(value, tuple):
        return [_value(path, v, leaves) for v in value]
    if isinstance(value, Declared):
        return _owner(path, value, leaves)
    if isinstance(value, RatioLaw):
        return {
            "ratio_law": value.recipe[0],
            "values": [list(v) if isinstance(v, tuple) else v for v in value.recipe[1]],
        }
    if isinstance(value, (Parameter, Input, Table)):
        return {"expression": _expr(value._expr_(), leaves)}
    if isinstance(value, Expr):
        return {"expression": _expr(value, leaves)}
    if isinstance(value, Table2):
        leaves[value.digest()] = _grid(value)
        return {"table2": value.digest()}
    return {"fraction": [value.numerator, value.denominator]} if isinstance(value, Fraction) else value


def _expr(expr: Expr, leaves: dict[str, Any]) -> str:
    for leaf in expr.leaves():
        if leaf.op == "parameter":
            p = leaf.args[0]
            leaves[p.name] = {"parameter": p.name, "value": p.value, "unit": p.unit}
        elif leaf.op == "input":
            i = leaf.args[0]
            leaves[i.name] = {"input": i.name, "start": i.start, "unit": i.unit}
        elif leaf.op == "table":
            t = leaf.args[0]
            leaves[t.digest()] = {
                "x": list(t.x), "y": list(t.y), "kind": t.kind, "periodic": t.periodic, "ends": t.ends,
                "extrapolate": t.extrapolate,
            }  # fmt: skip
        elif leaf.op == "table2":
            leaves[leaf.args[0].digest()] = _grid(leaf.args[0])
    return str(expr)


def _grid(table: Table2) -> dict[str, Any]:
    return {**{name: np.asarray(getattr(table, name)).tolist() for name in "xyz"}, "kind": table.kind}


# -- reading ----------------------------------------------------------------------------------------------------------


def _leaf(item: Mapping[str, Any]) -> Parameter | Input | Table | Table2:
    if "parameter" in item:
        return Parameter(item["parameter"], item["value"], item["unit"])
    if "input" in item:
        return Input(item["input"], item["start"], item["unit"])
    if "z" in item:
        return Table2(item["x"], item["y"], item["z"], item["kind"])
    ends, outside = item.get("ends", "not-a-knot"), item.get("extrapolate", "hold")
    return Table(item["x"], item["y"], item["kind"], item["periodic"], ends, outside)


def _class(name: str) -> Any:
    """A block or effect of the catalogue by name, or None."""
    found = getattr(catalogue, name, None) or getattr(effects, name, None) or getattr(heat, name, None)
    return found if isinstance(found, type) and issubclass(found, Declared) else None


def _read_tree(data: Mapping[str, Any], leaves: Mapping[str, Any]) -> Tree:
    parts = []
    for name, item in data["parts"].items():
        part = _read_tree(item["train"], leaves) if "train" in item else _read_owner(name, item, leaves)
        if not isinstance(part, (Tree, Block)):
            raise ModelError(f"'{name}': {item['type']} is no block")
        parts.append((name, part))
    ends = {name: _flanges_of(part) for name, part in parts}

    def end(text: str) -> tuple[str, str]:
        name, _, flange = text.rpartition(".")
        if flange not in ends.get(name, ()):
            raise ModelError(f"there is no flange '{text}'{did_you_mean(flange, ends.get(name, ()))}")
        return name, flange

    links = tuple(tuple(end(text) for text in link) for link in data["links"])
    for link in links:
        if len(set(link)) < max(2, len(link)):
            raise ModelError(f"the connection {link!r} must join two or more flanges, each once")
    exposed = tuple((name, end(text)) for name, text in data["exposed"].items())
    coordinates = tuple(Coordinate(n, parse(text, leaves), unit) for n, (text, unit) in data["coordinates"].items())
    return Tree(data["name"], tuple(parts), links, exposed, coordinates)


def _flanges_of(part: Tree | Block) -> tuple[str, ...]:
    return tuple(n for n, _ in part.exposed) if isinstance(part, Tree) else tuple(type(part).flanges)


def _read_owner(path: str, item: Mapping[str, Any], leaves: Mapping[str, Any]) -> Declared:
    kind = _class(item["type"])
    if kind is None:
        raise ModelError(f"'{path}': there is no block or effect '{item['type']}' in the catalogue")
    fields = {name: _read_value(f"{path}.{name}", v, leaves) for name, v in item.items() if name != "type"}
    try:
        made = kind(**fields)
    except GearblocksError as error:
        raise ModelError(f"'{path}': {error}") from error
    assert isinstance(made, Declared)
    return made


def _read_value(path: str, value: Any, leaves: Mapping[str, Any]) -> Any:
    if isinstance(value, list):
        return tuple(_read_value(path, v, leaves) for v in value)
    if isinstance(value, dict):
        if "fraction" in value:
            return Fraction(*value["fraction"])
        if "table2" in value:
            return _known(leaves, "table2", value["table2"])
        if "ratio_law" in value:
            return _read_ratio_law(value["ratio_law"], value["values"])
        if "expression" not in value:
            return _read_owner(path, value, leaves)
        expr = parse(value["expression"], leaves)
        if expr.op in ("parameter", "input"):
            return expr.args[0]
        if expr.op == "table" and expr.args[1].op == "time":
            return expr.args[0]
        return expr
    return value


def _read_ratio_law(how: str, values: list[Any]) -> RatioLaw:
    if how not in ("segments", "ellipse", "from_function", "from_table"):
        raise ModelError(f"there is no ratio law '{how}'")
    if how == "from_function":
        values = [parse(values[0], {}), *values[1:]]
    made = getattr(RatioLaw, how)(*values)
    assert isinstance(made, RatioLaw)
    return made


# -- expressions ------------------------------------------------------------------------------------------------------

Leaves: TypeAlias = Mapping[str, Parameter | Input | Table | Table2]


def _known(leaves: Leaves, kind: str, key: str) -> Parameter | Input | Table | Table2:
    """The leaf of that name; GearblocksError where there is none of the kind."""
    if type(leaves.get(key)).__name__.lower() != kind:
        raise GearblocksError(f"the expression names the {kind} '{key}', which is not there")
    return leaves[key]


def parse(text: str, leaves: Leaves) -> Expr:
    """The expression that `str` printed. `leaves` holds Parameters, Inputs (by name) and Tables (by digest).

    Raises GearblocksError for anything that is not an expression of the known functions: the text is read, never run.
    """
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise GearblocksError(f"'{text:.200}' is not an expression: {error}") from None
    return _parse(tree, leaves)


def _parse(node: ast.expr, leaves: Leaves) -> Expr:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return number(node.value)
    if isinstance(node, ast.Name) and node.id == "time":
        return Expr("time")
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
        inner = _parse(node.operand, leaves)
        return number(-inner.args[0]) if inner.op == "number" else -inner
    if isinstance(node, ast.BinOp):
        a, b = _parse(node.left, leaves), _parse(node.right, leaves)
        for kind, build in _BINARY_NODES.items():
            if isinstance(node.op, kind):
                return build(a, b)
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for relation, name in ((ast.Lt, "<"), (ast.LtE, "<="), (ast.Gt, ">"), (ast.GtE, ">=")):
            if isinstance(node.ops[0], relation):
                return Expr(name, _parse(node.left, leaves), _parse(node.comparators[0], leaves))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        return _parse_call(node.func.id, node.args, leaves)
    raise GearblocksError(f"'{ast.unparse(node)}' cannot stand in an expression")


_BINARY_NODES: dict[type[ast.operator], Callable[[Expr, Expr], Expr]] = {
    ast.Add: lambda a, b: Expr("+", a, b),
    ast.Sub: lambda a, b: Expr("+", a, -b),
    ast.Mult: lambda a, b: Expr("*", a, b),
    ast.Div: lambda a, b: Expr("*", a, Expr("**", b, number(-1.0))),
    ast.Pow: lambda a, b: Expr("**", a, b),
}


_MANY = range(1, 1000)
_COUNTS: dict[str, Sequence[int]] = {
    "atan2": (2,), "Heaviside": (1, 2), "Min": _MANY, "Max": _MANY, "And": _MANY, "Or": _MANY, "Piecewise": _MANY
}  # fmt: skip


def _parse_call(name: str, args: list[ast.expr], leaves: Leaves) -> Expr:
    if (
        name in ("parameter", "input", "sense", "local", "table", "table2")
        and args
        and isinstance(args[0], ast.Constant)
    ):
        key = str(args[0].value)
        if name in ("sense", "local"):
            return Expr(name, key)
        leaf = _known(leaves, name, key)
        if len(args) != {"table": 2, "table2": 3}.get(name, 1):
            raise GearblocksError(f"'{name}' of '{key}' takes another number of values than {len(args)}")
        return Expr(name, leaf, *(_parse(a, leaves) for a in args[1:]))
    if name in FUNCTIONS:
        if not args or len(args) not in _COUNTS.get(name, (1,)) or (name == "Piecewise" and len(args) % 2):
            raise GearblocksError(f"'{name}' takes another number of values than {len(args)}")
        return Expr(name, *(_parse(a, leaves) for a in args))
    raise GearblocksError(f"'{name}' is not a function of expressions; there are {', '.join(FUNCTIONS)}")
