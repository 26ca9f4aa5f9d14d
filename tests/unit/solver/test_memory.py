"""Memory of simulations that serves the next run: what ran before leaves no trace, and what is tied is not handed on."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gearblocks as gb
from benchmarks.problems import p1, p2
from gearblocks.solver.memory import SPARE


def _geared():
    """A clutch, a stop and a torque by an input: modes, impacts, constraint forces."""
    rig = gb.Drivetrain("geared")
    blocks = [gb.Torque(tau=gb.Input("push", start=3.0)), gb.Inertia(J=0.3, w0=4.0), gb.Clutch(capacity=2.0)]
    blocks += [gb.Inertia(J=0.5), gb.Lash(k=2e3, half_gap=0.01, c=0.2), gb.Inertia(J=2.0)]
    parts = [rig.add(f"part{i}", block) for i, block in enumerate(blocks)]
    rig.chain(*parts)
    return rig


def _bits(run):
    final = run.final_state
    assert final is not None
    return (
        run.t.tobytes(), final.y.tobytes(), final.modes.tobytes(), run.events.array.tobytes(), run.stats.steps,
        run.stats.rhs_calls, run.energy.residual,
    )  # fmt: skip


ASKED = {"t_end": 0.02, "rtol": 1e-7}
OTHERS = [
    {"t_end": 0.05, "method": "dp5", "rtol": 1e-3},
    {"t_end": 1e-3, "method": "rk4", "step": 1e-6, "locate": False},
    {"t": np.linspace(0.0, 0.03, 7), "outputs": []},
    {"t_end": 0.01, "initial": "static_at_start"},
    {"t_end": 0.01, "t_start": -3.0},
]


@pytest.mark.parametrize("make", [p1, p2, _geared])
@pytest.mark.few(1)
def test_what_ran_before_changes_no_bit(make):
    model = gb.build(make())
    expected = _bits(gb.simulate(model, **ASKED))
    path = next(p.path for p in model.program.parameters if p.path.endswith((".c", ".k")))
    for other in [*OTHERS, {"t_end": 0.02, "parameters": {path: 1.7 * model.values[0] + 0.1}}]:
        if other.get("initial") and make is _geared:
            continue  # the clutch slips: no equilibrium
        gb.simulate(model, **other)
        assert len(model.library._spare) == 1
        assert _bits(gb.simulate(model, **ASKED)) == expected


def test_inputs_are_those_of_the_run():
    model = gb.build(_geared())
    plain = _bits(gb.simulate(model, **ASKED))
    pushed = _bits(gb.simulate(model, inputs={"push": 9.0}, **ASKED))
    assert pushed != plain
    assert _bits(gb.simulate(model, **ASKED)) == plain
    table = gb.Table([0.0, 1.0], [0.0, 50.0])
    for source in (table, lambda t: 50.0 * t):
        tied = _bits(gb.simulate(model, inputs={"push": source}, **ASKED))
        assert tied != plain and _bits(gb.simulate(model, inputs={"push": source}, **ASKED)) == tied
        assert _bits(gb.simulate(model, **ASKED)) == plain


def test_what_fails_or_has_something_tied_is_not_handed_on():
    model = gb.build(_geared())
    gb.simulate(model, inputs={"push": lambda t: 1.0}, **ASKED)
    assert model.library._spare == []
    with pytest.raises(gb.SimulationError):
        gb.simulate(model, inputs={"push": lambda t: float("nan")}, **ASKED)
    with pytest.raises(gb.ParameterError):
        gb.simulate(model, inputs={"push": float("nan")}, **ASKED)
    assert model.library._spare == []


def test_threads_share_what_is_spare():
    model = gb.build(p1())
    expected = _bits(gb.simulate(model, **ASKED))
    with ThreadPoolExecutor(8) as workers:
        found = [*workers.map(lambda _: _bits(gb.simulate(model, **ASKED)), range(40))]
    assert set(found) == {expected}
    assert 1 <= len(model.library._spare) <= SPARE


def test_results_outlive_the_memory_that_made_them():
    model = gb.build(p1())
    run = gb.simulate(model, **ASKED)
    names = run.names
    kept = {name: run[name].copy() for name in names[:3]}
    gb.simulate(model, t_end=0.5)
    assert all(np.array_equal(gb.simulate(model, **ASKED)[name], kept[name]) for name in kept)
    assert all(np.array_equal(run[name], kept[name]) for name in kept)
