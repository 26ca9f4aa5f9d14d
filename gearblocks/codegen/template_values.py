"""What the template of the generated C prints: functions with their signatures, and tables as rows of numbers."""

from __future__ import annotations

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate
from typing import Any

from gearblocks.assembly.elimination import Combination
from gearblocks.codegen.comments import PARTS
from gearblocks.codegen.function import Function, texts_of
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.operands import Operand, Role
from gearblocks.codegen.output_names import flanges_of
from gearblocks.codegen.parts import GroupRows
from gearblocks.codegen.reactions import flange_numbers, reaction_tables
from gearblocks.codegen.switched_constraints import constraint_columns, delassus_columns
from gearblocks.laws.rational import Exact, over

_FEW = 16  # loops that are written out
_SCALAR: dict[str, Any] = {
    "real": "double", "number": lambda text: text, "where_torques_are_read": "", "lanes_only": False,
}  # fmt: skip
"""What lanes have otherwise (lanes.py): type of numbers, C of what may be a plain number, what asks for torques."""
_SMALL = 64  # states of a train whose derivatives stay in registers


@dataclass(frozen=True, slots=True)
class Sparse:
    """Rows of a sparse matrix as C arrays: start of each row, columns and values."""

    name: str
    start: Sequence[int]
    index: Sequence[int]
    value: Sequence[str]


@dataclass(frozen=True, slots=True)
class OutputCall:
    """What computes outputs of one batch, [first, end); of_state: whether these need neither rates nor torques of flanges;
    angles: the first one that reads angles (-1: none)."""

    function: Function
    first: int
    end: int
    of_state: bool
    angles: int


@dataclass(frozen=True, slots=True)
class WrappedAngle:
    """A wrapped angle: its state, that of its speed (-1: none) and its group, the turns taken off at a time, the switches
    whose mode falls by `steps` then.

    starts: (group, a, b) of every group with a start value, which turns a/b times as far.
    """

    state: int
    speed: int
    group: int
    turns: int
    switches: list[int]
    steps: list[int]
    starts: list[tuple[int, float, float]]


def sparse(name: str, rows: Sequence[Mapping[int, Exact]] | Sequence[Mapping[int, float]]) -> Sparse:
    """Rows of exact numbers, sorted by column."""
    start, index = array("q", accumulate(map(len, rows), initial=0)), array("q")
    value: list[Any] = []
    for row in rows:
        by_column: Mapping[int, Any] = dict(sorted(row.items())) if len(row) > 1 else row
        index.extend(by_column)
        value += by_column.values()
    return Sparse(name, start, index or [0], texts_of(value) or ["0.0"])


def view(g: Generator, angles_in_law: bool, coordinates: list[str]) -> dict[str, Any]:
    """Everything the template names."""
    lay, assembly = g.lay, g.assembly
    combinations = [c if isinstance(c, Combination) else Combination() for _, c in assembly.definitions]
    implicit = g.linear.functions if g.linear is not None else {}
    functions = g.functions | implicit
    signals = [(s.index, s.call) for s in g.feedback.values() if s.call is not None]
    in_law = _signals_in_law(g)
    return {
        "g": g,
        "lay": lay,
        "name": _c_string(assembly.train.name),
        "functions": functions,
        "all_functions": [f for group in functions.values() for f in group] + [call.function for _, call in signals],
        **_linear(g, angles_in_law),
        "feedback": [str(call) for _, call in signals],
        "law_feedback": [str(call) for index, call in signals if index in in_law],
        **_late(g),
        "columns": list({x.column.name: x for f in _all(g) for x in f.tables}.values()),
        "long_table": g.long_tables.take,
        "coordinates": coordinates,
        "angles_in_law": angles_in_law,
        "signs": any(s.op == "sign" for f in _all(g) for s in f.body),
        "small": lay.n_total <= _SMALL,
        "plain": assembly.plain,
        "output_time_terms": bool(g.shared_time_terms(outputs_only=True) or g.functions.get("output_time_terms")),
        "dependent": g.dependent,
        **_constraints(g),
        "dependent_members": [f.group for f in assembly.dependent_groups],
        "mobile": _mobile(g),
        "massless": g.massless,
        "shifts": sparse("shift", g.massless.shifts if g.massless else []),
        "angle_steps": _angle_steps(g),
        "start_steps": _start_steps(g),
        "dependent_offsets": sparse(
            "dependent_offset", [_offsets(g, f.row or Combination()) for f in assembly.dependent_groups]
        ),
        **_loops(g),
        "rows": sparse("row", assembly.rows),
        "row_offsets": sparse("row_offset", [_paths(g, offsets) for offsets in assembly.row_offsets]),
        "defined": [group for group, _ in assembly.definitions],
        "by_group": sparse("by_group", [c.groups for c in combinations]),
        "by_coordinate": sparse("by_coordinate", [c.coordinates for c in combinations]),
        "by_offset": sparse("by_offset", [_offsets(g, c) for c in combinations]),
        "phi_gains": [repr(float(over(1, s.phi0_gain))) for s in assembly.starts],
        "w_gains": [repr(float(over(1, s.w0_gain))) for s in assembly.starts],
        "flanges": _flanges(g),
        "wrapped": _wrapped(g),
        "angle_speeds": [_speed_state(g, group) for group in assembly.angles],
        "turned": sparse("turned", _wrap_counts(g)),
        "reactions": reaction_tables(g, flange_numbers(g)),
        "output_calls": [_output_call(f) for f in g.functions.get("outputs", [])],
        "first_flange_output": sum(code.n * len(code.law.shows) for code in g.codes),
        "inputs": list(lay.inputs),
        "parts": PARTS,
        "uses": lambda what, name: any(role.value == name for f in functions.get(what, []) for role in f.roles),
        "numbers": lambda values: ", ".join(map(str, values)),
        **_SCALAR,
    }


