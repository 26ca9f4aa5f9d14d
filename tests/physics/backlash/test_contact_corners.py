"""Corners of contacts with backlash: orders across them, errors that follow the tolerance, no double crossing missed."""

import numpy as np
import pytest

import gearblocks as gb

# P2, one gear pair (Kahraman-Singh form): x'' + 2 z x' + (1 + eps cos w t) g(x) = Fm + Fah w^2 cos w t, gap +-1
Z, EPS, FM, FAH, W = 0.05, 0.2, 0.1, 0.05, 0.9


def _p2():
    """Inertia 1 and radius 1 against the ground: the deflection is the angle."""
    rig = gb.Drivetrain("P2")
    body, ground = rig.add("body", gb.Inertia(J=1.0, phi0=1.1)), rig.add("ground", gb.Fixed())
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20, radius=1.0, k=1.0, c=2 * Z, stiffness_variation=gb.Fourier(cos=(EPS,), driven_by=W),
            backlash=gb.Backlash(half_gap=1.0), contact_damping="always",
        ),
    )  # fmt: skip
    drive = rig.add("drive", gb.Torque(tau=FM + FAH * W**2 * gb.cos(W * gb.time)))
    rig.chain(drive, body, mesh, ground)
    return rig


PERIODS = 8
T = 2 * np.pi / W * np.arange(1, PERIODS + 1)
T_END = float(T[-1])


def _error(run, true):
    """Root mean square over the samples of the distance in the phase plane."""
    return np.sqrt(np.mean((run["body.phi"] - true["body.phi"]) ** 2 + (run["body.w"] - true["body.w"]) ** 2))


@pytest.fixture(scope="module")
def p2():
    model = gb.build(_p2())
    return model, gb.simulate(model, t=T, rtol=1e-14, method="dp8")


def test_p2_is_the_equation_of_the_gear_pair(p2, reference):
    model, _ = p2

    def rates(t, y, modes):
        g = y[0] - 1 if modes[0] > 0 else y[0] + 1 if modes[1] < 0 else 0.0
        return y[1], FM + FAH * W**2 * np.cos(W * t) - 2 * Z * y[1] - (1 + EPS * np.cos(W * t)) * g

    t = np.linspace(0, T_END, 81)
    true = reference(rates, (1.1, 0.0), t, lambda t, y: (y[0] - 1, y[0] + 1), max_step=0.1)
    run = gb.simulate(model, t=t, rtol=1e-13)
    assert run.stats.events >= 8
    assert np.abs(run["mesh.deflection"] - true[:, 0]).max() < 1e-10


@pytest.mark.numeric
@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [
        ("rk4", 4, (40, 55, 75, 100, 140, 190, 260, 350, 480)),
        ("dp5", 5, (13, 18, 25, 34, 46, 62, 85, 115)),
        ("dp8", 8, (14, 16, 18, 20, 22, 24, 26, 28)),
    ],
)
def test_a_fixed_step_method_keeps_its_order_across_corners(method, order, steps, p2):
    """Steps per period. Where in a step a corner falls is chance, so the error scatters by a factor of 2 about its line:
    hence the mean over 8 samples, and many step sizes."""
    model, true = p2
    errors = []
    for n in steps:
        run = gb.simulate(model, t=T, method=method, step=2 * np.pi / W / n, outputs=["body.phi", "body.w"])
        assert run.stats.events == true.stats.events
        errors.append(_error(run, true))
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert max(errors) < 1e-4
    assert min(errors) > 1e-11
    assert slope >= order - 0.3, (slope, errors)


def test_without_located_corners_the_order_is_lost(p2):
    model, true = p2
    errors = []
    for n in (45, 70, 100, 150, 220):
        run = gb.simulate(model, t=T, method="dp8", step=2 * np.pi / W / n, locate=False)
        errors.append(_error(run, true))
    assert -np.polyfit(np.log((45, 70, 100, 150, 220)), np.log(errors), 1)[0] < 4


@pytest.mark.parametrize("method", ["dp5", "dp8"])
def test_errors_follow_the_tolerance(method, p2):
    model, true = p2
    tolerances = 10.0 ** -np.arange(3, 13)
    errors = []
    for rtol in tolerances:
        run = gb.simulate(model, t=T, method=method, rtol=rtol)
        errors.append(_error(run, true))
        assert run.stats.events == true.stats.events
        # the motion is 2 wide and some 100 steps long; every corner may double an error
        assert errors[-1] < 300 * rtol, rtol
    slope = np.polyfit(np.log10(tolerances), np.log10(np.maximum(errors, 1e-14)), 1)[0]
    assert 0.75 < slope < 1.35


