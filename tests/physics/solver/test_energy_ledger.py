"""Energy: what a train without losses keeps, and ledgers that close."""

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import gearblocks as gb

J, K, B = (1.0, 0.6, 1.4, 0.8), (90.0, 200.0, 120.0), 0.05


def _chain():
    """Four inertias, a spring, a lash, a spring: no damping, no load."""
    rig = gb.Drivetrain("free chain")
    parts = []
    for i, inertia in enumerate(J):
        parts.append(rig.add(f"j{i}", gb.Inertia(J=inertia)))
        if i in (0, 2):
            parts.append(rig.add(f"k{i}", gb.Shaft(k=K[i])))
        elif i == 1:
            parts.append(rig.add("lash", gb.Lash(k=K[1], half_gap=B)))
    rig.chain(*parts)
    return rig


def _energy(phi, w):
    x = phi[2] - phi[1]
    g = np.sign(x) * np.maximum(np.abs(x) - B, 0)
    spring = K[0] * (phi[1] - phi[0]) ** 2 + K[2] * (phi[3] - phi[2]) ** 2 + K[1] * g**2
    return (spring + sum(j * v**2 for j, v in zip(J, w, strict=True))) / 2


def _rates(t, y):
    p = y[:4]
    x = p[2] - p[1]
    t0, t2 = K[0] * (p[1] - p[0]), K[2] * (p[3] - p[2])
    t1 = K[1] * (x - B if x > B else x + B if x < -B else 0.0)
    return [*y[4:], t0 / J[0], (t1 - t0) / J[1], (t2 - t1) / J[2], -t2 / J[3]]


@pytest.mark.long
def test_energy_drifts_no_more_than_with_scipy_over_a_thousand_slow_periods():
    stiffness = np.zeros((4, 4))
    for i, k in enumerate(K):
        stiffness[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    slow = np.sqrt(sorted(np.linalg.eigvals(stiffness / np.array(J)[:, None]).real)[1])
    t_end = 1000 * 2 * np.pi / slow
    y0 = np.array([0.0, 0, 0, 0.2, 0.5, -0.3, 0, -0.2 * 0.5 / 0.8])
    start = {f"j{i}.phi": y0[i] for i in range(4)} | {f"j{i}.w": y0[4 + i] for i in range(4)}
    rtol = 1e-6  # at tighter ones scipy takes minutes
    ours = gb.simulate(_chain(), t=[0.0, t_end], rtol=rtol, initial=start)
    assert ours.stats.events > 1000
    e = _energy([ours[f"j{i}.phi"] for i in range(4)], [ours[f"j{i}.w"] for i in range(4)])
    true = solve_ivp(_rates, (0, t_end), y0, "DOP853", rtol=rtol, atol=1e-9, t_eval=[t_end])
    theirs = _energy(true.y[:4, -1], true.y[4:, -1])
    assert abs(e[1] / e[0] - 1) <= abs(theirs / e[0] - 1)


def test_a_free_chain_with_backlash_keeps_its_energy_in_proportion_to_the_tolerance():
    model, start = gb.build(_chain()), {"j3.phi": 0.2, "j0.w": 0.5}
    for rtol in (1e-6, 1e-9, 1e-12):
        run = gb.simulate(model, t=np.linspace(0, 30, 301), rtol=rtol, initial=start)
        e = _energy([run[f"j{i}.phi"] for i in range(4)], [run[f"j{i}.w"] for i in range(4)])
        # some 200 steps: each may err by rtol
        assert np.abs(e / e[0] - 1).max() < 200 * rtol + 1e-13
        assert run.energy.residual <= 200 * rtol + 1e-13
        assert run.energy.supplied == {}
        assert run.energy.dissipated == {}
        assert run.energy.end == pytest.approx(e[-1], rel=1e-12)


def test_the_ledger_names_who_gave_and_who_took():
    rig = gb.Drivetrain("ledger")
    motor, wheel = rig.add("motor", gb.Inertia(J=0.1)), rig.add("wheel", gb.Inertia(J=0.3))
    shaft = rig.add("shaft", gb.Shaft(k=50.0, c=0.2))
    drive, load = rig.add("drive", gb.Torque(tau=4.0)), rig.add("load", gb.SpeedLoad(coeffs=(0.1, 0.05, 0.01)))
    rig.chain(drive, motor, shaft, wheel, load)
    t = np.linspace(0, 5, 20001)
    run = gb.simulate(rig, t=t, rtol=1e-11, initial={"motor.w": 2.0, "wheel.w": 2.0})
    ledger = run.energy
    assert set(ledger.supplied) == {"drive"}
    assert set(ledger.dissipated) == {"shaft", "load"}
    # trapezium sums over 20000 samples of 0.25 ms: (0.25 ms x 26 rad/s)^2 / 12
    assert ledger.supplied["drive"] == pytest.approx(np.trapezoid(run["drive.flange.power"], t), rel=1e-5)
    assert ledger.dissipated["load"] == pytest.approx(np.trapezoid(run["load.loss_power"], t), rel=1e-5)
    assert ledger.dissipated["shaft"] == pytest.approx(np.trapezoid(run["shaft.loss_power"], t), rel=1e-5)
    assert ledger.residual < 1e-10  # 10 rtol
    total = sum(ledger.supplied.values()) - sum(ledger.dissipated.values())
    assert ledger.end - ledger.start == pytest.approx(total, rel=1e-9)
    assert ledger.stored["motor"] == pytest.approx(0.05 * run["motor.w"][-1] ** 2, rel=1e-12)
    assert ledger.stored["shaft"] == pytest.approx(25 * run["shaft.twist"][-1] ** 2, rel=1e-12)


@pytest.mark.parametrize("method", ["dp5", "dp8"])
def test_the_ledger_closes_to_the_tolerance_with_jumps_of_torque_and_stiffness(method):
    rig = gb.Drivetrain("jumps")
    body, ground = rig.add("body", gb.Inertia(J=1.0)), rig.add("ground", gb.Fixed())
    spring = rig.add("spring", gb.Shaft(k=gb.piecewise((100, gb.time < 0.4), (150, gb.time < 0.9), (60, True)), c=0.3))
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((10, gb.time < 0.5), (-3, True))))
    rig.chain(drive, body, spring, ground)
    for rtol in (1e-6, 1e-10):
        run = gb.simulate(rig, t=[2.0], rtol=rtol, method=method)
        assert run.energy.residual <= 10 * rtol


