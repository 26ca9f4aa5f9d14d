"""The polynomial that is fitted to a gap: its digits, and where it strays."""

import json
import math
from pathlib import Path

import pytest

from gearblocks.geometry.backlash_fit import polynomial_fit

pytestmark = pytest.mark.numeric

DATA = Path(__file__).parents[2] / "data"


FITS = json.loads((DATA / "noncircular_backlash_fits.json").read_text())


@pytest.mark.parametrize("degree", [5, 7, 9])
def test_the_fitted_polynomial_is_that_of_the_reference_to_all_its_digits(degree: int) -> None:
    true = FITS[str(degree)]["coef_odd"]
    # the reference was solved in double precision: its own condition costs three digits
    assert polynomial_fit(degree) == pytest.approx([true[str(p)] for p in range(1, degree + 1, 2)], rel=1e-12)


def test_the_fit_of_degree_nine_rounds_to_the_printed_one() -> None:
    assert [round(c, 4) for c in polynomial_fit(9)] == list(FITS["printed"].values())


@pytest.mark.parametrize("degree", [5, 7, 9])
def test_the_fit_strays_beyond_its_interval_as_the_reference_tells(degree: int) -> None:
    def f(x: float) -> float:
        return math.fsum(c * x ** (2 * j + 1) for j, c in enumerate(polynomial_fit(degree)))

    for x, (value, true) in FITS[str(degree)]["outside"].items():
        # the coefficients agree to 1e-13, at x = 4 times 4^9
        assert f(float(x)) == pytest.approx(value, rel=1e-9)
        assert true == pytest.approx(float(x) - 1)
    assert abs(f(1.0)) == pytest.approx(FITS[str(degree)]["maxdev"], rel=1e-10)
