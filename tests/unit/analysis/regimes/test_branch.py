"""Branches of periodic orbits: folds, doublings, branch points, tori and grazes against what is known of them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gearblocks as gb

Array = NDArray[np.float64]
Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")
ASK: dict[str, Any] = {"section": SECTION, "of": "disc.phi"}


def _harmonic_balance(phase: float, harmonics: int = 9) -> float:
    """w of x'' + 0.1 x' + 0.4 x + x^3 = 0.6 cos w t, x = sum Re c_n exp(i n w t), with this phase of c_1."""
    from scipy.optimize import root

    orders = np.arange(1, 2 * harmonics, 2)
    angle = 2 * np.pi * np.arange(128) / 128
    waves = np.exp(1j * np.outer(orders, angle))

    def left(unknown: Array) -> Array:
        c, w = unknown[:harmonics] + 1j * unknown[harmonics:-1], unknown[-1]
        off = (0.4 - (orders * w) ** 2 + 0.1j * orders * w) * c + 2 * waves.conj() @ (c @ waves).real ** 3 / 128
        off[0] -= 0.6
        return np.concatenate([off.real, off.imag, [(c[0] * np.exp(-1j * phase)).imag]])

    start = np.zeros(2 * harmonics + 1)
    start[0], start[harmonics], start[-1] = 2.5 * np.cos(phase), 2.5 * np.sin(phase), np.sqrt(0.4 + 0.75 * 2.5**2)
    found = root(left, start, tol=1e-13)
    assert np.abs(left(found.x)).max() < 1e-9
    return float(found.x[-1])


