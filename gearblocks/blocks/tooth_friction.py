"""Sliding friction of the teeth of a mesh (Vaishya and Singh 2003): torques -F rho_i of the pairs in contact."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from gearblocks.blocks.contact import Line, theta_of
from gearblocks.geometry.involute import ToothPair
from gearblocks.language.contributions import Acts, Contribution, Energy, Force, Shows, Switch


def with_tooth_friction(
    block: Any, s: Any, found: Iterable[Contribution], line: Line, pair: ToothPair
) -> Iterator[Contribution]:
    """The contributions of a mesh together with those of its friction (see `gearblocks.ToothFriction`)."""
    items = list(found)
    (force,) = (x for x in items if isinstance(x, Force))
    if block.friction.direction == "square_wave":
        extra = s.friction.mu * s.friction.wave * force.force
        yield from (Force(x.deflection, x.force + extra) if x is force else x for x in items)
        yield Shows("friction_force", extra, "N", "friction along the line of action")
        return
    lost = [x.expr for x in items if isinstance(x, Shows) and x.name == "loss_power"]
    yield from (x for x in items if not (isinstance(x, Shows) and x.name == "loss_power"))
    for item in _sliding(block, s, force, line, pair):
        if isinstance(item, Shows) and item.name == "loss_power":
            item = Shows(item.name, sum(lost, item.expr), item.unit, item.words)
        yield item


def _pressing(block: Any, s: Any, force: Force) -> Any:
    """The size of the normal force, without a switch of its own where the contact tells the sign."""
    import sympy as sp

    if block.backlash is None or block.contact_damping == "always":
        return sp.Abs(force.force)
    side = block.backlash.pushing_side(s.backlash, force.deflection)
    return s.named("side_N", side, "sign of the force of the contact") * force.force


def _sliding(block: Any, s: Any, force: Force, line: Line, pair: ToothPair) -> Iterator[Contribution]:
    """Friction forces of the pairs in contact, on their own lever arms."""
    import sympy as sp

    theta, rates = theta_of(block.friction, s.friction, line.angle, s.time)
    yield from rates
    turned = block.friction.driven_by == "angle" and block.friction.flank == "coast"
    cycles = s.named("u", (-theta if turned else theta) / (2 * sp.pi), "turn of the teeth, in mesh cycles")
    entered = sp.floor(cycles)
    approach, pitch, arms = pair.path[0], pair.base_pitch, pair.lever_arms
    double = entered - sp.floor(cycles - (pair.contact_ratio - 1))
    double = s.named("two_pairs", double, "1 while two pairs are in contact, else 0")
    normal = s.friction.mu * _pressing(block, s, force)
    flanges = (s.pinion, s.wheel)
    torques: list[Any] = [0, 0]
    total: Any = 0
    lost: Any = 0
    for j, share in enumerate((1 - double / 2, double / 2)):
        place = pitch * (cycles - entered + j) - approach
        place = s.named(f"xi_{j + 1}", place, f"place of contact of pair {j + 1}, from the pitch point", "m")
        radii = arms[0] + place, arms[1] - place
        slip = sum(rho * (flange.w - s.carrier.w) for rho, flange in zip(radii, flanges, strict=True))
        slip = s.named(f"v_{j + 1}", slip, f"sliding speed of pair {j + 1}", "m/s")
        if s.friction.transition is None:
            direction = sp.sign(slip)
            yield Switch(f"sliding of pair {j + 1}", slip, when=double if j else 1, low=-1.0, high=1.0)
        else:
            direction = slip / sp.sqrt(slip**2 + s.friction.transition**2)
        rubbing = s.named(f"F_{j + 1}", normal * share * direction, f"friction force of pair {j + 1}", "N")
        torques = [tau - rubbing * rho for tau, rho in zip(torques, radii, strict=True)]
        total += rubbing
        lost += rubbing * slip
        if j == 0:
            yield Shows("sliding_speed", slip, "m/s", "sliding of the pair that came last, < 0 before the pitch point")
    for flange, tau in zip(flanges, torques, strict=True):
        yield Acts(flange, tau)
    yield Acts(s.carrier, -torques[0] - torques[1])
    yield Energy(loss=lost)
    yield Shows("friction_force", total, "N", "friction across the line of action, of all pairs")
    yield Shows("loss_power", lost, "W", "power lost in the contact")
