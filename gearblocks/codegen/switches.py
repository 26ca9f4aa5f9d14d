"""Switches of a program: their order, their event functions, and the limits within which a mode stays.

Event functions that are affine in the state come first, then general ones, then those of time alone.
Knows nothing of how crossings are located.
"""

from __future__ import annotations

from typing import Any

from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.feedback import reads_motion
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.operands import Assignment, Index, Operand, Role
from gearblocks.codegen.parts import Band, Prediction
from gearblocks.codegen.program import SwitchInfo
from gearblocks.codegen.switched_constraints import switched_constraint_functions
from gearblocks.laws.symbols import MOVING

_ORDER = (("affine", "affine_constraint"), ("general", "general_constraint"), ("line", "wave"))


def lay_out_switches(g: Generator) -> None:
    """Gives every switch its number."""
    at = 0
    for wanted in _ORDER:
        for code in g.codes:
            if not code.offsets.switches:
                code.offsets.switches = [-1] * len(code.law.switches)
            for i, switch in enumerate(code.law.switches):
                if code.events.sorts[i] in wanted:
                    code.offsets.switches[i] = at
                    kind = "time" if switch.level < 2 else "state"
                    for e in range(code.n):
                        owner = f"{code.paths[e]}.{switch.name}".rstrip(".")
                        g.switches.append(SwitchInfo(owner, switch.name, kind, switch.low, switch.high))
                    at += code.n
        if "affine" in wanted:
            g.n_affine = at
        elif "general" in wanted:
            g.n_surfaces = at


def _modes(code: BatchCode, expr: Any) -> set[int]:
    """Numbers of the switches whose modes it reads."""
    roles = code.law.pool.roles
    return {roles[x].of.number for x in expr.free_symbols if roles[x].role == "mode"}


def event_functions(g: Generator, code: BatchCode) -> None:
    """Functions of a batch for its event functions, their linear parts, states of Hold and limits."""
    values: list[Assignment] = []
    directions: list[Assignment] = []
    scales: list[Assignment] = []
    scaled: set[int] = set()
    for i, sort in enumerate(code.events.sorts):
        place = Operand(Role.EVENT_FUNCTIONS, code.offsets.switches[i], instance=True)
        if sort in ("affine", "general"):
            values.append(Assignment(place, "=", code.surfaces[i]))
        if sort == "affine":
            directions.append(Assignment(place, "=", code.events.direction(i)))
            scale = code.events.gap_scale(i)
            if scale is not None:
                scaled.add(scale[0])
                scales.append(Assignment(Operand(Role.SCALES, f"q{scale[0]}"), "max", scale[1]))
    g.keep("event_functions", code.function("event_functions", values))
    g.keep("directions", code.function("directions", directions, vector=Role.DIRECTION))
    function = code.function("scales", scales)
    function.take(code.coordinate_argument(j) for j in sorted(scaled))
    g.keep("scales", function)
    states = [
        Assignment(Operand(Role.STATES, g.lay.state0[code.number, state], instance=True), "=", expr)
        for state, expr in code.holds
    ]
    g.keep("update_states", code.function("update_states", states))
    for state, _value, when in code.law.holds:
        modes = _modes(code, when)
        if state in code.law.inverse_speeds and modes:  # a contact that has become rigid has none
            switch = code.offsets.switches[min(modes)]
            first = g.lay.state0[code.number, state]
            g.inverse_speeds += [(first + e, switch + e) for e in range(code.n)]
    features: list[Assignment] = []
    for argument, bounded in code.features:
        if reads_motion(g, code, argument):  # known behind the torques alone
            continue
        features.append(Assignment(Operand(Role.FEATURES, len(g.features), instance=True), "=", argument))
        g.features += [bounded] * code.n
    g.keep("features", code.function("features", features))
    switched_constraint_functions(g, code)
    _limits(g, code)
    _predictions(g, code)


def _limits(g: Generator, code: BatchCode) -> None:
    """Limits per switch; switches of tables and those with a condition are told apart here."""
    assignments: list[Assignment] = []
    for i, switch in enumerate(code.law.switches):
        at = Index(code.offsets.switches[i], instance=True)
        if switch.constraint in ("slip", "gap", "sign", "hold"):
            continue
        if switch.table is not None:
            assignments.append(Assignment(at, "table", code.whens[i], table=code.offsets.tables[switch.table]))
        elif switch.band is not None:
            assignments.append(Assignment(at, "band", code.bands[i]))
            band = code.names([code.bands[i]])
            g.bands.append(Band(band, band.print(code.bands[i]), code.offsets.switches[i], code.n))
        else:
            assignments.append(Assignment(at, "sign", code.whens[i]))
    g.keep("mode_limits", code.function("mode_limits", assignments))


def _predictions(g: Generator, code: BatchCode) -> None:
    """Segments of tables, those over sizes of slips among them, and crossings that time alone gives."""
    for i, sort in enumerate(code.events.sorts):
        first = code.offsets.switches[i]
        if code.law.switches[i].form is not None:
            g.force_switches += range(first, first + code.n)
        table = code.law.switches[i].table
        name = code.offsets.tables[table] if table is not None else ""
        if table is not None:
            g.table_switches.append((first, code.n, name))
        if code.law.switches[i].of_slip:
            g.slip_switches += range(first, first + code.n)
        timed = code.law.switches[i].level != MOVING
        if sort in ("affine", "general") and (timed or code.law.switches[i].at_zero is not None):
            exact = g.exact_timed if timed else g.exact_moving
            exact += range(first, first + code.n)
        if code.law.switches[i].at_zero == 0:
            g.strict_switches.append((first, code.n))
        if sort in ("line", "wave"):
            predictor, args = code.events.prediction(i)
            names = code.names(args)
            g.predictions.append(Prediction(names, predictor, [names.print(a) for a in args], first, code.n, name))
