"""Runs with bad arguments, bad inputs and in hostile surroundings: a clear word by name, and what was done is kept."""

import multiprocessing
import os
import shutil
import signal
import threading
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.errors import GearblocksWarning

NAN, INF = float("nan"), float("inf")


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("rig")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))),
        rig.add("motor", gb.Inertia(J=0.02)),
        rig.add("shaft", gb.Shaft(k=1.0e3, c=1.0)),
        rig.add("wheel", gb.Inertia(J=0.1)),
    )
    return rig


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(_rig())


def _refused(model: Any, words: str, **arguments: Any) -> None:
    with pytest.raises((gb.ParameterError, gb.UnknownNameError)) as caught:
        gb.simulate(model, **arguments)
    assert words in str(caught.value), str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "give either t_end"),
        ({"t_end": 1.0, "t": [0, 1]}, "give either t_end"),
        *(({"t_end": x}, "t_end = ") for x in (NAN, INF, 0, -1, "1", [1], 1j, True, gb.time)),
        *(({"t": x}, "t ") for x in ([1, 0], [0, 0], [0, NAN], [], "abc", [[0, 1]], [-1, 0], [0, 1j], ["a"], gb.time)),
        ({"t_end": 1.0, "t_start": 1.0}, "must be later than the start"),
        ({"t_end": 1.0, "t_start": "x"}, "t_start = 'x' must be a number"),
        *(({"t_end": 1.0, "rtol": x}, "rtol = ") for x in (0, -1, NAN, 1, "1", None, 1e-20)),
        *(({"t_end": 1.0, "step": x}, "step = ") for x in (0, -1, NAN, INF, "x")),
        *(({"t_end": 1.0, "max_step": x}, "max_step = ") for x in (0, -1, NAN, "x")),
        *(({"t_end": 1.0, "method": x}, "method = ") for x in ("rk5", "radau", 4, None, ["dp5"])),
        ({"t_end": 1.0, "method": "rk4"}, "give step="),
        *(({"t_end": 1.0, "locate": x}, "locate = ") for x in ("x", None, 2)),
        ({"t_end": 1.0, "progress": 3}, "progress = 3 must be a function"),
        ({"tend": 1.0}, "simulate has no argument 'tend'"),
        ({"tend": 1.0}, "did you mean 't_end'"),
        *(({"t_end": 1.0, "outputs": x}, "outputs = ") for x in (3, None, ["motor.w", 3])),
        *(({"t_end": 1.0, "outputs": x}, "no output matches") for x in ("mtor.*", "motr.w", "", ["motor.w", "x"])),
        ({"t_end": 1.0, "inputs": {"tua": 1}}, "did you mean 'tau'"),
        *(
            ({"t_end": 1.0, "inputs": {"tau": x}}, "input 'tau' = ")
            for x in (NAN, INF, "x", None, [1, 2], 1j, True, gb.time, sp.sin(gb.time), gb.Parameter("x", 1.0))
        ),
        *(({"t_end": 1.0, what: x}, f"{what} = ") for what in ("inputs", "parameters") for x in ("tau", ["tau"], 3)),
        *(({"t_end": 1.0, what: {3: 4}}, "must be text, not 3") for what in ("inputs", "parameters", "initial")),
        ({"t_end": 1.0, "parameters": {"motor.j": 1}}, "did you mean 'motor.J'"),
        ({"t_end": 1.0, "parameters": {"J": 1}}, "is not unique: it could be motor.J, wheel.J"),
        *(
            ({"t_end": 1.0, "parameters": {"motor.J": x}}, "motor.J = ")
            for x in (-1, NAN, "x", None, [1], True, 1j, gb.time)
        ),
        *(({"t_end": 1.0, "initial": {"motor.w": x}}, "motor.w = ") for x in (NAN, "x", None, True)),
        ({"t_end": 1.0, "initial": {"motr.w": 1}}, "did you mean 'motor.w'"),
        *(({"t_end": 1.0, "initial": x}, "initial = ") for x in ("satic", 3, ["motor.w"], np.zeros(4))),
    ],
)
def test_a_bad_argument_is_named_with_its_value(model: gb.Model, arguments: dict[str, Any], words: str) -> None:
    _refused(model, words, **arguments)


def test_what_is_no_train_and_values_without_a_name_are_refused(model: gb.Model) -> None:
    for thing in (gb.Inertia(J=1.0), None, "rig", gb.Drivetrain, {}):
        with pytest.raises(gb.GearblocksError, match="is no Drivetrain"):
            gb.simulate(thing, t_end=1.0)  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match=r"1\.0 is given without a name"):
        gb.simulate(model, 1.0)


