"""Inputs that are functions and jump at times that nobody announces: each jump ends a step there, as a knot of a table does.

Closed form: constant torques.
"""

import math

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["auto", "dp5", "dp8", "rodas"]
T = np.linspace(0.0, 2.0, 21)
AT = 0.7371


def _flywheel(brake=None, *, load):
    rig = gb.Drivetrain("flywheel")
    body, torque = rig.add("body", gb.Inertia(J=2.0)), rig.add("torque", gb.Torque(tau=load))
    rig.connect(body.a, torque.flange)
    if brake is not None:
        held = rig.add("brake", gb.Brake(capacity=brake))
        rig.connect(body.b, held.a)
        rig.connect(held.housing, rig.add("ground", gb.Fixed()).flange)
    return rig


def _square(t):
    half = math.pi / 7
    return np.array([1.5 * (x % (2 * half) if x % (2 * half) < half else 2 * half - x % (2 * half)) for x in t])


CASES = {
    "a step from rest": (
        lambda: _flywheel(load=gb.Input("u")),
        lambda t: 3.0 * (t >= AT),
        lambda t: 1.5 * np.maximum(t - AT, 0.0),
        1,
    ),
    "a small step": (
        lambda: _flywheel(load=gb.Input("u")),
        lambda t: 3e-9 * (t >= AT),
        lambda t: 1.5e-9 * np.maximum(t - AT, 0.0),
        1,
    ),
    "a square wave": (
        lambda: _flywheel(load=gb.Input("u")),
        lambda t: math.copysign(3.0, math.sin(7 * t)),
        _square,
        4,
    ),
    "a capacity that falls": (
        lambda: _flywheel(gb.Input("u"), load=5.0),
        lambda t: 9.0 if t < AT else 1.0,
        lambda t: 2.0 * np.maximum(t - AT, 0.0),
        1,
    ),
    "a load beyond what is held": (
        lambda: _flywheel(2.0, load=gb.Input("u")),
        lambda t: 3.0 * (t >= AT),
        lambda t: 0.5 * np.maximum(t - AT, 0.0),
        1,
    ),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rtol", [1e-4, 1e-9])
@pytest.mark.parametrize("case", CASES)
def test_a_function_that_jumps_is_followed_to_rounding(case, rtol, method):
    rig, function, speed, jumps = CASES[case]
    run = gb.simulate(rig(), t=T, method=method, rtol=rtol, inputs={"u": function})
    exact = speed(T)
    assert run["body.w"] == pytest.approx(exact, abs=1e-12 * exact.max())
    told = [e for e in run.events if e.kind == "time"]
    assert len(told) == jumps
    assert run.stats.steps < 20 and run.energy.residual < 1e-12


def test_two_that_jump_in_one_step_do_so_in_turn():
    rig = _flywheel(load=gb.Input("u"))
    rig.connect(rig["body"].b, rig.add("other", gb.Torque(tau=gb.Input("v"))).flange)
    run = gb.simulate(rig, t=T, inputs={"u": lambda t: 3.0 * (t >= AT), "v": lambda t: 1.0 * (t >= AT + 1e-3)})
    exact = 1.5 * np.maximum(T - AT, 0.0) + 0.5 * np.maximum(T - AT - 1e-3, 0.0)
    assert run["body.w"] == pytest.approx(exact, abs=1e-12)
    assert [round(e.t, 4) for e in run.events] == [AT, AT + 1e-3]


@pytest.mark.parametrize("method", METHODS)
def test_what_is_steep_or_rounded_is_no_jump(method):
    rig = _flywheel(load=gb.Input("u"))
    rounded = gb.simulate(rig, t=T, method=method, inputs={"u": lambda t: 1.0 + 1e-12 * (hash(t) % 7)})
    steep = gb.simulate(rig, t=T, method=method, inputs={"u": lambda t: 3.0 * min(max((t - AT) / 0.01, 0.0), 1.0)})
    assert len(rounded.events) == len(steep.events) == 0
    assert rounded["body.w"] == pytest.approx(0.5 * T, rel=1e-9)
    assert steep["body.w"][-1] == pytest.approx(1.5 * (2.0 - AT - 0.005), rel=1e-5)


def test_a_run_that_goes_on_behind_a_jump_is_the_run_in_one_piece():
    rig, inputs = _flywheel(load=gb.Input("u")), {"u": lambda t: 3.0 * (t >= AT)}
    first = gb.simulate(rig, t=[0.0, AT], inputs=inputs)
    second = gb.simulate(rig, t=[AT, 2.0], inputs=inputs, initial=first)
    assert first["body.w"][-1] == 0.0
    assert second["body.w"][-1] == pytest.approx(1.5 * (2.0 - AT), rel=1e-12)
