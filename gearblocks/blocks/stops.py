"""Rigid stops: unilateral constraints with Newton's restitution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Shows, Stop
from gearblocks.language.fields import Flange, State, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Value


@dataclass(frozen=True, slots=True)
class Limits:
    """x stays between lower and upper (None: without limit); restitution of the impacts."""

    x: Any
    lower: Any
    upper: Any
    restitution: Any


def stops(limits: Limits, impulse: Any = None, impacts: Any = None) -> Iterator[Stop]:
    """The contacts "lower" and "upper"; both share the states for the last impulse and the number of impacts."""
    if limits.lower is not None:
        yield Stop("lower", limits.x - limits.lower, limits.restitution, impulse, impacts)
    if limits.upper is not None:
        yield Stop("upper", limits.upper - limits.x, limits.restitution, impulse, impacts)


def pressing(s: Any, limits: Limits) -> tuple[Any, Any]:
    """The force along x, > 0 from the lower stop, and the contact: -1 at the lower stop, +1 at the upper one."""
    import sympy as sp

    none = (sp.Integer(0),) * 3
    _, below, up = none if limits.lower is None else s.stick("lower")
    _, above, down = none if limits.upper is None else s.stick("upper")
    return up - down, above - below


class HardStop(Block):
    """Rigid stops of a relative angle: lower <= phi_rel <= upper.

        a o---[ | ]---o b        phi_rel = phi_b - phi_a, torque: on b

    With b left open it stands on the ground and limits phi_rel = phi_a; torque is then that on a. On sliders the limits
    are positions in m. One of lower and upper may be left out. In a chain it passes through to b; at the end of one b is the
    ground.

    An impact turns the closing speed v into -restitution v at that instant (Newton); where several contacts close at
    once, their impulses solve one linear complementarity problem. Bounces that follow each other without end in a finite
    time end in rest; the contact then stays closed as long as it is pressed, and never pulls. gap: distance to the nearer
    stop, exactly 0 in contact; contact: -1 at the lower stop, +1 at the upper one, 0 between; impacts: how many there
    were; impulse [N m s] of the last one.

    Example:
        rig = gb.Drivetrain("flap")
        flap, stop = rig.add("flap", gb.Inertia(J=0.01)), gb.HardStop(upper="90 deg", restitution=0.3)
        rig.chain(rig.add("drive", gb.Torque(tau=0.5)), flap, rig.add("stop", stop))
    """

    a = Flange("stopped shaft", slider=None)
    b = Flange("other shaft, or the ground", ground=True, spare=True, slider=None)
    lower: Value | None = param("least relative angle", "rad", default=None, symbol="theta_min")
    upper: Value | None = param("largest relative angle", "rad", default=None, symbol="theta_max")
    restitution: Value = param("speed after an impact over the speed before", ge=0, le=1)
    impulse = State("impulse of the last impact", "N m s")
    impacts = State("number of impacts")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Stops that leave no room."""
        if self.lower is None and self.upper is None:
            yield "there is no stop: give lower, upper or both"
        if isinstance(self.lower, (int, float)) and isinstance(self.upper, (int, float)) and self.lower >= self.upper:
            yield f"lower = {self.lower!r} rad must be < upper = {self.upper!r} rad"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Two unilateral contacts along the relative angle."""
        import sympy as sp

        x = s.b.phi - s.a.phi if s.b.phi.is_Symbol else s.a.phi
        limits = Limits(x, s.lower, s.upper, s.restitution)
        yield from stops(limits, s.impulse, s.impacts)
        force, contact = pressing(s, limits)
        gaps = [x - s.lower] if self.lower is not None else []
        gaps += [s.upper - x] if self.upper is not None else []
        yield Shows("gap", (1 - contact**2) * sp.Min(*gaps), "rad", "distance to the nearer stop")
        yield Shows("torque", force, "N m", "torque on flange b, or on a where b is the ground")
        yield Shows("contact", contact, "1", "-1 at the lower stop, 0 between, +1 at the upper one")
        yield Shows("impacts", s.impacts, "1", "number of impacts")
        yield Shows("impulse", s.impulse, "N m s", "impulse of the last impact")
