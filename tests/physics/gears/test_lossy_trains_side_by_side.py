"""Trains with lossy gears that nothing couples: each moves, and rests, as it does alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import gearblocks as gb


def breaking_loose() -> gb.Drivetrain:
    """Two gears, held by friction until a torque over time moves them."""
    rig = gb.Drivetrain("breaking loose")
    one, two, three = (rig.add(f"j{i}", gb.Inertia(J=J)) for i, J in enumerate((0.25, 1.73, 0.0592)))
    first = rig.add("first", gb.LossyGear(ratio=2.0, efficiency=(0.926, 0.926)))
    second = rig.add("second", gb.LossyGear(ratio=2.0, efficiency=(0.613, 0.795), bearing=(0.5, 0.5)))
    swings, grows = gb.Torque(tau=0.242 * gb.sin(10.0 * gb.time)), gb.Torque(tau=-5.066666666666666 * gb.time)
    rig.connect(one.a, first.a)
    rig.connect(one.b, second.a)
    rig.connect(two.a, first.b)
    rig.connect(two.b, rig.add("grows", grows).flange)
    rig.connect(three.a, second.b, rig.add("swings", swings).flange)
    rig.chain(three, rig.add("damper", gb.Damper(c=0.333)), rig.add("ground", gb.Fixed()))
    return rig


def held(bearing: float = 9.3, size: float = 1.0) -> gb.Drivetrain:
    """Three gears in a row that hold the load by their friction, or let go where it is little."""
    rig = gb.Drivetrain("held")
    bodies = [rig.add(f"j{i}", gb.Inertia(J=J)) for i, J in enumerate((1.86, 0.1, 0.0447, 0.118))]
    gears = [
        rig.add("first", gb.LossyGear(ratio=2.5, efficiency=(0.657, 0.953), bearing=(bearing, bearing))),
        rig.add("second", gb.LossyGear(ratio=-1.0, efficiency=(0.538, 0.809))),
        rig.add("third", gb.LossyGear(ratio=4.0, efficiency=(0.463, 0.463))),
    ]
    rig.chain(bodies[0], gears[0], bodies[1])
    rig.connect(bodies[1].a, gears[1].a)
    rig.connect(bodies[2].a, gears[1].b)
    rig.connect(bodies[1].b, gears[2].a)
    load = rig.add("load", gb.Torque(tau=size * (-2.81 + 5.63 * gb.cos(gb.time))))
    rig.connect(bodies[3].a, gears[2].b, load.flange)
    rig.connect(bodies[2].b, rig.add("fan", gb.SpeedLoad(coeffs=(0.0624, 0.00367, 0.0))).flange)
    rig.chain(bodies[3], rig.add("damper", gb.Damper(c=0.059)), rig.add("ground", gb.Fixed()))
    return rig


PAIRS: dict[str, tuple[Callable[[], gb.Drivetrain], Callable[[], gb.Drivetrain]]] = {
    "moves beside held": (breaking_loose, held),
    "held twice": (held, lambda: held(20.0, 1000.0)),
    "lets go beside held": (lambda: held(0.3, 0.2), held),
    "small beside large": (breaking_loose, lambda: held(9.3e4, 1e4)),
}


@pytest.mark.parametrize("method", ["dp5", "dp8", pytest.param("rodas", marks=pytest.mark.long)])
@pytest.mark.parametrize("pair", PAIRS)
@pytest.mark.few(1)
def test_each_of_two_moves_as_it_does_alone(pair: str, method: str) -> None:
    """What holds one is small beside the forces in the other: solved together it was rounding of those, and no run went on."""
    t, trains = np.linspace(0.0, 1.5, 151), [make() for make in PAIRS[pair]]
    both = gb.Drivetrain("both")
    for name, train in zip(("one", "two"), trains, strict=True):
        both.add(name, train)
    run = gb.simulate(both, t=t, method=method)
    alone = [gb.simulate(train, t=t, rtol=1e-10) for train in trains]
    for name, right in zip(("one", "two"), alone, strict=True):
        speeds = [x for x in right.names if x.endswith(".w") and x.count(".") == 1]
        largest = max(float(np.abs(right[x]).max()) for x in speeds)
        for x in speeds:
            assert np.abs(run[f"{name}.{x}"] - right[x]).max() <= 1e-5 * largest, x
    assert run.stats.steps < 4 * sum(x.stats.steps for x in alone)
