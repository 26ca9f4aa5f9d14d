"""Runs that end within rounding of an event, before or behind it, and go on from there."""

import numpy as np
import pytest

import gearblocks as gb


def _pressed(stiffness):
    """A body between a spring and a rigid stop that it takes along as the load rises, until the spring pulls it back."""
    rig = gb.Drivetrain("pressed")
    body, taken = rig.add("body", gb.Inertia(J=2.0)), rig.add("taken", gb.Inertia(J=1.47))
    stop = rig.add("stop", gb.HardStop(restitution=0.0, upper=0.0, lower=-0.0706))
    spring, ground = rig.add("spring", gb.Shaft(k=stiffness)), rig.add("ground", gb.Fixed())
    load = rig.add("load", gb.Torque(tau=-17.5 * gb.tanh(12.3 * gb.time) ** 3))
    rig.connect(body.a, stop.a, spring.a, load.flange)
    rig.connect(taken.a, stop.b)
    rig.connect(spring.b, ground.flange)
    return gb.build(rig)


@pytest.mark.parametrize("method", ["dp8", "dp5", "rodas"])
@pytest.mark.parametrize("stiffness", [5000.0, 3000.0])
def test_a_stop_that_opens_as_the_run_ends(stiffness, method):
    """What the gap has moved by in 1e-10 s, 1e-28 rad, was taken for a way back, and the run stopped."""
    model = _pressed(stiffness)
    whole = gb.simulate(model, t_end=0.5, method=method, rtol=1e-7)
    opens = next(e.t for e in whole.events if e.component == "stop.upper")
    for after in (-1e-9, -1e-12, -1e-14, 0.0, 1e-14, 1e-12, 1e-9, 1e-7):
        first = gb.simulate(model, t_end=opens + after, method=method, rtol=1e-7)
        rest = gb.simulate(model, t_end=0.5, method=method, rtol=1e-7, initial=first)
        for name in ("body.w", "taken.w", "body.phi", "taken.phi"):
            assert rest[name][-1] == pytest.approx(whole[name][-1], rel=1e-5, abs=1e-6 * np.abs(whole[name]).max())
