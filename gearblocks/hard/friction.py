"""Dry friction: rest, break-away, locks that are more than enough, chatter that is none and chatter that is real."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.hard.judging import Check, Meter, below, count, fact, largest
from gearblocks.hard.parts import driven, line

CALLS = 5000


def _braked(meter: Meter, t: Any, *, tau: Any, capacity: Any = 10.0, w0: float = 0.0) -> Any:
    """The run of a body of J = 1 with one brake, at the times t."""
    return meter.simulate(driven("braked", ("brake", gb.Brake(capacity=capacity)), tau=tau, w0=w0), t=t)


def brake_holds(meter: Meter) -> Iterator[Check]:
    """Stops at t = 0.2 at phi = 0.1 and stays."""
    t = np.linspace(0.0, 10.0, 1001)
    run = _braked(meter, t, tau=5.0, w0=1.0)
    held = t > 0.2 + 1e-6
    yield below("speed at rest", largest(run["body.w"][held]), 1e-9)
    yield below("phi off by", largest(run["body.phi"][held] - 0.1), 1e-6)
    yield fact("speed at rest is 0.0", not run["body.w"][held].any())
    yield count("calls", meter.rhs_calls, CALLS)


def no_net_torque_while_sliding(meter: Meter) -> Iterator[Check]:
    """A drive as strong as the brake keeps the speed."""
    run = meter.simulate(driven("sliding", ("brake", gb.Brake(capacity=10.0)), tau=10.0, w0=1.0), t_end=100.0)
    yield below("w off by", largest(run["body.w"] - 1.0), 1e-9)


def no_net_torque_at_rest(meter: Meter) -> Iterator[Check]:
    """A drive that rises to the capacity exactly does not break the brake away."""
    tau = gb.Table([0.0, 5.0], [0.0, 10.0], kind="step")
    run = meter.simulate(driven("at rest", ("brake", gb.Brake(capacity=10.0)), tau=tau), t_end=10.0)
    yield below("phi", largest(run["body.phi"]), 1e-9)


def equal_speeds(meter: Meter) -> Iterator[Check]:
    """A clutch between shafts of one speed locks at once."""
    rig = line(
        "equal speeds",
        ("torque", gb.Torque(tau=50.0)), ("one", gb.Inertia(J=1.0, w0=100.0)), ("clutch", gb.Clutch(capacity=100.0)),
        ("two", gb.Inertia(J=1.0, w0=100.0)),
    )  # fmt: skip
    run = meter.simulate(rig, t_end=5.0)
    yield below("slip", largest(run["clutch.w_rel"]), 1e-9)
    yield below("w off by", abs(run["one.w"][-1] - 225.0), 1e-5)
    yield count("calls", meter.rhs_calls, CALLS)


def two_locks_at_once(meter: Meter) -> Iterator[Check]:
    """Two clutches lock at t = 0.5, all at rest then."""
    rig = line(
        "two locks",
        ("one", gb.Inertia(J=1.0, w0=10.0)), ("left", gb.Clutch(capacity=20.0)), ("two", gb.Inertia(J=1.0, w0=0.0)),
        ("right", gb.Clutch(capacity=20.0)), ("three", gb.Inertia(J=1.0, w0=-10.0)),
    )  # fmt: skip
    t = np.linspace(0.0, 5.0, 501)
    run = meter.simulate(rig, t=t)
    rest = t > 0.5 + 1e-6
    yield below("speed at rest", max(largest(run[f"{x}.w"][rest]) for x in ("one", "two", "three")), 1e-9)
    yield below("asymmetry", largest(run["one.w"] + run["three.w"]), 1e-9)
    yield count("calls", meter.rhs_calls, CALLS)


def redundant_brakes(meter: Meter) -> Iterator[Check]:
    """Brakes of 4 and 4 hold 5 together."""
    brakes = (("left", gb.Brake(capacity=4.0)), ("right", gb.Brake(capacity=4.0)))
    run = meter.simulate(driven("two brakes", *brakes, tau=5.0, w0=1.0), t_end=5.0)
    shares = [float(run[f"{x}.torque"][-1]) for x in ("left", "right")]
    yield below("speed at rest", abs(run["body.w"][-1]), 1e-9)
    yield below(f"shares {shares[0]:.4g} and {shares[1]:.4g}: sum off by", abs(sum(shares) - 5.0), 1e-9)
    yield below("largest share", max(map(abs, shares)), 4.0 + 1e-9)
    yield count("calls", meter.rhs_calls, CALLS)


def _planetary(drive: Any, **brakes: Any) -> gb.Drivetrain:
    """w_s + 2 w_r = 3 w_c with J = 0.1, 1, 0.5 on sun, carrier, ring, the torque `drive` on the sun and brakes by member."""
    rig = gb.Drivetrain("planetary")
    gear = rig.add("gear", gb.IdealPlanetary(ratio=2.0))
    for member, J in (("sun", 0.1), ("carrier", 1.0), ("ring", 0.5)):
        body = rig.add(member, gb.Inertia(J=J))
        rig.connect(body.a, getattr(gear, member))
        if member in brakes:
            rig.connect(rig.add(f"{member}_brake", gb.Brake(capacity=brakes[member])).a, body.a)
    rig.connect(rig.add("torque", gb.Torque(tau=drive)).flange, gear.sun)
    return rig


def braked_ring_and_carrier(meter: Meter) -> Iterator[Check]:
    """Two locks on two degrees of freedom: no motion, torques from the static balance."""
    run = meter.simulate(_planetary(3.0, ring=100.0, carrier=100.0), t_end=5.0)
    yield below("sun speed", largest(run["sun.w"]), 1e-9)
    yield below("ring brake off 6 by", abs(run["ring_brake.a.tau"][-1] - 6.0), 1e-9)
    yield below("carrier brake off -9 by", abs(run["carrier_brake.a.tau"][-1] + 9.0), 1e-9)
    yield count("calls", meter.rhs_calls, CALLS)


def long_hold(meter: Meter) -> Iterator[Check]:
    """Held for 1000 s: no creep."""
    run = _braked(meter, [1.0, 1001.0], tau=5.0, w0=1.0)
    yield below("creep", abs(run["body.phi"][1] - run["body.phi"][0]), 1e-9)
    yield count("calls", meter.rhs_calls, CALLS)


def grazing_capacity(meter: Meter) -> Iterator[Check]:
    """The capacity dips to 5 + 1e-9 under a torque of 5."""
    capacity = 6.0 - gb.cos(2 * math.pi * gb.time) * (1 - 1e-9)
    run = meter.simulate(driven("grazing", ("brake", gb.Brake(capacity=capacity)), tau=5.0), t_end=5.0)
    yield below("phi", largest(run["body.phi"]), 1e-9)
    yield count("calls", meter.rhs_calls, 20_000)


def faint_deceleration(meter: Meter) -> Iterator[Check]:
    """1e-3 rad/s is braked by 1e-6 rad/s2."""
    run = _braked(meter, [0.0, 1500.0, 2000.0], tau=10.0 - 1e-6, w0=1e-3)
    yield below("phi off by", largest(run["body.phi"][1:] - 0.5), 1e-6)
    yield below("speed", largest(run["body.w"][1:]), 1e-9)
    yield count("calls", meter.rhs_calls, CALLS)


def always_zero(meter: Meter) -> Iterator[Check]:
    """A clutch of capacity 0, and play of 0 at a twist of 0: nothing happens."""
    rig = line(
        "no capacity",
        ("one", gb.Inertia(J=1.0, w0=1.0)), ("clutch", gb.Clutch(capacity=0.0 * gb.time)), ("two", gb.Inertia(J=1.0)),
    )  # fmt: skip
    run = meter.simulate(rig, t_end=10.0)
    yield count("capacity 0: events", len(run.events), 1)
    yield below("w off by", largest(run["one.w"] - 1.0) + largest(run["two.w"]), 1e-12)
    rig = line(
        "zero gap", ("one", gb.Inertia(J=1.0)), ("lash", gb.Lash(k=1.0, half_gap=0.0)), ("two", gb.Inertia(J=1.0))
    )
    run = meter.simulate(rig, t_end=10.0)
    yield count("twist 0: events", len(run.events), 1)
    yield below("angle", largest(run["one.phi"]) + largest(run["two.phi"]), 1e-12)


def events_at_samples(meter: Meter) -> Iterator[Check]:
    """The capacity jumps at t = 0, on samples and at the end: every jump once, both sides of it where steps are recorded."""
    capacity = gb.Table([0.0, 1.0, 2.0, 3.0], [8.0, 0.0, 8.0, 0.0], kind="step")
    rig = driven("steps", ("brake", gb.Brake(capacity=capacity)), tau=5.0, w0=10.0)
    run = meter.simulate(rig, t_end=3.0)
    torque, wanted = run["brake.torque"], {1.0: (8.0, 0.0), 2.0: (0.0, 8.0), 3.0: (8.0, 0.0)}
    for at, (left, right) in wanted.items():
        rows = torque[run.t == at]
        yield fact(f"t = {at:g}: {rows}", len(rows) == 2 and abs(rows[0] - left) < 1e-9 and abs(rows[1] - right) < 1e-9)
    yield below("first torque off 8 by", abs(torque[0] - 8.0), 1e-9)
    switched = [event for event in run.events if event.kind != "time"]
    yield fact(f"{len(switched)} changes of mode", len({(e.t, e.component) for e in switched}) == len(switched))
    sampled = meter.simulate(rig, t=[0.0, 1.0, 2.0, 3.0])
    yield fact(
        f"{len(sampled.events)} events on samples, {len(run.events)} else", len(sampled.events) == len(run.events)
    )
    exact = 10.0 - 3.0 * 1.0 + 5.0 * 1.0 - 3.0 * 1.0
    yield below("w off by", max(abs(x["body.w"][-1] - exact) for x in (run, sampled)), 1e-9)


def freed_member(meter: Meter) -> Iterator[Check]:
    """Sun, carrier and ring are held, the ring is freed at t = 1, and the brake of the sun is too weak for the rest."""
    ring = gb.Table([0.0, 1.0], [100.0, 0.0], kind="step")
    run = meter.simulate(_planetary(3.0, sun=1.0, carrier=100.0, ring=ring), t_end=1.5)
    before = run.t < 1.0
    yield below("speed while held", max(largest(run[f"{x}.w"][before]) for x in ("sun", "carrier", "ring")), 1e-12)
    after = int(np.flatnonzero(run.t == 1.0)[-1])
    exact = (3.0 - 1.0) / (0.1 + 0.5 / 4)
    yield below(f"sun's acceleration off {exact:.4g} by", abs(run["sun.alpha"][after] - exact), 1e-9)
    yield below("carrier speed", largest(run["carrier.w"]), 1e-12)
    firm = meter.simulate(_planetary(3.0, sun=100.0, carrier=100.0, ring=ring), t_end=1.5)
    yield below("speed with a strong sun brake", largest(firm["sun.w"]), 1e-12)


def slow_belt(meter: Meter) -> Iterator[Check]:
    """Stick-slip on a belt of v = 1e-9: the period in closed form, some ten steps each."""
    v, k, static, sliding = 1e-9, 1.0, 1.0, 0.5
    gap = (static - sliding) / k
    period = 2 * gap / v + 2 * (math.pi - math.atan(gap / v))
    rig = gb.Drivetrain("slow belt")
    belt, grip = rig.add("belt", gb.Speed(w=v)), rig.add("grip", gb.Clutch(capacity=sliding, peak=static / sliding))
    body = rig.add("body", gb.Inertia(J=1.0, w0=v))
    rig.chain(belt, grip, body, rig.add("spring", gb.Shaft(k=k)), rig.add("wall", gb.Fixed()))
    cycles = 5
    run = meter.simulate(rig, t_end=(cycles + 1) * period)
    away = [e.t for e in run.events if e.component == "grip" and e.before == 0]
    spans = np.diff(away)
    yield fact(f"{len(away)} times away", len(away) >= cycles)
    yield below("period off by", largest(spans / period - 1) if len(spans) else math.nan, 1e-6)
    yield below("steps per cycle", run.stats.steps / (cycles + 1), 100.0)
