"""Small trains with effects whose part in a quantity is known."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

import gearblocks as gb


class Bias(gb.Effect):
    """A torque that is always there."""

    torque: float = gb.param("torque", "N m")


class Draught(gb.Block):
    """A user's block: a constant push on a shaft, an effect of its own."""

    flange = gb.Flange("shaft")
    bias: Bias | None = gb.effect("constant push", default=None)

    def physics(self, s: Any) -> Iterator[Any]:
        if self.bias is not None:
            yield gb.Acts(s.flange, s.bias.torque)
            yield gb.Shows("push", s.bias.torque, "N m")


def _discs() -> gb.Drivetrain:
    rig = gb.Drivetrain("two discs")
    motor, load = rig.add("motor", gb.Inertia(J=0.02)), rig.add("load", gb.Inertia(J=0.05))
    drive = rig.add("drive", gb.Torque(tau=gb.Parameter("drive", 5.0, "N m") + gb.sin(80 * gb.time)))
    rig.chain(drive, motor, rig.add("shaft", gb.Shaft(k=2e3, c=0.3)), load)
    bearing = gb.BearingFriction(viscous=0.02, windage=gb.FluidDrag(c=1e-5))
    rig.connect(rig.add("bearing", bearing).a, load.b)
    fan = rig.add("fan", gb.Speed(w=20 + gb.sin(9 * gb.time)))
    rig.chain(fan, rig.add("belt", gb.Shaft(k=900.0, c=0.1)), rig.add("blades", gb.Inertia(J=0.01, w0=20.0)))
    return rig


def _pushed(left: float = 0.5, right: float = -0.5) -> gb.Drivetrain:
    rig = gb.Drivetrain("pushed")
    disc = rig.add("disc", gb.Inertia(J=0.1))
    rig.chain(
        rig.add("drive", gb.Torque(tau=2.0)), disc, rig.add("brake", gb.Damper(c=0.05)), rig.add("wall", gb.Fixed())
    )
    for name, torque in (("left", left), ("right", right)):
        rig.connect(rig.add(name, Draught(bias=Bias(torque=torque))).flange, disc.b)
    return rig


def _hammer(amplitude: float = 0.5, **more: Any) -> gb.Drivetrain:
    """A disc that is shaken within a gap, far above its resonance: chaotic from 0.2 N m on."""
    rig = gb.Drivetrain("hammer")
    tau = 0.1 + gb.Parameter("amplitude", amplitude, "N m") * gb.cos(1.3 * gb.time) * more.get("until", 1.0)
    disc, wall = rig.add("disc", gb.Inertia(J=1.0)), rig.add("wall", gb.Fixed())
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), disc, rig.add("lash", gb.Lash(k=1.0, half_gap=1.0, c=0.1)), wall)
    return rig


@pytest.fixture
def discs() -> Callable[..., gb.Drivetrain]:
    """Two discs on a shaft, one in a bearing with drags, and a fan behind a prescribed speed."""
    return _discs


@pytest.fixture
def pushed() -> Callable[..., gb.Drivetrain]:
    """A disc that two draughts push."""
    return _pushed


@pytest.fixture
def hammer() -> Callable[..., gb.Drivetrain]:
    """Chaotic at an amplitude of 0.5 N m."""
    return _hammer


@pytest.fixture(scope="session")
def discs_scene() -> gb.Scene:
    asked = (gb.peak("shaft.torque"), gb.last("load.w"))
    return gb.Scene(_discs(), t_end=0.2, quantity=asked, within=0.02)


@pytest.fixture(scope="session")
def discs_price(discs_scene: gb.Scene) -> Any:
    return gb.price(discs_scene)


@pytest.fixture(scope="session")
def hammer_scene() -> gb.Scene:
    asked = (gb.rms("lash.torque", after=50), gb.mean("lash.torque", after=50))
    return gb.Scene(_hammer(), t_end=200, quantity=asked, within=0.05)
