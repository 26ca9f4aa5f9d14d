"""Classes of blocks: what is declared wrongly is refused where it is written, and no block changes."""

import re
from collections.abc import Callable, Iterator
from typing import Any

import pytest

import gearblocks as gb

NAN, INF = float("nan"), float("inf")


def test_a_block_cannot_be_changed_and_says_what_to_do() -> None:
    block = gb.Inertia(J=1.0)
    with pytest.raises(AttributeError, match=re.escape("rig.set({'path.J': value})")):
        block.J = 2.0  # type: ignore[misc]


def _field_without_call() -> type:
    class Motor(gb.Block):
        shaft = gb.Flange

        def physics(self, s: Any) -> Iterator[Any]:
            yield gb.Acts(s.shaft, 1.0)

    return Motor  # fmt: skip


def _field_with_a_taken_name() -> type:
    class Motor(gb.Block):
        time = gb.param("start", "s")

        def physics(self, s: Any) -> Iterator[Any]:
            yield gb.Shows("x", s.time)

    return Motor  # fmt: skip


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_field_without_call, "Motor.shaft: write gb.Flange"),
        (_field_with_a_taken_name, "cannot be named 'time'"),
        (lambda: gb.State("current", "A", NAN), "State 'current': start = nan"),
    ],
)
def test_a_class_that_declares_nonsense_is_refused_where_it_is_written(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(gb.GearblocksError, match=words):
        make()


def _written(torque: str, **scope: Any) -> type:
    """A class as a notebook cell makes it, without a source file."""
    scope |= {"gb": gb}
    text = "class Cell(gb.Block):\n f = gb.Flange('f')\n def physics(self, s):\n"
    exec(text + f"  yield gb.Acts(s.f, {torque})\n", scope)  # noqa: S102  as a notebook does
    made = scope["Cell"]
    assert isinstance(made, type)
    return made


def test_two_classes_of_one_name_in_a_train_are_refused() -> None:
    rig = gb.Drivetrain("cell")
    parts = [rig.add(f"m{i}", _written(f"{i}.0")()) for i in range(2)]
    rig.chain(*parts, rig.add("wheel", gb.Inertia(J=1.0)))
    with pytest.raises(gb.ModelError, match="two classes of blocks are named Cell"):
        gb.build(rig)


class _Drag(gb.Effect):
    c: float = gb.param("damping", "N m s/rad", ge=0)


class _Bearing(gb.Block):
    """A body with a drag that is there unless it is left out."""

    a = gb.Flange("shaft", spare=True)
    drag: _Drag | None = gb.effect("drag", default=_Drag(c=0.1))

    def physics(self, s: Any) -> Iterator[Any]:
        yield gb.Body(s.a, 1.0)
        if self.drag is not None:
            yield gb.Acts(s.a, -s.drag.c * s.a.w)


def test_an_effect_that_is_there_by_default_is_one_that_can_be_left_out() -> None:
    rig = gb.Drivetrain("rig")
    rig.add("bearing", _Bearing())
    assert rig.effects() == {"bearing.drag": _Drag(c=0.1)}
    free = rig.without("bearing.drag")
    assert free["bearing"].part == _Bearing(drag=None) and not free.effects()
    assert gb.simulate(rig, t_end=1.0, initial={"bearing.w": 1.0})["bearing.a.w"][-1] < 0.95
    assert gb.simulate(free, t_end=1.0, initial={"bearing.w": 1.0})["bearing.a.w"][-1] == 1.0
