"""Elements that families put between two nodes; every function adds parts to a growing train."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tests.random.description import GROUND
from tests.random.draw import Growth, any_signal, digits, given_input, smooth_signal
from tests.random.expressions import SLIP, TWIST, Node, call, table, thing


def torque_size(g: Growth, node: str) -> float:
    """A torque that gives the body of a node some 3 to 100 rad/s2."""
    return digits(max(g.inertia.get(node, 0.0), 0.05) * g.d.log(3.0, 100.0))


def torque(g: Growth, node: str, signal: Any = None, smooth: bool = False) -> None:
    """A torque or force on a node."""
    size = torque_size(g, node)
    if signal is None:
        if not smooth and g.d.chance(0.12):
            signal = given_input(g, size)
        else:
            signal = (smooth_signal if smooth else any_signal)(g.d, size, g.t_end)
    if node in g.slides:
        g.add("force", "Force", {"flange": node}, f=signal)
    else:
        g.add("torque", "Torque", {"flange": node}, tau=signal)


def shaft(g: Growth, a: str, b: str, smooth: bool = True) -> None:
    """A spring, linear or over its twist, with or without a damper."""
    k = g.stiffness(a, b)
    fields: dict[str, Any] = {"k": k, "c": g.damping(a, b, k)}
    kind = g.d.random()
    if kind < 0.12:
        fields = {"torque": k * TWIST + digits(k * g.d.log(0.1, 30.0)) * TWIST * TWIST * TWIST, "c": fields["c"]}
    elif kind < 0.18 and not smooth:
        x = g.d.log(0.02, 0.5)
        y = digits(k * x)
        fields = {
            "torque": table((-x, 0.0, x), (digits(-2 * y), 0.0, y), g.d.choice(("linear", "cubic"))),
            "c": fields["c"],
        }
    elif g.laws and kind > 0.6:
        fields["rest"] = digits(g.d.either_sign(g.d.log(0.001, 0.1)))
    g.drops.append(g.add("shaft", "Shaft", {"a": a, "b": b}, **fields))


def damper(g: Growth, a: str, b: str) -> None:
    """A damper with a time constant between 0.05 and 5 s."""
    g.add("damper", "Damper", {"a": a, "b": b}, c=digits(g.reduced(a, b) / g.d.log(0.05, 5.0)))


def gear(g: Growth, a: str) -> str:
    """An ideal gear to a new body; its speed follows."""
    ratio = g.d.ratio()
    b = g.follower()
    if g.d.chance(0.25):
        teeth = (g.d.choice((17, 20, 23)), g.d.choice((20, 31, 46)))
        g.add("gear", "IdealGear", {"a": a, "b": b}, teeth=teeth, external=g.d.chance(0.5))
    else:
        g.add("gear", "IdealGear", {"a": a, "b": b}, ratio=ratio)
    return b


def planetary(g: Growth, a: str) -> tuple[str, str]:
    """A planetary set or differential on a node: one more body with a speed of its own, a third that follows."""
    still = all(not p.field("w0") for p in g.parts)
    free = g.body(w0=g.d.either_sign(g.d.log(0.5, 10.0)) if g.d.chance(0.5) and not still else 0.0)
    follows = g.follower()
    nodes = [a, free, follows]
    g.d.shuffle(nodes)
    if g.d.chance(0.7):
        at = dict(zip(("sun", "carrier", "ring"), nodes, strict=True))
        g.add("planetary", "IdealPlanetary", at, ratio=g.d.choice((1.5, 2.0, 2.5, 3.0, -2.0, 0.5)))
    else:
        at = dict(zip(("carrier", "left", "right"), nodes, strict=True))
        g.add("differential", "Differential", at, ratio=g.d.choice((1, 1, 2, 3.5)))
    return free, follows


def lash(g: Growth, a: str, b: str) -> None:
    """A spring with a gap."""
    k = g.stiffness(a, b, 10.0, 120.0)
    fields: dict[str, Any] = {"k": k, "half_gap": g.d.choice((0.0, g.d.log(0.001, 0.3), g.d.log(0.01, 0.1)))}
    kind = g.d.random()
    if kind < 0.55:
        fields["c"] = g.damping(a, b, k)
        fields["contact_damping"] = g.d.choice((None, "clipped", "clipped_force", "always"))
    elif kind < 0.8:
        fields["contact_damping"] = thing("HuntCrossley", restitution=g.d.even(0.2, 0.95))
    if g.laws and g.d.chance(0.6):
        ends(g, fields)
    g.drops.append(g.add("lash", "Lash", {"a": a, "b": b}, **fields))


def ends(g: Growth, fields: dict[str, Any]) -> None:
    """Ends of its own for a gap, a rest, an exponent."""
    room = fields.pop("half_gap")
    side = g.d.random()
    if side < 0.7:
        fields["lower"] = digits(-room * g.d.log(0.3, 3.0))
    if side > 0.3:
        fields["upper"] = digits(room * g.d.log(0.3, 3.0))
    if g.d.chance(0.3):
        fields["rest"] = digits(g.d.either_sign(g.d.log(0.001, 0.1)))
    if g.d.chance(0.4) and not isinstance(fields.get("contact_damping"), Node):
        fields["exponent"] = g.d.choice((1.0, 1.5, 2.0))


def stop(g: Growth, a: str, b: str) -> None:
    """Rigid stops with room about the start."""
    room = g.d.log(0.01, 1.0)
    fields: dict[str, Any] = {"restitution": g.d.choice((0.0, 0.0, 1.0, g.d.even(0.1, 0.9), g.d.even(0.05, 0.6)))}
    kind = g.d.random()
    if kind < 0.7:
        fields["upper"] = room
    if kind > 0.4:
        fields["lower"] = digits(-room * g.d.log(0.3, 3.0))
    if g.d.chance(0.12):  # starts in contact
        fields["upper" if "upper" in fields else "lower"] = 0.0
    if fields.get("upper") == fields.get("lower") == 0.0:
        fields["upper"] = room
    if _rebounds_at_start("HardStop", fields) and any(_rebounds_at_start(p.block, dict(p.fields)) for p in g.parts):
        fields["restitution"] = 0.5
    g.add("stop", "HardStop", {"a": a, "b": b}, **fields)


def _rebounds_at_start(block: str, fields: Mapping[str, Any]) -> bool:
    """Whether it is a stop without loss that the start is in contact with: two of them can leave no room to move in."""
    return block == "HardStop" and fields["restitution"] == 1.0 and 0.0 in (fields.get("upper"), fields.get("lower"))


def speed_load(g: Growth, node: str, dry: bool | None = None) -> None:
    """A load over speed; dry: whether it has a constant part."""
    size = torque_size(g, node)
    c0 = digits(size * g.d.log(0.05, 1.0)) if (g.d.chance(0.5) if dry is None else dry) else 0.0
    c1, c2 = digits(size / g.d.log(5.0, 200.0)), digits(size / g.d.log(50.0, 5000.0))
    g.add("load", "SpeedLoad", {"flange": node}, coeffs=(c0, g.d.choice((0.0, c1)), g.d.choice((0.0, c2))))


def capacity_signal(g: Growth, size: float) -> Any:
    """Capacity of a friction element: constant, pulsing through 0, or falling to nothing."""
    w = g.d.log(2.0, 20.0)
    return g.d.choice((
        lambda: size, lambda: size, lambda: size,
        lambda: size * call("sin", w * _time()),
        lambda: digits(0.5 * size) + size * call("cos", w * _time()),
        lambda: size * call("Abs", call("sin", w * _time())),
        lambda: table((0.0, digits(0.4 * g.t_end), digits(0.6 * g.t_end)), (size, size, 0.0)),
        lambda: table((0.0, digits(0.3 * g.t_end), digits(0.5 * g.t_end)), (0.0, 0.0, size)),
    ))()  # fmt: skip


def _time() -> Any:
    from tests.random.expressions import TIME

    return TIME


def dry_fields(g: Growth, size: float) -> dict[str, Any]:
    """capacity, or mu with force and engagement, and now and then a static peak."""
    fields: dict[str, Any] = {}
    if g.d.chance(0.6):
        fields["capacity"] = capacity_signal(g, size)
    else:
        mu: Any = g.d.even(0.05, 0.5)
        if g.d.chance(0.5):
            start = g.d.choice((0.0, 0.0, -1.0))
            kind = g.d.choice(("linear", "linear", "cubic"))
            knee = g.d.log(1.0, 10.0)
            mu = table((start, knee, digits(2.5 * knee)), (mu, digits(0.7 * mu), digits(0.6 * mu)), kind)
        elif g.laws and g.d.chance(0.8):
            mu = over_slip(g, mu)
        fields |= {
            "mu": mu,
            "force_max": digits(size / 0.2),
            "engagement": g.d.choice((1.0, 1.0, 0.5, capacity_signal(g, 1.0))),
        }
        fields["geometry"] = g.d.choice((None, 0.5, 2.0))
    fields["peak"] = g.d.choice((None, None, None, 1.1, 1.3, 2.0))
    return fields


def over_slip(g: Growth, size: float) -> Any:
    """A law over the slip that starts near a size: Modelica's exponential, a fall, a rise."""
    knee = g.d.log(0.5, 20.0)
    return g.d.choice((
        lambda: digits(0.7 * size) + digits(g.d.even(0.1, 1.0) * size) * call("exp", digits(-1.0 / knee) * SLIP),
        lambda: Node("/", (size, 1.0 + digits(1.0 / knee) * SLIP)),
        lambda: size + digits(size / knee) * SLIP,
    ))()  # fmt: skip