def _p1():
    """P1: four discs, two shafts, a spline with backlash between."""
    rig = gb.Drivetrain("P1")
    J, k, km, r, b, T, w = (5e-3, 2e-4, 2e-4, 1e-2), 1e5, 245e6, 0.025, 20e-6, 2600.0, 4.2e4
    twist, arc = T / k, (T / r / km + b) / r
    angles = (0.0, -twist, -twist - arc, -2 * twist - arc)
    discs = [rig.add(f"disc{i}", gb.Inertia(J=J[i], phi0=angles[i], w0=0.0)) for i in range(4)]
    left, right = (rig.add(n, gb.Shaft(k=k, damping_ratio=0.05)) for n in ("left", "right"))
    mesh = rig.add("mesh", gb.SplineCoupling(
        teeth=20, radius=r, k=km, damping_ratio=0.05, stiffness_variation=gb.Fourier(cos=(0.3,), driven_by=w),
        backlash=gb.Backlash(half_gap=b), contact_damping="always",
    ))  # fmt: skip
    drive, load = (
        rig.add("drive", gb.Torque(tau=T * (1 + 0.1 * gb.cos(w * gb.time)))),
        rig.add("load", gb.Torque(tau=-T)),
    )
    rig.chain(drive, discs[0], left, discs[1], mesh, discs[2], right, discs[3], load)
    return rig


def test_no_double_crossing_is_missed_on_p1():
    model = gb.build(_p1())
    t = [0.004]  # some hundred corners; the motion is chaotic and later counts need not agree
    fine = gb.simulate(model, t=t, method="dp8", step=2 * np.pi / 4.2e4 / 400)
    for method, rtol in (("dp5", 1e-4), ("dp8", 1e-4), ("dp8", 1e-6)):
        run = gb.simulate(model, t=t, method=method, rtol=rtol)
        assert run.stats.events == fine.stats.events > 50, (method, rtol)
        here, there = np.array([e.t for e in run.events]), np.array([e.t for e in fine.events])
        assert np.abs(here - there).max() < 0.02 * 2 * np.pi / 4.2e4


def _eight_meshes():
    """A sun and eight planets that do not act on each other but through the sun: eight gaps that open and close."""
    rig = gb.Drivetrain("eight meshes in parallel")
    sun = rig.add("sun", gb.Inertia(J=2e-4))
    w = 6e4
    drive = rig.add("drive", gb.Torque(tau=300 * (1 + 0.5 * gb.cos(w * gb.time))))
    rig.connect(drive.flange, sun.a)
    for i in range(8):
        variation = gb.Fourier(cos=(0.25,), driven_by=w, phase=2 * np.pi * (3 * i % 8) / 8)
        mesh = rig.add(f"mesh{i}", gb.GearMesh(
            teeth=(30, 20), r_base=(0.03, 0.02), external=True, k=2e8, c=0.02 * np.sqrt(2e8 * 4e-5 / 4e-4),
            stiffness_variation=variation, backlash=gb.Backlash(half_gap=1e-6 * (1 + i)), contact_damping="always",
        ))  # fmt: skip
        planet, load = rig.add(f"planet{i}", gb.Inertia(J=4e-5)), rig.add(f"load{i}", gb.Torque(tau=300 / 8 * 2 / 3))
        rig.connect(sun.b, mesh.pinion)
        rig.connect(mesh.wheel, planet.a, load.flange)
    return rig


@pytest.mark.long
def test_no_double_crossing_is_missed_on_eight_meshes_in_parallel():
    model = gb.build(_eight_meshes())
    t = [1.2e-3]
    fine = gb.simulate(model, t=t, method="dp8", step=2 * np.pi / 6e4 / 400)
    for method in ("dp5", "dp8"):
        run = gb.simulate(model, t=t, method=method, rtol=1e-4)
        counts = [
            {c: sum(e.component == c for e in r.events) for c in (f"mesh{i}" for i in range(8))} for r in (run, fine)
        ]
        assert counts[0] == counts[1], method
        assert run.stats.events > 80
        assert min(counts[1].values()) >= 2
