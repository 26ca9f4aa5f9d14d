"""Heat: what elements lose, at temperatures that are given or of masses, which conduct; laws that fade as they warm up."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Part, Train
from tests.random.draw import Growth, digits, given_input
from tests.random.expressions import TEMPERATURE, Node, call, sense, thing
from tests.random.families import pieces
from tests.random.families.lossy import lossy_gear
from tests.random.families.mixed import extend

WARMS = (
    "Shaft", "Damper", "Clutch", "Brake", "BearingFriction", "OneWayClutch", "SpeedLoad", "EddyCurrentBrake", "DCMotor",
    "LossyGear", "Worm", "HardStop", "Vehicle", "GearMesh", "Lash", "Gearbox", "PlanetaryGear", "SplineCoupling",
    "TorqueConverter", "BeltDrive", "NonCircularGear", "Tyre", "Chassis",
)  # fmt: skip
T0 = 300.0


def heat(seed: int) -> Train:
    """A train with two to five parts that lose, and one to three thermal masses."""
    g = Growth("heat", seed)
    d = g.d
    bodies = [g.body(w0=g.speed())]
    for _ in range(d.randint(1, 3)):
        _extend(g, bodies)
    for _ in range(d.randint(1, 3)):
        _lossy_part(g, d.choice(bodies))
    for _ in range(d.randint(1, 2)):
        pieces.torque(g, d.choice(bodies))
    warmed(g)
    return g.train()


def _extend(g: Growth, bodies: list[str]) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.15:
        bodies.append(lossy_gear(g, a))
    elif kind < 0.25:
        extend(g, bodies, False)
    else:
        b = g.body(w0=g.speed())
        bodies.append(b)
        (pieces.dry if d.chance(0.5) else pieces.shaft)(g, a, b)


def _lossy_part(g: Growth, node: str) -> None:
    d = g.d
    size = pieces.torque_size(g, node)
    kind = d.random()
    if kind < 0.35:
        pieces.dry(g, node, GROUND, ("Brake", "BearingFriction"))
    elif kind < 0.55:
        pieces.speed_load(g, node)
    elif kind < 0.7:
        g.add("eddy", "EddyCurrentBrake", {"flange": node}, tau_nominal=size, w_nominal=d.log(2.0, 50.0))
    elif kind < 0.8:
        k = d.log(0.1, 2.0)
        g.add(
            "motor",
            "DCMotor",
            {"flange": node},
            R=d.log(0.1, 5.0),
            L=d.log(0.01, 1.0),
            k=k,
            u=digits(k * d.log(2.0, 30.0)),
        )
    elif kind < 0.9:
        pieces.damper(g, node, GROUND)
    else:
        pieces.stop(g, node, GROUND)


def warmed(g: Growth, kinds: tuple[str, ...] = WARMS) -> None:
    """Heat ports, masses and conductances for what has grown, of these kinds."""
    d = g.d
    masses = [g.name("disc") for _ in range(d.randint(1, 3))]
    scale = max(sum(g.inertia[b] for b in g.rotating), 0.1) * d.log(0.3, 30.0)
    for i, p in enumerate(g.parts):
        loses = p.block in kinds and _loses(p)
        if not loses or d.chance(0.15):
            continue
        kind = d.random()
        T: Any = d.choice(masses) if kind < 0.75 else d.choice((T0, 350.0)) if kind < 0.9 else given_input(g, 400.0)
        if isinstance(T, Node):
            g.inputs[-1] = (g.inputs[-1][0], d.even(280.0, 400.0))
        g.parts[i] = _fading(g, p.changed(heat=thing("HeatPort", T=T)), T)
    for name in masses:
        g.parts.append(
            Part(name, "ThermalMass", (("C", digits(scale * d.log(0.3, 3.0))), ("T0", d.choice((T0, 293.15)))), ())
        )
    for _ in range(d.randint(0, 3)):
        C = scale
        G: Any = digits(C / (g.t_end * d.log(0.2, 10.0)))
        if d.chance(0.3):
            G = G * (1.0 + 0.05 * call("Abs", sense(f"{d.choice(g.rotating)}.w")))
        ends: list[Any] = [d.choice(masses), d.choice((*masses, T0, T0, 280.0))]
        if ends[0] == ends[1]:
            ends[1] = T0
        if d.chance(0.5):
            ends.reverse()
        g.add("wall", "ThermalConductance", {}, G=G, a=ends[0], b=ends[1])


def _loses(p: Part) -> bool:
    """Whether a part of a kind that may lose does: a spring with damping, a pair with compliance."""
    if p.block == "Shaft":
        return p.field("c") is not None or p.field("hysteresis") is not None
    return p.block != "NonCircularGear" or p.field("k") is not None


def _fading(g: Growth, p: Part, T: Any) -> Part:
    """At times with a law that falls, or rises, as it warms up."""
    d = g.d
    if not d.chance(0.5):
        return p
    warm = TEMPERATURE + -T0
    fades = 1.0 + digits(d.either_sign(d.log(1e-4, 1e-2))) * warm
    if d.chance(0.5):  # a bound one
        fades = call("exp", digits(-d.log(1e-4, 1e-2)) * warm)
    if p.block == "EddyCurrentBrake":
        return p.changed(alpha=0.004, T_ref=d.choice((None, T0)))
    if p.block in ("Clutch", "Brake", "OneWayClutch"):
        for name in ("capacity", "mu"):
            if isinstance(p.field(name), float) and fades.op == "exp":
                return p.changed(**{name: p.field(name) * fades})
    return p
