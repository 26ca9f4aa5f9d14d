"""From an assembly to a program: offsets are given out, every law is printed once per batch, the template is filled."""

from __future__ import annotations

import hashlib
from importlib.resources import files
from typing import Any

import sympy as sp

from gearblocks.assembly.angle_wrapping import Turns, find_turns, located
from gearblocks.assembly.assemble import HELD
from gearblocks.assembly.tables import Assembly
from gearblocks.codegen.batch import BatchCode, Places
from gearblocks.codegen.feedback import order_senses, reads_angles
from gearblocks.codegen.function import Statement, column, identifier
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.jacobian.matrix import linear_part
from gearblocks.codegen.layout import lay_out, padded
from gearblocks.codegen.mass_matrix import check_mobility, drive_functions, lay_out_mass
from gearblocks.codegen.massless_groups import hidden_rows, lay_out_massless
from gearblocks.codegen.mean_excitation import mean_of_column
from gearblocks.codegen.output_names import (
    flange_outputs,
    follower_infos,
    moved_infos,
    shown,
    start_infos,
    state_quantities,
    unknown_outputs,
)
from gearblocks.codegen.parts import Band, Prediction, Sense
from gearblocks.codegen.program import EnergyInfo, InputInfo, IntegralInfo, Program, SwitchInfo
from gearblocks.codegen.switched_constraints import held_torques, lay_out_locks, lock_functions, loss_places
from gearblocks.codegen.template_values import view
from gearblocks.language.signals import Table
from gearblocks.language.tables import Table2
from gearblocks.laws.printer import c_text
from gearblocks.laws.symbols import CONSTANT


def generate(assembly: Assembly) -> Program:
    """The program of an assembly. The same assembly gives the same bytes."""
    wanted = sorted({
        slot.of for b in assembly.batches for slot in b.law.pool.slots.values() if slot.role == "sense"
    } | {leaf.args[0] for c in assembly.train.coordinates for leaf in c.expr.leaves() if leaf.op == "sense"})  # fmt: skip
    in_law = [slot.of for b in assembly.batches for slot in b.law.pool.slots.values() if slot.role == "sense"]
    angles = assembly.in_law or any(reads_angles(assembly, path) for path in in_law)
    turns = find_turns(assembly, in_law) if angles else Turns()
    g = Generator(assembly, lay_out(assembly, angles_in_law=angles, n_counted=len(turns.counted)), turns=turns)
    g.senses = {path: Sense(path, i) for i, path in enumerate(wanted)}
    g.tail = g.lay.tail
    _columns(g)
    _laws(g)
    g.senses = order_senses(g.senses, g.codes, g.assembly, set(in_law), g.turns.whole)
    g.lay.n_total = g.lay.n_padded + padded(g.tail - g.lay.n_padded)
    g.linear = linear_part(g)
    g.outputs += flange_outputs(g)
    return _program(g, _render(g, angles))


# -- offsets ----------------------------------------------------------------------------------------------------------


def _columns(g: Generator) -> None:
    """Hoists every law and places exact values, inverse masses, hoisted columns and switches."""
    hidden = hidden_rows(g.assembly) if g.assembly.n_hidden else {}
    at = len(g.lay.parameters)
    g.inverse_mass = at
    at += g.assembly.n_groups
    if g.assembly.plain:
        g.mass = at
        at += g.assembly.n_groups
    else:
        at = lay_out_mass(g, at)
    at = lay_out_locks(g, at)
    for number, batch in enumerate(g.assembly.batches):
        own = {path: i for (b, path), i in g.lay.own.items() if b == number}
        places = Places(
            own,
            inverse_mass=g.inverse_mass,
            mass=g.mass,
            hidden=hidden,
            floats=g.assembly.floats,
            senses={p: s.index for p, s in g.senses.items()},
        )
        places.tables = {
            x: _table_name(g, slot.of) for x, slot in batch.law.pool.slots.items() if slot.role in ("table", "table2")
        }  # fmt: skip
        places.locks = {name: g.locks.first[number, name] for name in batch.law.sticks}
        code = BatchCode(g.lay, number, batch, places)
        for symbol, values in batch.exact.items():
            if batch.law.pool.slots[symbol].role == "exact":
                places.exact[symbol] = at
                g.exact.append((at, column(f"{batch.name}_{identifier(str(symbol))}", [float(v) for v in values])))
                at += len(batch.components)
        code.hoist_all()
        g.codes.append(code)
    g.n_par = at
    g.mobile = check_mobility(g, [item for code in g.codes for item in code.mobile_groups()])
    _switches(g)
    for code in g.codes:
        _hoisted(g, code)


