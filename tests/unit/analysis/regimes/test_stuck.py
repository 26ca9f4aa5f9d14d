"""Derivatives beside what friction or a stop holds from the begin of a run on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

import gearblocks as gb
from gearblocks.analysis.regimes.strobe import Strobe, strobe

SECTION = gb.stroboscopic("drive")


def _seen(*, lock: bool) -> tuple[Strobe, np.ndarray]:
    """Two discs that friction or a freewheel holds together for good, the one three times as heavy, and their states."""
    rig, drive = gb.Drivetrain("held"), gb.Parameter("drive", 1.0, "rad/s")
    coupling = gb.Freewheel() if lock else gb.Clutch(capacity=5.0)
    rig.chain(
        rig.add("source", gb.Torque(tau=2.0 + 0.5 * gb.cos(drive * gb.time))), rig.add("one", gb.Inertia(J=1.0, w0=1.0)),
        rig.add("coupling", coupling), rig.add("two", gb.Inertia(J=3.0)), rig.add("damper", gb.Damper(c=0.5)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    seen = strobe(gb.build(rig), SECTION, None, None, 1e-12)
    return seen, seen.follow(seen.start(None), 5).states[-1]


@pytest.mark.parametrize("lock", [False, True])
def test_a_slip_beside_what_sticks_is_taken_away_by_the_impulse_of_friction(lock: bool) -> None:
    seen, y = _seen(lock=lock)
    names = [q.name for q in seen.model.program.states]
    one, two = names.index("one.w"), names.index("two.w")
    assert y[one] == pytest.approx(y[two], abs=1e-12)
    found = seen.map(y, 1).maps[-1]
    left = np.exp(-0.5 / 4 * 2 * np.pi)  # of the speed of both together, which keep their momentum
    assert found[np.ix_([one, two], [one, two])] == pytest.approx(np.outer([left] * 2, [0.25, 0.75]), abs=1e-9)
    step = 1e-6
    for j in (one, two):
        # forward: the freewheel lets what is behind it run ahead, friction either
        beside = seen.follow(y + step * (np.arange(seen.n) == (two if lock else j)), 1).states[-1]
        there = (beside - seen.follow(y, 1).states[-1]) / step
        assert there == pytest.approx(found[:, two if lock else j], abs=1e-4)


def test_a_stuck_disc_has_no_multiplier_beside_those_of_where_it_sticks() -> None:
    rig, drive = gb.Drivetrain("stuck"), gb.Parameter("drive", 1.0, "rad/s")
    disc = rig.add("disc", gb.Inertia(J=1.0, w0=3.0))
    rig.chain(
        rig.add("source", gb.Torque(tau=0.5 * gb.cos(drive * gb.time))), disc, rig.add("spring", gb.Shaft(k=1.0)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    rig.connect(rig.add("brake", gb.Brake(capacity=2.0)).a, disc.b)
    seen = strobe(gb.build(rig), SECTION, None, None, 1e-9)
    found = seen.map(seen.follow(seen.start(None), 10).states[-1], 1).maps[-1]
    assert found == pytest.approx(np.diag([1.0, 1.0, 0.0]), abs=1e-12)
    orbit = gb.periodic_orbit(rig, SECTION)
    assert np.abs(orbit.multipliers) == pytest.approx([1.0, 0.0], abs=1e-12) and orbit.neutral == (
        "free angle of brake",
    )


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_what_lies_off_a_stop_that_is_pressed_comes_back_to_it(restitution: float) -> None:
    """A disc pushes another one, three times as heavy, by a stop against a spring: off it by little they close up about what
    is their centre of gravity, and only a root of that later."""
    rig, drive = gb.Drivetrain("pushed"), gb.Parameter("drive", 1.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=2.0 + 0.5 * gb.cos(drive * gb.time))), rig.add("one", gb.Inertia(J=1.0)),
        rig.add("stop", gb.HardStop(lower=0.0, restitution=restitution)), rig.add("two", gb.Inertia(J=3.0)),
        rig.add("spring", gb.Shaft(k=0.3, c=0.5)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    seen = strobe(gb.build(rig), SECTION, None, None, 1e-12)
    y = seen.follow(seen.start(None), 5).states[-1]
    names = [q.name for q in seen.model.program.states]
    gap, spring, one, two = (names.index(name) for name in ("stop.coordinate", "spring.coordinate", "one.w", "two.w"))
    found, rate = seen.map(y, 1).maps[-1], np.array([[0.0, -1.0], [0.3 / 4, -0.5 / 4]])
    place, speed = expm(
        rate * 2 * np.pi
    ).T  # beside the motion of both discs as one, by the spring's twist and their speed
    of_gap = 0.25 * place + 0.5 * 0.25 / 4 * speed  # the damper feels what the one behind is late by
    for column, expected in ((gap, of_gap), (spring, place), (one, 0.25 * speed), (two, 0.75 * speed)):
        assert found[[spring, one, two, gap], column] == pytest.approx([*expected, expected[1], 0.0], abs=1e-8)
    step = 1e-9
    beside = seen.follow(y + step * (np.arange(seen.n) == gap), 1).states[-1]
    there = (beside - seen.follow(y, 1).states[-1])[[spring, one, two]] / step
    assert there == pytest.approx(found[[spring, one, two], gap], abs=1e-4)


def test_a_disc_that_a_stop_holds_for_good_has_a_period() -> None:
    rig, drive = gb.Drivetrain("pressed"), gb.Parameter("drive", 3.0, "rad/s")
    disc = rig.add("disc", gb.Inertia(J=1.0))
    rig.chain(rig.add("source", gb.Torque(tau=2.0 + gb.sin(drive * gb.time))), disc)
    rig.connect(rig.add("stop", gb.HardStop(upper=1.0, restitution=0.5)).a, disc.b)
    regime = gb.classify(rig, SECTION)
    assert regime.label == "period 1" and np.abs(regime.orbit.multipliers).max() == pytest.approx(0.0, abs=1e-9)


def _column_of_gap(rig: gb.Drivetrain, step: float) -> tuple[np.ndarray, np.ndarray]:
    """That of the map over a period, and differences of runs, both without what stops record."""
    seen = strobe(gb.build(rig), SECTION, None, None, 1e-12)
    y = seen.follow(seen.start(None), 3).states[-1]
    names = [q.name for q in seen.model.program.states]
    told = [i for i, name in enumerate(names) if not name.startswith("stop.im")]
    gap = names.index("stop.coordinate")
    beside = seen.follow(y + step * (np.arange(seen.n) == gap), 1).states[-1]
    return seen.map(y, 1).maps[-1][told, gap], ((beside - seen.follow(y, 1).states[-1]) / step)[told]


def _at_a_stop(torque: float) -> gb.Drivetrain:
    rig, drive = gb.Drivetrain("at a stop"), gb.Parameter("drive", 3.0, "rad/s")
    disc = rig.add("disc", gb.Inertia(J=1.0, phi0=1.0))
    rig.chain(rig.add("source", gb.Torque(tau=torque * (2.0 + gb.sin(drive * gb.time)))), disc)
    rig.connect(rig.add("stop", gb.HardStop(upper=1.0, restitution=0.5)).a, disc.b)
    return rig


@pytest.mark.parametrize(("beside", "stays"), [("weak brake", 0.0), ("strong brake", 1.0), ("freewheel", 1.0)])
def test_friction_beside_a_stop_holds_what_lies_off_it_or_lets_it_come_back(beside: str, stays: float) -> None:
    rig = _at_a_stop(1.0)
    if beside == "freewheel":
        rig.chain(rig.add("wheel", gb.Freewheel()), rig.add("wall", gb.Fixed()))
        rig.connect(rig["disc"].b, rig["wheel"].a)
    else:
        rig.connect(rig.add("brake", gb.Brake(capacity=0.5 if beside == "weak brake" else 5.0)).a, rig["disc"].b)
    found, runs = _column_of_gap(rig, 1e-6)
    assert found[0] == pytest.approx(stays, abs=1e-9) and found == pytest.approx(runs, abs=1e-6)


def test_what_nothing_presses_stays_off_its_stop() -> None:
    found, runs = _column_of_gap(_at_a_stop(0.0), 1e-6)
    assert found[0] == 1.0 and found == pytest.approx(runs, abs=1e-9)


def test_inertias_that_vary_on_the_way_back_are_told() -> None:
    """Behind a bent joint the inertia that is pushed varies; taken as it is at the start the map is 8 % off."""
    rig, drive = gb.Drivetrain("bent"), gb.Parameter("drive", 6.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=20.0 + 0.5 * gb.cos(drive * gb.time))), rig.add("one", gb.Inertia(J=1.0, w0=5.0)),
        rig.add("stop", gb.HardStop(lower=0.0, restitution=0.0)), rig.add("two", gb.Inertia(J=1.0, w0=5.0)),
        rig.add("joint", gb.UniversalJoint(angle=0.7)), rig.add("three", gb.Inertia(J=0.3)),
    )  # fmt: skip
    rig.chain(rig.add("damper", gb.Damper(c=4.0)), rig.add("ground", gb.Fixed()))
    rig.connect(rig["two"].b, rig["damper"].a)
    found, runs = _column_of_gap(rig, 1e-8)
    assert found == pytest.approx(runs, abs=1e-4)
