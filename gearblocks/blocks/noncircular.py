"""Pairs of non-circular gears."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Any

from gearblocks.blocks.contact import Contact, contact, damping, damping_problems, deflection_and_potential, error_of
from gearblocks.blocks.effects import Backlash, Harmonic, Profile, Superposition, ToothFriction, as_error
from gearblocks.geometry.ratio_law import RatioLaw
from gearblocks.language.block import Block
from gearblocks.language.contributions import Acts, Contribution, Force, Rate, Shows, Start, Tie
from gearblocks.language.expression import Expr
from gearblocks.language.fields import Flange, State, effect, option, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Input, Parameter, Signal, Table, Value
from gearblocks.language.watches import Excitation, Watch

_CORNERS = {"Abs", "sign", "Min", "Max", "Heaviside", "Piecewise"}


class NonCircularGear(Block):
    """Pair of non-circular gears a and b on a carrier c; without k a rigid tie.

        a o---|==|        w_b = F'(theta) w_a without its sign
              |==|---o b

        theta = phi_a - phi_c + phase                            angle of gear 1 (the driver) over which the law is given
        internal: q = F(theta) - F(phase at start) - (phi_b - phi_c) - e        torques of M: -m M on a, +M on b, (m-1) M on c
        external: q = F(theta) - F(phase at start) + (phi_b - phi_c) - e        torques of M: -m M on a, -M on b, (1+m) M on c
        M = k g(q) + c q',   m = F'(theta) = abs(w_b/w_a) at rest of the carrier;   rigid: q = 0 without e

    `external` only says whether b turns against a. A phase that moves shifts the law, not the gears at the start (a sensed
    output counts from 0). With filter, theta follows the phase as x'' = filter^2 (phase - x) - 2 filter x', from rest.
    A stiffness k over the angle derives from a potential: a gets -k'(theta) G(q) besides, c the opposite. The joints of the
    law are located. q' contains the rate of a phase that is an expression or table of time, or filtered; that of another
    Input or sensed output counts as 0. Large absolute angles cost theta its last digits, and leave q as it is.

    Example:
        rig = gb.Drivetrain("elliptical pair")
        pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3), external=True))
        rig.chain(rig.add("drive", gb.Speed(w=10.0)), pair, rig.add("load", gb.Inertia(J=0.1)))
    """

    a, b = Flange("gear 1, the driver of the law"), Flange("gear 2")
    carrier = Flange("carrier of both axes", ground=True)
    law: RatioLaw = option("ratio law, a gb.RatioLaw")
    external: bool = option("whether b turns against a")
    phase: Signal | None = signal("added to the angle of gear 1", "rad", default=None)
    filter: Value | None = param(
        "cut-off frequency of a filter of the phase", "rad/s", default=None, gt=0, symbol="omega_c"
    )
    filtered_phase = State("phase behind the filter", "rad", symbol="vartheta_f")
    filtered_rate = State("its rate", "rad/s", symbol="omega_f")
    start_angle = State("F of the phase at the start", "rad", symbol="F_0")
    k: Signal | None = signal(
        "stiffness about b, also over gb.driver_angle", "N m/rad", default=None, gt=0,
        belongs_to="compliance", over="driver_angle",
    )  # fmt: skip
    c: Value | None = param("damping about b", "N m s/rad", default=None, ge=0, belongs_to="damping")
    damping_ratio: Value | None = param(
        "damping ratio on the bodies beside, at the mean ratio", default=None, ge=0, belongs_to="damping"
    )
    backlash: Backlash | None = effect("dead zone of q, half_gap in rad about b", default=None, turns=True)
    contact_damping: str = option("damping and gap: 'clipped', 'clipped_force' or 'always'", default="clipped")
    transmission_error: Harmonic | Profile | Superposition | tuple[Harmonic | Profile, ...] | None = effect(
        "no-load error e in rad about b, over turns of gear 1", default=None, convert=as_error, turns=True
    )
    friction: ToothFriction | None = effect(
        "friction in the form of papers: M (1 + mu wave), direction='square_wave'", default=None
    )
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """A law that is none, a phase that a rigid pair cannot follow, effects that need compliance."""
        yield from damping_problems(self)
        if not isinstance(self.law, RatioLaw):
            yield f"law = {self.law!r:.80} must be a gb.RatioLaw, such as gb.RatioLaw.ellipse(e=0.3)"
        if not isinstance(self.external, bool):
            yield f"external = {self.external!r} must be True or False"
        if self.filter is not None and self.phase is None:
            yield "filter is that of a phase; give one"
        if self.damping_ratio is not None and not isinstance(self.k, (int, float, Parameter)):
            yield "damping_ratio needs a k that does not change; give c"
        if _senses(self.phase) and self.filter is not None:
            yield f"phase = {self.phase!r:.80} is sensed and has no value yet when the filter starts; leave filter out"
        if self.friction is not None and self.friction.direction != "square_wave":
            yield "friction: a ratio law knows no teeth to slide on; give direction='square_wave' and wave=..."
        if self.k is None:
            if living := [n for n in self.effects() if n != "compliance"]:
                yield f"{', '.join(living)} need{'s' * (len(living) == 1)} compliance: give k"
            if self.filter is None and (jerky := _corner(self.phase)) is not None:
                yield (
                    f"phase = {self.phase!r:.80} has no acceleration ({jerky}), which a rigid pair must follow: "
                    "give a smooth expression of time or a cubic Table, filter=rad/s, or k"
                )

    def ratio_varies(self) -> bool:
        """Its law over the angle of gear 1."""
        return True

    def would_show(self, effect: str) -> Iterator[Watch]:
        """Without backlash the force changes its sign where the teeth would part."""
        if effect == "backlash":
            yield Watch("torque", "the torque changes its sign, where the teeth would part")

    def excitations(self) -> Iterator[Excitation]:
        """The ratio varies over the turns of gear 1."""
        yield from super().excitations()
        yield from (Excitation("the ratio", order=float(j), flange="a", against="carrier") for j in (1, 2))

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The contact, or the tie."""
        import sympy as sp

        phase, at_start, moves = yield from self._phase(s)
        theta = s.named("theta", s.a.phi - s.carrier.phi + phase, "angle of gear 1 over which the law is given", "rad")
        turned = s.named("F", s.turned(self.law, theta), "law: angle of gear 2 over that of gear 1", "rad") - at_start
        sign = 1 if self.external else -1
        q = turned + sign * (s.b.phi - s.carrier.phi)
        m = s.named("m", s.slope(turned, s.a), "F', the ratio of the speeds")
        yield Shows("ratio", m, "1", "ratio m of the speeds, b over a, without its sign")
        yield Shows("driver_angle", theta, "rad", "angle of gear 1 over which the law is given")
        if self.k is None:
            yield Tie(sign * q, inverse=(s.a, lambda: self._from_gear_2(s, phase, at_start)))
            yield Shows("torque", s.b.tau, "N m", "torque on flange b")
            return
        if self.transmission_error is not None:
            error, rates = error_of(self.transmission_error, s.transmission_error, theta, s.time)
            yield from rates
            error = s.named("e", error, "no-load transmission error", "rad")
            rate = s.rate_of(q, moves) - s.rate_of(error, [*moves, *rates])
            q -= error
        else:
            rate = s.rate_of(q, moves)
        k = s.local("k", driver_angle=theta)
        q = s.named("q", q, "deflection about gear 2", "rad")
        rate = s.named("q'", rate, "rate of the deflection", "rad/s")
        stiffness = s.named("k_t", k, "stiffness about gear 2", "N m/rad")
        mean = sp.Rational(self.law.n1, self.law.n2)
        c = damping(s, k, mean**2 * s.a.mobility + s.b.mobility, unit="N m s/rad", body="J_e")
        choice = self.contact_damping, s.contact_damping
        law = Contact(q, rate, stiffness, c, self.backlash, s.backlash, *choice, "M")
        for item in contact(s, law):
            if isinstance(item, Force) and self.friction is not None:
                extra = s.friction.mu * s.friction.wave * item.force
                yield Shows("friction_moment", extra, "N m", "part of M that is friction")
                item = Force(item.deflection, item.force + extra)
            yield item
            if isinstance(item, Force):
                yield Shows("moment", item.force, "N m", "moment M, positive where a drives b")
                yield Shows("torque", -sign * item.force, "N m", "torque on flange b")
        potential = deflection_and_potential(law)[1]
        yield from (Acts(x, -slope * potential) for x in (s.a, s.carrier) if (slope := s.slope(k, x)) != 0)
        yield Shows("deflection", q, "rad", "deflection about b")
        yield Shows("deflection_rate", rate, "rad/s", "rate of the deflection")
        yield Shows("stiffness", stiffness, "N m/rad", "stiffness about b")

    def _from_gear_2(self, s: Any, phase: Any, at_start: Any) -> Any:
        """The rigid relation solved for gear 1: theta - F^-1(F(phase at start) +- (phi_b - phi_c))."""
        sign = 1 if self.external else -1
        theta = s.a.phi - s.carrier.phi + phase
        return theta - s.turned(self.law.inverted, at_start - sign * (s.b.phi - s.carrier.phi))

    def _phase(self, s: Any) -> Generator[Contribution, None, tuple[Any, Any, list[Rate]]]:
        """(phase, F of the phase at the start, rates of the states in the phase)."""
        import sympy as sp

        if self.phase is None:
            return sp.Integer(0), sp.Integer(0), []
        if self.filter is None and s.is_constant("phase"):
            return s.phase, s.turned(self.law, s.phase), []
        if _senses(self.phase):
            return s.phase, sp.Integer(0), []
        yield Start(s.start_angle, s.turned(self.law, s.phase))
        yield Rate(s.start_angle, sp.Integer(0))
        if self.filter is None:
            return s.phase, s.start_angle, []
        x, speed = s.filtered_phase, s.filtered_rate
        rates = [Rate(x, speed), Rate(speed, s.filter**2 * (s.phase - x) - 2 * s.filter * speed)]
        yield Start(x, s.phase)
        yield from rates
        return x, s.start_angle, rates


def _corner(phase: Any) -> str | None:
    """The reason why a signal has no second derivative, or None."""
    if isinstance(phase, Input):
        return "an Input may jump"
    if isinstance(phase, Table):
        return None if phase.kind == "cubic" else f"a table of kind '{phase.kind}' has corners"
    if isinstance(phase, Expr):
        leaves = list(phase.leaves())
        found = [_corner(leaf.args[0]) for leaf in leaves if leaf.op in ("input", "table")]
        found += ["a sensed output has no known rate" for leaf in leaves if leaf.op == "sense"]
        found += [f"{op} has corners" for op in sorted(_operations(phase) & _CORNERS)]
        return next((reason for reason in found if reason), None)
    return None


def _senses(phase: Any) -> bool:
    return isinstance(phase, Expr) and any(leaf.op == "sense" for leaf in phase.leaves())


def _operations(e: Expr) -> set[str]:
    return {e.op}.union(*(_operations(a) for a in e.args if isinstance(a, Expr)))
