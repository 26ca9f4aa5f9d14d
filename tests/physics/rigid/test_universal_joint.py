"""Universal joints: the constraint of the cross, energy, pairs of joints."""

import numpy as np
import pytest

import gearblocks as gb

NEAR = 1e-9  # tens of steps at rtol 1e-11


def _chain(**blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("driveline")
    rig.chain(*(rig.add(part, block) for part, block in blocks.items()))
    return rig


@pytest.mark.parametrize("phase", [None, 0.4])
@pytest.mark.parametrize(
    "angle", [0.0, 0.3, pytest.param(-0.3, marks=pytest.mark.long), pytest.param(1.2, marks=pytest.mark.long)]
)
@pytest.mark.few(1)
def test_the_tie_of_a_universal_joint_is_that_of_its_cross(angle, phase):
    import sympy as sp

    from gearblocks.laws.symbols import Pool, Symbols

    joint = gb.UniversalJoint(angle=angle, phase=phase)
    s = Symbols(joint, Pool(), frozenset())
    zero = next(x.zero for x in joint.physics(s) if isinstance(x, gb.Tie))
    own = {s.angle: angle, **({} if phase is None else {s.phase: phase})}
    driven = sp.lambdify(s.a.phi, sp.solve(zero.subs(own), s.b.phi)[0])
    at = np.linspace(-20.0, 20.0, 4001)
    shifted, turned = at + (phase or 0.0), np.array([driven(x) for x in at])
    cross = np.unwrap(np.arctan2(np.sin(shifted), np.cos(angle) * np.cos(shifted)))
    assert np.ptp(turned + (phase or 0.0) - cross) < 1e-12  # a whole number of turns apart at most
    assert (np.diff(turned) > 0).all()


@pytest.mark.parametrize("phase", [pytest.param(None, marks=pytest.mark.long), 0.7])
def test_two_bodies_on_a_universal_joint_swap_energy_along_its_ratio(phase, distance):
    angle, J_a, J_b, w0 = 0.6, 0.1, 0.5, 30.0
    joint = gb.UniversalJoint(angle=angle, phase=phase)
    rig = _chain(a=gb.Inertia(J=J_a, w0=w0), joint=joint, b=gb.Inertia(J=J_b))
    run = gb.simulate(rig, t=np.linspace(0, 3, 301), rtol=1e-11)
    at = run["a.phi"] + (phase or 0.0)
    ratio = np.cos(angle) / (1 - np.sin(angle) ** 2 * np.cos(at) ** 2)
    assert distance(run["b.w"], ratio * run["a.w"]) < 1e-13  # rounding
    whole = J_a + J_b * ratio**2  # free: whole w_a^2 keeps its value
    assert distance(run["a.w"], w0 * np.sqrt(whole[0] / whole)) < NEAR  # hundreds of steps
    assert distance(run["joint.torque"], J_b * run["b.alpha"]) < 1e-12
    largest = np.abs(run["joint.a.power"]).max()
    assert np.abs(run["joint.a.power"] + run["joint.b.power"]).max() < 1e-12 * largest
    assert run.energy.residual < 1e-10


@pytest.mark.long
def test_two_universal_joints_a_quarter_turn_apart_pass_the_speed_on_evenly():
    rig = _chain(
        drive=gb.Speed(w=10.0), a=gb.Inertia(J=0.1), first=gb.UniversalJoint(angle=0.6), tube=gb.Inertia(J=0.02),
        second=gb.UniversalJoint(angle=0.6, phase=np.pi / 2), b=gb.Inertia(J=0.5),
    )  # fmt: skip
    run = gb.simulate(rig, t=np.linspace(0, 3, 301), rtol=1e-9)
    assert np.ptp(run["b.w"]) < 1e-12
    assert run["tube.w"].max() == pytest.approx(10.0 / np.cos(0.6), rel=1e-3)  # sampled
    assert run["tube.w"].min() == pytest.approx(10.0 * np.cos(0.6), rel=1e-3)


@pytest.mark.long
def test_a_universal_joint_at_angle_zero_is_a_rigid_shaft():
    rig = _chain(drive=gb.Torque(tau=3.0), a=gb.Inertia(J=0.1), joint=gb.UniversalJoint(angle=0.0), b=gb.Inertia(J=0.5))
    run = gb.simulate(rig, t=[2.0], rtol=1e-9)
    assert run["b.w"][0] == pytest.approx(10.0, rel=1e-13)
