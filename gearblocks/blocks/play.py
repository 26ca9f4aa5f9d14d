"""Free play between two ends, either of which may be absent: a gap as contacts read it.

    g(x) = x - upper (x > upper),  0,  x - lower (x < lower)

Knows nothing of stiffness and damping.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gearblocks.language.contributions import Contribution, Switch


@dataclass(frozen=True, slots=True)
class Play:
    """lower, upper: symbols, or None where the side is open. The methods are those of `Backlash`; s is not read."""

    lower: Any
    upper: Any
    law: str = "exact"
    gaps: None = None

    def _sides(self, x: Any) -> tuple[Any, Any, Any, Any]:
        """1 at the lower end, depth beyond it; the same at the upper one. Zeros where there is none."""
        import sympy as sp

        zero = sp.Integer(0)
        below = (zero, zero) if self.lower is None else (sp.Heaviside(self.lower - x, 1), x - self.lower)
        above = (zero, zero) if self.upper is None else (sp.Heaviside(x - self.upper, 1), x - self.upper)
        return *below, *above

    def deflection(self, s: Any, x: Any) -> Any:  # noqa: ARG002  as Backlash has it
        """g(x)."""
        below, beyond_lower, above, beyond_upper = self._sides(x)
        return below * beyond_lower + above * beyond_upper

    def potential(self, s: Any, x: Any) -> Any:  # noqa: ARG002  as Backlash has it
        """The integral of g from the play."""
        below, beyond_lower, above, beyond_upper = self._sides(x)
        return below * beyond_lower**2 / 2 + above * beyond_upper**2 / 2

    def side(self, s: Any, x: Any) -> Any:  # noqa: ARG002  as Backlash has it
        """-1 at the lower end, 0 no contact, +1 at the upper end."""
        below, _, above, _ = self._sides(x)
        return above - below

    pushing_side = side

    def watches(self, s: Any, x: Any) -> Iterator[Contribution]:  # noqa: ARG002  as Backlash has it
        """The ends, by name."""
        if self.lower is not None:
            yield Switch("lower", self.lower - x)
        if self.upper is not None:
            yield Switch("upper", x - self.upper)
