"""Quantities as values: their names, what they refuse, and what they make of stored runs."""

from __future__ import annotations

import pickle
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.quantities import parsed

ALL = (
    gb.peak("shaft.torque"), gb.peak("shaft.torque", after=0.2), gb.trough("shaft.torque", after=0.1, before=0.9),
    gb.rms("load.w"), gb.mean("load.w", after=0.5), gb.std("load.w", after=0.5),
    gb.at("load.w", 0.25), gb.last("motor.w"), gb.count(),
    gb.count("clutch", "state", after=0.1), gb.event_time("clutch", number=-1), gb.energy_lost("clutch"),
    gb.energy_lost("*", after=0.5),
)  # fmt: skip


@pytest.fixture(scope="module")
def run(clutch_model: gb.Model) -> gb.Trajectory:
    return gb.simulate(clutch_model, t_end=1.0, rtol=1e-8)


def test_a_quantity_is_a_frozen_value_with_a_name() -> None:
    assert gb.peak("mesh.force", after=0.2) == gb.peak("mesh.force", after=0.2)
    assert gb.peak("mesh.force").name == "peak(mesh.force)"
    assert gb.trough("mesh.force", after=0.2, before=1).name == "trough(mesh.force, after=0.2, before=1)"
    assert str(gb.at("a.w", 0.5)) == "at(a.w, 0.5)" and gb.last("a.w").name == "last(a.w)"
    assert gb.count("c1", "state").name == "count(c1, kind=state)"
    assert len({q.name for q in ALL}) == len(ALL)
    with pytest.raises(AttributeError):
        gb.peak("a.w").output = "b.w"  # type: ignore[misc]


@pytest.mark.parametrize("quantity", ALL, ids=lambda q: q.name)
def test_what_a_name_writes_can_be_read_again_and_sent(quantity: gb.Quantity) -> None:
    if quantity.name.startswith("count(clutch"):
        assert parsed("count(clutch, state, after=0.1)") == quantity
    else:
        assert parsed(quantity.name) == quantity
    assert pickle.loads(pickle.dumps(quantity)) == quantity


@pytest.mark.parametrize("text", ["mesh.force", "loudness(mesh.force)", "peak()", "peak(a.w, sometime=3)", "at(a.w)"])
def test_text_that_is_no_quantity_is_refused(text: str) -> None:
    with pytest.raises(gb.ParameterError):
        parsed(text)


@pytest.mark.parametrize("quantity", ALL, ids=lambda q: q.name)
def test_values_do_not_depend_on_what_the_run_recorded(clutch_model: gb.Model, quantity: gb.Quantity) -> None:
    runs = [
        gb.simulate(clutch_model, t_end=1.0, rtol=1e-8),
        gb.simulate(clutch_model, t=np.linspace(0.0, 1.0, 7), rtol=1e-8),
        gb.simulate(clutch_model, t_end=1.0, rtol=1e-8, outputs=["motor.w"]),
    ]
    assert len({float(quantity.of(run)).hex() for run in runs}) == 1


@pytest.mark.few(1)
@pytest.mark.parametrize("quantity", ALL[:11], ids=lambda q: q.name)
def test_a_stored_run_shows_the_same_to_the_accuracy_of_its_samples(
    run: gb.Trajectory, clutch_model: gb.Model, quantity: gb.Quantity, tmp_path: Path
) -> None:
    fine = gb.simulate(clutch_model, t_end=1.0, rtol=1e-8, max_step=1e-3)
    fine.save(tmp_path / "run.nc")
    stored = gb.Trajectory.load(tmp_path / "run.nc")
    assert stored.case is None
    assert quantity.of(stored) == pytest.approx(quantity.of(run), rel=2e-7)  # twenty tolerances: two runs are compared


def test_losses_within_a_stored_run_are_not_known(run: gb.Trajectory) -> None:
    stored = pickle.loads(pickle.dumps(run))
    with pytest.raises(gb.ParameterError, match="from begin to end only"):
        gb.energy_lost("clutch", after=0.3).of(stored)


@pytest.mark.parametrize(
    ("quantity", "words"),
    [
        (gb.peak("shaft.torqe"), "no output 'shaft.torqe' - did you mean 'shaft.torque'"),
        (gb.rms("load.w", after=1.0), "after = 1 s must lie in the run before 1 s"),
        (gb.mean("load.w", after=-0.1), "the run goes from 0 to 1 s"),
        (gb.peak("load.w", before=2.0), "before = 2 s must lie within the run"),
        (gb.at("load.w", 1.5), "1.5 s must lie in the run, which goes from 0 to 1 s"),
        (gb.count("clutsch"), "'clutsch' has no events; clutch, tau have"),
        (gb.count("clutch", "contact_lost"), "'clutch' has no contact; nothing in this train has"),
        (
            gb.count("clutch", "sudden"),
            "kind = 'sudden' must be one of state, time, impact, contact_made, contact_lost",
        ),
        (gb.event_time("shaft"), "'shaft' has no events"),
        (gb.energy_lost("motor"), "'motor' has no losses"),
        (gb.points("load.w"), "needs a section"),
        (gb.points("load.w", gb.stroboscopic("nothing")), "there is no parameter 'nothing'"),
        (gb.points("load.w", gb.stroboscopic("gain")), "must be > 0"),
    ],
    ids=lambda x: getattr(x, "name", ""),
)
def test_what_the_run_does_not_have_is_refused_by_name(run: gb.Trajectory, quantity: gb.Quantity, words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        quantity.of(run)
    assert words in str(caught.value)


def test_bad_arguments_are_refused_where_they_are_written() -> None:
    for make in (
        lambda: gb.peak(3),  # type: ignore[arg-type]
        lambda: gb.rms("a", after=float("nan")),
        lambda: gb.at("a", "soon"),  # type: ignore[arg-type]
        lambda: gb.event_time("a", number=1.5),  # type: ignore[arg-type]
        lambda: gb.points("a", keep=2.5),  # type: ignore[arg-type]
    ):
        with pytest.raises(gb.ParameterError):
            make()
