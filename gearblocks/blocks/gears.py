"""Ideal gears."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.declare import Block, Contribution, Flange, Shows, Tie, exact, option


class IdealGear(Block):
    """Rigid gear pair without inertia: phi_a = ratio phi_b, both about the housing (the ground when not connected).

    Either ratio, or teeth=(za, zb) with external=True/False: ratio = zb/za, negative when external.
    """

    a, b = Flange("driving side"), Flange("driven side")
    housing = Flange("housing", ground=True)
    ratio: float | None = exact("phi_a/phi_b", default=None)
    teeth: tuple[int, int] | None = exact("tooth counts (za, zb)", default=None, many=True)
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


def teeth_problems(block: Any) -> Iterator[str]:
    """Tooth counts that are no two whole numbers > 0, and a missing external."""
    teeth = block.teeth
    if len(teeth) != 2 or any(int(z) != z or z <= 0 for z in teeth):
        yield f"teeth = {teeth!r} must be two whole numbers > 0"
    if not isinstance(block.external, bool):
        yield f"external = {block.external!r} must be True or False"
