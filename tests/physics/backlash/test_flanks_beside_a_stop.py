"""A stop where a contact whose damping is clipped begins: both laws change at one instant, in closed form."""

import cmath
import math

import pytest

import gearblocks as gb

J, K = 0.5, 2000.0


def _flight(damping_ratio):
    """From x = 0 at the speed -1: J x'' = -K x - c x' until its force is 0, then free to x = 0: its time and its speed there.

    x = (exp(r t) - exp(q t)) / (q - r), and x'' = 0 at t = 2 ln(q/r) / (r - q).
    """
    c = 2 * damping_ratio * math.sqrt(K * J)
    root = cmath.sqrt(c**2 / 4 / J**2 - K / J)
    r, q = -c / 2 / J + root, -c / 2 / J - root
    t = 2 * cmath.log(q / r) / (r - q)
    x, w = (cmath.exp(r * t) - cmath.exp(q * t)) / (q - r), (r * cmath.exp(r * t) - q * cmath.exp(q * t)) / (q - r)
    return c, t.real - x.real / w.real, w.real


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("restitution", [0.3, 0.8])
@pytest.mark.parametrize("damping_ratio", [0.2, 0.7, 1.3, 3.0])
@pytest.mark.parametrize("ratio", [1.0, -0.5])
@pytest.mark.few(1)
def test_a_body_between_a_stop_and_a_damped_flank(ratio, damping_ratio, restitution, method):
    """All flights last as long, each impact is slower by the same factor."""
    c, time, kept = _flight(damping_ratio)
    rig = gb.Drivetrain("stop beside a flank")
    body = rig.add("body", gb.Inertia(J=J, w0=-1.0))
    rig.connect(rig.add("stop", gb.HardStop(upper=0.0, restitution=restitution)).a, body.a)
    gear = rig.add("gear", gb.IdealGear(ratio=ratio))
    lash = rig.add("flank", gb.Lash(k=K * ratio**2, half_gap=0.0, c=c * ratio**2, contact_damping="clipped_force"))
    rig.connect(body.a, gear.a)
    rig.connect(gear.b, lash.a)
    rig.connect(lash.b, rig.add("ground", gb.Fixed()).flange)
    run = gb.simulate(rig, t_end=5.5 * time, method=method, rtol=1e-9)
    impacts = [e for e in run.events if e.kind == "impact"]
    assert len(impacts) == 5
    for n, impact in enumerate(impacts):
        speed = kept * (restitution * kept) ** n
        assert impact.t == pytest.approx((n + 1) * time, abs=3e-8 / speed * time)
        assert impact.before == pytest.approx(-speed, abs=3e-8)
    assert {e.after for e in run.events if e.component == "flank.pushing"} <= {0.0, 1.0}


@pytest.mark.long
@pytest.mark.parametrize(("method", "rtol"), [("dp5", 1e-8), ("dp8", 1e-6), ("rodas", 1e-6)])
def test_a_stop_of_which_nothing_is_asked_costs_nothing(method, rtol):
    """While the contact that presses a body on its stop lets go but has not parted, the force of the stop is exactly 0: its
    enclosure has a width, and each step took 20000 pieces (0.1 s, of a run of 1 ms)."""

    def run(method, rtol):
        rig = gb.Drivetrain("idle stop")
        striker, held = rig.add("striker", gb.Inertia(J=2.0, w0=3.0)), rig.add("held", gb.Inertia(J=0.3))
        hit = gb.HuntCrossley(restitution=0.6)
        rig.chain(striker, rig.add("contact", gb.Lash(k=1e4, half_gap=0.01, contact_damping=hit)), held)
        rig.connect(held.b, rig.add("stop", gb.HardStop(upper=0.0, restitution=0.0)).a)
        rig.connect(striker.a, rig.add("load", gb.Torque(tau=20.0 + 60 * gb.sin(20 * gb.time))).flange)
        return gb.simulate(rig, t_end=1.0, method=method, rtol=rtol)

    found, fine = run(method, rtol), run("dp8", 1e-10)
    assert found.stats.cpu_seconds < 0.05
    assert [e.component for e in found.events] == [e.component for e in fine.events]
    assert found["striker.w"][-1] == pytest.approx(fine["striker.w"][-1], abs=1e-4)
