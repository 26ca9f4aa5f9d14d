"""Trains that begin in static equilibrium under constant torques and stay there: what the rounding of balanced forces does to
speeds that are zero is no motion to resolve, with any method. Closed form: the twists are the torques over the stiffnesses."""

from __future__ import annotations

from collections.abc import Callable
from math import exp

import numpy as np
import pytest

import gearblocks as gb

METHODS = [("dp5", 1e-6), ("dp5", 1e-8), ("dp8", 1e-8), ("rodas", 1e-5), ("rodas", 1e-8), ("auto", 1e-6)]


def _chain(push: float = 6.55, pull: float = -59.4, segments: int = 3) -> tuple[gb.Drivetrain, dict[str, float]]:
    rig = gb.Drivetrain("chain")
    first, last = rig.add("j1", gb.Inertia(J=0.0823)), rig.add("j2", gb.Inertia(J=0.663))
    long = rig.add("long", gb.Shaft(k=16.9, c=0.0171, segments=segments, J=0.0514))
    held = rig.add("held", gb.Shaft(k=32.9, c=1.32))
    rig.connect(first.a, long.a, held.a)
    rig.connect(first.b, rig.add("push", gb.Torque(tau=push)).flange)
    rig.connect(last.a, long.b)
    rig.connect(last.b, rig.add("pull", gb.Torque(tau=pull)).flange)
    rig.connect(held.b, rig.add("ground", gb.Fixed()).flange)
    at_first = (push + pull) / 32.9
    return rig, {"j1.phi": at_first, "j2.phi": at_first + pull / 16.9}


def _lighter() -> tuple[gb.Drivetrain, dict[str, float]]:
    return _chain(-0.83, 7.1)


def _longer() -> tuple[gb.Drivetrain, dict[str, float]]:
    return _chain(-17.3, -41.0, segments=11)


def _opposed() -> tuple[gb.Drivetrain, dict[str, float]]:
    """Between two grounds: every body is held by forces that balance, none by a torque."""
    rig = gb.Drivetrain("opposed")
    left, right = rig.add("left", gb.Inertia(J=0.0047)), rig.add("right", gb.Inertia(J=0.19))
    near, far = rig.add("near", gb.Fixed()), rig.add("far", gb.Fixed())
    rig.chain(near, rig.add("soft", gb.Shaft(k=61.3, c=0.011)), left, rig.add("mid", gb.Shaft(k=61.3, c=0.07)), right)
    rig.chain(right, rig.add("stiff", gb.Shaft(k=122.6, c=0.004)), far)
    rig.connect(rig.add("push", gb.Torque(tau=29.0)).flange, left.a)
    rig.connect(rig.add("pull", gb.Torque(tau=-29.0 / 3.0)).flange, right.a)
    at_left, at_right = np.linalg.solve([[122.6, -61.3], [-61.3, 183.9]], [29.0, -29.0 / 3.0])
    return rig, {"left.phi": at_left, "right.phi": at_right}


def _branched() -> tuple[gb.Drivetrain, dict[str, float]]:
    rig = gb.Drivetrain("branched")
    trunk, left, right = (
        rig.add(name, gb.Inertia(J=J)) for name, J in (("trunk", 0.3), ("left", 0.02), ("right", 1.7))
    )
    rig.chain(rig.add("ground", gb.Fixed()), rig.add("root", gb.Shaft(k=210.0, c=0.01)), trunk)
    rig.chain(trunk, rig.add("to_left", gb.Shaft(k=33.0, c=0.002)), left, rig.add("twig", gb.Torque(tau=-8.3)))
    rig.chain(trunk, rig.add("to_right", gb.Shaft(k=570.0, c=0.1)), right, rig.add("bough", gb.Torque(tau=47.1)))
    at_trunk = (47.1 - 8.3) / 210.0
    return rig, {"trunk.phi": at_trunk, "left.phi": at_trunk - 8.3 / 33.0, "right.phi": at_trunk + 47.1 / 570.0}


def _geared() -> tuple[gb.Drivetrain, dict[str, float]]:
    rig = gb.Drivetrain("geared")
    drive, load = rig.add("drive", gb.Inertia(J=0.04)), rig.add("load", gb.Inertia(J=2.1))
    gear, side = rig.add("gear", gb.IdealGear(ratio=-3.7)), rig.add("side", gb.Inertia(J=0.11))
    soft, stiff = rig.add("soft", gb.Shaft(k=41.0, c=0.003)), rig.add("stiff", gb.Shaft(k=7300.0, c=0.02))
    rig.chain(drive, soft, side, gear, load, stiff, rig.add("ground", gb.Fixed()))
    rig.connect(rig.add("push", gb.Torque(tau=13.7)).flange, drive.a)
    at_load = -3.7 * 13.7 / 7300.0
    return rig, {"load.phi": at_load, "side.phi": -3.7 * at_load, "drive.phi": -3.7 * at_load + 13.7 / 41.0}