@pytest.mark.long
def test_folds_of_duffing_are_those_of_its_harmonic_balance(oscillator: Oscillator, tmp_path: Path) -> None:
    from scipy.optimize import minimize_scalar

    rig = oscillator(lambda drive, x, v: 0.6 * gb.cos(drive * gb.time) - x**3, k=0.4, c=0.1)
    branch = gb.continue_orbit(rig, "drive", (1.0, 3.0), parameters={"drive": 1.0}, **ASK)
    top, bottom = branch.marked("fold")
    # the largest frequency that the balance has near the peak; it is flat there
    peak = minimize_scalar(
        lambda a: -_harmonic_balance(a), bounds=(-1.9, -1.2), method="bounded", options={"xatol": 1e-6}
    )
    assert top.bracket[0] - 1e-7 <= -peak.fun <= top.bracket[1] + 1e-7  # told to 1e-8 by the balance
    assert bottom.value < top.value and "none below" in bottom.words and "none above" in top.words
    assert top.multipliers[0] == pytest.approx(1.0, abs=1e-4)
    assert branch.stable[: top.number].all() and branch.stable[bottom.number + 1 :].all()
    assert not branch.stable[top.number + 1 : bottom.number].any() and bottom.number - top.number > 5
    # orbits of both kinds are orbits: a point of the middle branch by scipy
    from scipy.integrate import solve_ivp

    i = (top.number + bottom.number) // 2
    w, y = branch.values[i], branch.states[i] * [-1, 1]
    assert branch.names == ("spring.coordinate", "disc.w")
    end = solve_ivp(
        lambda t, y: (y[1], 0.6 * np.cos(w * t) - 0.1 * y[1] - 0.4 * y[0] - y[0] ** 3), (0, 2 * np.pi / w), y,
        "DOP853", rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    assert end.y[:, -1] == pytest.approx(y, abs=1e-8)
    assert np.prod(branch.multipliers, axis=1) == pytest.approx(np.exp(-0.1 * 2 * np.pi / branch.values), rel=1e-7)
    assert branch.ended == "ends at 3: the end of the range" and branch.values[-1] == pytest.approx(3.0, rel=1e-14)
    branch.plot(tmp_path / "branch.png")
    data = branch.to_xarray()
    assert data["rms"].attrs["units"] == "rad" and data.sizes["orbit"] == len(branch.values)
    assert "fold at" in repr(branch) and "fold at" in repr(top)


def _of_hill(k: float, q: float, drive: float, multiplier: float) -> float:
    """det(M - multiplier) of x'' + 0.1 x' + (k + q cos(drive t)) x = 0 over a period."""
    from scipy.integrate import solve_ivp

    def rates(t: float, y: Array) -> tuple[float, ...]:
        stiffness = k + q * np.cos(drive * t)
        return y[1], -0.1 * y[1] - stiffness * y[0], y[3], -0.1 * y[3] - stiffness * y[2]

    run = solve_ivp(rates, (0, 2 * np.pi / drive), [1, 0, 0, 1], "DOP853", rtol=1e-12, atol=1e-14)
    return float(np.linalg.det(run.y[:, -1].reshape(2, 2) - multiplier * np.eye(2)))


@pytest.mark.long
def test_a_doubling_is_where_hills_equation_doubles_and_its_branch_leaves(oscillator: Oscillator) -> None:
    # x = 0 of x'' + 0.1 x' + (1 + q cos 2t) x + x^3 = 0
    from scipy.optimize import brentq

    q = gb.Parameter("q", 0.1)
    rig = oscillator(lambda drive, x, v: -q * gb.cos(drive * gb.time) * x - x**3, k=1.0, c=0.1)
    ask = {**ASK, "parameters": {"drive": 2.0}}
    known = brentq(lambda q: _of_hill(1.0, q, 2.0, -1.0), 0.1, 0.5, xtol=1e-12)
    still = gb.continue_orbit(rig, "q", (0.1, 0.5), **ask)
    (mark,) = still.marks
    assert (mark.kind, mark.periods, mark.words) == ("period doubling", 2, "a branch of period 2 leaves")
    assert mark.bracket[0] - 1e-8 <= known <= mark.bracket[1] + 1e-8 and mark.bracket[1] - mark.bracket[0] < 1e-6
    assert np.abs(still.states).max() < 1e-9
    branch = gb.continue_orbit(rig, "q", (0.1, 0.5), start=mark, **ask)
    assert branch.periods == 2 and branch.marks == () and branch.stable[2:].all()
    assert branch.values[0] == pytest.approx(known, abs=1e-6) and (np.diff(branch.values) > 0).all()
    found = gb.classify(rig, SECTION, parameters={"drive": 2.0, "q": 0.5}, initial={"disc.phi": 0.5})
    assert found.label == "period 2" and found.orbit is not None
    # it is the motion that one finds there: one of its two points, x and -x
    assert min(np.abs(branch.states[-1] - point).max() for point in found.orbit.points) < 1e-7


@pytest.mark.long
def test_where_hills_equation_buckles_another_branch_leaves(oscillator: Oscillator) -> None:
    # x = 0 of x'' + 0.1 x' + (1 - p + 0.3 cos t) x + x^3 = 0
    from scipy.optimize import brentq

    p = gb.Parameter("p", 0.5)
    rig = oscillator(lambda drive, x, v: (p - 0.3 * gb.cos(drive * gb.time)) * x - x**3, k=1.0, c=0.1)
    known = brentq(lambda p: _of_hill(1.0 - p, 0.3, 1.0, 1.0), 0.95, 1.2, xtol=1e-12)
    doubles = brentq(lambda p: _of_hill(1.0 - p, 0.3, 1.0, -1.0), 0.9, 0.95, xtol=1e-12)
    still = gb.continue_orbit(rig, "p", (0.9, 1.2), parameters={"p": 0.9}, **ASK)
    doubling, mark = still.marks
    assert (doubling.kind, mark.kind) == ("period doubling", "branch point")
    assert mark.words == "another branch of period 1 leaves"
    for one, value in ((doubling, doubles), (mark, known)):
        assert one.bracket[0] - 1e-7 <= value <= one.bracket[1] + 1e-7
    wells = gb.continue_orbit(rig, "p", (0.9, 1.2), start=mark, **ASK)
    assert wells.periods == 1 and wells.values[-1] == pytest.approx(1.2) and wells.stable[2]
    near = (wells.values - known > 1e-3) & (wells.values - known < 0.02)  # it leaves as a parabola
    slopes = wells.mean[near] ** 2 / (wells.values[near] - known)
    assert near.sum() > 2 and slopes.std() < 0.1 * slopes.mean()
    assert not still.stable[still.values > known + 1e-3].any()


def test_a_damping_that_turns_negative_is_a_torus(oscillator: Oscillator) -> None:
    c = gb.Parameter("damping", 0.1)
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) - c * v, k=2.0, c=0.0)
    branch = gb.continue_orbit(rig, "damping", (0.1, -0.1), **ASK)
    (mark,) = branch.marks
    assert mark.kind == "torus" and mark.bracket[0] - 1e-7 < 0.0 < mark.bracket[1] + 1e-7 and mark.direction is None


