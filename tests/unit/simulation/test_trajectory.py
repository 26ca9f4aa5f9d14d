"""A run keeps what it was given and gives it back by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from gearblocks.errors import GearblocksError, UnknownNameError
from gearblocks.simulation.records import EnergyLedger
from gearblocks.simulation.trajectory import Trajectory


def test_outputs_are_found_by_name(make_run: Callable[..., Trajectory]) -> None:
    run = make_run()
    assert run["wheel.w"][0] == 100.0
    assert run["t"] is run.t
    assert run.names == ("mesh.force", "mesh.deflection", "wheel.w", "planet.sun_mesh[1].force")
    assert "mesh.force" in run and "mesh.torque" not in run
    assert run.units["mesh.force"] == "N"
    assert list(run) == list(run.names)


def test_columns_may_come_as_one_table(make_run: Callable[..., Trajectory]) -> None:
    table = np.arange(8.0).reshape(4, 2)
    run = make_run(columns=(("a.x", "a.y"), table))
    assert run["a.y"].tolist() == [1.0, 3.0, 5.0, 7.0]


def test_a_run_cannot_be_changed(make_run: Callable[..., Trajectory]) -> None:
    run = make_run()
    for values in (run.t, run["mesh.force"], run.final_state.y if run.final_state else run.t):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 7.0
    with pytest.raises(AttributeError, match="cannot be changed"):
        run.t = np.zeros(3)
    with pytest.raises(AttributeError, match="cannot be changed"):
        del run.stats
    with pytest.raises(dataclasses.FrozenInstanceError):
        run.stats.steps = 4  # type: ignore[misc]
    with pytest.raises(TypeError):
        run.energy.stored["mesh"] = 0.0  # type: ignore[index]
    with pytest.raises(TypeError):
        run.meta["train"] = "another"  # type: ignore[index]


def test_an_unknown_output_is_refused_with_the_near_one(make_run: Callable[..., Trajectory]) -> None:
    with pytest.raises(KeyError) as caught:
        make_run()["mesh.forse"]
    assert isinstance(caught.value, GearblocksError)
    assert "mesh.forse" in str(caught.value) and "did you mean 'mesh.force'" in str(caught.value)


def test_patterns_cross_dots_and_brackets_mean_themselves(make_run: Callable[..., Trajectory]) -> None:
    run = make_run()
    assert run.select("mesh.*").names == ("mesh.force", "mesh.deflection")
    assert run.select("*force").names == ("mesh.force", "planet.sun_mesh[1].force")
    assert run.find("planet.sun_mesh[1].*") == ("planet.sun_mesh[1].force",)
    assert run.select("wheel.w", "mesh.force").names == ("mesh.force", "wheel.w")
    assert run.select("mesh.*").energy is run.energy
    with pytest.raises(UnknownNameError, match="pump"):
        run.select("mesh.*", "pump.*")


def test_wrong_shapes_and_names_are_refused(make_run: Callable[..., Trajectory]) -> None:
    with pytest.raises(GearblocksError, match=r"'a\.x' has shape \(3,\); the run has 4 samples"):
        make_run(columns={"a.x": np.zeros(3)})
    with pytest.raises(GearblocksError, match="cannot be named 't'"):
        make_run(columns={"t": np.zeros(4)})
    with pytest.raises(GearblocksError, match="2 names do not fit"):
        make_run(columns=(("a", "b"), np.zeros((4, 3))))


def test_the_ledger_balances(make_run: Callable[..., Trajectory]) -> None:
    ledger = make_run().energy
    assert ledger.end == 3.0
    assert ledger.turnover == 20.0
    assert ledger.imbalance == 0.0  # 3 - 1 - 3 + 1
    assert dataclasses.replace(ledger, start=0.0).residual == 1.0 / 20.0
    assert EnergyLedger().residual == 0.0
    assert "supplied by drive" in str(ledger)


def test_the_representation_tells_what_the_run_is(make_run: Callable[..., Trajectory]) -> None:
    words = repr(make_run())
    assert "a pair" in words and "4 samples" in words and "dp8" in words
    assert "stopped early" in repr(make_run(meta={"train": "x", "complete": False}))


def test_amounts_that_are_rounding_beside_the_turnover_are_told_as_zero(make_run: Callable[..., Trajectory]) -> None:
    ledger = dataclasses.replace(make_run().energy, supplied={"drive": 3.0, "gear": -3e-13}, dissipated={"mesh": 1e-9})
    rows = {line[: line.rindex(" J")].rpartition("  ")[0].strip(): line for line in str(ledger).splitlines()[:-1]}
    assert float(rows["supplied by gear"].split()[-2]) == 0.0 and ledger.supplied["gear"] == -3e-13
    assert float(rows["dissipated in mesh"].split()[-2]) == 1e-9
    assert float(rows["left over"].split()[-2]) == pytest.approx(ledger.imbalance)


@pytest.mark.parametrize(
    ("name", "way"),
    [("time", r"write run\.t$"), ("plots", "did you mean 'plot'"), ("to_pandas", r"write run\.to_dataframe$")],
)
def test_an_attribute_that_a_run_has_not_says_which_it_has(
    make_run: Callable[..., Trajectory], name: str, way: str
) -> None:
    with pytest.raises(AttributeError, match=rf"a Trajectory has no attribute '{name}'.*{way}"):
        getattr(make_run(), name)
