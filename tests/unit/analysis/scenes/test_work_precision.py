"""What accuracy costs: values, steps and calls are those of direct runs, and the choice keeps what it promises."""

from __future__ import annotations

import csv
import itertools
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.scenes import work_precision
from gearblocks.analysis.scenes.bench import Effort, bench_of
from gearblocks.analysis.scenes.work_precision_points import Point
from gearblocks.analysis.scenes.work_precision_result import WorkPrecision
from gearblocks.cli import scripts

TURN = 1 / 6  # s, at 360 rpm


def direct(scene: gb.Scene, effort: Effort) -> gb.Trajectory:
    """The run that an effort means."""
    return gb.simulate(
        scene.drivetrain,
        t_end=scene.end,
        method=effort.method,
        rtol=effort.rtol,
        step=effort.step,
        locate=effort.locate,
    )


@pytest.fixture(scope="module")
def scene() -> gb.Scene:
    """The first turns of the spline: the teeth part in each, and the motion is not yet settled."""
    asked = gb.peak("spline.force", after=2 * TURN), gb.energy_lost("spline")
    return gb.Scene(scripts.make("spline_coupling:period_5"), t_end=5 * TURN, quantity=asked, within=0.01)


@pytest.fixture(scope="module")
def found(scene: gb.Scene) -> WorkPrecision:
    return gb.work_precision(scene, budget=20.0)


def _point(found: WorkPrecision, method: str, rtol: float, locate: bool = True) -> Point:
    return next(p for p in found.points if p.effort == Effort(method, rtol, None, locate))


@pytest.mark.long
def test_every_point_is_that_of_a_direct_run(scene: gb.Scene, found: WorkPrecision) -> None:
    fixed = next(p for p in found.points if p.effort.step and p.effort.locate)
    chosen = [_point(found, "dp8", 1e-4), _point(found, "auto", 1e-2), _point(found, "dp5", 1e-3, False), fixed]
    chosen += [_point(found, "rodas", 1e-2)]
    for point in chosen:
        run = direct(scene, point.effort)
        stats = (run.stats.steps, run.stats.rhs_calls, run.stats.events)
        assert (point.stats.steps, point.stats.rhs_calls, point.stats.events) == stats
        assert point.values.tolist() == [q.of(run) for q in scene.measures]  # to the bit: the same steps


@pytest.mark.parametrize("locate", [True, False])
@pytest.mark.parametrize("method", ["dp8", "dp5", "rodas", "auto"])
def test_quantities_change_no_step(scene: gb.Scene, method: str, locate: bool) -> None:
    bench, effort = bench_of(scene), Effort(method, 1e-2, None, locate)
    told, bare = bench.outcome(effort).stats, bench.timed(effort, 1)
    assert (told.steps, told.rejected, told.events) == (bare.steps, bare.rejected, bare.events)
    dense = 3 if method == "dp8" else 0  # rates of the solution between steps
    assert bare.rhs_calls <= told.rhs_calls <= bare.rhs_calls + dense * bare.steps


@pytest.mark.long
def test_errors_are_told_against_what_another_method_finds_too(scene: gb.Scene, found: WorkPrecision) -> None:
    run = direct(scene, Effort("dp5", 1e-12))
    true = np.array([q.of(run) for q in scene.measures])
    assert np.abs(found.reference.values / true - 1).max() < 1e-9  # what dp5 is off itself
    assert found.verified is not None and found.verified.errors.max() < 1e-7
    for point in found.points:
        errors = np.abs(point.values - found.reference.values) / np.abs(found.reference.values)
        assert point.errors == pytest.approx(errors, rel=1e-12)
    errors = [_point(found, "dp5", 10.0**-k).errors.max() for k in (2, 4, 6)]
    assert errors[0] > 10 * errors[1] > 100 * errors[2]


@pytest.mark.long
@pytest.mark.parametrize("within", [1e-2, 1e-4, 1e-6])
def test_the_choice_is_within_and_so_is_all_that_is_tighter(found: WorkPrecision, within: float) -> None:
    choice = found.cheapest(within)
    line = next(
        x for x in found.lines() if (x[0].effort.method, x[0].effort.locate) == (choice.effort[0], choice.effort[3])
    )
    place = [p.effort for p in line].index(choice.effort)
    assert all((p.errors <= within).all() for p in line[place:])
    sure = [p for p in found.points if (p.errors <= within).all() and p.seconds < choice.seconds]
    for cheaper in sure:  # was within by chance: one that is tighter is not
        tighter = [p for p in found.points if p.effort[0] == cheaper.effort[0] and p.effort[3] == cheaper.effort[3]]
        after = tighter[[p.effort for p in tighter].index(cheaper.effort) :]
        assert not all(p.within(within, slice(None)) for p in after)