@pytest.mark.long
def test_a_branch_that_grazes_a_stop_ends_there_and_says_so() -> None:
    rig, F, drive = gb.Drivetrain("stop"), gb.Parameter("F", 0.2), gb.Parameter("drive", 1.0, "rad/s")
    source = rig.add("source", gb.Torque(tau=F * gb.cos(drive * gb.time)))
    disc, ground = rig.add("disc", gb.Inertia(J=1.0)), rig.add("ground", gb.Fixed())
    rig.chain(source, disc, rig.add("spring", gb.Shaft(k=2.0, c=0.25)), ground)
    rig.chain(disc, rig.add("stop", gb.HardStop(lower=-0.5, upper=9.0, restitution=0.6)), ground)
    branch = gb.continue_orbit(rig, "F", (0.2, 0.8), **ASK)
    (mark,) = branch.marks
    grazes = 0.5 * abs(1 + 0.25j)
    assert mark.kind == "grazing" and mark.words.startswith("0 events")
    assert mark.bracket[0] <= grazes <= mark.bracket[1] < grazes * (1 + 1e-4)
    assert "it grazes" in branch.ended and branch.stable.all()
    # linear until then
    assert np.abs(branch.multipliers) == pytest.approx(
        np.full((len(branch.values), 2), np.exp(-0.25 * np.pi)), abs=1e-6
    )


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"span": (1.0, 1.0)}, "must be two different numbers"),
        ({"span": 3.0}, "must be two numbers"),
        ({"step": 0.0}, r"step = 0.0 in \(0, 1\]"),
        ({"start": 3}, "start = 3 must be an orbit"),
        ({"parameter": "drve"}, "drve"),
        ({"periods": 0}, "periods = 0 must be >= 1"),
    ],
)
def test_what_cannot_be_followed_is_refused_by_name(oscillator: Oscillator, more: dict[str, Any], words: str) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=2.0)
    ask = {"parameter": "drive", "span": (1.0, 1.2), **ASK} | more
    with pytest.raises(gb.GearblocksError, match=words):
        gb.continue_orbit(rig, ask.pop("parameter"), ask.pop("span"), **ask)


def test_where_no_orbit_stands_apart_it_is_said(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=1.0, c=0.0)  # at its resonance
    with pytest.raises(gb.ParameterError, match="every motion of this train is neutral"):
        gb.continue_orbit(rig, "drive", (1.0, 2.0), **ASK)


@pytest.mark.long
def test_an_orbit_that_is_known_can_be_the_begin(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: 1e-3 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.25)
    orbit = gb.periodic_orbit(rig, SECTION, transient=0)  # on the hill between the wells
    branch = gb.continue_orbit(rig, "drive", (1.0, 1.5), start=orbit, **ASK)
    assert not branch.stable.any() and np.abs(branch.mean).max() < 1e-6 and branch.marks == ()
