"""Ideal gears."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Shows, Tie
from gearblocks.language.fields import Flange, exact, option


class IdealGear(Block):
    """Rigid gear pair without inertia: phi_a = ratio phi_b, both about the housing (the ground when not connected).

        a o---||        w_a = ratio w_b, torque: on b
              ||---o b

    On sliders it is a lever without mass (or a gear between racks): s_a = ratio s_b, both from its pivot, the housing.
    Either ratio, or teeth=(za, zb) with external=True/False: ratio = zb/za, negative when external.

    Example:
        rig = gb.Drivetrain("reduction")
        motor, load = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("load", gb.Inertia(J=0.1))
        rig.chain(rig.add("drive", gb.Torque(tau=1.0)), motor, rig.add("gear", gb.IdealGear(ratio=10)), load)
    """

    a, b = Flange("driving side", slider=None), Flange("driven side", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    ratio: float | None = exact("ratio phi_a/phi_b", default=None)
    teeth: tuple[int, int] | None = exact(
        "tooth counts (za, zb)", default=None, many=True, each=("number of teeth on a", "number of teeth on b")
    )
    external: bool | None = option("whether the teeth are outside on both", default=None)

    def problems(self) -> Iterator[str]:
        """Ratio and teeth together, or neither."""
        if (self.ratio is None) == (self.teeth is None):
            yield "give either ratio or teeth=(za, zb) with external=True or False"
        if self.teeth is not None:
            yield from teeth_problems(self)
        if self.ratio == 0:
            yield "ratio = 0 must not be 0"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie, and its torque on flange b."""
        ratio = s.ratio if self.teeth is None else s.teeth[1] / s.teeth[0] * (-1 if self.external else 1)
        yield Tie((s.a.phi - s.housing.phi) - ratio * (s.b.phi - s.housing.phi))
        yield Shows("torque", s.b.tau, "N m", "torque on flange b")


class IdealPlanetary(Block):
    """Rigid planetary set without inertia, seen from sun, carrier and ring (Willis 1841):

            |===|---o ring
            |-+-|---o carrier
            |===|---o sun

        phi_sun + ratio phi_ring = (1 + ratio) phi_carrier

    ratio = z_ring/z_sun of a simple set; a negative one is a set with two planets in mesh, other values belong to
    compound planets.

    Example:
        rig = gb.Drivetrain("planetary reduction")
        gear = rig.add("gear", gb.IdealPlanetary(ratio=78 / 42))
        motor, load = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("load", gb.Inertia(J=0.1))
        rig.connect(motor.b, gear.sun)
        rig.connect(gear.ring, rig.add("case", gb.Fixed()).flange)
        rig.connect(gear.carrier, load.a)
    """

    sun, carrier, ring = Flange("sun"), Flange("planet carrier"), Flange("ring")
    ratio: float | Fraction = exact("ratio z_ring/z_sun")

    def problems(self) -> Iterator[str]:
        """Ratios at which the set would be a plain coupling."""
        if self.ratio in (0, -1):
            yield f"ratio = {self.ratio!r} must be neither 0 nor -1 (carrier or ring would have no part in it)"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie of three shafts, and its torques on them."""
        yield Tie(s.sun.phi + s.ratio * s.ring.phi - (1 + s.ratio) * s.carrier.phi)
        for name in ("sun", "carrier", "ring"):
            yield Shows(f"torque_{name}", getattr(s, name).tau, "N m", f"torque on the {name}")


class Differential(Block):
    """Rigid differential without inertia: phi_left + phi_right = 2 phi_carrier / ratio.

                  o carrier
                  |
        left o---[+]---o right

    Example:
        rig = gb.Drivetrain("axle")
        axle = rig.add("axle", gb.Differential(ratio=3.5))
        left, right = rig.add("left", gb.Inertia(J=1.0)), rig.add("right", gb.Inertia(J=1.2))
        rig.connect(rig.add("drive", gb.Torque(tau=50.0)).flange, axle.carrier)
        rig.connect(axle.left, left.a)
        rig.connect(axle.right, right.a)
    """

    carrier, left, right = Flange("driven side"), Flange("left output"), Flange("right output")
    ratio: float = exact("ratio of phi_carrier to the mean of the outputs", default=1)

    def problems(self) -> Iterator[str]:
        """A ratio that means nothing."""
        if self.ratio == 0:
            yield "ratio = 0 must not be 0"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The tie of three shafts, and its torques on them."""
        yield Tie(s.left.phi + s.right.phi - 2 * s.carrier.phi / s.ratio)
        for name in ("carrier", "left", "right"):
            yield Shows(f"torque_{name}", getattr(s, name).tau, "N m", f"torque on the {name}")


def teeth_problems(block: Any) -> Iterator[str]:
    """Tooth counts that are no two whole numbers > 0, and a missing external."""
    teeth = block.teeth
    if len(teeth) != 2 or any(int(z) != z or z <= 0 for z in teeth):
        yield f"teeth = {teeth!r} must be two whole numbers > 0"
    if not isinstance(block.external, bool):
        yield f"external = {block.external!r} must be True (outside on both: they turn against each other) or False"
