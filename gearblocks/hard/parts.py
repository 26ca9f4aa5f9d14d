"""Small trains that several cases are made of."""

from __future__ import annotations

from typing import Any

import gearblocks as gb


def swing(name: str, spring: gb.Block, *, J: float = 1.0, tau: Any = None, **start: Any) -> gb.Drivetrain:
    """'body' held to the ground by 'spring', driven by the torque tau; start: phi0 [rad], w0 [rad/s]."""
    rig = gb.Drivetrain(name)
    body = rig.add("body", gb.Inertia(J=J, **start))
    if tau is not None:
        rig.connect(rig.add("torque", gb.Torque(tau=tau)).flange, body.a)
    rig.chain(body, rig.add("spring", spring), rig.add("wall", gb.Fixed()))
    return rig


def driven(name: str, *loads: tuple[str, gb.Block], J: float = 1.0, tau: Any = None, **start: Any) -> gb.Drivetrain:
    """'body' with one-flange blocks on its flange a, driven by the torque tau; start: phi0 [rad], w0 [rad/s]."""
    rig = gb.Drivetrain(name)
    body = rig.add("body", gb.Inertia(J=J, **start))
    if tau is not None:
        rig.connect(rig.add("torque", gb.Torque(tau=tau)).flange, body.a)
    for part, block in loads:
        rig.add(part, block)
        rig.connect(rig[part].a, body.a)
    return rig


def line(name: str, *parts: tuple[str, gb.Block]) -> gb.Drivetrain:
    """Blocks in a row, each joined to the next."""
    rig = gb.Drivetrain(name)
    rig.chain(*(rig.add(part, block) for part, block in parts))
    return rig
