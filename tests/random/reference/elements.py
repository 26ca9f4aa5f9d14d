"""What every block does, written anew: ties, springs, laws over rows, friction, stops, lossy gears."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.random.description import GROUND, Part, Train
from tests.random.expressions import Node, walk
from tests.random.reference import contacts, further, gearboxes, given, heat, rubbing, vehicles
from tests.random.reference.composites import expanded
from tests.random.reference.switches import Context, NoEvidenceError, Table2, ellipse, is_zero
from tests.random.reference.system import Array, Pair, System, Tie, derivative


def system_of(train: Train) -> System:
    """The system of a train; NoEvidenceError for what it has no law for."""
    train = expanded(given.written(train))
    s = _composed(train, held=False)
    units = [d.row for d in s.dry] + [x.row for x in s.stops] + [r for g in s.lossy for r in (g.ra, g.rb)]
    if all(is_zero(row @ s.P) for row in units):
        return s
    return _composed(train, held=True)  # friction, a stop or a gear with losses on a prescribed motion


def _composed(train: Train, held: bool) -> System:
    s = System(train, held)
    ordered = sorted(heat.prepared(s, train), key=lambda p: p.block not in ("Governor",))
    for part in ordered:
        add = ELEMENTS.get(part.block)
        if add is None:
            raise NoEvidenceError(f"the block {part.block}")
        add(s, part)
    s.context.aux = [0.0] * len(s.aux)
    given.begin(s)
    s.reduce()
    return s


def relative(s: System, part: Part, b: str, a: str) -> Array:
    """Angle of flange b over that of flange a."""
    return s.node(part.node(b)) - s.node(part.node(a))


# -- bodies and ties --------------------------------------------------------------------------------------------------


def body(s: System, p: Part) -> None:
    """J or m."""
    s.J[s.index[p.node("a")]] += p.field("J" if p.block == "Inertia" else "m")


def gear(s: System, p: Part) -> None:
    """phi_a = ratio phi_b about the housing."""
    if p.field("slip") is not None:
        further.creep(s, p)
        return
    teeth = p.field("teeth")
    ratio = p.field("ratio") if teeth is None else teeth[1] / teeth[0] * (-1 if p.field("external") else 1)
    s.ties.append(relative(s, p, "a", "housing") - ratio * relative(s, p, "b", "housing"))


def planetary(s: System, p: Part) -> None:
    """phi_sun + ratio phi_ring = (1 + ratio) phi_carrier."""
    i = p.field("ratio")
    s.ties.append(s.node(p.node("sun")) + i * s.node(p.node("ring")) - (1 + i) * s.node(p.node("carrier")))


def differential(s: System, p: Part) -> None:
    """phi_left + phi_right = 2 phi_carrier/ratio."""
    carrier = s.node(p.node("carrier"))
    s.ties.append(s.node(p.node("left")) + s.node(p.node("right")) - 2 / p.field("ratio", 1) * carrier)


def rack(s: System, p: Part) -> None:
    """s = radius phi."""
    s.ties.append(s.node(p.node("slider")) - p.field("radius") * s.node(p.node("flange")))


def joint(s: System, p: Part) -> None:
    """Hooke's joint as a nonlinear tie: phi_b = phi_a + atan(q sin 2 phi_a/(1 - q cos 2 phi_a))."""
    q = math.tan(p.field("angle") / 2) ** 2

    def m(phi: float) -> float:
        return 1 + 2 * q * (math.cos(2 * phi) - q) / (1 - 2 * q * math.cos(2 * phi) + q * q)

    def dm(phi: float) -> float:
        d = 1 - 2 * q * math.cos(2 * phi) + q * q
        up = -4 * q * math.sin(2 * phi)
        return up / d - 2 * q * (math.cos(2 * phi) - q) * 4 * q * math.sin(2 * phi) / d**2

    def F(phi: float) -> float:
        return phi + math.atan2(q * math.sin(2 * phi), 1 - q * math.cos(2 * phi))

    nonlinear_tie(s, s.node(p.node("a")), s.node(p.node("b")), (F, m, dm), 1.0)


