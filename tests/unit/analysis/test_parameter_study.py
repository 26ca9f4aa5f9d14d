"""Sweeps and studies: equal to single runs bit for bit whoever runs them, points that fail, names that are wrong."""

from __future__ import annotations

import math
import multiprocessing
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

QUANTITIES = (
    gb.peak("shaft.torque"), gb.rms("load.w", after=0.313), gb.energy_lost("clutch"), gb.last("motor.w"), gb.count("clutch"),
    gb.at("load.w", 0.2), gb.event_time("clutch"),
)  # fmt: skip
GRID = {"shaft.k": [150.0, 200.0, 250.0, 300.0], "clutch.capacity": [6.0, 8.0, 12.0]}


def swing(run: gb.Trajectory) -> float:
    """A function of a trajectory that processes can find."""
    return float(run["load.w"].max() - run["load.w"].min())


@pytest.fixture(scope="module")
def found(clutch_model: gb.Model) -> gb.Study:
    return gb.sweep(clutch_model, GRID, quantity=QUANTITIES, t_end=0.5, threads=1)


def _row(run: gb.Trajectory) -> bytes:
    return np.array([q.of(run) for q in QUANTITIES]).tobytes()


def _same(a: gb.Study, b: gb.Study) -> bool:
    return a.values.tobytes() == b.values.tobytes() and a.points.tobytes() == b.points.tobytes()


def test_every_value_is_that_of_a_single_run(clutch_model: gb.Model, found: gb.Study) -> None:
    assert found.shape == (4, 3) and found.complete and not found.failures
    for point, row in zip(found.points.tolist(), found.values.tolist(), strict=True):
        run = gb.simulate(clutch_model, t_end=0.5, parameters=dict(zip(found.paths, point, strict=True)))
        assert _row(run) == np.array(row).tobytes()
        assert run["motor.w"][-1] == row[3] and run.energy.dissipated["clutch"] == row[2]
    assert found["peak(shaft.torque)"][2, 1] == found.values[7, 0]


@pytest.mark.parametrize(
    "how", [{"threads": 1, "chunk": 1}, {"threads": 3, "chunk": 5}, {"threads": 2}, {"chunk": 100}]
)
def test_threads_and_chunks_change_no_bit(clutch_model: gb.Model, found: gb.Study, how: dict[str, int]) -> None:
    assert _same(gb.sweep(clutch_model, GRID, quantity=QUANTITIES, t_end=0.5, **how), found)  # type: ignore[arg-type]


def test_which_quantities_are_asked_for_together_changes_no_bit(clutch_model: gb.Model, found: gb.Study) -> None:
    for i, quantity in enumerate(QUANTITIES):
        alone = gb.sweep(clutch_model, GRID, quantity=quantity, t_end=0.5)
        assert alone.values[:, 0].tobytes() == found.values[:, i].tobytes()


@pytest.fixture(scope="module")
def processes() -> Iterator[Executor]:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield pool


@pytest.mark.long
def test_spawned_processes_change_no_bit(clutch_model: gb.Model, found: gb.Study, processes: Executor) -> None:
    assert _same(gb.sweep(clutch_model, GRID, quantity=QUANTITIES, t_end=0.5, executor=processes, chunk=5), found)


def test_an_executor_of_threads_changes_no_bit(clutch_model: gb.Model, found: gb.Study) -> None:
    with ThreadPoolExecutor(2) as pool:
        assert _same(gb.sweep(clutch_model, GRID, quantity=QUANTITIES, t_end=0.5, executor=pool, chunk=2), found)
        assert pool.submit(int, 3).result() == 3  # it is the caller's, and still open


def test_a_study_of_the_same_cases_has_the_same_values(clutch_model: gb.Model, found: gb.Study) -> None:
    cases = [dict(zip(found.paths, point, strict=True)) for point in found.points.tolist()]
    made = gb.study(clutch_model, cases, quantity=QUANTITIES, t_end=0.5)
    assert _same(made, found) and made.shape == ()
    assert made["last(motor.w)"].shape == (12,)
    columns = {path: found.points[:, i] for i, path in enumerate(found.paths)}
    assert _same(gb.study(clutch_model, columns, quantity=QUANTITIES, t_end=0.5), found)


def test_functions_of_a_trajectory_stand_beside_quantities(clutch_model: gb.Model, found: gb.Study) -> None:
    made = gb.sweep(clutch_model, GRID, quantity=[swing, *QUANTITIES], t_end=0.5)
    assert made.values[:, 1:].tobytes() == found.values.tobytes()
    run = gb.simulate(clutch_model, t_end=0.5, parameters={"shaft.k": 150.0, "clutch.capacity": 8.0})
    assert made["swing"][0, 1] == swing(run)
    sampled = gb.sweep(
        clutch_model, {"shaft.k": [150.0]}, quantity=lambda run: float(len(run.t)), t=np.linspace(0, 0.5, 9)
    )
    assert sampled.values.tolist() == [[9.0]] and sampled.names == ("quantity",)