def test_a_run_of_another_train_cannot_be_continued(model: gb.Model) -> None:
    other = gb.Drivetrain("other")
    other.add("a", gb.Inertia(J=1.0))
    run = gb.simulate(other, t_end=0.1)
    _refused(model, "is of another train", t_end=1.0, initial=run)


# -- inputs that fail during the run ----------------------------------------------------------------------------------


def _late(bad: Callable[[], Any]) -> Callable[[float], Any]:
    return lambda t: bad() if t > 0.05 else 1.0


def _failing(model: gb.Model, **arguments: Any) -> gb.SimulationError:
    with pytest.raises(gb.SimulationError) as caught:
        gb.simulate(model, **arguments)
    return caught.value


@pytest.mark.parametrize(
    ("bad", "cause", "behind"),
    [
        (lambda: NAN, "the input became NaN or infinite", type(None)),
        (lambda: INF, "the input became NaN or infinite", type(None)),
        (lambda: None, "the input function raised", TypeError),
        (lambda: "x", "the input function raised", ValueError),
        (lambda: 1j, "the input function raised", TypeError),
        (lambda: 1 / 0, "the input function raised", ZeroDivisionError),
        (lambda: {}["x"], "the input function raised", KeyError),
    ],
)
def test_an_input_that_fails_stops_the_run_by_name_and_keeps_what_is_done(
    model: gb.Model, bad: Callable[[], Any], cause: str, behind: type
) -> None:
    for times in ({"t_end": 0.1}, {"t": np.linspace(0, 0.1, 21)}):
        error = _failing(model, inputs={"tau": _late(bad)}, **times)
        assert error.component == "tau"
        assert cause in error.cause
        assert error.remedy
        assert 0.05 < error.time <= 0.1
        assert isinstance(error.__cause__, behind)
        assert error.trajectory is not None
        assert not error.trajectory.complete
        assert len(error.trajectory.t) > 2
        assert 0.03 < error.trajectory.t[-1] <= 0.0525  # the last step or sample before the input failed
        assert np.isfinite(error.trajectory["motor.w"]).all()
        assert "'tau'" in str(error)
        assert "t = 0.05" in str(error)


@pytest.mark.parametrize("bad", [lambda t: NAN, lambda t: None, lambda t: 1 / 0, lambda: 1.0, lambda t: np.zeros(2)])
def test_an_input_that_fails_at_once_is_named(model: gb.Model, bad: Any) -> None:
    error = _failing(model, t_end=0.1, inputs={"tau": bad})
    assert (error.component, error.time) == ("tau", 0.0)


def test_a_table_with_a_hole_is_refused_before_the_run() -> None:
    with pytest.raises(gb.GearblocksError, match="Table: x and y must be finite"):
        gb.Table([0, 1, 2], [0, NAN, 1])


# -- runs that cannot go on -------------------------------------------------------------------------------------------


def _train(*blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in zip(("a", "b", "c"), blocks, strict=False)))
    return rig


class _Signum(gb.Block):
    """Dry friction written as a sign of the speed, which cannot hold at rest (a Brake can)."""

    a = gb.Flange("shaft")

    def physics(self, s: Any) -> Iterator[Any]:
        yield gb.Acts(s.a, -2 * sp.sign(s.a.w))


def test_friction_written_as_a_sign_is_refused_at_rest_by_name_with_the_run_so_far() -> None:
    load = _Signum()
    rig = _train(gb.Torque(tau=sp.sin(gb.time)), gb.Inertia(J=1.0, w0=0.1), load)
    error = _failing(gb.build(rig), t_end=3.0)
    assert error.component.startswith("c")
    assert "sticks" in error.remedy
    stop = error.time  # w = 0.1 + 1 - cos t - 2 t
    assert abs(0.1 + 1 - np.cos(stop) - 2 * stop) < 1e-6  # the default rtol
    assert error.trajectory.t[-1] == pytest.approx(stop, abs=1e-9)
    assert abs(error.trajectory["b.w"][-1]) < 1e-6
    resting = _train(gb.Inertia(J=1.0), load)
    assert _failing(gb.build(resting), t_end=3.0).component.startswith("b")


def test_a_motion_that_runs_away_is_named_with_its_time() -> None:
    rig = _train(gb.Torque(tau=gb.sense("b.w") ** 3), gb.Inertia(J=1.0, w0=1.0))
    error = _failing(gb.build(rig), t_end=3.0)
    assert error.component == "b"
    assert error.time == pytest.approx(0.5, abs=1e-4)  # 1/w^2 = 1 - 2 t
    assert error.trajectory.t[-1] <= error.time


