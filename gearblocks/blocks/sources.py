"""Sources and loads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.declare import Acts, Block, Contribution, Energy, Flange, Shows, param, signal
from gearblocks.signals import Value


class Torque(Block):
    """A given torque on the flange, its reaction on the housing (the ground when not connected)."""

    flange = Flange("driven flange")
    housing = Flange("housing", ground=True)
    tau: Any = signal("torque on the flange", "N m")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Action and reaction."""
        yield Acts(s.flange, s.tau)
        yield Acts(s.housing, -s.tau)
        yield Shows("torque", s.tau, "N m", "torque on the flange")


class SpeedLoad(Block):
    """A load that opposes motion: tau = -sign(w) (c0 + c1 abs(w) + c2 w^2), coeffs = (c0, c1, c2).

    On a slider w is its speed in m/s and tau a force in N.

    Valid while the shaft turns: at w = 0 the constant part c0 jumps from one sign to the other and does not hold the
    shaft at rest.
    """

    flange = Flange("loaded flange", slider=None)
    coeffs: tuple[Value, Value, Value] = param("(c0, c1, c2)", "N m (rad/s)^-i", ge=0, many=True)

    def problems(self) -> Iterator[str]:
        """A wrong number of coefficients."""
        if not isinstance(self.coeffs, tuple) or len(self.coeffs) != 3:
            yield f"coeffs = {self.coeffs!r} must be three numbers (c0, c1, c2)"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The opposing torque; all its power is lost."""
        import sympy as sp

        w = s.flange.w
        c0, c1, c2 = s.coeffs
        against = sp.sign(w) * (c0 + c1 * sp.Abs(w) + c2 * w**2)
        yield Acts(s.flange, -against)
        yield Energy(loss=against * w)
        yield Shows("torque", -against, "N m", "torque on the flange")
        yield Shows("loss_power", against * w, "W", "power taken")
