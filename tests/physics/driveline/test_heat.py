"""Heat of losses: into thermal masses and through conductances, against closed forms and scipy; no trace where absent."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb
from gearblocks.errors import ModelError

T0 = 293.15


def _lock_up(mu, *, heat=None, **masses):
    """Two discs, J = 0.2 and 1, at 200 and 0 rad/s, and a clutch between them."""
    rig = gb.Drivetrain("lock-up")
    engine, car = rig.add("engine", gb.Inertia(J=0.2, w0=200.0)), rig.add("car", gb.Inertia(J=1.0))
    clutch = gb.Clutch(mu=mu, force_max=2e3, geometry=0.1, engagement=1.0, heat=heat)
    rig.chain(engine, rig.add("clutch", clutch), car)
    for name, mass in masses.items():
        rig.add(name, mass)
    return rig


# -- a mass -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.few(1)
def test_a_clutch_that_locks_up_heats_its_disc_by_the_energy_of_the_slip_over_its_capacity(method):
    rig = _lock_up(0.4, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=50.0, T0=T0))
    run = gb.simulate(rig, t_end=1.0, rtol=1e-11, method=method)
    heat = 0.5 * 0.2 * 1.0 / 1.2 * 200.0**2  # of the plastic impact of both
    assert run["clutch.mode"][-1] == 0
    assert run["disc.T"][-1] - T0 == pytest.approx(heat / 50.0, rel=1e-9)
    assert run["clutch.heat"][-1] == run["disc.heat"][-1] == pytest.approx(heat, rel=1e-9)
    assert run.energy.heat == pytest.approx({"clutch": heat}, rel=1e-9)
    assert run.energy.heat_stored == {"disc": run.energy.heat["clutch"]} and run.energy.heat_passed == {}
    assert run.energy.heat_residual < 1e-10 and run.energy.residual < 1e-10
    assert np.array_equal(run["clutch.heat_flow"], run["clutch.loss_power"])
    assert np.array_equal(run["clutch.temperature"], run["disc.T"])


@pytest.mark.long
def test_the_thermal_column_of_the_ledger_is_printed_and_stored(tmp_path):
    rig = _lock_up(0.4, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=50.0))
    rig.add("air", gb.ThermalConductance(G=100.0, a=T0, b="disc"))
    run = gb.simulate(rig, t_end=1.0)
    assert (
        run.energy.heat_passed["air"] == -run["air.heat"][-1] > 0
    )  # from a to b counts as taken from the surroundings
    assert "heat stored in disc" in str(run.energy) and "heat to surroundings by air" in str(run.energy)
    run.save(tmp_path / "run.nc")
    assert gb.Trajectory.load(tmp_path / "run.nc").energy == run.energy


def test_two_masses_with_a_conductance_meet_in_the_middle_along_an_exponential():
    C, D, G = 450.0, 900.0, 3.0
    rig = gb.Drivetrain("two bodies")
    rig.add("disc", gb.ThermalMass(C=C, T0=400.0))
    rig.add("hub", gb.ThermalMass(C=D, T0=300.0))
    rig.add("contact", gb.ThermalConductance(G=G, a="disc", b="hub"))
    rig.add("wheel", gb.Inertia(J=1.0))
    t = np.linspace(0.0, 500.0, 26)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    difference = 100.0 * np.exp(-G * (1 / C + 1 / D) * t)
    middle = (C * 400.0 + D * 300.0) / (C + D)
    assert np.allclose(run["disc.T"], middle + difference * D / (C + D), rtol=1e-11, atol=0)
    assert np.allclose(run["hub.T"], middle - difference * C / (C + D), rtol=1e-11, atol=0)
    assert np.allclose(run["contact.heat_flow"], G * difference, rtol=1e-8, atol=0)
    assert run.energy.heat_stored["disc"] == -run.energy.heat_stored["hub"]


def test_a_bearing_settles_at_the_temperature_at_which_air_takes_what_it_loses():
    rig = gb.Drivetrain("bearing")
    bearing = rig.add("bearing", gb.BearingFriction(viscous=0.02, heat=gb.HeatPort(T="ring")))
    rig.chain(rig.add("drive", gb.Speed(w=50.0)), bearing)
    rig.add("ring", gb.ThermalMass(C=2.0))
    rig.add("air", gb.ThermalConductance(G=0.5, a="ring", b=gb.Input("T_air", start=280.0, unit="K")))
    run = gb.simulate(rig, t_end=100.0, rtol=1e-9, inputs={"T_air": 270.0})
    assert run["ring.T"][-1] == pytest.approx(270.0 + 0.02 * 50.0**2 / 0.5, rel=1e-8)
    assert run.energy.heat_residual < 1e-8


@pytest.mark.long
def test_a_small_rise_above_the_surroundings_is_not_lost_in_rounding():
    def warmed(T):
        rig = gb.Drivetrain("warming up")
        damper = rig.add("damper", gb.Damper(c=0.1, heat=gb.HeatPort(T="oil")))
        rig.chain(
            rig.add("drive", gb.Torque(tau=1e-3 * gb.sin(5 * gb.time))), rig.add("disc", gb.Inertia(J=0.1)), damper
        )
        rig.connect(damper.b, rig.add("wall", gb.Fixed()).flange)
        rig.add("oil", gb.ThermalMass(C=2.0, T0=T))
        rig.add("air", gb.ThermalConductance(G=4.0, a=T, b="oil"))
        return gb.simulate(rig, t=[0.0, 1.0, 2.0], rtol=1e-9)

    cold, warm = warmed(0.0), warmed(300.0)
    assert warm.stats.steps == cold.stats.steps  # rounding of 300 K once took 50 times the steps
    assert np.allclose(warm["oil.rise"], cold["oil.T"], rtol=1e-12, atol=0) and 0 < cold["oil.T"][-1] < 1e-5


@pytest.mark.long
def test_a_static_start_asks_no_heat_to_rest():
    rig = gb.Drivetrain("running")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=10.0)), rig.add("two", gb.Inertia(J=1.0, w0=10.0))
    bearing = rig.add("bearing", gb.BearingFriction(viscous=0.2, heat=gb.HeatPort(T="ring")))
    rig.chain(rig.add("drive", gb.Torque(tau=2.0)), one, rig.add("shaft", gb.Shaft(k=100.0, c=1.0)), two, bearing)
    rig.add("ring", gb.ThermalMass(C=5.0))
    rig.add("air", gb.ThermalConductance(G=2.0, a="ring", b=290.0))
    run = gb.simulate(rig, t_end=1.0, initial="static")
    assert run["shaft.twist"] == pytest.approx(np.full(len(run.t), -0.02), rel=1e-12)
    assert run["ring.T"][0] == 293.15 and run["ring.T"][-1] > 295.0


# -- laws that read the temperature -----------------------------------------------------------------------------------


@pytest.mark.long
def test_friction_that_fades_with_the_temperature_of_its_disc_is_that_of_scipy():
    mu = 0.4 * (1 - 2e-3 * (gb.temperature - T0))
    rig = _lock_up(mu, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=30.0, T0=T0))
    rig.add("air", gb.ThermalConductance(G=40.0, a="disc", b=T0))
    t = np.linspace(0.0, 0.4, 9)
    run = gb.simulate(rig, t=t, rtol=1e-12)

    def rates(_, y):
        one, two, T = y
        torque = 0.1 * 2e3 * 0.4 * (1 - 2e-3 * (T - T0))
        return [-torque / 0.2, torque / 1.0, (torque * (one - two) - 40.0 * (T - T0)) / 30.0]

    found = solve_ivp(rates, (0, 0.4), [200.0, 0.0, T0], "DOP853", t_eval=t, rtol=1e-13, atol=1e-13)
    assert run["clutch.mode"][-1] == -1  # it slips all the time
    for name, row in (("engine.w", 0), ("car.w", 1), ("disc.T", 2)):
        assert np.allclose(run[name], found.y[row], rtol=1e-10, atol=1e-9), name


def test_an_eddy_current_brake_whose_disc_heats_up_is_that_of_scipy():
    tau, w_n, J, alpha, C = 100.0, 10.0, 1.0, 3.93e-3, 5.0
    brake = gb.EddyCurrentBrake(tau_nominal=tau, w_nominal=w_n, alpha=alpha, heat=gb.HeatPort(T="disc"))
    rig = gb.Drivetrain("retarder")
    rig.chain(rig.add("wheel", gb.Inertia(J=J, w0=20.0)), rig.add("brake", brake))
    rig.add("disc", gb.ThermalMass(C=C, T0=T0))
    t = np.linspace(0.0, 0.5, 11)
    run = gb.simulate(rig, t=t, rtol=1e-12)

    def rates(_, y):
        w, T = y
        hot = w_n * (1 + alpha * (T - 293.15))
        torque = 2 * tau / (w / hot + hot / w)
        return [-torque / J, torque * w / C]

    found = solve_ivp(rates, (0, 0.5), [20.0, T0], "DOP853", t_eval=t, rtol=1e-13, atol=1e-13)
    assert np.allclose(
        run["wheel.w"], found.y[0], rtol=1e-10, atol=1e-10
    )  # a state is kept relative to its largest value
    assert np.allclose(run["disc.T"], found.y[1], rtol=1e-10, atol=0)
    cold = gb.simulate(rig, t=t, rtol=1e-12, parameters={"brake.alpha": 0.0})
    assert abs(cold["wheel.w"][-1] / run["wheel.w"][-1] - 1) > 0.01


@pytest.mark.long
def test_a_temperature_that_is_a_number_is_a_parameter_that_the_law_follows():
    rig = gb.Drivetrain("brake")
    brake = gb.Brake(capacity=2.0 * (1 + 0.01 * (gb.temperature - 300.0)), heat=gb.HeatPort(T=300.0))
    rig.chain(rig.add("wheel", gb.Inertia(J=1.0, w0=10.0)), rig.add("brake", brake))
    for T, torque in ((300.0, 2.0), (350.0, 3.0)):
        run = gb.simulate(rig, t_end=1.0, parameters={"brake.heat.T": T})
        assert run["wheel.w"][-1] == pytest.approx(10.0 - torque, rel=1e-12)
        assert run["brake.temperature"][-1] == T and "brake.heat" not in run.names
    assert run.energy.heat == {}
    assert rig.effects() == {}, "its law reads the temperature: the port cannot be left out"


# -- what is lost at an instant, or by a constraint force -------------------------------------------------------------


def test_impacts_heat_a_stop_by_what_the_body_loses():
    rig = gb.Drivetrain("flap")
    stop = gb.HardStop(upper=1.0, restitution=0.5, heat=gb.HeatPort(T="rubber"))
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), rig.add("flap", gb.Inertia(J=0.1)), rig.add("stop", stop))
    rig.add("rubber", gb.ThermalMass(C=2.0, T0=T0))
    run = gb.simulate(rig, t_end=3.0)
    assert run["stop.contact"][-1] == 1  # after bounces without end it rests: the work of the drive is heat
    assert run["rubber.T"][-1] == pytest.approx(T0 + 1.0 * 1.0 / 2.0, rel=1e-12)
    assert run.energy.heat_residual < 1e-12


@pytest.mark.long
def test_teeth_that_close_on_a_speed_difference_are_heated_by_the_impact():
    rig = gb.Drivetrain("dogs")
    one, two = rig.add("one", gb.Inertia(J=0.2, w0=30.0)), rig.add("two", gb.Inertia(J=0.3))
    engaged = gb.piecewise((0.0, gb.time < 0.1), (1.0, True))
    rig.chain(one, rig.add("dogs", gb.DogClutch(engaged=engaged, heat=gb.HeatPort(T="teeth"))), two)
    rig.add("teeth", gb.ThermalMass(C=0.5, T0=T0))
    run = gb.simulate(rig, t_end=0.2)
    assert run["teeth.heat"][-1] == pytest.approx(0.5 * 0.2 * 0.3 / 0.5 * 30.0**2, rel=1e-12)
    assert run["teeth.T"][0] == T0


@pytest.mark.long
def test_a_lossy_gear_heats_its_oil_by_what_does_not_leave_it():
    def loaded(T):
        rig = gb.Drivetrain("reduction")
        gear = gb.LossyGear(ratio=4, efficiency=(0.9, 0.85), bearing=(0.1, 0.1), heat=gb.HeatPort(T=T))
        drive = rig.add("drive", gb.Torque(tau=3.0 + 4.0 * gb.sin(2.0 * gb.time)))
        motor, load = rig.add("motor", gb.Inertia(J=0.02)), rig.add("load", gb.Inertia(J=1.0))
        rig.chain(drive, motor, rig.add("gear", gear), load, rig.add("fan", gb.SpeedLoad(coeffs=(0.0, 0.5, 0.0))))
        rig.add("oil", gb.ThermalMass(C=20.0, T0=T0))
        return rig

    t = np.linspace(0.0, 3.0, 6001)
    run = gb.simulate(loaded("oil"), t=t, rtol=1e-10)
    assert run["oil.heat"][-1] == pytest.approx(np.trapezoid(run["gear.loss_power"], t), rel=1e-6)
    assert np.allclose(run["gear.heat_flow"], run["gear.loss_power"], rtol=1e-12, atol=1e-12)
    assert run.energy.heat_residual < 1e-9
    implicit = gb.simulate(loaded("oil"), t=t, rtol=1e-8, method="rodas")
    assert implicit["oil.heat"][-1] == pytest.approx(run["oil.heat"][-1], rel=1e-6)
    assert gb.simulate(loaded(300.0), t_end=1.0, method="rodas").stats.method == "rodas"


# -- absent, nested, of users, packed -----------------------------------------------------------------------------------


@pytest.mark.long
def test_without_a_heat_port_there_is_no_trace_of_it():
    hot = _lock_up(0.4, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=50.0))
    plain, cold = _lock_up(0.4), hot.without("clutch.heat")
    assert list(hot.effects()) == ["clutch.heat"] and cold.effects() == {}
    assert "heat" not in gb.build(plain).program.source and "heat" in gb.build(hot).program.source
    one, other = (gb.simulate(x, t_end=1.0) for x in (plain, cold))
    assert np.array_equal(one["car.w"], other["car.w"]) and other["disc.T"][-1] == 293.15
    assert one.energy.heat == other.energy.heat == {} and "heat" not in str(one.energy)


def test_a_heat_port_changes_no_bit_of_a_motion_that_does_not_read_it_at_fixed_steps():
    plain = gb.simulate(_lock_up(0.4), t_end=1.0, method="rk4", step=1e-3)
    rig = _lock_up(0.4, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=50.0))
    hot = gb.simulate(rig, t_end=1.0, method="rk4", step=1e-3)
    assert np.array_equal(plain["car.w"], hot["car.w"])


@pytest.mark.long
def test_heat_stays_inside_a_nested_train_and_survives_json(tmp_path):
    box = _lock_up(0.4, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=50.0))
    whole = gb.Drivetrain("whole")
    whole.add("left", box)
    whole.add("right", box)
    whole.add("wall", gb.ThermalConductance(G=5.0, a="left.disc", b="right.disc"))
    whole.to_json(tmp_path / "whole.json")
    run = gb.simulate(gb.Drivetrain.from_json(tmp_path / "whole.json"), t_end=1.0)
    assert run["left.disc.T"][-1] == run["right.disc.T"][-1] > 350.0
    assert set(run.energy.heat) == {"left.clutch", "right.clutch"}


class _Rubbing(gb.Block):
    """A drag that fades as its lining heats up."""

    a = gb.Flange("shaft")
    c = gb.param("drag", "N m s/rad", gt=0)
    heat: gb.HeatPort | None = gb.effect("heat port")

    def physics(self, s):
        c = s.c if self.heat is None else s.c * 300.0 / s.heat.T
        yield gb.Acts(s.a, -c * s.a.w)
        yield gb.Energy(loss=c * s.a.w**2)


def test_a_block_of_a_user_takes_a_heat_port():
    rig = gb.Drivetrain("own")
    rig.chain(
        rig.add("wheel", gb.Inertia(J=1.0, w0=30.0)), rig.add("drag", _Rubbing(c=0.5, heat=gb.HeatPort(T="lining")))
    )
    rig.add("lining", gb.ThermalMass(C=1.0, T0=300.0))
    run = gb.simulate(rig, t_end=2.0, rtol=1e-10)

    def rates(_, y):
        c = 0.5 * 300.0 / y[1]
        return [-c * y[0], c * y[0] ** 2]

    found = solve_ivp(rates, (0, 2), [30.0, 300.0], "DOP853", rtol=1e-12, atol=1e-12)
    assert run["wheel.w"][-1] == pytest.approx(found.y[0, -1], rel=1e-9)
    assert run["lining.T"][-1] == pytest.approx(found.y[1, -1], rel=1e-9)
    bare = gb.Drivetrain("bare")
    bare.chain(bare.add("wheel", gb.Inertia(J=1.0, w0=30.0)), bare.add("drag", _Rubbing(c=0.5)))
    assert "drag.heat_flow" not in gb.simulate(bare, t_end=0.1).names


def test_the_heat_equation_is_printed_with_its_mass():
    rig = _lock_up(0.4, heat=gb.HeatPort(T="disc"), disc=gb.ThermalMass(C=50.0))
    rig.add("air", gb.ThermalConductance(G=40.0, a="disc", b=T0))
    text = str(rig.equations())
    assert "T_disc = (Q_clutch - Q_air)/C_disc + T0_disc" in text
    assert "Q_clutch' = -T_clutch" in text


# -- what is refused --------------------------------------------------------------------------------------------------


def test_a_temperature_without_a_port_is_refused_by_name():
    with pytest.raises(
        ModelError, match=r"Clutch 'clutch': mu = .* contains gb.temperature: give the block heat=gb.HeatPort"
    ):
        _lock_up(0.4 * gb.temperature)


def test_heat_into_what_is_no_mass_is_refused_with_the_near_ones():
    rig = _lock_up(0.4, heat=gb.HeatPort(T="disk"), disc=gb.ThermalMass(C=50.0))
    with pytest.raises(ModelError, match=r"'clutch': .* of 'disk', which is no ThermalMass .* did you mean 'disc'"):
        gb.build(rig)


def test_a_temperature_below_absolute_zero_and_a_coefficient_without_a_port_are_refused():
    rig = gb.Drivetrain("rig")
    with pytest.raises(ModelError, match=r"T0 = -5\.0 K must be >= 0"):
        rig.add("disc", gb.ThermalMass(C=1.0, T0=-5.0))
    with pytest.raises(ModelError, match=r"alpha = 0\.004 needs the temperature: give heat"):
        rig.add("brake", gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=1.0, alpha=0.004))
