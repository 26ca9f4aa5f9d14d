"""Judgements: never by chance, never wider than what was run."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.scenes.bench import Effort
from gearblocks.analysis.scenes.scatter import Estimate
from gearblocks.analysis.scenes.trials import Judgement, Trials, Verdict, relative_cost
from gearblocks.simulation.records import Stats


@pytest.fixture
def trials(pushed: Callable[..., gb.Drivetrain]) -> Trials:
    return Trials(gb.Scene(pushed(), t_end=0.1, quantity=gb.last("disc.w"), within=0.01))


def _estimate(members: list[float], values: float | None = None, error: float = 0.0) -> Estimate:
    table = np.array(members)[:, None]
    value = np.array([table.mean() if values is None else values])
    size = np.array([3.18 * table.std(ddof=1) / 2 if len(members) > 1 else error])
    return Estimate(value, size, table, Effort(), Stats(), 2)


@pytest.mark.parametrize(
    ("whole", "without", "expected"),
    [
        (_estimate([0.9, 1.1, 0.95, 1.05]), _estimate([1.2, 0.8, 1.1, 0.9]), Verdict.undecided),  # equal by chance
        (_estimate([1.0, 1.0001, 1.0, 1.0001]), _estimate([1.0, 1.0001, 1.0, 1.0]), Verdict.not_needed),
        (_estimate([1.0, 1.0001, 1.0, 1.0001]), _estimate([1.1, 1.1001, 1.1, 1.1]), Verdict.needed),
        (_estimate([], 1.0, 0.002), _estimate([], 1.004, 0.002), Verdict.not_needed),
        (_estimate([], 1.0, 0.002), _estimate([], 1.009, 0.002), Verdict.undecided),
        (_estimate([], 1.0, 0.002), _estimate([], 1.02, 0.002), Verdict.needed),
        (_estimate([], 1.0), _estimate([1.002, 0.998, 1.001, 1.0]), Verdict.not_needed),
        (_estimate([], 1.0), _estimate([1.0, 1.02, 0.985, 1.0]), Verdict.needed),  # one run answered, now none does
        (_estimate([], 0.0), _estimate([], 0.0), Verdict.not_needed),
        (_estimate([], 0.0), _estimate([], 3.0), Verdict.needed),
        (_estimate([], np.nan), _estimate([], np.nan), Verdict.not_needed),  # an event that neither has
        (_estimate([], 1.0), _estimate([], np.nan), Verdict.needed),
        (_estimate([1.0, np.nan, 1.0, 1.0]), _estimate([1.0, np.nan, 1.0, 1.0]), Verdict.undecided),
        (_estimate([1.0, 1.1, 1.0, 1.0]), _estimate([1.0, np.nan, 1.0, 1.0]), Verdict.undecided),
    ],
)
def test_verdicts(trials: Trials, whole: Estimate, without: Estimate, expected: Verdict) -> None:
    trial = trials.trial(["left.bias"])
    trials.whole.estimates[1], trial.estimates[1] = whole, without
    judgement = trials.judged(trial, patience=False)
    assert judgement.verdict is expected
    assert isinstance(judgement.worst(["last(disc.w)"]), str)


def test_of_several_quantities_it_is_said_which_one_changes() -> None:
    names = ("peak(shaft.torque, after=0.1)", "last(disc.w)")

    def words(changes: tuple[float, float], *verdicts: Verdict) -> str:
        return Judgement(np.array(changes), np.array([0.0, 0.0]), verdicts).worst(names)

    assert words((0.002, -0.03), Verdict.needed, Verdict.needed) == "-3 % of last(disc.w)"
    assert words((0.002, -0.03), Verdict.not_needed, Verdict.needed) == "-3 % of last(disc.w) alone"
    assert words((-0.04, 0.0), Verdict.needed, Verdict.not_needed) == f"-4 % of {names[0]} alone"
    assert words((np.inf, 0.0), Verdict.needed, Verdict.not_needed) == f"{names[0]} from 0 alone"
    assert Judgement(np.array([0.02]), np.zeros(1), (Verdict.needed,)).worst(names[:1]) == "+2 %"


class _Busy:
    """A bench on a machine that becomes slower with every run that is timed; seconds: of a run while it is idle."""

    runs = 0

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds

    def timed(self, effort: Effort, repeats: int) -> Stats:
        _Busy.runs += 1
        return Stats(rhs_calls=100, cpu_seconds=self.seconds * (1 + 0.03 * _Busy.runs))


def test_times_that_are_compared_are_taken_in_turns(trials: Trials) -> None:
    lean = trials.trial(["left.bias"])
    trials.whole.stats, lean.stats = Stats(cpu_seconds=4e-3), Stats(cpu_seconds=4e-3)  # as they were on a busy machine
    trials.whole.bench, lean.bench = _Busy(2e-3), _Busy(1e-3)  # type: ignore[assignment]
    whole = trials.take_turns([lean])
    assert lean.stats.cpu_seconds / whole.cpu_seconds == pytest.approx(0.5, rel=0.05)
    assert lean.beside == whole.cpu_seconds and _Busy.runs == 18


def test_time_is_believed_where_it_says_something_quite_different_from_counted_work() -> None:
    # modes of lossy gears beside friction took two thirds of the time of a launch; no counter sees them
    assert relative_cost(1.4, 6.3e-3, 18e-3) == pytest.approx(0.35)
    assert relative_cost(0.9, 8e-3, 10e-3) == 0.9 and relative_cost(0.9, 13e-3, 10e-3) == 0.9  # timings scatter
    assert relative_cost(0.9, 1e-3, np.nan) == 0.9
    assert relative_cost(0.5, 1e-4, 1e-4) == 0.5  # short runs take what it takes to begin


@pytest.mark.long
def test_a_change_of_nothing_is_never_needed_in_a_chaotic_motion(hammer: Callable[..., gb.Drivetrain]) -> None:
    # a seal without any drag to speak of: two runs, with and without, differ by tens of percent all the same
    rig = hammer(0.53)
    rig.connect(rig.add("seal", gb.BearingFriction(viscous=1e-12)).a, rig["disc"].b)
    asked = (gb.rms("lash.torque", after=50), gb.peak("lash.torque", after=100))
    trials = Trials(gb.Scene(rig, t_end=150, quantity=asked, within=0.01))
    found = trials.judged(trials.trial(["seal.viscous"]))
    assert found.members > 16 and (np.abs(found.changes) <= found.errors).all()
    assert Verdict.needed not in found.verdicts


def test_what_matters_is_needed_in_a_chaotic_motion(hammer_scene: gb.Scene) -> None:
    trials = Trials(hammer_scene)
    found = trials.judged(trials.trial(["lash.backlash"]))
    assert found.members >= 4 and found.verdicts[0] is Verdict.needed


def test_of_all_quantities_together() -> None:
    nothing = np.zeros(2)
    for verdicts, expected in (
        ((Verdict.no_influence, Verdict.no_influence), Verdict.no_influence),
        ((Verdict.no_influence, Verdict.not_needed), Verdict.not_needed),
        ((Verdict.not_needed, Verdict.undecided), Verdict.undecided),
        ((Verdict.needed, Verdict.undecided), Verdict.needed),
    ):
        assert Judgement(nothing, nothing, verdicts).verdict is expected


def test_each_set_is_built_once_with_what_rests_on_it(discs_scene: gb.Scene) -> None:
    trials = Trials(discs_scene)
    one, other = trials.all([["shaft.compliance"], ["shaft.compliance", "shaft.damping"]])
    assert one is other and one.effects == {"shaft.compliance", "shaft.damping"}
    assert trials.count == 2 and trials.trial(one.effects) is one and trials.count == 2


def test_counters_are_those_of_the_tolerance_of_all_though_one_needs_a_finer_one(discs_scene: gb.Scene) -> None:
    trials = Trials(discs_scene.changed(within=1e-7), Effort("dp5", 1e-3))
    assert trials.whole.estimates[1].effort.rtol < 1e-3
    run = gb.simulate(discs_scene.drivetrain, t_end=discs_scene.end, method="dp5", rtol=1e-3)
    assert trials.whole.stats.rhs_calls == run.stats.rhs_calls


@pytest.mark.parametrize("turns", [0, 2])
def test_counters_are_those_of_a_run_without_its_quantities(
    discs_scene: gb.Scene, turns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gearblocks.analysis.scenes.trials._MOST_TURNS", turns)
    scene = discs_scene.changed(quantity=(gb.rms("shaft.torque", after=0.1), gb.at("load.w", 0.0123)))
    run = gb.simulate(scene.drivetrain, t_end=scene.end)
    assert Trials(scene).take_turns([]).rhs_calls == run.stats.rhs_calls