_OF_MOTION = {
    Role.ACCELERATIONS, Role.FLANGE_TORQUES, Role.CONSTRAINT_FORCES, Role.FEEDBACK_SIGNALS, Role.RATES,
}  # fmt: skip
"""What an output reads that needs more than the state."""
_ANGLES = {Role.ANGLES, Role.UNWRAPPED_ANGLES}


def _output_call(f: Function) -> OutputCall:
    offsets = [int(s.target.offset) for s in f.body if isinstance(s.target, Operand)]
    angles = [int(target.offset) for target, reads in f.each if not _ANGLES.isdisjoint(reads)]
    return OutputCall(f, min(offsets), max(offsets) + f.count, _OF_MOTION.isdisjoint(f.roles), min(angles, default=-1))


def _loops(g: Generator) -> dict[str, Any]:
    """Coordinates that close loops."""
    dependents = g.assembly.dependents
    return {
        "loops_read_angles": any(c.groups for c in dependents),
        "loop_groups": sparse("loop_group", [c.groups for c in dependents]),
        "loops": sparse("loop", [c.coordinates for c in dependents]),
        "loop_texts": _loop_texts(dependents),
        "loop_offsets": sparse("loop_offset", [_offsets(g, c) for c in dependents]),
    }


def contents(g: Generator) -> list[str]:
    """The parts of the text that this program has, in order."""
    absent = {
        "lookup_tables": not g.tables, "laws": not (g.functions or g.feedback),
        "switched_constraints": not g.constraints.members, "jacobian": g.linear is None,
    }  # fmt: skip
    return [words for part, words in PARTS.items() if not absent.get(part)]


def _constraints(g: Generator) -> dict[str, Any]:
    """Tables of switched constraints."""
    constraints = g.constraints
    return {
        "constraints": constraints.members,
        "constraint_tables": constraints,
        "constraint_columns": list(constraint_columns(constraints).values()),
        "delassus_columns": delassus_columns(constraints),
        "constraint_groups": sparse("constraint_group", [member.row for member in constraints.members]),
    }


def _wrap_counts(g: Generator) -> list[dict[int, Exact]]:
    """Turns of every group over the wrap counts among the quadratures."""
    return [{2 * c: r for c, r in g.wrapping.forms.get(i, {}).items()} for i in range(g.assembly.n_groups)]


def _wrapped(g: Generator) -> list[WrappedAngle]:
    """Angles from which whole turns are taken."""
    found = []
    for c, item in enumerate(g.wrapping.wrapped):
        rows = [(group, Fraction(form[c])) for group, form in g.wrapping.forms.items() if form.get(c)]
        rows = [(group, r) for group, r in rows if group < len(g.assembly.starts)]
        switches = [g.codes[b].offsets.switches[i] + e for b, i, e, _ in item.steps]
        starts = [(group, *_parts(r)) for group, r in rows]
        group = g.assembly.angles[item.number]
        found.append(WrappedAngle(g.lay.angle0 + item.number, _speed_state(g, group), group, item.turns, switches,
                                 [step for *_, step in item.steps], starts))  # fmt: skip
    return found


def _speed_state(g: Generator, group: int) -> int:
    """Where the speed of a group lies among the states; -1: it follows from others."""
    return g.lay.v0 + group if group < g.assembly.n_speeds else -1