def nonlinear_tie(
    s: System,
    a: Array,
    b: Array,
    law: tuple[Callable[[float], float], Callable[[float], float], Callable[[float], float]],
    sign: float,
    phase: Any = 0.0,
) -> None:
    """phi_b = sign (F(phi_a + phase) - F(phase at the start)) with F, F', F'' the law; until `reduce` over nodes."""
    F, m, dm = law
    ahead, rate_of, pull_of = (s.compile(x) for x in (phase, derivative(phase), derivative(derivative(phase))))

    def rate(q: Array, v: Array, c: Context) -> tuple[Array, float, float]:
        ra, rb = a @ s.N, b @ s.N
        if np.abs([*(a @ s.P), *(b @ s.P)]).max(initial=0.0) > 0:
            raise NoEvidenceError("a nonlinear tie beside a prescribed motion")
        phi, extra = float(ra @ q) + ahead(c), rate_of(c)
        w, slope = float(ra @ v) + extra, m(phi)
        return rb - sign * slope * ra, sign * slope * extra, sign * (dm(phi) * w * w + slope * pull_of(c))

    def apart(q: Array, c: Context) -> float:  # at the start: the phase is that of then
        return float(b @ s.N @ q) - sign * (F(float(a @ s.N @ q) + ahead(c)) - F(ahead(c)))

    s.nonlinear.append(Tie(rate, (a, b), apart))


def noncircular(s: System, p: Part) -> None:
    """phi_b = -+F(phi_a): a tie, or with k a contact of q = F(theta) -+ phi_b."""
    law = p.field("law")
    if not isinstance(law, Node) or law.args[0] != "RatioLaw.ellipse":
        raise NoEvidenceError("a ratio law")
    fields = dict(law.args[1])
    F, m, dm = ellipse(fields["e"], fields.get("order", 1))
    a, b = relative(s, p, "a", "carrier"), relative(s, p, "b", "carrier")
    sign = 1.0 if p.field("external") else -1.0
    phase = p.field("phase", 0.0)
    if p.field("k") is None:
        nonlinear_tie(s, a, b, (F, m, dm), -sign, phase)
        return
    ahead, rate = s.compile(phase), s.compile(derivative(phase))
    s.context.t = 0.0
    at_start = F(ahead(s.context))
    i, j = s.law_row(a), s.law_row(b)
    s.elastic += [a, b]
    if not isinstance(phase, Node) and p.field("transmission_error") is None:
        s.pairs.append(Pair(p.name, a, b, sign, float(phase), (F, m)))
    force, spring = contacts.contact(s, p, p.field("k"))
    warms = s.heats.get(p.name, -1)

    def law_of(c: Context, f: list[float]) -> None:
        theta = c.X[i] + ahead(c)
        slope = m(theta)
        q = F(theta) - at_start + sign * c.X[j]
        turns = slope * (c.V[i] + rate(c)) + sign * c.V[j]
        M = force(q, turns, 1.0)[0]
        f[i] -= slope * M
        f[j] -= sign * M
        if warms >= 0:
            f[-1 - warms] += (M - spring(q)) * turns

    s.laws.append(law_of)


# -- springs and loads ------------------------------------------------------------------------------------------------


def shaft(s: System, p: Part) -> None:
    """k twist + c twist'; or a law over the twist; inner friction beside."""
    row = relative(s, p, "b", "a")
    if p.field("rigid"):
        s.ties.append(row)
        return
    if p.field("rest") is not None:
        i, k, rest = s.law_row(row), p.field("k"), p.field("rest")
        s.elastic.append(row)
        s.laws.append(lambda c, f: f.__setitem__(i, f[i] - k * (c.X[i] - rest)))
    elif p.field("k") is not None:
        s.springs.append((row, p.field("k")))
        s.elastic.append(row)
    else:
        i = s.law_row(row)
        s.elastic.append(row)
        torque = s.compile(p.field("torque"), lambda c: c.X[i])

        def law(c: Context, f: list[float]) -> None:
            f[i] -= torque(c)

        s.laws.append(law)
    if p.field("c") is not None:
        s.dampers.append((row, p.field("c")))
        _rubs(s, p, row, p.field("c"))
    if p.field("hysteresis") is not None:
        rubbing.inner_friction(s, row, dict(p.field("hysteresis").args[1]), p.name)


def damper(s: System, p: Part) -> None:
    """c w_rel."""
    row = relative(s, p, "b", "a")
    s.dampers.append((row, p.field("c")))
    _rubs(s, p, row, p.field("c"))


def _rubs(s: System, p: Part, row: Array, c1: float) -> None:
    """The heat of a viscous part."""
    if p.name in s.heats:
        i = s.law_row(row)
        heat.lost(s, p, lambda c: c1 * c.V[i] ** 2)


def torque(s: System, p: Part) -> None:
    """A given torque or force against the housing."""
    value = p.field("tau" if p.block == "Torque" else "f")
    timely = not any(n.op == "sense" for n in walk(value))
    s.torques.append((relative(s, p, "flange", "housing"), s.compile(value), timely))