@pytest.mark.long
@pytest.mark.parametrize("within", [1e-2, 1e-5])
def test_the_price_holds_for_longer_windows(scene: gb.Scene, found: WorkPrecision, within: float) -> None:
    once = found.cheapest(within)
    assert once.rhs_calls == direct(scene, once.effort).stats.rhs_calls
    for times in (1.5, 2.0, 4.0):
        measured = direct(scene.changed(t_end=times * scene.end), once.effort).stats.rhs_calls
        assert measured / 1.5 < found.cheapest(within, t_end=times * scene.end).rhs_calls < 1.5 * measured
    with pytest.raises(gb.ParameterError, match=r"within <= 1 %"):
        replace(found, after={}).cheapest(t_end=2 * scene.end)


def swing(w0: float = 1.0) -> gb.Drivetrain:
    rig = gb.Drivetrain("swing")
    disc, shaft = rig.add("disc", gb.Inertia(J=0.1, w0=w0)), rig.add("shaft", gb.Shaft(k=50.0, c=0.1))
    rig.chain(disc, shaft, rig.add("wall", gb.Fixed()))
    return rig


def test_a_longer_window_is_priced_by_what_comes_not_by_what_has_passed() -> None:
    rig = swing()
    rig.connect(rig["disc"].a, rig.add("motor", gb.Torque(tau=gb.Input("tau", unit="N m"))).flange)
    t = np.array([0.0, *np.linspace(3.0, 6.0, 201)])  # a torque that has corners in the second window alone
    pulses = {"tau": gb.Table(t.tolist(), (np.arange(202) % 2 * (t > 3.0)).tolist())}
    scene = gb.Scene(rig, t_end=3.0, inputs=pulses, quantity=gb.rms("disc.w"), within=0.01)
    found = gb.work_precision(scene, budget=5.0)
    once, twice = found.cheapest(), found.cheapest(t_end=6.0)
    how = {"method": once.effort.method, "rtol": once.effort.rtol, "step": once.effort.step}
    measured = gb.simulate(rig, t_end=6.0, inputs=pulses, **how).stats.rhs_calls
    assert measured / 1.5 < twice.rhs_calls < 1.5 * measured
    assert measured > 3 * once.rhs_calls


def test_a_longer_window_is_for_a_method_that_comes_to_its_end_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    stops: list[tuple[str, bool]] = []  # what is cheapest in the window stops after it, and one more

    def after(runs: Any, point: Point) -> float:
        stops.append(point.line)
        return math.nan if len(stops) <= 2 else 1.0

    monkeypatch.setattr(work_precision._Runs, "after", after)
    rig = swing()
    rig.chain(rig["disc"], rig.add("drag", gb.SpeedLoad(coeffs=(0.0, 0.01, 0.0))))
    found = gb.work_precision(gb.Scene(rig, t_end=1.0, quantity=gb.rms("disc.w"), within=0.01), budget=3.0)
    for within in (0.01, 1e-4):
        other = found.cheapest(within, t_end=2.0)
        assert (other.effort.method, other.effort.locate) not in stops[:2] and (other.errors <= within).all()
        assert other.rhs_calls == 2 * next(p for p in found.points if p.effort == other.effort).stats.rhs_calls
    assert found.cheapest().effort.method in {method for method, _ in stops}
    none = replace(found, after={p.line: math.nan for p in found.points})
    with pytest.raises(gb.ParameterError, match=r"after 1 s, no run as accurate comes to its end"):
        none.cheapest(t_end=2.0)


def test_a_budget_that_the_reference_takes_leaves_no_runs(scene: gb.Scene) -> None:
    found = gb.work_precision(scene, budget=1e-9)
    assert not found.points and "the reference alone took the budget" in found.sentence
    with pytest.raises(gb.ParameterError, match="the reference alone took the budget"):
        found.cheapest()


