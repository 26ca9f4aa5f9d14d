"""Continuously variable transmission of non-circular gears: three branches, a differential each, and selectors.

          pair 1, th + psi_j ------------> left  \
    input                                         differential j -> shaft -> inertia j -> selector j -> output
          pair 2, th + psi_j + delta ----> carrier /                                     (common)    load

Each branch turns at i_out = k delta/2 of the input while both of its pairs are on the straight part of their ratio law
m = k phi + b (differential: right = 2 carrier/i1 - left, i1 = 2), and falls back in the rest of the turn. N = 3
branches, 2 pi/3 apart, take the load in turn; the selectors are clutches with ramps that overlap (`build`) or dogs.

Law: NORM, m = 0.7 phi/X + 0.5 on X = 240 degrees, closed over a turn. A phase of delta = 0 is geared neutral: the
output rests. Angles of the input count from 0; its position over the laws at the start is the middle of the window of
branch 0.
"""

from __future__ import annotations

import math
from typing import Any

import gearblocks as gb

X = math.radians(240)
LAW = gb.RatioLaw.segments(0.7 / X, 0.5, X)
BRANCHES, SPEED, LOAD, CAPACITY = 3, 262.0, 0.2, 1.0  # -, rad/s, N m, N m
J_BRANCH, J_OUTPUT, K_SHAFT, C_SHAFT = 2.0e-6, 2.0e-5, 100.0, 0.005  # kg m2, kg m2, N m/rad, N m s/rad


def build() -> gb.Drivetrain:
    """60 degrees of phase: clutches that overlap, the new one closing before the old one opens."""
    return selected(math.radians(60))


def changing_over() -> gb.Scene:
    """60 degrees of phase, from the second turn on: peak torque of a branch's shaft and heat of its clutch, to 1 %."""
    turn = math.tau / SPEED
    asked = gb.peak("shaft_0.torque", after=turn), gb.energy_lost("selector_0", after=turn)
    return gb.Scene(build(), t_end=3 * turn, quantity=asked, within=0.01, name="CVT at 60 degrees")


def dogs() -> gb.Drivetrain:
    """120 degrees of phase, no overlap left: dogs that change over at the end of each window."""
    return selected(math.radians(120), dogs=True)


def neutral() -> gb.Drivetrain:
    """No phase: geared neutral, the output rests while all branches swing."""
    return selected(0.0)


def selected(delta: float, *, dogs: bool = False) -> gb.Drivetrain:
    """The transmission at the phase delta [rad] of its second pairs, 0 to 120 degrees."""
    rig = gb.Drivetrain(f"CVT, {math.degrees(delta):.0f} degrees, {'dogs' if dogs else 'clutches'}")
    middle = (X - delta) / 2
    angle = SPEED * gb.time + middle
    source = rig.add("input", gb.Speed(w=SPEED))
    output = rig.add("output", gb.Inertia(J=J_OUTPUT, w0=_branch_speed(middle, delta)))
    rig.connect(rig.add("load", gb.Torque(tau=-LOAD)).flange, output.b)
    for j in range(BRANCHES):
        own = middle - math.tau * j / BRANCHES
        pairs = [
            rig.add(f"pair{i}_{j}", gb.NonCircularGear(law=LAW, external=False, phase=own + (i - 1) * delta))
            for i in (1, 2)
        ]
        differential = rig.add(f"differential_{j}", gb.Differential(ratio=2))
        rig.connect(source.flange, *(pair.a for pair in pairs))
        rig.connect(pairs[0].b, differential.left)
        rig.connect(pairs[1].b, differential.carrier)
        wound = -LOAD / K_SHAFT if j == 0 else 0.0
        branch = rig.add(f"branch_{j}", gb.Inertia(J=J_BRANCH, phi0=wound, w0=_branch_speed(own, delta)))
        shaft = rig.add(f"shaft_{j}", gb.Shaft(k=K_SHAFT, c=C_SHAFT))
        rig.connect(differential.right, shaft.a)
        rig.connect(shaft.b, branch.a)
        select = _dog(j, delta, angle) if dogs else gb.Clutch(capacity=CAPACITY * _ramp(j, delta, angle))
        rig.add(f"selector_{j}", select)
        selector = rig[f"selector_{j}"]
        rig.connect(branch.b, selector.a)
        rig.connect(selector.b, output.a)
    return rig


def _branch_speed(angle: float, delta: float) -> float:
    """Speed of a branch at the angle of its first pair."""
    return SPEED * float(LAW.m(angle + delta) - LAW.m(angle))


def _window(j: int, delta: float) -> tuple[float, float, float]:
    """Angles of the input where the window of branch j begins and ends, and how far it overlaps its neighbours'."""
    pitch = math.tau / BRANCHES
    return pitch * j, pitch * j + X - delta, X - delta - pitch


def _ramp(j: int, delta: float, angle: Any) -> Any:
    """Share of the capacity: up in the second quarter of the overlap, down in the third one of the next.

    A ramp over u = 0 .. 1 is 3 u^2 - 2 u^3.
    """
    begin, end, overlap = _window(j, delta)
    up, down = begin + overlap / 4, end - overlap / 2
    corners = [up, up + overlap / 4, down, down + overlap / 4, up + math.tau]
    u = gb.Table(corners, [0, 1, 1, 0, 0], periodic=True)(angle)
    return 3 * u**2 - 2 * u**3


def _dog(j: int, delta: float, angle: Any) -> gb.Block:
    """A dog that is in until its window ends, when the next one goes in."""
    ends = [math.tau * i / BRANCHES + X - delta for i in range(-1, BRANCHES)]
    turns = gb.Table(ends, [float(i == j) for i in range(BRANCHES)] + [float(j == 0)], kind="step", periodic=True)
    return gb.DogClutch(engaged=turns(angle))