def test_start_values_and_inputs_vary_too(clutch_model: gb.Model) -> None:
    made = gb.sweep(clutch_model, {"motor.w": [30.0, 60.0], "tau": [0.0, 3.0]}, quantity=QUANTITIES, t_end=0.5)
    assert made.units == ("rad/s", "N m")
    run = gb.simulate(clutch_model, t_end=0.5, initial={"motor.w": 60.0}, inputs={"tau": 3.0})
    assert _row(run) == made.values[3].tobytes()
    fixed = gb.sweep(
        clutch_model,
        {"tau": [3.0]},
        quantity=QUANTITIES,
        t_end=0.5,
        initial={"motor.w": 60.0},
        parameters={"shaft.c": 0.2},
    )
    assert fixed.values.tobytes() == made.values[3].tobytes()


def test_short_paths_and_parameters_are_found(clutch_model: gb.Model) -> None:
    made = gb.sweep(
        clutch_model, {"capacity": [6.0, 8.0]}, quantity=gb.last("load.w"), t_end=0.1, parameters={"gain": 0.01}
    )
    assert made.paths == ("clutch.capacity",)
    run = gb.simulate(clutch_model, t_end=0.1, parameters={"gain": 0.01, "clutch.capacity": 6.0})
    assert made.values[0, 0] == run["load.w"][-1]


@pytest.mark.long
def test_a_static_start_is_made_at_every_point() -> None:
    rig = gb.Drivetrain("sagging")
    ground, shaft = rig.add("ground", gb.Fixed()), rig.add("shaft", gb.Shaft(k=100.0, c=1.0))
    rig.connect(ground.flange, shaft.a)
    load = rig.add("load", gb.Torque(tau=5.0 + gb.sin(10 * gb.time)))
    rig.connect(shaft.b, rig.add("body", gb.Inertia(J=1.0)).a, load.flange)
    made = gb.sweep(rig, {"shaft.k": [50.0, 100.0]}, quantity=gb.at("body.phi", 0.0), t_end=0.2, initial="static")
    assert made.values[:, 0] == pytest.approx([0.1, 0.05], rel=1e-12)


@pytest.mark.long
def test_with_a_section_runs_are_as_long_as_its_periods() -> None:
    rig = gb.Drivetrain("driven")
    speed = gb.Parameter("speed", 40.0, "rad/s")
    drive, body, damper = (
        rig.add("drive", gb.Torque(tau=gb.cos(speed * gb.time))), rig.add("body", gb.Inertia(J=1.0)),
        rig.add("damper", gb.Damper(c=3.0)),
    )  # fmt: skip
    rig.chain(drive, body, damper, rig.add("ground", gb.Fixed()))
    w = np.array([20.0, 40.0])
    made = gb.sweep(
        rig, {"speed": w}, quantity=[gb.points("body.w"), gb.rms("body.w"), gb.peak("body.w")],
        section=gb.stroboscopic("speed"), transient=40, keep=3, rtol=1e-9, chunk=2,
    )  # fmt: skip
    assert made["points(body.w)"].shape == (2, 3)
    assert made["points(body.w)"] == pytest.approx(np.repeat(3.0 / (9 + w**2), 3).reshape(2, 3), abs=1e-9)
    size = 1 / np.sqrt(9 + w**2)  # the transient exp(-3 t) is below 1e-8 after 40 periods
    assert made["rms(body.w)"] == pytest.approx(size / np.sqrt(2), rel=1e-7)
    assert made["peak(body.w)"] == pytest.approx(size, rel=1e-7)


# -- what goes wrong ----------------------------------------------------------------------------------------------------


def test_a_failing_point_is_named_and_does_not_spoil_its_neighbours(clutch_model: gb.Model) -> None:
    gains = [0.0, 1e4, 0.01, 2e4]
    made = gb.sweep(clutch_model, {"gain": gains}, quantity=QUANTITIES[:4], t_end=0.5, threads=1, chunk=4)
    assert np.isnan(made.values).all(axis=1).tolist() == [False, True, False, True]
    assert [f.point for f in made.failures] == [{"gain": 1e4}, {"gain": 2e4}]
    with pytest.raises(gb.SimulationError) as single:
        gb.simulate(clutch_model, t_end=0.5, parameters={"gain": 1e4})
    assert made.failures[0].message == str(single.value)
    assert made.values[2].tolist() == [
        float(q.of(gb.simulate(clutch_model, t_end=0.5, parameters={"gain": 0.01}))) for q in QUANTITIES[:4]
    ]
    assert "2 points failed; first gain = 10000" in repr(made)


