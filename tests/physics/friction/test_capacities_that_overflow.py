"""Peaks so high that the torque at which a friction breaks away is no number: a lock that holds whatever comes, after an
impact, against the closed form. Its force has no bounds to enclose, and no step may look for them without end."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

LARGEST = float(np.finfo(float).max)
J, J_LOAD, W0, TAU, RATE = 1.0, 2.0, 10.0, 10.0, 31.0


def _held(pressed: bool, loaded: bool) -> gb.Model:
    """An inertia under a waving torque, and what holds it: to a load or to the ground."""
    rig = gb.Drivetrain("overflow")
    given = {"mu": 0.5, "force_max": 20.0, "engagement": gb.cos(1.2 * gb.time)} if pressed else {"capacity": 10.0}
    friction = gb.Clutch if loaded else gb.Brake
    holds = rig.add("friction", friction(peak=LARGEST, **given))
    drive, turns = (
        rig.add("drive", gb.Torque(tau=TAU * gb.sin(RATE * gb.time))),
        rig.add("turns", gb.Inertia(J=J, w0=W0)),
    )
    rig.chain(drive, turns, holds, *([rig.add("load", gb.Inertia(J=J_LOAD))] if loaded else []))
    return gb.build(rig)


@pytest.mark.parametrize("pressed", [True, False])
@pytest.mark.parametrize("loaded", [True, False])
@pytest.mark.few(1)
def test_an_unbounded_capacity_holds_like_a_lock(pressed: bool, loaded: bool) -> None:
    run = gb.simulate(_held(pressed, loaded), t_end=1.0, rtol=1e-8)
    t = np.asarray(run.t)
    together = J + J_LOAD
    right = (J * W0 + TAU / RATE * (1 - np.cos(RATE * t))) / together if loaded else np.zeros_like(t)
    assert np.abs(run["turns.w"] - right)[t > 0].max() <= 1e-7 * W0
    assert [event.kind for event in run.events] == ["impact"]
