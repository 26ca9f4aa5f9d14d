"""Stiff trains: the implicit method and the choice of the method."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.errors import ParameterError


def chain(n: int = 20, swing: float = 0.2, stiffened: float = 1.0) -> gb.Drivetrain:
    """Heavy and light inertias in turn, shafts and meshes in turn, a shaft to ground, in static equilibrium at 200 N m."""
    twists = [8e-4 + 200 / (1.5e6 * stiffened) if i % 2 and i < n - 1 else 0.02 for i in range(n)]
    angles = np.cumsum(twists[::-1])[::-1]
    rig = gb.Drivetrain("stiff chain")
    links = [rig.add("drive", gb.Torque(tau=200 * (1 + swing * gb.sin(125.66370614359172 * gb.time))))]
    for i in range(n):
        links.append(rig.add(f"disc{i}", gb.Inertia(J=1e-5 if i % 2 else 1e-2, phi0=float(angles[i]))))
        if i % 2 and i < n - 1:
            link = gb.Lash(k=1.5e6 * stiffened, c=0.387, half_gap=8e-4, contact_damping="always")
        else:
            link = gb.Shaft(k=1e4, c=1.0)
        links.append(rig.add(f"link{i}", link))
    links.append(rig.add("ground", gb.Fixed()))
    rig.chain(*links)
    return rig


TIMES = np.linspace(0.0, 0.05, 26)[1:]


def far_off(run: gb.Trajectory, reference: gb.Trajectory, n: int = 20) -> float:
    """Largest error of a twist relative to its largest value."""
    pairs = [(run[f"link{i}.twist"], reference[f"link{i}.twist"]) for i in range(n)]
    return max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in pairs)


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(chain())


@pytest.fixture(scope="module")
def reference(model: gb.Model) -> gb.Trajectory:
    return gb.simulate(model, t=TIMES, method="dp8", rtol=1e-11)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_the_implicit_method_meets_its_tolerance_on_a_stiff_chain(model, reference, rtol):
    run = gb.simulate(model, t=TIMES, method="rodas", rtol=rtol)
    assert far_off(run, reference) < 3 * rtol  # errors of some dozens of steps add up
    assert run.stats.jacobians == run.stats.steps + run.stats.rejected
    assert run.stats.steps < reference.stats.steps / 4
    assert run.energy.residual < rtol


def test_auto_leaves_the_explicit_method_where_stability_sets_its_steps_and_says_so(model, reference):
    run = gb.simulate(model, t=TIMES, rtol=1e-6)
    assert far_off(run, reference) < 3e-6
    assert run.stats.method == "rodas+dp8"
    assert "then rodas" in run.stats.why and "stability" in run.stats.why
    assert run.stats.steps < reference.stats.steps / 10


@pytest.mark.long
@pytest.mark.numeric
def test_meshes_that_hit_both_sides_are_located_by_the_implicit_method_too():
    model = gb.build(chain(swing=1.5))
    one, other = (gb.simulate(model, t=TIMES, method=m, rtol=1e-9) for m in ("rodas", "dp8"))
    assert len(one.events) == len(other.events) > 10
    assert max(abs(a.t - b.t) for a, b in zip(one.events, other.events, strict=True)) < 1e-8
    assert far_off(one, other) < 1e-7  # corners amplify


def test_the_cost_does_not_grow_with_stiffness():
    runs = {s: gb.simulate(chain(stiffened=s), t=TIMES, method="rodas", rtol=1e-6) for s in (1.0, 1e2, 1e4, 1e6)}
    steps = [run.stats.steps for run in runs.values()]
    assert max(steps) < 2 * min(steps)
    shafts = [np.array([run[f"link{i}.twist"] for i in range(0, 20, 2)]) for run in runs.values()]
    gaps = [float(np.abs(a - shafts[-1]).max()) for a in shafts[:-1]]
    assert gaps[0] > 10 * gaps[1]  # towards the rigid mesh
    assert gaps[2] < 1e-6


@pytest.mark.parametrize(
    "stiffened",
    [1e3, 1e6, 1e9, 1e12],
)
def test_auto_finds_the_implicit_method_however_stiff_the_meshes_are(stiffened):
    # a thousand steps are a few ms; for stability alone it would be 1e7 and more. At 1e12 a mesh deflects by less than the
    # last digits of its gap, which shakes the explicit steps before the change
    run, close = (gb.simulate(chain(stiffened=s), t=TIMES, rtol=1e-6) for s in (stiffened, 1e6))
    assert run.stats.steps + run.stats.rejected < 1000
    assert run.stats.method.startswith("rodas")
    twists = [np.array([r[f"link{i}.twist"] for i in range(0, 20, 2)]) for r in (run, close)]
    # the two tolerances, and the deflections of nine meshes, 1e-4 rad / stiffened each, beside a twist of 0.02 rad
    assert np.abs(twists[0] - twists[1]).max() < 0.02 * (2e-6 + 0.1 / stiffened)


@pytest.mark.long
@pytest.mark.parametrize(("n", "stiffened"), [(6, 1e11), (20, 1e6), (20, 1e11), (40, 1e5)])
def test_a_trial_comes_soon_where_a_run_would_hardly_end(n, stiffened):
    # rounding of the start shakes the meshes: their vibration sets steps of 1e-10 to 1e-8 s, of which 0.05 s has millions
    run = gb.simulate(chain(n=n, stiffened=stiffened), t=TIMES, rtol=1e-6)
    assert run.stats.method == "rodas+dp8"
    assert int(re.search(r"(\d+) steps dp8", run.stats.why)[1]) <= 48


@pytest.mark.long
def test_auto_meets_its_tolerance_where_meshes_hit_and_changes_the_method_a_few_times_only():
    model, t = gb.build(chain(n=100, swing=1.5)), TIMES * 2
    exact, run = (gb.simulate(model, t=t, method=m, rtol=r) for m, r in (("dp8", 1e-11), ("auto", 1e-6)))
    assert len(run.events) == len(exact.events) > 300
    assert far_off(run, exact, 100) < 1e-6
    changes = re.search(r"(\d+) changes in all", run.stats.why)
    assert changes is None or int(changes[1]) <= 12


def test_a_train_that_is_not_stiff_keeps_the_explicit_method_bit_for_bit():
    rig = gb.Drivetrain("plain")
    rig.chain(rig.add("a", gb.Inertia(J=1.0, w0=1.0)), rig.add("s", gb.Shaft(k=100.0)), rig.add("b", gb.Inertia(J=2.0)))
    auto, dp8 = (gb.simulate(rig, t_end=20.0, rtol=1e-8, method=m) for m in ("auto", "dp8"))
    assert auto.stats.method == "dp8"
    assert auto.stats.steps == dp8.stats.steps
    assert (auto["s.twist"] == dp8["s.twist"]).all()


def test_fixed_steps_are_possible_and_of_order_five():
    rig = gb.Drivetrain("driven")
    drive = rig.add("drive", gb.Torque(tau=gb.sin(3 * gb.time)))
    link = rig.add("link", gb.Shaft(torque=10 * gb.twist + 200 * gb.twist**3, c=0.1))
    rig.chain(drive, rig.add("disc", gb.Inertia(J=1.0, w0=1.0)), link, rig.add("ground", gb.Fixed()))
    t = np.array([0.5, 1.0, 2.0])
    model = gb.build(rig)
    exact = gb.simulate(model, t=t, method="dp8", rtol=1e-13)["link.twist"]
    errors = [np.abs(gb.simulate(model, t=t, method="rodas", step=h)["link.twist"] - exact).max() for h in (0.02, 0.01)]
    assert 4.6 < np.log2(errors[0] / errors[1]) < 5.6


def test_an_input_function_is_differenced_in_time():
    rig = gb.Drivetrain("input")
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", unit="N m")))
    rig.chain(
        drive, rig.add("disc", gb.Inertia(J=1.0)), rig.add("c", gb.Shaft(k=50.0, c=5.0)), rig.add("g", gb.Fixed())
    )
    given = {"tau": lambda t: np.cos(7 * t)}
    one, other = (gb.simulate(rig, t=TIMES * 40, method=m, rtol=1e-9, inputs=given) for m in ("rodas", "dp8"))
    assert np.abs(one["c.twist"] - other["c.twist"]).max() < 1e-9 * np.abs(other["c.twist"]).max() * 10


@pytest.mark.long
def test_angles_whose_turns_are_counted_go_on_through_implicit_steps():
    rig = gb.Drivetrain("turning pair")
    wave = gb.Fourier(cos=(0.2,))
    mesh = gb.GearMesh(teeth=(20, 30), r_base=(0.02, 0.03), external=True, k=1e6, stiffness_variation=wave)
    rig.chain(
        rig.add("a", gb.Inertia(J=1e-3, w0=300.0)), rig.add("m", mesh), rig.add("b", gb.Inertia(J=4e-3, w0=-201.0))
    )
    one, other = (gb.simulate(rig, t=TIMES, method=m, rtol=1e-9) for m in ("rodas", "dp8"))
    for name, allowed in (("a.phi", 1e-9), ("m.deflection", 1e-6)):  # some hundred steps; swings add their phases up
        assert np.abs(one[name] - other[name]).max() < allowed * np.abs(other[name]).max()


def test_an_unknown_method_is_refused_with_the_possible_ones():
    with pytest.raises(ParameterError, match="'rodas'"):
        gb.simulate(chain(n=4), t_end=1.0, method="rodass")


@pytest.mark.long
@pytest.mark.parametrize("rtol", [1e-3, 5e-4, 1e-4])
def test_auto_leaves_the_implicit_method_where_impacts_and_not_stability_set_the_steps(rtol):
    """Four discs whose coupling strikes 26,000 times a second: a trial of implicit steps may seem to pay, and stays."""
    rig = gb.Drivetrain("rattling")
    twists, inertias = (0.0260, 0.0178, 0.0260, 0.0), (5e-3, 2e-4, 2e-4, 1e-2)
    angles = np.cumsum(twists[::-1])[::-1]
    discs = [
        rig.add(f"disc{i}", gb.Inertia(J=J, phi0=float(a)))
        for i, (J, a) in enumerate(zip(inertias, angles, strict=True))
    ]
    left, right = (rig.add(name, gb.Shaft(k=1e5, damping_ratio=0.05)) for name in ("left", "right"))
    w = gb.Parameter("w", 4.2e4, "rad/s")
    gap = rig.add(
        "gap",
        gb.SplineCoupling(
            teeth=20, radius=0.025, k=245e6, c=626.0, stiffness_variation=gb.Fourier(cos=(0.3,), driven_by=w),
            backlash=gb.Backlash(half_gap=20e-6), contact_damping="always",
        ),
    )  # fmt: skip
    drive = rig.add("drive", gb.Torque(tau=2600 * (1 + 0.1 * gb.cos(w * gb.time))))
    rig.chain(drive, discs[0], left, discs[1], gap, discs[2], right, discs[3], rig.add("load", gb.Torque(tau=-2600)))
    auto, dp8 = (gb.simulate(rig, t_end=0.02, rtol=rtol, method=m) for m in ("auto", "dp8"))
    assert len(dp8.events) > 100
    assert auto.stats.rhs_calls < 1.3 * dp8.stats.rhs_calls
