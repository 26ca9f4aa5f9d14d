"""From an assembly to a program: offsets are given out, every law is printed once per batch, the template is filled."""

from __future__ import annotations

from itertools import chain
from typing import Any

import sympy as sp

from gearblocks.assembly.angle_wrapping import AngleWrapping, find_wrapped_angles, located
from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.assembly.tables import Assembly
from gearblocks.codegen import comments
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.comments import in_comment, key_of, tool, with_comments, without_comments
from gearblocks.codegen.enclosures import lay_out_enclosures
from gearblocks.codegen.feedback import order_signals, reads_angles, reads_motion, signals_behind_motion
from gearblocks.codegen.function import column, identifier
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.hoisted_terms import lay_out_terms
from gearblocks.codegen.jacobian.matrix import linear_part
from gearblocks.codegen.lanes import has_lanes, lane_values
from gearblocks.codegen.layout import input_info, lay_out, padded
from gearblocks.codegen.mass_matrix import check_mobility, lay_out_mass, prescribed_motion_functions
from gearblocks.codegen.massless_groups import lay_out_massless, massless_rows
from gearblocks.codegen.operands import Assignment, Operand, Role
from gearblocks.codegen.output_names import (
    dependent_starts,
    flange_outputs,
    flanges_of,
    heat_infos,
    lossy_starts,
    prescribed_starts,
    shown,
    start_infos,
    state_quantities,
    unknown_outputs,
)
from gearblocks.codegen.parts import FeedbackSignal
from gearblocks.codegen.program import EnergyInfo, IntegralInfo, Program
from gearblocks.codegen.rigid_train import algebraic_slips, body_rows, deflection_rows, group_starts, slip_rows
from gearblocks.codegen.switched_constraints import constraint_torques, lay_out_switched_constraints, loss_offsets
from gearblocks.codegen.switches import event_functions, lay_out_switches
from gearblocks.codegen.symbol_names import Offsets
from gearblocks.codegen.template_loading import CompiledTemplates, templates
from gearblocks.codegen.template_values import contents, view
from gearblocks.language.signals import Table
from gearblocks.language.tables import Table2
from gearblocks.laws.printer import c_text


def generate(assembly: Assembly, compiled: CompiledTemplates | None = None) -> Program:
    """The program of an assembly. The same assembly gives the same bytes. compiled: where templates are kept."""
    wanted = sorted({
        meaning.of for b in assembly.batches for meaning in b.law.pool.roles.values() if meaning.role == "sense"
    } | {leaf.args[0] for c in assembly.train.coordinates for leaf in c.expr.leaves() if leaf.op == "sense"})  # fmt: skip
    in_law = [meaning.of for b in assembly.batches for meaning in b.law.pool.roles.values() if meaning.role == "sense"]
    angles = assembly.in_law or any(reads_angles(assembly, path) for path in in_law)
    wrapping = find_wrapped_angles(assembly, in_law) if angles else AngleWrapping()
    g = Generator(assembly, lay_out(assembly, angles_in_law=angles, n_wrapped=len(wrapping.wrapped)), wrapping=wrapping)
    g.feedback = {path: FeedbackSignal(path, i) for i, path in enumerate(wanted)}
    g.n_end = g.lay.quadratures0
    _columns(g)
    g.behind_motion = signals_behind_motion(g, in_law)
    _laws(g)
    g.feedback = order_signals(g.feedback, g.codes, g.assembly, set(in_law), g.wrapping.unwrapped)
    if g.n_surfaces > g.n_affine:
        g.enclosures = lay_out_enclosures(g)
    g.lay.n_total = g.lay.n_padded + padded(g.n_end - g.lay.n_padded)
    g.linear = linear_part(g)
    g.output_groups += flange_outputs(g)
    return _program(g, *_render(g, angles, templates(compiled)))


# -- offsets ----------------------------------------------------------------------------------------------------------


def _columns(g: Generator) -> None:
    """Hoists every law; offsets of exact values, inverse masses, hoisted terms and switches."""
    massless = massless_rows(g.assembly) if g.assembly.n_massless else {}
    at = len(g.lay.parameters)
    g.inverse_mass = at
    at += g.assembly.n_groups
    if g.assembly.plain:
        g.mass = at
        at += g.assembly.n_groups
    else:
        at = lay_out_mass(g, at)
    at = lay_out_switched_constraints(g, at)
    for number, batch in enumerate(g.assembly.batches):
        own = {path: i for (b, path), i in g.lay.own.items() if b == number}
        offsets = Offsets(
            own,
            inverse_mass=g.inverse_mass,
            mass=g.mass,
            massless=massless,
            floating_bases=g.assembly.floating_bases,
            by_mode=bool(g.assembly.force_unknowns),
            feedback={p: s.index for p, s in g.feedback.items()},
        )
        offsets.tables = {
            x: _table_name(g, meaning.of) for x, meaning in batch.law.pool.roles.items() if meaning.role in ("table", "table2")
        }  # fmt: skip
        offsets.constraints = {name: g.constraints.first[number, name] for name in batch.law.constraints}
        code = BatchCode(g.lay, number, batch, offsets)
        for symbol, values in batch.exact.items():
            if batch.law.pool.roles[symbol].role == "exact":
                offsets.exact[symbol] = at
                g.exact.append((at, column(f"{batch.name}_{identifier(str(symbol))}", [float(v) for v in values])))
                at += len(batch.components)
        code.hoist_all()
        g.codes.append(code)
    g.n_par = at
    g.mobile = check_mobility(g, [item for code in g.codes for item in code.mobile_groups()])
    lay_out_switches(g)
    for code in g.codes:
        lay_out_terms(g, code)


