"""What a tolerance means: errors of runs in closed form, in units of rtol and of what each body itself moves by."""

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0, 20, 41)


def _oscillators(*amplitudes):
    """Bodies on springs of their own, undamped, each with its own frequency and amplitude."""
    rig, true = gb.Drivetrain("oscillators"), {}
    ground = rig.add("ground", gb.Fixed())
    for i, a in enumerate(amplitudes):
        w = 1.0 + 0.3 * i
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


@pytest.mark.parametrize(("method", "most"), [("dp5", 15), ("dp8", 6), ("rodas", 2)])
def test_every_body_is_followed_to_a_part_of_its_own_amplitude(method, most):
    rig, true = _oscillators(*(10.0 ** (-i / 2) for i in range(10)))
    model = gb.build(rig)
    for rtol in (1e-4, 1e-7):
        error = _worst(gb.simulate(model, t=T, method=method, rtol=rtol), true)
        assert error < most * rtol