def test_a_machine_that_does_other_work_takes_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    ticks = itertools.count()  # three for each point, whatever it takes
    monkeypatch.setattr(work_precision, "thread_time", lambda: float(next(ticks)))
    scene = gb.Scene(swing(), t_end=3.0, quantity=gb.rms("disc.w"), within=1e-6)
    found = gb.work_precision(scene, budget=30.0)  # ten points, of which none is as accurate
    assert not any(point.within(scene.within, slice(None)) for point in found.points[:2])
    assert found.cheapest().errors[0] <= 1e-6 and 10 < len(found.points) <= 20


@pytest.mark.long
def test_the_sentence_says_what_the_runs_say(scene: gb.Scene, found: WorkPrecision) -> None:
    for name, line in zip(scene.names, found.sentence.splitlines(), strict=True):
        choice = found.cheapest(quantity=name)
        assert line.startswith(f"1 % of {name} costs ")
        assert f"({choice.rhs_calls:,.0f} right-hand sides)" in line and f" with {choice.effort.method} at " in line
        price, reach = re.search(r"each further digit costs x ([\d.]+), down to (\S+?)\.$", line).groups()
        tight = found.cheapest(float(reach.replace(" %", "")), quantity=name)
        digits = round(np.log10(0.01 / float(reach)))
        assert float(price) == pytest.approx((tight.seconds / choice.seconds) ** (1 / digits), rel=0.06)  # two digits
    assert str(found).endswith(found.sentence) and "events not located" in str(found)


def test_a_train_without_events_has_nothing_to_locate() -> None:
    found = gb.work_precision(gb.Scene(swing(), t_end=3.0, quantity=gb.rms("disc.w"), within=1e-3), budget=5.0)
    assert all(point.effort.locate for point in found.points)
    decay, w = 0.1 / 0.2, np.sqrt(500.0 - 0.25)  # of the amplitude; rad/s
    t = np.linspace(0.0, 3.0, 200_001)
    speed = np.exp(-decay * t) * (np.cos(w * t) - decay / w * np.sin(w * t))
    assert found.reference.values[0] == pytest.approx(np.sqrt(np.trapezoid(speed**2, t) / 3.0), rel=1e-8)


@pytest.mark.long
def test_where_the_motion_scatters_errors_are_those_of_means() -> None:
    rig, turn = scripts.make("spline_coupling:chaos"), TURN / 3
    asked = gb.peak("spline.force", after=60 * turn)
    scene = gb.Scene(rig, t_end=100 * turn, quantity=asked, within=0.1)
    found = gb.work_precision(scene, budget=10.0)
    assert found.scattered and found.reference.members >= 8
    choice = found.cheapest()
    assert 4 <= choice.members <= 256
    assert choice.rhs_calls % choice.members == 0
    assert "the mean of peak(spline.force" in found.sentence and f"{choice.members} runs of " in found.sentence
    # other members than the tool's own: the promise is one of 95 % for the sum of what both means are uncertain by
    bench, draw = bench_of(scene), np.random.default_rng(20261124)
    free = np.array([p.start == "" for p in bench.model.program.parameters])
    runs = [
        bench.outcome(choice.effort, 1 + 1e-6 * free * draw.standard_normal(len(free))).values[0] for _ in range(48)
    ]
    assert np.mean(runs) == pytest.approx(found.reference.values[0], rel=0.1)
    assert np.std(runs) > 0.01 * np.mean(runs)  # one run tells less than the mean


@pytest.mark.long
def test_what_cannot_be_answered_is_refused(scene: gb.Scene, found: WorkPrecision) -> None:
    with pytest.raises(gb.ParameterError, match="takes a gb"):
        gb.work_precision(scene.drivetrain)  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match="budget = 0"):
        gb.work_precision(scene, budget=0)
    with pytest.raises(gb.UnknownNameError, match="the scene asks for"):
        found.cheapest(quantity="peak(spline.force)")
    with pytest.raises(gb.ParameterError, match="no run is within 1e-14 of peak"):
        found.cheapest(1e-14)


@pytest.mark.long
def test_all_runs_are_written_and_drawn(found: WorkPrecision, tmp_path: Path) -> None:
    with found.to_csv(tmp_path / "cost.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(found.points)
    assert [int(row["rhs_calls"]) for row in rows] == [p.stats.rhs_calls for p in found.points]
    assert float(rows[0]["error of energy_lost(spline)"]) == found.points[0].errors[1]
    found.plot(tmp_path / "cost.png")
    assert (tmp_path / "cost.png").stat().st_size > 10_000
    assert "<table" in found._repr_html_() and repr(found).startswith("<WorkPrecision of spline coupling, set S: ")
