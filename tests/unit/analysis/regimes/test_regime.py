"""Labels of motions that are known for what they are, with the evidence that they rest on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes.exponents import LyapunovExponents

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")
LIGHT = 2e-6 / (2 * np.pi)  # damping of a focus that decays by 1e-6 in a period


def _sum(second: float, size: float = 1.0) -> Callable[[Any, Any, Any], Any]:
    return lambda drive, x, v: gb.cos(drive * gb.time) + size * gb.cos(second * gb.time)


def _van_der_pol(drive: Any, x: Any, v: Any) -> Any:
    return 0.1 * gb.cos(drive * gb.time) + (1 - x**2) * v


@pytest.mark.parametrize(
    ("label", "torque", "numbers"),
    [
        ("period 1", lambda drive, x, v: gb.cos(drive * gb.time), {"k": 1.44, "c": LIGHT}),  # turns by a fifth
        pytest.param("quasi-periodic", _sum(1.5 + 1e-7), {"k": 3.0, "c": 0.2}, marks=pytest.mark.long),
        ("period 2", _sum(1.5), {"k": 3.0, "c": 0.2}),
        ("period 2", _sum(0.5, 4e-6), {"k": 3.0, "c": 0.2}),
        ("period 3", _sum(1 / 3, 1e-4), {"k": 3.0, "c": 0.2}),
        ("quasi-periodic", lambda drive, x, v: gb.cos(drive * gb.time), {"k": 2.0, "c": 0.0}),  # its own, undamped
        ("diverged", lambda drive, x, v: gb.cos(drive * gb.time) + 0.05 * v, {"k": 2.0, "c": 0.0}),
        pytest.param("quasi-periodic", _van_der_pol, {"k": 3.3, "c": 0.0, "phi0": 0.1}, marks=pytest.mark.long),
    ],
)  # fmt: skip
def test_motions_get_their_labels(oscillator: Oscillator, label: str, torque: Any, numbers: dict[str, float]) -> None:
    found = gb.classify(oscillator(torque, **numbers), SECTION)
    assert (found.label, found.settled) == (label, True), found.evidence
    if found.period is not None:
        assert found.orbit is not None and found.orbit.stable and found.orbit.closure < 1e-8
        assert found.label == f"period {found.period}" == f"period {found.orbit.periods}"


@pytest.mark.long
def test_a_motion_whose_period_is_longer_than_was_looked_for_is_told_by_its_exponents(oscillator: Oscillator) -> None:
    # x'' + 0.3 x' - x + x^3 = force cos 1.2 t: period 5 at 0.37
    rig = oscillator(lambda drive, x, v: 0.37 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.3)
    found = gb.classify(rig, SECTION, longest=2, parameters={"drive": 1.2})
    assert found.label == "period 5", found.evidence


@pytest.mark.long
@pytest.mark.parametrize(
    ("label", "second", "longest"),
    [("period 2", 1.5, 1), ("quasi-periodic", 1.5 + 1e-7, 1), ("period 11", 12 / 11, 4), ("quasi-periodic", 2**0.5, 2)],
)
def test_drives_that_repeat_later_than_was_looked_for_are_no_torus(
    oscillator: Oscillator, label: str, second: float, longest: int
) -> None:
    found = gb.classify(oscillator(_sum(second), k=3.0, c=0.2), SECTION, longest=longest)
    assert found.label == label, found.evidence


def test_errors_of_exponents_are_not_small_by_chance() -> None:
    rng, periods, trials = np.random.default_rng(5), 500, 4000
    irregular = 0.2 + 0.3 * rng.standard_normal((periods, trials))
    found = LyapunovExponents(irregular, 1.0, (), "", np.zeros(1), periods)
    off = np.abs(found.per_period - 0.2) / found.errors_per_period
    assert (off > 3).mean() < 0.02 and (off > 30).sum() == 0
    k = np.arange(periods)[:, None]
    regular = 0.2 + 0.3 * np.cos(2 * np.pi * np.array([0.618, 0.1234, 0.377]) * k)
    found = LyapunovExponents(regular, 1.0, (), "", np.zeros(1), periods)
    assert np.abs(found.per_period - 0.2).max() < 1e-6 and found.errors_per_period.max() < 1e-5


def _ueda(oscillator: Oscillator, force: float, share: float = 1.0) -> gb.Drivetrain:
    """x'' + 0.05 x' + x^3 = force cos(share t), seen once per period of `drive` = 1."""
    return oscillator(lambda drive, x, v: force * gb.cos(share * drive * gb.time) - x**3, k=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("number", range(4))
@pytest.mark.parametrize(("force", "share", "period"), [(8.045113, 0.5, 2), (10.932331, 1.0, 3)])
def test_an_irregular_transient_is_no_chaos(
    oscillator: Oscillator, force: float, share: float, period: int, number: int
) -> None:
    # next to a boundary crisis: irregular for a thousand periods of the section (six thousand) on the mean, then periodic
    model = gb.build(_ueda(oscillator, force, share))
    parameters = {"drive": 1.0 / share}
    start = {"disc.phi": -3.0 + 6.0 * number / 4, "disc.w": 0.3 * number - 1.0}
    run = gb.simulate(
        model,
        t=2 * np.pi * share * np.arange(60000),
        rtol=1e-9,
        parameters=parameters,
        initial=start,
        outputs=["disc.phi"],
    )
    off = np.abs(run["disc.phi"][period:] - run["disc.phi"][:-period])
    assert off[-100:].max() < 1e-6  # the truth; by as long a run as it takes
    settled = int(np.flatnonzero(off > 1e-3)[-1])
    found = gb.classify(model, SECTION, parameters=parameters, initial=start)
    assert found.label == f"period {period}", (settled, found.evidence)


@pytest.mark.long
@pytest.mark.parametrize(
    ("labels", "torque", "numbers"),
    [
        # a cascade: period 4 of Ueda's oscillator behind its period 2
        (("period 4",), lambda drive, x, v: 5.28 * gb.cos(drive * gb.time) - x**3, {"k": 1e-12}),
        # below and within the first tongue of Hill's equation, which begins at q = 0.2001 (test_branch.py)
        (("period 1",), lambda drive, x, v: (1 - 0.1 * gb.cos(2 * drive * gb.time)) * -x + x, {"k": 1.0, "c": 0.1}),
        (("diverged",), lambda drive, x, v: -0.5 * gb.cos(2 * drive * gb.time) * x, {"k": 1.0, "c": 0.1, "phi0": 0.1}),
        # an oscillation of its own, caught by the drive (Adler: |detuning| < force/(2 a), a = 2) and not caught
        (("period 1",), lambda drive, x, v: gb.cos(drive * gb.time) + (0.2 - 0.2 * x**2) * v, {"k": 1.05, "c": 0.0}),
        (
            ("quasi-periodic",),
            lambda drive, x, v: 0.05 * gb.cos(drive * gb.time) + (0.2 - 0.2 * x**2) * v,
            {"k": 2.2, "c": 0.0, "phi0": 0.1},
        ),
        # what is left of the start falls as 1/sqrt(t): the multiplier of rest is 1
        (("period 1", "unresolved"), lambda drive, x, v: 0.0 * drive - x**3, {"k": 1e-15, "c": 1.0, "phi0": 1.0}),
        # three drives, the third of which repeats after 7 periods
        (
            ("period 7",),
            lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(3 * drive * gb.time) + 1e-3 * gb.sin(drive * gb.time / 7),
            {"k": 3.0, "c": 0.2},
        ),
        # escapes from its well after it has swung up
        (("diverged",), lambda drive, x, v: 0.25 * gb.cos(drive * gb.time) + x**3, {"k": 1.0, "c": 0.05}),
    ],
)  # fmt: skip
def test_further_kinds_get_their_labels_or_none(
    oscillator: Oscillator, labels: tuple[str, ...], torque: Any, numbers: dict[str, float]
) -> None:
    found = gb.classify(oscillator(torque, **numbers), SECTION)
    assert found.label in labels, found.evidence


def test_multipliers_of_a_focus_are_those_of_its_equation(oscillator: Oscillator) -> None:
    # x'' + c x' + k x: exp((-c/2 +- i sqrt(k - c^2/4)) T)
    k, c = 1.44, 0.1
    orbit = gb.periodic_orbit(oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=k, c=c), SECTION)
    expected = np.exp((-c / 2 + 1j * np.sqrt(k - c**2 / 4)) * 2 * np.pi)
    assert sorted(orbit.multipliers, key=lambda m: m.imag) == pytest.approx(
        sorted([expected, expected.conjugate()], key=lambda m: m.imag), abs=1e-9
    )
    assert orbit.exponents == pytest.approx([-c / 2, -c / 2], abs=1e-10)


