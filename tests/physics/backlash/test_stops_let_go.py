"""A stop that lets go of a body slowly: nothing of it is left when something else happens in flight."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gearblocks as gb

K, C, LIMIT, END = 3.23, 0.291, 0.1, 3.0


def drive(sine, largest, t, f, g):
    return 13.65 * largest(sine(f * t), -0.15) - g * (1 - sine(5 * t + np.pi / 2))


def oscillator(side: int, slides: bool) -> gb.Drivetrain:
    """A body between stops without restitution; its drive has a corner while it is in flight."""
    rig = gb.Drivetrain("let go")
    tau = side * drive(gb.sin, sp.Max, gb.time, gb.Parameter("f", 4.64), gb.Parameter("g", 5.67))
    body = rig.add("body", gb.Mass(m=4.0) if slides else gb.Inertia(J=4.0))
    load = rig.add("load", gb.Force(f=tau) if slides else gb.Torque(tau=tau))
    stop = rig.add("stop", gb.HardStop(restitution=0.0, lower=-LIMIT, upper=LIMIT))
    spring, ground = rig.add("spring", gb.Shaft(k=K, c=C)), rig.add("ground", gb.Fixed())
    rig.connect(body.a, load.flange, stop.a)
    rig.connect(body.b, spring.a)
    rig.connect(spring.b, ground.flange)
    return rig


def motion(f: float, g: float) -> float:
    """Where the body is at the end: flights and rests in turn."""

    def push(t, x=-LIMIT, v=0.0):
        return drive(np.sin, max, t, f, g) - K * x - C * v

    def at(t, y):
        return LIMIT - abs(y[0])

    at.terminal, at.direction = True, -1
    t, y = 0.0, [0.0, 0.0]
    while t < END:
        flight = solve_ivp(
            lambda t, y: [y[1], push(t, *y) / 4],
            (t, END),
            y,
            "DOP853",
            events=at,
            rtol=1e-11,
            atol=1e-13,
            max_step=4e-3,
        )
        t, x = flight.t[-1], flight.y[0, -1]
        if flight.status == 0:
            return x
        rests = np.linspace(t, END, 3001)
        pressed = [np.sign(x) * push(s, x) > 0 for s in rests]
        if all(pressed):
            return x
        i = pressed.index(False)
        if i:
            t = brentq(push, rests[i - 1], rests[i], args=(x,), xtol=1e-14)
        t += 1e-9
        y = [x * (1 - 1e-15), 0.0]
    return y[0]


@pytest.mark.parametrize(("side", "slides"), [(1, False), (-1, False), (1, True)])
@pytest.mark.few(1)
def test_a_body_that_a_stop_lets_go_does_not_stop_in_flight(side, slides):
    model = gb.build(oscillator(side, slides))
    for f, g in ((4.4, 5.3), (4.4, 6.0), (4.64, 5.67)):
        right = side * motion(f, g)
        for method in ("dp5", "dp8", "rodas"):
            for rtol in (1e-6, 1e-8):
                run = gb.simulate(model, t_end=END, method=method, rtol=rtol, parameters={"f": f, "g": g})
                found = run["body.s" if slides else "body.phi"][-1]
                assert found == pytest.approx(right, abs=30 * rtol), (f, g, method, rtol)