def _parts(r: Fraction) -> tuple[float, float]:
    """A ratio as two whole numbers that doubles hold, else as a rounded number over 1."""
    small = max(abs(r.numerator), r.denominator) < 2**53
    return (float(r.numerator), float(r.denominator)) if small else (float(r), 1.0)


def _mobile(g: Generator) -> dict[str, list[int]]:
    """The rows over speeds of the groups whose mobility is needed; entry -1: a speed of its own."""
    tables: dict[str, list[int]] = {"start": [0], "index": [], "entry": []}
    order = {f.group: i for i, f in enumerate(g.assembly.dependent_groups)}
    for group in g.mobile:
        row = {group: -1} if group not in order else g.dependent.rows.get(order[group], {}) if g.dependent else {}
        tables["index"] += row.keys()
        tables["entry"] += row.values()
        tables["start"].append(len(tables["index"]))
    return tables


def _loop_texts(loops: Sequence[Combination]) -> list[str]:
    """Few loops over coordinates alone, written out: rows of a table would not be unrolled."""
    if len(loops) > _FEW or any(c.groups or c.offsets for c in loops):
        return []
    rows = [sorted(c.coordinates.items()) for c in loops]
    return [" + ".join(f"{float(c)!r} * y[{i}]" for i, c in row) or "0.0" for row in rows]


def _prescribed_angle_calls(g: Generator) -> dict[int, str]:
    """The call that computes the angle of each group with prescribed motion."""
    calls: dict[int, str] = {}
    for i, f in enumerate(g.assembly.dependent_groups):
        call = g.dependent.calls.get(i) if g.dependent is not None else None
        if f.prescribed is not None and call is not None:
            calls[f.group] = (
                f"phi[{f.group}] = 0.0, {call}" if f.prescribed.rides else str(call)
            )  # it reads its own angle
    return calls


def _angle_steps(g: Generator) -> list[tuple[int, int, str]]:
    """How the angles are computed: (first definition, last, "") by rows, or a call."""
    calls = _prescribed_angle_calls(g)
    steps: list[tuple[int, int, str]] = []
    for i, (group, row) in enumerate(g.assembly.definitions):
        if not isinstance(row, Combination):
            steps.append((i, i + 1, calls[group]))
        elif steps and not steps[-1][2]:
            steps[-1] = (steps[-1][0], i + 1, "")
        else:
            steps.append((i, i + 1, ""))
    return steps


def _start_steps(g: Generator) -> list[tuple[int, int, str]]:
    """How the start angles of dependent groups are computed: (first, last, "") by rows, or a call."""
    calls = _prescribed_angle_calls(g)
    steps: list[tuple[int, int, str]] = []
    for i, f in enumerate(g.assembly.dependent_groups):
        if f.row is None:
            if f.group in calls:
                steps.append((i, i + 1, calls[f.group]))
        elif steps and not steps[-1][2] and steps[-1][1] == i:
            steps[-1] = (steps[-1][0], i + 1, "")
        else:
            steps.append((i, i + 1, ""))
    return steps


def _all(g: Generator) -> list[Function]:
    """Every function of the program."""
    found = [f for functions in g.functions.values() for f in functions]
    if g.linear is not None:
        found += [f for functions in g.linear.functions.values() for f in functions]
        found += [call.function for s in g.linear.feedback for call in (s.slope, s.change)]
    return found + [s.call.function for s in g.feedback.values() if s.call is not None]


def _linear(g: Generator, angles_in_law: bool) -> dict[str, Any]:
    """What the template of the implicit part names."""
    linear = g.linear
    if linear is None:
        return {"linear": None}
    tilted = angles_in_law and g.assembly.has_prescribed_angles
    moves = angles_in_law or any(Role.GROUP_SPEEDS in f.read for f in linear.functions.get("kinematic_rates", []))
    slopes, changes = [s.slope for s in linear.feedback], [s.change for s in linear.feedback if not linear.computed]
    by_states = linear.group_rows.by_states(linear.first_speed) if linear.group_rows else []
    c, varying = g.constraints, linear.computed is not None
    return {
        "linear": linear,
        "constraint_changes": bool(c.members) and (c.dynamic or c.prescribed) and (varying or any(by_states)),
        "forces_heat": any(code.law.heat and code.constraint_loss is not None for code in g.codes),
        "by_states": sparse("by_states", by_states),
        "speeds_read": moves,
        "linear_functions": [call.function for call in [*slopes, *changes]],
        "slopes": list(map(str, slopes)),
        "changes": list(map(str, changes)),
        "spread": sparse("spread", linear.spread),
        "terms": _terms(linear.terms),
        "kinematic_rate_rows": sparse("kinematic_rate", linear.computed.kinematic_rates if linear.computed else []),
        "with_inertia": _rows_of(linear.computed.with_inertia if linear.computed else []),
        "group_changes": _rows_of(linear.computed.accelerations if linear.computed else []),
        "group_tables": [sparse(name, rows) for name, rows in _group_tables(linear.group_rows, moves, tilted).items()],
    }


