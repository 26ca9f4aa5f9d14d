"""Rarer kinds: what leaves an unstable rest, what is neutral altogether, starts that lie along neutral directions, motions that
turn backwards."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def test_what_leaves_an_unstable_rest_does_not_diverge(oscillator: Oscillator) -> None:
    # van der Pol's oscillator from 1e-20: grows by exp(0.094) a period up to an amplitude of 2
    model = gb.build(oscillator(lambda drive, x, v: 0.03 * (1 - x**2) * v + 0 * drive, k=2.0, c=0.0, phi0=1e-20))
    run = gb.simulate(model, t=2 * np.pi * np.array([0, 400, *np.linspace(2000, 2010, 400)]), rtol=1e-9)
    assert abs(run["disc.phi"][1]) < 1e-2 and np.abs(run["disc.phi"][2:]).max() == pytest.approx(2.0, abs=0.01)
    found = gb.classify(model, SECTION)
    assert found.label == "quasi-periodic", found.evidence


def test_a_motion_that_is_neutral_altogether_is_told_by_whether_it_repeats(oscillator: Oscillator) -> None:
    # undamped: x'' + 4 x = cos t repeats from every start, x'' + x = cos t grows by pi a period
    repeats, grows = (oscillator(lambda drive, x, v: gb.cos(drive * gb.time), k=k, c=0.0) for k in (4.0, 1.0))
    found = gb.classify(repeats, SECTION)
    assert found.label == "period 1" and "largest multiplier none" in found.evidence[0], found.evidence
    found = gb.classify(grows, SECTION)
    assert found.label == "unresolved" and "neutral" in found.evidence[0], found.evidence
    with pytest.raises(gb.SimulationError, match="no exponents but those that are 0"):
        gb.lyapunov(grows, SECTION)
    with pytest.raises(gb.SimulationError, match="no orbit"):
        gb.periodic_orbit(grows, SECTION)


def test_starts_that_lie_apart_along_neutral_directions_alone_are_one_motion() -> None:
    # w' = 2 + cos t - 1 - 0.3 w: slip of the brake adds up, and is another one from each start
    rig, drive = gb.Drivetrain("drift"), gb.Parameter("drive", 1.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=2.0 + gb.cos(drive * gb.time))), rig.add("disc", gb.Inertia(J=1.0)),
        rig.add("damper", gb.Damper(c=0.3)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    rig.connect(rig.add("brake", gb.Brake(capacity=1.0)).a, rig["disc"].b)
    found = gb.classify(rig, SECTION, starts=3)
    assert found.label == "period 1" and found.evidence[0].startswith("3 of 3 starts"), found.evidence


def test_machines_that_turn_backwards_and_both_ways_go_on_by_their_turns() -> None:
    # x'' + 0.1 x' = s (2 sin(6 t - s x) - 0.4): s x = 6 t - pi/6, beside it z'' + 0.1 z' + 2 cos(pi/6) z = 0
    rig, drive = gb.Drivetrain("two"), gb.Parameter("drive", 6.0, "rad/s")
    for name, s in (("a", 1), ("b", -1)):
        tau = s * (2.0 * gb.sin(drive * gb.time - s * gb.sense(f"{name}.phi")) - 0.4)
        rig.chain(
            rig.add(f"source_{name}", gb.Torque(tau=tau)),
            rig.add(name, gb.Inertia(J=1.0, w0=6.0 * s, phi0=-s * (np.pi / 6 + 0.1))),
            rig.add(f"damper_{name}", gb.Damper(c=0.1)), rig.add(f"ground_{name}", gb.Fixed()),
        )  # fmt: skip
    found = gb.classify(rig, SECTION)
    assert found.label == "period 1" and "a by +1, b by -1" in found.evidence[0], found.evidence
    orbit = found.orbit
    assert orbit is not None and orbit.ahead[:2] == pytest.approx([2 * np.pi, -2 * np.pi])
    known = np.exp(np.roots([1.0, 0.1, 2 * np.cos(np.pi / 6)]) * 2 * np.pi / 6.0)
    assert np.sort(orbit.multipliers.imag) == pytest.approx(np.sort(np.repeat(known.imag, 2)), abs=1e-6)
