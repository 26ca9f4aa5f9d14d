"""Studies by fixed steps in lanes: what they answer, where they are refused, and what runs in their place."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gearblocks as gb

W = np.linspace(60.0, 140.0, 7)
PERIODS = {"section": gb.stroboscopic("w"), "transient": 60, "keep": 5}
QUANTITIES = [
    gb.points("mesh.deflection"), gb.peak("mesh.force"), gb.trough("mesh.force"), gb.rms("mesh.deflection"),
    gb.mean("mesh.force"), gb.last("body.w"),
]  # fmt: skip


def _pair(hold: bool = False) -> gb.Drivetrain:
    """A pair on the ground with play that its load keeps closed for most of the time; with a brake that slips."""
    rig = gb.Drivetrain("pair")
    w = gb.Parameter("w", 100.0, "rad/s")
    body = rig.add("body", gb.Inertia(J=1e-2))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20, radius=0.1, k=1e4, c=4.0, stiffness_variation=gb.Fourier(cos=(0.1,), driven_by=w),
            backlash=gb.Backlash(half_gap=1e-3), contact_damping="always",
        ),
    )  # fmt: skip
    drive = rig.add("drive", gb.Torque(tau=1.0 + 0.6 * gb.cos(w * gb.time)))
    rig.chain(drive, body, mesh, rig.add("ground", gb.Fixed()))
    if hold:
        rig.connect(rig.add("brake", gb.Brake(capacity=0.01)).a, body.a)
    return rig


def _values(study):
    return np.column_stack([np.asarray(study[q.name]).reshape(len(study), -1) for q in QUANTITIES])


def test_quantities_of_steps_go_to_those_of_the_solution():
    model = gb.build(_pair())
    fine = _values(gb.sweep(model, {"w": W}, quantity=QUANTITIES, rtol=1e-10, **PERIODS))
    size = abs(fine).max(axis=0)
    off = []
    for count in (50, 200):
        found = gb.sweep(model, {"w": W}, quantity=QUANTITIES, steps_per_period=count, **PERIODS)
        assert found.meta["in_lanes"] and not found.failures
        off.append((abs(_values(found) - fine) / size).max())
    # a peak lies up to half a step off a sample, and a corner anywhere in a step: order 2 at best, with luck in it
    assert off[0] < 5e-3
    assert off[1] < 5e-4


def test_workers_and_chunks_change_no_bit():
    model = gb.build(_pair())
    one = _values(gb.sweep(model, {"w": W}, quantity=QUANTITIES, steps_per_period=40, threads=1, **PERIODS))
    with ThreadPoolExecutor(2) as pool:
        for more in ({"threads": 2, "chunk": 2}, {"executor": pool, "chunk": 3}):
            again = gb.sweep(model, {"w": W}, quantity=QUANTITIES, steps_per_period=40, **more, **PERIODS)
            np.testing.assert_array_equal(_values(again), one)


@pytest.mark.long
def test_start_values_and_fixed_parameters_count():
    model = gb.build(_pair())
    arguments = {"quantity": gb.peak("mesh.force"), "steps_per_period": 100, "parameters": {"mesh.k": 2e4}}
    arguments |= {"section": gb.stroboscopic("w"), "transient": 0, "keep": 3}
    found = gb.sweep(model, {"body.w": [0.0, 5.0]}, **arguments)
    for i, w0 in enumerate((0.0, 5.0)):
        step = 2 * np.pi / 100.0 / 100
        run = gb.simulate(
            model, t=step * np.arange(301), method="rk4", step=step, locate=False, initial={"body.w": w0},
            parameters={"mesh.k": 2e4},
        )  # fmt: skip
        assert float(np.asarray(found["peak(mesh.force)"])[i]) == pytest.approx(run["mesh.force"].max(), rel=1e-12)


@pytest.mark.long
@pytest.mark.parametrize(
    ("rig", "quantity", "more"),
    [
        (_pair(hold=True), gb.peak("mesh.force"), {}),
        (_pair(), gb.count("mesh"), {}),
        (_pair(), lambda run: run["mesh.force"][-1], {}),
        (_pair(), gb.peak("mesh.force"), {"initial": "static"}),
    ],
)
@pytest.mark.few(1)
def test_other_trains_and_quantities_are_run_one_by_one_with_located_events(rig, quantity, more):
    arguments = {"quantity": quantity, **PERIODS, **more}
    found = gb.sweep(rig, {"w": W[:2]}, steps_per_period=400, **arguments)
    fine = gb.sweep(rig, {"w": W[:2]}, rtol=1e-9, **arguments)
    assert not found.meta["in_lanes"] and found.meta["method"] == "rk4"
    name = quantity.name if hasattr(quantity, "name") else "quantity"
    np.testing.assert_allclose(np.asarray(found[name]), np.asarray(fine[name]), rtol=1e-3)


@pytest.mark.long
def test_a_point_that_diverges_is_named():
    found = gb.sweep(_pair(), {"mesh.k": [1e4, 1e12]}, quantity=gb.peak("mesh.force"), steps_per_period=40, **PERIODS)
    assert np.isfinite(np.asarray(found["peak(mesh.force)"])).tolist() == [True, False]
    assert [f.message for f in found.failures] == ["its steps diverge: more of them in a period, or a located run"]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"steps_per_period": 2}, "whole number, >= 4"),
        ({"steps_per_period": 20, "method": "dp8"}, "leave out method and step"),
        ({"steps_per_period": 20, "step": 1e-3}, "leave out method and step"),
        ({"steps_per_period": 20, "t_end": 1.0}, "leave out t_end and t"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(more, words):
    with pytest.raises(gb.GearblocksError, match=words):
        gb.sweep(_pair(), {"w": W}, quantity=gb.peak("mesh.force"), **{**PERIODS, **more})
