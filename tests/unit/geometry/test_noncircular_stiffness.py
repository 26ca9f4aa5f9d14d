"""Stiffness over the angle: circles give the tooth pair of the standard, concave curves are refused."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.geometry.involute import ToothPair, single_stiffness

pytestmark = pytest.mark.numeric

MODULE, WIDTH = 2e-3, 0.02


@pytest.mark.parametrize("shifts", [(0.0, 0.0), (0.3, -0.1)])
def test_circles_have_the_tooth_numbers_and_the_single_stiffness_of_the_standard(shifts):
    pair = gb.RatioLaw.ellipse(0.0).pair(40 * MODULE)
    phi = np.linspace(0, 2 * np.pi, 7)
    assert pair.equivalent_teeth(phi, 1, module=MODULE) == pytest.approx(np.full(7, 40.0), rel=1e-13)
    k = pair.mesh_stiffness(phi, module=MODULE, face_width=WIDTH, shifts=shifts, factor=0.8)
    same = ToothPair(40, 40, MODULE, np.deg2rad(20), shifts=shifts, addendum=0.95)  # its rack factor is 1
    assert k == pytest.approx(np.full(7, WIDTH * single_stiffness(same)), rel=1e-13)


def test_a_pair_is_as_stiff_where_its_mate_drives():
    law = gb.RatioLaw.ellipse(0.3)
    one, other = law.pair(0.2), law.inverted.pair(0.2)
    phi = np.linspace(0, 2 * np.pi, 9)
    k = [p.mesh_stiffness(x, module=MODULE, face_width=WIDTH) for p, x in ((one, phi), (other, law.F(phi)))]
    assert k[0] == pytest.approx(k[1], rel=1e-10)  # Ze1 = Ze2 in ellipses


def test_a_concave_curve_and_numbers_below_zero_are_refused():
    pair = gb.RatioLaw.segments(0.7 / np.deg2rad(240), 0.5, np.deg2rad(240)).pair(0.2)
    with pytest.raises(gb.ParameterError, match="the pitch curve of gear 1 is concave where it meshes"):
        pair.mesh_stiffness(pair.curvatures[0].smallest_at, module=MODULE, face_width=WIDTH)
    with pytest.raises(gb.ParameterError, match="face_width = -1"):
        pair.mesh_stiffness(0.0, module=MODULE, face_width=-1)
    with pytest.raises(gb.ParameterError, match="module = 0"):
        pair.equivalent_teeth(0.0, 1, module=0)


def test_placed_points_of_both_gears_touch_at_the_pitch_point(ratio_laws):
    for law in ratio_laws.values():
        pair = law.pair(0.2)
        for phi in (0.0, 0.7, 4.0):
            touching = [pair.radii(phi)[0], 0.0]
            for gear in (1, 2):
                place = np.array(pair.placed(phi, gear, *pair.points(phi, gear)))
                assert np.abs(place - touching).max() < 1e-15 * 20, gear
