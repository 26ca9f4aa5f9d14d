"""Lumped thermal network: masses that store heat, and what conducts it between them and the surroundings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Rate, Shows
from gearblocks.language.fields import State, param, signal
from gearblocks.language.signals import Signal, Value


class ThermalMass(Block):
    """Lumped heat capacity: C dT/dt = sum of all heat flows into it, T = T0 + heat/C.

    Heat comes from every element with heat=gb.HeatPort(T="its name") and through every gb.ThermalConductance that names it;
    heat [J] is their sum since the start. Knows nothing of temperatures within the body, nor of phase changes.
    received: heat from elsewhere, besides.

    Example:
        rig = gb.Drivetrain("stop on a disc brake")
        wheel, disc = rig.add("wheel", gb.Inertia(J=2.0, w0=100.0)), rig.add("disc", gb.ThermalMass(C=450.0, T0="293.15 K"))
        rig.chain(wheel, rig.add("brake", gb.Brake(capacity=200.0, heat=gb.HeatPort(T="disc"))))
        rig.add("air", gb.ThermalConductance(G=5.0, a="disc", b=293.15))
        print(gb.simulate(rig, t_end=2.0)["disc.T"][-1])
    """

    C: Value = param("heat capacity", "J/K", gt=0)
    T0: Value = param("temperature at the start", "K", default=293.15, ge=0)
    received: Signal | None = signal("heat received from elsewhere since the start", "J", default=None, symbol="Q")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Its temperature, from the heat that states of other parts count."""
        import sympy as sp

        heat = sp.Integer(0) if self.received is None else s.received
        yield Shows("T", s.named("T", s.T0 + heat / s.C, "temperature", "K"), "K", "temperature")
        yield Shows("rise", heat / s.C, "K", "temperature above that at the start")
        yield Shows("T_start", s.T0, "K", "temperature at the start")
        yield Shows("heat", heat, "J", "heat received since the start")


class ThermalConductance(Block):
    """Thermal conductance, of a wall, a contact or a surface in air: heat_flow = G (T_a - T_b) from a to b.

    a, b: each the name of a ThermalMass, or a temperature: a number, an Input, an expression. G may be a signal, as where
    a turning disc fans itself: G=gb.sense("disc.w")*0.1. at_start, since: T_a - T_b in two parts, which a train fills in for
    its masses, so that a small rise is not lost in the rounding of two temperatures near 300 K.

    Example:
        rig = gb.Drivetrain("two bodies")
        disc, hub = rig.add("disc", gb.ThermalMass(C=450.0, T0=400.0)), rig.add("hub", gb.ThermalMass(C=900.0))
        rig.add("contact", gb.ThermalConductance(G=3.0, a="disc", b="hub"))
    """

    G: Signal = signal("thermal conductance", "W/K", ge=0)
    a: Signal = signal("one temperature: a value, or the name of a ThermalMass", "K", ge=0, part="T")
    b: Signal = signal("the other temperature: a value, or the name of a ThermalMass", "K", ge=0, part="T")
    at_start: Signal | None = signal(
        "difference of the temperatures at the start", "K", default=None, symbol="vartheta_0"
    )
    since: Signal | None = signal("what it has grown by since", "K", default=None, symbol="vartheta")
    passed = State("heat passed on", "J", accumulates=True, symbol="Q")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The heat flow and its sum."""
        whole = s.reading or self.at_start is None or self.since is None
        flow = s.G * (s.a - s.b) if whole else s.G * s.at_start + s.G * s.since
        flow = s.named("q", flow, "heat flow from a to b", "W")
        yield Rate(s.passed, flow)
        yield Shows("heat_flow", flow, "W", "heat flow from a to b")
        yield Shows("heat", s.passed, "J", "heat passed from a to b since the start")
