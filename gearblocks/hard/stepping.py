"""The solver driven in communication steps, as an FMU drives it: the same core, in this process."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.hard.judging import RTOL, Check, Meter, below, count, expect, fact, heat, largest, started
from gearblocks.hard.parts import line

LOCK, SPEED, HEAT = 4 / 3, 100 / 3, 1e4 / 3
"""When the clutch of `_launch` locks [s], at which speed [rad/s], and what it lost by then [J]."""


def a_million_rpm(meter: Meter) -> Iterator[Check]:
    """100 teeth at 1e6 rpm for 1e4 s in steps of 1e-3 s: the phase of the mesh after 1e7 steps."""
    w, end, step = gb.rpm(1e6), 1e4, 1e-3
    rig = gb.Drivetrain("spindle")
    variation = gb.Fourier(cos=(0.1,))
    mesh = gb.GearMesh(teeth=(100, 150), r_base=(0.1, 0.15), external=True, k=10.0, stiffness_variation=variation)
    rig.chain(
        rig.add("pinion", gb.Inertia(J=1e-3, w0=w)), rig.add("mesh", mesh), rig.add("wheel", gb.Inertia(J=4e-3, w0=-w * 2 / 3))
    )  # fmt: skip
    run = meter.simulate(rig, t=[0.0, end], step=step)
    cycles = _cycles(w, end, 100)
    off = (run["mesh.mesh_phase"][-1] - cycles + 0.5) % 1.0 - 0.5
    yield below("mesh phase off by", 2 * math.pi * abs(off), 1e-3)
    yield fact(f"{meter.steps} steps", meter.steps >= round(end / step))


def _cycles(w: float, t: float, teeth: int) -> float:
    """teeth w t / (2 pi) less its whole turns, from exact fractions."""
    from fractions import Fraction

    pi = Fraction("3.14159265358979323846264338327950288419716939937510")
    return float((teeth * Fraction(w) * Fraction(t) / (2 * pi)) % 1)


def _launch() -> gb.Drivetrain:
    """J = 1 at 100 rad/s and J = 2 at rest behind a clutch of 50: locks at 4/3 s."""
    return line(
        "launch",
        ("one", gb.Inertia(J=1.0, w0=100.0)), ("clutch", gb.Clutch(capacity=50.0)), ("two", gb.Inertia(J=2.0, w0=0.0)),
    )  # fmt: skip


def _stepped(meter: Meter, model: gb.Model, times: Iterable[float]) -> tuple[Any, float, int]:
    """Outputs at the communication points (rows), heat of the clutch at the end, events."""
    began = time.thread_time()
    with started(model) as sim:
        rows = []
        for t in times:
            expect(sim.advance(float(t)))
            rows.append(sim.outputs())
        lost = heat(sim, model, "clutch")
        events = int(sim.counters.events)
        meter.count(sim.counters, time.thread_time() - began)
    return np.array(rows), lost, events


def lock_up(meter: Meter) -> Iterator[Check]:
    """5 s in communication steps of 1e-2 s are one call."""
    model, times = gb.build(_launch()), np.arange(1, 501) * 1e-2
    rows, lost, _ = _stepped(meter, model, times)
    calls = meter.rhs_calls
    whole = meter.simulate(model, t=times)
    yield below("heat off by (relative)", abs(lost / HEAT - 1), 1e-6)
    yield count("calls", calls, 20_000)
    names = [q.name for q in model.program.outputs]
    w = rows[:, names.index("one.w")]
    yield below("speed off by", abs(w[-1] - SPEED), 1e-6)
    yield below("off one call by", largest(w - whole["one.w"]), 1e-9)


def state_across_event(meter: Meter) -> Iterator[Check]:
    """Saved before the lock-up, stepped past it, restored, stepped again: the same bits."""
    model = gb.build(_launch())
    with started(model) as sim:
        expect(sim.advance(1.3))
        kept = sim.save()
        passes = []
        for _ in range(2):
            expect(sim.restore(kept))
            rows = []
            for t in (1.31, 1.4, 2.0):
                expect(sim.advance(t))
                rows.append(np.concatenate([sim.outputs(), sim.state()]))
            passes.append(np.array(rows).tobytes())
        meter.count(sim.counters)
        yield fact(f"{len(passes[0])} bytes equal", passes[0] == passes[1])
        names = [q.name for q in model.program.outputs]
        yield below("slip at the end", abs(sim.outputs()[names.index("clutch.w_rel")]), 1e-300)


def grids(meter: Meter) -> Iterator[Check]:
    """Communication steps of 1e-1, 1e-2, 1e-3 s and one that ends on the event: the same motion and events."""
    model = gb.build(_launch())
    names = [q.name for q in model.program.outputs]
    wanted = [names.index(name) for name in ("one.w", "two.w", "one.phi", "two.phi")]
    plain = {h: np.arange(1, round(2.0 / h) + 1) * h for h in (1e-1, 1e-2, 1e-3)}
    event = float(meter.simulate(model, t_end=2.0).events[-1].t)
    found = {f"{h:g} s": (times, *_stepped(meter, model, times)) for h, times in plain.items()}
    times = np.union1d(plain[1e-1], [event])
    found["on the event"] = (times, *_stepped(meter, model, times))
    base = found["0.1 s"]
    scale = np.abs(base[1][:, wanted]).max(axis=0)
    for name, (times, rows, _, events) in found.items():
        at = [int(np.argmin(np.abs(times - t))) for t in base[0]]
        off = largest((rows[at][:, wanted] - base[1][:, wanted]) / scale)
        yield below(f"{name}: off by", off, 10 * RTOL)
        yield fact(f"{events} events", events == base[3])
