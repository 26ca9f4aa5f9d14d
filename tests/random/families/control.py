"""Control: conditions over time, speeds and angles, maps, governors, motors, feedback, inputs."""

from __future__ import annotations

from typing import Any

from tests.random.description import GROUND, Train
from tests.random.draw import Growth, any_signal, corner_signal, digits, given_input
from tests.random.expressions import Node, call, either, sense, table, thing
from tests.random.families import pieces


def control(seed: int) -> Train:
    """A train with one to three controlled sources."""
    g = Growth("control", seed)
    d = g.d
    bodies = [g.body(w0=d.choice((None, 0.0, d.even(5.0, 60.0), d.even(-60.0, 60.0))))]
    for _ in range(d.randint(0, 4)):
        a, b = d.choice(bodies), None
        if d.chance(0.2):
            b = pieces.gear(g, a)
        else:
            b = g.body(w0=g.speed())
            pieces.shaft(g, a, b, smooth=False)
        bodies.append(b)
    for _ in range(d.randint(1, 3)):
        source(g, d.choice(bodies), d.choice(bodies))
    for _ in range(d.randint(0, 2)):
        d.choice((
            lambda: pieces.damper(g, d.choice(bodies), GROUND), lambda: pieces.speed_load(g, d.choice(bodies), dry=False),
            lambda: pieces.torque(g, d.choice(bodies)), lambda: pieces.shaft(g, d.choice(bodies), GROUND),
        ))()  # fmt: skip
    return g.train()


def source(g: Growth, node: str, read: str) -> None:
    """A torque that depends on time, a speed or an angle, such that it never holds a switch on its surface."""
    d = g.d
    size = pieces.torque_size(g, node)
    phi, w = sense(f"{read}.phi"), sense(f"{read}.w")
    turns = d.choice((1.0, 1.0, 2.0, 3.0, 8.0))
    wave = call("sin", turns * phi)
    gain = digits(size / d.log(2.0, 30.0))
    w1 = d.log(2.0, 60.0)
    signal: Any = d.choice((
        lambda: either(size, call("cos", turns * phi) > d.even(-0.5, 0.95), 0.0),
        lambda: either(size, wave > 0.0, d.choice((0.0, digits(0.3 * size)))),
        lambda: size * call("Abs", wave),
        lambda: size * call("Max", wave, d.even(-0.5, 0.8)),
        lambda: table((0.0, 0.8, 2.0, 6.28), (0.0, size, digits(-0.4 * size), 0.0), d.choice(("linear", "cubic")), True, phi),
        lambda: either(gain * (w1 - w), w < w1, 0.0),
        lambda: -1.0 * gain * w + size * wave,
        lambda: call("Min", call("Max", gain * (w1 + -1.0 * w), digits(-size)), size),
        lambda: table((-w1, 0.0, w1), (size, size, digits(-0.5 * size)), "linear", False, w),
        lambda: call("tanh", digits(2.0 / w1) * (w1 - w)) * size,
        lambda: corner_signal(d, size, g.t_end),
        lambda: given_input(g, size) + -gain * w,
        lambda: either(size, Node("<", (w, w1)), digits(0.5 * size)) if d.chance(0.5) else any_signal(d, size, g.t_end),
    ))()  # fmt: skip
    if d.chance(0.25):
        machine(g, node, size)
    else:
        pieces.torque(g, node, signal)


def machine(g: Growth, node: str, size: float) -> None:
    """A governor with an engine map, a DC motor, or an eddy current brake that is switched."""
    d = g.d
    target = d.log(3.0, 50.0)
    kind = d.random()
    if kind < 0.5:
        integral = d.choice((None, d.log(0.1, 5.0)))
        lag = d.choice((None, d.log(0.02, 0.5)))
        governor = g.add("governor", "Governor", {"flange": node}, target=target, gain=d.log(0.02, 1.0),
                         integral_gain=integral, time_constant=lag, bias=d.choice((None, 0.2)))  # fmt: skip
        command = sense(f"{governor}.command")
        if d.chance(0.5):
            pieces.torque(g, node, size * command)
        else:
            z = ((0.0, digits(0.8 * size)), (digits(-0.2 * size), size), (digits(-0.3 * size), digits(0.5 * size)))
            map2 = thing("Table2", x=(0.0, target, 2 * target), y=(0.0, 1.0), z=z)
            g.add("engine", "Engine", {"flange": node}, torque_map=map2, throttle=command)
    elif kind < 0.8:
        k = d.log(0.1, 2.0)
        u = call("Min", call("Max", 2.0 * (target - sense(f"{node}.w")), -10.0), 10.0)
        g.add("motor", "DCMotor", {"flange": node}, R=d.log(0.1, 5.0), L=d.log(0.01, 1.0), k=k, u=u)
    else:
        excitation = (
            call("Abs", any_signal(d, 1.0, g.t_end))
            if d.chance(0.5)
            else table((0.0, digits(0.5 * g.t_end)), (1.0, 0.0), "step")
        )
        g.add(
            "eddy",
            "EddyCurrentBrake",
            {"flange": node},
            tau_nominal=size,
            w_nominal=d.log(2.0, 50.0),
            excitation=excitation,
        )
