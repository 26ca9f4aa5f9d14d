"""Spline couplings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.blocks.contact import Line, damping, damping_problems, mesh, variation_problems
from gearblocks.blocks.effects import Backlash, Fourier, HuntCrossley, Profile, Square, as_profile
from gearblocks.blocks.rigid_impact import hits, impact, without
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Shows, Tie
from gearblocks.language.fields import Flange, effect, exact, option, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Value, number_or_zero
from gearblocks.language.watches import Excitation, Watch, orders_of


class SplineCoupling(Block):
    """Involute spline: all teeth as one contact at the pitch radius.

        a o---=[####]=---o b        positive N drives b

        x = radius (phi_a - phi_b),   N = c x' + k(t) g(x),   torques -radius N on a, +radius N on b

    With contact_damping="always" the damping acts in the gap too, and N can be tensile there: the model of Xue, Wang
    and Yuan (2015), J. Harbin Inst. Tech. 47(1) 107-111, doi 10.11918/j.issn.0367-6234.2015.01.016. Damping in
    contact only ("clipped", the default) changes results by up to a factor of 6.

    With backlash=Backlash(gaps=(..)) the teeth come into contact one after the other, each with k/teeth: the load is
    piecewise linear over the deflection, its corners are located, and engaged_teeth counts those that carry load.

    Without compliance it is a rigid tie, or with backlash and contact_damping=HuntCrossley(...) a rigid impact of that
    restitution at both ends of the (smallest) gap.

    Example:
        rig = gb.Drivetrain("spline")
        spline = gb.SplineCoupling(teeth=24, radius="20 mm", k="500 MN/m", c=500.0, backlash=gb.Backlash(half_gap="20 um"))
        hub, shaft = rig.add("hub", gb.Inertia(J=0.01)), rig.add("shaft", gb.Inertia(J=0.02))
        rig.chain(rig.add("drive", gb.Torque(tau=10.0)), hub, rig.add("spline", spline), shaft)
    """

    a, b = Flange("external spline"), Flange("internal spline")
    teeth: int = exact("number of teeth")
    radius: Value = param("pitch radius", "m", gt=0)
    k: Value | None = param("mean stiffness of all teeth along the arc", "N/m", gt=0, belongs_to="compliance")
    c: Value | None = param("damping along the arc", "N s/m", default=None, ge=0, belongs_to="damping")
    damping_ratio: Value | None = param("damping ratio on the bodies beside", default=None, ge=0, belongs_to="damping")
    stiffness_variation: Fourier | Square | Profile | None = effect("variation of k", default=None, convert=as_profile)
    backlash: Backlash | None = effect("dead zone along the arc", default=None)
    contact_damping: str | HuntCrossley = option(
        "damping and gap: 'clipped', 'clipped_force', 'always' or HuntCrossley", default="clipped", belongs_to="damping"
    )
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting fields."""
        yield from damping_problems(self)
        yield from variation_problems(self)
        if int(self.teeth) != self.teeth or self.teeth <= 0:
            yield f"teeth = {self.teeth!r} must be a whole number > 0"
        gaps = None if self.backlash is None else self.backlash.gaps
        if gaps is not None and len(gaps) != self.teeth:
            yield f"backlash.gaps has {len(gaps)} gaps for {self.teeth} teeth; give one of every tooth"

    def without_effect(self, name: str) -> Block:
        """Without compliance a restitution stays, as that of a rigid impact."""
        return without(self, name, super().without_effect(name))

    def gives_way(self, flange: str) -> tuple[str, float] | None:  # noqa: ARG002  both sides alike
        """Its compliance, k r^2."""
        stiffness = number_or_zero(self.k) * number_or_zero(self.radius) ** 2
        return None if self.k is None else ("compliance", stiffness)

    def would_show(self, effect: str) -> Iterator[Watch]:
        """Without backlash the force changes its sign where the teeth would part."""
        if effect == "backlash":
            yield Watch("force", "the force changes its sign, where the teeth would part")

    def excitations(self) -> Iterator[Excitation]:
        """Tooth frequency and its orders, where the stiffness varies."""
        yield from super().excitations()
        if self.stiffness_variation is not None:
            yield from orders_of(self.stiffness_variation, float(self.teeth), "the spline", "a", None)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Contact along the arc of the pitch circle, the rigid tie or rigid impacts."""
        turn = s.a.phi - s.b.phi
        if hits(self):
            force = yield from impact(self, s, turn, s.radius)
            yield Shows("force", force, "N", "force along the arc, positive on the drive side")
            yield Shows("deflection", s.radius * turn, "m", "deflection along the arc")
            return
        if self.k is None:
            yield Tie(turn)
            yield Shows("force", s.b.tau / s.radius, "N", "force along the arc")
            return
        speed = s.radius * (s.a.w - s.b.w)
        c = damping(s, s.k, s.radius**2 * (s.a.mobility + s.b.mobility))
        yield from mesh(self, s, Line(s.radius * turn, speed, s.k, c, s.teeth * s.a.phi))
