"""An input function that ends the program (Ctrl-C, sys.exit) ends every tool that runs it; a mistake in it is a mistake."""

import functools
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

VALUES = {"body.J": np.linspace(1.0, 2.0, 6)}
ENDS = [KeyboardInterrupt, SystemExit, GeneratorExit]


class Source:
    """An input that raises at a time, from some call on."""

    def __init__(self, kind: type[BaseException], calls: int = 0, time: float = 0.0) -> None:
        self.kind, self.calls, self.time = kind, calls, time

    def __call__(self, t: float) -> float:
        self.calls -= 1
        if self.calls < 0 and t >= self.time:
            raise self.kind("enough")
        return 1.0


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("driven")
    drive, body = rig.add("drive", gb.Torque(tau=gb.Input("u"))), rig.add("body", gb.Inertia(J=1.0))
    mesh = rig.add("mesh", gb.SplineCoupling(teeth=20, radius=0.02, k=1e6, c=10.0, backlash=gb.Backlash(half_gap=1e-4)))
    rig.chain(drive, body, mesh, rig.add("ground", gb.Fixed()))
    return rig


@functools.cache
def _model() -> gb.Model:
    return gb.build(_rig())


def _last(run: gb.Trajectory) -> float:
    return float(run["body.w"][-1])


def _swept(source: Any, quantity: Any = None, **how: Any) -> gb.Study:
    quantity = quantity or gb.last("body.w")
    return gb.sweep(_model(), VALUES, quantity=quantity, t_end=0.02, inputs={"u": source}, **{"threads": 1, **how})


@functools.cache
def _calls() -> int:
    """How often a run of one point calls its input."""
    source = Source(ValueError, calls=10**9)
    gb.sweep(
        _model(), {"body.J": [1.0]}, quantity=gb.last("body.w"), t_end=0.02, inputs={"u": source}, chunk=1, threads=1
    )
    return 10**9 - source.calls


@pytest.mark.parametrize("initial", [None, "static", "rolling"])
@pytest.mark.parametrize("quantity", [gb.last("body.w"), _last], ids=["quantity", "function"])
@pytest.mark.parametrize("end", ENDS)
def test_an_input_that_ends_the_program_at_its_first_call_ends_a_study(
    end: type[BaseException], quantity: Any, initial: Any
) -> None:
    with pytest.raises(end, match="enough"):
        _swept(Source(end), quantity, initial=initial)


@pytest.mark.parametrize("quantity", [gb.last("body.w"), _last], ids=["quantity", "function"])
@pytest.mark.parametrize("end", ENDS)
def test_it_ends_the_first_run_too_where_that_is_under_way(end: type[BaseException], quantity: Any) -> None:
    with pytest.raises(end):
        _swept(Source(end, time=0.01), quantity)


@pytest.mark.parametrize("quantity", [gb.last("body.w"), _last], ids=["quantity", "function"])
def test_ctrl_c_in_an_input_keeps_what_is_done_and_a_second_call_goes_on(quantity: Any, tmp_path: Path) -> None:
    """As Ctrl-C anywhere else in a study."""
    whole = _swept(Source(ValueError, calls=10**9), quantity)
    assert whole.complete and not whole.failures
    source = Source(KeyboardInterrupt, calls=int(2.5 * _calls()))
    first = _swept(source, quantity, store=tmp_path / "a.zarr", chunk=1)
    assert not first.complete and 1 <= first.done.sum() <= 3 and not first.failures
    source.kind, source.calls = ValueError, 10**9
    second = _swept(source, quantity, store=tmp_path / "a.zarr", chunk=1)
    assert second.complete and not second.failures and second.values.tobytes() == whole.values.tobytes()
    assert 10**9 - source.calls < 6 * _calls()


def test_what_was_stored_before_an_exit_stays_stored(tmp_path: Path) -> None:
    source = Source(SystemExit, calls=int(2.5 * _calls()))
    with pytest.raises(SystemExit):
        _swept(source, store=tmp_path / "a.zarr", chunk=1)
    source.kind = KeyboardInterrupt
    source.calls = 0
    kept = _swept(source, store=tmp_path / "a.zarr", chunk=1)
    assert 1 <= kept.done.sum() <= 3 and not kept.failures


def _exits(t: float) -> float:
    raise SystemExit("enough")


def _interrupts(t: float) -> float:
    raise KeyboardInterrupt


def test_it_ends_a_study_on_other_processes() -> None:
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(SystemExit, match="enough"):
            _swept(_exits, threads=None, chunk=2, executor=pool)
        stopped = _swept(_interrupts, threads=None, chunk=2, executor=pool)
        assert not stopped.done.any() and not stopped.failures


@pytest.mark.parametrize("initial", [None, "static", "rolling"])
@pytest.mark.parametrize("quantity", [gb.last("body.w"), _last], ids=["quantity", "function"])
def test_a_mistake_in_an_input_is_a_failed_point_that_names_the_input_and_the_mistake(
    quantity: Any, initial: Any
) -> None:
    made = _swept(Source(ZeroDivisionError, time=0.0), quantity, initial=initial)
    assert made.complete and len(made.failures) == 6
    assert all("'u': the input function raised ZeroDivisionError: enough" in one.message for one in made.failures)


TOOLS = {
    "linearize": lambda inputs: gb.linearize(_model(), inputs=inputs),
    "carried_start": lambda inputs: gb.carried_start(
        _rig(), _rig().without("mesh.backlash"), initial="static", inputs=inputs
    ),
    "price": lambda inputs: gb.price(_scene(inputs)),
    "fit": lambda inputs: gb.fit(_scene(inputs)),
    "work_precision": lambda inputs: gb.work_precision(_scene(inputs)),
    "study": lambda inputs: gb.study(
        _model(), [{"body.J": 1.0}], quantity=gb.last("body.w"), t_end=0.02, inputs=inputs
    ),
}


def _scene(inputs: Any) -> gb.Scene:
    return gb.Scene(_rig(), t_end=0.02, quantity=(gb.peak("body.w"),), inputs=inputs)


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("end", [KeyboardInterrupt, SystemExit])
def test_it_ends_every_tool_that_takes_inputs(end: type[BaseException], tool: str) -> None:
    with pytest.raises(end, match="enough"):
        TOOLS[tool]({"u": Source(end)})


@pytest.mark.parametrize("tool", [name for name in TOOLS if name != "study"])
def test_a_mistake_in_an_input_names_it_in_every_tool(tool: str) -> None:
    with pytest.raises(gb.SimulationError, match="'u': the input function raised ZeroDivisionError: enough"):
        TOOLS[tool]({"u": Source(ZeroDivisionError)})


def test_an_exit_in_a_trial_ends_a_price() -> None:
    """In a thread of its trains."""
    with pytest.raises(SystemExit, match="enough"):
        gb.price(_scene({"u": Source(SystemExit, calls=6 * _calls())}))
