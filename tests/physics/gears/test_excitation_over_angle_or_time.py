"""A mesh whose stiffness and error follow the angle keeps the energy of a free pair; one that follows time does not."""

import numpy as np
import pytest

import gearblocks as gb

Z, R, K, J = (20, 30), (0.02, 0.03), 1.0e6, (1e-3, 4e-3)
NATURAL = float(np.sqrt(K * (R[0] ** 2 / J[0] + R[1] ** 2 / J[1])))  # of the mesh at its mean stiffness
CYCLES = 1000
EXCITATIONS = {
    "stiffness": {"stiffness_variation": gb.Fourier(cos=(0.2, 0.05))},
    "error": {"transmission_error": gb.Harmonic(cos=(1e-5,))},
}
EXCITATIONS["both"] = EXCITATIONS["stiffness"] | EXCITATIONS["error"]


def _energy(excitation, pace, driven_by):
    """Total energy of a free pair without damping over 1000 mesh cycles, relative to its start, and the run."""
    w = pace * NATURAL / Z[0]
    rig = gb.Drivetrain("free pair")
    effects = {name: effect.changed(driven_by=driven_by) for name, effect in EXCITATIONS[excitation].items()}
    mesh = gb.GearMesh(teeth=Z, r_base=R, external=True, k=K, **effects)
    rig.chain(
        rig.add("pinion", gb.Inertia(J=J[0], phi0=1e-3, w0=w)),
        rig.add("mesh", mesh),
        rig.add("wheel", gb.Inertia(J=J[1], w0=-w * Z[0] / Z[1])),
    )
    # the samples fall on ever other points of the mesh cycle
    t = np.linspace(0, CYCLES * 2 * np.pi / (pace * NATURAL), 2311)
    run = gb.simulate(rig, t=t, rtol=1e-12, method="dp8")
    spring = run["mesh.stiffness"] * run["mesh.deflection"] ** 2 / 2
    energy = run["pinion.kinetic_energy"] + run["wheel.kinetic_energy"] + spring
    return energy / energy[0], run


@pytest.mark.long
@pytest.mark.parametrize("pace", [pytest.param(0.2, marks=pytest.mark.long), 1.0, 2.0])
@pytest.mark.parametrize("excitation", EXCITATIONS)
def test_driven_by_the_angle_a_free_pair_keeps_its_energy_and_driven_by_time_it_does_not(excitation, pace):
    """pace: mesh frequency over natural frequency."""
    kept, run = _energy(excitation, pace, "angle")
    assert run["pinion.phi"][-1] * Z[0] / (2 * np.pi) == pytest.approx(CYCLES, rel=0.05)
    # up to 170,000 steps at rtol 1e-12 drift by 6e-11
    assert np.abs(kept - 1).max() < 1e-9
    assert run.energy.supplied == {}
    lost, run = _energy(excitation, pace, pace * NATURAL)
    assert np.abs(lost - 1).max() > 1e-5
    # whatever keeps the excitation in time has to pay for it: the ledger says how much
    gained = run.energy.end - run.energy.start
    assert run.energy.supplied["mesh"] == pytest.approx(gained, abs=1e-9 * run.energy.largest_stored)
