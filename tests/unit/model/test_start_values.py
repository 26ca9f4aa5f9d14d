"""Start values: where relative and dependent angles begin, and what contradicts."""

import math
from collections.abc import Callable
from typing import Any

import pytest

import gearblocks as gb


def _inertia(**more: Any) -> gb.Inertia:
    return gb.Inertia(J=1.0, **more)


def _chain(*blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    rig.chain(*(rig.add(f"b{i}", block) for i, block in enumerate(blocks)))
    return rig


def _refused(act: Callable[[], Any], *words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        act()
    for word in words:
        assert word in str(caught.value), str(caught.value)


def test_start_values_that_contradict_are_refused_also_where_the_program_is_known_already() -> None:
    for ratio, w in ((1.0, 1.0), (2.0, 0.5)):
        gb.build(_chain(_inertia(w0=1.0), gb.IdealGear(ratio=ratio), _inertia(w0=w)))
        rig = _chain(_inertia(w0=1.0), gb.IdealGear(ratio=ratio), _inertia(w0=3.0))
        _refused(lambda rig=rig: gb.build(rig), "'b0': w0 = 1.0", "'b2': w0 = 3.0", "contradict")


def test_a_state_that_has_the_name_of_a_start_value_is_refused() -> None:
    """initial={"b0.w": ...} would mean either, and start speeds that contradict each other would go unseen."""

    class Fan(gb.Block):
        a = gb.Flange("shaft")
        J: float = gb.param("inertia", "kg m2", gt=0)
        w0: float | None = gb.param("start speed", "rad/s", default=None, start="speed")
        w = gb.State("speed of the air")

        def physics(self, s: Any) -> Any:
            yield gb.Body(s.a, s.J)
            yield gb.Rate(s.w, s.a.w - s.w)

    rig = gb.Drivetrain("fans")
    rig.connect(*(rig.add(f"b{i}", Fan(J=1.0, w0=1.0 + i)).a for i in range(2)))
    _refused(lambda: gb.build(rig), "'b0.w' names a state of this block and the start speed of its body", "rename")


X = math.radians(240)
LAW = gb.RatioLaw.segments(0.7 / X, 0.5, X)


@pytest.mark.long
@pytest.mark.parametrize("phase", [-6.0, -0.5, 0.0, 1.0, 5.0, 7.0, 20.0])
def test_a_shaft_behind_a_non_circular_pair_starts_unwound_on_any_piece_of_the_law(phase):
    rig = gb.Drivetrain("pair and shaft")
    pair, shaft = (
        rig.add("pair", gb.NonCircularGear(law=LAW, external=False, phase=phase)),
        rig.add("shaft", gb.Shaft(k=10.0)),
    )
    rig.connect(rig.add("source", gb.Speed(w=262.0)).flange, pair.a)
    rig.connect(pair.b, shaft.a)
    rig.connect(shaft.b, rig.add("body", gb.Inertia(J=1.0)).a)
    run = gb.simulate(rig, t_end=1e-6)
    assert run["shaft.twist"][0] == pytest.approx(0.0, abs=1e-14)  # F of angles up to 20 rad, right to their last digit


@pytest.mark.long
def test_a_relative_angle_starts_from_the_angle_of_a_geared_shaft():
    rig = gb.Drivetrain("geared clutch")
    one, two = rig.add("one", gb.Inertia(J=1.0, phi0=0.3, w0=1.0)), rig.add("two", gb.Inertia(J=1.0, phi0=0.1))
    gear, clutch = rig.add("gear", gb.IdealGear(ratio=2)), rig.add("clutch", gb.Clutch(capacity=1.0))
    rig.chain(one, gear, clutch, two)
    run = gb.simulate(rig, t_end=1e-3)
    assert run["clutch.phi_rel"][0] == pytest.approx(0.1 - 0.15, abs=1e-15)
