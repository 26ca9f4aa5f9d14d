"""Ideal gears and gear meshes."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import Any

from gearblocks.blocks.contact import Contact, contact, damping, damping_problems, theta_of
from gearblocks.declare import Block, Contribution, Flange, Force, Shows, Tie, effect, exact, option, param
from gearblocks.effects import Backlash, Fourier, Harmonic, Profile, Square, as_profile
from gearblocks.signals import Value


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


class IdealPlanetary(Block):
    """Rigid planetary set without inertia, seen from sun, carrier and ring (Willis 1841):

        phi_sun + ratio phi_ring = (1 + ratio) phi_carrier

    ratio = z_ring/z_sun of a simple set; a negative one is a set with two planets in mesh, other values belong to
    compound planets.
    """

    sun, carrier, ring = Flange("sun"), Flange("planet carrier"), Flange("ring")
    ratio: float = exact("z_ring/z_sun")

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
    """Rigid differential without inertia: phi_left + phi_right = 2 phi_carrier / ratio."""

    carrier, left, right = Flange("driven side"), Flange("left output"), Flange("right output")
    ratio: float = exact("phi_carrier over the mean of the outputs", default=1)

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
        yield f"external = {block.external!r} must be True or False"


class GearMesh(Block):
    """Mesh of two gears along the line of action; without k a rigid tie by the teeth.

        external: x = r1 (phi_1 - phi_c) + r2 (phi_2 - phi_c) - e        internal: r1 (..) - r2 (..) - e
        N = c x' + k(.) g(x),    torques -N dx/dphi on pinion (1), wheel (2) and carrier (c)

    Base radii r1, r2 [m] from r_base, or module and pressure_angle (and helix_angle): r = m z cos(alpha_t)/(2 cos(beta)).
    A variation over the ANGLE comes from a potential: the pinion gets - dk/dphi_1 G(x) besides, the carrier the
    opposite; over a frequency it is the papers' parametric excitation, which does work on the train.
    """

    pinion, wheel = Flange("gear 1"), Flange("gear 2")
    carrier = Flange("carrier of both axes", ground=True)
    teeth: tuple[int, int] = exact("tooth counts (z1, z2)", many=True)
    external: bool = option("whether the teeth are outside on both")
    module: Value | None = param("normal module", "m", default=None, gt=0)
    pressure_angle: Value | None = param("normal pressure angle", "rad", default=None, ge=0, lt=1.5)
    helix_angle: Value | None = param("helix angle", "rad", default=None, gt=-1.5, lt=1.5)
    r_base: tuple[Value, Value] | None = param("base radii (r1, r2)", "m", default=None, gt=0, many=True)
    k: Value | None = param(
        "mean stiffness along the line of action", "N/m", default=None, gt=0, belongs_to="compliance"
    )
    c: Value | None = param("damping along the line of action", "N s/m", default=None, ge=0, belongs_to="damping")
    damping_ratio: Value | None = param("damping ratio on the bodies beside", default=None, ge=0, belongs_to="damping")
    stiffness_variation: Fourier | Square | Profile | None = effect("variation of k", convert=as_profile)
    backlash: Backlash | None = effect("dead zone")
    contact_damping: str = option("damping and gap: 'clipped', 'clipped_force' or 'always'", default="clipped")
    transmission_error: Harmonic | Profile | None = effect(
        "no-load transmission error e, subtracted from the deflection", convert=as_profile
    )

    def problems(self) -> Iterator[str]:
        """Geometry that is missing or contradicts the teeth."""
        yield from teeth_problems(self)
        yield from damping_problems(self)
        if self.r_base is not None and (self.module is not None or self.pressure_angle is not None):
            yield "r_base and module/pressure_angle are both given; give one of them"
        elif self.r_base is not None:
            yield from self._radius_problems()
        elif self.k is not None and (self.module is None or self.pressure_angle is None):
            yield "the base radii are unknown: give module and pressure_angle, or r_base=(r1, r2)"
        if self.k is None and (living := [n for n in self.effects() if n != "compliance"]):
            yield f"{', '.join(living)} need compliance: give k"

    def _radius_problems(self) -> Iterator[str]:
        assert self.r_base is not None
        if len(self.r_base) != 2 or not all(isinstance(r, (int, float)) for r in self.r_base):
            yield f"r_base = {self.r_base!r} must be two numbers in m"
        elif not isclose(self.r_base[0] * self.teeth[1], self.r_base[1] * self.teeth[0], rel_tol=1e-9):
            yield (
                f"r_base = {self.r_base!r} is not in the ratio of teeth = {self.teeth!r} "
                f"(r2/r1 = {self.r_base[1] / self.r_base[0]:.10g}, z2/z1 = {self.teeth[1] / self.teeth[0]:.10g})"
            )

    def _radius(self, s: Any) -> Any:
        """Base radius of the pinion; that of the wheel follows from the teeth."""
        import sympy as sp

        if self.r_base is not None:
            return s.r_base[0]
        if self.module is None:
            return None
        if self.helix_angle is None:
            return s.module * s.teeth[0] * sp.cos(s.pressure_angle) / 2
        transverse = sp.atan(sp.tan(s.pressure_angle) / sp.cos(s.helix_angle))
        return s.module * s.teeth[0] * sp.cos(transverse) / (2 * sp.cos(s.helix_angle))

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Contact along the line of action, or the rigid tie."""
        sign = 1 if self.external else -1
        ratio = sign * s.teeth[1] / s.teeth[0]
        turn = s.pinion.phi - s.carrier.phi
        lever = turn + ratio * (s.wheel.phi - s.carrier.phi)
        r1 = self._radius(s)
        if self.k is None:
            yield Tie(lever)
            if r1 is not None:
                yield Shows("force", -s.wheel.tau / (ratio * r1), "N", "mesh force along the line of action")
            return
        speed = (s.pinion.w - s.carrier.w) + ratio * (s.wheel.w - s.carrier.w)
        r2 = r1 * s.teeth[1] / s.teeth[0]
        c = damping(s, s.k, r1**2 * s.pinion.mobility + r2**2 * s.wheel.mobility)
        yield from mesh(self, s, r1 * lever, r1 * speed, c, s.teeth[0] * turn)


