"""What a train has before any run: outputs, parameters, inputs and flanges, by pattern, with unit, words and value."""

from __future__ import annotations

import dataclasses
import pickle
from collections.abc import Callable
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.model.listing import Listed, Listing, matches


def _rig() -> gb.Drivetrain:
    rig = gb.Drivetrain("spur pair")
    motor, wheel = rig.add("motor", gb.Inertia(J=0.02, w0=3.0)), rig.add("wheel", gb.Inertia(J=0.05))
    gear = rig.add("gear", gb.IdealGear(ratio=2.5))
    shaft = rig.add("shaft", gb.Shaft(k="20 kN m/rad", c=gb.Parameter("drag", 3.0, "N m s/rad")))
    tau = gb.Input("tau", start=20.0, unit="kN m") + gb.Parameter("n", 3000, "rpm")
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), motor, gear, shaft, wheel)
    return rig


def _nested() -> gb.Drivetrain:
    cell = gb.Drivetrain("cell")
    body = cell.add("body", gb.Mass(m=1.0))
    cell.expose("end", body.a)
    rig = gb.Drivetrain("nested")
    rig.connect(rig.add("one", cell).end, rig.add("spring", gb.Shaft(k=1.0)).a)
    return rig


def _refused(act: Callable[[], Any], kind: type[Exception], *words: str) -> None:
    with pytest.raises(kind) as caught:
        act()
    for word in words:
        assert word in str(caught.value), str(caught.value)


def test_outputs_are_those_that_a_run_records() -> None:
    rig = _rig()
    run = gb.simulate(rig, t_end=1e-3)
    found = rig.outputs()
    assert sorted(found.names) == sorted(run.names)
    assert {x.name: x.unit for x in found} == dict(run.units)
    assert Listed("shaft.twist", "rad", "twist phi_b - phi_a") in found


def test_patterns_go_over_whole_names_and_cross_dots() -> None:
    rig = _rig()
    assert rig.outputs("motor.w").names == ("motor.w",)
    assert rig.outputs("shaft.t*").names == ("shaft.twist", "shaft.twist_rate", "shaft.torque")
    assert set(rig.outputs("*.w", "shaft.twist").names) >= {"motor.w", "motor.a.w", "shaft.twist"}
    assert matches("gear.sun_mesh[1].force", "gear.sun_mesh[1].*")
    assert not matches("gear.sun_mesh1.force", "gear.sun_mesh[1].*")


def test_a_listing_goes_part_by_part_own_outputs_first() -> None:
    names = _rig().outputs("motor.*", "shaft.*").names
    assert [name.partition(".")[0] for name in names] == sorted(
        [name.partition(".")[0] for name in names], key=["motor", "shaft"].index
    )
    depths = [name.count(".") for name in names if name.startswith("shaft.")]
    assert depths == sorted(depths)


def test_parameters_have_their_values_in_the_unit_they_are_given_in() -> None:
    found = {x.name: x for x in _rig().parameters()}
    assert found["shaft.k"] == Listed("shaft.k", "N m/rad", "torsional stiffness", 2e4)
    assert (found["n"].value, found["n"].unit) == (3000.0, "rpm")
    assert found["motor.w0"].value == 3.0
    run = gb.simulate(
        _rig(), t_end=1e-3, parameters={x.name: x.value for x in found.values() if "start" not in x.words}
    )
    assert run.complete


def test_a_start_value_that_is_found_when_the_train_is_built_has_none() -> None:
    rig = gb.Drivetrain("joint")
    motor, load = rig.add("motor", gb.Inertia(J=1.0)), rig.add("load", gb.Inertia(J=2.0, w0=3.0))
    rig.chain(motor, rig.add("joint", gb.UniversalJoint(angle=0.3)), load)
    assert [x.value for x in rig.parameters("motor.w0")] == [None]
    assert [x.value for x in rig.set({"load.w0": None}).parameters("motor.w0")] == [0.0]


def test_inputs_have_their_value_before_anything_is_connected() -> None:
    assert tuple(_rig().inputs()) == (Listed("tau", "kN m", "input", 20.0),)
    assert repr(_rig().inputs()) == "1 input\n  tau  20  kN m  input"
    assert repr(_nested().inputs()) == "no inputs"


def test_flanges_say_what_they_are_joined_to() -> None:
    found = {x.name: x.value for x in _rig().flanges()}
    assert found["motor.b"] == "joined to gear.a"
    assert found["gear.housing"] == "the ground"
    assert found["wheel.b"] == "free"


def test_flanges_of_a_train_that_is_not_finished_and_of_trains_inside_are_listed() -> None:
    found = {x.name: (x.value, x.unit) for x in _nested().flanges()}
    assert found == {
        "one.end": ("joined to one.body.a, spring.a", "m"),
        "one.body.a": ("joined to one.end, spring.a", "m"),
        "one.body.b": ("free", "m"),
        "spring.a": ("joined to one.end, one.body.a", "m"),
        "spring.b": ("open", "m"),
    }
    assert len(gb.Drivetrain("empty").flanges()) == 0


@pytest.mark.parametrize("what", ["outputs", "parameters", "flanges"])
def test_a_pattern_that_matches_nothing_is_named_with_near_ones(what: str) -> None:
    take = getattr(_rig(), what)
    _refused(
        lambda: take("shft.*"), gb.UnknownNameError, f"none of the {what} matches 'shft.*' - did you mean 'shaft.*'"
    )
    _refused(
        lambda: take("*", "moter.x", "zzz"), gb.UnknownNameError, "matches 'moter.x'", "matches 'zzz'", "there are "
    )
    _refused(lambda: take(["shaft.*"]), gb.ParameterError, f"{what} takes patterns one by one as text, such as {what}(")


def test_a_run_that_is_asked_for_an_output_it_has_not_names_near_patterns() -> None:
    _refused(
        lambda: gb.simulate(_rig(), t_end=1.0, outputs="shft.*"),
        gb.UnknownNameError, "no output matches 'shft.*' - did you mean 'shaft.*'", "rig.outputs() lists them",
    )  # fmt: skip


def test_open_ends_are_named_before_outputs_are() -> None:
    _refused(lambda: _nested().outputs(), gb.ModelError, "flange 'b' of Shaft 'spring' is open")


def test_a_listing_is_a_frozen_value() -> None:
    found = _rig().outputs("motor.w")
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.what = "x"
    assert found == _rig().outputs("motor.w") == pickle.loads(pickle.dumps(found))
    assert found[0] == Listed("motor.w", "rad/s", "speed")
    assert found[:1] == tuple(found)


def test_a_long_listing_prints_its_beginning() -> None:
    found = Listing("outputs", tuple(Listed(f"b.x{i}", "1", "") for i in range(1000)))
    lines = repr(found).splitlines()
    assert lines[0] == "1000 outputs"
    assert lines[-1] == "  ... and 800 more"
    assert len(lines) == 202


def test_nothing_is_compiled_for_a_listing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("compiled")

    monkeypatch.setattr("gearblocks.model.build.compile_program", refuse)
    monkeypatch.setattr("gearblocks.model.build.start_core_build", refuse)
    rig = gb.Drivetrain("never built elsewhere")
    rig.chain(rig.add("a", gb.Inertia(J=0.123)), rig.add("b", gb.Damper(c=1.0)), rig.add("c", gb.Inertia(J=0.3)))
    assert rig.outputs("a.w").names == ("a.w",)
