"""Drawn trains whose runs did not end, each by what no smaller train has shown so far.

mixed 15000348: a stop struck to rest beside a hysteresis that holds gave the lock a speed of rounding, which gave it
back to the stop,
at one instant for ever. contact 15000428: the force of a closed stop that nothing presses is rounding, on its limit; each step
was searched in 20,000 pieces. contact 24000362: a step was cut by less than it was stretched by to reach a knot of a table, and
tried again as it was, within one call. mixed 27000245: a table's corner at the twist of a shaft beside closed locks; rounding
of implicit steps drifts across it, and of each step 20,000 pieces were looked at. mixed 27000393: room that locks beside lossy
gears have left was told as none wherever the sides of a gear change as all bounds shrink.
"""

import sys
from pathlib import Path

import pytest

import gearblocks as gb

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import arguments, build  # noqa: E402
from tests.random.families import draw  # noqa: E402
from tests.random.judge import Judge  # noqa: E402


@pytest.mark.parametrize(
    ("family", "seed"), [("mixed", 15000348), ("contact", 15000428), ("contact", 24000362), ("mixed", 27000245)]
)
@pytest.mark.few(1)
def test_they_end_and_are_right(family, seed):
    verdict = Judge(gb, draw(family, seed)).judge(light=True)
    assert (verdict.kind, verdict.what) == ("right", ""), verdict
    assert "reference" in verdict.evidence


@pytest.mark.parametrize(
    ("seed", "method", "t_end", "steps", "rejected"),
    [(27000245, "rodas", 0.01, 55, 1), (27000393, "dp8", 0.05, 35, 10)],
)
def test_they_take_the_steps_that_their_motion_asks_for(seed, method, t_end, steps, rejected):
    train = draw("mixed", seed)
    run = gb.simulate(build(train, gb), t_end=t_end, method=method, **arguments(train, gb))
    assert run.stats.steps <= steps and run.stats.rejected <= rejected
