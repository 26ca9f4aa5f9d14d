"""What may stand where a value is wanted, and that no jump or pulse in time is missed."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.train.handles import FlangeHandle

EXACT = 1e-12  # polynomials between located corners: rounding only


def _driven(tau, J=1.0):
    rig = gb.Drivetrain("driven")
    body, drive = rig.add("body", gb.Inertia(J=J)), rig.add("drive", gb.Torque(tau=tau))
    rig.chain(drive, body)
    return rig


def _end(tau, t_end, rtol=1e-6, **arguments):
    return gb.simulate(_driven(tau), t=[0.0, t_end], rtol=rtol, **arguments)["body.w"][-1]


# -- parameters -------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_one_parameter_serves_several_blocks_and_is_set_once():
    T = gb.Parameter("T", 3.0, "N m")
    J = gb.Parameter("J", 2.0, "kg m2")
    rig = gb.Drivetrain("shared")
    a, b = rig.add("a", gb.Inertia(J=J)), rig.add("b", gb.Inertia(J=2 * J))
    shaft = rig.add("shaft", gb.Shaft(k=1.0))
    one, two = rig.add("one", gb.Torque(tau=T)), rig.add("two", gb.Torque(tau=-T / 2 * gb.time))
    rig.chain(one, a, shaft, b, two)
    model = gb.build(rig)
    run = gb.simulate(model, t=[0.0, 1e-9], rtol=1e-6)
    assert run["a.alpha"][0] == 1.5
    run = gb.simulate(model, t=[0.0, 1.0], rtol=1e-10, parameters={"T": 5.0, "J": 1.0})
    assert run["a.alpha"][0] == 5.0
    assert run["two.torque"][-1] == -2.5
    # impulse of both torques: 5 t - 5/4 t^2
    assert 1.0 * run["a.w"][-1] + 2.0 * run["b.w"][-1] == pytest.approx(5 - 1.25, rel=1e-10)


def test_two_parameters_of_one_name_and_different_values_are_refused():
    rig = _driven(gb.Parameter("T", 1.0))
    more = rig.add("more", gb.Torque(tau=gb.Parameter("T", 2.0)))
    rig.connect(more.flange, FlangeHandle(rig, "body", "b"))
    with pytest.raises(gb.ModelError, match="'T'"):
        gb.build(rig)


@pytest.mark.long
def test_a_short_path_is_enough_when_it_is_unique():
    model = gb.build(_driven(2.0))
    assert gb.simulate(model, t=[1.0], parameters={"J": 4.0})["body.w"][0] == pytest.approx(0.5, rel=EXACT)
    with pytest.raises(gb.UnknownNameError, match=r"body\.J"):
        gb.simulate(model, t=[1.0], parameters={"body.I": 4.0})


# -- inputs -----------------------------------------------------------------------------------------------------------


def test_an_input_is_a_number_a_table_or_a_function():
    u = gb.Input("u", start=2.0, unit="N m")
    assert _end(u, 3.0) == pytest.approx(6.0, rel=EXACT)  # its start value
    assert _end(u, 3.0, inputs={"u": 5.0}) == pytest.approx(15.0, rel=EXACT)
    line = gb.Table([0, 1, 2], [0, 4, -2])
    assert _end(u, 3.0, inputs={"u": line}) == pytest.approx(2 + 1 - 2, rel=EXACT)  # held after the last point
    steps = gb.Table([0, 1, 2], [1, -3, 2], "step")
    assert _end(u, 3.0, inputs={"u": steps}) == pytest.approx(1 - 3 + 2, abs=EXACT)
    assert _end(u, 2.0, rtol=1e-11, inputs={"u": lambda t: 3 * t**2}) == pytest.approx(8.0, rel=1e-10)


@pytest.mark.parametrize(("ends", "scipys"), [("not-a-knot", "not-a-knot"), ("flat", "clamped")])
@pytest.mark.few(1)
def test_a_cubic_table_is_a_spline_with_these_ends(ends, scipys):
    from scipy.interpolate import CubicSpline

    x, y = np.array([0.0, 0.3, 1.0, 1.4, 2.0]), np.array([1.0, -1.0, 2.0, 0.5, 3.0])
    area = float(CubicSpline(x, y, bc_type=scipys).integrate(0, 2)) + 3.0  # held for one second
    table = gb.Table(x, y, "cubic", ends=ends)
    assert _end(gb.Input("u"), 3.0, inputs={"u": table}) == pytest.approx(area, rel=EXACT)
    assert _end(table, 3.0) == pytest.approx(area, rel=EXACT)


@pytest.mark.parametrize("as_input", [True, False], ids=["input", "signal"])
@pytest.mark.parametrize(
    ("table", "area"),
    [
        (gb.Table([0, 0.1, 0.2, 0.4], [0, 1, -1, 0], periodic=True), 0.05 + 0.0 - 0.1),
        (gb.Table([0, 0.1, 0.4], [3, -1, 3], "step", periodic=True), 0.3 - 0.3),
        (gb.Table([0, 0.1, 0.4], [5, -1, 5], "step", periodic=True), 0.5 - 0.3),
        (gb.Table([0, 0.1, 0.2, 0.4], [1, 2, 3, 1], "cubic", periodic=True), None),
    ],
    ids=["linear", "step", "another step", "cubic"],
)
@pytest.mark.few(2)
def test_a_periodic_table_repeats(table, area, as_input):
    if area is None:
        from scipy.interpolate import CubicSpline

        area = float(CubicSpline(table.x, table.y, bc_type="periodic").integrate(0, 0.4))
    n = 10
    got = _end(gb.Input("u"), 0.4 * n, inputs={"u": table}) if as_input else _end(table, 0.4 * n)
    assert got == pytest.approx(n * area, rel=1e-11, abs=1e-12)  # 30 corners, each located to rounding


@pytest.mark.long
def test_inputs_of_one_name_are_one_input():
    rig = _driven(gb.Input("u", 1.0) + 2 * gb.Input("u", 1.0))
    model = gb.build(rig)
    assert [i.name for i in model.program.inputs] == ["u"]
    assert gb.simulate(model, t=[1.0], inputs={"u": 2.0})["body.w"][0] == pytest.approx(6.0, rel=EXACT)


def test_an_input_that_steps_is_seen_at_its_instant():
    table = gb.Table([0, 0.123456789], [0, 1], "step")
    run = gb.simulate(_driven(gb.Input("u")), t_end=1.0, inputs={"u": table}, rtol=1e-3)
    assert run["body.w"][-1] == pytest.approx(1 - 0.123456789, rel=EXACT)
    assert run["body.phi"][-1] == pytest.approx((1 - 0.123456789) ** 2 / 2, rel=EXACT)


# -- switches of time -------------------------------------------------------------------------------------------------

t = gb.time
PI = np.pi
SWITCHES = {
    "piecewise": (sp.Piecewise((1, t < 0.5), (-2, t < 0.7), (3, True)), 2.0, 0.5 - 0.4 + 3.9),
    "own piecewise": (gb.piecewise((1, t < 0.5), (-2, t < 0.7), (3, True)), 2.0, 0.5 - 0.4 + 3.9),
    "nested": (sp.Piecewise((sp.Piecewise((5, t < 0.25), (t, True)), t < 1), (0, True)), 2.0, 1.25 + (1 - 0.0625) / 2),
    "sign": (sp.sign(sp.sin(2 * sp.pi * t)), 2.5, 0.5),
    "abs": (sp.Abs(t - 0.3), 1.0, 0.045 + 0.245),
    "min": (sp.Min(t, 0.4), 1.0, 0.08 + 0.24),
    "heaviside": (sp.Heaviside(t - 0.3) - sp.Heaviside(t - 0.31), 1.0, 0.01),
    "and": (sp.Piecewise((1, sp.And(sp.sin(PI * t) > 0, t > 2.5)), (0, True)), 4.0, 0.5),
    "or": (sp.Piecewise((1, sp.Or(t < 0.25, t > 0.75)), (0, True)), 1.0, 0.5),
}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.long] * (n in ("nested", "abs", "min", "or"))) for n in SWITCHES]
)
@pytest.mark.few(1)
def test_a_condition_on_time_is_met_exactly(name):
    expression, end, impulse = SWITCHES[name]
    assert _end(expression, end) == pytest.approx(impulse, rel=1e-12)


@pytest.mark.long
def test_the_largest_of_three_lines_is_taken():
    run = _end(sp.Max(t, 0.4, 2 * t - 0.5), 1.0)
    # 0.4 until 0.4, t until 0.5, 2 t - 0.5 after
    assert run == pytest.approx(0.16 + (0.25 - 0.16) / 2 + (1 - 0.25) - 0.25, rel=EXACT)


@pytest.mark.parametrize("rtol", [1e-2, 1e-3, 1e-8])
@pytest.mark.few(1)
def test_a_pulse_of_a_millisecond_in_ten_seconds_is_seen(rtol):
    for pulse in (
        sp.Heaviside(t - 7) - sp.Heaviside(t - 7.001),
        sp.Piecewise((1, sp.And(t > 7, t < 7.001)), (0, True)),
        gb.Table([0, 7, 7.001], [0, 1, 0], "step"),
    ):
        assert _end(pulse, 10.0, rtol=rtol) == pytest.approx(1e-3, rel=1e-11)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_a_pulse_of_an_input_is_seen_by_a_spring(rtol):
    rig = gb.Drivetrain("struck")
    body, spring = rig.add("body", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(k=1.0))
    ground, drive = rig.add("ground", gb.Fixed()), rig.add("drive", gb.Torque(tau=gb.Input("u")))
    rig.chain(drive, body, spring, ground)
    pulse = gb.Table([0, 5, 5.001], [0, 1, 0], "step")
    run = gb.simulate(rig, t=[10.0], inputs={"u": pulse}, rtol=rtol)
    true = np.cos(10 - 5.001) - np.cos(10 - 5)
    assert run["body.phi"][0] == pytest.approx(true, rel=30 * rtol)  # a second of free swing at rtol


@pytest.mark.long
def test_a_condition_holds_its_right_limit_at_the_instant_itself():
    run = gb.simulate(_driven(sp.Heaviside(t - 0.5)), t=[0.25, 0.5, 0.75], rtol=1e-6)
    assert list(run["drive.torque"]) == [0.0, 1.0, 1.0]
    run = gb.simulate(_driven(sp.Piecewise((1, t < 0.5), (2, True))), t_end=1.0, rtol=1e-6)
    at = run["drive.torque"][run.t == 0.5]
    assert list(at) == [1.0, 2.0]  # both sides of the event


def test_a_switch_at_the_start_and_at_the_end_of_a_run():
    assert _end(sp.Piecewise((7, t < 0), (1, True)), 1.0) == pytest.approx(1.0, rel=EXACT)
    assert _end(sp.Piecewise((1, t < 1), (700, True)), 1.0) == pytest.approx(1.0, rel=EXACT)


def test_a_condition_that_asks_for_equality_is_refused():
    with pytest.raises(gb.GearblocksError, match=r"Equality|equality"):
        gb.build(_driven(sp.Piecewise((1, sp.Eq(sp.sin(t), 0)), (0, True))))


def test_a_foreign_symbol_is_refused_with_the_way_out():
    with pytest.raises(gb.GearblocksError, match="Parameter"):
        _driven(sp.Symbol("omega") * 2)


@pytest.mark.long
def test_numbers_of_numpy_are_numbers():
    assert _end(np.float64(2.0), 1.0) == pytest.approx(2.0, rel=EXACT)
    assert _end(np.float64(2.0) * gb.time, 1.0) == pytest.approx(1.0, rel=EXACT)
