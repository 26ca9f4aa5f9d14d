"""Heat in a train: which masses the heat of ports and conductances goes to, as signals of the blocks.

A ThermalMass receives the sum of what names it. Knows nothing of laws.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from gearblocks.blocks.thermal import ThermalConductance, ThermalMass
from gearblocks.errors import ModelError, did_you_mean
from gearblocks.language.block import Block
from gearblocks.language.expression import Expr, as_expr, number
from gearblocks.language.heat import heat_port, mass_of


class HeatPath(NamedTuple):
    """Heat that a state of a component counts: from a mass to a mass; "": surroundings, or with is_loss the component."""

    component: str
    state: str
    source: str
    sink: str
    is_loss: bool = False


def has_heat(blocks: Iterable[Block]) -> bool:
    """Whether any of these has to do with heat."""
    return any(isinstance(x, (ThermalMass, ThermalConductance)) or heat_port(x) is not None for x in blocks)


def heat_paths(blocks: Mapping[str, Block]) -> Iterator[HeatPath]:
    """All heat that goes to or comes from a ThermalMass, or passes a conductance. blocks: by path."""
    masses = {path for path, block in blocks.items() if type(block) is ThermalMass}
    for path, block in blocks.items():
        if type(block) is ThermalConductance:
            ends = [x if (x := mass_of(block.__dict__[end])) in masses else "" for end in ("a", "b")]
            yield HeatPath(path, "passed", ends[0], ends[1])
        elif (port := heat_port(block)) is not None and (mass := mass_of(port[1].T)):
            yield HeatPath(path, f"{port[0]}.given", "", mass, is_loss=True)


def receiving(blocks: Mapping[str, Block]) -> dict[str, Block]:
    """The masses by path, each with the heat that it receives, and the conductances beside them, with the difference of
    temperatures in two parts. ModelError where a port names what is no ThermalMass."""
    masses = {path for path, block in blocks.items() if type(block) is ThermalMass}
    received: dict[str, Any] = {}
    problems = []
    for path in heat_paths(blocks):
        amount = Expr("sense", f"{path.component}.heat")
        for mass, part in ((path.sink, amount), (path.source, -amount)):
            if mass in masses:
                received[mass] = part if mass not in received else received[mass] + part
            elif mass:
                problems.append(_no_mass(path.component, mass, masses))
    if problems:
        raise ModelError(problems)
    found: dict[str, Block] = {}
    for mass, heat in received.items():
        other = blocks[mass].__dict__["received"]
        found[mass] = blocks[mass].changed(received=heat if other is None else as_expr(other) + heat)
    for name, block in blocks.items():
        if type(block) is ThermalConductance and any(mass_of(block.__dict__[end]) in masses for end in ("a", "b")):
            (start_a, rise_a), (start_b, rise_b) = (_parts(block.__dict__[end], masses) for end in ("a", "b"))
            found[name] = block.changed(at_start=start_a - start_b, since=rise_a - rise_b)
    return found


def _parts(temperature: Any, masses: Collection[str]) -> tuple[Expr, Expr]:
    """A temperature at the start, and its rise since; of what is no mass, the whole and nothing."""
    mass = mass_of(temperature)
    if mass not in masses:
        return as_expr(temperature), number(0.0)
    return Expr("sense", f"{mass}.T_start"), Expr("sense", f"{mass}.rise")


def _no_mass(component: str, mass: str, masses: Collection[str]) -> str:
    known = f"; there are {', '.join(sorted(masses))}" if masses else "; there is none"
    return (
        f"'{component}': its heat port has the temperature of '{mass}', which is no ThermalMass of this train"
        f"{known}{did_you_mean(mass, masses)}"
    )
