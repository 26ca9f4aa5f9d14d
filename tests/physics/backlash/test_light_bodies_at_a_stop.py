"""A light body lies at a stop, unpressed, and is struck from the other side again and again: it stays, whatever rounding the
two impulses on it leave, which are large beside its inertia.

Independent: a ball on a wall, v_n = e v_(n-1) and t_n - t_(n-1) = 2 J v_n / tau.
"""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

GAP, TAU = 0.0062, 0.7


def _train(heavy: float, light: float, e: float, start: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("light at a stop")
    one = rig.add("one", gb.Inertia(J=heavy, phi0=0.4, w0=start))
    two = rig.add("two", gb.Inertia(J=light, phi0=0.456, w0=0.0))
    play = gb.Lash(k=1e6, lower=-GAP, contact_damping=gb.HuntCrossley(restitution=e))
    rig.chain(rig.add("load", gb.Torque(tau=TAU)), one, rig.add("play", play), two)
    rig.connect(two.b, rig.add("stop", gb.HardStop(restitution=0.0, upper=0.456)).a)
    return rig.without("play.compliance")


CASES = [
    tuple(float(x) for x in np.random.default_rng(i).uniform((2, 0.01, 0.5, 0.5), (6, 0.05, 0.97, 3))) for i in range(8)
]


@pytest.mark.parametrize(("heavy", "light", "e", "start"), CASES)
@pytest.mark.few(8)
def test_it_stays_where_it_lies(heavy: float, light: float, e: float, start: float) -> None:
    run = gb.simulate(_train(heavy, light, e, start), t_end=60.0, method="dp8", rtol=1e-9)
    hits = [x for x in run.events if x.kind == "impact" and x.component.startswith("play")]
    assert not [x for x in run.events if x.component.startswith("stop") and x.kind == "impact" and x.t > 0]
    assert len(hits) >= 2
    for n, hit in enumerate(hits[:6]):
        assert hit.after == pytest.approx(-e * hit.before, rel=1e-9)
        if n:
            assert hit.before == pytest.approx(-hits[n - 1].after, rel=1e-7)
            assert hit.t - hits[n - 1].t == pytest.approx(2 * heavy * hits[n - 1].after / TAU, rel=1e-7)
    assert np.max(np.abs(run["two.w"])) < 1e-9


@pytest.mark.parametrize("light", [1e-4, 1e-7, 1e-9])
def test_one_of_hardly_any_inertia_stays_as_well(light: float) -> None:
    """Impulses on it are 1e7 and more times as large, as accelerations, as those on what strikes it: solved to the end."""
    e = 1e-3
    rig = gb.Drivetrain("hardly any inertia")
    one, two = rig.add("one", gb.Inertia(J=1.0, phi0=-0.1, w0=1.0)), rig.add("two", gb.Inertia(J=light, w0=0.0))
    hit, stop = (rig.add(n, gb.HardStop(restitution=e, lower=0.0, upper=1.0)) for n in ("hit", "stop"))
    rig.chain(one, hit, two, stop, rig.add("ground", gb.Fixed()))
    run = gb.simulate(rig, t_end=0.2)
    assert run["one.w"][-1] == pytest.approx(-e, rel=1e-4) and run["two.w"][-1] == 0.0 and len(run.events) == 1
