"""Stops that a load hammers against friction: infinitely many impacts in a finite time, in closed form."""

import itertools
import math

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas", "auto"]
ROOM = 0.2


def _rig(load, dry, restitution, friction):
    """A body of 1 kg m2 that a torque presses against its stop, beside dry friction."""
    rig = gb.Drivetrain("hammer")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.chain(rig.add("drive", gb.Torque(tau=load)), body)
    rig.connect(rig.add("stop", gb.HardStop(upper=ROOM, restitution=restitution)).a, body.b)
    if friction == "brake":
        rig.connect(rig.add("dry", gb.Brake(capacity=dry)).a, body.b)
    elif friction == "bearing":
        rig.connect(rig.add("dry", gb.BearingFriction(coulomb=dry)).a, body.b)
    else:
        rig.connect(rig.add("dry", gb.SpeedLoad(coeffs=(dry, 0.0, 0.0))).flange, body.b)
    return rig


def _end(load, dry, restitution):
    """When the impacts end: speeds fall by restitution sqrt((load - dry)/(load + dry)), and so do the flights."""
    into, away = load - dry, load + dry
    first = math.sqrt(2 * ROOM / into)
    speed = restitution * into * first
    flight = speed / away + math.sqrt(speed**2 / away / into)
    return first + flight / (1 - restitution * math.sqrt(into / away))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("load", "dry", "restitution", "friction"),
    [
        (5.384, 1.0, 0.9, "brake"),
        (5.384, 1.0, 0.9, "load"),
        (3.0, 2.0, 0.95, "bearing"),
        (1.0, 0.5, 1.0, "brake"),
        (8.0, 0.3, 0.243, "load"),
    ],
)
@pytest.mark.few(1)
def test_impacts_against_friction_end_when_the_sum_of_the_flights_does(load, dry, restitution, friction, method):
    end = _end(load, dry, restitution)
    rig = _rig(load, dry, restitution, friction)
    run = gb.simulate(rig, t=[0.0, 0.9 * end, end + 1e-6, end + 2.0], method=method, rtol=1e-9)
    impacts = [e for e in run.events if e.kind == "impact"]
    assert impacts[-1].t == pytest.approx(end, abs=1e-6)  # flights lower than the rounding of 0.2 rad end in rest
    falls = [after.before / before.before for before, after in itertools.pairwise(impacts[:8])]
    assert falls == pytest.approx([restitution * math.sqrt((load - dry) / (load + dry))] * len(falls), rel=1e-6)
    assert list(run["body.w"][2:]) == [0.0, 0.0]
    assert list(run["stop.contact"][2:]) == [1.0, 1.0]
    assert run["body.phi"][-1] == pytest.approx(ROOM, rel=1e-14)
    assert len(run.events) < 400


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_bounces_die_out_behind_a_spring(method):
    """A body between stops on a shaft, with friction beside; the flights die out within steps of the vibration."""
    rig = gb.Drivetrain("sprung")
    near, far = rig.add("near", gb.Inertia(J=0.05, w0=-7.0)), rig.add("far", gb.Inertia(J=0.12))
    rig.chain(
        rig.add("drive", gb.Torque(tau=20 + gb.sin(10 * gb.time))), near, rig.add("shaft", gb.Shaft(k=60.0, c=0.1)), far
    )
    rig.connect(rig.add("stop", gb.HardStop(lower=-0.3, upper=0.2, restitution=0.243)).a, far.b)
    rig.connect(rig.add("brake", gb.Brake(capacity=0.7)).a, far.b)
    run = gb.simulate(rig, t=np.linspace(0, 2, 21), method=method, rtol=1e-8)
    fine = gb.simulate(rig, t=np.linspace(0, 2, 21), method="dp5", rtol=1e-10, max_step=2e-4)
    assert np.max(np.abs(run["near.phi"] - fine["near.phi"])) < 1e-5
    assert len(run.events) < 2000
