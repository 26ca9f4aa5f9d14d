"""Pitch curves of ratio laws: rolling, involutes, undercut, curvature."""

import numpy as np
import pytest

import gearblocks as gb

pytestmark = pytest.mark.numeric

TURN = 2 * np.pi


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


def test_a_rack_undercuts_beyond_the_largest_module(ratio_laws):
    pair = ratio_laws["ellipse"].pair(0.25)
    alpha = np.deg2rad(20)
    limit = pair.largest_module(alpha)
    for factor, undercut in ((0.98, False), (1.02, True)):
        flanks = pair.flanks(factor * limit, 500, pressure_angle=alpha)  # many flanks meet the sharpest place
        assert flanks.undercut.any() == undercut


def test_concave_curves_are_reported(ratio_laws):
    one, two = ratio_laws["segments"].pair(0.2).curvatures
    assert not one.is_convex and not two.is_convex
    assert ratio_laws["segments"].pair(0.2).flanks(1e-3, 200, pressure_angle=0.35).undercut.any()


def test_the_convexity_of_gear_1_is_that_of_its_formula(ratio_laws):
    law = ratio_laws["segments"]
    phi = np.linspace(0, TURN, 5000)
    m, dm, ddm = law.m(phi), law.dm(phi), law.dm(phi, 2)
    formula = 1 + 1 / m + 2 * dm**2 / m**3 - ddm / m**2  # 1 + 1/m + (1/m)''
    assert np.array_equal(formula > 0, law.pair(0.2).curvature_at(phi, 1) > 0)
