"""The laws of a train over lanes: many points of a study side by side in vectors (templates/lanes.c.jinja).

For trains whose sides follow from the state alone: nothing sticks, no switch of time, no group depends on others.
Sides are selects there, with the bits of the scalar code that locates nothing. Knows nothing of how lanes are stepped.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gearblocks.codegen.generator import Generator
from gearblocks.codegen.operands import Operand, Role

_WIDEST = 64  # numbers in the state vector: beyond, lanes fill the cache and gain nothing
FUNCTIONS = ("rates", "event_functions", "torques", "inertia_torques", "outputs")
"""Groups of functions that lanes call."""


def has_lanes(g: Generator) -> bool:
    """Whether the train can be stepped in lanes."""
    simple = g.assembly.plain and not (g.constraints.members or g.massless or g.wrapping.wrapped or g.feedback)
    sided = g.n_surfaces == len(g.switches) and not g.functions.get("update_states")
    timed = _read_modes(g, "time_terms", "output_time_terms")
    return simple and sided and not (timed or g.tables or g.maps) and g.lay.n_total <= _WIDEST


def _read_modes(g: Generator, *groups: str) -> bool:
    return any(Role.MODES in f.read for what in groups for f in g.functions.get(what, []))


def lane_values(g: Generator, values: Mapping[str, Any]) -> dict[str, Any]:
    """What the template names, beside what that of the model does."""
    functions = [f for what in FUNCTIONS for f in g.functions.get(what, [])]
    first, count = (
        values["first_flange_output"],
        values["flanges"]["count"],
    )  # of flanges: angles, speeds, torques, powers
    return {
        **values,
        "lane_functions": functions,
        "columns": list({x.column.name: x for f in functions for x in f.tables}.values()),
        "long_table": lambda *_: None,  # nothing writes tables out here: all stand in the text
        "reads_angles": _readers(g, Role.ANGLES, range(first, first + count)),
        "reads_torques": _readers(g, Role.FLANGE_TORQUES, range(first + 2 * count, first + 4 * count)),
        "where_torques_are_read": "if (is_read(reads_torques))\n        ",
        "modes_read": _read_modes(g, "event_functions"),
        "small": False,
        "lanes_only": True,
        "real": "gb_lane",
        "number": _number,
    }


def _readers(g: Generator, role: Role, flanges: range) -> list[int]:
    """By output: 1 where it reads this vector; flanges: those of the flanges that do."""
    reads = [0] * len(g.outputs)
    for f in g.functions.get("outputs", []):
        stored = [s.target for s in f.body if isinstance(s.target, Operand)]
        for target in stored if role in f.roles else ():
            first = int(target.offset)
            reads[first : first + f.count] = [1] * f.count
    reads[flanges.start : flanges.stop] = [1] * len(flanges)
    return reads


def _number(text: str) -> str:
    """C of an expression as a vector: a plain number is one in all lanes."""
    try:
        float(text)
    except ValueError:
        return text
    return f"gb_all({text})"
