"""Shafts without inertia between two gaps with clipped damping: where both are open nothing tells how fast they turn, and a run
stops by name. What has inertia does not feel how they do, as they pass a torque on only where both gaps press: with a little
drag on them the run is the limit of vanishing inertias."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 2.0, 101)
BETWEEN = {
    "nothing": lambda: None,
    "an ideal gear": lambda: gb.IdealGear(ratio=1.5),
    "a clutch": lambda: gb.Clutch(capacity=8.0),
    "a lossy gear without bearing torques": lambda: gb.LossyGear(ratio=1.5, efficiency=(0.9, 0.8)),
}


UNTOLD = r"nothing tells how fast its side . turns, .* contact_damping='always', .* a Damper to the ground"


def between_gaps(kind: str, beside: gb.Block | None) -> gb.Drivetrain:
    """Two bodies, two gaps, and what is between them, with something on each of its shafts."""
    rig = gb.Drivetrain(f"{kind} between gaps")
    one, other = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("other", gb.Inertia(J=2.0, w0=-1.0))
    first = rig.add("first", gb.Lash(k=1000.0, c=2.0, half_gap=0.05))
    second = rig.add("second", gb.Lash(k=400.0, c=1.0, half_gap=0.02))
    drive = rig.add("drive", gb.Torque(tau=12.0 * gb.sin(7.0 * gb.time)))
    rig.connect(drive.flange, one.a)
    rig.connect(one.b, first.a)
    rig.connect(other.a, second.b)
    block = BETWEEN[kind]()
    middle = rig.add("middle", block) if block is not None else None
    nodes = [(first.b, second.a)] if middle is None else [(first.b, middle.a), (middle.b, second.a)]
    for i, ends in enumerate(nodes):
        if beside is None:
            rig.connect(*ends)
            continue
        part = rig.add(f"beside{i}", beside)
        rig.connect(*ends, part.a)
        if isinstance(beside, gb.Damper):
            rig.connect(part.b, rig.add(f"ground{i}", gb.Fixed()).flange)
    return rig


@cache
def of_vanishing_inertias(kind: str) -> dict[str, np.ndarray]:
    """The speeds of both bodies with inertias on the shafts that go to zero."""
    light, lighter = (
        gb.simulate(between_gaps(kind, gb.Inertia(J=J)), t=T, method="rodas", rtol=1e-8) for J in (4e-6, 1e-6)
    )
    return {
        body: 2 * lighter[f"{body}.w"] - light[f"{body}.w"] for body in ("one", "other")
    }  # in powers of the root of J


@pytest.mark.parametrize("kind", [kind for kind in BETWEEN if "lossy" not in kind])
def test_where_nothing_tells_how_fast_it_turns_the_run_stops_by_name_with_what_helps(kind: str) -> None:
    with pytest.raises(gb.SimulationError, match=UNTOLD):
        gb.simulate(between_gaps(kind, None), t=T)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
@pytest.mark.parametrize("method", ["auto", "dp8", "dp5", "rodas"])
def test_beside_a_lossy_gear_it_stops_by_name_or_is_right_where_no_step_ends_between_the_gaps(
    method: str, rtol: float
) -> None:
    """A gear between two gaps passes both in an instant, and with some steps none of its modes is the one of nothing."""
    kind = "a lossy gear without bearing torques"
    untold = ""
    try:
        run = gb.simulate(between_gaps(kind, None), t=T, method=method, rtol=rtol)
    except gb.SimulationError as stop:
        untold, run = str(stop), stop.trajectory
    assert not untold or re.search(UNTOLD, untold)
    for body, limit in of_vanishing_inertias(kind).items():
        assert np.abs(run[f"{body}.w"] - limit[: len(run.t)]).max() < 5e-4 * np.abs(limit).max()


def test_where_a_lossy_gear_elsewhere_has_no_motion_either_the_shaft_is_named():
    rig = between_gaps("an ideal gear", None)
    rig.connect(rig.add("wheel", gb.LossyGear(ratio=4.0, efficiency=(0.8, 0.6))).b, rig["one"].b)
    rig.connect(rig["wheel"].a, rig.add("third", gb.Inertia(J=0.1, w0=8.0)).a)
    with pytest.raises(gb.SimulationError, match=r"'(first|second)': nothing tells how fast its side . turns"):
        gb.simulate(rig, t=T)


@pytest.mark.parametrize("kind", BETWEEN)
@pytest.mark.few(2)
def test_with_a_little_drag_it_is_the_limit_of_vanishing_inertias(kind: str) -> None:
    run = gb.simulate(between_gaps(kind, gb.Damper(c=1e-5)), t=T)
    for body, limit in of_vanishing_inertias(kind).items():
        assert np.abs(run[f"{body}.w"] - limit).max() < 3e-4 * np.abs(limit).max()
