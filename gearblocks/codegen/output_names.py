"""Names, units and words of outputs, states and start values, on turning shafts and on sliders."""

from __future__ import annotations

from collections.abc import Iterator

from gearblocks.assembly.assemble import GROUND_GROUP, expand_rows
from gearblocks.codegen.batch import BatchCode
from gearblocks.codegen.generator import Generator
from gearblocks.codegen.output_list import OutputGroup, Quantity
from gearblocks.codegen.program import (
    LOSSY,
    LOSSY_VARYING,
    POWER_INTO_FLANGE,
    DependentStart,
    HeatInfo,
    PrescribedStart,
    StartInfo,
)
from gearblocks.language.block import declared_state
from gearblocks.language.fields import ANGLE, SPEED, Unseen
from gearblocks.language.units import unit_along
from gearblocks.train.heat import has_heat, heat_paths
from gearblocks.train.translational import flange_names, slider_names, words_along


def shown(code: BatchCode, name: str, unit: str, words: str) -> OutputGroup:
    """One output of the blocks of a batch."""
    slides = bytes(c.slides for c in code.components)
    return _group(tuple(code.paths), (name, name), unit, words, slides)


def flange_outputs(g: Generator) -> Iterator[OutputGroup]:
    """Outputs of the flanges and the coordinates for reading, which follow the outputs of the blocks."""
    flanges, _ = flanges_of(g)
    owners = [tuple(f"{path}.{flange}" for path in code.paths) for code, flange in flanges]
    slides = [bytes(flange in c.sliders for c in code.components) for code, flange in flanges]
    for i, (unit, words) in enumerate((
        ("rad", "angle"), ("rad/s", "speed"), ("N m", "torque of the block on the flange"),
        ("W", POWER_INTO_FLANGE),
    )):  # fmt: skip
        names = flange_names(False)[i], flange_names(True)[i]
        yield from (_group(those, names, unit, words, which) for those, which in zip(owners, slides, strict=True))
    for coordinate in g.assembly.train.coordinates:
        yield _group((coordinate.name,), ("", ""), coordinate.unit, "relative coordinate", b"")


def _group(owners: tuple[str, ...], names: tuple[str, str], unit: str, words: str, slides: bytes) -> OutputGroup:
    """names: of what turns and of what slides; unit, words: of what turns."""
    turning, sliding = (
        Quantity(name, unit_along(unit, along), words_along(words, along))
        for name, along in zip(names, (False, True), strict=True)
    )
    return OutputGroup(owners, turning, sliding, slides if any(slides) else b"")


def flanges_of(g: Generator) -> tuple[list[tuple[BatchCode, str]], list[tuple[BatchCode, str]]]:
    """Batches with their flanges in the order of the outputs, and those that are no shafts and not shown."""
    both: tuple[list[tuple[BatchCode, str]], list[tuple[BatchCode, str]]] = [], []
    for code in g.codes:
        for flange in code.batch.flanges:
            kind = type(code.components[0].block)
            both[isinstance(kind.flanges[flange], Unseen)].append((code, flange))
    return both


def shown_bodies(code: BatchCode) -> list[str]:
    """The flanges of a batch at which its bodies are, those that the assembly added aside."""
    flanges = type(code.components[0].block).flanges
    return [flange for flange, _ in code.law.bodies if not isinstance(flanges[flange], Unseen)]


def state_quantities(g: Generator) -> list[Quantity]:
    """The states of the program without the quadratures."""
    lay = g.lay
    states: list[Quantity] = [Quantity("", "rad", "coordinate", "coordinate")] * lay.n
    for code in g.codes:
        for e, c in enumerate(code.components):
            for j in range(len(code.law.forms)):
                if code.batch.used[j] and not code.batch.dependent[j]:
                    unit, words = unit_along("rad", c.slides), words_along("relative angle", c.slides)
                    states[code.batch.sources[j][e]] = Quantity(f"{c.path}.coordinate", unit, words, "coordinate")
            for state in code.law.rates:
                kind = "sum" if declared_state(c.block, state).accumulates else "state"
                states[lay.state0[code.number, state] + e] = Quantity(f"{c.path}.{state}", "1", "state", kind)
    sliders = slider_names(g.assembly.train.components)
    for i, start in enumerate(g.assembly.starts[: g.assembly.n_speeds]):
        slides = start.w0 in sliders
        name, unit = f"{start.w0}.{flange_names(slides)[1]}", unit_along("rad/s", slides)
        states[lay.v0 + i] = Quantity(name, unit, "speed", "speed")
    if lay.angle0 < lay.n:
        for i, group in enumerate(g.assembly.angles):
            owner = g.assembly.starts[group].phi0
            slides = owner in sliders
            unit, words = unit_along("rad", slides), words_along("angle", slides)
            states[lay.angle0 + i] = Quantity(f"{owner}.{flange_names(slides)[0]}", unit, words, "angle")
    return states


def heat_infos(g: Generator) -> Iterator[HeatInfo]:
    """What the thermal column of the ledger adds up."""
    train = g.assembly.train
    if not has_heat(train.examples):
        return
    paths = {path.component: path for path in heat_paths({c.path: c.block for c in train.components})}
    for code in g.codes:
        for e, c in enumerate(code.components):
            if (path := paths.get(c.path)) is not None:
                offset = g.lay.state0[code.number, path.state] + e
                yield HeatInfo(c.path, offset, path.source, path.sink, path.is_loss)


