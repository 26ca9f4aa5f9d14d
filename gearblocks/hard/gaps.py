"""Play: nearly none, exactly none, chaotic, backwards in time, in other units, in another order."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.hard.judging import RTOL, Check, Meter, below, count, fact, largest
from gearblocks.hard.parts import swing

REVERSALS = 10.0 * gb.sin(2 * math.pi * gb.time)


def _against_no_gap(meter: Meter, half_gap: float) -> Iterator[Check]:
    """A stiff mesh with play under a load that reverses, held against the same one without play at 1e-10."""
    t = np.linspace(0.0, 2.0, 401)
    lash = gb.Lash(k=1e6, c=20.0, half_gap=half_gap)
    run = meter.simulate(swing("play", lash, tau=REVERSALS), t=t)
    events = run.stats.events
    tight = meter.simulate(swing("no play", gb.Shaft(k=1e6, c=20.0), tau=REVERSALS), t=t, rtol=1e-10)
    yield fact(f"reaches t = {run.t[-1]:g} s", run.t[-1] == 2.0)
    yield below("off the spring without play by", largest(run["body.phi"] - tight["body.phi"]), 2e-9)
    yield count("events", events, 199)


def tiny_gap(meter: Meter) -> Iterator[Check]:
    """Play of 1e-9 rad."""
    yield from _against_no_gap(meter, 5e-10)


def no_gap(meter: Meter) -> Iterator[Check]:
    """Play of 0: both edges of the gap are one point."""
    yield from _against_no_gap(meter, 0.0)


def chaotic_pair(meter: Meter) -> Iterator[Check]:
    """x'' + 0.02 x' + g(x) = 0.1 + 0.192 cos 0.8 t: the rms of 400 periods after 100, which scatters by 2 % from one start
    to the next; of 16 starts by 0.5 %."""
    period, per_period = 2 * math.pi / 0.8, 20
    t = period * np.arange(100 * per_period, 500 * per_period + 1) / per_period
    lash = gb.Lash(k=1.0, c=0.02, half_gap=1.0, contact_damping="always")
    drive = 0.1 + 0.192 * gb.cos(0.8 * gb.time)
    model = gb.build(swing("chaos", lash, tau=drive))
    starts = [{"body.phi": 1e-3 * i} for i in range(16)]
    x = np.array([meter.simulate(model, t=t, initial=start)["body.phi"] for start in starts])
    rms, wanted = (float(np.sqrt(np.mean(y**2))) for y in (x, _chaos(t)))
    yield below("largest angle", largest(x), 10.0)
    yield below(f"rms {rms:.4f}, off DOP853 by", abs(rms / wanted - 1), 0.05)


def _chaos(t: Any) -> Any:
    """x at the times t by DOP853 at 1e-10."""
    from scipy.integrate import solve_ivp

    def rates(t: float, y: Any) -> Any:
        x, v = y
        g = x - 1.0 if x > 1.0 else x + 1.0 if x < -1.0 else 0.0
        return (v, 0.1 + 0.192 * math.cos(0.8 * t) - 0.02 * v - g)

    return solve_ivp(rates, (0.0, t[-1]), [0.0, 0.0], "DOP853", t_eval=t, rtol=1e-10, atol=1e-12).y[0]


def _pair(scale: float = 1.0, c: float | None = None) -> gb.Drivetrain:
    """Two bodies with play between them; scale multiplies inertia, stiffness, damping and torque."""
    rig = gb.Drivetrain("pair with play")
    one = rig.add("one", gb.Inertia(J=1.0 * scale, w0=0.3))
    lash = rig.add("lash", gb.Lash(k=100.0 * scale, half_gap=0.1, c=None if c is None else c * scale))
    rig.chain(one, lash, rig.add("two", gb.Inertia(J=2.0 * scale)))
    if c is not None:
        swinging = 1.0 * scale * gb.sin(3 * gb.time)
        rig.connect(rig.add("torque", gb.Torque(tau=swinging)).flange, one.a)
    return rig


def time_reversal(meter: Meter) -> Iterator[Check]:
    """Forth and back again without losses: what is missed grows with the tolerance and the motion's own sensitivity."""
    model, span = gb.build(_pair()), 5.0
    names = ("one.phi", "two.phi", "one.w", "two.w")

    def after(start: dict[str, float]) -> Any:
        run = meter.simulate(model, t=[0.0, span], initial=start)
        return np.array([run[name][-1] for name in names])

    begin = {"one.phi": 0.0, "two.phi": 0.0, "one.w": 0.3, "two.w": 0.0}
    end = after(begin)
    events = meter.events
    back = after(dict(zip(names, end * [1, 1, -1, -1], strict=True))) * [1, 1, -1, -1]
    nudge = 1e-4
    slopes = [(after(begin | {name: begin[name] + nudge}) - end) / nudge for name in names]
    condition = float(np.linalg.norm(np.array(slopes), 2))
    missed = largest(back - list(begin.values()))
    yield below(f"condition {condition:.3g}, {events} events, start missed by", missed, 100 * RTOL * condition)