def _table_name(g: Generator, table: Table | Table2) -> str:
    if isinstance(table, Table2):
        axes = [_table_name(g, axis) for axis in table.axes]
        return g.maps.setdefault(table.digest(), (f"map_{len(g.maps)}", table, axes))[0]
    return g.tables.setdefault(table.digest(), (f"table_{len(g.tables)}", table))[0]


def _switches(g: Generator) -> None:
    """Affine surfaces first, then general ones, then those of time alone."""
    at = 0
    for wanted in (("affine", "affine_lock"), ("general", "general_lock"), ("line", "wave")):
        for code in g.codes:
            if not code.places.switches:
                code.places.switches = [-1] * len(code.law.switches)
            for i, switch in enumerate(code.law.switches):
                if code.sorts[i] in wanted:
                    code.places.switches[i] = at
                    kind = "time" if switch.level < 2 else "state"
                    for e in range(code.n):
                        owner = f"{code.paths[e]}.{switch.name}".rstrip(".")
                        g.switches.append(SwitchInfo(owner, switch.name, kind, switch.low, switch.high))
                    at += code.n
        if "affine" in wanted:
            g.n_affine = at
        elif "general" in wanted:
            g.n_surfaces = at


def _hoisted(g: Generator, code: BatchCode) -> None:
    """Places of the hoisted columns of a batch and the statements that fill them.

    Everything that asks for a column must have been hoisted: predictions, gap scales and directions too.
    """
    for i, sort in enumerate(code.sorts):
        if sort in ("line", "wave"):
            code.prediction(i)
        elif sort == "affine":
            code.direction_of(i)
            code.gap_scale(i)
    prepare: list[tuple[str, str, Any, bool]] = []
    times: dict[bool, list[tuple[str, str, Any, bool]]] = {False: [], True: []}
    means: list[tuple[str, str, Any, bool]] = []
    moving = code.moving_columns({path.rpartition(".")[2] for path in g.senses})
    for item in code.hoister.columns:
        constant, late = item.level == CONSTANT, item.symbol not in moving
        if item.shared:
            names, _, _ = code.names([item.expr], vector="lane")
            text = c_text(item.expr, names)
            key = (item.level, text)
            if key not in g.shared:
                g.shared[key] = _shared_column(g, constant, text)
                if not constant:
                    mean = mean_of_column(code, item)
                    names, _, _ = code.names([mean], vector="lane")
                    g.means_shared.append(Statement(g.times_shared[-1].lhs, "=", c_text(mean, names)))
            code.places.hoisted[item.symbol] = g.shared[key]
            if not late:
                g.early.add(g.shared[key])
            continue
        if constant:
            code.places.hoisted[item.symbol] = f"par[{g.n_par} + e]"
            prepare.append((f"par[{g.n_par} + e]", "=", item.expr, False))
            g.n_par += code.n
        else:
            code.places.hoisted[item.symbol] = f"tau[({g.n_time} + e) * GB_LANES]"
            place = f"tau[({g.n_time} + e) * GB_LANES + i]"
            times[late].append((place, "=", item.expr, False))
            means.append((place, "=", mean_of_column(code, item), False))
            g.n_time += code.n
    g.keep("prepare", code.function("prepare", prepare))
    g.keep("times", code.function("times", times[False], vector="lane"))
    g.keep("times_late", code.function("times_late", times[True], vector="lane"))
    g.keep("means", code.function("means", means, vector="lane"))


def _shared_column(g: Generator, constant: bool, text: str) -> str:
    if constant:
        g.prepare_shared.append(Statement(f"par[{g.n_par}]", "=", text))
        g.n_par += 1
        return f"par[{g.n_par - 1}]"
    g.times_shared.append(Statement(f"tau[{g.n_time} * GB_LANES + i]", "=", text))
    g.n_time += 1
    return f"tau[{g.n_time - 1} * GB_LANES]"


# -- laws -------------------------------------------------------------------------------------------------------------