def dry(g: Growth, a: str, b: str, kinds: tuple[str, ...] = ()) -> None:
    """A friction element between two nodes."""
    size = digits(torque_size(g, a) * g.d.log(0.2, 2.0))
    if b == GROUND:
        kind = g.d.choice(
            kinds or ("Brake", "Brake", "BearingFriction", "BearingFriction", "OneWayClutch", "Freewheel")
        )
    else:
        kind = g.d.choice(
            kinds or ("Clutch", "Clutch", "Clutch", "OneWayClutch", "Freewheel", "Brake", "BearingFriction")
        )
    if kind == "BearingFriction":
        bearing(g, a, b)
    elif kind == "Brake":
        g.add("brake", "Brake", {"a": a, "housing": b}, **dry_fields(g, size))
    elif kind == "Freewheel":
        ends = (a, b) if g.d.chance(0.5) else (b, a)
        g.add("freewheel", "Freewheel", dict(zip("ab", ends, strict=True)))
    else:
        fields = dry_fields(g, size)
        ends = (a, b) if g.d.chance(0.5) else (b, a)
        g.add(kind.lower(), kind, dict(zip("ab", ends, strict=True)), **fields)


def bearing(g: Growth, a: str, housing: str = GROUND) -> None:
    """Friction of a bearing, with a rise near rest, a viscous part or a table."""
    size = digits(torque_size(g, a) * g.d.log(0.05, 1.0))
    fields: dict[str, Any] = {}
    if g.d.chance(0.25):
        start = g.d.choice((0.0, -1.0))
        fields["torque"] = table((start, g.d.log(2.0, 12.0), 30.0), (size, digits(1.4 * size), digits(2.0 * size)))
    elif g.laws and g.d.chance(0.5):
        fields["torque"] = over_slip(g, size)
    else:
        fields["coulomb"] = size
        fields["viscous"] = g.d.choice((None, digits(size / g.d.log(5.0, 100.0))))
        if g.d.chance(0.35):
            fields["stribeck"] = thing("Stribeck", rise=digits(size * g.d.log(0.1, 3.0)), speed=g.d.log(0.1, 2.0))
    fields["peak"] = g.d.choice((None, None, None, 1.2, 1.5))
    g.add("bearing", "BearingFriction", {"a": a, "housing": housing}, **fields)


def hysteresis_shaft(g: Growth, a: str, b: str) -> None:
    """A shaft with inner friction."""
    k = g.stiffness(a, b)
    friction = digits(k * g.d.log(0.005, 0.2))
    stiffness = digits(k * g.d.log(0.3, 3.0)) if g.d.chance(0.6) else None
    inner = thing("Hysteresis", friction=friction, **({} if stiffness is None else {"stiffness": stiffness}))
    g.add("shaft", "Shaft", {"a": a, "b": b}, k=k, c=g.damping(a, b, k), hysteresis=inner)


def maxwell(g: Growth, a: str, b: str) -> None:
    """A spring and a damper in a row, a node without inertia between them, beside a spring."""
    middle = g.bare()
    k = g.stiffness(a, b)
    g.add("shaft", "Shaft", {"a": a, "b": middle}, k=k)
    g.add("damper", "Damper", {"a": middle, "b": b}, c=digits(k / g.d.log(2.0, 60.0)))
    if g.d.chance(0.5):
        g.add("shaft", "Shaft", {"a": a, "b": b}, k=digits(k * g.d.log(0.1, 3.0)))
