"""Maps whose motions are known, one step in each period of the section: labels, multipliers and exponents beside their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

SECTION = gb.stroboscopic("drive")
Pair = tuple[Any, Any]

LAWS: dict[str, Callable[[Any, Any, Any], Pair]] = {
    "logistic": lambda r, x, y: (r * x * (1 - x), 0.1 * x),  # May 1976
    "Henon": lambda r, x, y: (1 - r * x**2 + y, 0.3 * x),  # 1976
    "delayed": lambda r, x, y: (r * x * (1 - y), x),  # Maynard Smith 1968: a torus from r = 2 on
}


class Map(gb.Block):
    """(x, y) -> law(r, x, y), once per period of the drive."""

    drive: float = gb.param("frequency", "rad/s")
    r: float = gb.param("number of the law")
    law: str = gb.option("name of the law")
    x = gb.State("first state", start=0.3)
    y = gb.State("second state", start=0.1)

    def physics(self, s: Any) -> Any:
        on = gb.piecewise((1, gb.sin(s.drive * s.time - 1) >= 0), (0, True))
        for state, value in zip((s.x, s.y), LAWS[self.law](s.r, s.x, s.y), strict=True):
            yield gb.Hold(state, value, on)
        yield gb.Shows("x", s.x)


def _train(law: str, r: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("map")
    rig.add("map", Map(drive=gb.Parameter("drive", 1.0, "rad/s"), r=r, law=law))
    return rig


def _known(law: str, r: float) -> tuple[int | None, float]:
    """The period of the map, None where it has none below 100, and its largest exponent."""
    step, z = LAWS[law], (0.3, 0.1)
    for _ in range(20000):
        z = step(r, *z)
    later, column, total, count = z, np.array([1.0, 0.3]), 0.0, 20000
    period = None
    for m in range(1, 100):
        later = step(r, *later)
        if max(abs(later[0] - z[0]), abs(later[1] - z[1])) < 1e-9:
            period = m
            break
    for _ in range(count):
        h = 1e-6
        ahead = [step(r, z[0] + s * h * column[0], z[1] + s * h * column[1]) for s in (1, -1)]
        column = np.array([ahead[0][0] - ahead[1][0], ahead[0][1] - ahead[1][1]]) / (2 * h)
        length = float(np.hypot(*column))
        total, column, z = total + np.log(length), column / length, step(r, *z)
    return period, total / count


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("law", "r", "label"),
    [
        ("logistic", 2.8, "period 1"),  # where it is set to what it is
        ("logistic", 2.999, "period 1"),  # next to its doubling: multiplier 2 - r
        ("logistic", 3.001, "period 2"),
        ("logistic", 3.2, "period 2"),
        ("logistic", 3.55, "period 8"),
        ("logistic", 3.83, "period 3"),  # the window that begins at 1 + sqrt(8) = 3.82843
        ("logistic", 3.828, "chaotic"),  # and irregular next to it: laminar for long, again and again
        ("logistic", 3.9, "chaotic"),
        ("Henon", 1.25, "period 7"),
        ("Henon", 1.4, "chaotic"),
        ("delayed", 1.99, "period 1"),
        ("delayed", 2.05, "quasi-periodic"),
        ("delayed", 2.27, "chaotic"),
    ],
)
def test_labels_are_those_of_the_map(law: str, r: float, label: str) -> None:
    period, exponent = _known(law, r)
    assert label == (f"period {period}" if period else "chaotic" if exponent > 0.01 else "quasi-periodic")
    found = gb.classify(_train(law, r), SECTION)
    assert found.label == label, found.evidence
    if label == "chaotic":
        assert found.exponents is not None
        assert abs(found.exponents.per_period[0] - exponent) < 4 * found.exponents.errors_per_period[0]
    elif period:
        assert found.orbit is not None
        assert np.log(abs(found.orbit.multipliers[0])) / period == pytest.approx(exponent, abs=1e-3)
