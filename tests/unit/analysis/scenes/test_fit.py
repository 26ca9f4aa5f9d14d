"""What a scene calls for: the fitted train against the whole one, by direct runs, and what is left of what went."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from fmu_export import export
from gearblocks.analysis.scenes.fit import fitted
from gearblocks.analysis.scenes.price import MOST, priced
from gearblocks.analysis.scenes.trials import Trials


@pytest.fixture(scope="module")
def best(discs_scene: gb.Scene) -> Any:
    return gb.fit(discs_scene)


def _values(scene: gb.Scene, rig: gb.Drivetrain, **how: Any) -> np.ndarray[Any, Any]:
    initial = gb.carried_start(scene.drivetrain, rig, initial=scene.initial)
    run = gb.simulate(rig, t_end=scene.end, initial=initial, **how)
    return np.array([m.of(run) for m in scene.measures])  # type: ignore[union-attr]


@pytest.mark.long
def test_the_fitted_train_run_as_it_says_is_within_the_accuracy(discs_scene: gb.Scene, best: Any) -> None:
    full = _values(discs_scene, discs_scene.drivetrain, rtol=1e-10)
    how: dict[str, Any] = {"method": best.method, "rtol": best.rtol, "step": best.step, "locate": best.locate}
    assert (np.abs(_values(discs_scene, best.drivetrain, **how) / full - 1) <= discs_scene.within).all()
    change = _values(discs_scene, best.drivetrain, rtol=1e-10) / full - 1
    assert (np.abs(best.judgement.changes - change) <= best.judgement.errors + 1e-9).all()  # 1e-9: of the direct runs


@pytest.mark.long
def test_what_goes_is_what_may_go_and_what_cannot_influence(best: Any) -> None:
    assert set(best.dropped) == {"bearing.windage", "belt.compliance", "belt.damping"}
    assert set(best.drivetrain.effects()) == {"shaft.compliance", "shaft.damping", "bearing.viscous"}
    for name in best.dropped:
        assert name in best.sentence
    assert best.trains <= MOST


@pytest.mark.long
def test_where_it_holds_is_what_direct_runs_say(discs_scene: gb.Scene, best: Any) -> None:
    around = {one.words: one for one in best.around}
    assert set(around) == {"load -10 %", "load +10 %", "speed -10 %", "speed +10 %"}
    for share in (0.9, 1.1):
        words = f"load {100 * (share - 1):+.0f} %"
        more = {"drive": 5.0 * share}  # the Parameter scales, the sine that has no name beside it does not
        runs = [
            gb.simulate(rig, t_end=discs_scene.end, rtol=1e-10, parameters=more)
            for rig in (discs_scene.drivetrain, best.drivetrain)
        ]
        full, lean = (np.array([m.of(run) for m in discs_scene.measures]) for run in runs)  # type: ignore[union-attr]
        assert around[words].judgement.changes == pytest.approx(lean / full - 1, abs=1e-6)
        assert around[words].holds


@pytest.mark.long
def test_no_name_of_what_went_is_left_in_equations_and_c(best: Any) -> None:
    full = best.scene.drivetrain
    text, source = str(full.equations()), gb.build(full).program.source
    left, source_left = str(best.drivetrain.equations()), gb.build(best.drivetrain).program.source
    lost = {"bearing.windage", "belt.k", "belt.c"}
    paths = {p.path for p in gb.build(full).program.parameters}
    assert any(path.startswith(tuple(lost)) for path in paths)
    assert not any(p.path.startswith(tuple(lost)) for p in gb.build(best.drivetrain).program.parameters)
    for words in ("windage",):
        assert words in source and words not in source_left
        assert words in text and words not in left
    full_program, program = gb.build(full).program, gb.build(best.drivetrain).program
    assert len(program.states) < len(full_program.states)
    assert len(program.switches) < len(full_program.switches)


@pytest.mark.long
def test_no_name_of_what_went_is_left_in_the_fmu(best: Any, tmp_path: Path) -> None:
    def words(rig: gb.Drivetrain, name: str) -> str:
        export(rig, tmp_path / name)
        with zipfile.ZipFile(tmp_path / name) as packed:
            texts = [n for n in packed.namelist() if n.endswith((".xml", ".c", ".h", ".html", ".svg"))]
            return "\n".join(packed.read(n).decode() for n in texts)

    full, lean = words(best.scene.drivetrain, "full.fmu"), words(best.drivetrain, "lean.fmu")
    for name in ("windage", "belt.k", "belt.c"):
        assert name in full and name not in lean


@pytest.mark.long
def test_a_fit_starts_where_the_whole_train_starts(discs: Callable[..., gb.Drivetrain]) -> None:
    # the start value of an angle that goes with the belt's compliance; the method is chosen on the fitted train
    scene = gb.Scene(
        discs(), t_end=0.1, quantity=gb.last("load.w"), within=0.02, initial={"load.w": 30.0, "blades.w": 25.0},
        parameters={"belt.k": 800.0, "drive": 4.0},
    )  # fmt: skip
    found = gb.fit(scene)
    assert "belt.compliance" in found.dropped
    initial = gb.carried_start(scene.drivetrain, found.drivetrain, initial=scene.initial, parameters=scene.parameters)
    full = gb.simulate(scene.drivetrain, t_end=0.1, rtol=1e-10, initial=scene.initial, parameters=scene.parameters)
    how: dict[str, Any] = {"method": found.method, "rtol": found.rtol, "step": found.step, "locate": found.locate}
    lean = gb.simulate(found.drivetrain, t_end=0.1, initial=initial, parameters={"drive": 4.0}, **how)
    assert lean["load.w"][-1] == pytest.approx(full["load.w"][-1], rel=0.02)


def test_nothing_goes_where_everything_is_needed(pushed: Callable[..., gb.Drivetrain]) -> None:
    found = gb.fit(gb.Scene(pushed(0.5, -0.2), t_end=1.0, quantity=gb.last("disc.w"), within=0.01))
    assert not found.dropped and found.drivetrain.effects() and "nothing is to be left out" in found.sentence
    assert not found.around


def test_where_it_does_not_hold_is_said(pushed: Callable[..., gb.Drivetrain]) -> None:
    # 0.9 % of the torque goes; with a load 10 % lower that is 1.0 %, with effects that stay where they are
    found = gb.fit(gb.Scene(pushed(0.5, -0.481), t_end=1.0, quantity=gb.last("disc.w"), within=0.00945))
    judged = {one.words: one.judgement.changes[0] for one in found.around or found.spoilt}
    assert judged["load -10 %"] == pytest.approx(-0.019 / 1.819, abs=1e-5)
    assert judged["load +10 %"] == pytest.approx(-0.019 / 2.219, abs=1e-5)
    said = found.sentence
    assert "load -10 %: -1.04 %" in said and "load +10 %: " not in said
    assert "stops holding at load -10 %" in said or "does not hold around the scene (load -10 %" in said


def test_what_there_is_not_to_vary_is_said(pushed: Callable[..., gb.Drivetrain]) -> None:
    found = gb.fit(gb.Scene(pushed(1e-4, -1e-4), t_end=0.1, quantity=gb.last("disc.w"), within=0.01))
    assert found.dropped and {one.words for one in found.around} == {"load -10 %", "load +10 %"}
    assert found.sentence.endswith("it holds at load -10 %, load +10 %; the train has no speed to vary.")


@pytest.mark.long
def test_a_scene_that_scatters_is_told_to_be_a_mean(hammer: Callable[..., gb.Drivetrain]) -> None:
    rig = hammer()
    rig.connect(rig.add("seal", gb.BearingFriction(viscous=1e-12)).a, rig["disc"].b)
    scene = gb.Scene(rig, t_end=150, quantity=gb.rms("lash.torque", after=50), within=0.2)
    trials = Trials(scene)
    found = fitted(trials, priced(trials))
    assert "means over runs: its motion scatters" in found.sentence


def test_what_a_scene_tells_has_its_units(discs_scene: gb.Scene, best: Any) -> None:
    units = [gb.build(discs_scene.drivetrain).program.output_units[m.output] for m in discs_scene.measures]
    assert list(discs_scene.units) == units and all(units)
    states = len(gb.build(best.drivetrain).program.states)
    assert f"; {states} state" in best.evidence
    for line, unit in zip(best.evidence.splitlines(), units, strict=False):
        assert f" {unit} with everything, " in line and f" {unit} fitted (" in line
    rows = best.price.table()[1]
    assert [rows[0][1 + i].endswith(f" {unit}") for i, unit in enumerate(units)] == [True] * len(units)
    assert not any(cell == "-0" for row in rows for cell in row)
    twice = gb.Scene(discs_scene.drivetrain, t_end=0.01, quantity=(lambda run: run["motor.w"][-1], gb.count("bearing")))
    assert twice.units == ("", "")
