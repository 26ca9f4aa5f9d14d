"""What limited the steps of a run, by component and by count."""

import pickle
from collections import Counter

import numpy as np
import pytest

import gearblocks as gb


def _rattling(seed: int) -> tuple[gb.Drivetrain, str]:
    """A chain of shafts with one coupling that has play and rattles; its name."""
    random = np.random.default_rng(seed)
    count, rig = int(random.integers(3, 7)), gb.Drivetrain("rattling")
    loose = int(random.integers(count))
    parts = [rig.add("motor", gb.Inertia(J=0.02))]
    for i in range(count):
        soft = gb.Shaft(k=float(random.uniform(1e3, 3e3)), c=0.2)
        play = gb.Lash(k=2e3, half_gap=1e-3, c=0.2)
        parts.append(rig.add(f"part_{i}", play if i == loose else soft))
        parts.append(rig.add(f"disc_{i}", gb.Inertia(J=float(random.uniform(0.01, 0.03)))))
    rig.chain(rig.add("drive", gb.Torque(tau=5 * gb.sin(25 * gb.time))), *parts)
    return rig, f"part_{loose}"


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.few(1)
def test_the_coupling_that_rattles_is_named_with_its_events(seed: int) -> None:
    rig, loose = _rattling(seed)
    run = gb.simulate(rig, t_end=1.0)
    said = run.explain()
    assert said.switching == loose
    (row,) = [x for x in said.rows if x.events]
    assert row.events == len(run.events) > 20


@pytest.mark.parametrize("method", ["auto", "dp5", "rodas"])
@pytest.mark.few(1)
def test_steps_and_refused_trials_are_those_of_the_run(method: str) -> None:
    rig, _ = _rattling(3)
    run = gb.simulate(rig, t_end=0.5, method=method, rtol=1e-5)
    said = run.explain()
    assert (said.steps, said.rejected) == (run.stats.steps, run.stats.rejected)
    assert sum(x.events for x in said.rows) == len(run.events)


def test_samples_and_inputs_change_nothing() -> None:
    rig = gb.Drivetrain("driven")
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau", unit="N m")))
    rig.chain(
        drive, rig.add("disc", gb.Inertia(J=0.1)), rig.add("shaft", gb.Shaft(k=100.0)), rig.add("wall", gb.Fixed())
    )
    table = gb.Table(np.linspace(0.0, 1.0, 101), np.sin(np.arange(101.0)))
    by_steps = gb.simulate(rig, t_end=1.0, inputs={"tau": table})
    by_samples = gb.simulate(rig, t=[0.0, 0.3, 1.0], inputs={"tau": table})
    assert by_steps.explain() == by_samples.explain()
    times = next(x for x in by_steps.explain().rows if x.cause == "time")
    assert times.steps >= 100  # one at each joint of the table
    assert any("tables" in words for words in by_steps.explain().remedies)


@pytest.mark.long
def test_a_chattering_brake_is_named_among_others() -> None:
    rig = gb.Drivetrain("brakes")
    parts = [rig.add("motor", gb.Inertia(J=0.1, w0=5.0))]
    for i in range(3):
        parts += [rig.add(f"shaft_{i}", gb.Shaft(k=500.0, c=0.1)), rig.add(f"disc_{i}", gb.Inertia(J=0.05, w0=5.0))]
        capacity = 1.0 if i != 1 else 30 * (1 + gb.sin(400 * gb.time))
        rig.connect(rig.add(f"brake_{i}", gb.Brake(capacity=capacity)).a, parts[-1].a)
    rig.chain(rig.add("drive", gb.Torque(tau=15 * gb.sin(12 * gb.time))), *parts)
    run = gb.simulate(rig, t_end=1.0)
    found = Counter(event.component.split(".")[0] for event in run.events)
    assert run.explain().switching == found.most_common(1)[0][0] == "brake_1"


@pytest.mark.long
def test_the_largest_step_allowed_is_named_where_it_limits() -> None:
    rig, _ = _rattling(0)
    free = rig.without("*.backlash")
    said = gb.simulate(free, t_end=0.5, max_step=2e-4, watch=False).explain()
    assert said.rows[0].cause == "most"
    assert any("max_step" in words for words in said.remedies)


def test_a_strong_damper_is_too_fast_for_an_explicit_method() -> None:
    rig = gb.Drivetrain("damped")
    small, large = rig.add("small", gb.Inertia(J=1e-4)), rig.add("large", gb.Inertia(J=1.0, w0=1.0))
    spring, damper = rig.add("spring", gb.Shaft(k=10.0)), rig.add("damper", gb.Damper(c=50.0))
    rig.chain(rig.add("wall", gb.Fixed()), spring, large, damper, small)
    said = gb.simulate(rig, t_end=0.2, method="dp8").explain()
    assert said.limiting == "damper"
    assert "method='rodas'" in said.remedies


def test_a_run_that_cannot_be_done_again_says_so() -> None:
    rig, _ = _rattling(0)
    run = pickle.loads(pickle.dumps(gb.simulate(rig, t_end=0.1)))
    with pytest.raises(gb.ParameterError, match="cannot be explained"):
        run.explain()


def test_an_explanation_reads_as_sentences_and_as_a_table() -> None:
    rig, loose = _rattling(1)
    said = gb.simulate(rig, t_end=0.5).explain()
    assert str(said).startswith(f"'rattling' took {said.steps} steps")
    assert f"of the events are of '{loose}'" in str(said)
    assert "What would help" in str(said)
    assert "<table" in said._repr_html_()
    assert loose in repr(said)