def _table_name(g: Generator, table: Table | Table2) -> str:
    if isinstance(table, Table2):
        axes = [_table_name(g, axis) for axis in table.axes]
        return g.maps.setdefault(table.digest(), (f"map_{len(g.maps)}", table, axes))[0]
    return g.tables.setdefault(table.digest(), (f"table_{len(g.tables)}", table))[0]


# -- laws -------------------------------------------------------------------------------------------------------------


def _laws(g: Generator) -> None:
    flange_tau = 0
    if g.assembly.n_massless:
        lay_out_massless(g)
    for code in g.codes:
        prescribed_motion_functions(g, code)
        _rates(g, code)
        event_functions(g, code)
    for code, flange in chain.from_iterable(flanges_of(g)):
        code.offsets.flange_torques[flange] = flange_tau
        flange_tau += code.n
    _supplies(g)
    loss_offsets(g)
    for code in g.codes:
        torques = [*code.torques.items(), *constraint_torques(code)]
        g.keep("torques", code.function("torques", [Assignment(_flange_torque(code, f), "+=", e) for f, e in torques]))
        _bodies(g, code)
        _shows(g, code)
        starts = [Assignment(_state(g, code, x, Role.STATES), "=", e) for x, e in code.starts.items()]
        g.keep("starts", code.function("starts", starts))


def _shows(g: Generator, code: BatchCode) -> None:
    """Outputs of the blocks; those that read unwrapped angles apart."""
    shows: dict[bool, list[Assignment]] = {False: [], True: []}
    for i, (show, expr) in enumerate(code.shows):
        unwrapped = (code.number, i) in g.wrapping.unwrapped
        out = Operand(Role.OUTPUTS, len(g.outputs), instance=True)
        shows[unwrapped].append(Assignment(out, "show", located(expr) if unwrapped else expr))
        g.output_groups.append(shown(code, show.name, show.unit, show.words))
    for vector, name, those in (
        (Role.STATES, "outputs", shows[False]), (Role.UNWRAPPED_ANGLES, "unwrapped_outputs", shows[True]),
    ):  # fmt: skip
        made = code.function(name, those, vector=vector)
        reads = (code.names([a.expr], vector=vector).reads for a in those)
        made.each = tuple(
            (a.target, read) for a, read in zip(those, reads, strict=True) if isinstance(a.target, Operand)
        )
        g.keep("outputs", made)


def _flange_torque(code: BatchCode, flange: str) -> Operand:
    return Operand(Role.FLANGE_TORQUES, code.offsets.flange_torques[flange], instance=True)


def _state(g: Generator, code: BatchCode, state: str, vector: Role) -> Operand:
    """A state of the blocks of a batch, or its rate."""
    return Operand(vector, g.lay.state0[code.number, state], instance=True)


def _supplies(g: Generator) -> None:
    """Offsets in the ledger of the power of prescribed motions."""
    if g.dependent is not None:
        g.supply0 = g.n_end
        for i in g.dependent.supplied:
            motion = g.dependent.members[i].prescribed
            assert motion is not None
            g.integrals.append(IntegralInfo(motion.path, "supplied", g.n_end))
            g.n_end += 1


def _rates(g: Generator, code: BatchCode) -> None:
    """Derivatives, and the ledger in the full variant."""
    batch = code.batch
    own = [j for j in range(len(code.speeds)) if batch.used[j] and not batch.dependent[j]]
    assignments = [Assignment(Operand(Role.RATES, f"q{j}"), "=", code.speeds[j]) for j in own]
    assignments += [code.torque(f, expr) for f, expr in code.torques.items() if batch.groups[f][0] != GROUND_GROUP]
    assignments += [Assignment(_state(g, code, x, Role.RATES), "=", expr) for x, expr in code.rates.items()]
    for part, entry in (("loss", code.loss), ("supplied", code.supplied)):
        if entry is not None:
            place = Operand(Role.RATES, g.n_end, instance=True)
            assignments.append(Assignment(place, "=", entry, full=True))
            if part == "loss" and code.constraint_loss is not None:
                losses = [Assignment(place, "+=", code.constraint_loss, full=True)]
                if code.law.heat:
                    losses.append(Assignment(_state(g, code, code.law.heat, Role.RATES), "+=", code.constraint_loss))
                g.keep("constraint_losses", code.function("constraint_losses", losses))
            g.integrals += [IntegralInfo(code.paths[e], part, g.n_end + e) for e in range(code.n)]
            g.n_end += code.n
    late = [a for a in assignments if reads_motion(g, code, a.expr)]
    function = code.function("rates", [a for a in assignments if a not in late])
    function.take(code.coordinate_argument(j) for j in own)
    g.keep("rates", function)
    g.keep("late_rates", code.function("late_rates", late))


