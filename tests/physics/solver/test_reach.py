"""Explicit steps beside fast damped motions: the estimate of the error and the polynomial inside a step tell the truth."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import gearblocks as gb
from gearblocks.solver.methods import DP8


def estimate_and_error(z: complex) -> tuple[float, float]:
    """Of one step of y' = z y of size 1 with the pair 8(5,3): its joined estimate, and its true error."""
    rates = []
    for row in DP8.a:
        rates.append(z * (1 + sum(a * k for a, k in zip(row, rates, strict=False))))
    e5, e3 = (abs(sum(e * k for e, k in zip(row, rates, strict=False))) for row in DP8.errors)
    new = 1 + sum(b * k for b, k in zip(DP8.b, rates, strict=True))
    return e5**2 / np.hypot(e5, 0.1 * e3), abs(new - np.exp(z))


def test_within_its_reach_the_estimate_covers_the_error_and_beyond_it_does_not():
    for angle in np.linspace(np.pi / 2, np.pi, 13):
        for size in np.linspace(0.5, DP8.reach, 15):
            estimate, error = estimate_and_error(size * np.exp(1j * angle))
            assert error < estimate, (angle, size)
    beyond = [estimate_and_error(z) for z in np.linspace(-6.2, -5.2, 21)]
    assert max(error / estimate for estimate, error in beyond) > 20


@pytest.mark.parametrize("method", ["dp8", "dp5", "auto"])
@pytest.mark.parametrize(("J", "k", "c"), [(1e-3, 50.0, 2.0), (4e-4, 8.0, 0.6), (2e-3, 1e4, 6.0)])
@pytest.mark.few(1)
def test_a_light_inertia_in_a_strong_damper_is_right_between_the_steps(method, J, k, c):
    """A slow inertia drives a light one through a shaft; to the ground it has a damper, whose rate c/J holds explicit steps."""
    rig = gb.Drivetrain("light")
    rig.chain(
        rig.add("source", gb.Torque(tau=1.0)), rig.add("slow", gb.Inertia(J=0.5)), rig.add("shaft", gb.Shaft(k=k)),
        rig.add("light", gb.Inertia(J=J)), rig.add("damper", gb.Damper(c=c)), rig.add("wall", gb.Fixed()),
    )  # fmt: skip
    A = np.zeros((4, 4))  # twist, slow.w, light.w, 1
    A[0] = [0, -1, 1, 0]
    A[1] = [k / 0.5, 0, 0, 2]
    A[2] = [-k / J, 0, -c / J, 0]
    t = np.linspace(0.0, 0.5, 201)
    step, y = expm(A * t[1]), [np.array([0.0, 0.0, 0.0, 1.0])]
    for _ in t[1:]:
        y.append(step @ y[-1])
    right = np.array(y)
    for rtol in (1e-4, 1e-6, 1e-8):
        run = gb.simulate(rig, t=t, rtol=rtol, method=method)
        for name, values in (("shaft.twist", right[:, 0]), ("slow.w", right[:, 1]), ("light.w", right[:, 2])):
            assert np.max(abs(run[name] - values)) < 10 * rtol * np.max(abs(values)), (rtol, name)


GROWING = [
    (1e-3, 50.0, 2.0, 0.8, 16, 1e-8, 1e3), (1e-3, 50.0, 2.0, 0.8, 16, 1e-8, 1e4), (1e-3, 50.0, 2.0, 0.8, 8, 1e-8, 1e4),
    (4e-4, 8.0, 0.6, 0.8, 8, 1e-6, 1e3), (4e-4, 8.0, 0.6, 0.8, 16, 1e-6, 1e2), (4e-4, 8.0, 0.6, 1.2, 16, 1e-4, 1e3),
]  # fmt: skip


@pytest.mark.parametrize("method", ["dp8", "auto"])
@pytest.mark.parametrize(("J", "k", "c", "pace", "power", "rtol", "size"), GROWING)
@pytest.mark.few(1)
def test_steps_that_are_held_back_are_right_inside_while_what_they_follow_grows(
    method, J, k, c, pace, power, rtol, size, reference
):
    """A light inertia in a strong damper holds steps back while a vibration comes up from nothing: the steps do not grow, so
    nobody looked, and the estimates of their ends pass zero (46 tolerances off inside)."""
    rig = gb.Drivetrain("light")
    light = rig.add("light", gb.Inertia(J=J))
    rig.chain(
        rig.add("source", gb.Torque(tau=1.0)), rig.add("slow", gb.Inertia(J=0.5)), rig.add("shaft", gb.Shaft(k=k)),
        light, rig.add("damper", gb.Damper(c=c)), rig.add("wall", gb.Fixed()),
    )  # fmt: skip
    end, w = 0.2, pace * c / J
    comes = size * rtol * (gb.time / end) ** power * gb.sin(w * gb.time)
    rig.connect(rig.add("engine", gb.Torque(tau=comes)).flange, light.a)

    def rates(t, y, modes):
        twist, slow, fast = y
        tau = size * rtol * (t / end) ** power * np.sin(w * t)
        return [fast - slow, (1.0 + k * twist) / 0.5, (tau - k * twist - c * fast) / J]

    t = np.linspace(0.0, end, 1001)
    right = reference(rates, [0.0, 0.0, 0.0], t)
    run = gb.simulate(rig, t=t, rtol=rtol, method=method)
    for name, values in zip(("shaft.twist", "slow.w", "light.w"), right.T, strict=True):
        error = np.max(abs(run[name] - values)) / np.max(abs(values))
        assert error < 8 * rtol, (name, error / rtol)


def _gearbox():
    path = Path(__file__).parents[3] / "models" / "automatic_gearbox.py"
    spec = importlib.util.spec_from_file_location("automatic_gearbox_reach", path)
    shipped = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(shipped)
    return gb.build(shipped.build())


def _gearbox_errors(model, end, cases):
    """Samples closer than the steps: their insides are the worst."""
    t = np.linspace(0.0, end, int(200 * end) + 1)
    right = gb.simulate(model, t=t, rtol=1e-12, method="rodas")
    for method, rtol in cases:
        run = gb.simulate(model, t=t, rtol=rtol, method=method)
        for name in ("half_shafts.torque", "half_shafts.twist", "crank.w", "ring.w", "turbine.w", "car.v", "wheels.w"):
            error = np.max(abs(run[name] - right[name])) / np.max(abs(right[name]))
            yield method, rtol, name, error / rtol


def test_steps_that_grow_little_by_little_are_looked_into():
    """Each longer than the last by less than what is looked at: the inside of a step of dp8 was off by 13 rtol."""
    for case in _gearbox_errors(_gearbox(), 9.7, [("dp8", 1e-10)]):
        assert case[-1] < 8, case


@pytest.mark.long
def test_the_automatic_gearbox_is_right_with_every_method():
    tolerances = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
    cases = [(method, rtol) for method in ("auto", "dp5", "dp8", "rodas") for rtol in tolerances]
    for case in _gearbox_errors(_gearbox(), 60.0, cases):
        assert case[-1] < 10, case
