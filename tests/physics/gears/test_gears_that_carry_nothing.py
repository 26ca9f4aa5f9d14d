"""A lossy gear that turns a light body only, beside two that carry a load which swings about their bearing torques.

Whenever the train comes to rest that gear carries nothing but rounding, and what its losses hold is as much. Truth: as its body
gets light, the train moves as it does without both; the difference is in proportion to the inertia.
"""

import random

import numpy as np
import pytest

import gearblocks as gb

LOAD = gb.Parameter("size", 12.4, "N m") * gb.sin(gb.Parameter("pace", 15.7, "rad/s") * gb.time)
METHODS = ("auto", "dp5", "dp8", "rodas")


def _model(*, side: bool) -> gb.Model:
    rig = gb.Drivetrain("gears")
    first, second = rig.add("first", gb.Inertia(J=1.09)), rig.add("second", gb.Inertia(J=0.626))
    back = rig.add("back", gb.LossyGear(ratio=-0.5, efficiency=(0.791, 0.809), bearing=(1.09, 1.09)))
    entry = rig.add("entry", gb.LossyGear(ratio=3.0, efficiency=(0.978, 0.802), bearing=(1.75, 1.75)))
    driven, load = rig.add("driven", gb.Inertia(J=0.249)), rig.add("load", gb.Torque(tau=LOAD))
    rig.connect(first.a, back.a)
    rig.connect(second.a, back.b, entry.a)
    rig.connect(driven.a, entry.b)
    rig.connect(driven.b, load.flange)
    if side:
        gear = rig.add("gear", gb.LossyGear(ratio=3.0, efficiency=(0.786, 0.786)))
        rig.connect(first.b, gear.a)
        rig.connect(gear.b, rig.add("light", gb.Inertia(J=0.369)).a)
    return gb.build(rig)


def _drawn(draw: random.Random) -> dict[str, float]:
    return {
        "size": draw.uniform(8.5, 14.0), "pace": draw.uniform(3.0, 40.0),
        "first.J": 10.0 ** draw.uniform(-1.0, 1.0), "second.J": 10.0 ** draw.uniform(-1.0, 0.5),
    }  # fmt: skip


def test_no_run_stops_where_all_comes_to_rest() -> None:
    """One in ten of such runs stopped: "no motion agrees with its losses"."""
    model, draw = _model(side=True), random.Random(2)
    for _ in range(12):
        numbers = _drawn(draw) | {"light.J": 10.0 ** draw.uniform(-2.0, 0.5)}
        how = {"method": draw.choice(METHODS), "rtol": draw.choice((1e-4, 1e-6, 1e-8))}
        run = gb.simulate(model, t_end=60.0 / numbers["pace"], parameters=numbers, **how)
        assert run.complete and len(run.events) > 5, (numbers, how)


@pytest.mark.parametrize("method", METHODS)
def test_a_light_body_moves_the_others_by_as_much_as_it_is_heavy(method: str) -> None:
    with_side, without, draw = _model(side=True), _model(side=False), random.Random(2)
    for _ in range(2):
        numbers = _drawn(draw)
        t = np.linspace(0.0, 60.0 / numbers["pace"], 601)
        truth = gb.simulate(without, t=t, parameters=numbers, rtol=1e-10)["first.w"]
        off = []
        for inertia in (1e-3, 1e-4):
            run = gb.simulate(with_side, t=t, parameters=numbers | {"light.J": inertia}, method=method, rtol=1e-10)
            off.append((run["first.w"] - truth) / inertia)
        assert np.abs(off[0] - off[1]).max() < 1e-2 * np.abs(off[1]).max() < 1e-2 * np.abs(truth).max(), numbers


@pytest.mark.parametrize("inertia", [1e-6, 1e-7, 1e-8, 1e-9])
def test_bodies_far_lighter_than_the_others_are_no_obstacle(inertia: float) -> None:
    """A start at rest without load: what lifts the matrix little beside the light body lifted it far beside all others."""
    with_side, without, draw = _model(side=True), _model(side=False), random.Random(2)
    for method in METHODS:
        numbers = _drawn(draw)
        t = np.linspace(0.0, 30.0 / numbers["pace"], 301)
        truth = gb.simulate(without, t=t, parameters=numbers, rtol=1e-9)["first.w"]
        run = gb.simulate(with_side, t=t, parameters=numbers | {"light.J": inertia}, method=method, rtol=1e-8)
        assert np.abs(run["first.w"] - truth).max() < (inertia + 1e-7) * np.abs(truth).max(), numbers
