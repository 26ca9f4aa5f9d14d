"""Flights on a stop that end as the slip of a clutch beside them does: no order of parts and connections changes the run."""

import sys
from pathlib import Path
from random import Random

import numpy as np
import pytest

import gearblocks as gb

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import build  # noqa: E402
from tests.random.families import draw  # noqa: E402
from tests.random.judge import deviations, motion_of  # noqa: E402
from tests.random.reference import reference_motion  # noqa: E402

T = np.linspace(0.0, 2.8, 57)


@pytest.fixture(scope="module")
def train():
    """A body that clatters in its gap against another one, which a clutch carries along; a slider that slips beside them."""
    return draw("mixed", 1900040)


@pytest.mark.parametrize("order", [0, 2, 5])
@pytest.mark.parametrize("changed", [{}, {"friction": 1.7}, {"stiffness": 30.0}])
@pytest.mark.few(1)
def test_flights_and_a_slip_that_end_at_once_do_so_in_any_order(train, order, changed):
    parameters = {f"shaft1.hysteresis.{name}": value for name, value in changed.items()}
    model = gb.build(build(train, gb, Random(order)))
    runs = [gb.simulate(model, t=T, method=method, rtol=1e-9, parameters=parameters) for method in ("dp5", "dp8")]
    given = gb.simulate(build(train, gb, None), t=T, method="rodas", rtol=1e-9, parameters=parameters)
    for run in runs:
        assert np.abs(run["j3.w"] - given["j3.w"]).max() < 1e-5
        assert [e.after for e in run.events if e.component.startswith("shaft1")] == [
            e.after for e in given.events if e.component.startswith("shaft1")
        ]
        assert run.energy.residual < 1e-8


@pytest.mark.long
def test_the_run_is_that_of_the_reference(train):
    run = gb.simulate(build(train, gb, Random(2)), t=T, method="dp8", rtol=1e-10)
    motion = motion_of(run, train)
    assert (
        deviations(
            motion, reference_motion(train, T, given=np.array([motion.angles[:, 0], motion.speeds[:, 0]])), T
        ).max()
        < 1e-5
    )