def _late(t: float) -> float:
    if t > 0.1:
        raise ValueError("no torque is known after 0.1 s")
    return 2.0


def test_an_input_function_that_raises_is_a_failure_with_its_words(clutch_model: gb.Model) -> None:
    values = {"shaft.k": [150.0, 200.0, 250.0]}
    made = gb.sweep(clutch_model, values, quantity=QUANTITIES[0], t_end=0.2, inputs={"tau": _late}, threads=2)
    assert len(made.failures) == 3
    assert "'tau': the input function raised" in made.failures[1].message
    assert "ValueError: no torque is known after 0.1 s" in made.failures[1].message
    steady = gb.sweep(clutch_model, values, quantity=QUANTITIES[0], t_end=0.09, inputs={"tau": _late}, threads=2)
    assert (
        steady.values.tobytes()
        == gb.sweep(
            clutch_model, values, quantity=QUANTITIES[0], t_end=0.09, inputs={"tau": lambda t: 2.0}
        ).values.tobytes()
    )


def test_a_function_that_raises_at_both_ends_is_a_slip_and_elsewhere_a_failure(clutch_model: gb.Model) -> None:
    def wrong(run: gb.Trajectory) -> float:
        return 1.0 / (run.meta["parameters"]["shaft.k"] - 200.0)

    for values in ([200.0], [200.0, 200.0], [200.0, 210.0, 200.0]):
        with pytest.raises(
            gb.ParameterError, match=r"quantity = wrong: ZeroDivisionError.*mend the function, or .*nan"
        ) as told:
            gb.sweep(clutch_model, {"shaft.k": values}, quantity=wrong, t_end=0.01)
        assert isinstance(told.value.__cause__, ZeroDivisionError)
    for values, failed in (([210.0, 200.0], 1), ([200.0, 210.0], 0)):
        made = gb.sweep(clutch_model, {"shaft.k": values}, quantity=wrong, t_end=0.01)
        assert made["wrong"][1 - failed] == 0.1 and np.isnan(made["wrong"][failed])
        assert [x.message for x in made.failures] == ["wrong: ZeroDivisionError: float division by zero"]


def test_energy_that_does_not_balance_is_told() -> None:
    rig = gb.Drivetrain("stepped over")
    ground, shaft = rig.add("ground", gb.Fixed()), rig.add("shaft", gb.Shaft(k=100.0, c=0.1))
    rig.connect(ground.flange, shaft.a)
    rig.connect(shaft.b, rig.add("body", gb.Inertia(J=1.0, w0=1.0)).a)
    steps: dict[str, Any] = {"t_end": 10.0, "method": "rk4", "step": 0.2}
    with pytest.warns(gb.errors.GearblocksWarning, match="2 of 2 points are in doubt") as told:
        made = gb.sweep(rig, {"shaft.k": [90.0, 100.0]}, quantity=gb.last("body.w"), **steps)
    assert len(made.doubts) == 2 and not made.failures and "in doubt" in repr(made)
    with pytest.warns(gb.errors.GearblocksWarning, match="its energy is balanced") as of_a_run:  # as a single run says
        gb.simulate(rig, **steps)
    assert [Path(said[0].filename) for said in (told, of_a_run)] == [Path(__file__)] * 2


def test_ctrl_c_keeps_what_is_done(clutch_model: gb.Model) -> None:
    counts = []

    def tell(done: int, total: int) -> None:
        counts.append((done, total))
        if done >= 4:
            raise KeyboardInterrupt

    made = gb.sweep(
        clutch_model, {"shaft.k": np.linspace(100, 200, 12)}, quantity=QUANTITIES[:3], t_end=0.4, threads=1, chunk=2,
        progress=tell,
    )  # fmt: skip
    assert counts == [(2, 12), (4, 12)]
    assert not made.complete and made.done.sum() == 4
    assert np.isfinite(made.values[made.done]).all() and np.isnan(made.values[~made.done]).all()
    assert not made.failures and "4 of 12 points are done" in repr(made)


