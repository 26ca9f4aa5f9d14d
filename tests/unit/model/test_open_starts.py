"""Start speeds that nothing gives, as `describe` lists them."""

from typing import Any

import gearblocks as gb

LINE = "start speeds that nothing gives, 0 unless ties say otherwise: "


def _told(*parts: Any) -> list[str]:
    rig = gb.Drivetrain("driven")
    rig.chain(*(rig.add(f"b{i}", part) for i, part in enumerate(parts)))
    return [line.removeprefix(LINE) for line in rig.describe().splitlines() if line.startswith(LINE)]


def _shaft() -> gb.Shaft:
    return gb.Shaft(k=1e3, c=1.0)


def test_a_body_beside_one_that_turns_is_listed() -> None:
    assert _told(gb.Inertia(J=1.0, w0=5.0), _shaft(), gb.Inertia(J=1.0)) == ["b2"]
    assert _told(gb.Inertia(J=1.0), _shaft(), gb.Inertia(J=1.0, w0=5.0), _shaft(), gb.Inertia(J=1.0)) == ["b0, b4"]


def test_nothing_is_said_where_all_speeds_are_given_or_none() -> None:
    assert _told(gb.Inertia(J=1.0), _shaft(), gb.Inertia(J=1.0)) == []
    assert _told(gb.Inertia(J=1.0, w0=5.0), _shaft(), gb.Inertia(J=1.0, w0=4.0)) == []
    assert _told(gb.Inertia(J=1.0, w0=5.0), _shaft(), gb.Inertia(J=1.0, w0=0.0)) == []  # at rest, as was said


def test_a_speed_that_a_gear_or_the_ground_gives_is_not_open() -> None:
    assert _told(gb.Inertia(J=1.0, w0=5.0), gb.IdealGear(ratio=2.0), gb.Inertia(J=1.0)) == []
    assert _told(
        gb.Inertia(J=1.0, w0=5.0), gb.IdealGear(ratio=2.0), gb.Inertia(J=1.0), _shaft(), gb.Inertia(J=1.0)
    ) == ["b4"]
    assert _told(gb.Inertia(J=1.0, w0=5.0), _shaft(), gb.Fixed()) == []


def test_of_many_the_first_are_named_and_the_rest_counted() -> None:
    more = [part for _ in range(15) for part in (_shaft(), gb.Inertia(J=1.0))]
    names = ", ".join(f"b{2 * i}" for i in range(1, 13))
    assert _told(gb.Inertia(J=1.0, w0=5.0), *more) == [f"{names} and 3 more"]
