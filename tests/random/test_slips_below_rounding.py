"""A train that the campaign found, gears of which let go so softly that their slip is rounding of the speeds for a while: what
its samples scatter by tells nothing of what it does between them, and shortens no step. Its parts cannot be fewer: what lets go
when hangs on all of them."""

import sys
from pathlib import Path

import pytest

import gearblocks as gb

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import arguments, build  # noqa: E402
from tests.random.families import draw  # noqa: E402
from tests.random.judge import HangError, cpu_limit  # noqa: E402


def test_slips_below_the_rounding_of_speeds_shorten_no_step():
    train = draw("mixed", 9950123)
    model = gb.build(build(train, gb))
    try:
        with cpu_limit(20.0):  # it took minutes; here 2 s
            run = gb.simulate(model, t_end=0.05, method="dp5", rtol=1e-8, **arguments(train, gb))
    except HangError:
        pytest.fail("steps of 1e-13 s")
    assert run.stats.steps < 200
