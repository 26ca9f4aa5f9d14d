"""Runs that begin late at a tight tolerance: rounding of time, which moves what time drives, is no motion to resolve."""

import numpy as np
import pytest

import gearblocks as gb

T = gb.time
WINDOW = 0.01


def _driven(spring):
    """A body of 1e-2 kg m2 under 30 sin(800 t) N m, free or on a spring to the ground."""
    rig = gb.Drivetrain("driven")
    parts = [rig.add("drive", gb.Torque(tau=30 * gb.sin(800 * T))), rig.add("body", gb.Inertia(J=1e-2))]
    if spring:
        parts += [rig.add("spring", gb.Shaft(k=4e3)), rig.add("ground", gb.Fixed())]
    rig.chain(*parts)
    return gb.build(rig)


@pytest.fixture(scope="module")
def models():
    return {spring: _driven(spring) for spring in (False, True)}


def _speed(spring, begin):
    """The speed after the window, from rest: integral of the torque times the response cos(own (late - t)) to an impulse."""
    own, late = np.sqrt(4e3 / 1e-2) if spring else 0.0, begin + WINDOW
    parts = [(800 - own, own * late), (800 + own, -own * late)]  # products of sines and cosines as sums
    return 15 / 1e-2 * sum((np.cos(w * begin + turn) - np.cos(w * late + turn)) / w for w, turn in parts)


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("spring", [False, True])
@pytest.mark.few(3)
def test_a_run_that_begins_late_is_as_right_as_time_is(models, spring, method):
    for begin in (1.7, 40.0, 137.9, 359.4, 688.0, 1063.1, 1250.3, 20000.3):
        run = gb.simulate(models[spring], t=[begin + WINDOW], t_start=begin, method=method, rtol=1e-10)
        phase = 800 * begin * 4e-16  # rounding of 800 t
        assert run["body.w"][-1] == pytest.approx(_speed(spring, begin), abs=75 * (1e-9 + 30 * phase))


@pytest.mark.parametrize(("method", "rtol"), [("dp5", 1e-11), ("rodas", 1e-11), ("dp5", 1e-12), ("dp8", 1e-12)])
@pytest.mark.few(2)
def test_a_run_that_begins_late_goes_on_at_more_digits_than_time_has(models, method, rtol):
    for begin in np.linspace(60.0, 1500.0, 25):
        for model in models.values():
            run = gb.simulate(model, t=[begin + WINDOW], t_start=begin, method=method, rtol=rtol)
            assert run.complete and run.stats.steps < 10000


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8"])
def test_a_gear_pair_with_an_excited_mesh_goes_on_late(method):
    """The mesh of P1's kind, from rest: the motion begins as softly as its excitation, whole periods later the same."""
    rig = gb.Drivetrain("pair")
    w = 2 * np.pi * 1024.0
    mesh = gb.GearMesh(
        teeth=(20, 20), external=True, r_base=(0.05, 0.05), k=2e8, damping_ratio=0.05,
        stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=gb.Parameter("w", w, "rad/s")),
    )  # fmt: skip
    rig.chain(
        rig.add("drive", gb.Torque(tau=100.0)), rig.add("one", gb.Inertia(J=1e-3)), rig.add("mesh", mesh),
        rig.add("two", gb.Inertia(J=1e-3)), rig.add("load", gb.Torque(tau=-60.0)),
    )  # fmt: skip
    model = gb.build(rig)
    first = gb.simulate(model, t=[WINDOW], method=method, rtol=1e-11)["mesh.force"][-1]
    for begin in (3.0, 40.0, 257.0):
        run = gb.simulate(model, t=[begin + WINDOW], t_start=begin, method=method, rtol=1e-11)
        assert run["mesh.force"][-1] == pytest.approx(first, rel=1e-7 + w * begin * 1e-15)
        assert run.stats.steps < 5000
