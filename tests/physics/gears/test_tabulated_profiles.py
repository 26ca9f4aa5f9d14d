"""Stiffness and error given as points over one mesh cycle."""

import numpy as np
import pytest

import gearblocks as gb

CYCLES = np.linspace(0.0, 1.0, 201)
WAVE = gb.Table(CYCLES, 0.2 * np.cos(2 * np.pi * CYCLES).round(15), kind="cubic", periodic=True)
T = np.linspace(0.0, 0.02, 101)


def _pair(**effects: object) -> gb.Drivetrain:
    rig = gb.Drivetrain("pair")
    mesh = gb.GearMesh(teeth=(20, 30), r_base=(0.03, 0.045), external=True, k=1e8, **effects)  # type: ignore[arg-type]
    rig.chain(
        rig.add("drive", gb.Torque(tau=50.0)), rig.add("pinion", gb.Inertia(J=1e-3, w0=100.0)), rig.add("mesh", mesh),
        rig.add("wheel", gb.Inertia(J=4e-3, w0=-200.0 / 3)), rig.add("load", gb.Torque(tau=75.0)),
    )  # fmt: skip
    return rig


@pytest.mark.parametrize("drive", ["angle", pytest.param(5000.0, marks=pytest.mark.long)])
def test_a_table_of_a_cosine_moves_the_mesh_as_the_cosine_does(drive: object) -> None:
    # a spline through 200 points a cycle is a cosine to (pi/100)^4/384 = 3e-9 of its size
    table = gb.simulate(_pair(stiffness_variation=gb.Profile(table=WAVE, driven_by=drive)), t=T, rtol=1e-10)
    wave = gb.simulate(_pair(stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=drive)), t=T, rtol=1e-10)
    scale = np.abs(wave["mesh.deflection"]).max()
    assert np.abs(table["mesh.deflection"] - wave["mesh.deflection"]).max() < 1e-5 * scale
    assert table.energy.residual < 1e-8  # ledger: 10 rtol is 1e-9, the joints of the spline cost the rest


def test_a_bare_table_is_a_profile_over_the_angle() -> None:
    short, full = _pair(stiffness_variation=WAVE), _pair(stiffness_variation=gb.Profile(table=WAVE))
    assert gb.build(short).program.key == gb.build(full).program.key


@pytest.mark.long
def test_a_table_as_transmission_error_moves_the_mesh_as_the_harmonic_does() -> None:
    error = gb.Table(CYCLES, (1e-5 * np.cos(2 * np.pi * CYCLES)).round(20), kind="cubic", periodic=True)
    table = gb.simulate(_pair(transmission_error=error), t=T, rtol=1e-10)
    wave = gb.simulate(_pair(transmission_error=gb.Harmonic(cos=(1e-5,))), t=T, rtol=1e-10)
    assert np.abs(table["mesh.force"] - wave["mesh.force"]).max() < 1e-4 * np.abs(wave["mesh.force"]).max()


def test_a_table_that_is_no_cycle_is_refused() -> None:
    with pytest.raises(gb.ModelError, match="periodic=True with x from 0 to 1"):
        _pair(stiffness_variation=gb.Table([0, 1], [0, 1]))
