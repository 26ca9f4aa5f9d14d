"""Massless groups beside laws over speed that are flat at rest or saturate, against scipy (1e-11)."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

T = np.linspace(0.0, 1.0, 101)


def behind_a_spring(load: gb.Block, k: float = 50.0, w0: float = 30.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("load without inertia")
    rig.chain(rig.add("motor", gb.Inertia(J=1.0, w0=w0)), rig.add("shaft", gb.Shaft(k=k)), rig.add("load", load))
    return rig


@pytest.mark.parametrize("method", ["auto", "dp8", "rodas"])
@pytest.mark.parametrize("c1", [1e-6, 1e-3, 0.1, 10.0])
def test_a_pump_at_the_end_of_a_shaft(method: str, c1: float) -> None:
    """k twist = -sign(w) (c1 |w| + c2 w^2) of the hub: whole Newton steps from rest are T/c1 and far off."""
    k, c2 = 50.0, 0.5

    def rates(_t, y):
        pulled = -k * y[1]  # by the hub behind
        size = 2 * abs(pulled) / (c1 + np.sqrt(c1**2 + 4 * c2 * abs(pulled)))
        return [k * y[1], np.sign(pulled) * size - y[0]]

    halt = lambda _t, y: y[1]  # noqa: E731  the root of the load has a corner
    halt.terminal = True
    y, at, rows = np.array([30.0, -1e-13]), 0.0, np.zeros((2, 101))
    while at < 1.0:
        part = solve_ivp(rates, (at, 1.0), y, "Radau", rtol=1e-11, atol=1e-13, events=halt, dense_output=True)
        inside = (at <= T) & (part.t[-1] >= T)
        rows[:, inside] = part.sol(T[inside])
        at, y = part.t[-1], part.y[:, -1]
        y[1] = np.copysign(1e-13, -y[1] if part.status == 0 else y[0] * -1)
    run = gb.simulate(behind_a_spring(gb.SpeedLoad(coeffs=(0, c1, c2))), t=T, rtol=1e-9, method=method)
    assert np.abs(run["motor.w"] - rows[0]).max() < 1e-6 * 30.0
    assert run.energy.residual < 1e-7


@pytest.mark.parametrize("method", ["auto", "rodas"])
def test_a_tyre_on_a_hub_without_inertia_passes_the_torque_on(method: str) -> None:
    """m v = integral of tau/R, and the slip is that of the force, up to 0.8 of the grip: the law saturates."""
    R, m, K, N, grip, v0 = 0.31, 1100.0, 6e4, 3e3, 0.9, 0.4
    rig, tau = gb.Drivetrain("hub"), 0.8 * grip * N * R
    tyre = gb.Tyre(radius=R, stiffness=K, grip=grip, low_speed=v0, normal_force=N)
    rig.chain(
        rig.add("drive", gb.Torque(tau=tau * gb.sin(3 * gb.time))), rig.add("tyre", tyre),
        rig.add("car", gb.Chassis(mass=m)),
    )  # fmt: skip
    run = gb.simulate(rig, t=T, rtol=1e-10, method=method)
    v, share = tau / R / m * (1 - np.cos(3 * T)) / 3, 0.8 * np.sin(3 * T)
    slip = grip * N / K * share / np.sqrt(1 - share**2)  # F = D sin(atan(K slip/D))
    assert np.abs(run["car.v"] - v).max() < 1e-8
    assert np.abs(run["tyre.slip"] - slip).max() < 1e-8 * slip.max()
    assert run.stats.steps < 500


def test_a_load_beyond_its_largest_torque_is_named() -> None:
    """An eddy-current brake gives at most tau_nominal: k twist reaches it at a time that the rising branch tells."""
    k, most, w_n, w0 = 50.0, 10.0, 2.0, 3.0
    rig = behind_a_spring(gb.EddyCurrentBrake(tau_nominal=most, w_nominal=w_n), k, w0)

    def hub(T):
        return w_n * T / (most + np.sqrt(max(most**2 - T**2, 0.0)))

    full = lambda _t, y: y[1] - most / k * (1 - 1e-9)  # noqa: E731
    full.terminal = True
    end = solve_ivp(
        lambda _t, y: [-k * y[1], y[0] - hub(min(k * max(y[1], 0.0), most))], (0, 1), [w0, 0.0], "DOP853", rtol=1e-9,
        atol=1e-11, events=full,
    ).t[-1]  # fmt: skip
    with pytest.raises(gb.SimulationError, match=r"'load': .* largest torque") as stopped:
        gb.simulate(rig, t_end=1.0, rtol=1e-9)
    assert abs(stopped.value.time - end) < 1e-4


@pytest.mark.parametrize("slides", [True, False])
def test_friction_that_falls_by_more_than_what_damps_its_shaft_is_named(slides: bool) -> None:
    """dF/dslip = -3 at rest beside c = 0.7 of the springs: the balance has no speed near 0 but rest."""
    rig, law = gb.Drivetrain("falling"), 2.0 + gb.exp(-3.0 * gb.slip)
    one, two = (gb.Mass(m=0.3, v0=2.0), gb.Mass(m=0.8)) if slides else (gb.Inertia(J=0.3, w0=2.0), gb.Inertia(J=0.8))
    left, right = rig.add("left", gb.Shaft(k=300.0, c=0.4)), rig.add("right", gb.Shaft(k=500.0, c=0.3))
    rig.chain(rig.add("one", one), left, right, rig.add("two", two))
    rig.connect(left.b, rig.add("friction", gb.BearingFriction(torque=law)).a)
    with pytest.raises(gb.SimulationError, match=r"'friction': .* of its slip about .* falls with the slip by more"):
        gb.simulate(rig, t_end=1.0)
