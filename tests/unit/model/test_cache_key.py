"""What makes a model another one: the code of its blocks, their helpers and constants."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb


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
