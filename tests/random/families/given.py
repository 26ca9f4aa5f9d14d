"""Motions given by accelerations, with their speeds beside, or behind filters; pulses; starts of masses; what else warms up."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from tests.random.description import GROUND, Part, Train
from tests.random.draw import Growth, any_signal, corner_signal, digits, given_input, smooth_signal
from tests.random.expressions import TIME, Node, call, either, pulses, table, thing
from tests.random.families import pieces
from tests.random.families.heat import WARMS, warmed

WARM = (*WARMS, "DogClutch", "Freewheel", "Synchronizer")


def given(seed: int) -> Train:
    """Two to four bodies behind such a source."""
    g = Growth("given", seed)
    d = g.d
    if d.chance(0.15):
        _masses(g)
        return g.train()
    first = g.body()
    bodies = [first]
    if d.chance(0.65):
        _motion(g, first)
        b = g.body(w0=g.speed())
        pieces.shaft(g, first, b)
        bodies = [b]
    for _ in range(d.randint(1, 3)):
        bodies += d.choice((_coupling, _coupling, _gearbox, _mass, _spring, _on_tyre))(g, d.choice(bodies))
    pieces.torque(g, d.choice([b for b in bodies if b not in g.slides]), pulsed(g, pieces.torque_size(g, bodies[0])))
    for _ in range(d.randint(0, 2)):
        _bearing(g, d.choice([b for b in bodies if b not in g.slides]))
    if d.chance(0.6):
        warmed(g, WARM)
    return g.train()


def pulsed(g: Growth, size: float) -> Node:
    """Pulses, trapezoids, triangles."""
    d = g.d
    period = digits(g.t_end * d.even(0.15, 0.8))
    start = d.choice((0.0, digits(0.3 * period), digits(-0.4 * period)))
    more: dict[str, Any] = {"start": start} | ({"offset": digits(-0.3 * size)} if d.chance(0.3) else {})
    more |= {"count": d.choice((1, 2))} if d.chance(0.3) else {}
    size = d.either_sign(size)
    if d.chance(0.5):
        return pulses("pulse", size, period=period, duty=d.choice((0.5, d.even(0.05, 0.95))), **more)
    up, down = digits(period * d.even(0.05, 0.3)), digits(period * d.even(0.05, 0.3))
    width = d.choice((0.0, digits(period * d.even(0.1, 0.35))))
    return pulses("trapezoid", size, rising=up, width=width, falling=down, period=period, **more)


def _motion(g: Growth, node: str) -> None:
    """Acceleration, angle with its speed, and motions behind filters."""
    d, at = g.d, {"flange": node}
    w, f = d.log(1.0, 20.0), digits(d.log(5.0, 60.0))
    size = d.either_sign(d.log(0.5, 20.0))
    kind = d.random()
    if kind < 0.4:
        early = digits(g.t_end * d.even(0.1, 0.6))
        alpha: Any = d.choice((
            lambda: size, lambda: size * call("sin", w * TIME), lambda: either(size, early > TIME, digits(-0.5 * size)),
            lambda: corner_signal(d, size, g.t_end), lambda: given_input(g, abs(size)), lambda: pulsed(g, abs(size)),
        ))()  # fmt: skip
        g.add("start", "Acceleration", at, alpha=alpha, w0=d.choice((None, d.even(-10.0, 10.0))))
    elif kind < 0.55:
        waves = (digits(size / w), digits(size / w) * w, digits(size / w) * w * w)
        phi, speed, alpha = (
            x * call(n, w * TIME) for x, n in zip((*waves[:2], -waves[2]), ("sin", "cos", "sin"), strict=True)
        )
        g.add("turn", "Angle", at, phi=phi, w=speed, alpha=alpha)
    elif kind < 0.75:
        phi = d.choice((smooth_signal, corner_signal))(d, d.log(0.1, 3.0), g.t_end)
        g.add("turn", "Angle", at, phi=phi, filter=f, filter_type=d.choice((None, "bessel", "butterworth", "critical")))
    else:
        speed = given_input(g, abs(size)) if d.chance(0.2) else any_signal(d, abs(size), g.t_end)
        kinds = (None, "first order", "bessel", "butterworth", "critical")
        g.add("run", "Speed", at, w=speed, filter=f, filter_type=d.choice(kinds))


def _coupling(g: Growth, a: str) -> list[str]:
    """A dog clutch, a freewheel or a synchronizer with a cone of any kind."""
    d, b = g.d, g.body(w0=g.speed())
    ends = dict(zip("ab", (a, b) if d.chance(0.5) else (b, a), strict=True))
    at, off = d.even(0.1, 0.5) * g.t_end, d.even(0.6, 0.95) * g.t_end
    engaged = d.choice((1.0, table((0.0, round(at, 4), round(off, 4)), (-1.0, 1.0, -1.0), "step")))
    kind = d.random()
    if kind < 0.25:
        g.add("dog", "DogClutch", ends, engaged=engaged)
    elif kind < 0.5:
        g.add("freewheel", "Freewheel", ends)
    else:
        g.laws = True
        g.add("sync", "Synchronizer", ends, engaged=engaged, **pieces.dry_fields(g, pieces.torque_size(g, a)))
    return [b]


def _gearbox(g: Growth, a: str) -> list[str]:
    """With a table of losses; rigid, or with compliance."""
    d, b = g.d, g.follower()
    rows, w, size = [], 0.0, pieces.torque_size(g, a)
    for _ in range(d.randint(1, 3)):
        tau = digits(size * d.log(0.01, 0.2))
        rows.append((w, d.even(0.6, 1.0), d.even(0.6, 1.0), tau, tau))
        w = digits(w + d.log(0.5, 15.0))
    fields: dict[str, Any] = {"ratio": d.ratio(), "loss_table": tuple(rows)}
    if d.chance(0.3):
        k = g.stiffness(a, b)
        fields |= {"k": k, "c": digits(k / d.log(30.0, 400.0)), "half_gap": d.choice((None, d.log(0.001, 0.05)))}
        fields["contact_damping"] = d.choice((None, "always", "clipped"))
    g.add("box", "Gearbox", {"a": a, "b": b}, **fields)
    return [b]


def _mass(g: Growth, a: str) -> list[str]:
    """A rack, and on it a mass behind a spring that starts from somewhere."""
    d = g.d
    slider, other = g.mass(d.log(0.1, 3.0)), g.mass(d.log(0.1, 3.0), v0=d.even(-3.0, 3.0))
    g.add("rack", "Rack", {"flange": a, "slider": slider}, radius=d.choice((0.1, 0.3)))
    k = g.stiffness(slider, other)
    g.add("spring", "Shaft", {"a": slider, "b": other}, k=k, c=g.damping(slider, other, k))
    _starts(g, other, s0=d.even(-0.1, 0.1))
    return []


def _starts(g: Growth, node: str, **fields: float | None) -> None:
    i = next(i for i, p in enumerate(g.parts) if p.name == node)
    g.parts[i] = g.parts[i].changed(**fields)


def _masses(g: Growth) -> None:
    """Masses in a row, of which the last one begins with an acceleration."""
    d = g.d
    row = [g.mass(d.log(0.1, 3.0), v0=d.even(-3.0, 3.0)), *(g.mass(d.log(0.1, 3.0)) for _ in range(d.randint(1, 2)))]
    _starts(g, row[0], s0=d.even(-1.0, 1.0))
    for a, b in pairwise(row):
        k = g.stiffness(a, b)
        g.add("spring", "Shaft", {"a": a, "b": b}, k=k, c=g.damping(a, b, k))
    _starts(g, row[-1], a0=d.even(-30.0, 30.0))
    pieces.torque(g, d.choice(row), smooth=True)


def _spring(g: Growth, a: str) -> list[str]:
    b = g.body(w0=g.speed())
    pieces.shaft(g, a, b)
    return [b]


def _on_tyre(g: Growth, a: str) -> list[str]:
    """A tyre and the chassis that it moves."""
    d, mass, car = g.d, g.d.log(0.5, 10.0), g.name("car")
    g.inertia[car] = mass
    g.slides.add(car)
    fields = {"mass": mass, "v0": d.choice((None, d.even(-3.0, 3.0))), "drag_area": d.choice((None, d.log(0.1, 3.0)))}
    g.parts.append(Part(car, "Chassis", tuple((n, x) for n, x in fields.items() if x is not None), (("a", car),)))
    weight = digits(mass * 9.80665)
    g.add("tyre", "Tyre", {"wheel": a, "vehicle": car}, radius=d.choice((0.1, 0.3)), grip=d.even(0.2, 1.1), normal_force=weight,
          stiffness=digits(weight * d.log(2.0, 30.0)), low_speed=d.log(0.05, 1.0))  # fmt: skip
    return []


def _bearing(g: Growth, a: str) -> None:
    """Friction, or none, and drag of air and oil."""
    d = g.d
    size = digits(pieces.torque_size(g, a) * d.log(0.05, 1.0))
    fields: dict[str, Any] = {}
    kind = d.random()
    if kind < 0.5:
        fields = {"coulomb": size, "viscous": d.choice((None, digits(size / 20.0))), "peak": d.choice((None, 1.3))}
    elif kind < 0.75:
        fields = {"viscous": digits(size / d.log(5.0, 50.0))}
    else:
        fields = {"torque": table((0.0, 5.0, 30.0), (size, digits(1.4 * size), digits(2.0 * size)))}
    drags = d.choice((("windage",), ("churning",), ("windage", "churning")))
    g.add("bearing", "BearingFriction", {"a": a, "housing": GROUND}, **fields,
          **{n: thing("FluidDrag", c=digits(size / d.log(50.0, 2000.0))) for n in drags})  # fmt: skip
