"""Static starts of trains that turn: speeds that nobody gave follow from those that are given."""

import numpy as np
import pytest

import gearblocks as gb


def _pair(**wheel):
    rig = gb.Drivetrain("pair")
    mesh = gb.GearMesh(teeth=(23, 41), r_base=(0.023, 0.041), external=True, k=2e8, damping_ratio=0.05)
    rig.chain(
        rig.add("drive", gb.Speed(w="3000 rpm")), rig.add("pinion", gb.Inertia(J=2e-4)), rig.add("mesh", mesh),
        rig.add("wheel", gb.Inertia(J=0.005, **wheel)), rig.add("shaft", gb.Shaft(k=1e4, c=1.0)),
        rig.add("drum", gb.Inertia(J=0.1)), rig.add("load", gb.Torque(tau=50.0)),
    )  # fmt: skip
    return rig


def _wave(speed):
    rig = gb.Drivetrain("wave")
    rig.chain(
        rig.add("drive", gb.Speed(w=speed)), rig.add("motor", gb.Inertia(J=0.02)), rig.add("shaft", gb.Shaft(k=2e3, c=3.0)),
        rig.add("drum", gb.Inertia(J=0.1)), rig.add("load", gb.Torque(tau=-8.0)),
    )  # fmt: skip
    return rig


def _planetary():
    rig = gb.Drivetrain("set")
    parts = {n: rig.add(n, gb.Inertia(J=J)) for n, J in (("sun", 0.01), ("carrier", 0.05), ("ring", 0.1))}
    planetary = rig.add("set", gb.IdealPlanetary(ratio=70 / 30))
    link = rig.add("link", gb.Shaft(k=5e3, c=1.0))
    rig.connect(parts["sun"].a, planetary.sun)
    rig.connect(planetary.carrier, link.a)
    rig.connect(link.b, parts["carrier"].a)
    rig.connect(planetary.ring, parts["ring"].a)
    rig.connect(rig.add("ground", gb.Fixed()).flange, parts["ring"].b)
    rig.connect(rig.add("drive", gb.Speed(w=100.0)).flange, parts["sun"].b)
    rig.connect(rig.add("load", gb.Torque(tau=-6.0)).flange, parts["carrier"].b)
    return rig


def test_bodies_behind_a_given_speed_turn_along_and_carry_the_load():
    run = gb.simulate(_pair(), t_end=1e-6, initial="static")
    w = 3000 * 2 * np.pi / 60
    assert run["wheel.w"][0] == pytest.approx(-w * 23 / 41, rel=1e-12)
    assert run["drum.w"][0] == run["wheel.w"][0]
    assert run["shaft.torque"][0] == pytest.approx(-50.0, rel=1e-9)
    assert abs(run["mesh.force"][0]) == pytest.approx(50.0 / 0.041, rel=1e-9)
    given = gb.simulate(_pair(w0=float(run["wheel.w"][0])), t_end=1e-6, initial="static")
    assert given["mesh.force"][0] == run["mesh.force"][0]


@pytest.mark.long
def test_so_they_do_in_a_planetary_set():
    run = gb.simulate(_planetary(), t_end=1e-6, initial="static")
    assert run["carrier.w"][0] == pytest.approx(100.0 * 30 / (30 + 70), rel=1e-12)
    assert run["link.torque"][0] == pytest.approx(6.0, rel=1e-9)


@pytest.mark.parametrize(("initial", "w"), [("static", 20.0), ("static_at_start", 21.0)])
def test_the_speed_is_the_mean_or_that_of_the_start(initial, w):
    run = gb.simulate(_wave(20.0 + gb.cos(300 * gb.time)), t_end=1e-6, initial=initial)
    assert run["drum.w"][0] == pytest.approx(w, rel=1e-12)


@pytest.mark.long
def test_sweeps_linear_tools_and_labels_start_so_too():
    speed = gb.Parameter("speed", 20.0, "rad/s")
    rig = _wave(speed)
    study = gb.sweep(
        rig, {"speed": [20.0, 30.0]}, quantity=gb.at("shaft.torque", 0.0), t_end=1e-3, initial="static"
    )  # fmt: skip
    np.testing.assert_allclose(study.values.ravel(), [8.0, 8.0], rtol=1e-9)
    assert gb.linearize(rig, at="static").point["drum.w"] == 20.0
    assert gb.classify(rig, gb.stroboscopic("speed"), initial="static").label == "period 1"


def test_speeds_that_contradict_are_refused_with_both_names():
    with pytest.raises(
        gb.ParameterError, match=r"'mesh' would wind up at .* rad/s; 'wheel\.w' = 5 contradicts the -176"
    ):
        gb.simulate(_pair(w0=5.0), t_end=1e-6, initial="static")
