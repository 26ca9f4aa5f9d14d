"""The family of relays: its lines in place of jumps, and trains that came to no end or to a wrong one."""

import sys
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import Part, Train, build  # noqa: E402
from tests.random.expressions import TIME, either, sense  # noqa: E402
from tests.random.families import draw  # noqa: E402
from tests.random.families.positioner import widened  # noqa: E402
from tests.random.judge import Judge  # noqa: E402
from tests.random.limit import samples_that_switches_pass  # noqa: E402


def test_lines_stand_in_place_of_the_jumps_of_relays_alone():
    target = either(1.0, TIME < 2.0, 3.0)
    relay = Part("relay1", "Torque", (("tau", either(2.0, sense("j.w") < target, -1.0)),), (("flange", "j"),))
    other = Part("torque1", "Torque", (("tau", either(1.0, TIME < 1.0, 0.0)),), (("flange", "j"),))
    wheel = Part("j", "Inertia", (("J", 1.0),), (("a", "j"),))
    wide = widened(Train("positioner", 0, (wheel, relay, other), 3.0), 1e-2)
    assert wide.parts[0] == wheel and wide.parts[2] == other
    run = gb.simulate(build(wide, gb), t=[0.1, 0.9, 2.9])
    assert run["relay1.torque"] == pytest.approx([2.0, -1.0, 2.0], abs=0.05)  # against 1 N m at 0.9 s
    assert np.abs(run["j.w"][1] - 1.0) < 1e-2


@pytest.mark.parametrize(
    "seed", [36, 41, 44, *(pytest.param(s, marks=pytest.mark.long) for s in (39, 40, 42, 43, 45, 47, 2037, 2075))]
)
def test_relays_that_were_wrong_stopped_or_came_to_no_end(seed):
    """36 rested beside a set point that had gone on, 41 and 45 stopped as theirs jumped, 44 swung about one that moved; the
    others have lossy gears."""
    verdict = Judge(gb, draw("positioner", seed)).judge(light=True)
    assert (verdict.kind, verdict.evidence) == ("right", ["limit"]), verdict


def test_a_sample_that_a_switch_passes_on_the_way_to_the_limit_is_not_compared():
    """In runs at 1.02 and 1.01 s, in the limit at 1 s: a sample at 1.005 s is beyond it in none of them."""
    t = np.array([0.0, 0.9, 1.005, 1.015, 1.2, 2.0])
    one, other = [("relay", 1.02), ("brake", 1.9)], [("relay", 1.01), ("brake", 1.9)]
    assert samples_that_switches_pass(one, other, t) == pytest.approx([1.005, 1.015])
    assert samples_that_switches_pass(one, [*other, ("relay", 1.99)], t) == pytest.approx([1.005, 1.015, 2.0])


def test_a_run_that_is_half_a_percent_off_is_wrong_beside_the_limit_of_steep_lines():
    """Whatever tolerances the other runs have."""
    judge = Judge(gb, draw("positioner", 44))
    model = gb.build(build(judge.train, gb))
    for name, rtol in (("default", 1e-6), ("fine", 1e-9)):
        judge._run(name, model, method="auto", rtol=rtol)
    run = next(motion for text, (_, motion) in judge.runs.items() if text.startswith("default"))
    run.speeds[:] *= 1.005
    judge._against_limit()
    assert judge.verdict.kind == "wrong" and "limit" in judge.verdict.message, judge.verdict
