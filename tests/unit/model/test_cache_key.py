"""What makes a model another one: the code of its blocks, their helpers and constants."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.train.structure import structure_of


def _written(torque: str, **scope: Any) -> type:
    """A class as a notebook cell makes it, without a source file."""
    scope |= {"gb": gb}
    text = "class Cell(gb.Block):\n f = gb.Flange('f')\n def physics(self, s):\n"
    exec(text + f"  yield gb.Acts(s.f, {torque})\n", scope)  # noqa: S102  as a notebook does
    made = scope["Cell"]
    assert isinstance(made, type)
    return made


def _end_speed(kind: type) -> float:
    rig = gb.Drivetrain("cell")
    rig.chain(rig.add("motor", kind()), rig.add("wheel", gb.Inertia(J=1.0)))
    return float(gb.simulate(rig, t_end=1.0)["wheel.w"][-1])


def _constant(value: float) -> Callable[[], float]:
    return lambda: value


def test_a_class_written_again_with_other_code_helpers_or_constants_is_not_taken_from_the_cache() -> None:
    class Helper:
        pass

    def one() -> float:
        return 5.0

    def other() -> float:
        return 6.0

    cases = [
        ("1.0", {}, 1.0), ("2.0", {}, 2.0), ("K", {"K": 3.0}, 3.0), ("K", {"K": 4.0}, 4.0),
        ("K[0]", {"K": (3.5,)}, 3.5), ("K[0]", {"K": (4.5,)}, 4.5), ("h()", {"h": one}, 5.0), ("h()", {"h": other}, 6.0),
        ("h()", {"h": _constant(7.0)}, 7.0), ("h()", {"h": _constant(8.0)}, 8.0),
        ("float(K[0])", {"K": np.array([9.0, 1.0])}, 9.0), ("float(K[0])", {"K": np.array([10.0, 1.0])}, 10.0),
        ("H.k()", {"H": type("H", (Helper,), {"k": staticmethod(one)})}, 5.0),
        ("H.k()", {"H": type("H", (Helper,), {"k": staticmethod(other)})}, 6.0),
    ]  # fmt: skip
    for torque, scope, speed in cases:
        assert _end_speed(_written(torque, **scope)) == pytest.approx(speed, rel=1e-12)  # constant torque


class Law(gb.Block):
    """A torque by a function, and the mean of a row."""

    flange = gb.Flange("shaft")
    of: Any = gb.option("torque over speed", default=None)
    row: Any = gb.option("a row", default=None)

    def physics(self, s: Any) -> Any:
        yield gb.Acts(s.flange, float(self.row[1000]) if self.row is not None else self.of(s.flange.w))


def _against(n: float) -> Callable[[Any], Any]:
    return lambda w: -(w**n)


def _row_of(*laws: Law) -> list[float]:
    rig = gb.Drivetrain("laws")
    for i, law in enumerate(laws):
        rig.connect(rig.add(f"body{i}", gb.Inertia(J=1.0, w0=1.0)).a, rig.add(f"law{i}", law).flange)
    run = gb.simulate(rig, t_end=1.0, rtol=1e-9)
    return [float(run[f"body{i}.w"][-1]) for i in range(len(laws))]


def test_functions_and_long_arrays_in_an_option_are_told_apart_by_what_they_hold() -> None:
    """Their names hold an address, which another function has later, or a few of the numbers."""
    keys = {structure_of(Law(of=_against(n))) for n in (1, 2, 1)}
    assert len(keys) == 2
    assert not any("0x" in str(key) for key in keys)
    row = np.zeros((3, 2001))
    row[1:, 1000] = 1.0, 2.0
    assert _row_of(*(Law(row=x) for x in row)) == pytest.approx([1.0, 2.0, 3.0])


def test_the_unit_of_a_parameter_in_an_expression_is_no_matter_of_what_was_built_before() -> None:
    for unit, factor in (("N m", 1.0), ("kN m", 1000.0)):
        rig = gb.Drivetrain("unit")
        torque = rig.add("torque", gb.Torque(tau=2 * gb.Parameter("size", 1.0, unit=unit)))
        rig.chain(torque, rig.add("body", gb.Inertia(J=1.0)))
        run = gb.simulate(rig, t_end=1.0, parameters={"size": 3.0})
        assert run["body.w"][-1] == pytest.approx(6.0 * factor, rel=1e-9)


def test_an_inertia_whose_expression_is_zero_is_not_there_whatever_was_built_before() -> None:
    for J in (1.0, 0.0):
        rig = gb.Drivetrain("zero")
        body = rig.add("body", gb.Inertia(J=2 * gb.Parameter("J", J, unit="kg m2")))
        spring = rig.add("spring", gb.Shaft(k=10.0, c=0.3))
        rig.chain(rig.add("torque", gb.Torque(tau=1.0)), body, spring, rig.add("wall", gb.Fixed()))
        run = gb.simulate(rig, t_end=2.0)
    assert run["body.phi"][-1] == pytest.approx(0.1, rel=1e-6)


def test_the_class_of_an_effect_in_an_effect_counts() -> None:
    speeds = []
    for sign in (-1, -2):
        scope: dict[str, Any] = {"gb": gb}
        text = f"""
class Inner(gb.Effect):
    c = gb.param("damping", "N m s/rad", ge=0)
    def torque(self, s, w):
        return {sign} * s.c * w
class Outer(gb.Effect):
    inner: Inner | None = gb.effect("drag")
class Drag(gb.Block):
    flange = gb.Flange("shaft")
    outer: Outer | None = gb.effect("drag")
    def physics(self, s):
        yield gb.Acts(s.flange, self.outer.inner.torque(s.outer.inner, s.flange.w))
"""
        exec(text, scope)  # noqa: S102  as a notebook does
        speeds += _row_of(scope["Drag"](outer=scope["Outer"](inner=scope["Inner"](c=1.0))))
    assert speeds == pytest.approx([np.exp(-1), np.exp(-2)], rel=1e-6)
