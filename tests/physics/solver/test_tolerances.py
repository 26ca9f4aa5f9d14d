"""What a tolerance means: errors of runs in closed form, in units of rtol and of what each body itself moves by."""

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0, 20, 41)


def _oscillators(*amplitudes):
    """Bodies on springs of their own, undamped, each with its own frequency and amplitude; the last are the quickest."""
    rig, true = gb.Drivetrain("oscillators"), {}
    ground = rig.add("ground", gb.Fixed())
    for i, a in enumerate(amplitudes):
        w = (1.0 + 0.3 * i) * (4 if i > 7 else 1)
        body = rig.add(f"body{i}", gb.Inertia(J=0.5, phi0=a))
        rig.chain(body, rig.add(f"spring{i}", gb.Shaft(k=0.5 * w**2)), ground)
        true[f"body{i}"] = a * np.cos(w * T), -a * w * np.sin(w * T), a, a * w
    return rig, true


def _worst(run, true):
    """The largest error of an angle or a speed, over its amplitude."""
    found = 0.0
    for name, (phi, w, size, pace) in true.items():
        found = max(found, np.abs(run[f"{name}.phi"] - phi).max() / size, np.abs(run[f"{name}.w"] - w).max() / pace)
    return found


@pytest.mark.parametrize(("method", "most"), [("dp5", 6), ("dp8", 4), ("rodas", 1)])
def test_three_swings_are_right_to_a_few_tolerances(method, most):
    rig, true = _oscillators(1.0)
    model = gb.build(rig)
    for rtol in (1e-4, 1e-6, 1e-8):
        error = _worst(gb.simulate(model, t=T, method=method, rtol=rtol), true)
        assert error < most * rtol


@pytest.mark.parametrize(("method", "most"), [("dp5", 60), ("dp8", 25), ("rodas", 10)])
def test_every_body_is_followed_to_a_part_of_its_own_amplitude(method, most):
    rig, true = _oscillators(*(10.0 ** (-i / 2) for i in range(10)))
    model = gb.build(rig)
    for rtol in (1e-4, 1e-7):
        error = _worst(gb.simulate(model, t=T, method=method, rtol=rtol), true)
        assert error < most * rtol


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_no_step_is_longer_than_the_largest_one_asked_for(method):
    rig, _ = _oscillators(1.0)
    model = gb.build(rig)
    free, short = (gb.simulate(model, t_end=20.0, method=method, rtol=1e-3, max_step=x) for x in (None, 0.05))
    assert np.diff(free.t).max() > 0.1
    assert 0.04 < np.diff(short.t).max() <= 0.05 * (1 + 1e-9)


@pytest.mark.parametrize("method", ["rk4", "dp5"])
def test_fixed_steps_come_back_to_their_grid_after_an_event(method):
    rig = gb.Drivetrain("kicked")
    tau = gb.piecewise((0, gb.time < 0.234), (1, gb.sense("body.w") < 0.2), (0, True))
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("body", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=1.0, method=method, step=0.1, t_start=0.0)
    times = np.unique(run.t)
    assert times == pytest.approx(sorted([*np.arange(11) / 10, 0.234, 0.434]), abs=1e-9)
    assert run["body.w"][-1] == pytest.approx(0.2, abs=1e-9)


@pytest.mark.parametrize(("method", "order"), [("rk4", 4), ("dp5", 5), ("rodas", 4)])
def test_fixed_steps_keep_their_order_where_a_force_changes_in_time(method, order):
    rig = gb.Drivetrain("forced")
    drive, body = rig.add("drive", gb.Torque(tau=3 * gb.sin(2 * gb.time))), rig.add("body", gb.Inertia(J=1.0))
    rig.chain(drive, body, rig.add("spring", gb.Shaft(k=9.0)), rig.add("ground", gb.Fixed()))
    true = 0.6 * np.sin(2 * T) - 0.4 * np.sin(3 * T)
    model = gb.build(rig)
    steps = (0.1, 0.05, 0.025)
    error = [np.abs(gb.simulate(model, t=T, method=method, step=h)["body.phi"] - true).max() for h in steps]
    assert error[0] / error[1] > 0.8 * 2**order and error[1] / error[2] > 0.8 * 2**order