def _laws(g: Generator) -> None:
    flange_tau = 0
    if g.assembly.n_hidden:
        lay_out_massless(g)
    for code in g.codes:
        drive_functions(g, code)
        _rates(g, code)
        _surfaces(g, code)
        for flange in code.batch.flanges:
            code.places.tau[flange] = flange_tau
            flange_tau += code.n
    _supplies(g)
    loss_places(g)
    for code in g.codes:
        targets = [(f"flange_tau[{code.places.tau[f]} + e]", "+=", e, False) for f, e in code.torques.items()]
        targets += [(f"flange_tau[{code.places.tau[f]} + e]", "+=", e, False) for f, e in held_torques(code)]
        g.keep("torques", code.function("torques", targets))
        _bodies(g, code)
        shows: dict[bool, list[tuple[str, str, Any, bool]]] = {False: [], True: []}
        for i, (show, expr) in enumerate(code.shows):
            shows[(code.number, i) in g.turns.whole].append((f"out[{len(g.outputs)} + e]", "=", expr, False))
            g.outputs += shown(g, code, show.name, show.unit, show.words)
        g.keep("shows", code.function("shows", shows[False]))
        apart = [(lhs, op, located(expr), full) for lhs, op, expr, full in shows[True]]
        g.keep("shows", code.function("whole_shows", apart, vector="whole"))
        starts = [(f"y[{g.lay.state0[code.number, x]} + e]", "=", e, False) for x, e in code.starts.items()]
        g.keep("starts", code.function("starts", starts))


def _supplies(g: Generator) -> None:
    """Places in the ledger for the power of prescribed motions."""
    if g.motion is not None:
        g.supply0 = g.tail
        for i in g.motion.powered:
            drive = g.motion.followers[i].drive
            assert drive is not None
            g.integrals.append(IntegralInfo(drive.path, "supplied", g.tail))
            g.tail += 1


def _rates(g: Generator, code: BatchCode) -> None:
    """Derivatives, and the ledger in the full variant."""
    batch = code.batch
    targets: list[tuple[str, str, Any, bool]] = []
    place: dict[str, str] = {}
    for j, speed in enumerate(code.speeds):
        if batch.used[j] and not batch.dependent[j]:
            targets.append((f"dy[q{j}]", "=", speed, False))
    held = [f for f in code.torques if batch.groups[f][0] == HELD]
    for flange, expr in code.torques.items():
        if flange not in held:
            place[code.torque_place(flange)] = flange
            targets.append((code.torque_place(flange), "+=", expr, False))
    for state, expr in code.rates.items():
        targets.append((f"dy[{g.lay.state0[code.number, state]} + e]", "=", expr, False))
    for part, entry in (("loss", code.loss), ("supplied", code.supplied)):
        if entry is not None:
            targets.append((f"dy[{g.tail} + e]", "=", entry, True))
            if part == "loss" and code.late_loss is not None:
                g.keep("late_rates", code.function("late_rates", [(f"dy[{g.tail} + e]", "+=", code.late_loss, True)]))
            g.integrals += [IntegralInfo(code.paths[e], part, g.tail + e) for e in range(code.n)]
            g.tail += code.n
    function = code.function("rates", targets, extra=[f for f in code.torques if f not in held])
    for statement in function.body:
        if statement.lhs in place:
            statement.rhs = code.scaled(place[statement.lhs], statement.rhs)
    known = {name for _, name, _ in function.args}
    for j in range(len(code.speeds)):
        if batch.used[j] and not batch.dependent[j] and f"q{j}" not in known:
            function.args.append(("int", f"q{j}", column(f"{batch.name}_q{j}", batch.sources[j])))
    g.keep("rates", function)


def _surfaces(g: Generator, code: BatchCode) -> None:
    values, directions, scales = [], [], []
    for i, sort in enumerate(code.sorts):
        at = f"{code.places.switches[i]} + e"
        if sort in ("affine", "general"):
            values.append((f"s[{at}]", "=", code.surfaces[i], False))
        if sort == "affine":
            directions.append((f"s[{at}]", "=", code.direction_of(i), False))
            scale = code.gap_scale(i)
            if scale is not None:
                scales.append((f"scale[q{scale[0]}]", "|=", scale[1], False))
    g.keep("surfaces", code.function("surfaces", values))
    g.keep("directions", code.function("directions", directions, vector="direction"))
    function = code.function("scales", scales)
    for j in {int(lhs[7:-1]) for lhs, _, _, _ in scales}:
        function.args.append(("int", f"q{j}", column(f"{code.batch.name}_q{j}", code.batch.sources[j])))
    g.keep("scales", function)
    held = [(f"y[{g.lay.state0[code.number, state]} + e]", "=", expr, False) for state, expr in code.holds]
    g.keep("hold", code.function("hold", held))
    lock_functions(g, code)
    _bounds(g, code)


