"""Angles without inertia that dampers or friction hold have a memory: a run that goes on does not begin at their rest."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

TAU = gb.cos(gb.time) + 0.2


def _disc(*, J: float = 1.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("held")
    rig.chain(rig.add("source", gb.Torque(tau=TAU)), rig.add("disc", gb.Inertia(J=J, w0=0.4)))
    return rig


def _to_ground(rig: gb.Drivetrain, *parts: tuple[str, Any]) -> gb.Drivetrain:
    rig.chain(rig["disc"], *(rig.add(*part) for part in parts), rig.add("ground", gb.Fixed()))
    return rig


def _damped() -> gb.Drivetrain:
    return _to_ground(_disc(), ("near", gb.Shaft(k=3.0, c=0.5)), ("far", gb.Shaft(k=2.0)))


def _maxwell() -> gb.Drivetrain:
    return _to_ground(_disc(), ("far", gb.Damper(c=0.8)), ("near", gb.Shaft(k=3.0)))


def _two_nodes() -> gb.Drivetrain:
    return _to_ground(
        _disc(), ("near", gb.Shaft(k=3.0, c=0.5)), ("middle", gb.Shaft(k=4.0)), ("far", gb.Shaft(k=2.0, c=0.1))
    )


def _geared() -> gb.Drivetrain:
    return _to_ground(
        _disc(), ("near", gb.Shaft(k=3.0, c=0.5)), ("gear", gb.IdealGear(ratio=2.0)), ("far", gb.Shaft(k=2.0))
    )


def _side_by_side() -> gb.Drivetrain:
    rig = _damped()
    rig.chain(rig["disc"], rig.add("beside", gb.Shaft(k=1.0, c=0.3)), rig.add("behind", gb.Shaft(k=1.5)), rig["ground"])
    return rig


def _braked() -> gb.Drivetrain:
    rig = _damped()
    rig.connect(rig.add("brake", gb.Brake(capacity=0.4)).a, rig["near"].b)
    return rig


def _borne() -> gb.Drivetrain:
    rig = _geared()
    rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=0.3)).a, rig["gear"].b)
    return rig


def _clutched() -> gb.Drivetrain:
    return _to_ground(_disc(), ("clutch", gb.Clutch(capacity=0.5)), ("near", gb.Shaft(k=3.0, c=0.2)))


@pytest.mark.few(1)
@pytest.mark.parametrize("made", [_damped, _braked, _maxwell, _two_nodes, _geared, _side_by_side, _borne, _clutched])
def test_a_run_that_goes_on_is_the_run_in_one_piece(made: Callable[[], gb.Drivetrain]) -> None:
    model = gb.build(made())
    at = [2.0, 4.7, 9.0]
    whole = gb.simulate(model, t=at, rtol=1e-10)
    parts = gb.simulate(model, t=at[:1], rtol=1e-10)
    for until in (1, 2):
        parts = gb.simulate(model, t=at[until - 1 : until + 1], rtol=1e-10, initial=parts)
        for name in ("disc.phi", "disc.w", "near.twist"):
            assert np.abs(parts[name] - whole[name][until - 1 : until + 1]).max() < 1e-7, (name, until)


def test_a_start_at_rest_finds_what_is_not_given_in_balance() -> None:
    run = gb.simulate(_damped().set({"disc.phi0": 0.5}), t=[0.0], rtol=1e-9)
    assert run["near.twist"][0] * 3.0 == pytest.approx(run["far.twist"][0] * 2.0, rel=1e-12)
    assert abs(run["near.twist"][0] + run["far.twist"][0]) == pytest.approx(0.5, rel=1e-12)
