"""Runs that are given bad inputs, run away, are interrupted or continued: a clear word by name, and what was done is kept."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

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
        (lambda: "x", "the input function raised TypeError: it answered 'x'", TypeError),
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
    with pytest.raises(gb.GearblocksError, match=r"Table: y\[1\] = nan must be a finite number"):
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


@pytest.mark.long
def test_friction_written_as_a_sign_in_a_block_holds_at_rest() -> None:
    load = _Signum()
    rig = _train(gb.Torque(tau=sp.sin(gb.time)), gb.Inertia(J=1.0, w0=0.1), load)
    run = gb.simulate(rig, t_end=3.0)
    stop = run.events[0].t  # w = 0.1 + 1 - cos t - 2 t
    assert abs(0.1 + 1 - np.cos(stop) - 2 * stop) < 1e-6  # the default rtol
    assert run.events[0].after == 0.5
    assert abs(run["b.w"][run.t >= stop]).max() < 1e-12
    assert abs(gb.simulate(_train(gb.Inertia(J=1.0), load), t_end=3.0)["a.w"]).max() == 0.0


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


# -- runs in pieces ---------------------------------------------------------------------------------------------------


def test_a_continued_run_keeps_the_contact_it_ended_in():
    rig = gb.Drivetrain("contact")
    body, lash, ground = (
        rig.add("body", gb.Inertia(J=1.0, w0=2.0)),
        rig.add("lash", gb.Lash(k=400.0, half_gap=0.1)),
        rig.add("ground", gb.Fixed()),
    )
    rig.chain(body, lash, ground)
    first = gb.simulate(rig, t_end=0.1, rtol=1e-10)  # in contact since 0.05 s
    second = gb.simulate(rig, t_end=0.2, rtol=1e-10, initial=first)
    assert second["lash.contact"][0] == first["lash.contact"][-1] == -1.0
    assert second.t[0] == first.t[-1]
    assert second["body.w"][0] == first["body.w"][-1]


@pytest.mark.long
def test_a_continued_run_keeps_the_parameters_of_the_first():
    rig = gb.Drivetrain("push")
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), rig.add("body", gb.Inertia(J=1.0)))
    first = gb.simulate(rig, t_end=1.0, parameters={"body.J": 4.0})
    second = gb.simulate(rig, t_end=2.0, initial=first)
    assert second["body.alpha"][0] == 0.25
    assert abs(second["body.w"][-1] - 0.5) < 1e-15  # rounding of the sum of steps


# -- events without end -----------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def ball() -> gb.Model:
    """A body that loses nothing between stops 1e-9 rad apart: 1e9 impacts a second."""
    rig = gb.Drivetrain("ball")
    body = rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    rig.connect(rig.add("gap", gb.HardStop(lower=0.0, upper=1e-9, restitution=1)).a, body.b)
    return gb.build(rig)


@pytest.mark.long
def test_events_that_do_not_let_the_run_end_stop_it_by_the_name_of_the_element(ball: gb.Model) -> None:
    with pytest.raises(gb.SimulationError, match=r"'gap': 10000\d events in a row .* needs a loss") as caught:
        gb.simulate(ball, t=[0.0, 100.0])
    assert caught.value.time == pytest.approx(1e-4, rel=0.01)


@pytest.mark.long
def test_the_record_of_a_run_is_bounded(ball: gb.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    from gearblocks.simulation import run

    monkeypatch.setattr(run, "memory_limit", lambda _: 5_000_000)
    with pytest.raises(
        gb.SimulationError, match=r"'gap': the record of \d+ steps and \d+ events .* give times t"
    ) as caught:
        gb.simulate(ball, t_end=100.0)
    assert 1e-6 < caught.value.time < 1e-4
    assert caught.value.trajectory is not None
