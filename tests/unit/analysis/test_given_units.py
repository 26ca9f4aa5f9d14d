"""Values with units, and in a Parameter's own unit, in designs and sweeps; rows and functions that are none of numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.regimes.branch import _span
from gearblocks.analysis.regimes.carried import rising

RPM = math.pi / 30


def driven() -> gb.Drivetrain:
    """A body on a spring, driven by a torque that follows a Parameter in rpm."""
    speed = gb.Parameter("speed", 10.0, "rpm")
    rig = gb.Drivetrain("driven")
    ground, disc = rig.add("ground", gb.Fixed()), rig.add("disc", gb.Inertia(J=1.0))
    rig.chain(ground, rig.add("shaft", gb.Shaft(k=1.0, c=0.2)), disc)
    rig.connect(disc.b, rig.add("drive", gb.Torque(tau=gb.cos(speed * gb.time))).flange)
    return rig


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(driven())


def test_one_number_means_one_speed_in_every_sweep(model: gb.Model) -> None:
    """The response of the oscillator of k = J = 1, c = 0.2 tells at which speed it was driven."""
    w = 12.0 * RPM
    amplitude = 1.0 / abs(1.0 - w * w + 0.2j * w)
    arguments: dict[str, Any] = {"of": "disc.phi", "transient": 60, "keep": 5, "rtol": 1e-10}
    for values in ([12.0], ["12 rpm"], [f"{w!r} rad/s"], "12 rpm"):
        found = gb.speed_sweep(model, "speed", values, **arguments)
        assert found.values == pytest.approx([12.0], rel=1e-15) and found.unit == "rpm"
        assert found.peak_to_peak == pytest.approx(np.full((2, 1), 2 * amplitude), rel=1e-3)
    study = gb.sweep(
        model, {"speed": [12.0]}, quantity=gb.peak("disc.phi"), section=gb.stroboscopic("speed"), transient=60, keep=5
    )
    assert study.values[0, 0] == pytest.approx(amplitude, rel=1e-3)


def test_a_bifurcation_and_a_branch_take_the_unit_of_the_parameter(model: gb.Model) -> None:
    section = gb.stroboscopic("speed")
    options: dict[str, Any] = {"section": section, "transient": 10, "keep": 7, "longest": 3}
    one, other = (gb.bifurcation(model, "speed", values, **options) for values in ([12.0], ["12 rpm"]))
    assert one.unit == "rpm" and one.points.tobytes() == other.points.tobytes()
    branch = gb.continue_orbit(model, "speed", (12.0, "13 rpm"), section=section, transient=60, of="disc.phi")
    assert (
        branch.unit == "rad/s" and branch.values[0] == pytest.approx(12 * RPM) and branch.values[-1] >= 13 * RPM - 0.01
    )
    w = branch.values
    assert (branch.high - branch.low) / 2 == pytest.approx(1.0 / np.abs(1.0 - w * w + 0.2j * w), rel=1e-6)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (["50 Hz"], "Hz counts cycles"), (["700 1/min"], "write rpm"), (["fast"], "must be a number"),
        ([2.0, 1.0], "must be finite and increase"), ([object()], "numbers in rpm, or texts with their unit"),
        (["2 rpm", "1 rpm"], "increase"),
    ],
)  # fmt: skip
def test_values_that_are_no_speeds_are_refused(model: gb.Model, values: Any, words: str) -> None:
    info = model.program.parameters[model.program.parameter_numbers["speed"]]
    with pytest.raises(gb.ParameterError, match=words):
        rising(values, info)
    with pytest.raises(gb.ParameterError):
        _span([*values, *values], info)


@pytest.mark.parametrize("make", [gb.latin_hypercube, gb.random_cases])
def test_bounds_may_bring_their_unit_and_values_bring_it_then(make: Any) -> None:
    plain = make({"shaft.k": (1.0, 2.0), "speed": (10.0, 20.0)}, 4)
    united = make({"shaft.k": ("1 N m/rad", "0.002 kN m/rad"), "speed": (10.0, 20.0)}, 4)
    assert [float(x.split()[0]) for x in united["shaft.k"]] == pytest.approx(plain["shaft.k"].tolist(), rel=1e-15)
    assert all(x.endswith(" N m/rad") for x in united["shaft.k"]) and (united["speed"] == plain["speed"]).all()
    studies = [gb.study(driven(), cases, quantity=gb.last("disc.phi"), t_end=0.1) for cases in (plain, united)]
    assert studies[0].values == pytest.approx(studies[1].values, rel=1e-12)


@pytest.mark.parametrize(
    ("bounds", "words"),
    [
        (("1 N m/rad", 2.0), "must both bring their unit, or none"), (("1 N m/rad", "2 mm"), "belongs here is in N m/rad"),
        (("2 mm", "1 mm"), "must be below"), (("stiff", "2 mm"), "lower bound"),
    ],
)  # fmt: skip
def test_bounds_that_are_none_are_refused(bounds: Any, words: str) -> None:
    with pytest.raises(gb.ParameterError, match=words):
        gb.latin_hypercube({"shaft.k": bounds}, 3)


def test_the_frequency_of_a_line_may_be_text() -> None:
    assert gb.line("disc.w", "1.15 kHz") == gb.line("disc.w", 1150.0)
    for wrong in ("1150 rad/s", "69000 rpm", "fast", "-3 Hz"):
        with pytest.raises(gb.ParameterError, match="line: frequency"):
            gb.line("disc.w", wrong)


def test_what_is_structural_is_told_whatever_its_values_are() -> None:
    rig = driven().set({"shaft": gb.Shaft(k=1.0, torque=None)})
    rig.chain(
        rig["disc"], rig.add("gear", gb.IdealGear(teeth=(20, 30), external=True)), rig.add("load", gb.Inertia(J=1.0))
    )
    ask: dict[str, Any] = {"quantity": gb.last("disc.phi"), "t_end": 0.1}
    for given in ({"gear.teeth": [(20, 30)]}, {"gear.teeth": [20.0]}, {"gear.external": [None]}):
        with pytest.raises(gb.ParameterError, match=r"is structural: make one study for each rig.set"):
            gb.sweep(rig, given, **ask)
    for path in ("gear.teeth", "teeth", "gear.external"):
        with pytest.raises(
            gb.ParameterError, match=r"is structural, no parameter of a run: make a new train with rig.set"
        ):
            gb.simulate(rig, t_end=0.1, parameters={path: 3.0})
    with pytest.raises(gb.ParameterError, match=r"'disc.J': value \[1\] = nan must be a finite number"):
        gb.sweep(rig, {"disc.J": [1.0, math.nan]}, **ask)


@pytest.mark.parametrize("at", ["foo", "Static", 3.0, ["static"]])
def test_a_point_that_is_none_is_refused_under_its_own_name(model: gb.Model, at: Any) -> None:
    for ask in (gb.modes, gb.linearize):
        with pytest.raises(
            gb.ParameterError, match=r"at = .* must be start values .* 'static', 'static_at_start', 'rolling'"
        ):
            ask(model, at=at)


def test_a_step_that_is_too_long_is_named_with_the_element_that_is_too_fast_for_it() -> None:
    rig = gb.Drivetrain("two springs")
    bodies = [rig.add(name, gb.Inertia(J=1e-3, w0=w)) for name, w in (("one", 1.0), ("two", 0.0), ("three", 0.0))]
    soft, stiff = rig.add("soft", gb.Shaft(k=10.0)), rig.add("stiff", gb.Shaft(k=1e5))
    rig.chain(bodies[0], soft, bodies[1], stiff, bodies[2])
    with pytest.raises(
        gb.SimulationError, match=r"'stiff': the fixed step = 0.001 s .* swings at 22\d\d Hz.*about 7.*e-05 s"
    ):
        gb.simulate(rig, t_end=1.0, method="rk4", step="1 ms")