def mesh(block: Any, s: Any, lever: Any, speed: Any, c: Any, angle: Any) -> Iterator[Contribution]:
    """What GearMesh and SplineCoupling share. lever, speed: deflection and rate without error; angle: of the teeth."""
    import sympy as sp

    error: Any = sp.Integer(0)
    error_rate: Any = sp.Integer(0)
    factor: Any = sp.Integer(1)
    if block.stiffness_variation is not None:
        theta, rates = theta_of(block.stiffness_variation, s.stiffness_variation, angle, s.time)
        yield from rates
        factor += block.stiffness_variation.value(s.stiffness_variation, theta)
    excitation = getattr(block, "transmission_error", None)
    if excitation is not None:
        theta, rates = theta_of(excitation, s.transmission_error, angle, s.time)
        yield from rates
        error = excitation.value(s.transmission_error, theta)
        error_rate = s.rate_of(error, rates)
    x, rate = lever - error, speed - error_rate
    stiffness = s.named("k_t", s.k * factor)
    law = Contact(x, rate, stiffness, c, block.backlash, s.backlash, block.contact_damping)
    for item in contact(s, law):
        yield item
        if isinstance(item, Force):
            yield Shows("force", item.force, "N", "mesh force N, positive on the drive side")
    if block.stiffness_variation is not None and block.stiffness_variation.driven_by == "angle":
        yield from _parametric_torque(block, s, law, s.k * factor)
    yield Shows("deflection", x, "m", "deflection along the line of action")
    yield Shows("dynamic_transmission_error", x + error, "m", "deflection without the no-load error")
    yield Shows("deflection_rate", rate, "m/s", "rate of the deflection")
    yield Shows("stiffness", stiffness, "N/m", "stiffness with its variation")
    yield Shows("mesh_phase", sp.frac(angle / (2 * sp.pi)), "1", "position inside the mesh cycle, in [0, 1)")


def _parametric_torque(block: Any, s: Any, law: Contact, k: Any) -> Iterator[Contribution]:
    """-dk/dphi G(x) on every flange whose angle k depends on; k is written out (law.k may be a name for it)."""
    from gearblocks.declare import Acts

    potential = law.x**2 / 2 if law.gap is None else law.gap.potential(law.gap_symbols, law.x)
    for name in type(block).flanges:
        flange = getattr(s, name)
        slope = s.slope(k, flange)
        if slope != 0:
            yield Acts(flange, -slope * potential)