def _terms(rows: Sequence[Sequence[tuple[int, int, int]]]) -> dict[str, list[int]]:
    """Rows of the table that spreads entries where numbers are computed."""
    terms = [term for row in rows for term in row]
    start = [0, *accumulate(len(row) for row in rows)]
    return {"start": start} | {name: [term[i] for term in terms] for i, name in enumerate(("place", "one", "two"))}


def _rows_of(rows: Sequence[Mapping[int, int]]) -> dict[str, list[int]]:
    """Rows of offsets of numbers, by unknown."""
    items = [item for row in rows for item in row.items()]
    start = [0, *accumulate(len(row) for row in rows)]
    return {"start": start, "index": [x for x, _ in items], "number": [number for _, number in items]}


def _group_tables(f: GroupRows | None, moves: bool, tilted: bool) -> dict[str, list[dict[int, Exact]]]:
    """The tables of dependent groups; moves: kinematic states read speeds; tilted: laws read angles, and prescribed
    motions move some."""
    if f is None:
        return {}
    tables = ({"speeds": f.speeds} if moves else {}) | {"with_inertia": f.with_inertia, "torque_change": f.torques}
    if tilted:
        tables |= {"tilt": f.tilts, "state_tilt": f.state_tilts}
    return {**tables, "torque_rate_change": f.torque_rates} if f.by_rate else tables


def _turned(kind: Any, rows: Sequence[Any]) -> dict[str, Any]:
    """Columns of rows by name, and their number."""
    columns = list(zip(*rows, strict=True)) or [()] * len(kind._fields)
    return {"count": len(rows), **dict(zip(kind._fields, columns, strict=True))}


def _signals_in_law(g: Generator) -> set[int]:
    """Numbers of the feedback signals that laws read, with what they read in turn."""
    wanted = [
        meaning.of for b in g.assembly.batches for meaning in b.law.pool.roles.values() if meaning.role == "sense"
    ]
    return {g.feedback[path].index for path in wanted if path not in g.behind_motion}


def _late(g: Generator) -> dict[str, Any]:
    """Calls of the signals behind the motion that rates read, with what they read in turn; whether these are reactions."""
    behind: set[str] = set()
    for path in reversed(g.feedback):  # each reads only earlier ones
        if path in g.behind_motion:
            behind.add(path)
            signal = g.feedback[path]
            roles = g.codes[signal.batch].law.pool.roles
            behind |= {roles[x].of for x in signal.expr.free_symbols if roles[x].role == "sense"}
    late = [x for x in g.feedback.values() if x.call is not None and x.path in behind and g.functions.get("late_rates")]
    reads = [g.codes[x.batch].law.pool.roles[symbol].role for x in late for symbol in x.expr.free_symbols]
    return {"late_feedback": [str(x.call) for x in late], "late_reactions": "tau" in reads}


def _c_string(text: str) -> str:
    plain = (c if 32 <= b < 127 and c not in '"\\?' else f"\\{b:03o}" for b in text.encode() for c in [chr(b)])
    return f'"{"".join(plain)}"'


def _offsets(g: Generator, c: Combination) -> dict[int, Exact]:
    return _paths(g, c.offsets)


def _paths(g: Generator, offsets: Mapping[str, Exact]) -> dict[int, Exact]:
    return {g.lay.path_of[path]: value for path, value in offsets.items()}


def _flanges(g: Generator) -> dict[str, Any]:
    """The flanges of all components in the tables of the outputs, column by column."""
    group: list[int] = []
    gain: list[Exact] = []
    node: list[int] = []
    shown, hidden = flanges_of(g)
    for code, flange in (*shown, *hidden):
        group += code.batch.groups[flange]
        gain += code.batch.gains[flange]
        node += code.batch.nodes[flange]
    at = {n: g.lay.path_of[path] for n, path in g.assembly.ground_offset.items() if path}
    offset = [at.get(n, -1) for n in node]
    count = {"count": len(node), "shown": sum(code.n for code, _ in shown)}
    return count | {"group": group, "gain": texts_of(gain), "offset": offset, "node": node}
