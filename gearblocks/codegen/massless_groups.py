"""Massless groups: their speeds follow from the balance of torques.

Where something damps such a group, T(w) = 0 gives its speed (a state of first order); where only springs act on it,
dT/dt = 0 gives it, and its angle is put into balance at the start and after every event. Knows nothing of which groups are
massless: the assembly says so.
"""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import sympy as sp

from gearblocks.codegen.function import Argument, Column, column
from gearblocks.codegen.jacobian.sparsity import eliminate
from gearblocks.codegen.operands import Assignment, Operand, Role
from gearblocks.codegen.parts import Massless, MasslessRows
from gearblocks.errors import ModelError
from gearblocks.language.block import given_start
from gearblocks.language.fields import ANGLE
from gearblocks.laws.rational import Exact

if TYPE_CHECKING:
    from gearblocks.assembly.tables import Assembly
    from gearblocks.codegen.batch import BatchCode
    from gearblocks.codegen.function import Function
    from gearblocks.codegen.generator import Generator


def massless_rows(assembly: Assembly) -> MasslessRows:
    """Factors on the massless groups by every group that moves with one. ModelError for a prescribed motion that does."""
    first, last = assembly.n_speeds, assembly.n_speeds + assembly.n_massless
    found: MasslessRows = {group: {group - first: 1} for group in range(first, last)}
    for f in assembly.dependent_groups:
        touched = [s for s in f.sources if s in found]
        if touched and f.prescribed is not None:
            raise ModelError(
                f"'{f.prescribed.path}' moves with a shaft that has no inertia; give that shaft an Inertia with J > 0"
            )
        if touched and f.row is not None:
            row: dict[int, Exact] = {}
            for source in touched:
                for number, c in found[source].items():
                    row[number] = row.get(number, 0) + f.row.groups[source] * c
            found[f.group] = {number: c for number, c in row.items() if c}
    return found


def lay_out_massless(g: Generator) -> None:
    """Fills g.massless from the balances of all batches. ModelError for a shaft without any damper or spring."""
    assembly = g.assembly
    rows = massless_rows(assembly)
    balances = {code.number: code.balance for code in g.codes}
    damped, sprung = [False] * assembly.n_massless, [False] * assembly.n_massless
    pairs: set[tuple[int, int]] = set()
    for code in g.codes:
        for entries, marks in ((code.balance.damping_entries, damped), (code.balance.stiffness_entries, sprung)):
            for (f, other), _ in entries.items():
                for a, b in _numbers(code, rows, f, other):
                    pairs.add((a, b))
                    if a == b and (marks is sprung or a not in assembly.floating_bases):
                        marks[a] = True
    forces = frozenset(group - assembly.n_speeds for group in assembly.force_unknowns)
    for i in forces:
        damped[i] = True
    for i in range(assembly.n_massless):
        if not damped[i] and not sprung[i]:
            raise ModelError(
                f"the shaft at '{assembly.starts[assembly.n_speeds + i].phi0}' has no inertia, and neither spring nor damper "
                f"holds it: give it an Inertia with J > 0"
            )
    _refuse_inputs(g, rows, damped)
    affine = all(
        not (sp.sympify(e).free_symbols & {x for x, s in g.codes[n].law.pool.roles.items() if s.role == "w"})
        for n, balance in balances.items() for e in (*balance.damping_entries.values(), *balance.stiffness_entries.values())
    )  # fmt: skip
    given = _given(assembly, rows) | {
        group - assembly.n_speeds for pair in assembly.speed_ties for group, _ in pair if group >= assembly.n_speeds
    }
    free = [
        i not in given or not damped[i] for i in range(assembly.n_massless)
    ]  # model/start_values.py checks the second
    pattern = eliminate(assembly.n_massless, pairs, forces)
    g.massless = Massless(rows, assembly.floating_bases, damped, free, pattern, affine, _shifts(g))
    g.massless.switched = any(s.role == "mode" for n in balances for s in g.codes[n].law.pool.roles.values())
    if forces:
        g.massless.by_mode = frozenset(i for i, s in enumerate(sprung) if s and damped[i]) - forces
    for code in g.codes:
        _functions(g, code)


def _numbers(code: BatchCode, rows: MasslessRows, f: str, other: str) -> list[tuple[int, int]]:
    """The pairs of massless groups that two flanges of the instances move with."""
    pairs = zip(code.batch.groups[f], code.batch.groups[other], strict=True)
    return [ab for a, b in pairs if a in rows and b in rows for ab in product(rows[a], rows[b])]


