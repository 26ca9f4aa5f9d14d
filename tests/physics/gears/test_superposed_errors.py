"""Several transmission errors of one mesh add up, each with a phase of its own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

OF_TEETH = gb.Harmonic(cos=(1e-5,), sin=(4e-6,))
RUN_OUT = gb.Harmonic(sin=(2e-5,), driven_by=100.0)
SAW = gb.Profile(table=gb.Table([0, 0.5, 1], [0, 1e-6, 0], periodic=True), driven_by=50.0)
START = {"pinion.w": 100.0, "wheel.w": -200.0 / 3}


def pair(error: Any, **fields: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("pair")
    mesh = gb.GearMesh(
        teeth=(20, 30),
        external=True,
        r_base=(0.03, 0.045),
        k=1e8,
        damping_ratio=0.05,
        transmission_error=error,
        **fields,
    )
    parts = [rig.add("pinion", gb.Inertia(J=0.01)), rig.add("mesh", mesh), rig.add("wheel", gb.Inertia(J=0.02))]
    rig.chain(*parts)
    return rig


def run(rig: gb.Drivetrain) -> gb.Trajectory:
    return gb.simulate(rig, t=np.linspace(0, 0.05, 101), rtol=1e-10, initial=START)


def error_in(found: gb.Trajectory) -> Any:
    return found["mesh.dynamic_transmission_error"] - found["mesh.deflection"]


def test_the_errors_add_up_each_with_its_own_phase() -> None:
    found = run(pair((OF_TEETH, RUN_OUT)))
    teeth = 20 * found["pinion.phi"]
    expected = 1e-5 * np.cos(teeth) + 4e-6 * np.sin(teeth) + 2e-5 * np.sin(100 * found.t)
    assert error_in(found) == pytest.approx(expected, abs=1e-18)  # a difference of numbers of 1e-5
    assert found.energy.residual < 1e-8


@pytest.mark.long
def test_a_sum_of_two_parts_is_the_series_of_both() -> None:
    parts = (gb.Harmonic(cos=(1e-5,)), gb.Harmonic(sin=(4e-6,)))
    one, two = run(pair(OF_TEETH)), run(pair(parts))
    # the same law in other terms: equal but for rounding, which grows along steps that differ in their last bits
    assert two["mesh.force"] == pytest.approx(one["mesh.force"], rel=1e-6, abs=1e-6 * np.abs(one["mesh.force"]).max())


@pytest.mark.long
def test_three_errors_are_a_sum_of_sums_with_paths_of_their_own(tmp_path: Path) -> None:
    rig = pair([OF_TEETH, RUN_OUT, SAW])
    nested = gb.Superposition(first=OF_TEETH, second=gb.Superposition(first=RUN_OUT, second=SAW))
    assert rig["mesh"] == pair(nested)["mesh"]
    louder = {"mesh.transmission_error.second.first.sin[0]": 4e-5}
    found = gb.simulate(rig, t=np.linspace(0, 0.05, 101), rtol=1e-10, initial=START, parameters=louder)
    teeth, cycles = 20 * found["pinion.phi"], 50 * found.t / (2 * np.pi) % 1
    saw = 2e-6 * np.minimum(cycles, 1 - cycles)
    expected = 1e-5 * np.cos(teeth) + 4e-6 * np.sin(teeth) + 4e-5 * np.sin(100 * found.t) + saw
    assert error_in(found) == pytest.approx(expected, abs=1e-18)  # a difference of numbers of 1e-5
    rig.to_json(tmp_path / "rig.json")
    assert gb.Drivetrain.from_json(tmp_path / "rig.json")["mesh"] == rig["mesh"]


def test_the_errors_of_a_mesh_are_one_effect() -> None:
    rig = pair((OF_TEETH, RUN_OUT))
    assert "mesh.transmission_error" in rig.effects()
    assert rig.without("*.transmission_error").dropped == ("mesh.transmission_error",)


def test_planets_move_every_part_by_their_phase() -> None:
    law = gb.MeshLaw(k=1e8, transmission_error=(OF_TEETH, gb.Harmonic(cos=(1e-6,), phase=0.5)))
    error = law.shifted(1.0).transmission_error
    assert isinstance(error, gb.Superposition)
    assert (error.first.phase, error.second.phase) == (1.0, 1.5)  # type: ignore[union-attr]


def test_phases_that_are_integrated_have_symbols_of_their_own() -> None:
    w = gb.Input("w", start=100.0, unit="rad/s")
    rig = pair((gb.Harmonic(cos=(1e-5,), driven_by=w), gb.Harmonic(cos=(2e-5,), driven_by=2 * w)))
    text = str(rig.equations().element("mesh"))
    assert re.search(r"e_mesh = a_ea1_mesh cos\(θ_ea_mesh\) \+ a_eb1_mesh cos\(θ_eb_mesh\)", text)
    assert "θ_ea_mesh' = w" in text and "θ_eb_mesh' = 2 w" in text


@pytest.mark.long
def test_a_gear_of_any_shape_takes_several_errors() -> None:
    gear = gb.NonCircularGear(
        external=True,
        law=gb.RatioLaw.ellipse(0.1),
        k=1e5,
        transmission_error=(gb.Harmonic(cos=(1e-3,)), gb.Harmonic(sin=(2e-3,), driven_by=9.0)),
    )
    rig = gb.Drivetrain("ellipses")
    rig.chain(rig.add("one", gb.Inertia(J=0.01, w0=3.0)), rig.add("gear", gear), rig.add("two", gb.Inertia(J=0.01)))
    found = gb.simulate(rig, t_end=0.05, rtol=1e-9)
    assert found.energy.residual < 1e-6 and found.stats.steps > 10


@pytest.mark.parametrize(
    ("error", "words"),
    [
        ((OF_TEETH, 3.0), "second = 3.0 must be an effect object"),
        ((OF_TEETH, None), "the second of two errors is missing; give both, or the other one alone"),
        ((OF_TEETH, gb.Backlash(half_gap=1e-5)), r"second = Backlash\(.*\) must be gb.Harmonic\(...\) or gb.Profile"),
        ((), r"transmission_error = \(\) must be an effect object"),
    ],
)
def test_a_part_that_is_no_error_is_refused_by_name(error: Any, words: str) -> None:
    with pytest.raises(gb.ModelError, match=words):
        pair(error)