class _Losing(Executor):
    """An executor whose worker dies."""

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future[Any]:
        from concurrent.futures.process import BrokenProcessPool

        future: Future[Any] = Future()
        future.set_exception(BrokenProcessPool("killed"))
        return future


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"values": {"shaft.kk": [1.0]}}, "no parameter, start value or input 'shaft.kk' - did you mean 'shaft.k'"),
        ({"values": {"J": [1.0]}}, "not unique"),
        ({"values": {"shaft.c": [1.0, -1.0]}}, "shaft.c = -1.0 N m s/rad must be"),
        ({"values": {"shaft.k": [1.0], "k": [2.0]}}, "'shaft.k' is given twice"),
        ({"parameters": {"k": 3.0}}, "'shaft.k' is given twice"),
        ({"values": {"tau": [1.0]}, "inputs": {"tau": 1.0}}, "'tau' is given twice"),
        ({"values": {"motor.w": [1.0]}, "initial": "static"}, "is a start value"),
        ({"quantity": ()}, "at least one"),
        ({"quantity": "load.w"}, "such as gb.peak"),
        ({"quantity": [gb.last("load.w"), gb.last("load.w")]}, "given twice"),
        ({"quantity": gb.peak("load.w", after=2.0)}, "after = 2 s"),
        ({"quantity": gb.last("lod.w")}, "did you mean 'load.w'"),
        ({"t_end": None}, "give t_end"),
        ({"t_end": -1.0}, "must be later"),
        ({"section": gb.stroboscopic("gain"), "t_end": None}, "is no frequency, it is in N m s/rad"),
        ({"section": 3, "t_end": None}, "section = 3"),
        ({"section": gb.stroboscopic("gain"), "t_end": None, "keep": 0}, "keep = 0"),
        ({"method": "euler"}, "method = 'euler'"),
        ({"threads": 0}, "threads = 0"),
        ({"chunk": 1.5}, "chunk = 1.5"),
        ({"executor": 4}, "executor = 4"),
        ({"progress": 4}, "progress = 4"),
        ({"executor": _Losing(), "chunk": 1}, "lost its workers"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(clutch_model: gb.Model, change: dict[str, Any], words: str) -> None:
    arguments = {"values": {"shaft.k": [1.0]}, "quantity": gb.last("load.w"), "t_end": 0.1, **change}
    with pytest.raises(gb.GearblocksError) as caught:
        gb.sweep(clutch_model, arguments.pop("values"), **arguments)
    assert words in str(caught.value)


def test_a_ratio_is_structural_and_refused_with_the_remedy() -> None:
    rig = gb.Drivetrain("geared")
    a, gear, b = (
        rig.add("a", gb.Inertia(J=1.0)),
        rig.add("gear", gb.IdealGear(ratio=2.0)),
        rig.add("b", gb.Inertia(J=1.0)),
    )
    rig.chain(a, gear, b)
    with pytest.raises(gb.ParameterError, match=r"structural: make one study for each rig\.set"):
        gb.sweep(rig, {"gear.ratio": [2.0, 3.0]}, quantity=gb.last("a.w"), t_end=0.1)


def test_what_cannot_be_sent_to_processes_is_refused_before_anything_is_run(
    clutch_model: gb.Model, processes: Executor
) -> None:
    with pytest.raises(gb.ParameterError, match="cannot be sent to other processes"):
        gb.sweep(clutch_model, {"shaft.k": [1.0]}, quantity=lambda run: 1.0, t_end=0.1, executor=processes, chunk=1)


def test_no_thread_is_left_behind(clutch_model: gb.Model) -> None:
    gb.sweep(clutch_model, {"shaft.k": [100.0, 200.0]}, quantity=gb.last("load.w"), t_end=0.1, threads=2)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("gearblocks-study")]


def test_values_of_studies_bring_their_units() -> None:
    speed = gb.Parameter("n", 3000.0, "rpm")
    rig = gb.Drivetrain("shaken")
    drive, disc = rig.add("drive", gb.Torque(tau=5.0 * gb.sin(speed * gb.time))), rig.add("disc", gb.Inertia(J=1.0))
    rig.chain(drive, disc, rig.add("shaft", gb.Shaft(k=20.0, c=0.1)), rig.add("load", gb.Inertia(J=2.0)))
    ask: dict[str, Any] = {"quantity": gb.peak("shaft.torque", after="10 ms"), "t_end": "50 ms"}
    bare = gb.sweep(rig, {"shaft.k": [20.0, 30.0], "n": [3000.0, 1500.0], "disc.w": [0.0, math.pi]}, **ask)
    texts = {"shaft.k": ["20 N m/rad", "0.03 kN m"], "n": np.array(["3000 rpm", "1500 rpm"]), "disc.w": [0.0, "30 rpm"]}
    given = gb.sweep(rig, texts, **ask)
    np.testing.assert_array_equal(given.points, bare.points)
    np.testing.assert_array_equal(given.values, bare.values)
    cases = gb.study(rig, [{"n": "1500 rpm", "shaft.k": 20.0}, {"n": 3000.0, "shaft.k": "30 N m/rad"}], **ask)
    np.testing.assert_array_equal(cases.points, [[1500.0, 20.0], [3000.0, 30.0]])
    with pytest.raises(
        gb.ParameterError, match=r"shaft\.k = '3 mm' is in mm \(m\), but what belongs here is in N m/rad"
    ):
        gb.sweep(rig, {"shaft.k": ["3 mm", 20.0]}, **ask)
    with pytest.raises(gb.ParameterError, match=r"a row is needed, such as \['3000 rpm'\]"):
        gb.sweep(rig, {"n": "3000 rpm"}, **ask)
