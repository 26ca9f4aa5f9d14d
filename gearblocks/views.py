"""What the template of the generated C prints: functions with their signatures, and tables as rows of numbers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from gearblocks.batchcode import Function
from gearblocks.coordinates import Combination
from gearblocks.generator import Generator
from gearblocks.rational import Exact, over

_VECTORS = (
    "par", "before", "mode", "tau", "y", "loop", "phi", "sense", "flange_tau", "direction", "loop_direction", "t", "u", "dy",
    "s", "out", "energy", "scale", "lo", "hi",
)  # fmt: skip
_INTEGERS = ("full", "i")
_SMALL = 64  # states of a train whose derivatives stay in registers


@dataclass(frozen=True, slots=True)
class FunctionView:
    """A function ready to print: signature, body, and the calls of all instances."""

    name: str
    signature: str
    function: Function
    calls: list[str]


@dataclass(frozen=True, slots=True)
class Sparse:
    """Rows of a sparse matrix as C arrays: start of each row, columns and values."""

    name: str
    start: list[int]
    index: list[int]
    value: list[str]


def function_view(function: Function) -> FunctionView:
    """Gives a function the vectors that its text names."""
    text = " ".join([*(x for _, x in function.prologue), *(f"{s.lhs} {s.rhs}" for s in function.body)])
    written = {s.lhs.split("[")[0] for s in function.body}
    if any(s.op in ("call", "below", "above") for s in function.body):
        text += " mode lo hi"
        written |= {"lo", "hi"}
    words = set(re.findall(r"[A-Za-z_]\w*", text))
    if any(s.full for s in function.body):
        words.add("full")
    used = [
        (f"{'' if name in written else 'const '}double *restrict {name}", name) for name in _VECTORS if name in words
    ]
    used += [(f"const int {name}", name) for name in _INTEGERS if name in words]
    args = [f"const {kind} {name}" for kind, name, _ in function.args]
    signature = ", ".join([*(kind for kind, _ in used), "const int e", *args])
    prefix = "".join(f"{name}, " for _, name in used)
    return FunctionView(function.name, signature, function, [prefix + call for call in function.calls])


def sparse(name: str, rows: Sequence[Mapping[int, Exact]]) -> Sparse:
    """Rows of exact numbers, sorted by column."""
    start, index, value = [0], [], []
    for row in rows:
        for column in sorted(row):
            index.append(column)
            value.append(repr(float(row[column])))
        start.append(len(index))
    return Sparse(name, start, index or [0], value or ["0.0"])


def view(g: Generator, angles_in_law: bool, coordinates: list[str]) -> dict[str, Any]:
    """Everything the template names."""
    lay, assembly = g.lay, g.assembly
    combinations = [c for _, c in assembly.definitions]
    functions = {what: [function_view(f) for f in functions] for what, functions in g.functions.items()}
    senses = [(function_view(s.function), s.call) for s in g.senses.values() if s.function is not None]
    return {
        "g": g,
        "lay": lay,
        "name": _c_string(assembly.train.name),
        "functions": functions,
        "all_functions": [f for group in functions.values() for f in group] + [f for f, _ in senses],
        "senses": [_sense_call(f, call) for f, call in senses],
        "law_senses": [_sense_call(f, call) for f, call in senses if int(f.name.split("_")[1]) in _law_senses(g)],
        "columns": list({c.name: c for f in _all(g) for c in f.tables}.values()),
        "coordinates": coordinates,
        "angles_in_law": angles_in_law,
        "signs": any(s.op == "call" and s.lhs.startswith("sign") for f in _all(g) for s in f.body),
        "small": lay.n_total <= _SMALL,
        "loops": sparse("loop", [c.coordinates for c in assembly.dependents]),
        "loop_offsets": sparse("loop_offset", [_offsets(g, c) for c in assembly.dependents]),
        "rows": sparse("row", assembly.rows),
        "row_offsets": sparse("row_offset", [_paths(g, offsets) for offsets in assembly.row_offsets]),
        "defined": [group for group, _ in assembly.definitions],
        "by_group": sparse("by_group", [c.groups for c in combinations]),
        "by_coordinate": sparse("by_coordinate", [c.coordinates for c in combinations]),
        "by_offset": sparse("by_offset", [_offsets(g, c) for c in combinations]),
        "phi_gains": [repr(float(over(1, s.phi0_gain))) for s in assembly.starts],
        "w_gains": [repr(float(over(1, s.w0_gain))) for s in assembly.starts],
        "flanges": _turned(FlangeRow, _flanges(g)),
        "ties": _turned(TieStep, _tie_order(g)),
        "n_flange_outputs": sum(code.n * len(code.batch.flanges) for code in g.codes),
        "first_flange_output": sum(code.n * len(code.law.shows) for code in g.codes),
        "inputs": list(lay.inputs),
        "numbers": lambda values: ", ".join(str(v) for v in values),
    }


def _all(g: Generator) -> list[Function]:
    """Every function of the program."""
    found = [f for functions in g.functions.values() for f in functions]
    return found + [s.function for s in g.senses.values() if s.function is not None]


def _sense_call(f: FunctionView, call: str) -> str:
    """The call that fills one sense: the vectors of the function, then the numbers of its instance."""
    vectors = f.calls[0][: len(f.calls[0]) - len(f.function.calls[0])]
    return f"{f.name}({vectors}{call})"


def _turned(kind: Any, rows: Sequence[Any]) -> dict[str, Any]:
    """Columns of rows by name, and their number."""
    columns = list(zip(*rows, strict=True)) or [()] * len(kind._fields)
    return {"count": len(rows), **dict(zip(kind._fields, columns, strict=True))}


def _law_senses(g: Generator) -> set[int]:
    """Numbers of the senses that laws read, with what they read in turn."""
    wanted = [slot.of for b in g.assembly.batches for slot in b.law.pool.slots.values() if slot.role == "sense"]
    return {g.senses[path].index for path in wanted}


def _c_string(text: str) -> str:
    plain = (c if 32 <= b < 127 and c not in '"\\?' else f"\\{b:03o}" for b in text.encode() for c in [chr(b)])
    return f'"{"".join(plain)}"'


def _offsets(g: Generator, c: Combination) -> dict[int, Exact]:
    return _paths(g, c.offsets)


def _paths(g: Generator, offsets: Mapping[str, Exact]) -> dict[int, Exact]:
    return {g.lay.path_of[path]: value for path, value in offsets.items()}


class FlangeRow(NamedTuple):
    """One flange of one component in the tables of the outputs."""

    group: int
    gain: str
    offset: int
    node: int


def _flanges(g: Generator) -> list[FlangeRow]:
    rows = []
    for code in g.codes:
        for flange in code.batch.flanges:
            for e in range(code.n):
                node = code.batch.nodes[flange][e]
                offset = g.assembly.held_offset.get(node)
                at = g.lay.path_of[offset] if offset else -1
                rows.append(FlangeRow(code.batch.groups[flange][e], repr(float(code.batch.gains[flange][e])), at, node))
    return rows


class TieStep(NamedTuple):
    """One step of the backward pass: the tie holds `child` (a node); torque_ratio = c_parent/c_child."""

    child: int
    parent: int
    child_flange: int
    parent_flange: int
    ratio: str


def _tie_order(g: Generator) -> list[TieStep]:
    """Ties from the leaves to the roots: each passes on what its node lacks."""
    edges: dict[int, list[tuple[int, Any, Exact, Exact]]] = {}
    roots = []
    for tie in g.assembly.groups.tree:
        if tie.parent == -1:
            roots.append((tie.child, tie))
        else:
            edges.setdefault(tie.child, []).append((tie.parent, tie, tie.c_child, tie.c_parent))
            edges.setdefault(tie.parent, []).append((tie.child, tie, tie.c_parent, tie.c_child))
    flange_of = _flange_numbers(g)
    order: list[TieStep] = []
    seen: set[int] = set()

    def walk(root: int) -> None:
        stack = [root]
        seen.add(root)
        while stack:
            node = stack.pop()
            for other, tie, c_node, c_other in edges.get(node, []):
                if other not in seen:
                    seen.add(other)
                    flanges = flange_of[tie.component]
                    order.append(
                        TieStep(other, node, flanges[other], flanges[node], repr(float(over(c_node, c_other))))
                    )
                    stack.append(other)

    for node, tie in roots:
        order.append(TieStep(node, -1, flange_of[tie.component][node], -1, "0.0"))
        walk(node)
    for node in sorted(edges):
        if node not in seen:
            walk(node)
    return list(reversed(order))


def _flange_numbers(g: Generator) -> dict[str, dict[int, int]]:
    """Number in flange_tau of the flange of each component at each node."""
    numbers: dict[str, dict[int, int]] = {}
    for code in g.codes:
        for flange in code.batch.flanges:
            for e in range(code.n):
                mine = numbers.setdefault(code.paths[e], {})
                mine.setdefault(code.batch.nodes[flange][e], code.places.tau[flange] + e)
    return numbers
