"""Implicit steps of trains in which friction or stops hold a body under load: what is behind it stays at rest, exactly.

A force on a held body has no way past it. Where the step matrix lets it through and cancels it afterwards, rounding is left,
and a body that rests on a contact without a gap takes part in impacts of 1e-20 rad/s.
"""

import math

import pytest

import gearblocks as gb

CONTACTS = {
    "spring": {"c": 0.5, "contact_damping": "always"},
    "restitution": {"contact_damping": gb.HuntCrossley(restitution=0.7)},
    "clipped": {"c": 0.5, "contact_damping": "clipped_force"},
}


def _rig(holder, contact, load, ratio=None):
    """load - striker - play - held body - shaft - body behind - contact without a gap - ground."""
    rig = gb.Drivetrain("held")
    striker = rig.add("striker", gb.Inertia(J=0.8, w0=3.0))
    held = rig.add("held", gb.Inertia(J=0.1))
    behind = rig.add("behind", gb.Inertia(J=1.4))
    play = rig.add("play", gb.Lash(k=350.0, half_gap=0.002))
    shaft = rig.add("shaft", gb.Shaft(k=1.5, c=0.01))
    rest = rig.add("rest", gb.Lash(k=140.0, half_gap=0.0, **CONTACTS[contact]))
    rig.connect(striker.a, play.a)
    rig.connect(held.a, play.b)
    rig.connect(held.b, rig.add("load", gb.Torque(tau=load)).flange)
    if ratio is None:
        rig.connect(held.b, shaft.a)
    else:
        gear = rig.add("gear", gb.IdealGear(ratio=ratio))
        rig.connect(held.b, gear.a)
        rig.connect(gear.b, shaft.a)
    rig.connect(behind.a, shaft.b)
    rig.connect(behind.b, rest.a)
    rig.connect(rest.b, rig.add("ground", gb.Fixed()).flange)
    if holder == "stop":
        rig.connect(held.b, rig.add("holder", gb.HardStop(upper=0.0, restitution=0.0)).a)
    elif holder in ("brake", "brake, losses apart"):
        rig.connect(held.b, rig.add("holder", gb.Brake(capacity=1e4)).a)
    elif holder == "bearing":
        rig.connect(held.b, rig.add("holder", gb.BearingFriction(coulomb=1e4)).a)
    else:
        between = rig.add("between", gb.Inertia(J=0.3))
        clutch = rig.add("clutch", gb.Clutch(capacity=1e4))
        rig.connect(held.b, clutch.a)
        rig.connect(clutch.b, between.a)
        rig.connect(between.b, rig.add("holder", gb.Brake(capacity=1e4)).a)
    if holder == "brake, losses apart":  # a train of its own, whose locks are no ties
        gear = gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.85))
        rig.chain(
            rig.add("drive", gb.Torque(tau=1.0)), rig.add("one", gb.Inertia(J=0.2, w0=2.0)), rig.add("lossy", gear),
            rig.add("two", gb.Inertia(J=0.3, w0=1.0)),
        )  # fmt: skip
    return rig


@pytest.mark.parametrize("contact", CONTACTS)
@pytest.mark.parametrize(
    ("holder", "ratio"),
    [
        ("brake", None),
        ("brake, losses apart", None),
        ("bearing", None),
        ("clutch", None),
        ("stop", None),
        ("brake", 2.7),
    ],
)
@pytest.mark.few(1)
def test_nothing_moves_behind_what_is_held(holder, ratio, contact):
    load = 1.6 * gb.sin(12.1 * gb.time) + (100.0 if holder == "stop" else 0.0)  # more than the striker pulls
    run = gb.simulate(_rig(holder, contact, load, ratio), t_end=1.0, method="rodas")
    assert set(run["behind.w"]) == set(run["behind.phi"]) == {0.0}
    assert {e.component for e in run.events} == {"play"}
    period = math.pi / math.sqrt(350.0 / 0.8)  # in contact; then back through the play at the speed of the start
    starts = [e.t for e in run.events if e.before == 0.0]
    ends = [e.t for e in run.events if e.after == 0.0]
    assert [b - a for a, b in zip(starts, ends, strict=False)] == pytest.approx([period] * len(ends), rel=1e-6)
    assert [b - a for a, b in zip(ends, starts[1:], strict=False)] == pytest.approx(
        [0.004 / 3] * len(starts[1:]), rel=1e-4
    )
