"""Compliant elements on two flanges of one axis, or on two sliders (k then in N/m, c in N s/m, half_gap in m)."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Any

from gearblocks.blocks.bodies import Inertia
from gearblocks.blocks.contact import Contact, contact, damping, damping_problems
from gearblocks.blocks.effects import Backlash, HuntCrossley, Hysteresis
from gearblocks.blocks.play import Play
from gearblocks.blocks.rigid_impact import hits, impact, without
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Energy, Force, Parts, Rate, Shows, Stick, Tie
from gearblocks.language.expression import Expr, as_expr
from gearblocks.language.fields import Flange, effect, option, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Signal, Value, constant_value, number_or_zero
from gearblocks.language.watches import Watch, beyond_both


class Shaft(Block):
    r"""Massless torsional spring and damper.

        a o---/\/\/---o b        twist = phi_b - phi_a
              --[]--             positive torque pulls a forward and b back ... on b: -(k twist + c twist')

    Either k (a number or signal), or torque: an expression of gb.twist or a Table over the twist, the torque that
    pulls the ends together. rest: the twist (on sliders s_b - s_a, a free length) at which it carries nothing: twist - rest
    then stands for the twist in both; the output twist stays phi_b - phi_a. phi_rel0, w_rel0: twist
    and its rate at the start, which bodies follow whose start nothing gives. Damping by c or damping_ratio. With its own
    inertia J the shaft becomes a chain of `segments` springs with J lumped at their ends; without the effect `segments`, of
    one spring between two halves of J. hysteresis=Hysteresis(...): inner friction beside the spring.

    Example:
        rig = gb.Drivetrain("two discs")
        left, right = rig.add("left", gb.Inertia(J=0.02, phi0=0.01)), rig.add("right", gb.Inertia(J=0.05))
        rig.chain(left, rig.add("shaft", gb.Shaft(k=2.0e4, c=3.0)), right)
        print(gb.simulate(rig, t_end=0.1).extremes("shaft.torque"))
    """

    a, b = Flange("left end", slider=None), Flange("right end", slider=None)
    k: Signal | None = signal(
        "torsional stiffness", "N m/rad", default=None, gt=0, belongs_to="compliance", unless="allow_negative",
        why=" (or give allow_negative=True)",
    )  # fmt: skip
    torque: Signal | None = signal(
        "restoring torque over gb.twist", "N m", default=None, belongs_to="compliance", over="twist", symbol="M"
    )
    c: Value | None = param("torsional damping", "N m s/rad", default=None, ge=0, belongs_to="damping")
    damping_ratio: Value | None = param("damping ratio on the bodies beside", default=None, ge=0, belongs_to="damping")
    allow_negative: bool = option("admit k < 0", default=False)
    rest: Value | None = param("twist without load", "rad", default=None, belongs_to="compliance", symbol="theta_0")
    phi_rel0: Value | None = param("start twist", "rad", default=None, belongs_to="compliance", start="relative angle")
    w_rel0: Value | None = param(
        "start rate of the twist", "rad/s", default=None, belongs_to="compliance", start="relative speed"
    )
    hysteresis: Hysteresis | None = effect("inner friction", default=None)
    rigid: bool = option(
        "turns as one piece; what is left when compliance is taken away", default=False, absence_of="compliance"
    )
    segments: int = option("number of springs in a row", default=1, belongs_to="segments")
    J: Value | None = param("own moment of inertia", "kg m2", default=None, ge=0)
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting fields."""
        yield from damping_problems(self)
        if self.k is not None and self.torque is not None:
            yield "k and torque are both given; give one of them"
        if self.k is None and self.torque is None and not self.rigid:
            yield "the stiffness is missing: give k or torque (or rigid=True)"
        if self.rigid and any(x is not None for x in (self.k, self.torque, self.c, self.damping_ratio)):
            yield "a rigid shaft has no k, torque, c or damping_ratio"
        if self.rigid and self.rest is not None:
            yield "a rigid shaft has no rest: it keeps the angle between its ends as it is"
        if (self.J is not None or self.segments != 1) and (given := self._of_one_spring()):
            yield f"{' and '.join(given)}: of one spring; leave J and segments out"
        if self.rigid and (self.phi_rel0 is not None or self.w_rel0 is not None):
            yield "a rigid shaft has no start twist; give phi0 and w0 to the bodies beside"
        if self.rigid and self.hysteresis is not None:
            yield "a rigid shaft has no hysteresis: nothing twists"
        if self.torque is not None and self.damping_ratio is not None:
            yield "damping_ratio needs k; give c"
        if not isinstance(self.segments, int) or self.segments < 1:
            yield f"segments = {self.segments!r} must be a whole number >= 1"
        elif self.segments > 1 and (self.k is None or self.J is None or self.damping_ratio is not None):
            yield "segments need k, J and (for damping) c"
        elif self.J is not None and not self.rigid and (self.k is None or self.damping_ratio is not None):
            yield "J needs k and (for damping) c"

    def _of_one_spring(self) -> list[str]:
        return [name for name in ("rest", "phi_rel0", "w_rel0") if getattr(self, name) is not None]

    def _numbers(self) -> tuple[Any, Any, Any]:
        return self.k, self.c, self.J

    def gives_way(self, flange: str) -> tuple[str, float] | None:  # noqa: ARG002  both ends alike
        """Its compliance."""
        return None if self.rigid else ("compliance", number_or_zero(self.k))

    def undeformed(self) -> dict[str, str]:
        """Its rest."""
        return {} if self.rest is None else {"rest": "rest"}

    def parts(self) -> Parts | None:
        """The chain of springs and lumps, when it has an inertia."""
        n, k, c, J = self.segments, *self._numbers()
        if J is None:
            return None
        if k is None:
            whole: dict[str, Block] = {"lump": Inertia(J=J), "shaft": self.changed(J=None)}
            return Parts(whole, ((("lump", "b"), ("shaft", "a")),), {"a": ("lump", "a"), "b": ("shaft", "b")})
        blocks: dict[str, Block] = {}
        for i in range(n + 1):
            blocks[f"lump[{i}]"] = Inertia(J=J / n / (2 if i in (0, n) else 1))
        for i in range(1, n + 1):
            spring = self.changed(segments=1, J=None, k=k * n, c=None if c is None else c * n)
            blocks[f"spring[{i}]"] = spring
        links = [((f"lump[{i - 1}]", "b"), (f"spring[{i}]", "a")) for i in range(1, n + 1)]
        links += [((f"spring[{i}]", "b"), (f"lump[{i}]", "a")) for i in range(1, n + 1)]
        return Parts(blocks, tuple(links), {"a": ("lump[0]", "a"), "b": (f"lump[{n}]", "b")})

    def would_show(self, effect: str) -> Iterator[Watch]:
        """The slider slips beyond its torque: at a torque of the shaft, or at a twist where it has a spring of its own."""
        if effect != "hysteresis" or self.hysteresis is None:
            return
        most, own = constant_value(self.hysteresis.friction), self.hysteresis.stiffness
        springs = [""] if self.segments == 1 else [f"spring[{i}]." for i in range(1, self.segments + 1)]
        for spring in springs:
            if own is None:
                yield Watch(f"{spring}torque", "the torque exceeds what the slider holds", most)
            else:
                yield Watch(f"{spring}twist", "the twist exceeds where the slider slips", most / constant_value(own))

    def beyond_tables(self) -> Iterator[tuple[str, Watch]]:
        """Tables over the twist."""
        leaves = self.torque.leaves() if isinstance(self.torque, Expr) else ()
        over = [leaf.args[0] for leaf in leaves if leaf.op == "table" and leaf.args[1].op == "local"]
        rest = 0.0 if self.rest is None else constant_value(self.rest)
        for table in () if self.J is not None else (self.torque, *over):
            yield from (("torque", watch) for watch in beyond_both(table, "twist", rest))
        yield from super().beyond_tables()

    def physics(self, s: Any) -> Iterator[Contribution]:
        """torque = k twist + c twist'."""
        twist, rate = s.b.phi - s.a.phi, s.b.w - s.a.w
        if not self.rigid:
            twist, rate = s.named("theta", twist, "twist", "rad"), s.named("theta'", rate, "rate of the twist", "rad/s")
        yield Shows("twist", twist, "rad", "twist phi_b - phi_a")
        yield Shows("twist_rate", rate, "rad/s", "rate of the twist, w_b - w_a")
        if self.k is None and self.torque is None:
            yield Tie(twist)
            yield Shows("torque", s.b.tau, "N m", "torque on flange b")
            return
        strain = twist if self.rest is None else twist - s.rest
        elastic = s.k * strain if self.k is not None else s.local("torque", twist=strain)
        c = damping(s, s.k, s.a.mobility + s.b.mobility, unit="N m s/rad", body="J_e")
        drag = c * rate if c is not None else 0
        yield Force(twist, s.named("T", elastic + drag, "torque that pulls the ends together", "N m"))
        stored = s.k * strain**2 / 2 if self.k is not None else s.energy_of("torque", "twist", strain)
        yield Energy(stored=stored, loss=drag * rate if c is not None else None)
        inner, lost = yield from _inner_friction(self, s, twist, rate)
        yield Shows("torque", -elastic - drag - inner, "N m", "torque on flange b")
        if c is not None or self.hysteresis is not None:
            yield Shows("loss_power", drag * rate + lost, "W", "power lost in damper and inner friction")


def _inner_friction(block: Shaft, s: Any, twist: Any, rate: Any) -> Generator[Contribution, None, tuple[Any, Any]]:
    """Torque of the dry slider of Jenkins and Iwan, with the sign of the twist, and the power that it loses."""
    import sympy as sp

    if block.hysteresis is None:
        return sp.Integer(0), sp.Integer(0)
    h = s.hysteresis
    if block.hysteresis.stiffness is None:
        direction, _, held = s.stick("hysteresis")
        yield Stick("hysteresis", rate, h.friction)
        return direction * h.friction - held, direction * h.friction * rate
    forward = sp.Heaviside(h.force - h.friction, 1) * sp.Heaviside(rate, 1)
    backward = sp.Heaviside(-h.force - h.friction, 1) * sp.Heaviside(-rate, 1)
    slips = forward + backward
    yield Rate(h.force, h.stiffness * rate * (1 - slips))
    yield Force(twist, h.force)
    yield Energy(stored=h.force**2 / (2 * h.stiffness), loss=slips * h.force * rate)
    return h.force, slips * h.force * rate


class Damper(Block):
    """Massless damper between two flanges: torque on b = -c w_rel.

        a o---[]--o b        w_rel = w_b - w_a

    Example:
        rig = gb.Drivetrain("disc that slows down")
        disc = rig.add("disc", gb.Inertia(J=0.01, w0=50.0))
        rig.chain(rig.add("ground", gb.Fixed()), rig.add("damper", gb.Damper(c=0.2)), disc)
    """

    a, b = Flange("left end", slider=None), Flange("right end", slider=None)
    c: Value = param("torsional damping", "N m s/rad", ge=0)
    heat: HeatPort | None = HEAT

    def physics(self, s: Any) -> Iterator[Contribution]:
        """torque = c w_rel."""
        rate = s.b.w - s.a.w
        yield Force(s.b.phi - s.a.phi, s.named("T", s.c * rate, "torque of the damper", "N m"))
        yield Energy(loss=s.c * rate**2)
        yield Shows("w_rel", rate, "rad/s", "slip w_b - w_a")
        yield Shows("torque", -s.c * rate, "N m", "torque on flange b")
        yield Shows("loss_power", s.c * rate**2, "W", "power lost")


class Lash(Block):
    r"""Torsional spring with a gap: twist = phi_b - phi_a, no torque while abs(twist) <= half_gap.

        a o---| |-/\/\/---o b        twist > 0 pulls a forward and b back

    In place of half_gap the ends of the gap may be given: no torque while lower <= twist <= upper; one of them alone is a
    contact on one side (Modelica's ElastoGap: lower = its free length s_rel0). rest: all is measured from there, twist -
    rest for the twist. phi_rel0, w_rel0: as of `Shaft`. exponent n >= 1: the elastic torque k g abs(g)^(n - 1), g the twist
    beyond the gap, k then in N m/rad^n. Without compliance it is a rigid tie, or with contact_damping=HuntCrossley(...) a
    rigid impact of that restitution at both ends of the gap.

    Example:
        rig = gb.Drivetrain("coupling with play")
        left, right = rig.add("left", gb.Inertia(J=0.02, w0=1.0)), rig.add("right", gb.Inertia(J=0.05))
        rig.chain(left, rig.add("lash", gb.Lash(k=1.0e4, half_gap="0.5 deg", c=2.0)), right)
    """

    a, b = Flange("left end", slider=None), Flange("right end", slider=None)
    k: Value | None = param("torsional stiffness in contact", "N m/rad", gt=0, belongs_to="compliance")
    half_gap: Value | None = param(
        "half of the free play", "rad", default=None, ge=0, belongs_to="backlash", or_one_of=("lower", "upper")
    )
    lower: Value | None = param(
        "least twist without torque", "rad", default=None, belongs_to="backlash", symbol="theta_min"
    )
    upper: Value | None = param(
        "largest twist without torque", "rad", default=None, belongs_to="backlash", symbol="theta_max"
    )
    rest: Value | None = param(
        "twist that the others are measured from", "rad", default=None, belongs_to="compliance", symbol="theta_0"
    )
    phi_rel0: Value | None = param("start twist", "rad", default=None, belongs_to="compliance", start="relative angle")
    w_rel0: Value | None = param(
        "start rate of the twist", "rad/s", default=None, belongs_to="compliance", start="relative speed"
    )
    exponent: Value | None = param("exponent of the twist beyond the gap", default=None, ge=1, belongs_to="compliance")
    c: Value | None = param("torsional damping", "N m s/rad", default=None, ge=0, belongs_to="damping")
    damping_ratio: Value | None = param("damping ratio on the bodies beside", default=None, ge=0, belongs_to="damping")
    contact_damping: str | HuntCrossley = option(
        "damping and gap: 'clipped', 'clipped_force', 'always' or HuntCrossley",
        default="clipped",
        belongs_to="damping",
        turns=True,
    )
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting fields."""
        yield from damping_problems(self)
        ends = [name for name in ("lower", "upper") if getattr(self, name) is not None]
        if self.half_gap is not None and ends:
            yield f"half_gap and {' and '.join(ends)} are both given; give half_gap, or the ends of the gap"
        lower, upper = constant_value(self.lower), constant_value(self.upper)
        if len(ends) == 2 and lower > upper:
            yield f"lower = {lower!r} rad must be <= upper = {upper!r} rad"
        if self.damping_ratio is not None and self.exponent is not None:
            yield "damping_ratio needs a stiffness that does not depend on the twist; give c"
        if self.k is None and (self.rest is not None or self.exponent is not None) and not hits(self):
            yield "rest and exponent need k: a rigid lash keeps the angle between its sides as it is"
        if self.k is None and (self.phi_rel0 is not None or self.w_rel0 is not None):
            yield "phi_rel0 and w_rel0 need k; give start values to the bodies beside"

    def without_effect(self, name: str) -> Block:
        """Without compliance a restitution stays, as that of a rigid impact; without the gap the spring rests at the end, or
        in the middle between both."""
        changed = without(self, name, super().without_effect(name))
        ends = [x for x in (self.lower, self.upper) if x is not None]
        if name != "backlash" or not ends or self.k is None:
            return changed
        middle = ends[0] if len(ends) == 1 else (as_expr(ends[0]) + as_expr(ends[1])) / 2
        rest = middle if self.rest is None else as_expr(self.rest) + as_expr(middle)
        number = constant_value(rest)
        moved = changed.changed(rest=rest if any(leaf.op == "parameter" for leaf in as_expr(rest).leaves()) else number)
        assert isinstance(moved, Block)
        return moved

    def gives_way(self, flange: str) -> tuple[str, float] | None:  # noqa: ARG002  both ends alike
        """Its compliance."""
        return None if self.k is None else ("compliance", number_or_zero(self.k))

    def undeformed(self) -> dict[str, str]:
        """Its rest, and the ends of its gap where they are given."""
        return {name: name for name in ("rest", "lower", "upper") if getattr(self, name) is not None}

    def would_show(self, effect: str) -> Iterator[Watch]:
        """Without free play the torque changes its sign where the sides would part."""
        if effect == "backlash":
            yield Watch("torque", "the torque changes its sign, where the sides would part")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """torque = k g(twist) + damping."""
        twist, rate = s.b.phi - s.a.phi, s.b.w - s.a.w
        if self.k is not None:
            twist, rate = s.named("theta", twist, "twist", "rad"), s.named("theta'", rate, "rate of the twist", "rad/s")
        yield Shows("twist", twist, "rad", "twist phi_b - phi_a")
        strain = twist if self.rest is None else twist - s.rest
        if hits(self):
            force = yield from impact(self, s, strain, 1)
            yield Shows("torque", -force, "N m", "torque on flange b")
            return
        if self.k is None:
            yield Tie(twist)
            yield Shows("torque", s.b.tau, "N m", "torque on flange b")
            return
        c = damping(s, s.k, s.a.mobility + s.b.mobility, unit="N m s/rad", body="J_e")
        gap: Any = None if self.half_gap is None else Backlash(half_gap=self.half_gap)
        if self.lower is not None or self.upper is not None:
            gap = Play(s.lower, s.upper)
        choice = self.contact_damping, s.contact_damping
        for item in contact(s, Contact(strain, rate, s.k, c, gap, s, *choice, "T", s.exponent)):
            yield item
            if isinstance(item, Force):
                yield Shows("torque", -item.force, "N m", "torque on flange b")
