"""What a one-way clutch holds is struck the way that it blocks, again and again, and does not give way, whatever rounding
the impacts leave of its slip: a hammer bounces on it as on a wall.
"""

import numpy as np
import pytest

import gearblocks as gb

MU = gb.Table([0.0, 4.0, 10.0], [0.389, 0.272, 0.233])
CLUTCHES = {
    "capacity": lambda: gb.OneWayClutch(capacity=0.3),
    "engagement that goes": lambda: gb.OneWayClutch(mu=0.389, force_max=7.6, engagement=1.0 * gb.sin(5 * gb.time)),
    "table": lambda: gb.OneWayClutch(mu=MU, force_max=7.6, engagement=1.0 * gb.sin(5 * gb.time)),
    "freewheel": lambda: gb.Freewheel(),
}
GAP = 0.043


def _rig(clutch, turned):
    rig = gb.Drivetrain("anvil")
    held, ground = rig.add("anvil", gb.Inertia(J=1.0)), rig.add("ground", gb.Fixed())
    holds, body = rig.add("clutch", CLUTCHES[clutch]()), rig.add("hammer", gb.Inertia(J=1.0))
    impacts = gb.HuntCrossley(restitution=1.0)
    play = rig.add("play", gb.Lash(k=1e6, half_gap=GAP, contact_damping=impacts))
    push = rig.add("push", gb.Torque(tau=-0.38 if turned else 0.38))
    weight = rig.add("weight", gb.Torque(tau=gb.Parameter("weight", 1.0, "N m")))
    rig.connect(held.a, holds.b if turned else holds.a, play.a, push.flange)
    rig.connect(ground.flange, holds.a if turned else holds.b)
    rig.connect(body.a, play.b, weight.flange)
    return rig.without("play.compliance")


def _fall(t, rate):
    """Angle of what falls through GAP and bounces without loss."""
    speed = np.sqrt(2.0 * rate * GAP)
    since = np.mod(t - speed / rate, 2.0 * speed / rate)
    return np.where(t < speed / rate, 0.5 * rate * t**2, GAP - speed * since + 0.5 * rate * since**2)


@pytest.mark.parametrize("clutch", CLUTCHES)
@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.few(1)
def test_a_hammer_bounces_on_it_as_on_a_wall(clutch, turned):
    t, model, side = np.linspace(0.0, 3.0, 301), gb.build(_rig(clutch, turned)), -1.0 if turned else 1.0
    for anvil, hammer, load in ((0.0582, 2.45, 119.3), (0.31, 0.7, 3.1), (0.0107, 0.0613, 7.7), (1.9, 3.3, 1.234)):
        values = {"anvil.J": anvil, "hammer.J": hammer, "weight": load * side}
        for method in ("dp8", "rodas"):
            run = gb.simulate(model, t=t, rtol=1e-9, method=method, parameters=values)
            assert np.abs(side * run["hammer.phi"] - _fall(t, load / hammer)).max() < 1e-6 * GAP
            assert np.abs(run["anvil.w"]).max() < 1e-12
