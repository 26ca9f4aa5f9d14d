"""A stop whose motion is given carries a body, which lets go while a clutch to another body slides or holds."""

import numpy as np
import pytest

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")


def _rig(given):
    """A stop between what is given and a body with friction; behind a clutch another one, in play of its own."""
    rig, size, rate = gb.Drivetrain("carried"), gb.Parameter("size", 1.0), gb.Parameter("rate", 2.0)
    phase = rate * gb.time
    motions = {
        "angle": lambda: gb.Angle(phi=size * gb.sin(phase)),
        "speed": lambda: gb.Speed(w=size * rate * gb.cos(phase)),
        "acceleration": lambda: gb.Acceleration(alpha=-size * rate**2 * gb.sin(phase), w0=size * rate),
    }
    motion = rig.add("motion", motions[given]())
    stop = rig.add("stop", gb.HardStop(lower=-0.2, upper=0.2, restitution=0.5))
    first, drag = rig.add("first", gb.Inertia(J=2.0)), rig.add("drag", gb.BearingFriction(coulomb=1.0))
    clutch = rig.add("clutch", gb.Clutch(capacity=5.0))
    second = rig.add("second", gb.Inertia(J=1.0, w0=gb.Parameter("start", -5.0)))
    play = rig.add("play", gb.Lash(k=gb.Parameter("k", 100.0), half_gap=0.1, c=0.1))
    rig.connect(motion.flange, stop.a, play.a)
    rig.connect(stop.b, first.a)
    rig.connect(first.b, drag.a, clutch.a)
    rig.connect(clutch.b, second.a)
    rig.connect(play.b, second.b)
    return rig


@pytest.mark.parametrize("given", ["angle", "speed", "acceleration"])
@pytest.mark.few(1)
def test_a_body_that_is_carried_moves_as_the_stop_until_it_lets_go(given):
    # an instant at which it was decided anew by a look ahead saw the stop strike at the speed that it has gained by then
    model, draw = gb.build(_rig(given)), np.random.default_rng(0)
    carried = 0
    for i in range(32):
        values = {
            "size": draw.uniform(0.5, 3),
            "rate": draw.uniform(1, 6),
            "start": draw.uniform(-6, 6),
            "k": draw.uniform(50, 1000),
        }
        method, rtol = METHODS[i % 4], 10 ** draw.uniform(-8, -4)
        run = gb.simulate(model, t_end=5.0, parameters=values, method=method, rtol=rtol)
        speed = values["size"] * values["rate"] * np.cos(values["rate"] * run.t)
        closed = run["stop.contact"] == 1.0
        carried += closed.sum()
        assert np.abs((run["first.w"] - speed) * closed).max() < 10 * rtol * np.abs(speed).max(), values
        assert abs(run.energy.residual) < 10 * rtol, values
    assert carried > 500
