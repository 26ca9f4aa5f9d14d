"""Planetary gearboxes with rigid teeth: a stepped planet, Simpson's three speeds, Ravigneaux's four.

Each function takes the gear that is in: brakes and clutches are closed for good (a shaft held by the ground, two shafts
joined), so these trains show ratios, torques and reflected inertias, not shifts. One planet stands for all planets of
its kind, with the sum of their inertias. Tooth counts are plausible, not those of a product.

Angles count about one axis, turning the same way for all shafts; a negative ratio turns the output backwards.
"""

from __future__ import annotations

import gearblocks as gb

INPUT, LOAD, SUN, PLANET, CARRIER, RING = 0.08, 1.5, 1.0e-3, 2.0e-4, 8.0e-3, 1.2e-2
"""Moments of inertia, kg m2."""


def build() -> gb.Drivetrain:
    """Ravigneaux's set in its first gear."""
    return ravigneaux()


def compound() -> gb.Drivetrain:
    """A stepped planet: sun 20 drives the large step 40, the small step 16 rolls in ring 76, which is held.

    Input: sun; output: carrier; ratio 1 + (40 76)/(20 16) = 10.5.
    """
    rig = gb.Drivetrain("stepped planet")
    sun, planet, ring, carrier = _bodies(rig, sun=SUN, planet=3 * PLANET, ring=RING, carrier=CARRIER)
    _mesh(rig, "sun_mesh", sun, planet, carrier, (20, 40), external=True)
    _mesh(rig, "ring_mesh", planet, ring, carrier, (16, 76), external=False)
    _hold(rig, ring)
    return _driven(rig, [sun], carrier)


def simpson(gear: int = 1) -> gb.Drivetrain:
    """Simpson's set: two equal simple sets (sun 28, ring 70) on one sun; gears 1, 2, 3 and -1 (reverse).

    The output is the first carrier with the second ring. With rho = 28/70: ratio 2 + rho with the second carrier held,
    1 + rho with the sun held, 1 with the first ring and the sun joined, -1/rho with the second carrier held and the sun
    driven; the first ring is driven forward.
    """
    rig = gb.Drivetrain(f"Simpson, gear {gear}")
    sun, ring, output, carrier = _bodies(rig, sun=2 * SUN, ring1=RING, output=RING + CARRIER, carrier2=CARRIER)
    first, second = (rig.add(f"set{i}", gb.IdealPlanetary(ratio=70 / 28)) for i in (1, 2))
    rig.connect(sun.b, first.sun, second.sun)
    rig.connect(ring.b, first.ring)
    rig.connect(output.b, first.carrier, second.ring)
    rig.connect(carrier.b, second.carrier)
    if gear in (1, -1):
        _hold(rig, carrier)
    elif gear == 2:
        _hold(rig, sun)
    elif gear != 3:
        raise gb.ModelError(f"gear = {gear!r} must be 1, 2, 3 or -1")
    return _driven(rig, {-1: [sun], 3: [ring, sun]}.get(gear, [ring]), output)


def ravigneaux(gear: int = 1) -> gb.Drivetrain:
    """Ravigneaux's set: small sun 30, short planet 20, long planet 20, large sun 36, ring 76; gears 1 .. 4 and -1.

    The short planets mesh with the small sun and the long ones, these with the large sun and the ring, all on one
    carrier; the ring is the output. With a = 76/30 and b = 76/36: ratio a with the carrier held, (a + b)/(1 + b) with
    the large sun held, 1 with both suns joined, b/(1 + b) with the carrier driven and the large sun held, -b with
    the large sun driven and the carrier held; the small sun is driven in gears 1 to 3.
    """
    rig = gb.Drivetrain(f"Ravigneaux, gear {gear}")
    small, large, short, long = _bodies(rig, small=SUN, large=SUN, short=3 * PLANET, long=3 * PLANET)
    carrier, ring = _bodies(rig, carrier=CARRIER, ring=RING)
    _mesh(rig, "small_mesh", small, short, carrier, (30, 20), external=True)
    _mesh(rig, "planet_mesh", short, long, carrier, (20, 20), external=True)
    _mesh(rig, "large_mesh", large, long, carrier, (36, 20), external=True)
    _mesh(rig, "ring_mesh", long, ring, carrier, (20, 76), external=False)
    if gear in (1, -1):
        _hold(rig, carrier)
    elif gear in (2, 4):
        _hold(rig, large)
    elif gear != 3:
        raise gb.ModelError(f"gear = {gear!r} must be 1, 2, 3, 4 or -1")
    return _driven(rig, {-1: [large], 3: [small, large], 4: [carrier]}.get(gear, [small]), ring)


def _bodies(rig: gb.Drivetrain, **inertias: float) -> list[gb.Inertia]:
    return [rig.add(name, gb.Inertia(J=J)) for name, J in inertias.items()]


def _mesh(
    rig: gb.Drivetrain, name: str, pinion: gb.Inertia, wheel: gb.Inertia, carrier: gb.Inertia, teeth: tuple[int, int], *,
    external: bool,
) -> None:  # fmt: skip
    """A rigid mesh on the carrier."""
    mesh = rig.add(name, gb.GearMesh(teeth=teeth, external=external))
    rig.connect(pinion.b, mesh.pinion)
    rig.connect(mesh.wheel, wheel.a)
    rig.connect(mesh.carrier, carrier.a)


def _hold(rig: gb.Drivetrain, body: gb.Inertia) -> None:
    rig.connect(rig.add("brake", gb.Fixed()).flange, body.a)


def _driven(rig: gb.Drivetrain, inputs: list[gb.Inertia], output: gb.Inertia) -> gb.Drivetrain:
    """100 N m on the input inertia, which sits on all `inputs`; a load inertia on the output."""
    engine, load = _bodies(rig, engine=INPUT, load=LOAD)
    rig.connect(rig.add("drive", gb.Torque(tau=100.0)).flange, engine.a)
    rig.connect(engine.b, *(body.a for body in inputs))
    rig.connect(output.a, load.a)
    return rig
