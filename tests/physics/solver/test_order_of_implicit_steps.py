"""rodas keeps its order where the motion hangs on forces of constraints: rows that change with the position, losses that change
with the speed, alone and together; where a torque reads what a flange feels; and where what holds follows a filter.

Independent: dp8, whose steps know no derivative; halving a step divides the error by 2^5, by 2^2 with a derivative missing.
"""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 1.0, 6)
TABLE = ((0.0, 0.9, 0.8, 0.1, 0.1), (20.0, 0.6, 0.5, 0.5, 0.5))


def _pair(capacity: float, *, losses: bool = False) -> gb.Drivetrain:
    """A clutch behind a non-circular pair, held or slipping throughout; and a gear with losses by speed behind that."""
    rig = gb.Drivetrain("clutch behind a varying ratio")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.3), ("two", 0.2), ("three", 0.1)))
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.25, order=1), external=True))
    rig.chain(
        rig.add("drive", gb.Torque(tau=1.0)), one, pair, two, rig.add("clutch", gb.Clutch(capacity=capacity)), three
    )
    rig.connect(three.b, rig.add("load", gb.Torque(tau=-0.4 + 0.1 * gb.sin(3 * gb.time))).flange)
    if losses:
        gear = rig.add("gear", gb.LossyGear(ratio=-2.0, loss_table=TABLE))
        rig.chain(three, gear, rig.add("four", gb.Inertia(J=0.05)))
    return rig


def _gear(varying: bool) -> gb.Drivetrain:
    """A lossy gear whose losses go with the speed, straight or behind a non-circular pair."""
    rig = gb.Drivetrain("losses by speed")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.1), ("two", 0.3), ("three", 0.2)))
    gear = rig.add("gear", gb.LossyGear(ratio=1.5, loss_table=TABLE))
    law = gb.RatioLaw.ellipse(e=0.25, order=1)
    pair = rig.add("pair", gb.NonCircularGear(law=law, external=True) if varying else gb.Shaft(k=40.0, c=0.2))
    rig.chain(rig.add("drive", gb.Torque(tau=3.0)), one, pair, two, gear, three)
    rig.chain(three, rig.add("load", gb.Damper(c=0.3)), rig.add("ground", gb.Fixed()))
    return rig


def _fed(signal: object) -> gb.Drivetrain:
    """Two bodies and a shaft, with a torque that reads what a flange of the shaft feels."""
    rig = gb.Drivetrain("fed back")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=0.7))
    shaft = rig.add("shaft", gb.Shaft(k=356.0, c=2.48))
    rig.chain(rig.add("motor", gb.Torque(tau=2.0 + signal)), one, shaft, two)
    rig.chain(two, rig.add("load", gb.Damper(c=0.3)), rig.add("ground", gb.Fixed()))
    return rig


def _filtered(source: gb.Block) -> gb.Drivetrain:
    """A clutch holds a body to a motion that follows from the states of a filter; another swings behind it."""
    rig = gb.Drivetrain("behind a filter")
    rotor, held, one = (rig.add(n, gb.Inertia(J=J)) for n, J in (("rotor", 0.3), ("held", 0.2), ("one", 0.1)))
    rig.chain(rig.add("source", source), rotor, rig.add("clutch", gb.Clutch(capacity=90.0)), held)
    rig.chain(held, rig.add("shaft", gb.Shaft(k=40.0, c=0.2)), one, rig.add("load", gb.Torque(tau=-0.4)))
    return rig


_WAVE, _ANGLE = 3.0 + gb.sin(2 * gb.time), gb.sin(2 * gb.time)

CASES = {
    "held to a filtered speed": (
        lambda: _filtered(gb.Speed(w=_WAVE, filter=8.0)),
        "clutch",
        {"held.w": 3.0, "one.w": 3.0},
    ),
    "held to a smooth speed": (
        lambda: _filtered(gb.Speed(w=_WAVE, filter=8.0, filter_type="bessel")),
        "clutch",
        {"held.w": 3.0, "one.w": 3.0},
    ),
    "held to a filtered angle": (lambda: _filtered(gb.Angle(phi=_ANGLE, filter=12.0)), "clutch", {}),
    "a clutch that holds": (lambda: _pair(5.0), "clutch", {"one.w": 8.0}),
    "a clutch that slips": (lambda: _pair(0.05), "clutch", {"one.w": 8.0}),
    "losses by speed": (lambda: _gear(False), "gear", {"one.w": 12.0}),
    "losses by speed behind a varying ratio": (lambda: _gear(True), "gear", {"one.w": 12.0}),
    "all of these, held": (lambda: _pair(5.0, losses=True), "clutch", {"one.w": 8.0}),
    "a torque of a flange fed back": (lambda: _fed(-0.5 * gb.sense("shaft.a.tau")), "", {"one.w": 4.0}),
    "a power of a flange fed back": (lambda: _fed(-9 * gb.tanh(0.012 * gb.sense("shaft.a.power"))), "", {"one.w": 4.0}),
}


@pytest.mark.parametrize("name", CASES)
def test_half_the_step_divides_the_error_by_what_its_order_says(name: str) -> None:
    make, part, start = CASES[name]
    initial = gb.rolling(start)
    true = gb.simulate(make(), t=T, method="dp8", rtol=1e-12, initial=initial)
    assert not [e for e in true.events if e.component == part and e.t > 1e-9]  # one mode throughout
    size = np.max(np.abs(true["one.w"]))
    errors = [
        np.max(np.abs(gb.simulate(make(), t=T, method="rodas", step=step, initial=initial)["one.w"] - true["one.w"]))
        / size
        for step in (0.02, 0.01)
    ]
    assert errors[0] < 1e-4 and errors[1] < max(errors[0] / 14.0, 1e-11), errors
