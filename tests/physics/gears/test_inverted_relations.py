"""Rigid nonlinear relations known at either side: a non-circular pair or a universal joint that its second gear moves."""

import numpy as np
import pytest

import gearblocks as gb

ELLIPSE = gb.RatioLaw.ellipse(0.4632)
LINE = gb.RatioLaw.segments(0.7 / np.radians(240), 0.5, np.radians(240))
WAVES = gb.RatioLaw.from_function(1 + 0.3 * gb.sin(gb.driver_angle) + 0.1 * gb.cos(2 * gb.driver_angle))
T = np.linspace(0.0, 0.5, 101)


@pytest.mark.long
@pytest.mark.parametrize(
    "law",
    [
        pytest.param(ELLIPSE, id="ellipse"),
        pytest.param(LINE, id="line", marks=pytest.mark.long),
        pytest.param(WAVES, id="waves", marks=pytest.mark.long),
    ],
)
def test_two_rows_on_a_driven_carrier_whose_suns_are_both_gear_1(law):
    """Sun 1 at rest, planets of two rows, sun 2 the output: chi = F^-1(F(beta) - planet against carrier)."""
    beta, w = np.radians(90), 20.0
    rig = gb.Drivetrain("double row")
    drive, fixed = rig.add("drive", gb.Speed(w=w)), rig.add("fixed", gb.Fixed())
    planet, out = rig.add("planet", gb.Inertia(J=0.02)), rig.add("out", gb.Inertia(J=0.05))
    first = rig.add("first", gb.NonCircularGear(law=law, external=True))
    second = rig.add("second", gb.NonCircularGear(law=law, external=True, phase=beta))
    rig.connect(drive.flange, first.carrier, second.carrier)
    rig.connect(fixed.flange, first.a)
    rig.connect(first.b, planet.a, second.b)
    rig.connect(second.a, out.a)
    run = gb.simulate(rig, t=T, rtol=1e-9)
    carrier = w * T
    turned = -law.F(-carrier)  # planet against carrier
    chi = law.inverse(law.F(beta) - turned)
    assert np.abs(run["planet.phi"] - carrier - turned).max() < 1e-12
    assert np.abs(run["out.phi"] - (carrier + chi - beta)).max() < 1e-12
    assert np.abs(run["out.w"] - w * (1 - law.m(-carrier) / law.m(chi))).max() < 1e-10 * w


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "external"),
    [
        pytest.param(LINE, True, id="line-external"),
        pytest.param(LINE, False, id="line-internal", marks=pytest.mark.long),
        pytest.param(WAVES, True, id="waves-external", marks=pytest.mark.long),
        pytest.param(WAVES, False, id="waves-internal"),
    ],
)
@pytest.mark.few(1)
def test_a_pair_driven_at_gear_2(law, external):
    sign = 1 if external else -1
    rig = gb.Drivetrain("driven at b")
    drive, body = rig.add("drive", gb.Speed(w=20.0)), rig.add("body", gb.Inertia(J=0.02))
    pair = rig.add("pair", gb.NonCircularGear(law=law, external=external, phase=0.4))
    rig.connect(drive.flange, pair.b)
    rig.connect(pair.a, body.a)
    run = gb.simulate(rig, t=T, rtol=1e-9)
    theta = law.inverse(law.F(0.4) - sign * 20.0 * T)
    assert np.abs(run["body.phi"] - (theta - 0.4)).max() < 1e-12
    assert np.abs(run["body.w"] + sign * 20.0 / law.m(theta)).max() < 1e-10 * 20.0
    # J w' = -m M on a, and M acts on b
    rate = -law.dm(theta) / law.m(theta) ** 2 * (20.0 / law.m(theta)) * 20.0
    away = np.abs(run["pair.torque"]) > 0  # torque on b: -sign J w'/m
    assert away.any()
    smooth = np.abs(law.dm(theta, 2)) < 1e3
    wanted = 0.02 * rate / law.m(theta)
    assert np.abs(np.abs(run["pair.torque"]) - np.abs(wanted))[smooth].max() < 1e-8 * np.abs(wanted).max()


STEEP = gb.RatioLaw.segments(0.4, 0.3, np.radians(200))


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("law", [LINE, STEEP, WAVES], ids=["line", "steep", "waves"])
@pytest.mark.few(1)
def test_the_work_of_a_motion_that_is_wholly_prescribed(law, method):
    """No state sets the steps, and laws with joints tend to infinity beyond them: the drive gives what the bodies gain."""
    rig = gb.Drivetrain("prescribed")
    drive, body, more = rig.add("drive", gb.Speed(w=20.0)), rig.add("body", gb.Inertia(J=0.02)), gb.Inertia(J=0.07)
    pair, again = (rig.add(name, gb.NonCircularGear(law=law, external=True, phase=0.4)) for name in ("pair", "again"))
    more = rig.add("more", more)
    rig.connect(drive.flange, pair.b)
    rig.connect(pair.a, body.a)
    rig.connect(body.b, again.b)
    rig.connect(again.a, more.a)
    one = law.inverse(law.F(0.4) - 20.0 * T)
    two = law.inverse(law.F(0.4) - (one - 0.4))
    w = -20.0 / law.m(one)
    gained = np.ptp((0.01 * w**2 + 0.035 * (w / law.m(two)) ** 2)[[0, -1]])
    model = gb.build(rig)
    for rtol in (1e-4, 1e-6, 1e-9):
        run = gb.simulate(model, t=T, rtol=rtol, method=method)
        assert run.energy.residual <= 10 * rtol
        assert abs(run.energy.supplied["drive"]) == pytest.approx(gained, abs=10 * rtol * run.energy.turnover)
        assert run["more.w"][-1] == pytest.approx((-w / law.m(two))[-1], rel=1e-9)


