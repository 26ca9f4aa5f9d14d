"""Ratio laws: how they are made, what they refuse, and the geometry that follows from them."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.geometry.ratio_fit import power_series

TURN = 2 * np.pi
X = np.deg2rad(240)
PHI = sp.Symbol("phi")
TABLE = np.linspace(0, TURN, 121)
LAWS = {
    "segments": gb.RatioLaw.segments(0.7 / X, 0.5, X),
    "two lobes": gb.RatioLaw.segments(0.2, 0.4, 1.5, T=TURN / 2, G=TURN / 3),
    "ellipse": gb.RatioLaw.ellipse(0.4632),
    "three lobes": gb.RatioLaw.ellipse(0.3, order=3),
    "waves": gb.RatioLaw.from_function(1 + 0.3 * sp.cos(PHI) + 0.2 * sp.sin(2 * PHI) * sp.cos(3 * PHI)),
    "fitted": gb.RatioLaw.from_function(1 / (1 + 0.2 * gb.cos(gb.driver_angle)), normalise=True),
    "table": gb.RatioLaw.from_table(TABLE, 1 + 0.3 * np.cos(TABLE).round(14), normalise=True),
}
EVERY = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


@EVERY
def test_each_derivative_is_the_slope_of_the_one_before(law):
    phi, h = np.linspace(-3, 9, 500), 1e-5
    if law is LAWS["table"]:  # m'' is a chain of lines: the difference must not reach over a point
        phi = phi[np.abs((phi / TABLE[1]) % 1 - 0.5) < 0.4]
    near_joint = np.zeros_like(phi, dtype=bool)
    if law.recipe[0] == "segments":
        rest = phi % law.period
        near_joint = (np.abs(rest - law.curve.x[:, None]) < 2 * h).any(axis=0)
    for value, slope in ((law.F, law.m), (law.m, law.dm), (law.dm, lambda x: law.dm(x, 2))):
        difference = (value(phi + h) - value(phi - h)) / (2 * h)
        error = np.abs(difference - slope(phi))[~near_joint]
        assert error.max() < 1e-7 * max(1.0, np.abs(slope(phi)).max())  # h^2/6 of the third derivative, and eps/h


@EVERY
def test_gear_2_gains_its_share_of_a_turn_in_a_period(law):
    phi = np.linspace(-5, 5, 101)
    assert np.abs(law.F(phi + law.period) - law.F(phi) - law.gain).max() < 1e-14 * 20
    assert law.F(0.0) == pytest.approx(0.0, abs=1e-15)
    assert law.n1 * law.gain / (law.n2 * law.period) == pytest.approx(law.n1**2 / law.n2**2)


@EVERY
def test_ten_million_turns_leave_the_remainder_as_it_is(law):
    phi = np.linspace(-4, 4, 33)
    whole, rest = law.split(phi, 10_000_000)
    here, near = law.split(phi, 10_000_000 % law.n2)
    assert np.abs(rest - near).max() < 1e-13
    assert np.array_equal(whole - here, np.full(33, 10_000_000 // law.n2 * law.n1))


@EVERY
def test_the_inverse_brings_gear_1_back(law):
    phi = np.linspace(-9, 9, 301)
    assert np.abs(law.inverse(law.F(phi)) - phi).max() < 1e-13


@EVERY
def test_no_ratio_lies_beyond_the_extremes(law):
    phi = np.linspace(0, TURN, 100001)
    span = law.m_range
    assert span.smallest - 1e-14 <= law.m(phi).min() < span.smallest + 1e-7
    assert span.largest - 1e-7 < law.m(phi).max() <= span.largest + 1e-14
    assert law.m(span.smallest_at) == pytest.approx(span.smallest, abs=1e-15)


def test_sums_of_waves_are_exact_and_other_functions_say_their_error():
    assert LAWS["waves"].fit_error == 0.0
    assert 0 < LAWS["fitted"].fit_error < 1e-13
    phi = np.linspace(0, TURN, 1001)
    true = 1 + 0.3 * np.cos(phi) + 0.2 * np.sin(2 * phi) * np.cos(3 * phi)
    assert np.abs(LAWS["waves"].m(phi) - true).max() < 1e-15
    fitted = LAWS["fitted"]
    assert np.abs(fitted.m(phi) / fitted.scaled - 1 / (1 + 0.2 * np.cos(phi))).max() <= fitted.fit_error + 4e-16
    assert fitted.scaled == pytest.approx(
        np.sqrt(1 - 0.2**2), abs=1e-14
    )  # the mean of 1/(1 + e cos) is 1/sqrt(1 - e^2)


def test_an_ellipse_is_the_same_law_however_it_is_given():
    e = 0.4632
    phi = np.linspace(0, TURN, 1001)
    given = gb.RatioLaw.from_function((1 - e**2) / (1 + e**2 - 2 * e * sp.cos(PHI)))
    assert np.abs(given.F(phi) - LAWS["ellipse"].F(phi)).max() < 1e-13
    K = (1 + e) / (1 - e)
    assert np.tan(LAWS["ellipse"].F(2.0) / 2) == pytest.approx(K * np.tan(1.0), rel=1e-14)


@pytest.mark.parametrize("zeros", [1, 3, 12])
def test_coefficients_that_rounding_makes_zero_keep_their_place(zeros):
    row = np.ones(13)
    row[13 - zeros :] = 0.0
    powers = power_series(row)
    v = np.linspace(-1, 1, 41)
    assert powers.shape == (13,)
    assert (
        np.abs(np.polynomial.polynomial.polyval(v, powers) - np.cos(np.outer(np.arccos(v), np.arange(13))) @ row).max()
        < 1e-12
    )


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
        (lambda: LAWS["ellipse"].pair(0.0), r"distance = 0\.0 m must be > 0"),
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


# -- geometry ---------------------------------------------------------------------------------------------------------


@EVERY
def test_both_pitch_curves_have_the_same_length_and_touch(law):
    pair = law.pair(0.2)
    phi = np.linspace(0, TURN, 20001)
    arcs = []
    for gear in (1, 2):
        x, y = pair.points(phi, gear)
        arcs.append(np.hypot(np.diff(x), np.diff(y)).sum())
    # chords of 20000 steps are shorter by less than (kappa step)^2/24 of the arc
    assert arcs == pytest.approx([pair.length] * 2, rel=1e-6)
    assert sum(pair.radii(phi)) == pytest.approx(np.full(20001, 0.2))


def test_circles_get_involutes():
    r, alpha = 0.1, np.deg2rad(20)
    for gear in (1, 2):
        flanks = gb.RatioLaw.ellipse(0.0).pair(2 * r).flanks(0.005, 40, pressure_angle=alpha, gear=gear)
        reach, base = np.hypot(flanks.x, flanks.y), r * np.cos(alpha)
        assert abs(flanks.defect) < 1e-14
        assert np.abs(flanks.radius - np.sqrt(reach**2 - base**2)).max() < 1e-15 * 20
        # half thickness angle of tooth 0: pi/(2 z) + inv(alpha) - inv(alpha at the radius)
        at = np.arccos(base / reach[1])
        half = np.pi / 80 + np.tan(alpha) - alpha - np.tan(at) + at
        middle = 0.0 if gear == 1 else np.pi
        polar = np.unwrap(np.arctan2(flanks.y[:2], flanks.x[:2])) - middle
        turned = np.abs((polar + np.pi) % TURN - np.pi)
        assert np.abs(turned - half).max() < 1e-14 * 10


def test_a_rack_undercuts_beyond_the_largest_module():
    pair = LAWS["ellipse"].pair(0.25)
    alpha = np.deg2rad(20)
    limit = pair.largest_module(alpha)
    for factor, undercut in ((0.98, False), (1.02, True)):
        flanks = pair.flanks(factor * limit, 500, pressure_angle=alpha)  # many flanks meet the sharpest place
        assert flanks.undercut.any() == undercut


def test_concave_curves_are_reported():
    one, two = LAWS["segments"].pair(0.2).curvatures
    assert not one.is_convex and not two.is_convex
    assert LAWS["segments"].pair(0.2).flanks(1e-3, 200, pressure_angle=0.35).undercut.any()


def test_the_convexity_of_gear_1_is_that_of_its_formula():
    law = LAWS["segments"]
    phi = np.linspace(0, TURN, 5000)
    m, dm, ddm = law.m(phi), law.dm(phi), law.dm(phi, 2)
    formula = 1 + 1 / m + 2 * dm**2 / m**3 - ddm / m**2  # 1 + 1/m + (1/m)''
    assert np.array_equal(formula > 0, law.pair(0.2).curvature_at(phi, 1) > 0)


# -- in trains --------------------------------------------------------------------------------------------------------


def _rig(law, **mesh):
    rig = gb.Drivetrain("pair")
    gear = gb.NonCircularGear(law=law, **({"external": False, "k": 400.0, "c": 0.01} | mesh))
    rig.chain(
        rig.add("drive", gb.Torque(tau=0.2)), rig.add("one", gb.Inertia(J=1e-4, w0=100.0)), rig.add("mesh", gear),
        rig.add("two", gb.Inertia(J=2e-4, w0=float(law.m(0.0)) * 100.0)),
    )  # fmt: skip
    return rig


@EVERY
def test_a_train_with_a_ratio_law_survives_its_file(law, tmp_path):
    rig = _rig(law, backlash=gb.Backlash(half_gap=1e-4), k=400 + 20 * gb.cos(gb.driver_angle))
    rig.to_json(tmp_path / "rig.json")
    back = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert back["mesh"].law == law
    assert gb.build(back).program.key == gb.build(rig).program.key


def test_another_law_is_another_program():
    keys = {gb.build(_rig(law)).program.key for law in LAWS.values()}
    assert len(keys) == len(LAWS)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"law": 2.0}, r"law = 2\.0 must be a gb\.RatioLaw"),
        ({"external": None}, "external = None must be True or False"),
        ({"k": -1.0}, r"k = -1\.0 N m/rad must be > 0"),
        ({"k": None}, "damping need compliance: give k"),
        ({"k": gb.twist}, r"contains gb\.twist, which only the torque of a Shaft knows"),
        ({"k": None, "c": None, "phase": gb.Input("p")}, "has no acceleration.*an Input may jump"),
        ({"k": None, "c": None, "phase": gb.Table([0, 1], [0, 1])}, "a table of kind 'linear' has corners"),
        ({"k": None, "c": None, "phase": abs(gb.time)}, "Abs has corners"),
        ({"phase": gb.sense("one.w"), "filter": 10.0}, "is sensed and has no value yet when the filter starts"),
        ({"filter": 10.0}, "filter is that of a phase; give one"),
        ({"k": 400 + gb.driver_angle, "c": None, "damping_ratio": 0.1}, "damping_ratio needs a k that does not change"),
    ],
)
def test_a_pair_that_cannot_be_is_refused(fields, words):
    with pytest.raises(gb.ModelError, match=words):
        gb.Drivetrain("wrong").add(
            "mesh", gb.NonCircularGear(**({"law": LAWS["ellipse"], "external": False, "k": 400.0, "c": 0.01} | fields))
        )


def test_a_spring_over_the_driver_angle_is_no_shaft():
    rig = gb.Drivetrain("wrong")
    with pytest.raises(gb.ModelError, match=r"gb\.driver_angle, which only the k of a NonCircularGear knows"):
        rig.add("shaft", gb.Shaft(k=gb.driver_angle + 1))
