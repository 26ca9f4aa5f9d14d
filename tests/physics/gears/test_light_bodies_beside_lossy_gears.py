"""A light body that a brake drags, between a lossy gear and a clutch that holds: its accelerations, were it free, are large
and cancel; none of their rounding may reach what it is tied to.

Independent: by hand, all that turns with the gear as one body on either side of it.
"""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

HEAVY, OTHER, DRAG, ETA = 0.8, 0.3, 7.1, 0.9
DRIVE = 30 * gb.sin(2.19 * gb.time + 1)
T = np.linspace(0.0, 0.05, 26)


def _train(ratio: float, light: float, brakes: int) -> gb.Drivetrain:
    rig = gb.Drivetrain("light between")
    one, other = rig.add("one", gb.Inertia(J=HEAVY, w0=5.0)), rig.add("other", gb.Inertia(J=OTHER, w0=5.0 / ratio))
    gear = rig.add("gear", gb.LossyGear(ratio=ratio, efficiency=(ETA, 0.8)))
    rig.chain(rig.add("drive", gb.Torque(tau=DRIVE)), one, gear, rig.add("link", gb.Clutch(capacity=80.0)), other)
    rig.connect(gear.b, rig.add("small", gb.Inertia(J=light, w0=5.0 / ratio)).a)
    for i in range(brakes):
        rig.connect(gear.b, rig.add(f"brake{i}", gb.Brake(capacity=DRAG / brakes)).a)
    return rig


CASES = [(1.0, 6.3e-5, 1), (2.5, 8e-6, 2), (-0.7, 4e-6, 1)]


@pytest.mark.parametrize(("ratio", "light", "brakes"), CASES)
def test_its_neighbours_accelerate_as_one(ratio: float, light: float, brakes: int) -> None:
    run = gb.simulate(_train(ratio, light, brakes), t=T, rtol=1e-10)
    r = abs(ratio)
    drive = 30 * np.sin(2.19 * T + 1)
    wanted = (r * ETA * drive - DRAG) / (r * ETA * HEAVY + (OTHER + light) / r)
    assert np.min(drive - HEAVY * wanted) > 0  # the gear drives forward, as ETA assumes
    assert run["one.alpha"] == pytest.approx(wanted, rel=1e-13 + 1e-16 / light)


@pytest.mark.parametrize(("ratio", "light", "brakes"), CASES)
def test_no_method_takes_steps_for_its_rounding(ratio: float, light: float, brakes: int) -> None:
    for method in ("dp8", "rodas"):
        run = gb.simulate(_train(ratio, light, brakes), t_end=0.2, rtol=1e-10, method=method)
        assert run.stats.steps < 40 and run.energy.residual < 1e-9, method


@pytest.mark.parametrize("ratio", [1.0, -0.7])
def test_nor_where_the_clutch_drives_a_planetary_set(ratio: float) -> None:
    """The mass matrix is none of single inertias there."""
    runs = {}
    for light in (1e-5, 2e-5, 3e-5):
        rig = _train(ratio, light, 1)
        gear, carrier, ring = (
            rig.add("set", gb.IdealPlanetary(ratio=2.0)),
            rig.add("carrier", gb.Inertia(J=0.3)),
            gb.Inertia(J=0.1),
        )
        rig.connect(rig["other"].b, gear.sun)
        rig.connect(carrier.a, gear.carrier)
        rig.connect(rig.add("ring", ring).a, gear.ring)
        runs[light] = gb.simulate(rig, t=T, rtol=1e-10)
        for method in ("dp8", "rodas"):
            run = gb.simulate(rig, t_end=0.2, rtol=1e-9, method=method)
            assert run.stats.steps < 40 and run.energy.residual < 1e-9, method
    one, two, three = (1 / run["one.alpha"] for run in runs.values())  # a line over the inertia
    assert one + three == pytest.approx(2 * two, rel=1e-11)


def test_strictness_that_is_of_no_use_ends_where_little_of_it_is_left() -> None:
    """At 1e-9 steps can be judged by a hundredth more strictly, no more: a balance that rounding moves ends it all the same."""
    run = gb.simulate(_train(1.0, 1e-9, 1), t_end=0.2, rtol=1e-9, method="rodas")
    assert run.stats.steps < 6000 and run.energy.residual < 1e-8
