"""Two bodies and a lossy gear whose slip comes to zero under a load: it rests there only where that holds it.

What the gear holds at rest is the difference of losses that nearly cancel beside the force of its teeth; by a last bit of
them it had counted as held under loads of fifteen times that.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")

# torque [N m], its rate [rad/s], bearing [N m], efficiencies: these had rested under their load, by one method or other
FOUND = [
    (1.13, 16.6, 0.06, 0.558, 0.891),
    (1.0160209841892238, 7.648030917683111, 0.06331599460365578, 0.5586885035228419, 0.7931998778918423),
    (1.1248467361072514, 14.407432503783808, 0.06230937907219328, 0.6389525161836058, 0.3251325946404738),
    (0.9297515730873982, 13.170746917967046, 0.07170213673193974, 0.5176831097351078, 0.771658641382587),
    (0.8598481917043939, 20.17252534172559, 0.07285583473338744, 0.3888397123398404, 0.5219874290233537),
    (1.5604981952686903, 26.366990857839923, 0.08620398082340322, 0.5520226862337377, 0.7825484498488382),
]


def _train() -> gb.Drivetrain:
    torque, rate = gb.Parameter("torque", 1.0, "N m"), gb.Parameter("rate", 10.0, "rad/s")
    bearing = gb.Parameter("bearing", 0.06, "N m")
    efficiency = (gb.Parameter("driving", 0.9, "1"), gb.Parameter("driven", 0.8, "1"))
    rig = gb.Drivetrain("reversal")
    one, other = rig.add("one", gb.Inertia(J=0.06)), rig.add("other", gb.Inertia(J=0.34))
    gear = rig.add("gear", gb.LossyGear(ratio=-1.0, efficiency=efficiency, bearing=(bearing, bearing)))
    load = rig.add("load", gb.Torque(tau=torque * gb.sin(rate * gb.time)))
    rig.chain(one, gear, other)
    rig.connect(other.b, load.flange)
    return rig


def _beyond(load: float, bearing: float, driving: float, driven: float) -> float:
    """By how much torque that enters at a, 0 at rest, leaves what sliding either way would ask for."""
    tau = -load
    asked = [
        (tau + sign * bearing) / driving if sign * tau + bearing >= 0 else (tau + sign * bearing) * driven
        for sign in (1, -1)
    ]
    return max(min(asked), -max(asked), 0.0)


def _rests(case: tuple[float, ...], method: str) -> list[tuple[float, float]]:
    """When the gear of a run comes to rest, and by how much its load is beyond what rests."""
    torque, rate, *losses = case
    values = dict(zip(("torque", "rate", "bearing", "driving", "driven"), case, strict=True))
    run = gb.simulate(_train(), t_end=4.0, method=method, rtol=1e-8, parameters=values)
    return [
        (event.t, _beyond(torque * float(np.sin(rate * event.t)), *losses))
        for event in run.events
        if event.component == "gear" and event.after == 0.0
    ]


@pytest.mark.parametrize("case", FOUND)
def test_it_rests_only_where_its_losses_hold_the_load(case: tuple[float, ...]) -> None:
    for method in METHODS:
        assert not [at for at, beyond in _rests(case, method) if beyond > 1e-6], method


@pytest.mark.long
def test_it_rests_only_where_it_can_in_trains_drawn_at_random() -> None:
    draw, rests = np.random.default_rng(7), 0
    for method, _ in itertools.product(METHODS, range(100)):
        case = tuple(float(x) for x in draw.uniform((0.3, 5.0, 0.0, 0.3, 0.3), (2.0, 30.0, 0.1, 0.98, 0.98)))
        found = _rests(case, method)
        rests += len(found)
        assert not [at for at, beyond in found if beyond > 1e-6], (case, method)
    assert rests > 10  # some do rest
