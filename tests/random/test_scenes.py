"""What price and fit say of some random scenes, against direct runs."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2]))  # `pytest` alone does not put the root there

from tests.random.scenes import complaints


# 10: two seconds; 1: pairs that matter together; 2, 5: several meshes and gaps; 13: counters of runs of 50 ms;
# 7108: two tolerances that agree by chance; 7122: a method that uses up all that the change leaves
@pytest.mark.long
@pytest.mark.parametrize(
    "seed", [10, *(pytest.param(seed, marks=pytest.mark.long) for seed in (1, 2, 5, 13, 7108, 7122))]
)
def test_every_sentence_is_as_direct_runs_say(seed: int) -> None:
    assert not list(complaints(seed))
