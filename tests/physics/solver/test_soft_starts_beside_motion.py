"""A load that rises softly from rest while another part of the train moves already.

Its force is a small difference of large numbers, and what it moves has no scale yet: neither may set the steps.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

T = gb.time

# torque, the same for numpy without cancellation
RISES = {
    "1 - cos": (7 * (1 - gb.cos(2 * T)), lambda t: 14 * np.sin(t) ** 2),
    "1 - exp": (7 * (1 - gb.exp(-T / 0.3)), lambda t: -7 * np.expm1(-t / 0.3)),
    "cos - cos": (7 * (gb.cos(T) - gb.cos(3 * T)), lambda t: 14 * np.sin(2 * t) * np.sin(t)),
    "sqrt": (7 * (gb.sqrt(1 + T * T) - 1), lambda t: 7 * t * t / (1 + np.sqrt(1 + t * t))),
    "tanh": (7 * gb.tanh(T / 0.3), lambda t: 7 * np.tanh(t / 0.3)),
    "a power of 1 - cos": (7 * (1 - gb.cos(T)) ** 2, lambda t: 28 * np.sin(t / 2) ** 4),
    "t^3": (7 * T**3, lambda t: 7 * t**3),
    "t^4": (7 * T**4, lambda t: 7 * t**4),
    "t^6": (7 * T**6, lambda t: 7 * t**6),
}
AT = np.linspace(0.0, 1.0, 11)


def _train(torque):
    """Two bodies with a shaft between them, and a third one that turns for itself."""
    rig = gb.Drivetrain("soft beside motion")
    rig.chain(rig.add("steady", gb.Torque(tau=1.0)), rig.add("other", gb.Inertia(J=0.1, w0=0.0)))
    rig.chain(
        rig.add("source", gb.Torque(tau=torque)), rig.add("a", gb.Inertia(J=0.2)), rig.add("shaft", gb.Shaft(k=270.0)),
        rig.add("b", gb.Inertia(J=0.2)),
    )  # fmt: skip
    return rig


def _right(torque):
    def rates(t, y):
        return [y[1], (torque(t) - 270 * (y[0] - y[2])) / 0.2, y[3], 270 * (y[0] - y[2]) / 0.2]

    return solve_ivp(rates, (0, 1), np.zeros(4), method="DOP853", rtol=1e-13, atol=1e-20, t_eval=AT, max_step=0.01).y


@pytest.mark.parametrize("name", RISES)
@pytest.mark.few(3)
def test_a_soft_start_beside_what_moves(name):
    torque, exact = RISES[name]
    model, right = gb.build(_train(torque)), _right(exact)
    twist = right[2] - right[0]
    for method in ("auto", "dp5", "dp8", "rodas"):
        for rtol in (1e-4, 1e-6, 1e-8, 1e-9):
            run = gb.simulate(model, t=AT, method=method, rtol=rtol)
            assert run.stats.steps < {1e-4: 250, 1e-6: 500, 1e-8: 1000, 1e-9: 1600}[rtol], (method, rtol)
            for found, values in ((run["a.w"], right[1]), (run["b.w"], right[3]), (run["shaft.twist"], twist)):
                assert np.abs(found - values).max() < 20 * rtol * np.abs(values).max(), (method, rtol)
            assert run["other.w"][-1] == pytest.approx(10.0, rel=rtol)
            assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_amplitudes_that_cancel_by_their_values_start_softly_too(method):
    """Numbers of parameters, which no rewriting of the formula can see."""
    a, b = gb.Parameter("a", 3.0, "N*m"), gb.Parameter("b", 3.0, "N*m")
    model = gb.build(_train(a - b * gb.cos(2 * T)))
    right = _right(lambda t: 6 * np.sin(t) ** 2)
    for rtol in (1e-6, 1e-9):
        run = gb.simulate(model, t=AT, method=method, rtol=rtol)
        assert run.stats.steps < 1200
        assert np.abs(run["a.w"] - right[1]).max() < 20 * rtol * np.abs(right[1]).max()


def test_rodas_keeps_its_order_with_a_load_over_time():
    """The slope in time comes from all instants of a step: a thousandth of the tolerance costs what order five asks."""
    rig = gb.Drivetrain("wave")
    rig.chain(
        rig.add("source", gb.Torque(tau=gb.sin(9 * T) * gb.exp(gb.cos(4 * T)))), rig.add("a", gb.Inertia(J=0.2)),
        rig.add("shaft", gb.Shaft(k=270.0, c=0.5)), rig.add("wall", gb.Fixed()),
    )  # fmt: skip

    def rates(t, y):
        return [y[1], (np.sin(9 * t) * np.exp(np.cos(4 * t)) - 270 * y[0] - 0.5 * y[1]) / 0.2]

    right = solve_ivp(
        rates, (0, 1), np.zeros(2), method="DOP853", rtol=1e-13, atol=1e-18, max_step=0.01, t_eval=[1.0]
    ).y
    model, errors = gb.build(rig), []
    for step in (0.01, 0.005):
        run = gb.simulate(model, t=[0.0, 1.0], method="rodas", step=step)
        errors.append(abs(run["a.w"][-1] - right[1, 0]))
    assert 4.5 < np.log2(errors[0] / errors[1]) < 6.5, errors
