"""Laws know relative angles where absolute ones cancel."""

import pytest

import gearblocks as gb
from gearblocks.laws.derivation import derive

MESH = {"teeth": (23, 41), "r_base": (0.03, 0.03 * 41 / 23), "external": True, "k": 2e8, "c": 300.0}
GAP = gb.Backlash(half_gap=3e-5)


@pytest.mark.parametrize("driven_by", ["angle", 500.0])
def test_a_mesh_on_a_turning_carrier_knows_its_deflection_without_absolute_angles(driven_by):
    # they cancel in the deflection; left in, they are integrated and drown it after many turns
    mesh = gb.GearMesh(**MESH, stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=driven_by), backlash=GAP)
    law = derive(mesh, frozenset())

    def absolute(expr):
        return [x for x in expr.free_symbols if law.pool.roles[x].role == "phi"]

    assert not absolute(law.switches[0].surface)  # the gap
    if driven_by != "angle":
        assert not any(absolute(x) for x in (*law.forces.values(), *law.torques.values(), law.stored, law.loss))
