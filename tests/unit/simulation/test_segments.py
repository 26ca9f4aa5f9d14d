"""Segments of a run: the solver's own steps with nodes between them, and a closer look that takes the same steps."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.simulation import segments
from gearblocks.simulation.arguments import method_options, set_inputs
from gearblocks.simulation.case import Case
from gearblocks.simulation.segments import NODES, Needs, Segments


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


def _segments(model: gb.Model, needs: Needs, method: str = "auto") -> tuple[Segments, gb.Trajectory]:
    run = gb.simulate(model, t_end=1.0, method=method)
    sim = model.library.open()
    sim.parameters[:] = model.values
    set_inputs(sim, model.program, {})
    options, _ = method_options(method, 1e-6, None, None, True, 1.0)
    case = Case(model.library, model.values, {}, options, 0.0, 1.0, None)
    return Segments(sim, model.program, case, needs), run


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_segments_are_the_accepted_steps_with_the_sides_of_events(rattling: gb.Model, method: str) -> None:
    found, run = _segments(rattling, Needs(("left.w",), ((0.0, 1.0),)), method)
    smooth = run.t[1:] > run.t[:-1]
    assert (found.t0 == run.t[:-1][smooth]).all() and (found.t1 == run.t[1:][smooth]).all()
    assert len(run.events) > 20 and found.events == run.events
    _, _, nodes = found.within("left.w", 0.0, 1.0)
    assert (nodes[:, 0] == run["left.w"][:-1][smooth]).all() and (nodes[:, 4] == run["left.w"][1:][smooth]).all()
    long = found.t1 - found.t0 > 1e-12  # shorter ones may have several nodes at one time
    times = (found.t0[:, None] + (found.t1 - found.t0)[:, None] * NODES[1:-1])[long].ravel()
    between = gb.simulate(rattling, t=np.append(times, 1.0), method=method)
    assert (nodes[long, 1:4].ravel() == between["left.w"][:-1]).all()


def test_a_closer_look_takes_the_same_steps_from_wherever_it_begins(
    rattling: gb.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = np.sort(np.random.default_rng(5).uniform(0.0, 1.0, 200))
    exact = gb.simulate(rattling, t=np.append(times, 1.0))["left.w"][:-1]
    for seconds, room in ((1e-6, 1 << 30), (1e-6, 1 << 16), (10.0, 1 << 30)):
        monkeypatch.setattr(segments, "_SLICE", seconds)
        monkeypatch.setattr(segments, "_MARKS", room)
        found, _ = _segments(rattling, Needs(("left.w",), ((0.0, 1.0),)))
        assert (found.sample("left.w", times) == exact).all()


def test_windows_that_cut_a_segment_leave_the_others_as_they_are(rattling: gb.Model) -> None:
    whole, _ = _segments(rattling, Needs(("left.w",), ((0.0, 1.0),)))
    a, b = 0.3003, 0.7007
    cut, _ = _segments(rattling, Needs(("left.w",), ((a, b),)))
    t0, t1, nodes = cut.within("left.w", a, b)
    inside = (whole.t0 >= a) & (whole.t1 <= b)
    assert (nodes[1:-1] == whole.within("left.w", 0.0, 1.0)[2][inside]).all()
    assert (t0[0], t1[-1]) == (a, b) and (t0[1:] == t1[:-1]).all()
    tiny = (0.5000001, 0.5000002)
    within, _ = _segments(rattling, Needs(("left.w",), (tiny,)))
    assert [x.shape for x in within.within("left.w", *tiny)] == [(1,), (1,), (1, 5)]


def test_segments_without_room_for_nodes_are_told_from_sides_of_events() -> None:
    wide, eps = [0.0, *NODES[1:-1], 1.0], np.spacing(1.0)
    assert segments._groups(np.array(wide)).tolist() == [[0, 1, 2, 3, 4]]
    tight = np.array([*wide, 1.0, *[1.0 + eps] * 4, 1.0 + eps])
    assert segments._groups(tight).tolist() == [[0, 1, 2, 3, 4], [5, 6, 7, 8, 9]]
