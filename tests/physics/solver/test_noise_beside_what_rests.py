"""Rounding that locks leave is no room for errors of implicit steps, whatever rests beside what moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

T = np.linspace(0.0, 3.0, 31)


def _alone(rig: gb.Drivetrain, width: float, J: float = 1.53) -> gb.Inertia:
    """0 to 1.2 N m across `width` rad/s about a set point that moves: a rate of 0.78 / width in 1/s."""
    target = 0.834 + 0.417 * gb.sin(4.0 * gb.time)
    line = gb.Torque(tau=sp.Max(0, sp.Min(1.2, 0.6 + 1.2 / width * (target - gb.sense("j.w")))))
    body = rig.add("j", gb.Inertia(J=J))
    rig.connect(rig.add("line", line).flange, body.a)
    return body


def _behind_a_clutch(rig: gb.Drivetrain, width: float) -> None:
    """Two bodies as one: the angle between them has never moved."""
    rig.chain(_alone(rig, width, 0.53), rig.add("clutch", gb.Clutch(capacity=3.21)), rig.add("k", gb.Inertia(J=1.0)))


def _beside_a_held_body(rig: gb.Drivetrain, width: float) -> None:
    _alone(rig, width)
    load = rig.add("load", gb.Torque(tau=5.0))
    rig.chain(load, rig.add("held", gb.Inertia(J=1.0)), rig.add("brake", gb.Brake(capacity=50.0)))


def _run(made: Callable[[gb.Drivetrain, float], object], width: float, rtol: float, method: str) -> np.ndarray:
    rig = gb.Drivetrain("line")
    made(rig, width)
    return gb.simulate(rig, t=T, rtol=rtol, method=method)["j.w"]


@pytest.mark.parametrize("made", [_behind_a_clutch, _beside_a_held_body])
@pytest.mark.parametrize(("width", "rtol"), [(1e-3, 1e-6), (1e-3, 1e-8), (1e-3, 1e-10), (1e-6, 1e-8), (1e-7, 1e-10)])
def test_a_steep_line_is_as_right_beside_what_rests_as_alone(
    made: Callable[[gb.Drivetrain, float], object], width: float, rtol: float
) -> None:
    """Its rates are fast: what they make of noise in a step that is much too long is no noise of the next trial."""
    off = np.abs(_run(made, width, rtol, "rodas") - _run(_alone, width, 1e-11, "dp5")).max()
    assert off < 4 * rtol, off / rtol
