"""Smooth trains: springs in chains, trees and loops, shafts without inertia, gears, planetaries, prescribed motions."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from tests.random.description import GROUND, WALL, Train
from tests.random.draw import Growth, digits, smooth_signal
from tests.random.expressions import TIME, call
from tests.random.families import meshes, pieces


def smooth(seed: int) -> Train:
    """A train without switches."""
    g = Growth("smooth", seed)
    d = g.d
    bodies = [g.body(w0=g.speed(), phi0=d.choice((None, None, 0.0, d.even(-0.5, 0.5))))]
    for _ in range(d.randint(1, 7)):
        _extend(g, bodies)
    for _ in range(d.randint(0, 2)):  # loops
        if len(bodies) > 2:
            a, b = d.sample(bodies, 2)
            d.choice((pieces.shaft, pieces.shaft, pieces.damper))(g, a, b)
    if d.chance(0.5):
        pieces.shaft(g, d.choice(bodies), GROUND)
    for _ in range(d.randint(1, 2)):
        pieces.torque(g, d.choice(bodies), smooth=True)
    if d.chance(0.3):
        _drag(g, d.choice(bodies))
    if d.chance(0.15):
        _slider(g, d.choice(bodies))
    return g.train()


def _extend(g: Growth, bodies: list[str]) -> None:
    d, a = g.d, g.d.choice(bodies)
    kind = d.random()
    if kind < 0.36:
        b = g.body(w0=g.speed())
        pieces.shaft(g, a, b)
        bodies.append(b)
    elif kind < 0.5:
        bodies.append(pieces.gear(g, a))
    elif kind < 0.58:
        bodies.extend(pieces.planetary(g, a))
    elif kind < 0.72:
        b = g.body(w0=g.speed())
        _massless(g, a, b)
        bodies.append(b)
    elif kind < 0.82:
        b = g.body(w0=g.speed())
        meshes.mesh(g, a, b, gap=False)
        bodies.append(b)
    elif kind < 0.88:
        bodies.append(meshes.noncircular(g, a))
    elif kind < 0.92:
        b = g.body(w0=g.speed())
        meshes.noncircular(g, a, b)
        bodies.append(b)
    elif kind < 0.96:
        b = g.follower()
        g.add("joint", "UniversalJoint", {"a": a, "b": b}, angle=d.even(0.1, 1.0))
        bodies.append(b)
    else:
        b = g.follower()
        g.add("belt", "BeltDrive", {"a": a, "b": b}, ratio=abs(d.ratio()))
        bodies.append(b)


def _massless(g: Growth, a: str, b: str) -> None:
    """Springs and dampers in a row whose nodes have no inertia, at times a load on one of them."""
    d = g.d
    if d.chance(0.3):
        pieces.maxwell(g, a, b)
        return
    nodes = [a, *(g.bare() for _ in range(d.randint(1, 2))), b]
    for n in nodes[1:-1]:
        if d.chance(0.5):  # a body with J = 0
            g.add("light", "Inertia", {"a": n}, J=0.0)
    for left, right in pairwise(nodes):
        k = digits(g.reduced(a, b) * d.log(6.0, 60.0) ** 2)
        g.add(
            "shaft", "Shaft", {"a": left, "b": right}, k=k, c=digits(k / d.log(5.0, 2000.0)) if d.chance(0.5) else None
        )
    if d.chance(0.3):
        signal: Any = smooth_signal(d, pieces.torque_size(g, a), g.t_end)
        g.add("torque", "Torque", {"flange": nodes[1]}, tau=signal)


def _drag(g: Growth, node: str) -> None:
    d = g.d
    kind = d.random()
    if kind < 0.3:
        g.add(
            "eddy",
            "EddyCurrentBrake",
            {"flange": node},
            tau_nominal=pieces.torque_size(g, node),
            w_nominal=d.log(2.0, 50.0),
        )
    elif kind < 0.6:
        k = d.log(0.1, 2.0)
        g.add("motor", "DCMotor", {"flange": node}, R=d.log(0.1, 5.0), L=d.log(0.01, 1.0), k=k,
              u=smooth_signal(d, digits(k * d.log(2.0, 30.0)), g.t_end))  # fmt: skip
    else:
        w = d.log(1.0, 15.0)
        law = d.choice((
            digits(d.log(0.5, 10.0)) * call("sin", w * TIME), d.even(-10.0, 10.0) + 0.0 * TIME,
            d.log(1.0, 10.0) * TIME,
        ))  # fmt: skip
        driven = g.bare()
        g.add("drive", "Speed", {"flange": driven}, w=law)
        pieces.shaft(g, driven, node)


def _slider(g: Growth, node: str) -> None:
    d = g.d
    m = g.mass(d.log(0.1, 5.0))
    g.add("rack", "Rack", {"flange": node, "slider": m}, radius=d.choice((0.1, 0.25, 0.5, -0.3)))
    if d.chance(0.6):
        k = digits(g.inertia[m] * d.log(3.0, 40.0) ** 2)
        g.add("spring", "Shaft", {"a": m, "b": WALL}, k=k, c=d.choice((None, digits(0.02 * k))))
    if d.chance(0.5):
        pieces.torque(g, m, smooth=True)
