"""Pulses and trapezoids over time, against what they are point by point; tables that jump."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import ParameterError
from gearblocks.language.expression import as_expr, evaluate


def _at(signal, t):
    def leaf(x):
        return t if x.op == "time" else float(x.args[0].values(evaluate(x.args[1], leaf)))

    return evaluate(as_expr(signal), leaf)


def test_a_pulse_is_on_for_its_duty_from_its_start_so_often():
    signal = gb.pulse(3.0, period=0.5, duty=0.2, start=0.1, offset=1.0, count=2)
    for t in np.arange(0.0025, 2.0, 0.005):
        on = 0.1 <= t < 1.1 and (t - 0.1) % 0.5 < 0.1
        assert _at(signal, t) == (4.0 if on else 1.0), t


def test_a_trapezoid_is_that_of_its_corners():
    signal = gb.trapezoid(2.0, rising=0.1, width=0.2, falling=0.05, period=0.5, start=0.1)
    x, y = [0.0, 0.1, 0.3, 0.35, 0.5], [0.0, 2.0, 2.0, 0.0, 0.0]
    for t in np.arange(0.0, 2.0, 0.007):
        wanted = 0.0 if t < 0.1 else np.interp((t - 0.1) % 0.5, x, y)
        assert _at(signal, t) == pytest.approx(wanted, abs=1e-12), t


def test_triangles_fill_their_period():
    signal = gb.trapezoid(rising=0.25, width=0.0, falling=0.75, period=1.0)
    assert [_at(signal, t) for t in (0.0, 0.125, 0.25, 0.625, 1.0, 1.125)] == [0.0, 0.5, 1.0, 0.5, 0.0, 0.5]


def test_flanks_are_located_in_a_run_and_amplitudes_may_be_parameters():
    rig = gb.Drivetrain("shaker")
    tau = gb.pulse(gb.Parameter("size", 3.0, "N m"), period=0.5, duty=0.2, start=0.1)
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=2.0)
    assert run["disc.w"][-1] == pytest.approx(4 * 3.0 * 0.1, rel=1e-13)
    assert gb.simulate(rig, t_end=2.0, parameters={"size": 5.0})["disc.w"][-1] == pytest.approx(2.0, rel=1e-13)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: gb.pulse(period=0.0), "period = 0.0 s must be a number > 0"),
        (lambda: gb.pulse(period=1.0, duty=1.0), "duty = 1.0 must be > 0 and < 1"),
        (lambda: gb.pulse(period=1.0, count=0), "count = 0 must be a whole number >= 1"),
        (lambda: gb.pulse(period=1.0, width=0.5), "pulse has no argument 'width'"),
        (lambda: gb.trapezoid(rising=0.0, width=0.1, falling=0.1, period=1.0), "gb.pulse has vertical flanks"),
        (lambda: gb.trapezoid(rising=0.5, width=0.5, falling=0.5, period=1.0), "must fit into the period of 1 s"),
        (lambda: gb.trapezoid(rising=0.5, width=-0.5, falling=0.5, period=1.0), "width = -0.5 s must be a number >= 0"),
    ],
)
def test_shapes_that_there_are_not_are_refused_by_name(make, says):
    with pytest.raises(ParameterError, match=says):
        make()
