"""What the other families draw seldom or never: fluid, creep, tyres, planetary gears with meshes, friction of teeth, phases
that move, shafts in segments, prescribed motion, self-locking worms, static starts, and laws of many conditions.
"""

from __future__ import annotations

import math
from typing import Any

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, any_signal, digits, given_input, smooth_signal
from tests.random.expressions import TIME, Node, call, cases, either, sense, table, thing
from tests.random.families import meshes, pieces
from tests.random.families.lossy import lossy_gear


def wide(seed: int) -> Train:
    """One or two components of a few bodies, with one to four of what is drawn seldom."""
    g = Growth("wide", seed)
    d = g.d
    still = d.chance(0.12)
    bodies: list[str] = []
    for _ in range(d.choice((1, 1, 1, 2))):
        component = [g.body(w0=None if still else g.speed())]
        for _ in range(d.randint(0, 2)):
            _extend(g, component, still)
        _special(g, component, still)
        if still or d.chance(0.3):
            pieces.shaft(g, component[0], GROUND)
        bodies += component
    for _ in range(d.randint(1, 2)):
        node = d.choice(bodies)
        if still:
            pieces.torque(g, node, d.either_sign(pieces.torque_size(g, node)))
        else:
            pieces.torque(g, node, law(g, node) if d.chance(0.6) else None)
    if still:
        g.initial = "static"
    elif d.chance(0.3):
        pieces.damper(g, d.choice(bodies), GROUND)
    return g.train()


def _extend(g: Growth, bodies: list[str], still: bool) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.25:
        bodies.append(pieces.gear(g, a))
        return
    b = g.body(w0=None if still else g.speed())
    bodies.append(b)
    if still or kind < 0.6:
        pieces.shaft(g, a, b)
    elif kind < 0.75:
        pieces.dry(g, a, b)
    elif kind < 0.85:
        pieces.lash(g, a, b)
    elif kind < 0.92:
        pieces.hysteresis_shaft(g, a, b)
    else:
        meshes.mesh(g, a, b, gap=True)


def _special(g: Growth, bodies: list[str], still: bool) -> None:
    d, a = g.d, g.d.choice(bodies)
    at_rest = (segments, planetary_gear)
    moving = (
        converter,
        belt,
        vehicle,
        planetary_gear,
        rubbing_mesh,
        segments,
        moving_phase,
        prescribed,
        worm,
        uneven_gear,
    )
    for _ in range(d.randint(1, 2)):
        bodies += d.choice(at_rest if still else moving)(g, a)


# -- elements ---------------------------------------------------------------------------------------------------------


def converter(g: Growth, a: str) -> list[str]:
    """A torque converter to a body of its own."""
    d, b = g.d, g.body(w0=g.speed())
    w = d.log(5.0, 50.0)
    size = digits(pieces.torque_size(g, a) / w**2)
    top = d.even(1.2, 2.6)
    capacity = table((0.0, 0.5, 0.8, 1.0), (size, digits(0.95 * size), digits(0.6 * size), 0.0))
    ratio = table((0.0, 0.4, 0.85, 1.0), (top, digits(0.5 + 0.5 * top), 1.0, d.choice((1.0, 0.97))))
    g.add("converter", "TorqueConverter", {"impeller": a, "turbine": b}, capacity=capacity, ratio=ratio)
    pieces.torque(g, a, d.either_sign(digits(size * w**2)))
    return [b]


def belt(g: Growth, a: str) -> list[str]:
    """A belt that creeps."""
    d, b = g.d, g.body(w0=g.speed())
    size = pieces.torque_size(g, a)
    slip = {"stiffness": digits(size * d.log(3.0, 100.0)), "low_speed": d.log(0.1, 3.0)}
    if d.chance(0.5):
        slip["limit"] = digits(size * d.log(0.3, 3.0))
    g.add("belt", "BeltDrive", {"a": a, "b": b}, ratio=abs(d.ratio()), slip=thing("Creep", **slip))
    return [b]


def vehicle(g: Growth, a: str) -> list[str]:
    """A vehicle on tyres."""
    d = g.d
    mass, radius = d.log(0.5, 20.0), d.choice((0.1, 0.3))
    slip = {"stiffness": digits(mass * 9.8 * d.log(2.0, 30.0)), "grip": d.even(0.3, 1.1), "low_speed": d.log(0.05, 1.0)}
    if d.chance(0.4):
        slip["shape"] = d.even(1.1, 1.9)
    rolling = d.choice((None, d.log(0.005, 0.1)))
    g.add("car", "Vehicle", {"flange": a}, mass=mass, wheel_radius=radius, drag_area=d.choice((None, d.log(0.1, 3.0))),
          rolling=rolling, rolling_speed=None if rolling is None else d.log(0.05, 1.0),
          grade=d.choice((None, None, d.even(-0.2, 0.2))), tyre=thing("TyreSlip", **slip))  # fmt: skip
    return []


