"""The mesh of two gears along the line of action."""

from __future__ import annotations

from collections.abc import Iterator
from math import isclose
from typing import Any

from gearblocks.blocks.contact import Line, damping, damping_problems, mesh, variation_problems
from gearblocks.blocks.effects import (
    Backlash,
    Fourier,
    Harmonic,
    HuntCrossley,
    Profile,
    Square,
    Superposition,
    ToothFriction,
    as_error,
    as_profile,
)
from gearblocks.blocks.gears import teeth_problems
from gearblocks.blocks.rigid_impact import hits, impact, without
from gearblocks.blocks.tooth_friction import with_tooth_friction
from gearblocks.geometry.involute import NUMBERS, ToothPair, contact_ratio_or_nan, iso_problems, mesh_stiffness, unnamed
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Shows, Tie
from gearblocks.language.fields import Flange, effect, exact, option, param
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Value, number_or_zero
from gearblocks.language.watches import Excitation, Watch, orders_of


def _of_both(words: str) -> tuple[str, str]:
    return f"{words} of gear 1", f"{words} of gear 2"


class GearMesh(Block):
    """Mesh of two gears along the line of action; without k or stiffness a rigid tie by the teeth, or, with backlash and
    contact_damping=HuntCrossley(...), a rigid impact of that restitution at both ends of the gap.

        pinion o---|===|            positive N drives the wheel, and brakes the pinion
                   |===|---o wheel  (the wheel of an external pair turns backward)

        external: x = r1 (phi_1 - phi_c) + r2 (phi_2 - phi_c) - e        internal: r1 (..) - r2 (..) - e
        N = c x' + k(.) g(x),    torques -N dx/dphi on pinion (1), wheel (2) and carrier (c)

    Base radii r1, r2 [m] from r_base, or module and pressure_angle (and helix_angle): r = m z cos(alpha_t)/(2 cos(beta)).
    A variation over the ANGLE comes from a potential: the pinion gets - dk/dphi_1 G(x) besides, the carrier the
    opposite; over a frequency it is the papers' parametric excitation, which does work on the train: somebody unseen
    keeps the excitation in step with time and pays for it. A free pair without damping keeps its energy in the first
    form (to 1e-10 over 1000 mesh cycles); in the second it gains or loses some, and without bound where the mesh
    frequency lies near the natural one or twice that. The same holds for a transmission error.

    stiffness="iso6336" gives k = c' (0.75 eps_alpha + 0.25) b after ISO 6336-1, method B, from the tooth numbers, module,
    pressure_angle, [helix_angle], face_width b, [profile_shift, addendum]: see
    `gearblocks.geometry.involute.single_stiffness` for the formula. It holds for solid steel gears loaded by 100 N per mm
    of face width or more, helix angles up to 30 degrees, eps_alpha >= 1.2, x1 >= x2 (1: the smaller gear) and
    -0.5 <= x1 + x2 <= 2; the wheel of an internal pair counts as a rack.

    Example:
        rig = gb.Drivetrain("spur pair")
        pair = gb.GearMesh(teeth=(23, 41), module="3 mm", pressure_angle="20 deg", external=True, k="200 MN/m")
        pinion, wheel = rig.add("pinion", gb.Inertia(J=2e-4)), rig.add("wheel", gb.Inertia(J=0.05))
        drive, load = rig.add("drive", gb.Torque(tau=20.0)), rig.add("load", gb.Torque(tau=35.0))
        rig.chain(drive, pinion, rig.add("mesh", pair), wheel, load)
        print(gb.simulate(rig, t_end=0.01, initial="static")["mesh.force"][-1])
    """

    pinion, wheel = Flange("gear 1"), Flange("gear 2")
    carrier = Flange("carrier of both axes", ground=True)
    teeth: tuple[int, int] = exact("tooth counts (z1, z2)", many=True, each=_of_both("number of teeth"))
    external: bool = option("whether the teeth are outside on both")
    module: Value | None = param("normal module", "m", default=None, gt=0, usual=0.1)
    pressure_angle: Value | None = param("normal pressure angle", "rad", default=None, ge=0, lt=1.5)
    helix_angle: Value | None = param("helix angle", "rad", default=None, gt=-1.5, lt=1.5)
    r_base: tuple[Value, Value] | None = param(
        "base radii (r1, r2), r2 in the ratio of the teeth",
        "m",
        default=None,
        gt=0,
        many=True,
        leading=1,
        each=_of_both("base radius"),
    )
    face_width: Value | None = param("common face width", "m", default=None, gt=0, usual=5.0)
    profile_shift: tuple[Value, Value] | None = param(
        "profile shifts (x1, x2) over the module",
        default=None,
        many=True,
        each=("profile shift of gear 1 over the module", "profile shift of gear 2 over the module"),
    )
    addendum: Value | None = param("addendum over the module; absent: 1", default=None, gt=0)
    k: Value | None = param(
        "mean stiffness along the line of action", "N/m", default=None, gt=0, belongs_to="compliance"
    )
    stiffness: str | None = option("'iso6336': the stiffness of the standard", default=None, belongs_to="compliance")
    c: Value | None = param("damping along the line of action", "N s/m", default=None, ge=0, belongs_to="damping")
    damping_ratio: Value | None = param("damping ratio on the bodies beside", default=None, ge=0, belongs_to="damping")
    stiffness_variation: Fourier | Square | Profile | None = effect("variation of k", default=None, convert=as_profile)
    backlash: Backlash | None = effect("dead zone", default=None)
    contact_damping: str | HuntCrossley = option(
        "damping and gap: 'clipped', 'clipped_force', 'always' or HuntCrossley", default="clipped", belongs_to="damping"
    )
    transmission_error: Harmonic | Profile | Superposition | tuple[Harmonic | Profile, ...] | None = effect(
        "no-load transmission error e, subtracted from the deflection", default=None, convert=as_error
    )
    friction: ToothFriction | None = effect("friction of the teeth", default=None)
    heat: HeatPort | None = HEAT

    # -- what is wrong ------------------------------------------------------------------------------------------------

    def problems(self) -> Iterator[str]:
        """Geometry that is missing or contradicts the teeth."""
        wrong_teeth = list(teeth_problems(self))
        yield from wrong_teeth
        yield from damping_problems(self)
        yield from variation_problems(self)
        if self.r_base is not None and (self.module is not None or self.pressure_angle is not None):
            yield "r_base and module/pressure_angle are both given; give one of them"
        elif self.r_base is not None:
            yield from self._radius_problems()
        elif (self.is_compliant or hits(self)) and (self.module is None or self.pressure_angle is None):
            yield "the base radii are unknown: give module and pressure_angle, or r_base=(r1, r2)"
        resting = ("backlash", "damping") if hits(self) else ()
        if not self.is_compliant and (living := [n for n in self.effects() if n not in resting]):
            yield f"{', '.join(living)} need{'s' * (len(living) == 1)} compliance: give k"
        if self.backlash is not None and self.backlash.gaps is not None:
            yield "backlash.gaps is for a spline, whose teeth are all in place at once; give half_gap"
        if not wrong_teeth:
            yield from self._geometry_problems()

    def _radius_problems(self) -> Iterator[str]:
        assert self.r_base is not None
        radii = [r for r in self.r_base if isinstance(r, (int, float))]
        if len(radii) != 2 or len(self.r_base) != 2:
            yield f"r_base = {self.r_base!r} must be two numbers in m"
        elif not isclose(radii[0] * self.teeth[1], radii[1] * self.teeth[0], rel_tol=1e-9):
            yield (
                f"r_base = {self.r_base!r} is not in the ratio of teeth = {self.teeth!r} "
                f"(r2/r1 = {radii[1] / radii[0]:.10g}, z2/z1 = {self.teeth[1] / self.teeth[0]:.10g}): "
                f"give ({radii[0]:g}, {radii[0] * self.teeth[1] / self.teeth[0]:.10g}), or module and pressure_angle"
            )

    def _geometry_problems(self) -> Iterator[str]:
        """Fields that the stiffness of the standard and the lever arms of friction need."""
        iso, rubbing = self.stiffness is not None, self.friction is not None and self.friction.direction == "geometry"
        if self.stiffness not in (None, "iso6336"):
            yield f"stiffness = {self.stiffness!r} is not known; give 'iso6336', or k"
            return
        if iso and self.k is not None:
            yield "k and stiffness are both given; give one of them"
        if self.profile_shift is not None and len(self.profile_shift) != 2:
            yield f"profile_shift = {self.profile_shift!r} must be two numbers (x1, x2)"
            return
        missing = [n for n in ("module", "pressure_angle") if getattr(self, n) is None]
        missing += ["face_width"] if iso and self.face_width is None else []
        if (iso or rubbing) and missing:
            yield ("stiffness='iso6336'" if iso else "friction") + f" needs {', '.join(missing)}"
        elif iso or rubbing:
            yield from self._limits(iso, rubbing)

    def _limits(self, iso: bool, rubbing: bool) -> Iterator[str]:
        """Numbers outside of the range of the formulas; Parameters are not judged."""
        shape = (
            self.module,
            self.pressure_angle,
            self.helix_angle or 0,
            self.addendum or 1,
            *(self.profile_shift or ()),
        )
        if not all(isinstance(v, (int, float)) for v in shape):
            return
        pair = self._pair(self)
        if iso:
            yield from (f"stiffness='iso6336': {p}" for p in iso_problems(pair, self._first_is_smaller))
        if rubbing and not 1 <= (ratio := contact_ratio_or_nan(pair)) <= 2:
            yield f"friction: the transverse contact ratio is {ratio:.3g} and must lie between 1 and 2"

    # -- geometry -----------------------------------------------------------------------------------------------------

    @property
    def is_compliant(self) -> bool:
        """Whether the teeth give way."""
        return self.k is not None or self.stiffness is not None

    @property
    def _first_is_smaller(self) -> bool:
        return not self.external or self.teeth[0] <= self.teeth[1]

    def _pair(self, s: Any) -> ToothPair:
        """The gears for geometry, of the numbers in a block or the symbols in s."""
        from gearblocks.laws.functions import SYMBOLS

        f, named = (NUMBERS, unnamed) if isinstance(s, Block) else (SYMBOLS, s.named)
        return ToothPair(
            s.teeth[0], s.teeth[1] if self.external else -s.teeth[1], s.module, s.pressure_angle,
            0 if s.helix_angle is None else s.helix_angle, s.profile_shift, 1 if s.addendum is None else s.addendum, f,
            named,
        )  # fmt: skip

    def _radius(self, s: Any) -> Any:
        """Base radius of the pinion; that of the wheel follows from the teeth."""
        if self.r_base is not None:
            return s.named("r_1", s.r_base[0], "base radius of gear 1", "m")
        return None if self.module is None else self._pair(s).base_radii[0]

    def without_effect(self, name: str) -> Block:
        """Without compliance a restitution stays, as that of a rigid impact."""
        return without(self, name, super().without_effect(name))

    def gives_way(self, flange: str) -> tuple[str, float] | None:
        """Its compliance, k r^2 about a gear."""
        if not self.is_compliant or flange == "carrier":
            return None
        if self.r_base is not None:
            radius = number_or_zero(self.r_base[0])
        else:
            values = {n: number_or_zero(getattr(self, n)) for n in ("module", "pressure_angle", "helix_angle")}
            radius = self._pair(self.changed(**values, profile_shift=None)).base_radii[0]
        lever = radius * (1 if flange == "pinion" else self.teeth[1] / self.teeth[0])
        return "compliance", number_or_zero(self.k) * lever**2

    def would_show(self, effect: str) -> Iterator[Watch]:
        """Without backlash the force changes its sign where the teeth would part."""
        if effect == "backlash":
            yield Watch("force", "the mesh force changes its sign, where the teeth would part")

    def excitations(self) -> Iterator[Excitation]:
        """Mesh frequency and its orders, where something varies with the mesh cycle."""
        yield from super().excitations()
        for name in ("stiffness_variation", "transmission_error", "friction"):
            if self.__dict__[name] is not None:
                yield from orders_of(self.__dict__[name], float(self.teeth[0]), "the mesh", "pinion", "carrier")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Contact along the line of action, or the rigid tie."""
        sign = 1 if self.external else -1
        ratio = sign * s.teeth[1] / s.teeth[0]
        turn, back = s.pinion.phi - s.carrier.phi, s.wheel.phi - s.carrier.phi
        r1 = self._radius(s)
        if hits(self):
            force = yield from impact(self, s, turn + ratio * back, r1)
            yield Shows("force", force, "N", "mesh force N, positive on the drive side")
            yield Shows("deflection", r1 * (turn + ratio * back), "m", "deflection along the line of action")
            return
        if not self.is_compliant:
            yield Tie(turn + ratio * back)
            if r1 is not None:
                yield Shows("force", -s.wheel.tau / (ratio * r1), "N", "mesh force along the line of action")
            return
        k = s.k
        if k is None:
            k = s.named(
                "k_iso", mesh_stiffness(self._pair(s), s.face_width, self._first_is_smaller),
                "stiffness after ISO 6336-1", "N/m",
            )  # fmt: skip
        speeds = s.pinion.w - s.carrier.w, s.wheel.w - s.carrier.w
        r2 = s.named("r_2", r1 * s.teeth[1] / s.teeth[0], "base radius of gear 2", "m")
        c = damping(s, k, r1**2 * s.pinion.mobility + r2**2 * s.wheel.mobility)
        line = Line(r1 * (turn + ratio * back), r1 * (speeds[0] + ratio * speeds[1]), k, c, s.teeth[0] * turn)
        if s.reading:
            lever, speed = r1 * turn + sign * r2 * back, r1 * speeds[0] + sign * r2 * speeds[1]
            line = Line(lever, speed, k, c, line.angle)
        found = mesh(self, s, line)
        yield from found if self.friction is None else with_tooth_friction(self, s, found, line, self._pair(s))
