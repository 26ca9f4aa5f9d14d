"""Gains that change with the position in the matrix of implicit methods."""

from __future__ import annotations

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.train.handles import FlangeHandle


class Hysteresis(gb.Block):
    """Bouc-Wen spring: k (a x + (1 - a) z), z' = v (1 - z^2 (b sign(v z) + c))."""

    a, b = gb.Flange("left end"), gb.Flange("right end")
    k: float = gb.param("stiffness", "N m/rad")
    z = gb.State("hysteretic part")

    def physics(self, s):
        v = s.b.w - s.a.w
        yield gb.Force(s.b.phi - s.a.phi, self_force := s.k * (0.4 * (s.b.phi - s.a.phi) + 0.6 * s.z))
        yield gb.Rate(s.z, v * (1 - s.z**2 * (0.5 * sp.sign(v * s.z) + 0.3)))
        yield gb.Shows("torque", self_force, "N m")


# -- shafts that follow others, and shafts without inertia ------------------------------------------------------------


class Cam(gb.Block):
    """phi_b = phi_a + sin(phi_a)/2."""

    a, b = gb.Flange("driving side"), gb.Flange("driven side")

    def physics(self, s):
        yield gb.Tie(s.b.phi - s.a.phi - sp.sin(s.a.phi) / 2)


# -- gains that change with the position ------------------------------------------------------------------------------


def in_a_row(*links: gb.Block) -> gb.Drivetrain:
    """Bodies with these links in between and springs to the ground at both ends."""
    rig = gb.Drivetrain("row")
    parts = [
        rig.add("ground0", gb.Fixed()),
        rig.add("spring0", gb.Shaft(k=6.0, c=0.2)),
        rig.add("body0", gb.Inertia(J=1.0)),
    ]
    for i, link in enumerate(links):
        parts += [rig.add(f"link{i}", link), rig.add(f"body{i + 1}", gb.Inertia(J=0.5 + 0.3 * i))]
    parts += [rig.add("spring1", gb.Shaft(k=9.0, c=0.1)), rig.add("ground1", gb.Fixed())]
    rig.chain(*parts)
    return rig


def test_a_cam_alone(check_whole):
    rig = gb.Drivetrain("cam")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("cam", Cam()), rig.add("b", gb.Inertia(J=2.0)))
    check_whole(rig)


@pytest.mark.long
@pytest.mark.parametrize(
    "external", [pytest.param(False, id="internal", marks=pytest.mark.long), pytest.param(True, id="external")]
)
def test_a_rigid_non_circular_pair_between_springs(check_whole, external):
    gear = gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.3), external=external, phase=0.4 + 0.3 * gb.sin(gb.time))
    check_whole(in_a_row(gb.Shaft(k=20.0, c=0.4), gear, gb.Lash(k=15.0, half_gap=0.1, c=0.2)))


@pytest.mark.long
def test_a_universal_joint_between_springs(check_whole):
    rig = in_a_row(
        gb.Shaft(k=20.0, c=0.4), gb.UniversalJoint(angle=0.7, phase=0.2), gb.Shaft(k=30.0), gb.Shaft(k=9.0, c=0.1)
    )
    assert check_whole(rig)[0] > 0  # of the springs, only those beside the driven fork are no kinematic states


@pytest.mark.long
def test_universal_joints_with_springs_and_without_any_between_them(check_whole):
    joint = gb.UniversalJoint(angle=0.5)
    check_whole(
        in_a_row(
            joint, gb.UniversalJoint(angle=0.6, phase=0.3), gb.Shaft(k=12.0, c=0.3), joint, gb.IdealGear(ratio=-1.5)
        )
    )


@pytest.mark.long
def test_two_non_circular_pairs_and_a_differential(check_whole):
    """Both side shafts of a differential through pairs with ratios that change, and springs across."""
    rig = gb.Drivetrain("two pairs")
    set_ = rig.add("set", gb.IdealPlanetary(ratio=-1.5))
    for i, flange in enumerate((set_.sun, set_.ring)):
        pair = rig.add(f"pair{i}", gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.2 + 0.1 * i), external=bool(i)))
        near, far = rig.add(f"near{i}", gb.Inertia(J=0.4 + 0.2 * i)), rig.add(f"far{i}", gb.Inertia(J=1.0 + i))
        rig.chain(far, rig.add(f"shaft{i}", gb.Shaft(k=20.0 + i, c=0.3)), near, pair)
        rig.connect(pair.b, flange)
        if i:
            across = rig.add("across", gb.Lash(k=9.0, half_gap=0.1, c=0.2))
            rig.connect(across.a, flange)
            rig.connect(across.b, far.a)
    out = rig.add("out", gb.Inertia(J=2.0))
    rig.connect(set_.carrier, out.a)
    load = rig.add("load", gb.Torque(tau=-0.4 * gb.sense("near0.w") * gb.sense("out.w") - gb.sense("out.phi")))
    rig.connect(load.flange, out.a)
    check_whole(rig)


