"""Rigid ties: loops with one tie too many, loops that contradict themselves, prescribed motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

import gearblocks as gb
from gearblocks.hard.judging import Check, Meter, below, largest, refusal

INERTIAS = (1.0, 2.0, 3.0, 4.0)


def _loop(last: float) -> gb.Drivetrain:
    """w1 = -2 w2, w2 = w3, w3 = -w4/last, w4 = w1: four shafts in a ring, a torque of 1 on the first."""
    rig = gb.Drivetrain("power loop")
    bodies = [rig.add(f"j{i}", gb.Inertia(J=J)) for i, J in enumerate(INERTIAS, 1)]
    ties: list[gb.IdealGear | gb.Shaft] = [
        rig.add("down", gb.IdealGear(ratio=-2.0)), rig.add("shaft", gb.Shaft(rigid=True)),
        rig.add("up", gb.IdealGear(ratio=-1 / last)), rig.add("close", gb.Shaft(rigid=True)),
    ]  # fmt: skip
    for i, tie in enumerate(ties):
        rig.connect(bodies[i].a, tie.a)
        rig.connect(tie.b, bodies[(i + 1) % 4].a)
    rig.connect(rig.add("torque", gb.Torque(tau=1.0)).flange, bodies[0].a)
    return rig


def closed_power_loop(meter: Meter) -> Iterator[Check]:
    """One tie of four is redundant: the motion is that of the others, the torques are the shortest that do it."""
    run = meter.simulate(_loop(2.0), t_end=1.0)
    total = INERTIAS[0] + INERTIAS[1] / 4 + INERTIAS[2] / 4 + INERTIAS[3]
    yield below("acceleration off by", largest(run["j1.alpha"] - 1 / total), 1e-9)
    wanted = _shortest(1 / total)
    ours = [run[f"{tie}.{end}.tau"][-1] for tie in ("down", "shaft", "up", "close") for end in ("a", "b")]
    yield below("tie torques off by", largest(np.array(ours) - wanted), 1e-9)


def _shortest(alpha: float) -> Any:
    """Torques on both flanges of the ties where their multipliers are of minimum norm, ties written as in the model."""
    rows = np.array([[1.0, 2.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0], [0.0, 0.0, 1.0, 0.5], [-1.0, 0.0, 0.0, 1.0]])
    accelerations = alpha * np.array([1.0, -0.5, -0.5, 1.0])
    needed = np.array(INERTIAS) * accelerations - [1.0, 0.0, 0.0, 0.0]
    multipliers = np.linalg.lstsq(rows.T, needed, rcond=None)[0]
    ends = ((0, 1), (1, 2), (2, 3), (3, 0))
    return np.array([rows[i, j] * multipliers[i] for i, pair in enumerate(ends) for j in pair])


def contradicting_loop(_meter: Meter) -> Iterator[Check]:
    """Ratios of 2 and 2.000001 in a ring let nothing move; around the loop one turn asks for 1 and for 1.0000005."""
    yield refusal(lambda: gb.build(_loop(2.000001)), "down", "up", "contradict", "1.0000005")


def prescribed_motion(meter: Meter) -> Iterator[Check]:
    """phi1 = sin t on a rigid gear of 3 before J = 2, for 1e4 s."""
    rig = gb.Drivetrain("prescribed")
    source, gear = rig.add("source", gb.Angle(phi=gb.sin(gb.time))), rig.add("gear", gb.IdealGear(ratio=3.0))
    load = rig.add("load", gb.Inertia(J=2.0))
    rig.chain(source, gear, load)
    t = np.linspace(0.0, 1e4, 10_001)
    run = meter.simulate(rig, t=t)
    yield below("torque off by", largest(run["source.torque"] + 2 / 9 * np.sin(t)), 1e-9)
    drift = largest(run["gear.a.phi"] - 3 * run["load.phi"])
    yield below("tie drifts by", max(drift, largest(run["gear.a.phi"] - np.sin(t))), 1e-12)
    yield below("speed off by", largest(run["load.w"] - np.cos(t) / 3), 1e-12 * math.pi)
