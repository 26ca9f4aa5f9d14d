"""A body that bounces on a stop where a law that holds it has its corner: every flight leaves both, and all end."""

import math

import numpy as np
import pytest

import gearblocks as gb

J, PUSH, K = 1.7, 0.5, 2080.0


def _rig(law, bound):
    """A spring in one of its forms, and a constant load, press a body on its stop, where the spring has no torque."""
    rig = gb.Drivetrain(law)
    body = rig.add("body", gb.Inertia(J=J, phi0=bound, w0=gb.Parameter("start", 1.0, "rad/s")))
    stop = rig.add("stop", gb.HardStop(restitution=gb.Parameter("kept", 0.3), lower=bound))
    load = rig.add("load", gb.Torque(tau=-PUSH))
    rig.connect(stop.a, body.a, load.flange)
    if law == "lash":
        spring = rig.add("spring", gb.Lash(k=K, half_gap=0.0))
    elif law == "table":
        spring = rig.add("spring", gb.Shaft(torque=gb.Table([-1.0, 0.0, 1.0], [-3 * K, 0.0, K])))
    else:
        twist = gb.sense("body.phi") - bound
        rig.connect(
            rig.add("spring", gb.Torque(tau=gb.piecewise((-K * twist, twist > 0.0), (-2 * K * twist, True)))).flange,
            body.b,
        )
    if law != "condition":
        rig.chain(rig.add("ground", gb.Fixed(phi0=bound)), spring, body)
    return rig


@pytest.mark.parametrize("law", ["lash", "table", "condition"])
@pytest.mark.parametrize("bound", [0.0, 0.3])
@pytest.mark.few(1)
def test_it_bounces_and_comes_to_rest(law, bound):
    """J x'' = -PUSH - K x in flight: 2/w atan(v K/(w PUSH)) long."""
    model, random, own = gb.build(_rig(law, bound)), np.random.default_rng(3), math.sqrt(K / J)
    for _ in range(40):
        start, kept = random.uniform(0.01, 1.0), random.uniform(0.2, 0.6)
        method, rtol = ["dp5", "dp8", "rodas", "auto"][random.integers(4)], 10 ** random.uniform(-8, -4)
        flights = [2 / own * math.atan(start * kept**n * K / (own * PUSH)) for n in range(60)]
        run = gb.simulate(
            model, t_end=sum(flights) + 0.05, parameters={"start": start, "kept": kept}, method=method, rtol=rtol
        )
        impacts = [e.t for e in run.events if e.kind == "impact"]
        assert len(impacts) >= 8, (start, kept, method, rtol)
        np.testing.assert_allclose(
            impacts, np.cumsum(flights)[: len(impacts)], rtol=20 * rtol, err_msg=f"{start} {kept} {method}"
        )
        assert (run["body.w"][-1], run["stop.contact"][-1]) == (0.0, -1.0)


# start speeds [rad/s], phase [rad], tolerance: of 300 at random, where flips at the corner were looked at from too far ahead
SHORT = [
    (-4.14, 0.765, 0.0, 1e-6),
    (4.699254132161325, 0.5209078996923999, 0.6951936748246219, 4.391450937933623e-08),
    (-3.4211899717373684, 0.28342525068615154, 2.522435431329242, 1.3592667730962366e-06),
    (1.4162009255551915, 0.5642517667667575, 4.076090299929202, 1.0381705498847679e-05),
]


@pytest.mark.parametrize(("first", "second", "phase", "rtol"), SHORT)
@pytest.mark.few(1)
def test_flights_that_are_shorter_than_a_look_ahead_end(first, second, phase, rtol):
    """A light body on a soft shaft lets steps be long; flights of 1e-9 s end in a row of flips that seem to be in vain."""
    rig = gb.Drivetrain("short flights")
    light, body = rig.add("light", gb.Inertia(J=0.0341, w0=first)), rig.add("body", gb.Inertia(J=1.7, w0=second))
    soft = gb.Table([-0.0647, 0.0, 0.0647], [-3.84, 0.0, 1.92], kind="cubic")
    shaft = rig.add("shaft", gb.Shaft(torque=soft, c=0.255))
    stop = rig.add("stop", gb.HardStop(restitution=0.327, lower=0.0))
    lash = rig.add("lash", gb.Lash(k=2080.0, half_gap=0.0))
    load = rig.add("load", gb.Torque(tau=10.9 * gb.sin(17.5 * gb.time + phase)))
    rig.connect(light.a, shaft.a)
    rig.connect(body.a, shaft.b, stop.a)
    rig.connect(body.b, lash.a, load.flange)
    rig.connect(lash.b, rig.add("ground", gb.Fixed()).flange)
    model = gb.build(rig)
    t = np.linspace(0.0, 2.9, 30)
    run, right = (gb.simulate(model, t=t, rtol=r, method=m) for r, m in ((rtol, "auto"), (1e-10, "dp5")))
    assert abs(run.energy.residual) < 10 * rtol
    for name in ("light.w", "body.w"):
        np.testing.assert_allclose(run[name], right[name], atol=100 * rtol * np.abs(right[name]).max())
