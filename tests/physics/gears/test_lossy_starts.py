"""Start speeds that follow through lossy gears behind a gain that varies, as far as a planetary set that leaves one speed open.

Closed forms: the gain of a pair of ellipses at angle 0, (1 + e)/(1 - e) of any order, that of a joint, 1/cos of its angle, and
Willis for the set.
"""

from math import cos

import pytest

import gearblocks as gb

ELLIPSES = gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.589, order=2), external=False)
ROUND = gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.225, order=1), external=True)
JOINT = gb.UniversalJoint(angle=0.4)
PAIRS = {"ellipses": (ELLIPSES, 1.589 / 0.411), "external": (ROUND, -1.225 / 0.775), "joint": (JOINT, 1.0 / cos(0.4))}
SET = 1.5  # w_sun + 1.5 w_ring = 2.5 w_carrier


@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.parametrize(("at", "given"), [("sun", "ring"), ("ring", "carrier"), ("carrier", "sun")])
@pytest.mark.few(1)
def test_speeds_follow_as_far_as_a_planetary_set(pair, at, given):
    """One flange of the set is behind the gears, another one has its speed given, the third is open."""
    block, gain = PAIRS[pair]
    rig = gb.Drivetrain("starts")
    first, second, third = (rig.add(f"j{i}", gb.Inertia(J=0.1 * i, w0=-2.0 if i == 1 else None)) for i in (1, 2, 3))
    members = {n: rig.add(n, gb.Inertia(J=0.2, w0=-5.11 if n == given else None)) for n in ("sun", "ring", "carrier")}
    one = rig.add("one", gb.LossyGear(ratio=-0.5, efficiency=(0.9, 0.9)))
    two = rig.add("two", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8), bearing=(0.1, 0.1)))
    rig.chain(first, rig.add("pair", block), second, one, third, two, members[at])
    planetary = rig.add("set", gb.IdealPlanetary(ratio=SET))
    for name, member in members.items():
        rig.connect(getattr(planetary, name), member.b)
    run = gb.simulate(rig, t_end=1e-3)
    w = {"j1": -2.0, "j2": -2.0 * gain, "j3": 4.0 * gain, at: 2.0 * gain, given: -5.11}
    known = SET * w.get("ring", 0.0) + w.get("sun", 0.0) - (1.0 + SET) * w.get("carrier", 0.0)
    factor = {"sun": 1.0, "ring": SET, "carrier": -1.0 - SET}
    w.update({n: -known / factor[n] for n in members if n not in w})
    for name, speed in w.items():
        assert run[f"{name}.w"][0] == pytest.approx(speed, rel=1e-12), name
