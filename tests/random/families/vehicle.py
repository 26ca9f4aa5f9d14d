"""Vehicles: wind, slopes and rolling resistance over time and the way, chassis on tyres and on wheels that roll, trailers."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Part, Train
from tests.random.draw import Growth, any_signal, digits, given_input
from tests.random.expressions import DISTANCE, TIME, call, either, table, thing
from tests.random.families import pieces

WEIGHT = 9.80665


def vehicle(seed: int) -> Train:
    """A drive, one or two axles, and what they move."""
    g = Growth("vehicle", seed)
    d = g.d
    axle = g.body(w0=None if d.chance(0.4) else g.speed())
    axles = [axle]
    for _ in range(d.randint(0, 2)):
        _drive(g, axles)
    if d.chance(0.4):
        load(g, axle)
    else:
        _on_wheels(g, axle)
    pieces.torque(g, axles[-1])
    if d.chance(0.5):
        pieces.dry(g, axle, GROUND, ("Brake", "BearingFriction"))
    return g.train()


def _drive(g: Growth, axles: list[str]) -> None:
    d, a = g.d, axles[-1]
    if d.chance(0.3):
        axles.append(pieces.gear(g, a))
        return
    b = g.body(w0=g.speed())
    axles.append(b)
    d.choice((pieces.shaft, pieces.dry, pieces.lash))(g, a, b)


def road(g: Growth, mass: float, radius: float) -> dict[str, Any]:
    """Air, slope and rolling resistance."""
    d = g.d
    way = d.log(0.3, 10.0)
    fields: dict[str, Any] = {
        "drag_area": d.choice((None, d.log(0.1, 3.0))),
        "air_density": d.choice((None, None, 1.0)),
    }
    if fields["drag_area"] is not None:
        fields["wind"] = d.choice(
            (None, d.even(-15.0, 15.0), _along(g, d.log(1.0, 15.0), way), d.log(1.0, 10.0) * call("sin", 2.0 * TIME))
        )
    fields["grade"] = d.choice(
        (
            None,
            d.even(-0.2, 0.2),
            _along(g, d.log(0.02, 0.3), way),
            d.log(0.02, 0.3) * call("sin", d.log(1.0, 10.0) * TIME),
        )
    )
    if d.chance(0.7):
        size = d.log(0.005, 0.2)
        humps = (size, digits(d.log(0.1, 3.0) * size), size)
        rolling: Any = d.choice((
            size, size, table((0.0, way, digits(2 * way)), humps, "linear", False, DISTANCE),
            size * (1.0 + call("sin", d.log(1.0, 10.0) * TIME)), either(size, way < DISTANCE, digits(0.2 * size)),
            table((0.0, digits(0.4 * g.t_end), digits(0.6 * g.t_end)), (size, size, 0.0)),
        ))  # fmt: skip
        fields["rolling"] = rolling
        fields["rolling_speed"] = d.log(0.05, 1.0) if d.chance(0.2) else None
    return fields


def _along(g: Growth, size: float, way: float) -> Any:
    """A signal over the way, with corners or without."""
    d = g.d
    return d.choice((
        lambda: size * call("sin", digits(1.0 / way) * DISTANCE),
        lambda: table((0.0, way, digits(2.5 * way)), (0.0, d.either_sign(size), 0.0), "linear", False, DISTANCE),
        lambda: table((-way, 0.0, way), (d.either_sign(size), 0.0, size), "cubic", False, DISTANCE),
        lambda: either(d.either_sign(size), digits(0.3 * way) < DISTANCE, 0.0),
        lambda: given_input(g, size) if d.chance(0.5) else size * call("tanh", DISTANCE),
    ))()  # fmt: skip


def load(g: Growth, axle: str) -> None:
    """A Vehicle on an axle, with or without tyres."""
    d = g.d
    mass, radius = d.log(0.5, 20.0), d.choice((0.1, 0.3))
    fields = road(g, mass, radius) | {"wheel_inertia": d.choice((None, d.log(0.01, 0.5)))}
    if d.chance(0.35):
        fields["tyre"] = thing("TyreSlip", **_tyre(g, mass * WEIGHT), grip=d.even(0.3, 1.1))
        if fields.get("rolling") is not None:
            fields["rolling_speed"] = d.log(0.05, 1.0)
    g.add("car", "Vehicle", {"flange": axle}, mass=mass, wheel_radius=radius, **fields)


def _tyre(g: Growth, weight: float) -> dict[str, Any]:
    d = g.d
    more = {"shape": d.even(1.1, 1.9)} if d.chance(0.4) else {}
    return {"stiffness": digits(weight * d.log(2.0, 30.0)), "low_speed": d.log(0.05, 1.0)} | more


def _on_wheels(g: Growth, axle: str) -> None:
    """A chassis on one or two axles, with or without a trailer."""
    d = g.d
    mass, radius = d.log(0.5, 20.0), d.choice((0.1, 0.3))
    rolls = d.chance(0.4)
    v0 = None if rolls or d.chance(0.3) else d.even(-8.0, 8.0)
    car = g.name("car")
    g.inertia[car] = mass
    g.slides.add(car)
    fields = {k: v for k, v in (road(g, mass, radius) | {"v0": v0}).items() if v is not None}
    g.parts.append(Part(car, "Chassis", (("mass", mass), *fields.items()), (("a", car),)))
    _wheel(g, axle, car, mass, radius, rolls)
    if d.chance(0.5):
        other = g.follower() if rolls and d.chance(0.5) else g.body(w0=None if rolls else g.speed())
        also = other in g.following
        _wheel(g, other, car, mass, d.choice((0.1, 0.2, 0.3)), also)
        if d.chance(0.6):
            pieces.torque(g, other)
        if d.chance(0.4):
            pieces.dry(g, other, GROUND, ("Brake", "BearingFriction"))
    if d.chance(0.3):
        g.add("push", "Force", {"flange": car}, f=any_signal(d, digits(mass * d.log(0.5, 5.0)), g.t_end))
    if d.chance(0.35):
        _trailer(g, car)


def _wheel(g: Growth, axle: str, car: str, mass: float, radius: float, rolls: bool) -> None:
    d = g.d
    if rolls:
        g.add("rack", "Rack", {"flange": axle, "slider": car}, radius=radius)
        return
    weight = digits(mass * WEIGHT * d.even(0.3, 1.0))
    grip: Any = d.choice((d.even(0.2, 1.1), d.even(0.2, 1.1), 0.8 + -0.5 * call("tanh", 2.0 * TIME)))
    force: Any = d.choice((weight, weight, weight * (1.0 + 0.3 * call("sin", d.log(1.0, 20.0) * TIME))))
    g.add(
        "tyre",
        "Tyre",
        {"wheel": axle, "vehicle": car},
        radius=radius,
        grip=grip,
        normal_force=force,
        **_tyre(g, weight),
    )


def _trailer(g: Growth, car: str) -> None:
    d = g.d
    mass, name = d.log(0.5, 10.0), g.name("trailer")
    g.inertia[name] = mass
    g.slides.add(name)
    fields = {k: v for k, v in road(g, mass, 0.3).items() if v is not None}
    g.parts.append(Part(name, "Chassis", (("mass", mass), *fields.items()), (("a", name),)))
    kind = d.random()
    if kind < 0.2:
        g.add("hitch", "Shaft", {"a": car, "b": name}, rigid=True)
    elif kind < 0.6:
        k = g.stiffness(car, name, 10.0, 60.0)
        g.add("hitch", "Shaft", {"a": car, "b": name}, k=k, c=g.damping(car, name, k))
    else:
        pieces.lash(g, car, name)
