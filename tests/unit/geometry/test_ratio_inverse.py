"""The ratio law of a pair seen from gear 2: F^-1 to rounding, for every way a law is made."""

import numpy as np
import pytest

import gearblocks as gb

PHI = np.linspace(-7.0, 15.0, 1001)
LAWS = {
    "ellipse": gb.RatioLaw.ellipse(0.4632),
    "lobes": gb.RatioLaw.ellipse(0.3, 2),
    "segments": gb.RatioLaw.segments(0.7 / np.radians(240), 0.5, np.radians(240)),
    "two turns": gb.RatioLaw.segments(0.1, 0.4, 1.5, np.pi, np.pi / 2),
    "waves": gb.RatioLaw.from_function(1 + 0.3 * gb.sin(gb.driver_angle) + 0.1 * gb.cos(2 * gb.driver_angle)),
    "fitted": gb.RatioLaw.from_function(1 / (1 + 0.4 * gb.cos(gb.driver_angle)), normalise=True),
    "points": gb.RatioLaw.from_table(
        np.linspace(0, 2 * np.pi, 9), [1, 1.2, 1.3, 1.1, 0.9, 0.8, 0.7, 0.8, 1], normalise=True
    ),
}


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.few(1)
def test_the_inverted_law_undoes_the_law_over_all_turns(name):
    law, inverse = LAWS[name], LAWS[name].inverted
    assert (inverse.n1, inverse.n2) == (law.n2, law.n1)
    assert np.abs(inverse.F(law.F(PHI)) - PHI).max() < 1e-12
    assert np.abs(inverse.m(law.F(PHI)) * law.m(PHI) - 1).max() < 1e-11
    assert np.abs(inverse.inverted.F(PHI) - law.F(PHI)).max() < 1e-12


def test_the_joints_of_a_law_are_joints_of_its_inverse():
    law = LAWS["segments"]
    joints = law.inverted.curve.x
    for y in law.F(law.curve.x):
        assert np.abs(joints - y).min() < 1e-14
    assert law.inverted.curve.joints
    assert not LAWS["waves"].inverted.curve.joints
