"""Ratio laws: their derivatives, turns and inverses, and which are refused."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

pytestmark = pytest.mark.numeric

TURN = 2 * np.pi
X = np.deg2rad(240)
PHI = sp.Symbol("phi")
TABLE = np.linspace(0, TURN, 121)


def test_each_derivative_is_the_slope_of_the_one_before(ratio_laws, law):
    phi, h = np.linspace(-3, 9, 500), 1e-5
    if law is ratio_laws["table"]:  # m'' is a chain of lines: the difference must not reach over a point
        phi = phi[np.abs((phi / TABLE[1]) % 1 - 0.5) < 0.4]
    near_joint = np.zeros_like(phi, dtype=bool)
    if law.recipe[0] == "segments":
        rest = phi % law.period
        near_joint = (np.abs(rest - law.curve.x[:, None]) < 2 * h).any(axis=0)
    for value, slope in ((law.F, law.m), (law.m, law.dm), (law.dm, lambda x: law.dm(x, 2))):
        difference = (value(phi + h) - value(phi - h)) / (2 * h)
        error = np.abs(difference - slope(phi))[~near_joint]
        assert error.max() < 1e-7 * max(1.0, np.abs(slope(phi)).max())  # h^2/6 of the third derivative, and eps/h


def test_gear_2_gains_its_share_of_a_turn_in_a_period(law):
    phi = np.linspace(-5, 5, 101)
    assert np.abs(law.F(phi + law.period) - law.F(phi) - law.gain).max() < 1e-14 * 20
    assert law.F(0.0) == pytest.approx(0.0, abs=1e-15)
    assert law.n1 * law.gain / (law.n2 * law.period) == pytest.approx(law.n1**2 / law.n2**2)


def test_ten_million_turns_leave_the_remainder_as_it_is(law):
    phi = np.linspace(-4, 4, 33)
    whole, rest = law.split(phi, 10_000_000)
    here, near = law.split(phi, 10_000_000 % law.n2)
    assert np.abs(rest - near).max() < 1e-13
    assert np.array_equal(whole - here, np.full(33, 10_000_000 // law.n2 * law.n1))


def test_the_inverse_brings_gear_1_back(law):
    phi = np.linspace(-9, 9, 301)
    assert np.abs(law.inverse(law.F(phi)) - phi).max() < 1e-13


def test_no_ratio_lies_beyond_the_extremes(law):
    phi = np.linspace(0, TURN, 100001)
    span = law.m_range
    assert span.smallest - 1e-14 <= law.m(phi).min() < span.smallest + 1e-7
    assert span.largest - 1e-7 < law.m(phi).max() <= span.largest + 1e-14
    assert law.m(span.smallest_at) == pytest.approx(span.smallest, abs=1e-15)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.RatioLaw.segments(0.7, 0.5, X), r"m = -4\.52.* at phi = 305.*must stay > 0.*103\.53 deg"),
        (lambda: gb.RatioLaw.segments(0.1, -0.2, X), "must stay > 0; no working segment is possible"),
        (lambda: gb.RatioLaw.segments(0.1, 0.8, 7.0), r"X = 7\.0 rad must be > 0 and < T"),
        (lambda: gb.RatioLaw.segments(0.1, 0.8, X, G=4.0), r"G = 4\.0 rad must be 2 pi or 2 pi over a whole number"),
        (lambda: gb.RatioLaw.segments(0.1, float("nan"), X), "b = nan must be a finite number"),
        (lambda: gb.RatioLaw.ellipse(1.0), r"e = 1\.0 must be >= 0 and < 1"),
        (lambda: gb.RatioLaw.ellipse(0.2, order=0), "order = 0 must be a whole number >= 1"),
        (lambda: gb.RatioLaw.from_function(1 + 1.2 * sp.cos(PHI)), r"m = -0\.2 at phi = 180 deg"),
        (lambda: gb.RatioLaw.from_function(1.01 + 0.2 * sp.cos(PHI)), r"drifts by \+3\.6 deg a turn; scale m by 0\.99"),
        (lambda: gb.RatioLaw.from_function(2 + 0.2 * sp.cos(PHI)), "turns by 720 deg over a period of 360 deg"),
        (
            lambda: gb.RatioLaw.from_function(1 + 0.2 * sp.Abs(sp.sin(PHI))),
            r"order 1 jumps by 0\.4 at phi = (0|180) deg",
        ),
        (
            lambda: gb.RatioLaw.from_function(1 + 0.2 * sp.Abs(sp.cos(PHI))),
            r"order 1 jumps by 0\.4 at phi = (90|270) deg",
        ),
        (
            lambda: gb.RatioLaw.from_function(1 + 0.2 * sp.Abs(sp.sin(PHI))),
            r"derivative of order 1 jumps by 0\.4 at phi = (0|180) deg",
        ),
        (
            lambda: gb.RatioLaw.from_function(1 + 0.2 * sp.Abs(sp.cos(PHI))),
            r"derivative of order 1 jumps by 0\.4 at phi = (90|270) deg",
        ),
        (lambda: gb.RatioLaw.from_function(1 + 0.2 * sp.Abs(sp.cos(PHI + 1))), "is not smooth near phi = (32|212)"),
        (lambda: gb.RatioLaw.from_function(1 + PHI * gb.time), "a ratio law depends on gb.driver_angle alone"),
        (lambda: gb.RatioLaw.from_function(PHI + sp.Symbol("x")), "has the symbols phi, x"),
        (lambda: gb.RatioLaw.from_function(1 / gb.sin(gb.driver_angle)), "has no value at phi = 0"),
        (lambda: gb.RatioLaw.from_table([0, 1, 2, 3], [1, 1, 1, 2]), r"m\[0\] = 1\.0, m\[-1\] = 2\.0"),
        (
            lambda: gb.RatioLaw.from_table([0, 1, 2, 3], [1, 1, 1, 1]),
            "whole number: else the pitch curve does not close",
        ),
        (lambda: gb.RatioLaw.from_table([1, 2], [1, 1]), "two rows of >= 4 numbers"),
        (lambda: gb.RatioLaw.ellipse(0.4632).pair(0.0), r"distance = 0\.0 m must be > 0"),
    ],
)
def test_a_law_that_cannot_be_is_refused_with_the_reason(make, words):
    with pytest.raises(gb.ParameterError, match=words):
        make()


def test_equal_descriptions_are_equal_laws():
    assert gb.RatioLaw.ellipse(0.3) == gb.RatioLaw.ellipse(0.3) != gb.RatioLaw.ellipse(0.31)
    assert hash(gb.RatioLaw.segments(0.1, 0.8, X)) == hash(gb.RatioLaw.segments(0.1, 0.8, X))
    assert gb.RatioLaw.from_function(1 + 0.2 * sp.cos(PHI)) == gb.RatioLaw.from_function(
        1 + 0.2 * gb.cos(gb.driver_angle)
    )
