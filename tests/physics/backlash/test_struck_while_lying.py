"""A body that lies at its stop, pressed by nothing any more, is struck: the stop is there, whatever its gap is rounded to."""

import math

import numpy as np
import pytest

import gearblocks as gb

E, GAP, FAR = 0.6, 5.0, 500.0


def _rig(kind):
    """A body comes to its stop, is pressed there in passing by another one, and struck across a rigid gap by a third."""
    rig = gb.Drivetrain(kind)
    lying = rig.add("lying", gb.Inertia(J=0.7, phi0=gb.Parameter("from", 0.1), w0=gb.Parameter("fast", 2.0)))
    striker = rig.add("striker", gb.Inertia(J=0.3, phi0=gb.Parameter("away", 0.0), w0=gb.Parameter("hits", 0.1)))
    pusher = rig.add("pusher", gb.Inertia(J=0.02, phi0=gb.Parameter("behind", 0.0), w0=gb.Parameter("passes", 1.0)))
    stop = rig.add("stop", gb.HardStop(upper=gb.Parameter("bound", 0.4), restitution=0.0))
    flank = rig.add("flank", gb.Lash(k=1.0, half_gap=GAP, contact_damping=gb.HuntCrossley(restitution=E)))
    spring = rig.add("spring", gb.Lash(k=40.0, half_gap=FAR))
    rig.connect(lying.b, stop.a, spring.b)
    rig.connect(pusher.a, spring.a)
    if kind == "gear":
        gear = rig.add("gear", gb.IdealGear(ratio=-3.0))
        rig.connect(lying.a, gear.a)
        rig.connect(gear.b, flank.b)
    elif kind == "planetary":  # its ring is held
        planetary = rig.add("planetary", gb.IdealPlanetary(ratio=2.0))
        rig.connect(lying.a, planetary.sun)
        rig.connect(planetary.carrier, flank.b)
        rig.connect(planetary.ring, rig.add("ground", gb.Fixed()).flange)
    else:
        rig.connect(lying.a, flank.b)
    rig.connect(striker.a, flank.a)
    return rig.without("flank.compliance")


@pytest.mark.parametrize(("kind", "ratio"), [("direct", 1.0), ("gear", -1 / 3), ("planetary", 1 / 3)])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.few(1)
def test_the_striker_bounces_as_off_a_wall(kind, ratio, method):
    model, random = gb.build(_rig(kind)), np.random.default_rng(5)
    for _ in range(40):
        bound, ahead, fast = random.uniform(0.05, 3.0), random.uniform(0.05, 0.5), random.uniform(1.0, 3.0)
        passes, meets = random.uniform(0.5, 3.0), 40.0
        behind = bound + FAR - passes * random.uniform(1.0, 3.0)  # its spring is met later
        hits = math.copysign(random.uniform(0.05, 0.2) * abs(ratio), ratio)
        away = ratio * bound + math.copysign(GAP, hits) - hits * meets
        values = {"from": bound - ahead, "fast": fast, "bound": bound, "away": away, "hits": hits}
        values |= {"behind": behind, "passes": passes}
        run = gb.simulate(model, t_end=meets + 1.0, parameters=values, method=method, rtol=10 ** random.uniform(-9, -4))
        assert abs(run["lying.w"][-1]) < 1e-12 * fast, values
        assert run["striker.w"][-1] == pytest.approx(-E * hits, rel=1e-9), values


@pytest.mark.parametrize("J", [0.055, 0.07, 0.31])
@pytest.mark.parametrize("e", [0.1, 0.4, 1.0])
@pytest.mark.parametrize("gear", [False, True])
def test_what_is_struck_against_a_stop_with_a_damper_behind_stays_there(J, e, gear):
    """A body that lies unpressed at a stop and is struck towards it: what rounding leaves of its speed is no motion, that
    the damper would turn into a force that opens the stop."""
    rig = gb.Drivetrain("struck at rest")
    hammer, anvil = rig.add("hammer", gb.Inertia(J=0.0364, w0=7.4)), rig.add("anvil", gb.Inertia(J=J))
    stop, damper = rig.add("stop", gb.HardStop(upper=0.0, restitution=0.8)), rig.add("damper", gb.Damper(c=0.0436))
    if gear:
        gap = gb.GearMesh(
            teeth=(23, 31), external=False, r_base=(0.02, 0.02 * 31 / 23), backlash=gb.Backlash(half_gap=0.00212),
            contact_damping=gb.HuntCrossley(restitution=e),
        )  # fmt: skip
        mesh = rig.add("gap", gap)
        rig.connect(hammer.a, mesh.pinion)
        rig.connect(anvil.a, mesh.wheel, stop.a)
    else:
        gap = rig.add("gap", gb.HardStop(lower=-0.106, restitution=e))
        rig.connect(hammer.a, gap.a)
        rig.connect(anvil.a, gap.b, stop.a)
    rig.connect(anvil.b, damper.a)
    rig.connect(damper.b, rig.add("wall", gb.Fixed()).flange)
    for method in ("auto", "rodas"):
        run = gb.simulate(rig, t_end=0.02, method=method)
        assert run["anvil.w"][-1] == 0.0
        assert run["hammer.w"][-1] == pytest.approx(-7.4 * e, abs=1e-12), method
        assert [event.component for event in run.events] == ["gap.upper" if gear else "gap.lower"]
