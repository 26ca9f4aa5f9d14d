"""Drawn trains whose runs did not end, each by what no smaller train has shown so far.

mixed 15000348: a stop struck to rest beside a hysteresis that holds gave the lock a speed of rounding, which gave it
back to the stop,
at one instant for ever. contact 15000428: the force of a closed stop that nothing presses is rounding, on its limit; each step
was searched in 20,000 pieces. contact 24000362: a step was cut by less than it was stretched by to reach a knot of a table, and
tried again as it was, within one call. mixed 27000245: a table's corner at the twist of a shaft beside closed locks; rounding
of implicit steps drifts across it, and of each step 20,000 pieces were looked at. mixed 27000393: room that locks beside lossy
gears have left was told as none wherever the sides of a gear change as all bounds shrink. mixed 30000473: a body between two
one-way clutches and a stop; what was left of a flight opened both, one of them opened the stop as it closed, and so on, each
cycle a 118th of the one before down to the rounding of the gap, where they went on. mixed 34000051 ended, with 11 rtol missing
in the balance: in the 36 steps between two looks at it three times the goal was used up. mixed 40000253: a
differential at rest of which one side moves by rounding alone; what such a step adds to the balance, in parts of what there is,
goes by its length, and held it at 1e-10 s. mixed 45000052: three gears that lose nothing at rest beside locks hold each other;
how much more load they would hold came out as 9.4 or as up to 133, by rounding, and each step seemed too long to tell it.
"""

import contextlib
import sys
from pathlib import Path

import pytest

import gearblocks as gb

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import arguments, build  # noqa: E402
from tests.random.families import draw  # noqa: E402
from tests.random.judge import HangError, Judge, cpu_limit  # noqa: E402


@pytest.mark.parametrize(
    ("family", "seed"),
    [("mixed", 15000348), ("contact", 15000428), ("contact", 24000362), ("mixed", 27000245), ("mixed", 34000051)],
)
@pytest.mark.few(1)
def test_they_end_and_are_right(family, seed):
    verdict = Judge(gb, draw(family, seed)).judge(light=True)
    assert (verdict.kind, verdict.what) == ("right", ""), verdict
    assert "reference" in verdict.evidence


@pytest.mark.parametrize(
    ("seed", "method", "t_end", "steps", "rejected"),
    [
        (27000245, "rodas", 0.01, 55, 1),
        (27000393, "dp8", 0.05, 35, 10),
        (40000253, "dp5", 0.1, 60, 40),
        (45000052, "dp8", 0.5, 40, 5),
    ],
)
def test_they_take_the_steps_that_their_motion_asks_for(seed, method, t_end, steps, rejected):
    train = draw("mixed", seed)
    run = gb.simulate(build(train, gb), t_end=t_end, method=method, **arguments(train, gb))
    assert run.stats.steps <= steps and run.stats.rejected <= rejected


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, pytest.param(1e-10, marks=pytest.mark.long)])
def test_flights_that_end_between_one_way_clutches_and_a_stop_leave_all_of_them_closed(rtol, method):
    train = draw("mixed", 30000473)
    model, given = gb.build(build(train, gb)), arguments(train, gb)
    run = None
    with contextlib.suppress(HangError), cpu_limit(20.0):
        run = gb.simulate(model, t=[0.0, 1.3, 2.0], rtol=rtol, method=method, **given)
    assert run is not None, "it came to no end"
    fine = gb.simulate(model, t=[0.0, 1.3, 2.0], rtol=1e-11, method="dp8", **given)
    assert len(run.events) < 400
    for body in ("j4", "j5", "j6", "j8"):
        assert run[f"{body}.w"] == pytest.approx(fine[f"{body}.w"], abs=30 * rtol)