def planetary_gear(g: Growth, a: str) -> list[str]:
    """Planets with their meshes; ring on the ground or a body, carrier a body."""
    d = g.d
    z_sun, z_planet, planets = d.choice(((24, 18, 3), (20, 16, 3), (30, 15, 3), (24, 12, 4), (18, 15, 3)))
    z_ring = z_sun + 2 * z_planet
    if (z_sun + z_ring) % planets:
        z_sun, z_planet, planets = 24, 18, 3
        z_ring = 60
    carrier = g.body(w0=None)
    ring = GROUND if d.chance(0.6) else g.body(w0=None)
    module = d.choice((0.002, 0.004, 0.01))
    radius, planet = module * z_sun / 2 * math.cos(0.35), d.log(0.002, 0.1)
    laws = {}
    for name in ("sun_mesh", "ring_mesh"):
        fields: dict[str, Any] = {"k": digits(planet / radius**2 * d.log(20.0, 100.0) ** 2)}
        if d.chance(0.8):
            fields["c"] = digits(2 * d.log(0.01, 0.3) * (fields["k"] * planet) ** 0.5 / radius)
        if d.chance(0.4):
            fields["stiffness_variation"] = thing("Fourier", cos=(d.even(0.05, 0.3),))
        if d.chance(0.25):
            fields["transmission_error"] = thing("Harmonic", cos=(digits(radius * d.log(0.0005, 0.005)),))
        if d.chance(0.3):
            fields["backlash"] = thing("Backlash", half_gap=digits(radius * d.log(0.001, 0.02)))
        laws[name] = thing("MeshLaw", **fields)
    at = {"sun": a, "ring": ring, "carrier": carrier}
    g.add("set", "PlanetaryGear", at, z_sun=z_sun, z_planet=z_planet, z_ring=z_ring, planets=planets, module=module,
          pressure_angle=0.35, planet_inertia=planet, planet_mass=d.choice((None, 0.3)), **laws)  # fmt: skip
    return [carrier] if ring == GROUND else [carrier, ring]


def rubbing_mesh(g: Growth, a: str) -> list[str]:
    """A mesh whose teeth rub."""
    d, b = g.d, g.body(w0=g.speed())
    teeth, module = (d.choice((19, 23)), d.choice((31, 40))), d.choice((0.002, 0.005))
    half = module * math.cos(0.35) / 2
    reduced = 1.0 / ((half * teeth[0]) ** 2 / g.inertia[a] + (half * teeth[1]) ** 2 / g.inertia[b])
    k = digits(reduced * d.log(15.0, 100.0) ** 2)
    mu = d.even(0.02, 0.15)
    if d.chance(0.4):
        w = d.log(5.0, 60.0)
        rubs = thing("ToothFriction", mu=mu, direction="square_wave", wave=call("sign", call("sin", w * TIME)))
    else:
        rubs = thing("ToothFriction", mu=mu, transition=d.log(0.01, 0.3))
    g.add("mesh", "GearMesh", {"pinion": a, "wheel": b}, teeth=teeth, external=True, module=module, pressure_angle=0.35,
          k=k, c=digits(2 * d.log(0.01, 0.3) * (k * reduced) ** 0.5), friction=rubs,
          stiffness_variation=d.choice((None, thing("Fourier", cos=(d.even(0.05, 0.3),)))))  # fmt: skip
    return [b]


def segments(g: Growth, a: str) -> list[str]:
    """A shaft in segments with inertia of its own."""
    d, b = g.d, g.body(w0=None)
    k = g.stiffness(a, b)
    own = digits(min(g.inertia[a], g.inertia[b]) * d.log(0.05, 1.0))
    g.add("shaft", "Shaft", {"a": a, "b": b}, k=k, c=g.damping(a, b, k), segments=d.randint(2, 4), J=own)
    return [b]


def moving_phase(g: Growth, a: str) -> list[str]:
    """A non-circular pair whose law is shifted while it runs."""
    d = g.d
    law_of = thing("RatioLaw.ellipse", e=d.even(0.05, 0.5), order=d.choice((1, 1, 2)))
    w = d.log(1.0, 10.0)
    phase = d.choice((d.even(-2.0, 2.0), d.even(0.1, 1.0) * call("sin", w * TIME), d.even(-1.0, 1.0) * TIME))
    if d.chance(0.25):
        b = g.follower()
        g.add(
            "noncircular",
            "NonCircularGear",
            {"a": a, "b": b},
            law=law_of,
            external=d.chance(0.5),
            phase=d.even(-2.0, 2.0),
        )
        return [b]
    b = g.body(w0=g.speed())
    k = g.stiffness(a, b, 10.0, 100.0)
    g.add("noncircular", "NonCircularGear", {"a": a, "b": b}, law=law_of, external=d.chance(0.6), k=k,
          c=g.damping(a, b, k), phase=phase)  # fmt: skip
    return [b]