@pytest.mark.long
def test_a_pair_whose_gear_2_is_held_while_its_carrier_coasts():
    rig = gb.Drivetrain("held at b")
    carrier, body = rig.add("carrier", gb.Inertia(J=1.0, w0=10.0)), rig.add("body", gb.Inertia(J=0.2))
    pair, fixed = rig.add("pair", gb.NonCircularGear(law=ELLIPSE, external=True)), rig.add("fixed", gb.Fixed())
    rig.connect(carrier.a, pair.carrier)
    rig.connect(pair.a, body.a)
    rig.connect(pair.b, fixed.flange)
    run = gb.simulate(rig, t=T, rtol=1e-10)
    turned = run["carrier.phi"]
    assert np.abs(run["body.phi"] - (turned + ELLIPSE.inverse(turned))).max() < 1e-12
    energy = 0.5 * run["carrier.w"] ** 2 + 0.1 * run["body.w"] ** 2
    assert np.ptp(energy) < 1e-8 * energy[0]


def test_a_universal_joint_driven_at_its_second_fork():
    rig = gb.Drivetrain("joint")
    drive, body = rig.add("drive", gb.Speed(w=20.0)), rig.add("body", gb.Inertia(J=0.02))
    joint = rig.add("joint", gb.UniversalJoint(angle=0.6, phase=0.3))
    rig.connect(drive.flange, joint.b)
    rig.connect(joint.a, body.a)
    run = gb.simulate(rig, t=T, rtol=1e-9)
    a, b = run["body.phi"] + 0.3, run["drive.flange.phi"] + 0.3
    assert np.abs(np.cos(0.6) * np.sin(b) * np.cos(a) - np.sin(a) * np.cos(b)).max() < 1e-13


@pytest.mark.long
def test_two_universal_joints_back_to_back_undo_each_other():
    rig = gb.Drivetrain("joints")
    drive, middle, out = (
        rig.add("drive", gb.Speed(w=20.0)),
        *(rig.add(n, gb.Inertia(J=0.02)) for n in ("middle", "out")),
    )
    one, two = (rig.add(n, gb.UniversalJoint(angle=0.6)) for n in ("one", "two"))
    rig.connect(drive.flange, one.a)
    rig.connect(one.b, middle.a)
    rig.connect(middle.b, two.b)
    rig.connect(two.a, out.a)
    assert np.abs(gb.simulate(rig, t=T, rtol=1e-9)["out.phi"] - 20.0 * T).max() < 1e-13 * 10.0


def test_a_motion_that_is_prescribed_at_both_gears_is_refused_by_name():
    rig = gb.Drivetrain("twice")
    a, b = rig.add("left", gb.Speed(w=20.0)), rig.add("right", gb.Speed(w=20.0))
    pair = rig.add("pair", gb.NonCircularGear(law=ELLIPSE, external=False))
    rig.connect(a.flange, pair.a)
    rig.connect(b.flange, pair.b)
    with pytest.raises(gb.ModelError, match="both prescribe the motion of one shaft"):
        gb.build(rig)


@pytest.mark.long
@pytest.mark.parametrize("gone", [pytest.param(["shaft_0"], marks=pytest.mark.long), ["shaft_0", "shaft_1", "shaft_2"]])
def test_start_angles_behind_a_rigid_shaft_follow_the_motion_that_drives_it(gone):
    from models import noncircular_cvt

    rig = noncircular_cvt.build().without(*(f"{name}.compliance" for name in gone))
    assert "branch_0.phi0" in rig.dropped
    run = gb.simulate(rig, t_end=1e-3, watch=False)
    angle, delta = 262.0 * run.t + (noncircular_cvt.X - np.radians(60)) / 2, np.radians(60)
    law = noncircular_cvt.LAW
    speed = 262.0 * (law.m(angle + delta) - law.m(angle))
    assert np.abs(run["branch_0.w"] - speed).max() < 1e-9 * np.abs(speed).max()


@pytest.mark.long
def test_start_angles_behind_a_rigid_gear_follow_the_first_body():
    rig = gb.Drivetrain("geared")
    one, two = rig.add("one", gb.Inertia(J=1.0, phi0=0.3)), rig.add("two", gb.Inertia(J=1.0, phi0=-0.2))
    rig.chain(one, rig.add("shaft", gb.Shaft(k=100.0)), rig.add("gear", gb.IdealGear(ratio=2)), two)
    rigid = rig.without("shaft.compliance")
    assert "two.phi0" in rigid.dropped
    assert gb.simulate(rigid, t_end=0.1)["two.phi"][0] == pytest.approx(0.15, rel=1e-12)
    assert gb.simulate(rig, t_end=0.1)["two.phi"][0] == pytest.approx(-0.2, rel=1e-12)
