"""The binary as an importer meets it: equal to the run in-process, and never a NaN under the name of OK."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import fmu_export
import gearblocks as gb
from fmu_export import manifest
from fmu_export.checks.instance import Instance, Unpacked
from fmu_export.checks.replay import replay
from gearblocks.solver.library import Model

OUTPUTS = ("wheel.phi", "wheel.w", "wheel.alpha", "spring.torque", "spring.contact")
References = dict[str, int]


def in_process(unpacked: Unpacked, times: np.ndarray, stop: float | None) -> np.ndarray:
    data = (unpacked.folder / manifest.NAME).read_bytes()
    content = manifest.from_json(data, (unpacked.folder / "sources" / "model.c").read_text(encoding="utf-8"))
    return replay(content, times, stop)


def rows_of(instance: Instance, refs: list[int], times: np.ndarray) -> np.ndarray:
    """Outputs at each of the communication points `times`."""
    rows = [instance.get(refs)]
    for begin, end in itertools.pairwise(times):
        instance.step(begin, end - begin)
        rows.append(instance.get(refs))
    return np.array(rows)


@pytest.mark.long
def test_every_check_passes(packed: Path) -> None:
    report = fmu_export.check(packed)
    assert report.ok, str(report)
    assert all(item.ok for item in report.items), str(report)
    assert {name for name, difference in report.differences if difference == 0.0} == set(OUTPUTS)
    assert "<table" in report.to_html()


@pytest.mark.parametrize("step", [1e-5, 1e-3, 0.7e-3, 0.02])
def test_fmu_and_in_process_runs_are_equal_bit_for_bit(unpacked: Unpacked, references: References, step: float) -> None:
    end = 0.02
    times = np.append(np.arange(0.0, end - 1e-9 * step, step), end)
    with Instance(unpacked) as instance:
        instance.start(stop=end)
        rows = rows_of(instance, [references[name] for name in OUTPUTS], times)
    np.testing.assert_array_equal(rows, in_process(unpacked, times, end))


@pytest.mark.parametrize(
    "options",
    [
        pytest.param({"method": "dp5"}, marks=pytest.mark.long),
        {"method": "rk4", "step": 2e-5},
        pytest.param({"step": 5e-5}, marks=pytest.mark.long),
    ],
)
def test_every_method_runs_as_in_process(model: Model, tmp_path: Path, options: dict[str, float]) -> None:
    report = fmu_export.check(fmu_export.export(model, tmp_path / "m.fmu", t_end=0.02, **options))
    assert all(item.ok for item in report.items), str(report)


def test_setting_an_input_to_its_own_value_changes_no_bit(unpacked: Unpacked, references: References) -> None:
    refs = [references[name] for name in OUTPUTS]
    times = np.linspace(0.0, 0.02, 41)
    with Instance(unpacked) as plain, Instance(unpacked) as busy:
        plain.start()
        busy.start()
        expected = rows_of(plain, refs, times)
        for i, (begin, end) in enumerate(itertools.pairwise(times), start=1):
            busy.set([references["tau"]], [5.0])
            busy.step(begin, end - begin)
            assert busy.get(refs) == list(expected[i])


def test_inputs_and_tunable_parameters_take_effect_where_they_are_set(
    unpacked: Unpacked, references: References
) -> None:
    """With the excitation gone and the damping strong, the wheel comes to rest where the spring carries the input."""
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1e-3)
        names = ("tau", "drive.amplitude", "spring.c", "spring.k")
        instance.set([references[name] for name in names], [12.0, 0.0, 40.0, 1e4])
        instance.step(1e-3, 0.5)
        # the slowest part falls as exp(-293 t), far below rounding at the end; the solver's tolerance is what stays
        assert instance.get([references["wheel.phi"]])[0] == pytest.approx(1e-3 + 12.0 / 1e4, rel=1e-4)
        assert instance.get([references["spring.k"]]) == [1e4]


def test_fixed_parameters_are_refused_once_the_run_has_begun(unpacked: Unpacked, references: References) -> None:
    with Instance(unpacked) as instance:
        instance.set([references["wheel.phi0"]], [1e-3])
        instance.start()
        assert instance.get([references["wheel.phi"]]) == [1e-3]
        line = instance.refuses(lambda: instance.set([references["wheel.phi0"]], [2e-3]))
        assert "'wheel.phi0' is fixed" in line
        assert "'solver.rtol' is fixed" in instance.refuses(lambda: instance.set([references["solver.rtol"]], [1e-3]))


def test_values_beyond_their_limits_and_nan_are_refused_by_name_and_time(
    unpacked: Unpacked, references: References
) -> None:
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1e-3)
        line = instance.refuses(lambda: instance.set([references["spring.k"]], [-1.0]))
        assert "'spring.k' is set to -1 at t = 0.001 s" in line
        line = instance.refuses(lambda: instance.set([references["tau"]], [math.nan]))
        assert "'tau' is set to" in line
        assert "at t = 0.001 s" in line
        instance.step(1e-3, 1e-3)
        assert all(map(math.isfinite, instance.get([references[name] for name in OUTPUTS])))


def test_a_refused_set_sets_nothing(unpacked: Unpacked, references: References) -> None:
    with Instance(unpacked) as instance:
        refs = [references["wheel.J"], references["spring.k"]]
        assert instance.refuses(lambda: instance.set(refs, [0.5, -1.0]))
        assert instance.get(refs) == [0.02, 2e4]


def test_a_run_that_cannot_go_on_says_what_and_when(unpacked: Unpacked, references: References) -> None:
    """Next to no inertia: an infinite acceleration."""
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1e-3)
        instance.set([references["wheel.J"]], [1e-320])
        line = instance.refuses(lambda: instance.step(1e-3, 1e-3))
        assert "wheel.w" in line
        assert "t = 0.001 s" in line
        assert "after a failure" in instance.refuses(lambda: instance.step(1e-3, 1e-3))
        instance.fmu.reset()
        instance.start()
        instance.step(0.0, 1e-3)


def test_the_stop_time_bounds_the_steps(unpacked: Unpacked) -> None:
    with Instance(unpacked) as instance:
        instance.start(stop=1e-3)
        instance.step(0.0, 7e-4)
        assert "beyond the stop time" in instance.refuses(lambda: instance.step(7e-4, 7e-4))
        instance.step(7e-4, 1e-3 - 7e-4)
    with Instance(unpacked) as instance:
        line = instance.refuses(lambda: instance.fmu.setupExperiment(startTime=1.0, stopTime=0.5))
        assert "must be later than the start time" in line


def test_a_run_may_start_at_any_time(unpacked: Unpacked, references: References) -> None:
    times = np.linspace(0.3, 0.32, 21)
    with Instance(unpacked) as instance:
        instance.start(t0=0.3)
        rows = rows_of(instance, [references[name] for name in OUTPUTS], times)
        assert instance.get([references["time"]]) == [times[-1]]
    np.testing.assert_array_equal(rows, in_process(unpacked, times, None))


def test_the_importers_tolerance_is_that_of_the_solver(unpacked: Unpacked, references: References) -> None:
    with Instance(unpacked) as one, Instance(unpacked) as two:
        one.start(tolerance=1e-9)
        two.set([references["solver.rtol"]], [1e-9])
        two.start()
        assert one.get([references["solver.rtol"]]) == [1e-9]
        times = np.linspace(0.0, 0.02, 5)
        refs = [references[name] for name in OUTPUTS]
        np.testing.assert_array_equal(rows_of(one, refs, times), rows_of(two, refs, times))


def test_located_events_are_logged_when_asked_for(unpacked: Unpacked) -> None:
    with Instance(unpacked, logging=True) as instance:
        instance.start()
        instance.step(0.0, 0.05)
        assert any(category == "logEvents" and "events up to t = 0.05 s" in text for _, category, text in instance.log)
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 0.05)
        assert instance.log == []


def test_a_state_of_another_model_is_refused(
    unpacked: Unpacked, model: Model, tmp_path: Path, unpacker: Callable[[Path, Path], Unpacked]
) -> None:
    other = unpacker(fmu_export.export(model, tmp_path / "other.fmu", rtol=1e-8), tmp_path / "other")
    with Instance(unpacked) as one, Instance(other) as two:
        one.start()
        state = one.fmu.getFMUstate()
        data = one.fmu.serializeFMUstate(state)
        assert "belongs to another model" in two.refuses(lambda: two.fmu.deSerializeFMUstate(data))
        one.fmu.freeFMUstate(state)


def test_functions_out_of_turn_are_refused(unpacked: Unpacked, references: References) -> None:
    with Instance(unpacked) as instance:
        fmu = instance.fmu
        assert instance.refuses(fmu.exitInitializationMode)
        assert instance.refuses(fmu.terminate)
        assert "has no value before the initialization" in instance.refuses(
            lambda: instance.get([references["wheel.phi"]])
        )
        instance.start()
        assert instance.refuses(fmu.exitInitializationMode)
        fmu.terminate()
        assert instance.refuses(fmu.terminate)
        assert instance.refuses(lambda: instance.set([references["tau"]], [1.0]))
        with pytest.raises(FMICallException):
            fmu.getInteger([references["tau"]])


def test_an_instance_survives_being_freed_in_any_state(unpacked: Unpacked) -> None:
    for stage in range(4):
        with Instance(unpacked) as instance:
            if stage > 0:
                instance.fmu.setupExperiment()
                instance.fmu.enterInitializationMode()
            if stage > 1:
                instance.fmu.exitInitializationMode()
            if stage > 2:
                instance.fmu.terminate()


def test_outputs_follow_an_input_at_the_instant_it_is_set(unpacked: Unpacked, references: References) -> None:
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1.3e-3)
        (before,) = instance.get([references["wheel.alpha"]])
        instance.set([references["tau"]], [6.0])
        (after,) = instance.get([references["wheel.alpha"]])
        assert after - before == pytest.approx(1.0 / 0.02, rel=1e-12)  # one N m more over J


def test_a_saved_state_holds_values_set_but_not_yet_stepped(unpacked: Unpacked, references: References) -> None:
    names = [references["spring.k"], references["tau"]]
    refs = [references[name] for name in OUTPUTS]
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1.3e-3)
        instance.set(names, [1.8e4, 6.0])
        state = instance.fmu.getFMUstate()
        instance.step(1.3e-3, 2e-3)
        first = instance.get(refs)
        instance.set(names, [1.0e4, 0.0])
        instance.step(3.3e-3, 2e-3)
        instance.fmu.setFMUstate(state)
        assert instance.get(names) == [1.8e4, 6.0]
        instance.step(1.3e-3, 2e-3)
        assert instance.get(refs) == first
        instance.fmu.freeFMUstate(state)


def test_a_state_saved_before_the_initialization_brings_it_back(unpacked: Unpacked, references: References) -> None:
    refs = [references[name] for name in OUTPUTS]
    with Instance(unpacked) as instance:
        instance.set([references["wheel.phi0"]], [1.5e-3])
        state = instance.fmu.getFMUstate()
        instance.start()
        instance.step(0.0, 1e-3)
        first = instance.get(refs)
        instance.fmu.setFMUstate(state)
        assert instance.get([references["wheel.phi0"]]) == [1.5e-3]
        instance.start()
        instance.step(0.0, 1e-3)
        assert instance.get(refs) == first
        instance.fmu.freeFMUstate(state)


def test_instances_on_several_threads_equal_one_alone(unpacked: Unpacked, references: References) -> None:
    refs = [references[name] for name in OUTPUTS]
    times = np.linspace(0.0, 0.05, 201)

    def run(tau: float) -> np.ndarray:
        with Instance(unpacked) as instance:
            instance.set([references["tau"]], [tau])
            instance.start()
            return rows_of(instance, refs, times)

    torques = [1.0, 2.0, 3.0, 4.0]
    alone = [run(tau) for tau in torques]
    with ThreadPoolExecutor(max_workers=len(torques)) as workers:
        together = list(workers.map(run, torques))
    np.testing.assert_array_equal(together, alone)


def test_start_values_that_cannot_start_may_be_mended(unpacked: Unpacked, references: References) -> None:
    with Instance(unpacked) as instance:
        instance.fmu.setupExperiment()
        instance.fmu.enterInitializationMode()
        instance.set([references["wheel.J"]], [1e-320])
        assert instance.refuses(instance.fmu.exitInitializationMode)
        instance.set([references["wheel.J"]], [0.02])
        instance.fmu.exitInitializationMode()
        instance.step(0.0, 1e-3)


def test_fmpy_feeds_inputs_and_start_values(packed: Path) -> None:
    """An input held at 8 N m is the same run as its start value of 8 N m, bit for bit."""
    signals = np.array([(0.0, 8.0), (1.0, 8.0)], dtype=[("time", "f8"), ("tau", "f8")])
    options: dict[str, Any] = {"stop_time": 0.02, "output_interval": 1e-4}
    fed = fmpy.simulate_fmu(str(packed), input=signals, **options)
    held = fmpy.simulate_fmu(str(packed), start_values={"tau": 8.0}, **options)
    other = fmpy.simulate_fmu(str(packed), start_values={"tau": 5.0, "spring.k": 2.1e4}, **options)
    np.testing.assert_array_equal(fed, held)
    assert not np.array_equal(fed["wheel.w"], other["wheel.w"])


def test_an_input_that_is_set_to_the_limit_of_a_condition_is_on_its_side(tmp_path: Path) -> None:
    pedal, gear = gb.Input("pedal"), gb.Input("gear", 1.0)
    law = gb.piecewise((10, pedal > 0), (0, True)) + gb.Table([1, 2], [0, 100], "step")(gear)
    rig = gb.Drivetrain("driven")
    rig.chain(rig.add("drive", gb.Torque(tau=law)), rig.add("disc", gb.Inertia(J=1.0)))
    signals = np.array(
        [(0, 0, 1), (1, 0, 1), (1, 1, 2), (2, 1, 2), (2, 0, 1), (3, 0, 1)],
        dtype=[("time", "f8"), ("pedal", "f8"), ("gear", "f8")],
    )
    path = fmu_export.export(rig, tmp_path / "driven.fmu", outputs=["disc.w"])
    rows = fmpy.simulate_fmu(str(path), stop_time=3.0, output_interval=0.25, input=signals, output=["disc.w"])
    assert rows["disc.w"][-1] == pytest.approx(110.0, rel=1e-12)