# -- Ctrl-C -----------------------------------------------------------------------------------------------------------


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Ctrl-C heard, also where the tests run in the background of a shell (it is ignored there)."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_gives_back_what_is_done() -> None:
    model = gb.build(_train(gb.Torque(tau=sp.sin(1000 * gb.time)), gb.Inertia(J=1.0)))
    pressed = threading.Event()

    def press(_: float) -> None:
        if not pressed.is_set():
            pressed.set()
            os.kill(os.getpid(), signal.SIGINT)

    run = gb.simulate(model, t_end=1e6, max_step=1e-4, progress=press)
    assert not run.complete
    assert 0 < run.t[-1] < 1e6
    assert len(run.t) == len(run["b.w"])


@pytest.mark.usefixtures("ctrl_c")
def test_ctrl_c_inside_an_input_function_gives_back_what_is_done(model: gb.Model) -> None:
    def pressed(t: float) -> float:
        if t > 0.05:
            os.kill(os.getpid(), signal.SIGINT)
        return 1.0

    run = gb.simulate(model, t_end=1.0, inputs={"tau": pressed})
    assert not run.complete
    assert 0.03 < run.t[-1] < 0.06  # the step that asked was not kept


# -- hostile surroundings ---------------------------------------------------------------------------------------------


def _speed(name: str = "cached") -> float:
    rig = gb.Drivetrain(name)
    rig.chain(rig.add("t", gb.Torque(tau=1.0)), rig.add("i", gb.Inertia(J=1.0)))
    return float(gb.simulate(rig, t_end=1.0)["i.w"][-1])


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    place = tmp_path / "cache"
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(place))
    return place


def test_a_cache_that_cannot_be_written_is_named_once_and_the_run_is_right(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "file" / "cache"))
    with pytest.warns(GearblocksWarning, match="cannot be written.*GEARBLOCKS_CACHE") as caught:
        assert _speed() == pytest.approx(1.0, rel=1e-12)
    assert len([w for w in caught if issubclass(w.category, GearblocksWarning)]) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _speed() == pytest.approx(1.0, rel=1e-12)


def test_a_full_disk_under_the_cache_is_named_and_the_run_is_right(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = os.replace

    def full(source: Any, target: Any) -> None:
        if str(target).startswith(str(cache)):
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    with pytest.warns(GearblocksWarning, match="no space left on device"):
        assert _speed() == pytest.approx(1.0, rel=1e-12)


def _elsewhere(processes: int = 1) -> list[float]:
    """The speed from as many fresh processes at once."""
    with multiprocessing.get_context("spawn").Pool(processes) as pool:
        return pool.map(_speed, ["elsewhere"] * processes, chunksize=1)


def test_damaged_entries_of_the_cache_are_made_anew(cache: Path) -> None:
    assert _elsewhere() == [pytest.approx(1.0, rel=1e-12)]
    for damage in (b"", b"\0" * 4096):
        entries = [path for path in cache.rglob("*") if path.is_file()]
        assert len(entries) > 4
        for path in entries:
            path.write_bytes(damage)
        assert _elsewhere() == [pytest.approx(1.0, rel=1e-12)]


def test_a_cache_that_vanishes_is_made_anew(cache: Path) -> None:
    for _ in range(2):
        assert _speed() == pytest.approx(1.0, rel=1e-12)
        shutil.rmtree(cache)


def test_two_processes_that_build_one_model_at_once_both_run(cache: Path) -> None:
    assert _elsewhere(2) == [pytest.approx(1.0, rel=1e-12)] * 2


@pytest.mark.parametrize("ending", [".csv", ".nc", ".json"])
def test_a_full_disk_while_a_run_is_written_keeps_the_file_that_was_there(
    model: gb.Model, ending: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = gb.simulate(model, t_end=0.1)
    path = tmp_path / f"run{ending}"
    path.write_text("before")

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    for call in ("fsync", "replace"):
        with monkeypatch.context() as patch:
            patch.setattr(os, call, full)
            with pytest.raises(gb.GearblocksError, match=f"run{ending}.*no space left.*unchanged"):
                run.save(path)
        assert path.read_text() == "before"
        assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(gb.GearblocksError, match="there is no folder"):
        run.save(tmp_path / "none" / f"run{ending}")
    run.save(path)
    assert path.stat().st_size > 100
