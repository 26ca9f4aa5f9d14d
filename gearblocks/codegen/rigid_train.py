"""The rigid train: angles of bodies, slips and deflections of compliant elements as forms over the angles of groups of shafts.

    phi_body, slip = sum of c phi_g,    deflection = sum of c phi_g + sum of d p    (p: angles at which the ground holds)

Groups that rigid constraints determine are put in. For starts in which the train turns as one piece. Knows nothing of values.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

from gearblocks.assembly.assemble import expand_rows
from gearblocks.assembly.elimination import Combination
from gearblocks.assembly.tables import GROUND_GROUP
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.output_names import shown_bodies
from gearblocks.codegen.program import UNKNOWN, AlgebraicSlip, GroupStart, RigidRow
from gearblocks.language.block import given_start
from gearblocks.language.fields import ACCELERATION, ANGLE, COMPLIANCE, RELATIVE_ANGLE, RELATIVE_SPEED, SPEED
from gearblocks.language.signals import Parameter
from gearblocks.laws.algebraic_friction import slip_laws
from gearblocks.laws.rational import Exact, exact_value
from gearblocks.train.graph import Component
from gearblocks.train.translational import flange_names

_Form: TypeAlias = "tuple[tuple[int, ...], tuple[float, ...], tuple[int, ...], tuple[float, ...]]"
"""Groups and offsets with their factors, as in a RigidRow."""


def group_starts(g: Generator) -> Iterator[GroupStart]:
    """Every group, by number."""
    a, lay = g.assembly, g.lay
    dependent = {f.group: f for f in a.dependent_groups}
    shown = _shown(g) if a.dependent_groups else {}
    varying: set[int] = set()
    for f in a.dependent_groups:
        if (f.prescribed is not None and f.sources) or not varying.isdisjoint(f.sources):
            varying.add(f.group)
    for group in range(a.n_groups):
        start = a.starts[group] if group < len(a.starts) else None
        output, gain = shown.get(group, ("", 1.0))
        own = dependent.get(group)
        yield GroupStart(
            -1 if start is None or group in a.force_unknowns else lay.phi0[group],
            1.0 if start is None else float(start.phi0_gain),
            lay.w0[group] if group < a.n_speeds else -1,
            float(a.starts[group].w0_gain) if group < a.n_speeds else 1.0,
            output,
            gain,
            own is not None and own.prescribed is not None,
            group in varying,
        )


def _shown(g: Generator) -> Mapping[int, tuple[str, float]]:
    """By group: the speed of a flange in it, and the gain of that."""
    found: dict[int, tuple[str, float]] = {}
    for code in g.codes:
        for flange in code.batch.flanges:
            groups, gains = code.batch.groups[flange], code.batch.gains[flange]
            for c, group, gain in zip(code.components, groups, gains, strict=True):
                speed = flange_names(flange in c.sliders)[1]
                found.setdefault(group, (f"{c.path}.{flange}.{speed}", float(gain)))
    return found


def body_rows(g: Generator) -> Iterator[RigidRow]:
    """The angle of every body."""
    expanded = expand_rows(g.assembly)
    for code in g.codes:
        for flange in shown_bodies(code):
            groups, gains = code.batch.groups[flange], code.batch.gains[flange]
            for c, group, gain in zip(code.components, groups, gains, strict=True):
                if group == GROUND_GROUP:
                    continue
                angle, speed, _, _ = flange_names(flange in c.sliders)
                given = (given_start(c.block, of) is not None for of in (ANGLE, SPEED, ACCELERATION))
                row = _scaled(g, expanded[group], gain) if group in expanded else ((group,), (float(gain),), (), ())
                yield RigidRow(c.path, *row, f"{c.path}.{angle}", f"{c.path}.{speed}", *given)


def deflection_rows(g: Generator) -> Iterator[RigidRow]:
    """The relative angle of every compliant element, as far as it is linear in the angles."""
    a = g.assembly
    for code in g.codes:
        used = [j for j in range(len(code.law.forms)) if code.batch.used[j]]
        for e, index in enumerate(code.batch.components if used else ()):
            c = a.train.components[index]
            if COMPLIANCE not in a.train.kinds[index].effects(c.block):
                continue
            for j in used:
                source = code.batch.sources[j][e]
                if code.batch.dependent[j]:
                    row = _parts(g, *_over_groups(g, a.dependents[source]))
                else:
                    row = _parts(g, a.rows[source], a.row_offsets[source])
                more: dict[str, Any] = {**_natural(g, c, code, j), **_given(c, j)}
                yield RigidRow(c.path, *row, varying=c.block.ratio_varies(), **more)


def _given(c: Component, j: int) -> dict[str, Any]:
    """Which start values an element gives of its first deflection."""
    roles = {"gives_angle": RELATIVE_ANGLE, "gives_speed": RELATIVE_SPEED} if j == 0 else {}
    return {what: given_start(c.block, of) is not None for what, of in roles.items()}


def _natural(g: Generator, c: Component, code: BatchCode, j: int) -> dict[str, Any]:
    """Where an element carries nothing: of its first deflection, which is scale times the coordinate."""
    fields = c.block.undeformed() if j == 0 else {}
    if not fields:
        return {}
    found: dict[str, Any] = {"scale": 1.0 / float(code.law.forms[0].scale)}
    for what, field in fields.items():
        value = c.block.__dict__[field]
        if isinstance(value, Parameter):
            found[what] = g.lay.shared[value.name]
        else:
            found[what] = g.lay.path_of.get(f"{c.path}.{field}", UNKNOWN)
    return found


def slip_rows(g: Generator) -> Iterator[RigidRow]:
    """The slip of every switched constraint, by number; of stops the gap."""
    expanded = expand_rows(g.assembly) if g.constraints.members else {}
    for member in g.constraints.members:
        form = Combination()
        for group, value in member.row.items():
            form.add(expanded.get(group, Combination({group: 1})), value)  # type: ignore[arg-type]  # floats
        yield RigidRow(member.path, *_parts(g, form.groups, form.offsets))


def algebraic_slips(g: Generator) -> Iterator[AlgebraicSlip]:
    """The slips of ties and friction whose forces are algebraic."""
    if not g.assembly.force_unknowns:
        return
    expanded = expand_rows(g.assembly)
    for code in g.codes:
        batch = code.batch
        flanges = type(code.components[0].block).flanges
        for law in slip_laws(code.law, flanges):
            numbers = (law.forward, law.backward, law.engaged)
            forward, backward, engaged = (None if i is None else code.offsets.switches[i] for i in numbers)
            for e, path in enumerate(code.paths):
                form = Combination()
                for flange, expr in law.row.items():
                    group = batch.groups[flange][e]
                    if group != GROUND_GROUP:
                        gain = exact_value(expr, {s: v[e] for s, v in batch.exact.items()}) * batch.gains[flange][e]
                        form.add(expanded.get(group, Combination({group: 1})), gain)
                groups, factors, _, _ = _parts(g, form.groups, form.offsets)
                switches = (-1 if x is None else x + e for x in (forward, backward, engaged))
                pressed = tuple(
                    g.lay.shared[x.of] if x.role == "shared" else g.lay.path_of[f"{path}.{x.of}"] for x in law.pressed
                )
                yield AlgebraicSlip(path, groups, factors, law.tie, tuple(switches), pressed)


def _scaled(g: Generator, form: Combination, gain: Exact) -> _Form:
    whole = Combination()
    whole.add(form, gain)
    return _parts(g, whole.groups, whole.offsets)


def _over_groups(g: Generator, form: Combination) -> tuple[Mapping[int, Exact], Mapping[str, Exact]]:
    """A form over coordinates, over groups and offsets."""
    whole = Combination(dict(form.groups), {}, dict(form.offsets))
    for source, factor in form.coordinates.items():
        whole.add(Combination(dict(g.assembly.rows[source]), {}, dict(g.assembly.row_offsets[source])), factor)
    return whole.groups, whole.offsets


def _parts(g: Generator, groups: Mapping[int, Exact], offsets: Mapping[str, Exact]) -> _Form:
    places = tuple([g.lay.path_of[path] for path in offsets])
    return tuple(groups), tuple(map(float, groups.values())), places, tuple(map(float, offsets.values()))
