"""A brake whose capacity fades below its load shortly before load and capacity come to zero: a step from there may end where
both are none, and a force of nothing at both ends of a step tells nothing of what it is between.

Evidence: the body, held or sliding one way, integrated piece by piece (scipy); what drives it turns faster all the time.
"""

import math
import random
from dataclasses import dataclass

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gearblocks as gb

J, END = 0.0854, 3.0


@dataclass(frozen=True)
class Case:
    """A load a |sin(p t)| of a brake that slides, beside a brake that holds b + c cos(q t), or nothing below zero."""

    a: float
    p: float
    b: float
    c: float
    q: float

    def excess(self, t):
        return self.a * abs(math.sin(self.p * t)) - max(0.0, self.b + self.c * math.cos(self.q * t))

    def angle(self, until):
        """The angle of the body at that time."""
        t, phi, grid = 0.0, 0.0, np.linspace(0.0, until, 6001)
        values = np.array([self.excess(x) for x in grid])
        while True:
            later = grid[(grid > t + 1e-9) & (values > 0.0)]
            if not len(later):
                return phi
            first, step = later[0], grid[1]
            t = (
                brentq(self.excess, max(first - step, t), first, xtol=1e-15)
                if self.excess(max(first - step, t)) < 0.0
                else t
            )

            def rests(_, y):
                return y[1]

            rests.terminal, rests.direction = True, -1
            run = solve_ivp(
                lambda x, y: [y[1], self.excess(x) / J],
                (t, until),
                [0.0, 0.0],
                "DOP853",
                rtol=1e-9,
                atol=1e-13,
                events=rests,
                max_step=0.01,
            )
            t, phi = run.t[-1], phi + run.y[0, -1]
            if t >= until:
                return phi

    def rig(self):
        rig = gb.Drivetrain("fading")
        held, drives = rig.add("held", gb.Inertia(J=J)), rig.add("drives", gb.Inertia(J=2.0, w0=45.0))
        slides = rig.add("slides", gb.Brake(capacity=self.a * sp.Abs(gb.sin(self.p * gb.time))))
        brake = rig.add("brake", gb.Brake(capacity=self.b + self.c * gb.cos(self.q * gb.time)))
        rig.connect(held.a, slides.a, brake.a)
        rig.connect(drives.a, slides.housing)
        return rig


def _cases(number):
    draw = random.Random(3)
    for _ in range(number):
        a, p, b = draw.uniform(0.03, 0.2), draw.uniform(3.0, 9.0), draw.uniform(0.05, 0.2)
        yield Case(a, p, b, b * draw.uniform(1.2, 3.0), draw.uniform(3.0, 9.0))


@pytest.mark.parametrize("case", list(_cases(24)))
@pytest.mark.few(4)
def test_what_lets_go_shortly_before_its_load_is_none_is_not_missed(case):
    true, model = case.angle(END), gb.build(case.rig())
    for method, rtol in (("dp8", 1e-4), ("dp8", 1e-6), ("auto", 1e-6), ("dp5", 1e-4), ("rodas", 1e-5)):
        run = gb.simulate(model, t=[0.0, END], method=method, rtol=rtol)
        assert run["held.phi"][-1] == pytest.approx(true, rel=100 * rtol), (method, rtol)