def speed(s: System, p: Part) -> None:
    """A prescribed speed or angle of a node that nothing else prescribes."""
    node = p.node("flange")
    if p.node("housing") != GROUND or node in s.prescribed:
        raise NoEvidenceError("this prescribed motion")
    if given.follows_states(p):
        given.motion(s, p)
        return
    turned = p.block == "Angle"
    motion = p.field("phi" if turned else "w")
    if not s.held:
        s.prescribed[node] = (motion, "angle" if turned else "speed")
        return
    if any(float(t.starts[0] @ s.node(node)) for t in s.nonlinear if t.starts is not None):
        raise NoEvidenceError("this prescribed motion")
    row, rate = s.node(node), derivative(motion) if turned else motion
    s.J[s.index[node]] += 1.0  # any: its tie gives what it needs
    asked, pull = s.compile(rate), s.compile(derivative(rate))
    start = s.compile(motion if turned else 0.0)
    s.nonlinear.append(Tie(lambda q, v, c: (row @ s.N, asked(c), pull(c)), starts=(row, start)))


def speed_load(s: System, p: Part) -> None:
    """-sign(w)(c0 + c1 abs(w) + c2 w^2); c0 holds at rest. Of other directions one that drives."""
    row = relative(s, p, "flange", "housing")
    c0, c1, c2 = p.field("coeffs")
    if p.field("direction") is not None:
        _drives(s, row, (c0, c1, c2), p.field("direction"))
        return
    if c1:
        s.dampers.append((row, c1))
        _rubs(s, p, row, c1)
    if c2:
        square(s, row, c2)
        if p.name in s.heats:
            i = s.law_row(row)
            heat.lost(s, p, lambda c: c2 * abs(c.V[i]) ** 3)
    if c0:
        rubbing.constant(s, row, c0, p.name)


def bearing(s: System, p: Part) -> None:
    """Friction of a bearing; one that drags alone holds nothing."""
    if p.field("coulomb") is not None or p.field("torque") is not None:
        rubbing.bearing(s, p)
        return
    row = relative(s, p, "a", "housing")
    if p.field("viscous") is not None:
        s.dampers.append((row, p.field("viscous")))
        _rubs(s, p, row, p.field("viscous"))
    c2 = rubbing.drag(p)
    square(s, row, c2)
    i = s.law_row(row)
    heat.lost(s, p, lambda c: c2 * abs(c.V[i]) ** 3)


def _drives(s: System, row: Array, coeffs: tuple[float, float, float], direction: str) -> None:
    """+-(c0 + c1 abs(w) + c2 w^2), along the motion or of one sign."""
    i, k = s.law_row(row), s.sw.new()
    c0, c1, c2 = coeffs

    def law(c: Context, f: list[float]) -> None:
        w = c.V[i]
        ahead = 1.0 if s.sw(k, w if abs(w) > 1e-9 else 0.0) else -1.0
        side = {"along": ahead, "forward": 1.0, "backward": -1.0}[direction]
        f[i] += side * (c0 + c1 * ahead * w + c2 * w * w)

    s.laws.append(law)


def square(s: System, row: Array, c2: float) -> None:
    """-c2 w abs(w); a speed that friction holds is 0 but for rounding, and below 1e-9 rad/s there is nothing to tell."""
    i, k = s.law_row(row), s.sw.new()

    def law(c: Context, f: list[float]) -> None:
        w = c.V[i]
        f[i] -= c2 * w * w if s.sw(k, w if abs(w) > 1e-9 else 0.0) else -c2 * w * w

    s.laws.append(law)


def eddy(s: System, p: Part) -> None:
    """-2 excitation tau_n/(w_n/w + w/w_n)."""
    i = s.law_row(relative(s, p, "flange", "housing"))
    excitation = s.compile(p.field("excitation", 1.0))
    t_n, nominal, alpha = p.field("tau_nominal"), p.field("w_nominal"), p.field("alpha", 0.0)
    T, T_ref = s.compile(heat.as_signal(heat.port(p)) if alpha else 293.15), p.field("T_ref", 293.15)

    def brakes(c: Context) -> float:
        w, w_n = c.V[i], nominal * (1 + alpha * (T(c) - T_ref))
        return 2 * excitation(c) * t_n * w_n * w / (w * w + w_n * w_n)

    def law(c: Context, f: list[float]) -> None:
        f[i] -= brakes(c)

    s.laws.append(law)
    heat.lost(s, p, lambda c: brakes(c) * c.V[i])