def _shaken(*, beside):
    """A body that a prescribed speed shakes; beside it nothing, a body that coasts, or one on a slow spring."""
    rig = gb.Drivetrain("shaken")
    rig.chain(rig.add("speed", gb.Speed(w=10 + 5 * gb.sin(30 * gb.time))), rig.add("body", gb.Inertia(J=0.3)))
    if beside != "nothing":
        other = rig.add("other", gb.Inertia(J=0.5, w0=3.0))
        if beside == "slow":
            rig.chain(other, rig.add("spring", gb.Shaft(k=1.0, c=0.01)), rig.add("ground", gb.Fixed()))
    return rig


@pytest.mark.parametrize("beside", ["nothing", pytest.param("coasting", marks=pytest.mark.long), "slow"])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.few(1)
def test_the_ledger_closes_where_time_alone_moves_a_body(method, beside):
    if beside == "nothing" and method == "rodas":
        return  # without a state there is no matrix
    model = gb.build(_shaken(beside=beside))
    for rtol in (1e-4, 1e-6, 1e-9):
        run = gb.simulate(model, t_end=2.0, rtol=rtol, method=method)
        assert run.energy.residual < 10 * rtol, rtol  # a few dozen steps, each within its share


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_torques_that_balance_are_followed_in_the_ledger_though_nothing_accelerates(method):
    rig = gb.Drivetrain("balanced")
    tau, w = 5 * gb.sin(300 * gb.time) ** 2, 2.0
    one, two = rig.add("one", gb.Torque(tau=tau)), rig.add("two", gb.Torque(tau=-tau))
    rig.chain(one, two, rig.add("body", gb.Inertia(J=1.0, w0=w)))
    for rtol in (1e-4, 1e-8):
        run = gb.simulate(rig, t_end=1.0, rtol=rtol, method=method)
        given = w * 2.5 * (1 - np.sin(600) / 600)
        assert run.energy.supplied["one"] == pytest.approx(given, rel=10 * rtol)


def test_a_run_that_loses_more_energy_than_is_asked_for_stops_and_says_so():
    rig = gb.Drivetrain("pendulum")
    rig.chain(
        rig.add("body", gb.Inertia(J=1.0, phi0=1.0)), rig.add("shaft", gb.Shaft(k=1.0)), rig.add("wall", gb.Fixed())
    )
    t = np.linspace(0.0, 1e7, 100_001)
    with pytest.raises(gb.SimulationError, match=r"energy residual is .* above the 1e-06 asked for") as stop:
        gb.simulate(rig, t=t, residual=1e-6)
    assert stop.value.trajectory.energy.residual > 1e-6 and stop.value.time == stop.value.trajectory.t[-1] < 1e7
    assert gb.simulate(rig, t_end=100.0, residual=1e-3).complete
    with pytest.raises(gb.SimulationError, match="smaller rtol"):
        gb.simulate(rig, t_end=100.0, residual=1e-12)  # seen at the end, however short the run
    with pytest.raises(gb.ParameterError, match="residual = 0"):
        gb.simulate(rig, t_end=1.0, residual=0.0)


@pytest.mark.long
def test_what_is_exchanged_counts_every_amount_without_its_sign():
    rig = gb.Drivetrain("two sources")
    drive, brake = rig.add("drive", gb.Torque(tau=5.0)), rig.add("brake", gb.Torque(tau=-3.0))
    rig.chain(drive, brake, rig.add("body", gb.Inertia(J=2.0, w0=1.0)))
    for arguments in ({"t_end": 3.0}, {"t": np.linspace(0, 3, 7)}, {"t_end": 3.0, "method": "rodas", "max_step": 0.1}):
        ledger = gb.simulate(rig, rtol=1e-8, **arguments).energy
        way = 1.0 * 3.0 + 1.0 * 3.0**2 / 2  # alpha = 1 rad/s2
        assert ledger.supplied == pytest.approx({"drive": 5 * way, "brake": -3 * way}, rel=1e-7)
        assert ledger.exchanged == pytest.approx(8 * way, rel=1e-7)
        assert ledger.largest_stored == pytest.approx(16.0, rel=1e-7)
        assert ledger.turnover == pytest.approx(8 * way + 16.0, rel=1e-7)
        assert abs(ledger.imbalance) < 1e-6 * ledger.turnover