def unit_scaling(meter: Meter) -> Iterator[Check]:
    """Inertia, stiffness, damping and torque by 1e-12 and 1e12: the same motion."""
    t = np.linspace(0.0, 20.0, 201)
    plain = meter.simulate(_pair(c=0.5), t=t)
    for scale in (1e-12, 1e12):
        run = meter.simulate(_pair(scale, c=0.5), t=t)
        off = max(largest(run[x] - plain[x]) / largest(plain[x]) for x in ("one.phi", "two.phi", "one.w", "two.w"))
        yield below(f"scale {scale:g}: off by", off, 1e-10)
        yield fact(f"{len(run.events)} events of {len(plain.events)}", len(run.events) == len(plain.events))


def order_of_parts(meter: Meter) -> Iterator[Check]:
    """Parts added in another order, every element turned round, other names: the same motion."""
    t = np.linspace(0.0, 5.0, 201)
    plain = meter.simulate(_shuffled(range(6), False), t=t)
    for order, flipped in (((5, 3, 1, 4, 2, 0), False), (range(6), True), ((2, 0, 5, 4, 1, 3), True)):
        run = meter.simulate(_shuffled(order, flipped), t=t)
        off = max(
            largest(run[f"{body}.{what}"] - plain[f"{body}.{what}"]) / largest(plain[f"{body}.{what}"])
            for body in ("j0", "j3", "j5") for what in ("phi", "w")
        )  # fmt: skip
        words = "".join(map(str, order)) + (" turned round" if flipped else "")
        yield below(f"{words}: off by", off, 1e-12)


def _shuffled(order: Any, flipped: bool) -> gb.Drivetrain:
    """Torque, two springs with a gear between, play, in any order of adding, in either direction."""
    rig = gb.Drivetrain("shuffled")
    teeth = (60, 20) if flipped else (20, 60)
    blocks: dict[int, gb.Block] = {
        0: gb.Inertia(J=1.0), 1: gb.Shaft(k=50.0, c=0.2), 2: gb.IdealGear(teeth=teeth, external=False),
        3: gb.Inertia(J=4.0), 4: gb.Lash(k=300.0, half_gap=0.02, c=0.5), 5: gb.Inertia(J=2.0),
    }  # fmt: skip
    names = {0: "j0", 1: "shaft", 2: "gear", 3: "j3", 4: "lash", 5: "j5"}
    made = {i: rig.add(names[i], blocks[i]) for i in order}
    torque = rig.add("torque", gb.Torque(tau=5.0 * gb.sin(4 * gb.time)))
    a, b = ("b", "a") if flipped else ("a", "b")
    for left, right in zip(range(5), range(1, 6), strict=True):
        rig.connect(getattr(made[left], b), getattr(made[right], a))
    rig.connect(torque.flange, getattr(made[0], a))
    return rig