def prescribed(g: Growth, a: str) -> list[str]:
    """A motion prescribed behind a spring, a gear, a clutch or a planetary."""
    d, node = g.d, g.bare()
    w = d.log(1.0, 15.0)
    angle = d.choice((
        d.even(0.05, 1.0) * call("sin", w * TIME), d.log(1.0, 10.0) * TIME, d.even(0.1, 0.6) * (1.0 - call("cos", w * TIME)),
    ))  # fmt: skip
    if d.chance(0.5):
        g.add("drive", "Angle", {"flange": node}, phi=angle)
    else:
        speed = d.choice(
            (digits(d.log(0.5, 10.0)) * call("sin", w * TIME), d.either_sign(d.log(0.5, 10.0)) + 0.0 * TIME)
        )
        g.add("drive", "Speed", {"flange": node}, w=speed)
    kind = d.random()
    if kind < 0.5:
        pieces.shaft(g, node, a)
    elif kind < 0.75:
        g.inertia[node] = g.inertia[a]
        d.choice((pieces.dry, pieces.lash))(g, a, node)
    else:
        middle = g.bare()
        g.add("gear", "IdealGear", {"a": node, "b": middle}, ratio=d.ratio())
        pieces.shaft(g, middle, a)
    return []


def worm(g: Growth, a: str) -> list[str]:
    """A worm, as a rule self-locking, with enough inertia on its driving side not to jam."""
    d = g.d
    mu, lead, ratio = d.even(0.05, 0.3), d.even(0.05, 0.4), d.choice((5.0, 10.0, -8.0, 20.0))
    c, t = math.cos(0.3490658503988659), math.tan(lead)
    locks = -(c - mu / t) / (c + mu * t)
    if abs(locks) < 0.02:
        lead = digits(1.3 * lead)
    b = g.body(J=digits(min(0.3 * g.inertia[a] * ratio**2 / max(locks, 0.2), 3.0)))
    g.following.add(b)
    g.add("worm", "Worm", {"a": a, "b": b}, ratio=ratio, lead_angle=lead, friction=mu)
    return [b]


def uneven_gear(g: Growth, a: str) -> list[str]:
    """A lossy gear whose bearing torques depend on which side drives."""
    d = g.d
    if d.chance(0.3):
        return [lossy_gear(g, a)]
    b = g.follower()
    tau = (digits(g.inertia[a] * d.log(0.3, 5.0)), digits(g.inertia[a] * d.log(0.3, 5.0)))
    g.add(
        "lossy",
        "LossyGear",
        {"a": a, "b": b},
        ratio=d.ratio(),
        efficiency=(d.even(0.5, 1.0), d.even(0.4, 1.0)),
        bearing=tau,
    )
    return [b]


# -- laws -------------------------------------------------------------------------------------------------------------


def law(g: Growth, node: str) -> Any:
    """A torque by conditions of several kinds, nested, such that none holds its switch on its surface."""
    d = g.d
    size = pieces.torque_size(g, node)
    phi, w = sense(f"{node}.phi"), sense(f"{node}.w")
    turns = d.choice((1.0, 2.0, 5.0, 12.0, 24.0, 40.0))
    wave, w1 = call("sin", turns * phi), d.log(2.0, 40.0)
    small, beat = digits(0.4 * size), call("sin", d.log(2.0, 20.0) * TIME)
    gain = digits(size / d.log(5.0, 40.0))
    return d.choice((
        lambda: cases((size, wave > 0.5), (-small, Node("<", (wave, -0.5))), other=0.0),
        lambda: cases(
            (size, Node("both", (wave > 0.0, beat > 0.0))), (small, Node("one", (wave > 0.6, beat > 0.8))), other=0.0
        ),
        lambda: either(size, Node("not", (call("cos", phi) > 0.3,)), small),
        lambda: either(either(size, beat > 0.0, small), wave > 0.2, either(small, phi > 1.0, 0.0)),
        lambda: size * call("Max", call("Min", wave, d.even(0.2, 0.8)), d.even(-0.8, 0.0)),
        lambda: size * call("Heaviside", wave, 1.0) if d.chance(0.5) else size * call("Abs", wave + d.even(-0.6, 0.6)),
        lambda: -1.0 * gain * call("Max", call("Abs", w) + -1.0 * w1, 0.0) * call("tanh", 4.0 * w),
        lambda: call("Min", call("Abs", gain * w), size) * -1.0 * call("atan", 2.0 * w),
        lambda: size * call("sqrt", 1.0 + wave * wave) * beat,
        lambda: Node("parameter", (g.name("level"), size)) * wave,
        lambda: given_input(g, size) * call("cos", phi),
        lambda: either(gain * (w1 + -1.0 * w), Node("both", (Node("<", (w, w1)), beat > -0.5)), 0.0),
        lambda: size * wave * table((0.0, digits(0.3 * g.t_end), g.t_end), (0.0, 1.0, 0.2)),
        lambda: table((-w1, 0.0, digits(0.5 * w1), w1), (size, small, 0.0, -small), d.choice(("linear", "cubic")), False, w),
        lambda: size * call("exp", -1.0 * call("Abs", phi)) if d.chance(0.5) else any_signal(d, size, g.t_end),
        lambda: smooth_signal(d, size, g.t_end) * call("Max", wave, 0.0),
    ))()  # fmt: skip