def motor(s: System, p: Part) -> None:
    """L i' = u - R i - k w, torque k i."""
    i, state = s.law_row(relative(s, p, "flange", "housing")), s.state()
    u, R, L, k = s.compile(p.field("u")), p.field("R"), p.field("L"), p.field("k")

    def law(c: Context, f: list[float]) -> None:
        f[i] += k * c.s[state]

    def rate(c: Context, f: list[float]) -> None:
        f[-1 - state] = (u(c) - R * c.s[state] - k * c.V[i]) / L

    s.laws.append(law)
    (s.after if s.follows_motion(p.field("u")) else s.laws).append(rate)
    heat.lost(s, p, lambda c: R * c.s[state] ** 2)


def governor(s: System, p: Part) -> None:
    """u = bias + gain e + integral, held between limits; back-calculation; an actuator of first order."""
    i = s.law_row(s.node(p.node("flange")))
    target, gain = s.compile(p.field("target")), p.field("gain")
    Ki, T = p.field("integral_gain"), p.field("time_constant")
    bias, lower, upper = p.field("bias", 0.0), p.field("lower", 0.0), p.field("upper", 1.0)
    out = s.aux.setdefault(f"{p.name}.command", len(s.aux))
    integral = s.state() if Ki is not None else None
    actuator = s.state() if T is not None else None
    at_low, at_high = s.sw.new(), s.sw.new()
    now = {"error": 0.0, "wanted": 0.0, "held": 0.0}

    def command(c: Context) -> None:  # before all torques: they read it at the same instant
        error = target(c) - c.V[i]
        wanted = bias + gain * error + (0.0 if integral is None else c.s[integral])
        above, below = s.sw(at_low, wanted - lower), s.sw(at_high, upper - wanted)
        held = wanted if above and below else (upper if above else lower)
        now.update(error=error, wanted=wanted, held=held)
        c.aux[out] = held if actuator is None else c.s[actuator]

    def law(c: Context, f: list[float]) -> None:
        if integral is not None:
            f[-1 - integral] = Ki * (now["error"] + (now["held"] - now["wanted"]) / gain)
        if actuator is not None:
            f[-1 - actuator] = (now["held"] - c.s[actuator]) / T

    s.commands.append(command)
    s.laws.append(law)


def engine(s: System, p: Part) -> None:
    """A bilinear map over speed and throttle."""
    i = s.law_row(relative(s, p, "flange", "housing"))
    found, throttle = Table2(s.sw, dict(p.field("torque_map").args[1])), s.compile(p.field("throttle"))

    def law(c: Context, f: list[float]) -> None:
        f[i] += found(c.V[i], throttle(c))

    s.laws.append(law)


def stop(s: System, p: Part) -> None:
    """lower <= phi_b - phi_a <= upper; over the ground phi_a."""
    row = relative(s, p, "b", "a") if p.node("b") != GROUND else s.node(p.node("a"))
    contacts.stops(s, row, p.field("lower"), p.field("upper"), p.field("restitution"), s.heats.get(p.name, -1))


def nothing(s: System, p: Part) -> None:
    """The ground is built in, and stores of heat are known before."""


ELEMENTS: dict[str, Any] = {
    "Inertia": body, "Mass": body, "IdealGear": gear, "BeltDrive": gear, "IdealPlanetary": planetary,
    "Differential": differential, "Rack": rack, "UniversalJoint": joint, "NonCircularGear": noncircular, "Shaft": shaft,
    "Damper": damper, "Torque": torque, "Force": torque, "Speed": speed, "Angle": speed, "SpeedLoad": speed_load,
    "Acceleration": speed, "Vehicle": vehicles.vehicle, "Chassis": vehicles.chassis, "Tyre": vehicles.tyre,
    "ThermalMass": nothing, "ThermalConductance": heat.conductance,
    "EddyCurrentBrake": eddy, "DCMotor": motor, "Governor": governor, "Engine": engine, "HardStop": stop,
    "Lash": contacts.lash, "GearMesh": contacts.mesh, "SplineCoupling": contacts.spline, "Fixed": nothing,
    "Clutch": rubbing.clutch, "Brake": rubbing.brake, "OneWayClutch": rubbing.clutch, "Freewheel": rubbing.freewheel,
    "BearingFriction": bearing, "DogClutch": rubbing.dog, "Synchronizer": rubbing.clutch,
    "TorqueConverter": further.converter, "LossyGear": rubbing.lossy_gear, "Worm": rubbing.worm,
    "Gearbox": gearboxes.gearbox,
}  # fmt: skip
