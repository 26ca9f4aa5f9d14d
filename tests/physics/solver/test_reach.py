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


# -- parts of a train that nothing couples -------------------------------------------------------------------------------

APART = [
    (1.6, 9000.0, 300.0, 4.0, "step"), (1.6, 9000.0, 300.0, 4.0, "ramp"), (0.3, 4000.0, 80.0, 30.0, "step"),
    (4.0, 26000.0, 800.0, 1.0, "ramp"), (1.6, 9000.0, 300.0, 4.0, "clutch"), (0.3, 4000.0, 80.0, 9.0, "clutch"),
]  # fmt: skip


def _parts(J, k, c, slow, load):
    """A pendulum of a disc, and a driveline at rest that is set in motion 5 s later: by a torque, or by a clutch to the disc
    that slips for good."""
    jump = load == "step"
    torque = gb.Table([0.0, 5.0, 5.0 if jump else 6.0, 20.0], [0.0, 0.0, 100.0, 100.0 if jump else 1500.0])
    rig = gb.Drivetrain("apart")
    disc, half = rig.add("disc", gb.Inertia(J=1.0, w0=1.0)), rig.add("half", gb.Shaft(k=k, c=c))
    rig.chain(rig.add("wall", gb.Fixed()), rig.add("spring", gb.Shaft(k=slow, c=0.1)), disc)
    b, car = rig.add("b", gb.Inertia(J=J)), rig.add("car", gb.Inertia(J=100.0 * J))
    if load == "clutch":
        fly = rig.add("fly", gb.Inertia(J=1e4, w0=400.0))
        rig.chain(fly, rig.add("clutch", gb.Clutch(capacity=torque)), b, half, car)
    else:
        rig.chain(rig.add("drive", gb.Torque(tau=torque)), b, half, car)
    return rig


@pytest.mark.parametrize("method", ["dp8", "auto"])
@pytest.mark.parametrize("case", APART, ids=str)
@pytest.mark.few(1)
def test_a_part_that_moves_late_and_that_nothing_couples_is_right_between_the_steps(case, method):
    """How fast its rates answer was asked in a direction that never left the part which moved first: steps were twice and more
    as long as the method reaches, and off by 237 tolerances inside, silently."""
    J, k, c, slow, load = case
    A = np.zeros((7, 7))  # disc.phi, disc.w, twist, b.w, car.w, load and its slope
    A[0, 1], A[1, 0], A[1, 1] = 1.0, -slow, -0.1
    A[2, 3:5], A[5, 6] = [-1.0, 1.0], 1.0
    A[3, 2:6] = np.array([k, -c, c, 1.0]) / J
    A[4, 2:5] = np.array([-k, c, -c]) / (100.0 * J)
    t = np.linspace(0.0, 8.0, 1601)
    step, y = expm(A * t[1]), [np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])]
    for i in range(1600):
        if i in (1000, 1200):
            y[-1][5:] = [100.0, 0.0] if load == "step" else [100.0 * (i == 1200), 100.0]
        y.append(step @ y[-1])
    right = np.array(y)
    model = gb.build(_parts(*case))
    for rtol in (1e-4, 1e-6, 1e-7, 1e-8, 1e-9):
        run = gb.simulate(model, t=t, rtol=rtol, method=method)
        for name, values in (("disc.w", right[:, 1]), ("half.twist", right[:, 2]), ("b.w", right[:, 3])):
            assert np.max(abs(run[name] - values)) < 10 * rtol * np.max(abs(values)), (rtol, name)


@pytest.mark.parametrize(
    ("J", "k", "c", "size", "t0", "capacity"),
    [(2.25973488, 2043.3277, 146.579231, 98.3911878, 7.73253819, 29.5173563),
     (4.54975, 906.64695, 35.04279, 224.59277, 3.83453896, 449.0)],
)  # fmt: skip
def test_a_part_that_a_pulse_drives_late_through_a_clutch_is_right_between_the_steps(J, k, c, size, t0, capacity):
    """No event tells that it begins to move: steps that grow ask again how fast its rates answer (259 tolerances off)."""
    rig = gb.Drivetrain("pulse")
    disc, half = rig.add("disc", gb.Inertia(J=1.0, w0=1.0)), rig.add("half", gb.Shaft(k=k, c=c))
    damping = 1.0 if capacity < size else 0.1
    rig.chain(rig.add("wall", gb.Fixed()), rig.add("spring", gb.Shaft(k=4.0, c=damping)), disc)
    J_b = 4.0 if capacity < size else 0.3
    motor, clutch = rig.add("motor", gb.Inertia(J=J)), rig.add("clutch", gb.Clutch(capacity=capacity))
    b, car = rig.add("b", gb.Inertia(J=J_b)), rig.add("car", gb.Inertia(J=100 * J_b))
    rig.chain(rig.add("drive", gb.Torque(tau=size * gb.exp(-((gb.time - t0) ** 4)))), motor, clutch, b, half, car)
    model, t = gb.build(rig), np.linspace(0.0, 12.0, 1501)
    right = gb.simulate(model, t=t, rtol=1e-11, method="rodas")
    for rtol in (1e-4, 1e-6, 1e-7, 1e-8):
        run = gb.simulate(model, t=t, rtol=rtol, method="dp8")
        for name in ("disc.w", "b.w", "half.twist"):
            error = np.max(abs(run[name] - right[name])) / np.max(abs(right[name]))
            assert error < 10 * rtol, (rtol, name, error / rtol)


def _shipped(name):
    path = Path(__file__).parents[3] / "models" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(f"{name}_reach", path)
    shipped = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(shipped)
    return gb.build(shipped.build())


@pytest.mark.parametrize("method", ["dp8", "auto"])
@pytest.mark.few(1)
def test_a_launch_is_right_between_the_steps(method):
    """The driveline rests behind an open clutch while the engine runs: 24 tolerances off inside a step."""
    model, t = _shipped("dual_clutch"), np.linspace(0.0, 3.0, 601)
    right = gb.simulate(model, t=t, rtol=1e-11, method="rodas")
    for rtol in (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9):
        run = gb.simulate(model, t=t, rtol=rtol, method=method)
        for name in ("crank.w", "output.w", "half_shafts.twist", "car.v"):
            error = np.max(abs(run[name] - right[name])) / np.max(abs(right[name]))
            assert error < 8 * rtol, (rtol, name, error / rtol)


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
    for case in _gearbox_errors(_shipped("automatic_gearbox"), 9.7, [("dp8", 1e-10)]):
        assert case[-1] < 8, case


@pytest.mark.long
def test_the_automatic_gearbox_is_right_with_every_method():
    tolerances = (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
    cases = [(method, rtol) for method in ("auto", "dp5", "dp8", "rodas") for rtol in tolerances]
    for case in _gearbox_errors(_shipped("automatic_gearbox"), 60.0, cases):
        assert case[-1] < 10, case
