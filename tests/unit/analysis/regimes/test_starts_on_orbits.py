"""Runs that begin on orbits that were found: at their points, with their parameters, at the time of the point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import gearblocks as gb
from gearblocks.analysis.regimes.diagram_store import DiagramStore, Told
from gearblocks.analysis.regimes.orbit import PeriodicOrbit
from gearblocks.analysis.regimes.regime import Regime

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def _halved(oscillator: Oscillator) -> gb.Drivetrain:
    """Driven by half of the frequency of its section, too: each second period is another one."""
    return oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(drive * gb.time / 2), k=2.0, c=0.3)


def _hill(oscillator: Oscillator) -> gb.Drivetrain:
    return oscillator(lambda drive, x, v: 1e-3 * gb.cos(drive * gb.time) + 2 * x - x**3, c=0.25)


def _end(run: gb.Trajectory, names: tuple[str, ...]) -> NDArray[np.float64]:
    """The states at its end."""
    assert run.final_state is not None
    return run.final_state.y[: len(names)]


def _after(rig: gb.Drivetrain, orbit: PeriodicOrbit, number: int, periods: int) -> NDArray[np.float64]:
    """The states so many periods after a point."""
    start = orbit.starts[number]
    run = gb.simulate(rig, t_end=start.t[0] + periods * orbit.period, initial=start, rtol=1e-10)
    return _end(run, orbit.names)


def test_a_run_from_a_point_of_an_orbit_goes_on_along_it(oscillator: Oscillator) -> None:
    rig = _halved(oscillator)
    orbit = gb.periodic_orbit(rig, SECTION, periods=2, parameters={"drive": 1.3})
    assert orbit.periods == 2 and np.abs(orbit.points[0] - orbit.points[1]).max() > 0.1
    assert [run.t[0] for run in orbit.starts] == pytest.approx([0.0, 2 * np.pi / 1.3])
    for number in (0, 1):
        assert _after(rig, orbit, number, 1) == pytest.approx(orbit.points[1 - number], abs=1e-7)  # rtol, one period on
        assert orbit.starts[number].meta["parameters"]["drive"] == 1.3


def test_a_run_stays_on_an_orbit_that_is_not_stable(oscillator: Oscillator) -> None:
    rig = _hill(oscillator)
    orbit = gb.periodic_orbit(rig, SECTION, transient=0)
    assert not orbit.stable
    assert _after(rig, orbit, 0, 1) == pytest.approx(orbit.points[0], abs=1e-8)  # 250 times what it is off at the start
    again = gb.periodic_orbit(rig, SECTION, transient=0, initial=orbit.starts[0])
    assert again.points == pytest.approx(orbit.points, abs=1e-10)


def test_orbits_of_a_branch_and_its_marks_are_starts_at_their_parameter(oscillator: Oscillator) -> None:
    force = gb.Parameter("force", 5.0)
    rig = oscillator(lambda drive, x, v: force * gb.cos(drive * gb.time) - x**3, k=1e-12)
    branch = gb.continue_orbit(rig, "force", (5.2, 5.45), section=SECTION, of="disc.phi", step=0.3, periods=2)
    (mark,) = branch.marked("period doubling")
    assert len(branch.starts) == len(branch.values)
    for start, value, y in (
        (branch.starts[-1], branch.values[-1], branch.states[-1]), (mark.start, mark.value, mark.states),
    ):  # fmt: skip
        run = gb.simulate(rig, t_end=4 * np.pi, initial=start, rtol=1e-10)
        assert run.meta["parameters"]["force"] == pytest.approx(value, abs=1e-6)
        assert _end(run, branch.names) == pytest.approx(y, abs=1e-6)


def test_names_of_states_that_are_no_start_values_say_how_a_run_begins_on_an_orbit() -> None:
    rig, drive = gb.Drivetrain("two discs"), gb.Parameter("drive", 1.0, "rad/s")
    rig.chain(
        rig.add("source", gb.Torque(tau=gb.cos(drive * gb.time))), rig.add("left", gb.Inertia(J=1.0)),
        rig.add("shaft", gb.Shaft(k=3.0, c=0.4)), rig.add("right", gb.Inertia(J=2.0)),
    )  # fmt: skip
    orbit = gb.periodic_orbit(rig, SECTION)
    named = dict(zip(orbit.names, orbit.points[0], strict=True))
    with pytest.raises(gb.UnknownNameError, match=r"state that follows from these.*initial=orbit\.starts\[0\]"):
        gb.simulate(rig, t_end=1.0, initial=named)
    with pytest.raises(gb.UnknownNameError, match=r"there is no initial value 'shaft.twist'; there are [^.]*\.[^.]*"):
        gb.simulate(rig, t_end=1.0, initial={"shaft.twist": 0.1})
    assert gb.simulate(rig, t_end=1.0, initial=orbit.starts[0])["shaft.twist"][0] == pytest.approx(orbit.points[0, 0])
    assert gb.linearize(rig, at=orbit.starts[0]).A.shape == gb.linearize(rig).A.shape


def test_a_store_of_a_diagram_keeps_what_runs_begin_with(oscillator: Oscillator, tmp_path: Any) -> None:
    rig = _halved(oscillator)
    orbit = gb.periodic_orbit(rig, SECTION, periods=2)
    regime = Regime("period 2", (), orbit=orbit)
    DiagramStore(tmp_path / "d", {}).write((0, 0), Told(np.zeros(2), None, regime))
    found = DiagramStore(tmp_path / "d", {}).known[0, 0].found
    assert isinstance(found, Regime) and found.orbit is not None
    assert (_after(rig, found.orbit, 1, 1) == _after(rig, orbit, 1, 1)).all()
    assert (_after(rig, replace(orbit, parameters={"drive": 1.1}), 1, 1) != _after(rig, orbit, 1, 1)).all()