def _given(assembly: Assembly, rows: MasslessRows) -> set[int]:
    """Massless groups with a given start angle, or with one that such an angle depends on."""
    found: set[int] = set()
    for c in assembly.train.components:
        if given_start(c.block, ANGLE) is not None:
            for node in c.nodes:
                found.update(rows.get(assembly.group_of_node[node][0], ()) if node >= 0 else ())
    return found


def _refuse_inputs(g: Generator, rows: MasslessRows, damped: list[bool]) -> None:
    """A massless group between springs alone cannot take the torque of an Input, whose rate nobody knows."""
    for code in g.codes:
        for f, torque in code.balance.torques.items():
            inner = {x for c in code.hoister.terms for x in c.expr.free_symbols if c.symbol in torque.free_symbols}
            roles = {code.law.pool.roles[x].role for x in inner | torque.free_symbols}
            for e, group in enumerate(code.batch.groups[f]):
                if not all(damped[i] for i in rows.get(group, ())) and roles & {"input", "sense"}:
                    raise ModelError(
                        f"'{code.paths[e]}': an Input or sensed signal acts on a shaft without inertia and damping; give the "
                        f"shaft one of them"
                    )


def _shifts(g: Generator) -> list[dict[int, Exact]]:
    """The states that the angle of each massless group moves."""
    assembly, lay = g.assembly, g.lay
    first = assembly.n_speeds
    found: list[dict[int, Exact]] = [{} for _ in range(assembly.n_massless)]
    for i, row in enumerate(assembly.rows):
        for group, c in row.items():
            if first <= group < first + assembly.n_massless:
                found[group - first][i] = c
    for i, group in enumerate(assembly.angles):
        if first <= group < first + assembly.n_massless:
            found[group - first][lay.angle0 + i] = 1
    return found


def _functions(g: Generator, code: BatchCode) -> None:
    """Torques, torque rates, damping and stiffness entries of one batch as functions."""
    massless, balance = g.massless, code.balance
    assert massless is not None
    for what, vector, exprs in (
        ("torque", Role.TORQUES, balance.torques), ("torque_rate", Role.TORQUE_RATES, balance.torque_rates),
    ):  # fmt: skip
        elastic = vector is Role.TORQUE_RATES
        assignments = [
            Assignment(Operand(vector, f"g_{f}"), "+=", e, flange=f) for f, e in exprs.items() if e != 0 or not elastic
        ]
        if assignments and not (elastic and all(massless.damped) and not massless.by_mode):
            g.keep(f"massless_{what}", code.function(f"massless_{what}", assignments))
    for vector, entries in (
        (Role.DAMPING_ENTRIES, balance.damping_entries),
        (Role.STIFFNESS_ENTRIES, balance.stiffness_entries),
    ):
        if entries:
            g.keep("massless_slopes", _slopes(code, massless, vector, entries))


def _slopes(code: BatchCode, massless: Massless, vector: Role, entries: dict[tuple[str, str], Any]) -> Function:
    assignments: list[Assignment] = []
    arguments: list[Argument] = []
    what = vector.value
    for i, ((f, other), e) in enumerate(entries.items()):
        terms = _terms(code, massless, f, other, damping=vector is Role.DAMPING_ENTRIES)
        for j in range(max(map(len, terms))):
            here = [own[j] if j < len(own) else (massless.n_entries - 1, 0.0) for own in terms]
            name = f"{code.batch.name}_{what}{i}_{j}"
            arguments += [
                Argument("int", f"at{i}_{j}", column(f"{name}_at", [place for place, _ in here])),
                Argument("double", f"by{i}_{j}", Column(f"{name}_by", tuple(factor for _, factor in here))),
            ]
            assignments.append(Assignment(Operand(vector, f"at{i}_{j}"), "+=", e, factor=f"by{i}_{j}"))
    function = code.function(f"massless_{what}", assignments)
    function.take(arguments)
    return function


def _terms(
    code: BatchCode, massless: Massless, f: str, other: str, *, damping: bool
) -> list[list[tuple[int, float]]]:  # fmt: skip
    """(entry, factor) by instance of what a slope adds. Dampers add nothing where springs alone give a speed."""
    found: list[list[tuple[int, float]]] = []
    for k, (a, b) in enumerate(zip(code.batch.groups[f], code.batch.groups[other], strict=True)):
        gain = code.batch.gains[f][k] * code.batch.gains[other][k]
        pairs = product(massless.rows.get(a, {}).items(), massless.rows.get(b, {}).items())
        found.append([
            (massless.entry(one, two), float(gain * x * y))
            for (one, x), (two, y) in pairs if not damping or not massless.floating_bases & {one, two}
        ])  # fmt: skip
    return found
