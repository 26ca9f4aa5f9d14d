"""What is kept of runs: on the solution between the steps, not on samples, and to the bit what a trajectory shows."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.simulation import measured_runs
from gearblocks.simulation.arguments import method_options, set_inputs
from gearblocks.simulation.case import Case
from gearblocks.simulation.measured_runs import MeasuredRun, measured_run, merged
from gearblocks.simulation.needs import Along, Needs
from gearblocks.solver import study_runs


@pytest.fixture(scope="module")
def rattling() -> gb.Model:
    """A driven inertia that strikes through a gap, with a clutch that slips: many events of two kinds."""
    rig = gb.Drivetrain("rattling")
    drive, left = rig.add("drive", gb.Torque(tau=2.0 + 6.0 * gb.sin(40 * gb.time))), rig.add("left", gb.Inertia(J=0.02))
    lash = rig.add("lash", gb.Lash(k=5e3, c=0.5, half_gap=2e-3))
    right, brake = rig.add("right", gb.Inertia(J=0.03)), rig.add("brake", gb.Brake(capacity=1.0))
    rig.chain(drive, left, lash, right)
    rig.connect(right.b, brake.a)
    return gb.build(rig)


def _measured(model: gb.Model, needs: Needs, method: str = "auto", end: float = 1.0) -> MeasuredRun:
    with model.library.open() as sim:
        set_inputs(sim, model.program, {})
        options, _ = method_options(method, 1e-6, None, None, True, end)
        return measured_run(sim, Case(model.library, model.values, {}, options, 0.0, end, None), needs)


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_values_events_and_losses_are_those_of_the_trajectory(rattling: gb.Model, method: str) -> None:
    times = tuple(np.sort(np.random.default_rng(5).uniform(0.0, 1.0, 40)).tolist())
    run = gb.simulate(rattling, t=[*times, 1.0], method=method)
    found = _measured(rattling, Needs(("left.w", "lash.torque"), times, ("brake",)), method)
    for name in ("left.w", "lash.torque"):
        assert [found.value(name, t) for t in (*times, 1.0)] == run[name].tolist()
    assert len(run.events) > 20 and found.events == run.events
    assert found.lost("brake", 0.0) == 0.0 and found.lost("brake", 1.0) == run.energy.dissipated["brake"]


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.few(1)
def test_what_an_output_is_along_the_run_is_that_of_very_many_samples(rattling: gb.Model, method: str) -> None:
    t = np.linspace(0.0, 1.0, 200_001)
    fine = gb.simulate(rattling, t=t, method=method)["lash.torque"]
    kinds = {kind: Along(kind, "lash.torque", 0.0, 1.0) for kind in ("peak", "trough", "mean", "rms")}
    found = _measured(rattling, Needs(along=(*kinds.values(),)), method)
    size = np.abs(fine).max()
    for kind, largest in (("peak", fine.max()), ("trough", -fine.min())):
        value = found.along_run(kinds[kind]) * (1.0 if kind == "peak" else -1.0)
        assert -1e-12 * size <= value - largest < 2e-6 * size, (
            "no sample is above, and those are a hundredth of a rise apart"
        )
    assert found.along_run(kinds["mean"]) == pytest.approx(np.trapezoid(fine, t), abs=2e-5 * size)
    assert found.along_run(kinds["rms"]) == pytest.approx(np.sqrt(np.trapezoid(fine**2, t)), abs=2e-5 * size)


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_integrals_over_jumps_and_peaks_within_steps_are_those_of_closed_forms(method: str) -> None:
    """A torque that jumps, on a mass that swings on a shaft: steps are long, and an output jumps with the torque."""
    rig = gb.Drivetrain("jumps")
    at = 0.35
    drive = rig.add("drive", gb.Torque(tau=gb.piecewise((-1.0, gb.time < at), (2.0, True))))
    body, shaft, wall = (
        rig.add("body", gb.Inertia(J=0.5)),
        rig.add("shaft", gb.Shaft(k=200.0)),
        rig.add("wall", gb.Fixed()),
    )
    rig.chain(drive, body, shaft, wall)
    kinds = [Along(kind, "drive.torque", 0.0, 1.0) for kind in ("mean", "rms", "peak", "trough")]
    swing = [Along("peak", "body.phi", 0.0, at), Along("trough", "body.phi", 0.0, at)]
    found = _measured(gb.build(rig), Needs(along=(*kinds, *swing)), method)
    mean, rms, peak, trough = (found.along_run(one) for one in kinds)
    assert mean == pytest.approx(2 * (1 - at) - at, rel=1e-12) and rms == pytest.approx(np.sqrt(4 - 3 * at), rel=1e-12)
    assert (peak, trough) == (2.0, -1.0)
    still = -1.0 / 200.0  # the body swings between 0 and twice that
    assert found.along_run(swing[1]) == pytest.approx(2 * still, rel=3e-6)
    assert found.along_run(swing[0]) == pytest.approx(0.0, abs=3e-6 * abs(still))


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_a_peak_lies_on_the_solution_however_long_the_steps_are(method: str) -> None:
    rig = gb.Drivetrain("swing")
    a, b = rig.add("a", gb.Inertia(J=0.5, w0=1.0)), rig.add("b", gb.Inertia(J=0.3))
    rig.chain(
        a,
        rig.add("shaft", gb.Shaft(k=200.0, c=0.02)),
        b,
        rig.add("spring", gb.Shaft(k=20.0)),
        rig.add("wall", gb.Fixed()),
    )
    model = gb.build(rig)
    for output in ("shaft.torque", "b.w"):
        peak, trough = Along("peak", output, 0.0, 3.0), Along("trough", output, 0.0, 3.0)
        found = _measured(model, Needs(along=(peak, trough)), method, 3.0)
        fine = gb.simulate(model, t=np.linspace(0.0, 3.0, 100_001), method=method)[output]
        size = np.abs(fine).max()
        assert -1e-13 * size <= found.along_run(peak) - fine.max() < 1e-7 * size
        assert -1e-13 * size <= fine.min() - found.along_run(trough) < 1e-7 * size


def test_windows_cut_the_solution_and_not_its_steps(rattling: gb.Model) -> None:
    edges = (0.0, 0.3003, 0.5000001, 0.5000002, 0.7007, 1.0)
    parts = [Along("mean", "left.w", a, b) for a, b in itertools.pairwise(edges)]
    peaks = [Along("peak", "left.w", a, b) for a, b in itertools.pairwise(edges)]
    whole = Along("mean", "left.w", 0.0, 1.0), Along("peak", "left.w", 0.0, 1.0)
    found = _measured(rattling, Needs(along=(*whole, *parts, *peaks)))
    alone = _measured(rattling, Needs(along=whole[:1]))
    assert alone.along_run(whole[0]) == found.along_run(whole[0])
    total = sum(found.along_run(part) * (part.before - part.after) for part in parts)
    assert total == pytest.approx(found.along_run(whole[0]), rel=1e-9)
    assert max(map(found.along_run, peaks)) == pytest.approx(found.along_run(whole[1]), rel=1e-9)


@pytest.mark.long
def test_squares_of_large_outputs_do_not_overflow() -> None:
    rig = gb.Drivetrain("heavy")
    drive = rig.add("drive", gb.Torque(tau=1e170 * gb.sin(2 * np.pi * gb.time)))
    rig.connect(drive.flange, rig.add("body", gb.Inertia(J=1e170)).a)
    rms = Along("rms", "drive.torque", 0.0, 1.0)
    assert _measured(gb.build(rig), Needs(along=(rms,))).along_run(rms) == pytest.approx(1e170 / np.sqrt(2), rel=1e-6)


def test_a_window_without_time_has_no_value(rattling: gb.Model) -> None:
    empty = [Along(kind, "left.w", 0.5, 0.5) for kind in ("peak", "trough", "mean", "rms")]
    found = _measured(rattling, Needs(along=tuple(empty)))
    assert np.isnan([found.along_run(one) for one in empty]).all()


def test_little_room_for_rows_events_and_time_changes_no_bit(
    rattling: gb.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs = Needs(("left.w",), tuple(np.linspace(0.0, 1.0, 500).tolist()), along=(Along("rms", "left.w", 0.1, 0.9),))
    before = _measured(rattling, needs)
    monkeypatch.setattr(study_runs, "_ROWS", 1)
    monkeypatch.setattr(study_runs, "_EVENTS", 3)
    monkeypatch.setattr(measured_runs, "_SLICE", 1e-9)
    after = _measured(rattling, needs)
    assert (before.values == after.values).all() and (before.along == after.along).all()
    assert before.events == after.events and before.missing == after.missing


def test_needs_are_merged_without_repetition(rattling: gb.Model) -> None:
    rms = Along("rms", "left.w", 0.0, 1.0)
    one, two = (
        Needs(("right.w", "left.w"), (0.5, 0.2), ("lash",), (rms,)),
        Needs(("left.w",), (0.5,), ("brake",), (rms,)),
    )
    assert merged(rattling.program, [one, two]) == Needs(("left.w", "right.w"), (0.2, 0.5), ("lash", "brake"), (rms,))
