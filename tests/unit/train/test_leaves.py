"""Parameters, Inputs and feedback signals in blocks, and other ones in their place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb


def _stage(gap: Any, gain: Any) -> gb.Drivetrain:
    """A nested train with a Parameter in an effect and one in a signal."""
    inner = gb.Drivetrain("stage")
    pinion, wheel = inner.add("pinion", gb.Inertia(J=1e-3)), inner.add("wheel", gb.Inertia(J=4e-3))
    teeth = gb.GearMesh(
        teeth=(20, 30),
        external=True,
        r_base=(0.02, 0.03),
        k=1e8,
        damping_ratio=0.05,
        backlash=gb.Backlash(half_gap=gap),
    )
    inner.chain(pinion, inner.add("mesh", teeth), wheel)
    inner.connect(inner.add("load", gb.Torque(tau=-gain * gb.sense("wheel.w"))).flange, wheel.b)
    inner.expose("a", pinion.a)
    return inner


def _rig(gap: Any, gain: Any, torque: Any, inertia: Any = 0.02) -> gb.Drivetrain:
    rig = gb.Drivetrain("nested")
    motor = rig.add("motor", gb.Inertia(J=inertia))
    drive, stage = rig.add("drive", gb.Torque(tau=torque)), rig.add("stage", _stage(gap, gain))
    rig.connect(drive.flange, motor.a)
    rig.connect(motor.b, stage.a)
    rig.coordinate("turn", gap * gb.sense("motor.phi"), "m")
    return rig


def _parameters(half_gap: float = 20.0, gain: float = 0.5, torque: float = 3.0) -> tuple[Any, Any, Any, Any]:
    gap = gb.Parameter("half_gap", half_gap, "um")
    load, drive = gb.Parameter("gain", gain), gb.Parameter("torque", torque, "N m")
    return gap, 0.1 * load, gb.piecewise((drive * (1 + gb.time), gb.time < 0.05), (2 * drive, True)), 0.01 * load + 0.02


VALUES = {"half_gap": 60.0, "gain": 0.9, "torque": 5.0}


def _text(train, folder):
    train.to_json(folder / "train.json")
    return (folder / "train.json").read_text(encoding="utf-8")


def test_a_parameter_has_another_value_wherever_it_stands(tmp_path):
    train = _rig(*_parameters())
    changed = train.set(VALUES)
    assert _text(changed, tmp_path) == _text(_rig(*_parameters(**VALUES)), tmp_path)
    assert _text(train, tmp_path) == _text(
        _rig(*_parameters()), tmp_path
    )  # the one that it was made of has not changed
    assert {row.name: row.value for row in changed.parameters(*VALUES)} == pytest.approx(VALUES)
    given = gb.simulate(train, t_end=0.1, parameters=VALUES)
    run = gb.simulate(changed, t_end=0.1)
    assert all(np.array_equal(run[name], given[name]) for name in ("motor.w", "stage.mesh.force", "turn"))


@pytest.mark.parametrize(("value", "wanted"), [(60.0, 60.0), ("0.06 mm", 60.0), ("60 um", 60.0), (np.float64(7), 7.0)])
def test_its_value_is_in_its_unit_or_brings_one(value, wanted):
    changed = _rig(*_parameters()).set({"half_gap": value})
    (row,) = changed.parameters("half_gap")
    assert row.value == pytest.approx(wanted)


@pytest.mark.parametrize(("values", "words"), [
    ({"half_gap": "3 N m"}, "half_gap.*N m.*um"), ({"half_gap": float("nan")}, "half_gap.*must be a finite number"),
    ({"half_gap": -3.0}, "half_gap.* must be >= 0"), ({"half_gaps": 3.0}, "'half_gaps' does not exist"),
])  # fmt: skip
def test_a_value_that_it_cannot_have_is_refused(values, words):
    with pytest.raises(gb.GearblocksError, match=words):
        _rig(*_parameters()).set(values)


@pytest.mark.parametrize("half_gap", [45.0, 2000.0])
def test_effects_that_were_left_out_are_watched_with_the_new_value(half_gap, tmp_path):
    plain = _rig(*_parameters()).without("*.backlash")
    wanted = _rig(*_parameters(half_gap, torque=4.0)).without("*.backlash")
    changed = plain.set({"half_gap": half_gap, "torque": 4.0})
    assert _text(changed, tmp_path) == _text(wanted, tmp_path)
    befores = [train["stage"].part._before["mesh"].backlash for train in (changed, wanted)]
    assert befores[0].half_gap == befores[1].half_gap == gb.Parameter("half_gap", half_gap, "um")


def test_a_field_comes_before_a_parameter_and_both_can_be_set_at_once():
    train = _rig(*_parameters())
    changed = train.set({"torque": 5.0, "stage.mesh.k": 2e8, "motor": gb.Inertia(J=3.0)})
    assert changed["stage.mesh"].k == 2e8 and changed["motor"].J == 3.0
    assert {row.name: row.value for row in changed.parameters("torque")} == {"torque": 5.0}
