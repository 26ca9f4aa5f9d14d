"""The largest value of functions whose maximum is known, from five nodes per segment."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gearblocks.simulation.extrema import NODES, WEIGHTS, extremum

Array = NDArray[np.float64]


def _found(f: Callable[[Array], Array], edges: Array, rtol: float = 1e-10) -> tuple[float, int]:
    asked = 0

    def sample(t: Array) -> Array:
        nonlocal asked
        asked += len(t)
        assert (np.diff(t) > 0).all()
        return f(t)

    t0, t1 = edges[:-1], edges[1:]
    nodes = f((t0[:, None] + (t1 - t0)[:, None] * NODES).ravel()).reshape(-1, 5)
    return extremum(t0, t1, nodes, sample, rtol), asked


@pytest.mark.parametrize("segments", [1, 2, 3, 5, 8, 40])
@pytest.mark.parametrize("phase", [0.0, 0.3, 1.1, 2.0])
def test_the_maximum_of_a_sine_does_not_depend_on_the_segments(segments: int, phase: float) -> None:
    best, _ = _found(lambda t: np.sin(t + phase), np.linspace(0.0, 3.0, segments + 1))
    assert best == pytest.approx(np.sin(np.clip(np.pi / 2, phase, phase + 3.0)), abs=1e-11)


@pytest.mark.parametrize("number", range(8))
def test_the_highest_of_two_near_peaks_is_taken(number: int) -> None:
    high, edges = 1.0 + 1e-6, np.linspace(0.0, 10.0, 9 + number)

    def f(t: Array) -> Array:
        return np.exp(-((t - 2.2) ** 2)) + high * np.exp(-((t - 7.6) ** 2))

    best, _ = _found(f, edges)
    grid = np.linspace(7.5, 7.7, 200001)
    assert best == pytest.approx(float(f(grid).max()), abs=1e-11)


def test_what_a_parabola_shows_needs_no_closer_look() -> None:
    best, asked = _found(lambda t: 1.0 - (t - 0.37) ** 2, np.linspace(0.0, 1.0, 4))
    assert (best, asked) == (pytest.approx(1.0, abs=1e-15), 0)


def test_a_constant_and_a_line_have_their_ends() -> None:
    assert _found(lambda t: 0 * t + 2.5, np.linspace(0, 1, 3)) == (2.5, 0)
    assert _found(lambda t: 3 - t, np.linspace(0, 1, 3))[0] == 3.0


def test_a_value_that_is_no_number_makes_the_peak_none() -> None:
    assert np.isnan(_found(lambda t: np.where(t > 0.5, np.nan, t), np.linspace(0, 1, 3))[0])


@pytest.mark.parametrize("degree", range(8))
def test_the_weights_integrate_polynomials_of_degree_seven(degree: int) -> None:
    assert float(WEIGHTS @ NODES**degree) == pytest.approx(1 / (degree + 1), rel=1e-14)