def _bodies(g: Generator, code: BatchCode) -> None:
    """Kinetic and stored energies, and the torque that bodies exert on their shafts by their inertia."""
    inertial: list[Assignment] = []
    energy: list[Assignment] = []
    for flange, J in code.law.bodies:
        if code.batch.groups[flange][0] != GROUND_GROUP:
            g.keep("masses", code.mass(flange, J))
    for flange, J in code.law.bodies:
        if code.batch.groups[flange][0] == GROUND_GROUP:
            continue
        w = code.law.pool.symbol("w", flange, f"w_{flange}")
        alpha = code.law.pool.symbol("alpha", flange, f"alpha_{flange}")
        inertial.append(Assignment(_flange_torque(code, flange), "-=", J * alpha))
        energy.append(Assignment(Operand(Role.ENERGIES, len(g.energies), instance=True), "=", J * w**2 / 2))
        g.energies += [EnergyInfo(code.paths[e], "kinetic", len(g.energies) + e) for e in range(code.n)]
    if code.stored is not None:
        energy.append(Assignment(Operand(Role.ENERGIES, len(g.energies), instance=True), "=", code.stored))
        g.energies += [EnergyInfo(code.paths[e], "stored", len(g.energies) + e) for e in range(code.n)]
    g.keep("inertia_torques", code.function("inertia_torques", inertial))
    g.keep("energies", code.function("energies", energy))


# -- outputs ----------------------------------------------------------------------------------------------------------


def _coordinate_outputs(g: Generator) -> list[str]:
    """C of the coordinates for reading, over feedback signals and parameters."""
    from gearblocks.language.expression import to_sympy

    texts = []
    for c in g.assembly.train.coordinates:
        names: dict[Any, str] = {}

        def leaf(x: Any, names: dict[Any, str] = names) -> Any:
            signal = x.op == "sense"
            offset = g.feedback[x.args[0]].index if signal else g.lay.shared[x.args[0].name]
            text = str(Operand(Role.FEEDBACK_SIGNALS if signal else Role.PARAMETERS, offset))
            symbol = sp.Symbol(text, real=True)
            names[symbol] = text
            return symbol

        texts.append(c_text(to_sympy(c.expr, leaf), names))
    return texts


def _program(g: Generator, source: str, key: str, lanes: str) -> Program:
    lay = g.lay
    if lay.angle0 >= lay.n:
        for i, group in enumerate(g.assembly.angles):
            g.integrals.append(IntegralInfo(g.assembly.starts[group].phi0, "angle", lay.angle0 + i))
    return Program(
        g.assembly.train.name, source, key, tuple(lay.parameters),
        tuple(map(input_info, lay.inputs.values())), tuple(state_quantities(g)), tuple(g.switches),
        g.outputs, tuple(g.energies), tuple(g.integrals), lay.n, lay.n_padded, lay.n_total,
        tuple(start_infos(g)), g.assembly.structural, (*dependent_starts(g), *lossy_starts(g)),
        tuple(prescribed_starts(g)), tuple(unknown_outputs(g)), lanes, tuple(group_starts(g)), tuple(body_rows(g)),
        tuple(deflection_rows(g)), tuple(slip_rows(g)), tuple(heat_infos(g)), tuple(algebraic_slips(g)),
    )  # fmt: skip


def _render(g: Generator, angles: bool, environment: Any) -> tuple[str, str, str]:
    """C text and its key, a hash of the program alone, which does not change with names in comments or the version; and the
    text over lanes, "" where the train has none."""

    def fill(name: str, values: dict[str, Any]) -> str:
        return str(environment.get_template(name).render(values))

    values = view(g, angles, _coordinate_outputs(g)) | {"comment": comments}
    text = fill("model.c.jinja", values)
    key = key_of(text)
    words = {"title": f"Train '{in_comment(g.assembly.train.name)}'", "tool": tool(), "contents": contents(g)}
    lanes = without_comments(fill("lanes.c.jinja", lane_values(g, values))) if has_lanes(g) else ""
    source = "".join([fill("header.c.jinja", words), with_comments(text), fill("key.c.jinja", {"key": key})])
    return source, key, lanes
