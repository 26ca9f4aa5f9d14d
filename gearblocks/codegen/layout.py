"""Layout of the state vector and the parameter vector: offsets of coordinates, angles, states, speeds, start values.

Knows nothing of laws; hoisted terms, switches and the ledger get their offsets while code is generated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from itertools import count, groupby, repeat
from typing import TypeAlias

from gearblocks.assembly.assemble import GROUND_GROUP
from gearblocks.assembly.tables import Assembly, Batch
from gearblocks.codegen.program import InputInfo, ParameterInfo
from gearblocks.language.block import given_start
from gearblocks.language.expression import Expr, evaluate
from gearblocks.language.fields import ANGLE, RELATIVE_ANGLE, RELATIVE_SPEED, SPEED, Field
from gearblocks.language.signals import Input, Parameter
from gearblocks.language.units import parse_unit, unit_along
from gearblocks.train.graph import Component
from gearblocks.train.structure import Kind
from gearblocks.train.translational import field_along, slider_names, start_name, words_along
from gearblocks.train.values import numbers_of

PAD = 8


def padded(n: int) -> int:
    """n rounded up to whole blocks of the vectors."""
    return -(-n // PAD) * PAD


@dataclass(slots=True)
class Layout:
    """Offsets. v0: first speed; angle0: first absolute angle; columns of batches by (batch number, key)."""

    assembly: Assembly
    n_coordinates: int = 0
    angle0: int = 0
    state0: dict[tuple[int, str], int] = field(default_factory=dict)
    v0: int = 0
    n: int = 0
    n_padded: int = 0
    n_angles: int = 0
    quadratures0: int = 0
    n_total: int = 0
    parameters: list[ParameterInfo] = field(default_factory=list)
    own: dict[tuple[int, str], int] = field(default_factory=dict)
    shared: dict[str, int] = field(default_factory=dict)
    shared_objects: dict[str, Parameter] = field(default_factory=dict)
    inputs: dict[str, Input] = field(default_factory=dict)
    phi0: list[int] = field(default_factory=list)
    w0: list[int] = field(default_factory=list)
    state_start: dict[tuple[int, str], int] = field(default_factory=dict)
    path_of: dict[str, int] = field(default_factory=dict)


def lay_out(assembly: Assembly, *, angles_in_law: bool, n_wrapped: int = 0) -> Layout:
    """State vector and parameter vector; the rest follows while code is generated.

    n_wrapped: wrapped angles; each has a wrap count and the rounding carried over at the start of the quadratures.
    """
    lay = Layout(assembly)
    lay.n_coordinates = len(assembly.rows)
    at = lay.n_coordinates
    if angles_in_law:
        lay.angle0 = at
        at += len(assembly.angles)
    for b, batch in enumerate(assembly.batches):
        for state in batch.law.rates:
            lay.state0[b, state] = at
            at += len(batch.components)
    lay.v0 = at
    lay.n = at + assembly.n_speeds
    lay.n_padded = padded(lay.n + (1 if lay.n == 0 else 0))
    lay.n_angles = 2 * n_wrapped if angles_in_law else len(assembly.angles)
    if not angles_in_law:
        lay.angle0 = lay.n_padded
    lay.quadratures0 = lay.n_padded + lay.n_angles
    _parameters(lay)
    return lay


def is_start(batch: Batch, spec: Field) -> bool:
    """Whether an own number of a block is a start value: a relative one, or where the block has a body."""
    return spec.start in (RELATIVE_ANGLE, RELATIVE_SPEED) or (bool(batch.law.bodies) and spec.start is not None)


def _own_numbers(batch: Batch, kind: Kind) -> list[tuple[str, Field]]:
    """(path inside the block, field) of every tunable number of a kind, start values aside."""
    return [
        (path, spec)
        for path, value, spec in kind.numbers(kind.example)
        if spec.role in ("param", "signal") and isinstance(value, (int, float)) and not is_start(batch, spec)
    ]


def _parameters(lay: Layout) -> None:
    train = lay.assembly.train
    for b, batch in enumerate(lay.assembly.batches):
        columns: dict[str, list[tuple[Component, Field]]] = {}
        own: dict[Kind, list[tuple[list[tuple[Component, Field]], Field]]] = {}
        for index in batch.components:
            owner, kind = train.components[index], train.kinds[index]
            if kind not in own:
                own[kind] = [(columns.setdefault(path, []), spec) for path, spec in _own_numbers(batch, kind)]
            for column, spec in own[kind]:
                column.append((owner, spec))
        for path, entries in columns.items():
            lay.own[b, path] = len(lay.parameters)
            for (_, slides), alike in groupby(entries, key=lambda entry: (id(entry[1]), entry[0].slides)):
                some = list(alike)
                info = _info(field_along(some[0][1], slides), tunable=True)
                _add_all(lay, [f"{owner.path}.{path}" for owner, _ in some], info)
    for kind in dict.fromkeys(train.kinds):
        for leaf in kind.leaves:
            if isinstance(leaf, Parameter):
                lay.shared_objects.setdefault(leaf.name, leaf)
            else:
                lay.inputs.setdefault(leaf.name, leaf)
    for expr in train.coordinates:
        for found in expr.expr.leaves():
            if found.op == "parameter":
                lay.shared_objects.setdefault(found.args[0].name, found.args[0])
    narrowest = _shared_bounds(lay)
    for name, parameter in sorted(lay.shared_objects.items()):
        lay.shared[name] = len(lay.parameters)
        gt, ge, lt, le = narrowest.get(name, (None, None, None, None))
        unit = parse_unit(parameter.unit)
        spec = Field(f"parameter {name}", unit.si, "param", gt=gt, ge=ge, lt=lt, le=le)
        _add(lay, name, _info(spec, tunable=True, given_in="" if unit.is_coherent else unit.text))
    _start_values(lay)


def input_info(x: Input) -> InputInfo:
    """The entry of an input."""
    unit = parse_unit(x.unit)
    return InputInfo(x.name, unit.si, x.si, "" if unit.is_coherent else unit.text)


Bounds: TypeAlias = tuple[float | None, float | None, float | None, float | None]
"""Of a field: gt, ge, lt, le."""


def _shared_bounds(lay: Layout) -> dict[str, Bounds]:
    """The narrowest bounds of the fields that each Parameter stands in by itself, or with numbers that it is multiplied by."""
    found: dict[str, list[Bounds]] = {}
    if not lay.shared_objects:
        return {}
    for c in lay.assembly.train.components:
        for _, value, spec in numbers_of(c.block, ""):
            if isinstance(value, Parameter):
                found.setdefault(value.name, []).append((spec.gt, spec.ge, spec.lt, spec.le))
            elif isinstance(value, Expr) and value.op == "*" and (one := _multiple(value, spec)) is not None:
                found.setdefault(one[0], []).append(one[1])
    return {name: _narrowest(bounds) for name, bounds in found.items()}


def _multiple(value: Expr, spec: Field) -> tuple[str, Bounds] | None:
    """The Parameter of a product with numbers, and what of the bounds holds for it too: those that are 0."""
    leaves = [x for x in value.args if x.op == "parameter"]
    numbers = [evaluate(x, lambda _: math.nan) for x in value.args if not any(True for _ in x.leaves())]
    factor = math.prod(numbers)
    if len(leaves) != 1 or len(numbers) != len(value.args) - 1 or factor == 0:
        return None
    gt, ge, lt, le = (0.0 if x == 0 else None for x in (spec.gt, spec.ge, spec.lt, spec.le))
    return leaves[0].args[0].name, (gt, ge, lt, le) if factor > 0 else (lt, le, gt, ge)


def _narrowest(bounds: list[Bounds]) -> Bounds:
    gt, ge, lt, le = ([x for x in values if x is not None] for values in zip(*bounds, strict=True))
    return max(gt, default=None), max(ge, default=None), min(lt, default=None), min(le, default=None)


def _info(spec: Field, *, tunable: bool, start: str = "", given_in: str = "") -> ParameterInfo:
    """The entry of a number of a field, without its path."""
    open_lower = spec.gt is not None and (spec.ge is None or spec.gt >= spec.ge)
    open_upper = spec.lt is not None and (spec.le is None or spec.lt <= spec.le)
    lower, upper = (spec.gt if open_lower else spec.ge), (spec.lt if open_upper else spec.le)
    return ParameterInfo(
        "", spec.unit, spec.words, lower, upper, tunable, start, open_lower, open_upper, given_in, spec.why
    )


def _add_all(lay: Layout, paths: list[str], info: ParameterInfo) -> None:
    """Gives alike numbers their offsets."""
    lay.path_of.update(zip(paths, count(len(lay.parameters)), strict=False))
    lay.parameters += map(ParameterInfo._make, zip(paths, *map(repeat, info[1:]), strict=False))


def _add(lay: Layout, path: str, info: ParameterInfo) -> int:
    """Gives a number its offset."""
    offset = lay.path_of[path] = len(lay.parameters)
    lay.parameters.append(ParameterInfo(path, *info[1:]))
    return offset


@cache
def _start_info(words: str, unit: str, of: str, slides: bool) -> ParameterInfo:
    """The entry of a start value: one for all blocks that have it."""
    return _info(Field(words_along(words, slides), unit_along(unit, slides), "param"), tunable=False, start=of)


def _start_values(lay: Layout) -> None:
    """Start angle and speed of every group, start of every state of a block."""
    blocks = {c.path: c.block for c in lay.assembly.train.components}
    sliders = slider_names(lay.assembly.train.components)
    known: dict[str, int] = {}
    for group, start in enumerate(lay.assembly.starts):
        wanted = [(start.phi0, ANGLE, "rad", "start angle", lay.phi0)]
        if group < lay.assembly.n_speeds:
            wanted.append((start.w0, SPEED, "rad/s", "start speed", lay.w0))
        for path, of, unit, words, target in wanted:
            slides = path in sliders
            given = given_start(blocks[path], of) if path in blocks else None
            if isinstance(given, Parameter):
                target.append(lay.shared[given.name])
            else:
                name = f"{path}.{start_name(blocks.get(path), of, slides)}"
                if name not in known:  # both sides of a lossy gear may start as one body says
                    known[name] = _add(lay, name, _start_info(words, unit, of, slides))
                target.append(known[name])
    for b, batch in enumerate(lay.assembly.batches):
        for state in batch.law.rates:
            lay.state_start[b, state] = len(lay.parameters)
            for index in batch.components:
                c = lay.assembly.train.components[index]
                unit = "1" if "." in state else type(c.block).states[state].unit
                _add(lay, f"{c.path}.{state}", _start_info("start value", unit, "state", c.slides))


def speed_index(lay: Layout, batch: Batch, flange: str) -> list[int]:
    """Where the speed of a flange lies in the state vector, per instance (flanges at the ground have none)."""
    return [0 if g == GROUND_GROUP else lay.v0 + g for g in batch.groups[flange]]