@pytest.mark.long
def test_the_largest_energy_is_that_of_the_whole_run():
    rig = gb.Drivetrain("there and back")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.piecewise((3, gb.time < 1), (-3, True)))), rig.add("body", gb.Inertia(J=2.0))
    )
    ledger = gb.simulate(rig, t_end=2.0, rtol=1e-8).energy
    assert ledger.largest_stored == pytest.approx(2.25, rel=1e-7)  # 1.5 rad/s at t = 1
    assert ledger.exchanged == pytest.approx(4.5, rel=1e-7)
    assert ledger.end == pytest.approx(0.0, abs=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp8", "rodas"])
def test_a_prescribed_speed_is_supplied_with_what_it_drives_through_a_stuck_clutch(method):
    rig = gb.Drivetrain("driven")
    speed, one = rig.add("speed", gb.Speed(w=10 + 5 * gb.sin(3 * gb.time))), rig.add("one", gb.Inertia(J=0.3))
    clutch, two = rig.add("clutch", gb.Clutch(capacity=1e3)), rig.add("two", gb.Inertia(J=0.9, w0=10.0))
    rig.chain(speed, one, clutch, two, rig.add("load", gb.Torque(tau=-2.0)))
    for t_end in (0.5, 2.0):
        run = gb.simulate(rig, t_end=t_end, rtol=1e-8, method=method)
        w, way = 10 + 5 * np.sin(3 * t_end), 10 * t_end + 5 / 3 * (1 - np.cos(3 * t_end))
        assert run["two.w"][-1] == pytest.approx(w, rel=1e-7)
        assert run.energy.supplied["load"] == pytest.approx(-2 * way, rel=1e-6)
        assert run.energy.supplied["speed"] == pytest.approx(0.6 * (w**2 - 100) + 2 * way, rel=1e-6)


@pytest.mark.long
def test_a_run_that_goes_on_has_a_ledger_of_its_own():
    rig = gb.Drivetrain("goes on")
    rig.chain(
        rig.add("drive", gb.Torque(tau=2.0)),
        rig.add("body", gb.Inertia(J=1.0)),
        rig.add("drag", gb.SpeedLoad(coeffs=(1.0, 0, 0))),
    )
    first = gb.simulate(rig, t_end=1.0)
    second = gb.simulate(rig, t_end=2.0, initial=first)
    assert second["body.phi"][-1] == pytest.approx(2.0, rel=1e-6)
    ledger = second.energy
    assert ledger.start == pytest.approx(0.5, rel=1e-6)  # 1 rad/s after 1 s, 1.5 rad further on after 2 s
    assert ledger.supplied == pytest.approx({"drive": 3.0}, rel=1e-6)
    assert ledger.dissipated == pytest.approx({"drag": 1.5}, rel=1e-6)
    assert ledger.exchanged == pytest.approx(4.5, rel=1e-6)


class _Pendulum(gb.Block):
    """A body that stores energy of its own: a pendulum; with a second body on a spring inside the block."""

    a, b = gb.Flange("pivot"), gb.Flange("other body", spare=True)

    def physics(self, s):
        yield gb.Body(s.a, 2.0)
        yield gb.Body(s.b, 0.5)
        yield gb.Force(s.b.phi - s.a.phi, 30 * (s.b.phi - s.a.phi))
        yield gb.Acts(s.a, -12 * sp.sin(s.a.phi))
        yield gb.Energy(stored=15 * (s.b.phi - s.a.phi) ** 2 + 12 * (1 - sp.cos(s.a.phi)))


@pytest.mark.long
def test_a_block_of_several_bodies_and_springs_stores_the_sum_of_their_energies():
    rig = gb.Drivetrain("pendulum")
    el = rig.add("el", _Pendulum())
    rig.chain(rig.add("one", gb.Inertia(J=0.1, phi0=0.4)), el, rig.add("two", gb.Inertia(J=0.2, w0=3.0)))
    run = gb.simulate(rig, t_end=2.0, rtol=1e-9)
    phi, w = run["el.a.phi"], run["el.a.w"]
    twist, other = run["el.b.phi"] - phi, run["el.b.w"]
    own = w**2 + 0.25 * other**2 + 15 * twist**2 + 12 * (1 - np.cos(phi))
    assert run.energy.stored["el"] == pytest.approx(own[-1], rel=1e-12)
    whole = own + 0.05 * w**2 + 0.1 * other**2
    assert np.allclose(whole, whole[0], rtol=1e-8)
    assert run.energy.start == pytest.approx(whole[0], rel=1e-12) and run.energy.end == pytest.approx(
        whole[0], rel=1e-8
    )