def _bounds(g: Generator, code: BatchCode) -> None:
    """Limits per switch; switches of tables and those with a condition are told apart here."""
    targets = []
    for i, switch in enumerate(code.law.switches):
        at = f"{code.places.switches[i]} + e"
        if switch.lock in ("slip", "gap", "sign", "hold"):
            continue
        if switch.table is not None:
            targets.append((f"table_bounds(&{code.places.tables[switch.table]}, {at}", "call", code.whens[i], False))
        elif switch.band is not None:
            targets.append((f"lo[{at}]", "below", code.bands[i], False))
            targets.append((f"hi[{at}]", "above", code.bands[i], False))
            g.bands.append(Band(code.function(f"band_{i}", [("", "", code.bands[i], False)]), code.places.switches[i]))
        else:
            targets.append((f"sign_bounds({at}", "call", code.whens[i], False))
    g.keep("bounds", code.function("bounds", targets))
    for i, sort in enumerate(code.sorts):
        first = code.places.switches[i]
        table = code.law.switches[i].table
        name = code.places.tables[table] if table is not None else ""
        if table is not None:
            g.table_switches.append((first, code.n, name))
        if sort in ("line", "wave"):
            predictor, args = code.prediction(i)
            names, _, prologue = code.names(args)
            texts = [c_text(a, names) for a in args]
            g.predictions.append(Prediction(f"{code.batch.name}_{i}", predictor, texts, prologue, first, code.n, name))


def _bodies(g: Generator, code: BatchCode) -> None:
    """Kinetic and stored energies, and the torque that bodies exert on their shafts by their inertia."""
    inertial, energy = [], []
    for flange, J in code.law.bodies:
        if code.batch.groups[flange][0] != HELD:
            g.keep("masses", code.mass(flange, J))
    for flange, J in code.law.bodies:
        if code.batch.groups[flange][0] == HELD:
            continue
        w = code.law.pool.symbol("w", flange, f"w_{flange}")
        alpha = code.law.pool.symbol("alpha", flange, f"alpha_{flange}")
        inertial.append((f"flange_tau[{code.places.tau[flange]} + e]", "-=", J * alpha, False))
        energy.append((len(g.energies), J * w**2 / 2, "kinetic"))
        g.energies += [EnergyInfo(code.paths[e], "kinetic", len(g.energies) + e) for e in range(code.n)]
    if code.stored is not None:
        energy.append((len(g.energies), code.stored, "stored"))
        g.energies += [EnergyInfo(code.paths[e], "stored", len(g.energies) + e) for e in range(code.n)]
    g.keep("inertial", code.function("inertial", inertial))
    g.keep("energies", code.function("energies", [(f"energy[{i} + e]", "=", x, False) for i, x, _ in energy]))


# -- outputs ----------------------------------------------------------------------------------------------------------


def _coordinate_outputs(g: Generator) -> list[str]:
    """C of the coordinates for reading, over sense[] and parameters."""
    from gearblocks.language.expression import to_sympy

    texts = []
    for c in g.assembly.train.coordinates:
        names: dict[Any, str] = {}

        def leaf(x: Any, names: dict[Any, str] = names) -> Any:
            text = f"sense[{g.senses[x.args[0]].index}]" if x.op == "sense" else f"par[{g.lay.shared[x.args[0].name]}]"
            symbol = sp.Symbol(text, real=True)
            names[symbol] = text
            return symbol

        texts.append(c_text(to_sympy(c.expr, leaf), names))
    return texts


def _program(g: Generator, source: str) -> Program:
    lay = g.lay
    if lay.angle0 >= lay.n:
        for i, group in enumerate(g.assembly.angles):
            g.integrals.append(IntegralInfo(g.assembly.starts[group].phi0, "angle", lay.angle0 + i))
    return Program(
        g.assembly.train.name, source, key_of(source), tuple(lay.parameters),
        tuple(InputInfo(x.name, x.unit, x.start) for x in lay.inputs.values()), tuple(state_quantities(g)), tuple(g.switches),
        tuple(g.outputs), tuple(g.energies), tuple(g.integrals), lay.n, lay.n_padded, lay.n_total,
        tuple(start_infos(g)), g.assembly.structural, tuple(follower_infos(g)),
        tuple(moved_infos(g)), tuple(unknown_outputs(g)),
    )  # fmt: skip


def _render(g: Generator, angles: bool) -> str:
    """Fills the template."""
    body = _fill("model.c.jinja", view(g, angles, _coordinate_outputs(g)))
    return body + _fill("key.c.jinja", {"key": hashlib.sha256(body.encode()).hexdigest()})


def _fill(name: str, values: dict[str, Any]) -> str:
    import jinja2

    environment = jinja2.Environment(
        trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True, undefined=jinja2.StrictUndefined,
        loader=jinja2.FunctionLoader(_template),
    )  # fmt: skip
    return environment.get_template(name).render(values)


def _template(name: str) -> str:
    return files("gearblocks.codegen").joinpath(f"templates/{name}").read_text(encoding="utf-8")


def key_of(source: str) -> str:
    """The key that the source ends with."""
    return source.rsplit('"', 2)[1]
