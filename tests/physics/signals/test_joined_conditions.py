"""Conditions joined by &, | and ~, with and without sympy in use."""

import subprocess
import sys

import pytest

JOINED = """
import sys
import gearblocks as gb
{more}
w, t = gb.sense("a.w"), gb.time
cases = {{
    (w < 1) & (t < 2): 1.0, (w < 1) & ~(t > 2): 1.0, ~((w > 1) | (t > 2)): 1.0, (t < 0.5) | ((t > 1) & (t < 1.5)): 1.0,
}}
for number, condition in enumerate(cases):
    rig = gb.Drivetrain("joined")
    a = rig.add("a", gb.Inertia(J=1.0))
    rig.connect(a.a, rig.add("drive", gb.Torque(tau=gb.piecewise((2.0, condition), (0, True)))).flange)
    rig.to_json(sys.argv[1])
    again = gb.Drivetrain.from_json(sys.argv[1])
    for train in (rig, again):
        assert abs(gb.simulate(train, t_end=3.0)["a.w"][-1] - (2.0 if number == 3 else 1.0)) < 1e-9, number
"""


def _run(more, folder):
    command = [sys.executable, "-c", JOINED.format(more=more), str(folder / "rig.json")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_conditions_are_joined_without_sympy(tmp_path):
    _run("", tmp_path)


@pytest.mark.long
def test_conditions_are_joined_with_sympy(tmp_path):
    _run("import sympy", tmp_path)
