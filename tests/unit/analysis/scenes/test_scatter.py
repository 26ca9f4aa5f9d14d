"""Estimates of a scene: two accuracies of a settled motion, means where it scatters."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.scenes import scatter
from gearblocks.analysis.scenes.bench import Effort, bench_of
from gearblocks.analysis.scenes.scatter import SPREADS, estimate, more_runs, perturbed
from gearblocks.cli import scripts


def test_the_error_of_a_settled_value_covers_a_run_at_a_tight_tolerance(discs_scene: gb.Scene) -> None:
    bench = bench_of(discs_scene)
    found = estimate(bench, discs_scene.within, Effort())
    tight = bench.outcome(Effort("auto", 1e-12)).values
    assert not found.scattered and found.runs == 2
    assert (np.abs(found.values - tight) <= found.errors).all()
    assert (found.errors <= 0.2 * discs_scene.within * np.abs(found.values)).all()


def test_two_tolerances_that_agree_by_chance_are_known_to_the_finer_one(
    discs_scene: gb.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = bench_of(discs_scene)
    same = bench.outcome(Effort())
    monkeypatch.setattr(type(bench), "outcome", lambda *_: same)
    found = estimate(bench, discs_scene.within, Effort())
    assert found.errors == pytest.approx(2e-6 / 30 * np.abs(found.values))


def test_a_tolerance_that_tells_too_little_is_made_finer(discs_scene: gb.Scene) -> None:
    found = estimate(bench_of(discs_scene), 1e-5, Effort("dp5", 1e-2))
    assert found.effort.rtol < 1e-2 and not found.scattered


def test_a_motion_that_scatters_is_a_mean_though_two_runs_agree(hammer_scene: gb.Scene) -> None:
    bench = bench_of(hammer_scene)
    runs = np.array([bench.outcome(Effort(), perturbed(bench, SPREADS, n)).values for n in range(12)])
    spread = runs.std(axis=0, ddof=1) / runs.mean(axis=0)
    apart = np.abs(runs[:, None, 0] - runs[None, :, 0])[np.triu_indices(len(runs), 1)] / runs[:, 0].mean()
    assert apart.min() < 0.1 * hammer_scene.within < spread.min()  # some two of them agree in the rms by chance
    found = estimate(bench, hammer_scene.within, Effort())
    assert found.scattered and len(found.members) >= 4
    assert (found.errors >= 0.3 * spread * np.abs(found.values)).all()


@pytest.mark.long
def test_a_value_that_hangs_on_the_seventh_digit_of_a_parameter_scatters() -> None:
    # the spline without the damping of its input shaft: two tight tolerances agree to 1e-4, 1e-7 of an inertia is 1.5 %
    whole = scripts.scene("spline_coupling:period_5")
    bench = bench_of(whole, whole.drivetrain.without("shaft_in.damping"))
    fine, finer = (bench.outcome(Effort("auto", rtol)).values for rtol in (1e-9, 1e-10))
    assert abs(finer / fine - 1) < 1e-4 and not estimate(bench_of(whole), 0.01, Effort()).scattered
    found = estimate(bench, 0.01, Effort())
    assert found.scattered and found.members.std() > 0.005 * found.values


def test_where_a_train_alike_scatters_it_is_asked_at_no_finer_tolerance(
    hammer_scene: gb.Scene, discs_scene: gb.Scene
) -> None:
    bench = bench_of(hammer_scene)
    slower = estimate(bench, hammer_scene.within, Effort())
    found = estimate(bench, hammer_scene.within, Effort(), slower)
    assert found.scattered and found.runs < slower.runs and len(found.members) == len(slower.members)
    assert (np.abs(found.values - slower.values) <= 2 * (found.errors + slower.errors)).all()
    assert not estimate(bench_of(discs_scene), discs_scene.within, Effort(), slower).scattered


def test_two_runs_are_a_mean_where_those_of_a_train_alike_hardly_scatter(hammer_scene: gb.Scene) -> None:
    bench, within = bench_of(hammer_scene), 20.0  # two runs of a chaotic motion tell little: 12.7 standard errors
    alike = estimate(bench, within, Effort())
    found = estimate(bench, within, Effort(), alike)
    assert len(alike.members) == 4 and len(found.members) == 2 and found.runs == 3
    assert (found.errors / np.abs(found.values) >= alike.errors / np.abs(alike.values)).all()  # also where both agree
    closer = estimate(bench, 0.3 * float(np.max(found.errors / np.abs(found.values))) / 0.05, Effort(), alike)
    assert len(closer.members) == 4


@pytest.mark.long
@pytest.mark.parametrize("runs", [4, pytest.param(16, marks=pytest.mark.long)])
def test_of_20_intervals_17_and_more_cover_the_mean_of_many_runs(
    hammer_scene: gb.Scene, runs: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # each covers it with a probability of 0.95; fewer than 17 of 20: 0.3 %
    bench = bench_of(hammer_scene)
    true = np.mean([bench.outcome(Effort(), perturbed(bench, SPREADS, 100_000 + n)).values for n in range(150)], axis=0)
    covered = np.zeros(2)
    for number in range(20):
        monkeypatch.setattr(scatter, "perturbed", lambda b, size, n, far=2000 * number: perturbed(b, size, far + n))
        found = more_runs(bench, estimate(bench, hammer_scene.within, Effort()), runs)
        assert found.scattered
        covered += np.abs(found.values - true) <= found.errors
    assert (covered >= 17).all(), covered


def test_chaos_that_ends_before_the_window_does_is_seen(hammer: Callable[..., gb.Drivetrain]) -> None:
    # braked from 140 s on, the disc settles at one place, whatever it did before
    rig = hammer(until=gb.Table([0.0, 130.0, 140.0, 300.0], [1.0, 1.0, 0.0, 0.0]))
    scene = gb.Scene(rig, t_end=300, quantity=gb.rms("lash.torque", after=20, before=130), within=0.05)
    assert estimate(bench_of(scene), 0.05, Effort()).scattered


@pytest.mark.parametrize("initial", [None, "static"])
def test_a_train_at_rest_does_not_scatter(initial: Any) -> None:
    rig = gb.Drivetrain("held")
    disc, wall = rig.add("disc", gb.Inertia(J=0.1)), rig.add("wall", gb.Fixed())
    rig.chain(rig.add("weight", gb.Torque(tau=3.0)), disc, rig.add("shaft", gb.Shaft(k=50.0, c=2.0)), wall)
    scene = gb.Scene(rig, t_end=4.0, quantity=gb.last("shaft.torque"), initial=initial)
    found = estimate(bench_of(scene), 0.01, Effort())
    assert not found.scattered and found.values[0] == pytest.approx(3.0, rel=1e-6)


def test_a_count_that_no_tolerance_settles_is_a_mean(hammer: Callable[..., gb.Drivetrain]) -> None:
    scene = gb.Scene(hammer(), t_end=200, quantity=gb.count("lash"), within=0.01)
    found = estimate(bench_of(scene), 0.01, Effort())
    assert found.scattered and found.errors[0] > 0


def test_start_values_structure_and_what_lies_on_its_bound_are_not_perturbed(discs_scene: gb.Scene) -> None:
    bench = bench_of(discs_scene)
    changed = perturbed(bench, 1e-6, 3) != 1.0
    program = bench.model.program
    for parameter, value, moves in zip(program.parameters, bench.parameters, changed, strict=True):
        inside = value not in (parameter.lower, parameter.upper)
        assert moves == (parameter.start == "" and parameter.path not in program.structural_paths and inside)
    assert changed.any()
    assert (perturbed(bench, 1e-6, 3) == perturbed(bench, 1e-6, 3)).all()
    assert (perturbed(bench, 1e-6, 4) != perturbed(bench, 1e-6, 3)).any()


def test_changes_of_parameters_keep_off_their_bounds() -> None:
    rig = gb.Drivetrain("held")
    disc, brake = rig.add("disc", gb.Inertia(J=0.1, w0=1.0)), rig.add("brake", gb.Brake(capacity=1.0))
    rig.chain(disc, brake)
    bench = bench_of(gb.Scene(rig, t_end=0.2, quantity=gb.last("disc.w")))
    numbers = bench.model.program.parameter_numbers
    peak, capacity = numbers["brake.peak"], numbers["brake.capacity"]
    found = np.array([perturbed(bench, SPREADS, number) for number in range(20)])
    assert bench.parameters[peak] == 1.0 and (found[:, peak] >= 1.0).all()  # the peak is never below sliding friction
    assert (found[:, capacity] < 1.0).any() and (found[:, capacity] > 1.0).any()


def test_a_run_that_takes_longer_than_its_patience_is_ended(hammer_scene: gb.Scene) -> None:
    bench = replace(bench_of(hammer_scene), patience=0.0)
    with pytest.raises(gb.SimulationError, match=r"takes more than 0 s of CPU time"):
        bench.outcome(Effort())
