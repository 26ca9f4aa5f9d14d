"""Conditions over signals that stay on their limits, drawn at random, hold for as long as plain Python says."""

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.logic import off  # noqa: E402

METHODS = ["dp5", "dp8", "rodas", "auto"]


@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(i, marks=pytest.mark.long) for i in range(8, 200))])
def test_conditions_hold_as_long_as_they_are_true(seed):
    assert off(seed, METHODS[seed % 4]) == []
