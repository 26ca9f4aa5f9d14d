"""The C of a train is the same bytes in every process."""

import os
import subprocess
import sys

import pytest

HEATED = """
import gearblocks as gb
from gearblocks.model.build import make_program

rig = gb.Drivetrain("heated")
rig.add("mass", gb.ThermalMass(C=50.0, T0=300.0))
one, two = rig.add("one", gb.Inertia(J=1.0, w0=9.0)), rig.add("two", gb.Inertia(J=2.0))
for i in range(5):
    shaft = rig.add(f"shaft{i}", gb.Shaft(k=9.0 + i, c=0.1, heat=gb.HeatPort(T="mass")))
    rig.chain(one, shaft, two)
print(make_program(rig.train()).key)
"""
"""The mass reads five signals at once."""


@pytest.mark.few(1)
def test_the_c_does_not_change_with_the_order_of_sets():
    keys = set()
    for seed in ("1", "2", "3"):
        run = subprocess.run(
            [sys.executable, "-c", HEATED], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=True
        )
        keys.add(run.stdout)
    assert len(keys) == 1
