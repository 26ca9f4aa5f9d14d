"""Arrows of torques and forces point the way that they begin; meshes of non-circular gears are told from round ones."""

from __future__ import annotations

import pytest

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.drawing.riders import _torque
from gearblocks.drawing.shapes import FILLED, Stroke
from gearblocks.language.signals import Signal

P = gb.Parameter("p", -3.0, "N m")


def _points_down(tau: Signal) -> bool:
    (head,) = (
        x for x in _torque(gb.Torque(tau=tau), False, True, False).shapes if isinstance(x, Stroke) and x.look == FILLED
    )
    return sum(y for _, y in head.points) > 0


@pytest.mark.parametrize(
    ("tau", "down"),
    [
        (5.0, True), (-5.0, False), (P, False), (-P, True), (P * (1 + 0.2 * gb.cos(30 * gb.time)), False),
        (gb.Input("tau", start=-2.0, unit="N m"), False), (gb.Table([0, 1], [0, -40]), False), (gb.sin(3 * gb.time), True),
        (-2 * gb.sense("motor.w"), True),
    ],
)  # fmt: skip
def test_a_torque_points_the_way_that_it_begins(tau: Signal, down: bool) -> None:
    assert _points_down(tau) == down


def test_planets_of_non_circular_gears_are_drawn_as_such() -> None:
    scheme = scripts.make("noncircular_planetary:rigid").draw().scheme
    (gearing,) = (e.gearing for e in scheme.elements if e.gearing is not None)
    assert gearing.noncircular == frozenset(gearing.meshes)
    (round_ones,) = (
        e.gearing for e in scripts.make("planetary_backlash").draw().scheme.elements if e.gearing is not None
    )
    assert not round_ones.noncircular