def _idle(push: float = -0.445, ratio: float = -31.0 / 23.0, k: float = 16.0) -> tuple[gb.Drivetrain, dict[str, float]]:
    """What is loaded carries branches that are not."""
    rig = gb.Drivetrain("idle")
    held, driven = rig.add("held", gb.Inertia(J=1.0)), rig.add("driven", gb.Inertia(J=1.0))
    side, tool, far = (rig.add(name, gb.Inertia(J=J)) for name, J in (("side", 0.376), ("tool", 0.107), ("far", 0.962)))
    rig.chain(held, rig.add("unloaded", gb.Shaft(k=15.0)), side)
    rig.chain(held, rig.add("gear", gb.IdealGear(ratio=ratio)), driven)
    rig.chain(held, rig.add("root", gb.Shaft(k=k, c=1.3)), rig.add("ground", gb.Fixed()))
    rig.chain(driven, rig.add("loaded", gb.Shaft(k=242.0, segments=3, J=0.0107)), tool)
    rig.chain(driven, rig.add("long", gb.Shaft(k=116.0, c=0.0314, segments=3, J=0.163)), far)
    rig.connect(tool.b, rig.add("push", gb.Torque(tau=push)).flange)
    at_held = push / ratio / k
    return rig, {"held.phi": at_held, "side.phi": at_held, "driven.phi": at_held / ratio, "far.phi": at_held / ratio}


def _idle_too() -> tuple[gb.Drivetrain, dict[str, float]]:
    return _idle(0.67, 1.9, 27.0)


@pytest.mark.parametrize("train", [_chain, _lighter, _longer, _opposed, _branched, _geared])
@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(2)
def test_it_stays_where_it_is(
    train: Callable[[], tuple[gb.Drivetrain, dict[str, float]]], method: str, rtol: float
) -> None:
    rig, right = train()
    run = gb.simulate(rig, t=np.linspace(0, 2, 5), initial="static", method=method, rtol=rtol)
    assert run.stats.steps < 2000
    for name, angle in right.items():
        assert run[name] == pytest.approx(angle, rel=1e-12), name


@pytest.mark.long
@pytest.mark.parametrize("train", [_idle, _idle_too])
@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-7, 1e-8])
def test_so_does_what_carries_unloaded_branches(
    train: Callable[[], tuple[gb.Drivetrain, dict[str, float]]], rtol: float
) -> None:
    """Rounding of what is loaded shakes them: an implicit method had made half a million steps a second of it."""
    rig, right = train()
    run = gb.simulate(rig, t=np.linspace(0, 3, 5), initial="static", method="rodas", rtol=rtol)
    assert run.stats.steps < 6000
    for name, angle in right.items():
        assert run[name] == pytest.approx(angle, rel=1e-12), name


@pytest.mark.long
@pytest.mark.parametrize(("pull", "target", "gain"), [(2.05, 17.8, 0.023), (1.1, 11.3, 0.07), (4.7, 21.9, 0.0131)])
@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-7, 1e-8])
def test_a_command_that_is_rounding_alone_holds_nothing_up(
    pull: float, target: float, gain: float, rtol: float
) -> None:
    """A governor whose command stays shut: what it balances to nothing jitters by more than its states' bits tell."""
    rig = gb.Drivetrain("shut")
    wheel, speed = rig.add("wheel", gb.Inertia(J=0.5, w0=26.8)), gb.sense("wheel.w")
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((pull * (53.4 - speed), speed < 53.4), (0.0, True))))
    governor = gb.Governor(target=target, gain=gain, integral_gain=0.104, time_constant=0.25)
    rig.connect(wheel.a, drive.flange, rig.add("governor", governor).flange)
    rig.connect(wheel.b, rig.add("more", gb.Torque(tau=2.9 * gb.sense("governor.command"))).flange)
    run = gb.simulate(rig, t=np.linspace(0, 3, 4), method="rodas", rtol=rtol)
    assert run.stats.steps < 3000
    assert run["wheel.w"] == pytest.approx([53.4 - 26.6 * exp(-2.0 * pull * t) for t in range(4)], rel=10 * rtol)
    assert run["governor.command"] == pytest.approx(np.zeros(4), abs=1e-13)
