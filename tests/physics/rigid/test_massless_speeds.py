"""Speeds of massless groups between dampers, fast beside all else, against the exponential of the matrix."""

import numpy as np
import pytest
from scipy.linalg import expm

import gearblocks as gb

METHODS = ("auto", "dp5", "dp8", "rodas")

# inertias, stiffnesses, dampings (None: undamped) along a chain from a torque of 1 N m to the ground
CHAINS = {
    "one": ((0.025, 0.0, 0.075), (210.0, 1800.0, 7000.0), (0.17, 0.19, None)),
    "slow": ((0.3, 0.0, 0.1), (900.0, 400.0, 2000.0), (8.0, 3.0, 1.0)),
    "two apart": ((0.05, 0.0, 0.2, 0.0, 0.03), (500.0, 3000.0, 900.0, 5000.0, 2500.0), (0.4, 0.1, 0.9, 0.2, None)),
    "two together": ((0.1, 0.0, 0.0, 0.05), (800.0, 2000.0, 1200.0, 3000.0), (0.5, 0.3, 0.7, 0.1)),
}


def chain(inertias, stiffnesses, dampings, tau=1.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("chain")
    parts = [rig.add("source", gb.Torque(tau=tau))]
    for i, (J, k, c) in enumerate(zip(inertias, stiffnesses, dampings, strict=True)):
        parts += [
            rig.add(f"i{i}", gb.Inertia(J=J)),
            rig.add(f"s{i}", gb.Shaft(k=k) if c is None else gb.Shaft(k=k, c=c)),
        ]
    rig.chain(*parts, rig.add("wall", gb.Fixed()))
    return rig


def exact(inertias, stiffnesses, dampings, t):
    """Angles and speeds, shape (2, len(t), n): descriptor form with the massless speeds solved for."""
    n, heavy = len(inertias), [i for i, J in enumerate(inertias) if J > 0]
    light = [i for i in range(n) if i not in heavy]
    K, C = np.zeros((n, n)), np.zeros((n, n))
    for matrix, values in ((K, stiffnesses), (C, [c or 0.0 for c in dampings])):
        for i, value in enumerate(values):
            matrix[i, i] += value
            if i + 1 < n:
                matrix[i + 1, i + 1] += value
                matrix[i, i + 1] -= value
                matrix[i + 1, i] -= value
    size = n + len(heavy) + 1  # angles, speeds, 1
    phi, load = np.eye(n, size), np.zeros((n, size))
    load[0, -1] = 1.0
    w = np.zeros((n, size))
    w[heavy] = np.eye(len(heavy), size, n)
    w[light] = np.linalg.solve(C[np.ix_(light, light)], (load - K @ phi - C @ w)[light])
    A = np.zeros((size, size))
    A[:n] = w
    A[n:-1] = (load - K @ phi - C @ w)[heavy] / np.array([inertias[i] for i in heavy])[:, None]
    step, y = expm(A * (t[1] - t[0])), np.zeros((len(t), size))
    y[0, -1] = 1.0
    for i in range(1, len(t)):
        y[i] = step @ y[i - 1]
    return y[:, :n], y @ w.T


@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.few(1)
def test_speeds_of_massless_shafts_are_as_right_as_those_of_others(name):
    t = np.linspace(0.0, 0.3, 301)
    phi, w = exact(*CHAINS[name], t)
    rig = chain(*CHAINS[name])
    for method in METHODS:
        for rtol in (1e-3, 1e-4, 1e-6, 1e-8, 1e-10):
            run = gb.simulate(rig, t=t, rtol=rtol, method=method)
            for i in range(w.shape[1]):
                for what, right in (("w", w[:, i]), ("phi", phi[:, i])):
                    error = np.max(abs(run[f"i{i}.{what}"] - right)) / np.max(abs(right))
                    # 30: the last body moves a fiftieth of what the first does; tolerances are those of twists
                    assert error < 30 * rtol, (method, rtol, i, what, error / rtol)


@pytest.mark.long
@pytest.mark.parametrize("name", ["one", *(pytest.param(x, marks=pytest.mark.long) for x in CHAINS if x != "one")])
def test_a_ramp_from_rest_finds_its_first_step_at_any_tolerance(name):
    """Linear: the speeds under t N m are the angles under 1 N m. rodas once began with 1e-157 s at 1e-10."""
    t = np.linspace(0.0, 0.3, 301)
    phi, _ = exact(*CHAINS[name], t)
    rig = chain(*CHAINS[name], tau=gb.time)
    for method in METHODS:
        for rtol in (1e-6, 1e-8, 1e-10):
            run = gb.simulate(rig, t=t, rtol=rtol, method=method)
            for i in range(phi.shape[1]):
                error = np.max(abs(run[f"i{i}.w"] - phi[:, i])) / np.max(abs(phi[:, i]))
                assert error < 30 * rtol, (method, rtol, i, error / rtol)


@pytest.mark.parametrize("method", ["dp8", "auto"])
def test_a_massless_speed_is_right_between_the_steps(method):
    """A cubic shaft swings a gear set, which a shaft without damping and a weakly damped one tie to a body: the polynomial of
    a twist is within the tolerance, the speed of the shaft without inertia, k/c times as sensitive, was off by 75 of them,
    by more than 10 at an eighth of the samples. Few insides are looked at: 20 at most, and 10 at 99 of 100."""
    rig = gb.Drivetrain("cubic")
    sun, ring = rig.add("sun", gb.Inertia(J=0.229, phi0=0.137, w0=-10.0)), rig.add("ring", gb.Inertia(J=0.119, w0=0.0))
    carrier, body = rig.add("carrier", gb.Inertia(J=0.5)), rig.add("body", gb.Inertia(J=0.1, w0=-1.32))
    light, gears = rig.add("light", gb.Inertia(J=0.0)), rig.add("gears", gb.IdealPlanetary(ratio=0.5))
    rig.connect(sun.a, gears.sun)
    rig.connect(ring.a, gears.ring)
    cubic = gb.Shaft(torque=123.0 * gb.twist + 983.0 * gb.twist**3)
    rig.connect(rig.add("drive", gb.Torque(tau=14.7)).flange, carrier.b)
    rig.connect(carrier.a, gears.carrier)
    rig.connect(carrier.a, rig.add("cubic", cubic).a)
    rig.connect(rig["cubic"].b, rig.add("wall", gb.Fixed()).flange)
    rig.chain(sun, rig.add("stiff", gb.Shaft(k=121.0)), light, rig.add("soft", gb.Shaft(k=42.1, c=0.363)), body)
    model, t = gb.build(rig), np.linspace(0.0, 0.5, 1001)
    right, other = (gb.simulate(model, t=t, rtol=1e-11, method=x)["light.w"] for x in ("rodas", "dp5"))
    size = np.abs(right).max()
    assert np.abs(other - right).max() < 1e-10 * size
    for rtol in (1e-6, 1e-7, 1e-8, 1e-9):
        off = np.abs(gb.simulate(model, t=t, rtol=rtol, method=method)["light.w"] - right) / (rtol * size)
        assert off.max() < 20, (rtol, off.max())
        assert np.mean(off > 10) < 0.01, (rtol, np.mean(off > 10))
