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


def test_results_of_one_thing_count_right():
    rig, drive = gb.Drivetrain("one"), gb.Parameter("drive", 1.0, "rad/s")
    rig.chain(
        rig.add("push", gb.Torque(tau=gb.cos(drive * gb.time))), rig.add("disc", gb.Inertia(J=1.0)),
        rig.add("spring", gb.Shaft(k=2.0, c=0.4)), rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    ask = {"section": gb.stroboscopic("drive"), "transient": 2, "of": "disc.phi"}
    told = [
        repr(gb.speed_sweep(rig, "drive", [1.0], keep=2, **ask)),
        repr(gb.bifurcation(rig, "drive", [1.0], keep=3, longest=1, **ask)),
        repr(gb.sweep(rig, {"spring.k": [1.0]}, quantity=gb.peak("disc.w"), t_end=0.1)),
        repr(gb.sweep(rig, {"spring.k": [1.0, 2.0], "disc.J": [1.0]}, quantity=gb.peak("disc.w"), t_end=0.1)),
        str(gb.modes(rig)),
        repr(gb.frequency_response(rig, "disc.J", "disc.phi", 2.0)),
    ]
    assert "1 value of drive" in told[0] and "1 value of drive" in told[1] and "at 1 frequency:" in told[5]
    assert ": 1 point over" in told[2] and ": 2 x 1 points over" in told[3]
    assert told[4].startswith("one: 1 mode, no free rotation")
