"""Sliders: bodies, racks and forces along a line."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.language import contributions
from gearblocks.language.block import Block
from gearblocks.language.contributions import Acts, Body, Contribution, Shows, Tie
from gearblocks.language.fields import Flange, exact, option, param, signal
from gearblocks.language.signals import Signal, Value


class Mass(Block):
    """A rigid sliding body; both flanges have the same position.

        a o---[ m ]---o b        s = s_a = s_b

    s0, v0: start values. Left out, they follow from tied neighbours, else they are 0. a0: start acceleration, as alpha0 of
    `Inertia`. small: as of `Inertia`.

    Example:
        rig = gb.Drivetrain("sledge")
        rig.chain(rig.add("push", gb.Force(f="20 N")), rig.add("sledge", gb.Mass(m="5 kg", v0=0.5)))
    """

    a, b = Flange("left end", spare=True, slider=True), Flange("right end", spare=True, slider=True)
    m: Value = param("mass", "kg", ge=0)
    s0: Value | None = param("start position", "m", default=None, start="angle")
    v0: Value | None = param("start speed", "m/s", default=None, start="speed")
    a0: Value | None = param("start acceleration", "m/s2", default=None, start="acceleration")
    small: bool = option("whether it may be lumped into its neighbour", default=False, belongs_to="inertia")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """m s'' = sum of the forces on both flanges."""
        yield Body(s.a, s.m)
        yield Tie(s.a.s - s.b.s)
        yield Shows("s", s.a.s, "m", "position")
        yield Shows("v", s.a.v, "m/s", "speed")
        yield Shows("acceleration", s.a.alpha, "m/s2", "acceleration")
        yield Shows("kinetic_energy", s.m * s.a.v**2 / 2, "J", "kinetic energy")


class Rack(Block):
    """Rack and pinion, or a wheel that rolls without slip: s = radius phi. A negative radius turns the other way.

           o flange
           |
          (+)---# housing
        =======---o slider
         # frame

    phi is the angle against the housing of the pinion, s the position against the frame (both the ground when not
    connected): s_slider - s_frame = radius (phi_flange - phi_housing). force is what the rack exerts on its slider; the
    flange gets -radius force, housing and frame the opposite of either.

    Example:
        rig = gb.Drivetrain("steering")
        pinion, rack = rig.add("pinion", gb.Inertia(J=1e-4)), rig.add("rack", gb.Rack(radius=0.01))
        rig.connect(rig.add("hand", gb.Torque(tau=1.0)).flange, pinion.a)
        rig.connect(pinion.b, rack.flange)
        rig.connect(rack.slider, rig.add("rod", gb.Mass(m=2.0)).a)
    """

    flange = Flange("pinion or wheel")
    slider = Flange("rack, or the axle of the wheel", slider=True)
    housing = Flange("housing of the pinion", ground=True)
    frame = Flange("frame that the rack slides in, or the road", ground=True, slider=True)
    radius: float = exact("rolling radius ds/dphi", "m")

    def problems(self) -> Iterator[str]:
        """A radius of zero."""
        if self.radius == 0:
            yield "radius = 0 m must not be 0: the slider could not move"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie, and its force on the slider."""
        yield Tie((s.slider.s - s.frame.s) - s.radius * (s.flange.phi - s.housing.phi))
        yield Shows("force", s.slider.f, "N", "force on the slider")


class Force(Block):
    """A given force on a slider, its reaction on the housing (the ground when not connected): Force(f=...).

        housing #---(->)---o flange        positive f pushes forward

    With a deflection and a force it is the contribution that laws yield: `yield Force(deflection, force)`.

    Example:
        rig = gb.Drivetrain("oscillator")
        push, mass = rig.add("push", gb.Force(f=10.0 * gb.sin(50 * gb.time))), rig.add("mass", gb.Mass(m=2.0))
        rig.chain(push, mass, rig.add("spring", gb.Shaft(k=5e3, c=2.0)), rig.add("ground", gb.Fixed()))
    """

    flange = Flange("driven slider", slider=True)
    housing = Flange("housing", ground=True, slider=True)
    f: Signal = signal("force on the slider", "N")

    def __new__(cls, *values: Any, **named: Any) -> Any:
        """The block, or the contribution of a law."""
        if cls is Force and (len(values) > 1 or {"deflection", "force"} & set(named)):
            return contributions.Force(*values, **named)
        return super().__new__(cls)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Action and reaction."""
        yield Acts(s.flange, s.f)
        yield Acts(s.housing, -s.f)
        yield Shows("force", s.f, "N", "force on the slider")
