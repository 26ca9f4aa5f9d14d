"""Ratio laws that are fitted to functions: exact where they can be, else with their error."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.geometry.ratio_fit import power_series

pytestmark = pytest.mark.numeric

TURN = 2 * np.pi
PHI = sp.Symbol("phi")


def test_sums_of_waves_are_exact_and_other_functions_say_their_error(ratio_laws):
    assert ratio_laws["waves"].fit_error == 0.0
    assert 0 < ratio_laws["fitted"].fit_error < 1e-13
    phi = np.linspace(0, TURN, 1001)
    true = 1 + 0.3 * np.cos(phi) + 0.2 * np.sin(2 * phi) * np.cos(3 * phi)
    assert np.abs(ratio_laws["waves"].m(phi) - true).max() < 1e-15
    fitted = ratio_laws["fitted"]
    assert np.abs(fitted.m(phi) / fitted.scaled - 1 / (1 + 0.2 * np.cos(phi))).max() <= fitted.fit_error + 4e-16
    assert fitted.scaled == pytest.approx(
        np.sqrt(1 - 0.2**2), abs=1e-14
    )  # the mean of 1/(1 + e cos) is 1/sqrt(1 - e^2)


def test_an_ellipse_is_the_same_law_however_it_is_given(ratio_laws):
    e = 0.4632
    phi = np.linspace(0, TURN, 1001)
    given = gb.RatioLaw.from_function((1 - e**2) / (1 + e**2 - 2 * e * sp.cos(PHI)))
    assert np.abs(given.F(phi) - ratio_laws["ellipse"].F(phi)).max() < 1e-13
    K = (1 + e) / (1 - e)
    assert np.tan(ratio_laws["ellipse"].F(2.0) / 2) == pytest.approx(K * np.tan(1.0), rel=1e-14)


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
