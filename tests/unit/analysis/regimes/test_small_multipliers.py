"""Multipliers and exponents of motions that fade by many orders within one period, against their equations."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def _row(inertias: Sequence[float], stiffness: Sequence[float], damping: Sequence[float], held: bool) -> gb.Drivetrain:
    """Discs in a row with shafts between them, the last one to the ground where it is held."""
    rig, drive = gb.Drivetrain("row"), gb.Parameter("drive", 1.0, "rad/s")
    parts = [rig.add("source", gb.Torque(tau=gb.cos(drive * gb.time)))]
    for i, (J, k, c) in enumerate(zip(inertias, stiffness, damping, strict=True)):
        parts += [rig.add(f"d{i}", gb.Inertia(J=J)), rig.add(f"s{i}", gb.Shaft(k=k, c=c))]
    rig.chain(*parts, rig.add("end", gb.Fixed() if held else gb.Inertia(J=2.0)))
    return rig


def _eigenvalues(
    inertias: Sequence[float], stiffness: Sequence[float], damping: Sequence[float], held: bool
) -> np.ndarray:
    """Of its equation [1/s], the largest real part first, without the rigid turn."""
    J = np.array([*inertias, 2.0])
    n = len(J)
    k, c = np.zeros((n, n)), np.zeros((n, n))
    for matrix, values in ((k, stiffness), (c, damping)):
        for i, value in enumerate(values):
            matrix[i : i + 2, i : i + 2] += value * np.array([[1.0, -1.0], [-1.0, 1.0]])
    n -= held
    k, c = (x[:n, :n] / J[:n, None] for x in (k, c))
    found = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-k, -c]]))
    found = found[np.abs(found) > 1e-6]
    return found[np.argsort(-found.real)]


ROWS = {
    "one by one": ((1.0,), (1.0,), (3.0,), True),
    "pairs": ((1.0, 0.5), (2.0, 3.0), (1.0, 2.0), True),
    "below rounding": ((1.0, 0.5, 0.7), (5.0, 3.0, 2.0), (2.0, 4.0, 0.5), True),
    "free to turn": ((1.0, 0.5), (5.0, 3.0), (2.0, 4.0), False),
    "beyond all numbers": ((1.0, 0.01), (5.0, 3.0), (2.0, 4.0), True),  # exp(-3900)
}


@pytest.mark.few(2)
@pytest.mark.parametrize("row", ROWS)
def test_they_are_those_of_a_linear_train_however_small(row: str) -> None:
    rig, known = _row(*ROWS[row]), _eigenvalues(*ROWS[row])
    orbit = gb.periodic_orbit(rig, SECTION)
    assert orbit.periods == 1 and len(orbit.exponents) == len(known)
    assert orbit.exponents == pytest.approx(known.real, abs=1e-8, rel=1e-8)
    assert np.abs(orbit.multipliers) == pytest.approx(np.exp(2 * np.pi * known.real), rel=1e-7, abs=0.0)
    phases = np.exp(2j * np.pi * known.imag)
    shown = orbit.multipliers[np.abs(orbit.multipliers) > 0]
    angles = shown / np.abs(shown)
    assert np.sort(angles.real) == pytest.approx(np.sort(phases.real[: len(shown)]), abs=1e-6)
    found = gb.lyapunov(rig, SECTION, periods=20)
    assert found.values == pytest.approx(known.real, abs=1e-8, rel=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("row", ["one by one", "below rounding"])
def test_along_a_branch_they_are_those_of_each_value(row: str) -> None:
    branch = gb.continue_orbit(_row(*ROWS[row]), "drive", (1.0, 0.8), section=SECTION, of="d0.phi")
    known = _eigenvalues(*ROWS[row]).real
    for value, multipliers in zip(branch.values, branch.multipliers, strict=True):
        assert np.log(np.abs(multipliers)) == pytest.approx(2 * np.pi / value * known, abs=1e-7)


def test_of_a_motion_that_is_not_linear_the_product_is_that_of_its_trace(oscillator: Oscillator) -> None:
    # Duffing's oscillator beside a damper of 6 1/s: det M = exp(-12 pi)
    rig = oscillator(lambda drive, x, v: 2.0 * gb.cos(drive * gb.time) - x**3, k=1.0, c=6.0)
    orbit = gb.periodic_orbit(rig, SECTION)
    assert orbit.exponents.sum() == pytest.approx(-6.0, abs=1e-9)


def test_exponents_of_chaos_are_told_beside_what_fades_at_once(oscillator: Oscillator) -> None:
    # a disc of its own that fades with 20 1/s, in a period of 2 pi: exp(-126)
    rig = oscillator(lambda drive, x, v: 7.5 * gb.cos(drive * gb.time) - x**3, k=1e-12)
    rig.chain(
        rig.add("other", gb.Inertia(J=1.0, w0=1.0)), rig.add("damper", gb.Damper(c=20.0)), rig.add("fixed", gb.Fixed())
    )
    found = gb.lyapunov(rig, SECTION, periods=200)
    assert found.values[0] > 0.05
    assert found.values[-1] == pytest.approx(-20.0, rel=1e-4)  # by steps of two over the fastest rate
    assert found.values.sum() == pytest.approx(-20.05, rel=1e-4)


def test_what_an_event_takes_away_for_good_is_nothing(oscillator: Oscillator) -> None:
    # a plastic stop: whatever the speed is before it strikes, it is that of the stop behind it
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=2.0, c=0.1)
    rig.chain(
        rig["disc"], rig.add("stop", gb.HardStop(lower=-0.2, upper=9.0, restitution=0.0)), rig.add("wall", gb.Fixed())
    )
    found = gb.classify(rig, SECTION)  # it rests on the stop as the section comes: no step of Newton's may leave it
    assert found.label == "period 1", found.evidence
    orbit = gb.periodic_orbit(rig, SECTION)
    assert orbit.stable and (np.abs(orbit.multipliers) < 1e-6).all()
