"""The shipped scenes: what accuracy costs in each is what direct runs say, also for a window twice as long."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.scenes.bench import Effort, bench_of
from gearblocks.analysis.scenes.reference import mean_of
from gearblocks.cli import scripts

SCENES = {
    "spline_coupling:period_5": 1, "spline_coupling:chaos": 1, "planetary_backlash:settled": 2,
    "noncircular_cvt:changing_over": 2, "two_speed_shift:shift": 2, "gear_pair:rattle": 1, "gear_pair:whine": 1,
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_every_shipped_scene_is_found_by_its_name(name: str) -> None:
    scene = scripts.scene(name)
    assert len(scene.names) == SCENES[name] and scene.within in (0.01, 0.05)
    file, _, function = name.partition(":")
    kinds = {maker.name: maker.kind for maker in scripts.makers(scripts.locate(file)[0])}
    assert kinds[function] == "scene" and kinds["build"] == "train"


@pytest.mark.long
def test_the_shift_answers_with_the_heat_and_the_torque_that_are_known() -> None:
    scene = scripts.scene("two_speed_shift:shift")
    found = bench_of(scene).outcome(Effort())
    assert found.values == pytest.approx([5697.1, 977.1], abs=0.1)  # as they were found elsewhere, with so many digits


@pytest.mark.long
@pytest.mark.parametrize("name", SCENES)
def test_what_accuracy_costs_is_what_direct_runs_say(name: str) -> None:
    scene = scripts.scene(name)
    found = gb.work_precision(scene, budget=60.0)
    choice = found.cheapest()
    bench = bench_of(scene)
    assert bench.timed(choice.effort, 1).rhs_calls == pytest.approx(choice.rhs_calls / choice.members, rel=1e-12)
    members = found.reference.enough
    again = bench.outcome(choice.effort) if members == 1 else mean_of(bench, choice.effort, members)
    off = np.abs(again.values - found.reference.values) / np.abs(found.reference.values)
    assert off.tolist() == choice.errors.tolist() and (off <= scene.within).all()
    for times in (2, 3):
        for offered in found.offered():  # of every method, at its loosest tolerance
            within = float((offered.errors + offered.noise).max())
            if within <= scene.within:
                longer = found.cheapest(within, t_end=scene.begin + times * (scene.end - scene.begin))
                measured = bench.lengthened(times).timed(longer.effort, 1).rhs_calls
                assert measured / 1.5 < longer.rhs_calls / longer.members < 1.5 * measured
    assert found.sentence.count(" costs ") >= len(scene.names)
