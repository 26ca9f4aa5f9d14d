"""Ratio laws of every form."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

TURN = 2 * np.pi
X = np.deg2rad(240)
PHI = sp.Symbol("phi")
TABLE = np.linspace(0, TURN, 121)
LAWS = {
    "segments": gb.RatioLaw.segments(0.7 / X, 0.5, X),
    "two lobes": gb.RatioLaw.segments(0.2, 0.4, 1.5, T=TURN / 2, G=TURN / 3),
    "ellipse": gb.RatioLaw.ellipse(0.4632),
    "three lobes": gb.RatioLaw.ellipse(0.3, order=3),
    "waves": gb.RatioLaw.from_function(1 + 0.3 * sp.cos(PHI) + 0.2 * sp.sin(2 * PHI) * sp.cos(3 * PHI)),
    "fitted": gb.RatioLaw.from_function(1 / (1 + 0.2 * gb.cos(gb.driver_angle)), normalise=True),
    "table": gb.RatioLaw.from_table(TABLE, 1 + 0.3 * np.cos(TABLE).round(14), normalise=True),
}


@pytest.fixture(scope="session")
def ratio_laws() -> dict[str, gb.RatioLaw]:
    """All of them by name."""
    return LAWS


@pytest.fixture(scope="session", params=LAWS.values(), ids=LAWS.keys())
def law(request: pytest.FixtureRequest) -> gb.RatioLaw:
    """Each of them."""
    return request.param
