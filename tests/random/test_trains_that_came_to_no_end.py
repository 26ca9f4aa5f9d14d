"""Drawn trains whose runs did not end, each by what no smaller train has shown so far.

mixed 15000348: a stop struck to rest beside a hysteresis that holds gave the lock a speed of rounding, which gave it
back to the stop,
at one instant for ever. contact 15000428: the force of a closed stop that nothing presses is rounding, on its limit; each step
was searched in 20,000 pieces. contact 24000362: a step was cut by less than it was stretched by to reach a knot of a table, and
tried again as it was, within one call.
"""

import sys
from pathlib import Path

import pytest

import gearblocks as gb

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.families import draw  # noqa: E402
from tests.random.judge import Judge  # noqa: E402


@pytest.mark.parametrize(("family", "seed"), [("mixed", 15000348), ("contact", 15000428), ("contact", 24000362)])
@pytest.mark.few(1)
def test_they_end_and_are_right(family, seed):
    verdict = Judge(gb, draw(family, seed)).judge(light=True)
    assert (verdict.kind, verdict.what) == ("right", ""), verdict
    assert "reference" in verdict.evidence
