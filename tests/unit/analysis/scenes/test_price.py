"""What effects cost and change: every row against direct runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.scenes.price import MOST
from gearblocks.analysis.scenes.price_result import GAIN
from gearblocks.analysis.scenes.trials import Verdict


def _direct(scene: gb.Scene, effects: frozenset[str]) -> list[float]:
    """The quantities of a run without these effects, made by hand."""
    rig = scene.drivetrain
    lean = rig.without(*effects) if effects else rig
    initial = gb.carried_start(rig, lean, initial=scene.initial)
    run = gb.simulate(lean, t_end=scene.end, rtol=1e-10, initial=initial)
    return [m.of(run) if isinstance(m, gb.Quantity) else m(run) for m in scene.measures]


def test_changes_are_those_of_direct_runs(discs_scene: gb.Scene, discs_price: Any) -> None:
    full = np.array(_direct(discs_scene, frozenset()))
    rows = [row for row in discs_price.rows if row.judgement.verdict is not Verdict.no_influence]
    assert len(rows) >= 5
    for row in rows:
        changes = np.array(_direct(discs_scene, row.effects)) / full - 1
        # 1e-9: what the tolerance of the direct runs leaves
        assert (np.abs(row.judgement.changes - changes) <= row.judgement.errors + 1e-9).all(), row.name
        within = discs_scene.within
        expected = Verdict.needed if (np.abs(changes) > within).any() else Verdict.not_needed
        assert row.judgement.verdict is expected, row.name


def test_states_switches_and_right_hand_sides_are_those_of_the_train_without(
    discs_scene: gb.Scene, discs_price: Any
) -> None:
    rig, row = discs_scene.drivetrain, discs_price["bearing.windage"]
    full, lean = gb.build(rig), gb.build(rig.without("bearing.windage"))
    assert row.states == len(full.program.states) - len(lean.program.states)
    assert row.switches == len(full.program.switches) - len(lean.program.switches) == 1
    assert row.stats.rhs_calls == gb.simulate(lean, t_end=discs_scene.end, t_start=0.0).stats.rhs_calls


def test_what_cannot_influence_is_free_without_a_run(discs_scene: gb.Scene, discs_price: Any) -> None:
    for name in ("belt.compliance", "belt.damping"):
        row = discs_price[name]
        assert row.judgement.verdict is Verdict.no_influence and row.stats is None
        assert _direct(discs_scene, row.effects) == pytest.approx(_direct(discs_scene, frozenset()), rel=1e-8)
    ran = [row for row in discs_price.rows if row.stats is not None]
    assert discs_price.trains == 1 + len({row.effects for row in ran})
    assert "without influence: belt.compliance" in discs_price.sentence


def test_ctrl_c_keeps_the_rows_that_are_done(discs_scene: gb.Scene, discs_price: Any) -> None:
    def tell(done: int, total: int) -> None:
        if done >= 2:
            raise KeyboardInterrupt

    stopped = gb.price(discs_scene, progress=tell)
    ran = {row.name for row in stopped.rows if row.stats is not None}
    assert not stopped.complete and discs_price.complete
    assert len(ran) >= 2 and ran.isdisjoint(stopped.untried)
    assert ran | set(stopped.untried) == {
        row.name for row in discs_price.rows if row.stats is not None and not row.together
    }
    for row in stopped.rows:
        assert row.judgement.verdict is discs_price[row.name].judgement.verdict
        np.testing.assert_array_equal(row.judgement.changes, discs_price[row.name].judgement.changes)
    assert "stopped before the end" in stopped.sentence and repr(stopped).endswith(", stopped>")
    with pytest.raises(KeyboardInterrupt):
        gb.fit(discs_scene, progress=tell)


def test_an_unknown_row_is_named(discs_price: Any) -> None:
    with pytest.raises(gb.UnknownNameError, match=r"no row 'bearing\.windag'.*did you mean 'bearing\.windage'"):
        discs_price["bearing.windag"]


@pytest.mark.long
def test_a_gap_that_never_opens_is_not_needed_and_gains_nothing() -> None:
    rig = gb.Drivetrain("pressed")
    disc, wall = rig.add("disc", gb.Inertia(J=0.1)), rig.add("wall", gb.Fixed())
    drive = rig.add("drive", gb.Torque(tau=-5.0 + gb.sin(9 * gb.time)))
    rig.chain(drive, disc, rig.add("lash", gb.Lash(k=100.0, half_gap=0.02, c=0.5)), wall)
    asked = gb.std("lash.torque", after=0.5)
    price = gb.price(gb.Scene(rig, t_end=2.0, quantity=asked, within=0.01, initial="static"))
    row = price["lash.backlash"]
    assert row.judgement.verdict is Verdict.not_needed and abs(row.judgement.changes[0]) < 1e-6
    # steps are relative to the largest angles, which the gap widens
    assert row.stats is not None
    assert row.stats.rhs_calls == pytest.approx(price.whole.stats.rhs_calls, rel=0.2)
    gain = price.share(row)
    assert ("saves nothing" if gain <= GAIN else f"saves {100 * gain:.0f} %") in price.sentence


@pytest.mark.long
def test_effects_of_users_blocks_that_cancel_go_together(pushed: Callable[..., gb.Drivetrain]) -> None:
    scene = gb.Scene(pushed(), t_end=1.0, quantity=gb.last("disc.w"), within=0.01)
    price = gb.price(scene)
    # the speed is proportional to the torque: 2.0 N m with both, 1.5 and 2.5 without one
    assert price["left.bias"].judgement.changes == pytest.approx([-0.25], abs=1e-6)
    assert price["right.bias"].judgement.changes == pytest.approx([+0.25], abs=1e-6)
    pair = price["left.bias + right.bias"]
    assert pair.judgement.verdict is Verdict.not_needed and abs(pair.judgement.changes[0]) < 1e-6
    assert "together not needed: left.bias + right.bias" in price.sentence
    assert set(gb.fit(scene).dropped) >= {"left.bias", "right.bias"}


@pytest.mark.long
def test_what_matters_only_beside_another_is_found() -> None:
    rig = gb.Drivetrain("held twice")
    disc = rig.add("disc", gb.Inertia(J=0.1, phi0=1.0))
    rig.chain(rig.add("weight", gb.Torque(tau=1.0)), disc)
    for side in ("near", "far"):
        rig.connect(rig.add(side, gb.BearingFriction(coulomb=2.0, viscous=1e-3)).a, disc.b)
    price = gb.price(gb.Scene(rig, t_end=0.2, quantity=gb.last("disc.phi"), within=0.01))
    alone = {row.name for row in price.rows if row.judgement.verdict is Verdict.not_needed}
    assert {"near.coulomb", "far.coulomb"} <= alone
    found = [row for row in price.rows if row.together and row.judgement.verdict is Verdict.needed]
    smallest = min(found, key=lambda row: len(row.effects))
    assert smallest.effects >= {"near.coulomb", "far.coulomb"}
    assert smallest.judgement.changes[0] == pytest.approx(0.2, rel=0.02)  # t^2 tau/(2 J), some drag
    assert f"together needed: {smallest.name}" in price.sentence


@pytest.mark.long
def test_alike_parts_are_one_row_and_a_quantity_that_goes_is_said() -> None:
    rig = gb.Drivetrain("chain")
    parts: list[Any] = [rig.add("drive", gb.Torque(tau=gb.sin(30 * gb.time)))]
    for i in (1, 2, 3):
        parts += [rig.add(f"disc{i}", gb.Inertia(J=0.02)), rig.add(f"shaft{i}", gb.Shaft(k=100.0 * i, c=0.05))]
    rig.chain(*parts, rig.add("wall", gb.Fixed()))
    asked = (gb.peak("shaft1.loss_power"), gb.peak("shaft3.torque"))
    price = gb.price(gb.Scene(rig, t_end=0.3, quantity=asked, within=0.05))
    assert {row.name for row in price.rows} >= {"shaft*.damping", "shaft*.compliance"}
    assert not any(row.name.startswith("shaft1") for row in price.rows)
    row = price["shaft*.damping"]
    assert row.effects == {"shaft1.damping", "shaft2.damping", "shaft3.damping"}
    assert row.judgement.verdict is Verdict.no_quantity and "shaft1.loss_power" in row.message
    assert row.stats is None and math.isnan(price.share(row))
    assert "part of the quantity: shaft*.compliance" in price.sentence


@pytest.mark.long
def test_an_event_that_there_is_only_with_an_effect_is_needed_and_can_be_said() -> None:
    rig = gb.Drivetrain("loose")
    disc, wall = rig.add("disc", gb.Inertia(J=0.1)), rig.add("wall", gb.Fixed())
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), disc, rig.add("lash", gb.Lash(k=100.0, half_gap=0.02)), wall)
    price = gb.price(gb.Scene(rig, t_end=0.5, quantity=gb.event_time("lash"), within=0.05))
    row = price["lash.backlash"]
    assert row.judgement.verdict in (Verdict.needed, Verdict.no_quantity)
    assert "lash.backlash" in str(price)


@pytest.mark.long
def test_a_train_that_does_not_run_without_is_said_with_its_reason() -> None:
    rig = gb.Drivetrain("two speeds")
    rig.chain(
        rig.add("left", gb.Speed(w=5.0)), rig.add("shaft", gb.Shaft(k=10.0, c=1.0)), rig.add("right", gb.Speed(w=6.0))
    )
    price = gb.price(gb.Scene(rig, t_end=0.1, quantity=gb.last("shaft.torque"), within=0.05))
    row = price["shaft.compliance"]
    assert row.judgement.verdict is Verdict.no_run and row.message
    assert row.stats is None and math.isnan(price.share(row))
    assert "not to be taken away: shaft.compliance" in price.sentence and row.message in str(price)


def test_mistakes_are_named(discs: Callable[..., gb.Drivetrain]) -> None:
    rig, peak = discs(), gb.peak("shaft.torque")
    for call in (gb.price, gb.fit):
        with pytest.raises(gb.ParameterError, match=r"takes a gb\.Scene, not 3"):
            call(3)  # type: ignore[arg-type]
        with pytest.raises(gb.ParameterError, match=r"progres.*did you mean 'progress'"):
            call(gb.Scene(rig, t_end=0.1, quantity=peak), progres=None)  # type: ignore[call-arg]
        with pytest.raises(gb.UnknownNameError, match=r"shaft\.torqe"):
            call(gb.Scene(rig, t_end=0.1, quantity=gb.peak("shaft.torqe")))
    with pytest.raises(gb.ParameterError, match="within = 2"):
        gb.Scene(rig, t_end=0.1, quantity=peak, within=2)
    with pytest.raises(gb.ParameterError, match="not of 3"):
        gb.Scene(3, t_end=0.1, quantity=peak)  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match="many numbers"):
        gb.Scene(rig, t_end=0.1, quantity=gb.points("shaft.torque"))

    def sloppy(run: gb.Trajectory) -> float:
        return run["shaft.torque"]  # type: ignore[return-value]

    with pytest.raises(gb.ParameterError, match=r"'sloppy' raises TypeError.*answer a number"):
        gb.price(gb.Scene(rig, t_end=0.1, quantity=sloppy))


def test_a_scene_that_cannot_go_on_raises_what_its_run_raises() -> None:
    rig = gb.Drivetrain("escape")
    tau = gb.sense("disc.w") ** 2
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), rig.add("disc", gb.Inertia(J=1.0, w0=10.0)))
    with pytest.raises(gb.SimulationError):
        gb.price(gb.Scene(rig, t_end=1.0, quantity=gb.last("disc.w")))


@pytest.mark.long
def test_a_train_of_many_effects_takes_forty_trains_and_says_what_was_not_tried() -> None:
    rig = gb.Drivetrain("many")
    names = [f"{a}{b}" for a in "abcde" for b in "vwxyz"]
    parts: list[Any] = [rig.add("drive", gb.Torque(tau=1.0))]
    for name in names:
        parts += [rig.add(f"{name}_disc", gb.Inertia(J=0.1)), rig.add(name, gb.Shaft(k=50.0, c=0.1))]
    rig.chain(*parts, rig.add("wall", gb.Fixed()))
    found = gb.fit(gb.Scene(rig, t_end=0.01, quantity=gb.last("av_disc.w"), within=0.01))
    assert found.trains <= MOST
    told = {row.name for row in found.price.rows} | set(found.price.untried)
    assert told >= set(rig.effects())
    assert found.price.untried and found.price.untried[0] in found.price.sentence
