"""One thing is not counted in the plural."""

import pytest

import gearblocks as gb
from gearblocks.plurals import singular


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("1 states, 11 inputs, 1 outputs", "1 state, 11 inputs, 1 output"),
        ("1 switches, 1 bodies, 1 boxes, 1 cases", "1 switch, 1 body, 1 box, 1 case"),
        ("0.1 points at 1 s, x-1 modes, 1 s: 0 events", "0.1 points at 1 s, x-1 modes, 1 s: 0 events"),
    ],
)
def test_one_is_singular(text, shown):
    assert singular(text) == shown


def test_what_a_train_tells_of_itself_counts_right():
    rig = gb.Drivetrain("one")
    rig.connect(rig.add("disc", gb.Inertia(J=1.0)).a, rig.add("drive", gb.Torque(tau=gb.Input("u"))).flange)
    told = [repr(gb.build(rig)), repr(gb.linearize(rig)), repr(gb.modes(rig)), repr(rig.equations())]
    assert "1 input," in told[0] and "1 mode," in told[2]
    assert not [x for x in told if singular(x) != x]
