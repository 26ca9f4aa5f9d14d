"""Motion that is given: by acceleration; by angle, speed and acceleration together; through filters; by tables that jump."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import ModelError


def _driven(drive, *, J=2.0):
    rig = gb.Drivetrain("driven")
    rig.chain(rig.add("drive", drive), rig.add("body", gb.Inertia(J=J)))
    return rig


# -- acceleration -----------------------------------------------------------------------------------------------------


def test_an_acceleration_that_jumps_gives_speed_angle_and_the_torque_that_it_asks_for():
    alpha = gb.piecewise((50.0, gb.time < 1.0), (0.0, True))
    run = gb.simulate(_driven(gb.Acceleration(alpha=alpha, w0=3.0)), t_end=2.0)
    assert run["body.w"][-1] == pytest.approx(53.0, rel=1e-13)
    assert run["body.phi"][-1] == pytest.approx(3.0 + 25.0 + 53.0, rel=1e-13)
    assert run["drive.torque"][[0, -1]] == pytest.approx([100.0, 0.0])
    assert run.energy.residual < 1e-13


@pytest.mark.long
def test_an_acceleration_may_be_an_input_and_act_on_a_slider():
    rig = gb.Drivetrain("sled")
    rig.chain(
        rig.add("drive", gb.Acceleration(alpha=gb.Input("a", unit="m/s2"))), rig.add("sled", gb.Mass(m=2.0, s0=1.0))
    )
    run = gb.simulate(rig, t_end=2.0, rtol=1e-10, inputs={"a": gb.Table([0.0, 2.0], [0.0, 6.0])})
    assert run["sled.v"][-1] == pytest.approx(6.0, rel=1e-9) and run["sled.s"][-1] == pytest.approx(1.0 + 4.0, rel=1e-9)
    assert {p.path: p.unit for p in gb.build(rig).program.parameters}["drive.w0"] == "m/s"


# -- angle, speed and acceleration --------------------------------------------------------------------------------------


@pytest.mark.long
def test_an_angle_with_its_speed_and_acceleration_moves_as_the_angle_by_itself():
    phi, w, alpha = gb.sin(3 * gb.time), 3 * gb.cos(3 * gb.time), -9 * gb.sin(3 * gb.time)
    t = np.linspace(0.0, 2.0, 21)
    alone = gb.simulate(_driven(gb.Angle(phi=phi)), t=t, rtol=1e-10)
    given = gb.simulate(_driven(gb.Angle(phi=phi, w=w, alpha=alpha)), t=t, rtol=1e-10)
    for name in ("body.phi", "body.w", "drive.torque"):
        assert np.allclose(given[name], alone[name], rtol=1e-14, atol=1e-14)
    assert abs(given["drive.angle_gap"]).max() < 1e-9 and abs(given["drive.speed_gap"]).max() < 1e-9


def test_three_inputs_move_a_shaft_and_show_where_they_do_not_belong_together():
    rig = _driven(gb.Angle(phi=gb.Input("phi"), w=gb.Input("w"), alpha=gb.Input("alpha")))
    inputs = {"phi": lambda t: t**3, "w": lambda t: 3 * t**2, "alpha": lambda t: 6 * t}
    run = gb.simulate(rig, t_end=2.0, rtol=1e-9, inputs=inputs)
    assert run["body.phi"][-1] == 8.0 and run["body.w"][-1] == 12.0 and run["drive.torque"][-1] == 24.0
    assert abs(run["drive.angle_gap"]).max() < 1e-8 and run.energy.residual < 1e-8
    with pytest.warns(gb.GearblocksWarning, match="its energy is balanced to"):
        run = gb.simulate(rig, t_end=2.0, rtol=1e-9, inputs={**inputs, "w": lambda t: 2 * t**2})
    assert run["drive.angle_gap"][-1] == pytest.approx(8.0 - 16.0 / 3.0, rel=1e-8)


def test_speed_without_acceleration_and_beside_a_filter_are_refused():
    rig = gb.Drivetrain("rig")
    with pytest.raises(ModelError, match="w and alpha are given together"):
        rig.add("one", gb.Angle(phi=gb.time, w=1.0))
    with pytest.raises(ModelError, match="leave one of both out"):
        rig.add("two", gb.Angle(phi=gb.time, w=1.0, alpha=0.0, filter=10.0))


# -- filters ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "overshoot"),
    [("bessel", np.exp(-np.pi * np.sqrt(3.0))), ("butterworth", np.exp(-np.pi)), ("critical", 0.0)],
)
@pytest.mark.few(1)
def test_filters_of_second_order_overshoot_a_step_as_they_must(kind, overshoot):
    # damping ratio sqrt(3)/2, sqrt(1/2), 1: overshoot exp(-pi zeta/sqrt(1 - zeta^2))
    run = gb.simulate(
        _driven(gb.Angle(phi=gb.Table([0.0, 0.1, 0.1, 1.0], [0.0, 0.0, 1.0, 1.0]), filter=10.0, filter_type=kind)),
        t_end=3.0,
    )
    peak = gb.peak("body.phi").of(run)
    assert peak - 1.0 == pytest.approx(overshoot, abs=2e-6)


@pytest.mark.parametrize("kind", ["bessel", "butterworth"])
@pytest.mark.parametrize("block", ["angle", "speed"])
@pytest.mark.few(1)
def test_the_gain_at_the_cut_off_frequency_is_minus_3_db(kind, block):
    w0 = 20.0
    signal = gb.sin(w0 * gb.time)
    drive = (
        gb.Angle(phi=signal, filter=w0, filter_type=kind)
        if block == "angle"
        else gb.Speed(w=signal, filter=w0, filter_type=kind)
    )
    run = gb.simulate(_driven(drive), t_end=5.0, rtol=1e-9)
    name = "body.phi" if block == "angle" else "body.w"
    assert gb.peak(name, after=4.0).of(run) == pytest.approx(np.sqrt(0.5), rel=1e-6)


def test_a_filter_that_there_is_not_is_refused_with_the_near_one():
    rig = gb.Drivetrain("rig")
    with pytest.raises(ModelError, match=r"filter_type = 'besel' must be .* did you mean 'bessel'"):
        rig.add("drive", gb.Angle(phi=1.0, filter=1.0, filter_type="besel"))
    with pytest.raises(ModelError, match="filter_type = 'bessel' needs filter"):
        rig.add("drive", gb.Speed(w=1.0, filter_type="bessel"))


# -- tables that jump ---------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_a_table_jumps_where_an_x_stands_twice():
    table = gb.Table([0.0, 1.0, 1.0, 2.0, 2.0], [0.0, 1.0, 3.0, 4.0, -1.0])
    assert list(table.values([0.0, 0.5, 1.0, 1.5, 2.0, 3.0])) == [0.0, 0.5, 3.0, 3.5, -1.0, -1.0]
    for signal, inputs in ((table, None), (gb.Input("u"), {"u": table})):
        run = gb.simulate(_driven(gb.Torque(tau=signal), J=1.0), t=[0.0, 1.0, 2.0, 3.0], rtol=1e-11, inputs=inputs)
        assert run["body.w"] == pytest.approx([0.0, 0.5, 4.0, 3.0], rel=1e-12)
        assert run["drive.torque"] == pytest.approx([0.0, 3.0, -1.0, -1.0])


@pytest.mark.long
def test_a_table_over_a_speed_may_jump_too():
    rig = gb.Drivetrain("rig")
    law = gb.Table([0.0, 5.0, 5.0, 10.0], [2.0, 2.0, 1.0, 1.0])
    rig.chain(rig.add("drive", gb.Torque(tau=law(gb.sense("body.w")))), rig.add("body", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=4.0, rtol=1e-10)  # 2.5 s to 5 rad/s, then half as fast
    assert run["body.w"][-1] == pytest.approx(6.5, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: gb.Table([0, 1, 1, 1, 2], [0, 1, 2, 3, 4]), "x = 1.0 stands three times or more"),
        (
            lambda: gb.Table([0, 1, 1, 2], [0, 1, 2, 0], periodic=True),
            r"Table \(periodic, which cannot jump\): x must increase",
        ),
        (
            lambda: gb.Table([0, 1, 1, 2], [0, 1, 2, 0], kind="cubic"),
            r"Table \(cubic, which cannot jump\): x must increase",
        ),
    ],
)
def test_jumps_that_cannot_be_are_refused(make, says):
    with pytest.raises(gb.ParameterError, match=says):
        make()
