"""Heat of a law: heat flow = power lost, counted by a state of the heat port where it goes into a thermal mass.

    given' = loss + share lambda slip  (of a lossy tie, by its constraint force lambda),   given += loss of an impact

Knows nothing of masses, nor of temperatures of a train.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import sympy as sp

from gearblocks.language.block import Block
from gearblocks.language.heat import heat_port, mass_of
from gearblocks.laws.law import Law
from gearblocks.laws.switched_constraints import constraint_loss


def add_heat(law: Law, block: Block, s: Any) -> None:
    """Heat flow, temperature and heat of a block with a heat port, as outputs and a state."""
    port = heat_port(block)
    if port is None:
        return
    name, values = port[0], getattr(s, port[0])
    pool, lost = law.pool, law.loss if law.loss is not None else sp.Integer(0)
    by_force = constraint_loss(pool, law.constraints)
    flow, temperature, heat = port[1].brings
    law.shows.append(replace(flow, expr=lost if by_force is None else lost + by_force))
    law.shows.append(replace(temperature, expr=values.T))
    if not mass_of(port[1].T):
        return
    law.heat = f"{name}.given"
    law.rates[law.heat] = _whole_loss(law, lost) if pool.reading else lost
    law.shows.append(replace(heat, expr=values.given))


def _whole_loss(law: Law, lost: Any) -> Any:
    """The power lost, in the friction forces that equations for people name."""
    pool = law.pool
    directions = {x for x in lost.free_symbols if pool.roles[x].role == "direction"}
    smooth = lost.xreplace(dict.fromkeys(directions, sp.Integer(0)))
    forces = {k.name: pool.symbol("friction", k.name, f"T_{k.name}".rstrip("_")) for k in law.constraints.values()}
    return smooth - sp.Add(
        *(forces[k.name] * k.slip for k in law.constraints.values() if not k.is_stop and k.share is None)
    )