class Crank(gb.Block):
    """phi = sin(z), z' = 2 w - z: a motion that is nonlinear in a state, which follows a shaft in turn."""

    a, b = gb.Flange("shaft that is read"), gb.Flange("shaft that is moved")
    z = gb.State("position", "rad")

    def physics(self, s):
        yield gb.Tie(s.b.phi - sp.sin(s.z))
        yield gb.Rate(s.z, 0.7 * sp.cos(s.z))


def test_a_motion_that_is_nonlinear_in_a_state(check_whole):
    rig = in_a_row(gb.Shaft(k=20.0, c=0.4), gb.Shaft(k=30.0, c=0.1))
    crank = rig.add("crank", Crank())
    rig.connect(crank.b, FlangeHandle(rig, "body1", "a"))
    rig.connect(crank.a, FlangeHandle(rig, "body0", "a"))
    check_whole(rig)


@pytest.mark.long
def test_a_cam_beside_a_damped_shaft_without_inertia_and_a_mesh_over_the_angle(check_whole):
    mesh = gb.GearMesh(
        teeth=(3, 4), external=True, r_base=(0.3, 0.4), k=80.0, c=1.0, stiffness_variation=gb.Fourier(cos=(0.2,)),
        transmission_error=gb.Harmonic(cos=(0.05,)),
    )  # fmt: skip
    rig = in_a_row(Cam(), mesh, Hysteresis(k=5.0), gb.UniversalJoint(angle=-0.4))
    one, two = rig.add("one", gb.Shaft(k=6.0, c=0.3)), rig.add("two", gb.Shaft(k=5.0, c=0.2))
    rig.connect(one.a, FlangeHandle(rig, "body1", "a"))
    rig.connect(one.b, two.a)
    rig.connect(two.b, FlangeHandle(rig, "body4", "a"))
    assert check_whole(rig)[1] == 1


@pytest.mark.long
def test_a_pair_on_a_carrier_that_turns_with_a_phase_behind_a_filter(check_whole):
    rig = gb.Drivetrain("carrier")
    law = gb.RatioLaw.segments(0.0887, 0.8143, 4.19)
    pair = rig.add("pair", gb.NonCircularGear(law=law, external=True, phase=gb.Input("phase"), filter=3.0))
    one, two, arm = (rig.add(n, gb.Inertia(J=j)) for n, j in (("one", 1.0), ("two", 0.5), ("arm", 2.0)))
    rig.connect(pair.a, one.a)
    rig.connect(pair.b, two.a)
    rig.connect(pair.carrier, arm.a)
    rig.chain(one, rig.add("across", gb.Shaft(k=5.0, c=0.1)), two, rig.add("beside", gb.Shaft(k=7.0)), arm)
    check_whole(rig)


@pytest.mark.long
def test_a_cam_beside_a_shaft_in_balance_between_springs_alone(check_whole):
    rig = in_a_row(Cam(), gb.Shaft(k=4.0))
    one, two = rig.add("one", gb.Shaft(k=6.0)), rig.add("two", gb.Shaft(k=5.0))
    rig.connect(one.a, FlangeHandle(rig, "body1", "a"))
    rig.connect(one.b, two.a)
    rig.connect(two.b, FlangeHandle(rig, "body0", "a"))
    assert check_whole(rig)[1] == 1


class Variator(gb.Block):
    """phi_b = u phi_a with a ratio that moves."""

    a, b = gb.Flange("driving side"), gb.Flange("driven side")
    u = gb.signal("ratio", "1")

    def physics(self, s):
        yield gb.Tie(s.b.phi - s.u * s.a.phi)


@pytest.mark.long
def test_gains_that_change_with_time_and_many_joints(check_whole):
    joints = [link for i in range(9) for link in (gb.UniversalJoint(angle=0.2 + 0.03 * i), gb.Shaft(k=5.0 + i, c=0.1))]
    check_whole(in_a_row(gb.Shaft(k=5.0), Variator(u=2 + 0.3 * gb.sin(gb.time)), *joints))
