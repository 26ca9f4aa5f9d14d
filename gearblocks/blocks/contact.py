"""Compliant contact: N = k(.) g(x) + d(x, x'), with dead zone g, damping d, and excitation by stiffness and error.

The law that meshes, splines, lashes and non-circular gears share. Knows nothing of their geometry.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from typing import Any

from gearblocks.blocks.effects import Backlash, Fourier, HuntCrossley, Superposition
from gearblocks.blocks.play import Play
from gearblocks.language.contributions import Acts, Contribution, Energy, Force, Hold, Rate, Shows, Switch


@dataclass(frozen=True, slots=True)
class Contact:
    """Symbols of one contact. x: deflection; rate: its rate; k: stiffness with variation; c: damping or None.

    gap: the backlash or None, with its symbols; choice: what damping does in the gap; force: what readers call the force;
    exponent: of the deflection beyond the gap, k g abs(g)^(n - 1), or None for 1.
    """

    x: Any
    rate: Any
    k: Any
    c: Any
    gap: Backlash | Play | None
    gap_symbols: Any
    choice: str | HuntCrossley
    choice_symbols: Any
    force: str = "N"
    exponent: Any = None


def damping(s: Any, k: Any, compliance_of_bodies: Any, *, unit: str = "N s/m", body: str = "m_e") -> Any:
    """c, given or from the damping ratio: c = 2 zeta sqrt(k / sum(r^2/J)); None when absent. unit: of c; body: name of the
    body that would swing as both do, 1/sum(r^2/J)."""
    import sympy as sp

    if s.damping_ratio is None:
        return s.c
    if s.reading:
        of = "kg" if body == "m_e" else "kg m2"
        at = s.named(body, 1 / compliance_of_bodies, "inertia of both sides against each other", of)
        return s.named("c", 2 * s.damping_ratio * sp.sqrt(k * at), "damping", unit)
    return 2 * s.damping_ratio * sp.sqrt(k / compliance_of_bodies)


def damping_problems(block: Any) -> Iterator[str]:
    """c and damping_ratio together, and choices of contact damping that do not exist or do not fit the backlash."""
    if block.c is not None and block.damping_ratio is not None:
        yield "c and damping_ratio are both given; give one of them"
    choice = block.contact_damping if "contact_damping" in type(block).fields else "clipped"
    gap = getattr(block, "backlash", None)
    damped = block.c is not None or block.damping_ratio is not None
    if isinstance(choice, HuntCrossley):
        yield from _impact_problems(block, damped)
    elif choice not in ("clipped", "clipped_force", "always"):
        yield f"contact_damping = {choice!r} must be 'clipped', 'clipped_force', 'always' or gb.HuntCrossley(...)"
    elif damped and choice != "always" and gap is not None and gap.law == "polynomial":
        yield f"contact_damping = {choice!r}: a polynomial has no gap to tell contact by; give contact_damping='always'"
    elif damped and choice == "clipped_force" and gap is not None and gap.law == "smooth":
        yield f"contact_damping = {choice!r}: a smooth law has no gap to tell contact by; give 'clipped' or 'always'"


def variation_problems(block: Any) -> Iterator[str]:
    """A stiffness that its variation takes below 0 in part of the cycle."""
    variation = block.stiffness_variation
    if variation is None or (isinstance(variation, Fourier) and variation.amplitudes() <= 1):
        return
    least = variation.least()
    if least < -1 - 1e-12:
        yield (
            f"stiffness_variation: in part of its cycle the stiffness is {1 + least:.3g} times k, below 0, and pushes the "
            "teeth ever further apart; give a variation that stays above -1 (it is relative to k: divide what is in N/m by k)"
        )


def _impact_problems(block: Any, damped: bool) -> Iterator[str]:
    """Problems of damping by Hunt and Crossley: it needs corners, and no other damping beside it."""
    gap = getattr(block, "backlash", None)
    if damped:
        yield "contact_damping=HuntCrossley(...) takes the place of c and damping_ratio; leave these out"
    ends = (getattr(block, name, None) for name in ("half_gap", "lower", "upper"))
    if all(end is None for end in ends) and (gap is None or gap.law != "exact"):
        yield "contact_damping=HuntCrossley(...) needs a contact that starts: give backlash with law='exact'"


def theta_of(block_effect: Any, s: Any, mesh_angle: Any, time: Any) -> tuple[Any, list[Contribution]]:
    """The phase of an excitation and the contributions it needs.

    mesh_angle: angle of the teeth in rad of the mesh cycle. A constant frequency gives w t, a varying one is integrated.
    """
    phase = 0 if s.phase is None else s.phase
    if block_effect.driven_by == "angle":
        return mesh_angle + phase, []
    if s.is_constant("driven_by"):
        return s.driven_by * time + phase, []
    return s.angle + phase, [Rate(s.angle, s.driven_by)]


def error_of(excitation: Any, s: Any, mesh_angle: Any, time: Any) -> tuple[Any, list[Contribution]]:
    """A transmission error, or the sum of several, and the contributions that their phases need."""
    if isinstance(excitation, Superposition):
        first, of_first = error_of(excitation.first, s.first, mesh_angle, time)
        second, of_second = error_of(excitation.second, s.second, mesh_angle, time)
        return first + second, [*of_first, *of_second]
    theta, rates = theta_of(excitation, s, mesh_angle, time)
    return excitation.value(s, theta), rates


def contact(s: Any, law: Contact) -> Iterator[Contribution]:
    """Force, switches, energy and the common outputs of a contact.

    Damping in a dead zone: "clipped" d = c x' within +-k abs(g), "clipped_force" max(k g + c x', 0) on the drive side
    (min on the coast side), "always" c x' in the gap too. What a clipped spring gives away is counted as loss.
    """
    import sympy as sp

    x, gap, symbols = law.x, law.gap, law.gap_symbols
    g, potential = _risen(law, *deflection_and_potential(law))
    side, pushing = sp.Integer(1), sp.Integer(1)
    if gap is not None:
        side = symbols.named("side", gap.side(symbols, x), "side of the contact: 1 drive, -1 coast, 0 none")
        pushing = symbols.named("sign_g", gap.pushing_side(symbols, x), "sign of the deflection beyond the gap")
        yield from gap.watches(symbols, x)
    elastic = law.k * g
    drag: Any = 0
    if isinstance(law.choice, HuntCrossley):
        drag = yield from _impact(law, elastic, pushing)
    elif law.c is not None:
        viscous = law.c * law.rate
        choice = "always" if gap is None else law.choice
        drag = _DRAG[choice](elastic, viscous, pushing)
        yield from _clip_switches(choice, elastic, viscous, pushing)
    if drag != 0:
        yield Shows("loss_power", drag * law.rate, "W", "power lost in the contact")
    total = elastic + drag
    if s.reading:
        total = s.named(law.force, _for_reading(s, law, elastic, pushing), *_UNITS[law.force][0])
    yield Force(x, total)
    yield Energy(stored=law.k * potential, loss=drag * law.rate if drag != 0 else None)
    yield Shows("contact", side, "1", "-1 coast side, 0 none, +1 drive side")
    if gap is not None and gap.gaps is not None:
        yield Shows("engaged_teeth", gap.engaged(symbols, x), "1", "teeth that carry load")


def _risen(law: Contact, g: Any, potential: Any) -> tuple[Any, Any]:
    """g abs(g)^(n - 1) and its integral."""
    from gearblocks.laws.functions import SignedPower

    if law.exponent is None:
        return g, potential
    return SignedPower(g, law.exponent, 0), SignedPower(g, law.exponent, -1)


def deflection_and_potential(law: Contact) -> tuple[Any, Any]:
    """g(x), and its integral; people read them by their names."""
    x, gap, symbols = law.x, law.gap, law.gap_symbols
    if gap is None:
        return x, x**2 / 2
    g, potential = gap.deflection(symbols, x), gap.potential(symbols, x)
    if not symbols.reading:
        return g, potential
    unit = _UNITS[law.force][1]
    g = symbols.named("g", g, "deflection beyond the gap", unit)
    exact = gap.law == "exact" and gap.gaps is None
    return g, g**2 / 2 if exact else symbols.named("G", potential, "g integrated", f"{unit}2")


_UNITS = {
    "N": (("force of the contact", "N"), "m"),
    "T": (("torque of the contact", "N m"), "rad"),
    "M": (("moment of the contact", "N m"), "rad"),
}
"""Words and unit of the force of a contact, and the unit of its deflection."""


def _for_reading(s: Any, law: Contact, elastic: Any, pushing: Any) -> Any:
    """The force as people write it, without the switches that locate its corners."""
    import sympy as sp

    if isinstance(law.choice, HuntCrossley):
        of = law.choice_symbols
        growth = s.named("chi", _growth(of), "damping per speed into the contact", f"s/{_UNITS[law.force][1]}")
        return elastic * sp.Max(0, 1 + growth * pushing * law.rate)
    if law.c is None:
        return elastic
    viscous = law.c * law.rate
    if law.gap is None or law.choice == "always":
        return elastic + viscous
    if law.choice == "clipped":
        limit = sp.Abs(elastic)
        (force, unit), _ = _UNITS[law.force]
        return elastic + s.named("d", sp.Max(-limit, sp.Min(viscous, limit)), f"damping part of the {force}", unit)
    if law.gap.gaps is not None:
        return pushing * sp.Max(0, pushing * (elastic + viscous))
    if isinstance(law.gap, Play):
        lower, upper = law.gap.lower, law.gap.upper
    else:
        lower, upper = -law.gap_symbols.half_gap, law.gap_symbols.half_gap
    above = [] if upper is None else [(sp.Max(0, elastic + viscous), law.x > upper)]
    below = [] if lower is None else [(sp.Min(0, elastic + viscous), law.x < lower)]
    return sp.Piecewise(*above, *below, (0, True))


def _growth(s: Any) -> Any:
    """chi of Hunt and Crossley: the damping of a restitution over the speed at which the present contact began."""
    from gearblocks.laws.functions import RestitutionDamping

    return RestitutionDamping(s.restitution) * s.slowness


def _clipped(elastic: Any, viscous: Any, side: Any) -> Any:
    import sympy as sp

    bound = elastic * side
    above, below = sp.Heaviside(viscous + bound, 1), sp.Heaviside(bound - viscous, 1)
    return side**2 * (above * below * viscous - (1 - above) * bound + (1 - below) * bound)


def _clipped_force(elastic: Any, viscous: Any, side: Any) -> Any:
    import sympy as sp

    pushing = sp.Heaviside((elastic + viscous) * side, 1)
    return side**2 * (pushing * viscous - (1 - pushing) * elastic)


def _impact(law: Contact, elastic: Any, side: Any) -> Generator[Contribution, None, Any]:
    """The damping of Hunt and Crossley, and the approach speed that each contact keeps."""
    import sympy as sp

    inward, s = side * law.rate, law.choice_symbols
    factor = 1 + _growth(s) * inward
    yield Switch("pushing", factor, when=side**2)
    approaching = 1 - sp.Heaviside(-inward, 1)
    slowness = 1 / inward if s.reading else approaching / (approaching * inward + 1 - approaching)
    yield Hold(s.slowness, slowness, side, inverse_speed=True)
    return elastic * (sp.Heaviside(factor, 1) * factor - 1)


_DRAG: dict[str, Callable[[Any, Any, Any], Any]] = {
    "always": lambda _elastic, viscous, _side: viscous,
    "clipped": _clipped,
    "clipped_force": _clipped_force,
}


def _clip_switches(choice: str, elastic: Any, viscous: Any, side: Any) -> Iterator[Switch]:
    if choice == "clipped":
        bound = elastic * side
        yield Switch("damping above -k g", viscous + bound, when=side**2)
        yield Switch("damping below k g", bound - viscous, when=side**2)
    elif choice == "clipped_force":
        yield Switch("pushing", (elastic + viscous) * side, when=side**2)


@dataclass(frozen=True, slots=True)
class Line:
    """A deflection along a line, without error: lever [m], its rate, k, c (or None), and the angle of the teeth that
    drives excitations (rad of the mesh cycle)."""

    lever: Any
    speed: Any
    k: Any
    c: Any
    angle: Any


def mesh(block: Any, s: Any, line: Line) -> Iterator[Contribution]:
    """Compliant mesh along a line, with excitation: x = lever - e, N = c x' + k (1 + variation) g(x); of gears and splines."""
    import sympy as sp

    error: Any = sp.Integer(0)
    error_rate: Any = sp.Integer(0)
    factor: Any = sp.Integer(1)
    if block.stiffness_variation is not None:
        theta, rates = theta_of(block.stiffness_variation, s.stiffness_variation, line.angle, s.time)
        yield from rates
        varying = block.stiffness_variation.value(s.stiffness_variation, theta)
        if varying.is_Piecewise:
            varying = s.named("v", varying, "variation of the stiffness")
        factor += varying
    excitation = getattr(block, "transmission_error", None)
    if excitation is not None:
        error, rates = error_of(excitation, s.transmission_error, line.angle, s.time)
        yield from rates
        error_rate = s.rate_of(error, rates)
    if error != 0:
        error = s.named("e", error, "no-load transmission error", "m")
    x = s.named("x", line.lever - error, "deflection", "m")
    rate = s.named("x'", line.speed - error_rate, "rate of the deflection", "m/s")
    stiffness = s.named("k_t", line.k * factor, "stiffness with its variation", "N/m")
    law = Contact(x, rate, stiffness, line.c, block.backlash, s.backlash, block.contact_damping, s.contact_damping)
    for item in contact(s, law):
        yield item
        if isinstance(item, Force):
            yield Shows("force", item.force, "N", "mesh force N, positive on the drive side")
    if block.stiffness_variation is not None and block.stiffness_variation.driven_by == "angle":
        yield from _parametric_torque(block, s, law, line.k * factor)
    yield Shows("deflection", x, "m", "deflection along the line of action")
    yield Shows("dynamic_transmission_error", x + error, "m", "deflection without the no-load error")
    yield Shows("deflection_rate", rate, "m/s", "rate of the deflection")
    yield Shows("stiffness", stiffness, "N/m", "stiffness with its variation")
    yield Shows("mesh_phase", sp.frac(line.angle / (2 * sp.pi)), "1", "position inside the mesh cycle, in [0, 1)")


def _parametric_torque(block: Any, s: Any, law: Contact, k: Any) -> Iterator[Contribution]:
    """-dk/dphi G(x) on every flange whose angle k depends on; k is written out (law.k may be a name for it)."""
    potential = deflection_and_potential(law)[1]
    slopes = {name: s.slope(k, getattr(s, name)) for name in type(block).flanges}
    first = next((slope for slope in slopes.values() if slope != 0), 0)
    named = s.named("kappa", first, "slope of the stiffness over the angle", "N/m")
    for name, slope in slopes.items():
        if slope != 0:
            opposite = slope == -first or (s.reading and (slope + first).expand() == 0)
            of = named if slope == first else -named if opposite else slope
            yield Acts(getattr(s, name), -of * potential)