def start_infos(g: Generator) -> Iterator[StartInfo]:
    """Names under which start values can be given: angle and speed of every body, states of blocks."""
    for code in g.codes:
        for flange in shown_bodies(code):
            groups, gains = code.batch.groups[flange], code.batch.gains[flange]
            for c, group, gain in zip(code.components, groups, gains, strict=True):
                if group != GROUND_GROUP and group < len(g.assembly.starts):
                    start, (angle, speed, _, _) = g.assembly.starts[group], flange_names(flange in c.sliders)
                    yield StartInfo(f"{c.path}.{angle}", g.lay.phi0[group], float(start.phi0_gain / gain), ANGLE)
                    if group < g.assembly.n_speeds:
                        yield StartInfo(f"{c.path}.{speed}", g.lay.w0[group], float(start.w0_gain / gain), SPEED)
        for state in code.law.rates:
            first = g.lay.state_start[code.number, state]
            for e in range(code.n):
                yield StartInfo(f"{code.paths[e]}.{state}", first + e, 1.0, "state")


def dependent_starts(g: Generator) -> Iterator[DependentStart]:
    """Start values of bodies on dependent shafts, by rigid constraints."""
    a, lay = g.assembly, g.lay
    expanded = expand_rows(a)
    for code in g.codes if expanded else ():
        for flange in shown_bodies(code):
            groups, gains = code.batch.groups[flange], code.batch.gains[flange]
            for c, group, gain in zip(code.components, groups, gains, strict=True):
                if group not in expanded or any(source >= len(a.starts) for source in expanded[group].groups):
                    continue
                row, (angle, speed, _, _) = expanded[group], flange_names(flange in c.sliders)
                offsets = {lay.path_of[path]: float(gain * x) for path, x in row.offsets.items()}
                phi = {lay.phi0[s]: float(gain * x / a.starts[s].phi0_gain) for s, x in row.groups.items()}
                yield DependentStart(f"{c.path}.{angle}", (*phi, *offsets), (*phi.values(), *offsets.values()), ANGLE)
                if all(s < a.n_speeds for s in row.groups):
                    w = {lay.w0[s]: float(gain * x / a.starts[s].w0_gain) for s, x in row.groups.items()}
                    yield DependentStart(f"{c.path}.{speed}", tuple(w), tuple(w.values()), SPEED)


def lossy_starts(g: Generator) -> Iterator[DependentStart]:
    """Slips of lossy ties at the start, which must be 0, over the start speeds of independent groups."""
    a, lay = g.assembly, g.lay
    expanded = expand_rows(a)
    for member in g.constraints.members:
        if member.law.kind != "tie":
            continue
        row: dict[int, float] = {}
        for group, value in member.row.items():
            for source, gain in expanded[group].groups.items() if group in expanded else ((group, 1),):
                row[source] = row.get(source, 0.0) + value * float(gain)
        if all(source < a.n_speeds for source in row):
            factors: dict[int, float] = {}
            for source, value in row.items():
                offset = lay.w0[source]
                factors[offset] = factors.get(offset, 0.0) + value / float(a.starts[source].w0_gain)
            least = 1e-12 * max(map(abs, row.values()), default=0.0)  # both sides may have one start value
            factors = {offset: x for offset, x in factors.items() if abs(x) > least}
            yield DependentStart(f"{member.path}.tie", tuple(factors), tuple(factors.values()), LOSSY)
        else:
            gains = tuple(1.0 / float(start.w0_gain) for start in a.starts[: a.n_speeds])
            offsets = tuple(lay.w0[source] for source in range(a.n_speeds))
            yield DependentStart(f"{member.path}.tie", offsets, gains, LOSSY_VARYING)


def prescribed_starts(g: Generator) -> Iterator[PrescribedStart]:
    """Start values of bodies on shafts with prescribed motion, or whose speed or angle a balance of torques gives."""
    causes = _causes(g)
    for code in g.codes if causes else ():
        for flange in shown_bodies(code):
            for c, group in zip(code.components, code.batch.groups[flange], strict=True):
                found = causes.get(group, {})
                names = flange_names(flange in c.sliders)
                if "speed" in found:
                    yield PrescribedStart(
                        f"{c.path}.{names[1]}", f"{c.path}.{flange}.{names[1]}", *found["speed"], SPEED
                    )
                if "angle" in found:
                    yield PrescribedStart(
                        f"{c.path}.{names[0]}", f"{c.path}.{flange}.{names[0]}", *found["angle"], ANGLE
                    )


def _causes(g: Generator) -> dict[int, dict[str, tuple[str, bool]]]:
    """By group: what moves its speed and its angle, in words, and whether a prescribed motion does."""
    a, massless = g.assembly, g.massless
    found: dict[int, dict[str, tuple[str, bool]]] = {}
    for i in range(a.n_massless):
        words = "the balance of torques at this shaft without inertia holds", False
        sprung = massless is not None and not massless.damped[i]
        found[a.n_speeds + i] = {"speed": words} | ({"angle": words} if sprung else {})
    for f in a.dependent_groups:
        causes: dict[str, tuple[str, bool]] = {}
        for source in f.sources:
            causes |= found.get(source, {})
        if f.prescribed is not None:
            words = f"'{f.prescribed.path}' moves", True
            causes = {"speed": words} | ({} if f.prescribed.by_speed else {"angle": words})
        if causes:
            found[f.group] = causes
    return found


def unknown_outputs(g: Generator) -> Iterator[tuple[str]]:
    """Outputs that read the acceleration of a massless group, which no equation gives."""
    massless = g.massless.rows if g.massless is not None else {}
    for code in g.codes if massless else ():
        roles = code.law.pool.roles
        for show, expr in code.shows:
            read = {roles[x].of for x in expr.free_symbols if x in roles and roles[x].role == "alpha"}
            for e, c in enumerate(code.components):
                if any(code.batch.groups[f][e] in massless for f in read if f in code.batch.groups):
                    yield (f"{c.path}.{show.name}",)