@pytest.mark.long
def test_a_motion_that_strikes_its_stops_is_periodic_though_these_count() -> None:
    rig, drive = gb.Drivetrain("stops"), gb.Parameter("drive", 1.0, "rad/s")
    source = rig.add("source", gb.Torque(tau=gb.cos(drive * gb.time)))
    stop = gb.HardStop(lower=-0.3, upper=0.4, restitution=0.6)
    rig.chain(source, rig.add("disc", gb.Inertia(J=1.0)), rig.add("stop", stop), rig.add("ground", gb.Fixed()))
    assert gb.classify(rig, SECTION).label == "period 1"


def test_two_wells_are_two_motions(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: 0.1 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.25, phi0=0.5)
    found = gb.classify(rig, SECTION, starts=4)
    assert found.label == "coexisting: period 1 and period 1" and found.settled
    wells = {bool(part.orbit.points[0, 0] > 0) for part in found.parts if part.orbit is not None}
    assert wells == {True, False}


def test_an_unstable_orbit_is_found_and_called_so(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: 1e-3 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.25)
    orbit = gb.periodic_orbit(rig, SECTION, transient=0)  # on the hill between the wells
    assert not orbit.stable and abs(orbit.points[0, 0]) < 1e-2 and "unstable" in repr(orbit)
    # there x'' + 0.25 x' - x = 0
    rate = -0.125 + np.sqrt(0.125**2 + 1)
    assert orbit.exponents[0] == pytest.approx(rate, abs=1e-4)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda rig: gb.classify(rig, SECTION, keep=10), "keep = 10 > twice"),
        (lambda rig: gb.lyapunov(rig, SECTION, periods=3), "periods = 3 must be >= 20"),
        (lambda rig: gb.periodic_orbit(rig, SECTION, periods=0), "periods = 0 must be >= 1"),
        (lambda rig: gb.classify(rig, gb.stroboscopic("drve")), "drve"),
        (lambda rig: gb.classify(rig, "drive"), "section = 'drive' must be a section"),
        (lambda rig: gb.classify(rig, SECTION, rtol=float("nan")), "rtol"),
        (lambda rig: gb.lyapunov(rig, SECTION, rtol=-1.0), "rtol"),
        (lambda rig: gb.bifurcation(rig, "drive", ["a"], section=SECTION), "drive = 'a' must be a number"),
    ],
)
def test_what_cannot_be_asked_is_refused_by_name(oscillator: Oscillator, call: Any, words: str) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time))
    with pytest.raises(gb.GearblocksError, match=words):
        call(rig)
