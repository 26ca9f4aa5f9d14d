"""Heat port of an element: its heat flow is the power that it loses, at a temperature that its law may read.

Which masses there are, and what leads heat on, is not asked here (blocks/thermal.py).
"""

from __future__ import annotations

from typing import Any, ClassVar

from gearblocks.language.block import Block, Declared, Effect, field_values
from gearblocks.language.contributions import Shows
from gearblocks.language.expression import Expr
from gearblocks.language.fields import State, effect, signal
from gearblocks.language.signals import Signal


class HeatPort(Effect):
    """Heat port: what the element loses, in W, leaves it as heat at the temperature T.

        heat_flow = loss_power,    T: a number, an Input, an expression, or the ThermalMass that takes the heat

    T="disc" names the gb.ThermalMass "disc" of the train: the heat goes there, and its temperature is that of the element. Any
    other T is that of surroundings that take all heat. A signal of the element may contain gb.temperature, which is T. Outputs
    heat_flow [W] and temperature [K]; into a mass also heat [J], given off since the start, with what impacts lose at an
    instant. A block of a user's own takes one as `heat: gb.HeatPort | None = gb.effect("heat port")` and reads s.heat.T.

    Example:
        mu = 0.4 - 5e-4 * (gb.temperature - 293.15)
        clutch = gb.Clutch(mu=mu, force_max=2e3, geometry=0.1, engagement=1.0, heat=gb.HeatPort(T="disc"))
        disc = gb.ThermalMass(C=450.0, T0=293.15)
    """

    T: Signal = signal("temperature: a value, or the name of the ThermalMass that takes the heat", "K", ge=0, part="T")
    given = State("heat given off", "J", accumulates=True, symbol="Q")
    brings: ClassVar[tuple[Shows, ...]] = (
        Shows("heat_flow", 0, "W", "power lost, as heat flow"),
        Shows("temperature", 0, "K", "temperature of the heat port"),
        Shows("heat", 0, "J", "heat given off since the start, into a ThermalMass"),
    )

    def needed_by(self, block: Block) -> bool:
        """Whether a signal of the block contains gb.temperature."""
        return any(reads_temperature(value) for value in field_values(block).values())


HEAT: Any = effect("heat port: what is lost leaves as heat, at a temperature", default=None)


def reads_temperature(value: Any) -> bool:
    """Whether gb.temperature stands in a value, or in a signal of an effect."""
    if isinstance(value, Expr):
        return any(leaf.op == "local" and leaf.args[0] == "temperature" for leaf in value.leaves())
    return isinstance(value, Declared) and any(map(reads_temperature, field_values(value).values()))


def heat_port(block: Declared) -> tuple[str, HeatPort] | None:
    """Name and heat port of a block, or None where it has none."""
    for name in type(block).fields:
        value = block.__dict__[name]
        if type(value) is not float and isinstance(value, HeatPort):
            return name, value
    return None


def mass_of(temperature: Any) -> str:
    """The part whose temperature T it is, or the empty text."""
    if isinstance(temperature, Expr) and temperature.op == "sense" and temperature.args[0].endswith(".T"):
        return str(temperature.args[0].removesuffix(".T"))
    return ""
