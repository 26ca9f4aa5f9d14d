"""Conditions of outputs that other laws read: they are located as those of the laws themselves. In closed form."""

import math

import pytest
import sympy as sp

import gearblocks as gb

J, FULL = 2.0, 50.0
METHODS = [("dp5", 1e-7), ("dp8", 1e-6), ("rodas", 1e-6), ("auto", 1e-4)]


class Shown(gb.Block):
    """Shows a law of the speed; acts on nothing."""

    flange = gb.Flange("shaft")
    limit: float = gb.param("speed", "rad/s")
    kind: str = gb.option("which law: jump, corner or floor", default="jump")

    def physics(self, s):
        w = s.flange.w
        laws = {
            "jump": sp.Piecewise((1.0, w < s.limit), (0.25, True)),
            "corner": 1 - sp.Max(w - s.limit, 0) / s.limit,
            "floor": 1 - sp.floor(w / s.limit) / 4,
        }
        yield gb.Shows("value", laws[self.kind])


class Passed(gb.Block):
    """Shows what it reads, where that is not below a quarter."""

    flange = gb.Flange("shaft")
    u = gb.signal("what it reads")

    def physics(self, s):
        yield gb.Shows("value", sp.Max(s.u, 0.25))


def _rig(block, name, passed=False):
    rig = gb.Drivetrain("sensed")
    body = rig.add("body", gb.Inertia(J=J))
    rig.connect(body.a, rig.add("law", block).flange)
    rig.connect(body.b, rig.add("drive", gb.Torque(tau=FULL * gb.sense(name))).flange)
    if passed:
        rig.connect(body.b, rig.add("passed", Passed(u=gb.sense("law.value"))).flange)
    return rig


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.parametrize("gain", [0.2, 5.0, 200.0])
@pytest.mark.few(3)
def test_a_governor_leaves_its_limit_where_it_does(gain, method, rtol):
    """Full torque until gain (target - w) + bias = 1, then exponentially to the droop."""
    target, bias = 10.0, 0.2
    first, last, rate = target - (1 - bias) / gain, target + bias / gain, FULL * gain / J
    left = first * J / FULL
    rig = _rig(gb.Governor(target=target, gain=gain, bias=bias), "law.command")
    end = left + 2.0 / rate
    run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
    assert [e.t for e in run.events] == pytest.approx([left], rel=10 * rtol)
    assert run["body.w"][-1] == pytest.approx(last - (last - first) * math.exp(-2.0), rel=10 * rtol)
    assert run["law.command"][-1] == pytest.approx(
        gain * (last - first) * math.exp(-2.0), rel=10 * rtol * gain * target
    )
    assert run.energy.residual <= 10 * rtol


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.parametrize("kind", ["jump", "corner", "floor"])
@pytest.mark.parametrize("passed", [False, True])
@pytest.mark.few(1)
def test_an_output_of_a_block_is_located(passed, kind, method, rtol):
    """J w' = FULL v(w): straight with a jump or a floor, an exponential behind a corner; read directly and through another."""
    limit, straight = 3.0, 3.0 * J / FULL
    rig = _rig(Shown(limit=limit, kind=kind), "passed.value" if passed else "law.value", passed)
    after = {"jump": 4 * straight, "floor": straight / 0.75 + straight / 0.5, "corner": straight / 2}[kind]
    ends = {"jump": 2 * limit, "floor": 3 * limit, "corner": limit * (2 - math.exp(-0.5))}[kind]
    run = gb.simulate(rig, t_end=straight + after, method=method, rtol=rtol)
    assert run.events[0].t == pytest.approx(straight, rel=10 * rtol)
    assert run["body.w"][-1] == pytest.approx(ends, rel=10 * rtol)
    assert run.energy.residual <= 10 * rtol


def test_an_output_that_nobody_reads_locates_nothing():
    """It has its jump, but no event and no steps of its own."""
    rig = gb.Drivetrain("unread")
    body = rig.add("body", gb.Inertia(J=J))
    rig.connect(body.a, rig.add("law", Shown(limit=3.0)).flange)
    rig.connect(body.b, rig.add("drive", gb.Torque(tau=FULL)).flange)
    run = gb.simulate(rig, t_end=1.0)
    assert not run.events
    assert (run["law.value"][0], run["law.value"][-1]) == (1.0, 0.25)
