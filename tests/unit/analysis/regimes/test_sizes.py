"""States whose motion is rounding beside that of others: no size of their own, and derivatives all the same."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from scipy.linalg import expm

import gearblocks as gb
from gearblocks.analysis.regimes.sizes import _Along, _jacobians
from gearblocks.analysis.regimes.strobe import strobe

DRIVE = 1.3
UNEVEN = 1.0 + 1e-15
"""A torque that all but balances another one: what it leaves is rounding."""


def _discs(
    inertias: Sequence[float], stiffness: Sequence[float], grounds: Sequence[float]
) -> tuple[Callable[[Sequence[object]], gb.Drivetrain], np.ndarray]:
    """Discs in a row with shafts of damping 0.07 k between them and to the ground, and exp(A T) of their equation."""

    def made(torques: Sequence[object]) -> gb.Drivetrain:
        rig = gb.Drivetrain("discs")
        discs = [rig.add(f"d{i}", gb.Inertia(J=J)) for i, J in enumerate(inertias)]
        for i, tau in enumerate(torques):
            rig.chain(rig.add(f"t{i}", gb.Torque(tau=tau)), discs[i])
        for i, k in enumerate(stiffness):
            rig.chain(discs[i], rig.add(f"s{i}", gb.Shaft(k=k, c=0.07 * k)), discs[i + 1])
        for i, k in enumerate(grounds):
            if k:
                rig.chain(discs[i], rig.add(f"g{i}", gb.Shaft(k=k, c=0.07 * k)), rig.add(f"f{i}", gb.Fixed()))
        return rig

    n = len(inertias)
    stiff = np.diag(np.asarray(grounds, dtype=float))
    for i, k in enumerate(stiffness):
        stiff[i : i + 2, i : i + 2] += k * np.array([[1.0, -1.0], [-1.0, 1.0]])
    over = stiff / np.asarray(inertias)[:, None]
    rates = np.block([[np.zeros((n, n)), np.eye(n)], [-over, -0.07 * over]])
    return made, np.linalg.eigvals(expm(rates * 2 * np.pi / DRIVE))


def _drive() -> tuple[gb.Parameter, object]:
    drive = gb.Parameter("drive", DRIVE, "rad/s")
    return drive, gb.cos(drive * gb.time)


@pytest.mark.parametrize(
    "case",
    [
        pytest.param("between two that swing against each other", marks=pytest.mark.long),
        "the same, free to turn",
        "at rest under a load",
    ],
)
def test_a_state_of_rounding_size_has_the_multipliers_of_its_equation(case: str) -> None:
    _, swings = _drive()
    if case == "at rest under a load":
        made, known = _discs((1.0, 0.4), (2.0,), (0.0, 5.0))
        rig = made([1.0 / 3.0 + 1e-25 * swings])
    else:
        made, known = _discs((1.0, 0.7, 1.0), (3.0, 3.0), (0.0, 0.0 if "free" in case else 1.0, 0.0))
        rig = made([swings, 0.0, -UNEVEN * swings])
    orbit = gb.periodic_orbit(rig, gb.stroboscopic("drive"))
    sizes = np.abs(orbit.points[0])
    assert 0.0 < sizes[sizes > 0.0].min() < 1e-13 * sizes.max()  # the case is there
    own = known[np.abs(known - 1.0) > 1e-6]
    assert orbit.neutral == (("rigid turn of d0, d1, d2",) if "free" in case else ())
    assert np.sort_complex(orbit.multipliers) == pytest.approx(np.sort_complex(own), abs=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("size", [1e-29, 1e-9])
def test_a_small_state_that_nothing_large_reaches_keeps_its_own_size(size: float) -> None:
    # Mathieu's equation beside the swing that drives it: x'' + 0.1 x' + (2.7 - 0.5 phi) x = size cos
    def rig(amplitude: float) -> gb.Drivetrain:
        _, swings = _drive()
        made = gb.Drivetrain("mathieu")
        for name, tau in (
            ("hub", swings),
            ("disc", amplitude * swings + 0.5 * gb.sense("hub.phi") * gb.sense("disc.phi")),
        ):
            made.chain(
                made.add(f"{name}_torque", gb.Torque(tau=tau)), made.add(name, gb.Inertia(J=1.0)),
                made.add(f"{name}_spring", gb.Shaft(k=2.0, c=0.1)), made.add(f"{name}_ground", gb.Fixed()),
            )  # fmt: skip
        return made

    small, large = (gb.periodic_orbit(rig(amplitude), gb.stroboscopic("drive")) for amplitude in (size, 0.1))
    assert np.abs(small.multipliers) == pytest.approx(np.abs(large.multipliers), abs=1e-9)
    at = [i for i, name in enumerate(small.names) if name.startswith("disc")]
    assert small.points[0, at] / size == pytest.approx(large.points[0, at] / 0.1, rel=1e-7)


def test_points_at_which_no_run_can_begin_are_passed_over() -> None:
    # a body that rests on a table which moves is beyond it at some instants, by what a run is off
    rig, drive = gb.Drivetrain("table"), gb.Parameter("drive", 1.0, "rad/s")
    disc, table = rig.add("disc", gb.Inertia(J=1.0, phi0=0.5)), gb.Angle(phi=0.9 * gb.sin(drive * gb.time))
    rig.chain(rig.add("weight", gb.Torque(tau=-1.0)), disc)
    rig.chain(rig.add("table", table), rig.add("stop", gb.HardStop(lower=0.0, upper=1e3, restitution=0.0)), disc)
    seen = strobe(gb.build(rig), gb.stroboscopic("drive"), None, None, 1e-9)
    y, after = seen.follow(seen.start(None), 3).states[-1], 3
    y[[q.name for q in seen.model.program.states].index("stop.coordinate")] = 0.0
    states, times = np.tile(y, (8, 1)), np.full(8, seen.period * after)
    known = _jacobians(seen, _Along(states, times), np.ones(seen.n))
    states[2:, 0] = -1e-6
    found = _jacobians(seen, _Along(states, times), np.ones(seen.n))
    assert len(known) == 8 and len(found) == 2 and (np.array(found) == known[0]).all()
