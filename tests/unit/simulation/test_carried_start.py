"""The start of a train without some effects is the state of the full train."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.simulation.carried_start import carried_start
from models import noncircular_cvt, planetary_backlash, spline_coupling


def _whine() -> gb.Drivetrain:
    """A loaded pair behind a shaft."""
    w = gb.rpm(1500)
    rig = gb.Drivetrain("loaded pair")
    mesh = gb.GearMesh(
        teeth=(29, 37), module=2.5e-3, pressure_angle=0.35, external=True, k=2e8, damping_ratio=0.05,
        backlash=gb.Backlash(half_gap=60e-6), transmission_error=gb.Harmonic(cos=(5e-6,)),
    )  # fmt: skip
    pinion, wheel = rig.add("pinion", gb.Inertia(J=8e-4, w0=w)), rig.add("wheel", gb.Inertia(J=0.02, w0=-w * 29 / 37))
    engine, shaft = rig.add("engine", gb.Speed(w=w)), rig.add("shaft", gb.Shaft(k=3e4, damping_ratio=0.02))
    rig.chain(engine, shaft, pinion, rig.add("mesh", mesh), wheel, rig.add("load", gb.Torque(tau=150.0)))
    return rig


def _first(train: gb.Drivetrain, initial: object, t_start: float = 0.0) -> gb.Trajectory:
    return gb.simulate(train, t=[t_start], t_start=t_start, initial=initial)


def _carried(full: gb.Drivetrain, *gone: str, initial: object = None) -> tuple[object, gb.Trajectory]:
    variant = full.without(*gone)
    found = carried_start(gb.build(full), gb.build(variant), initial)
    return found, _first(variant, found, initial.t[-1] if isinstance(initial, gb.Trajectory) else 0.0)


def test_a_start_that_serves_both_trains_stays_as_it_is() -> None:
    found, _ = _carried(spline_coupling.build(), "spline.damping")
    assert found is None


@pytest.mark.long
def test_shafts_that_become_one_keep_their_momentum() -> None:
    rig = gb.Drivetrain("two discs")
    left, right = rig.add("left", gb.Inertia(J=2.0, w0=3.0)), rig.add("right", gb.Inertia(J=1.0, w0=-1.5))
    rig.chain(left, rig.add("shaft", gb.Shaft(k=100.0)), rig.add("gear", gb.IdealGear(ratio=-2)), right)
    _, start = _carried(rig, "shaft.compliance")
    # phi_left = -2 phi_right: L = J_l w_l - J_r w_r/2 stays
    assert start["left.w"][0] == pytest.approx((2.0 * 3.0 + 1.5 / 2) / (2.0 + 1.0 / 4), rel=1e-14)
    assert start["right.w"][0] == pytest.approx(-start["left.w"][0] / 2, rel=1e-14)


@pytest.mark.long
def test_the_deflections_that_are_left_keep_their_forces() -> None:
    full = spline_coupling.build()
    _, start = _carried(full, "shaft_in.compliance")
    assert start["spline.force"][0] == pytest.approx(_first(full, None)["spline.force"][0], rel=1e-12)
    assert start["shaft_out.torque"][0] == pytest.approx(2600.0, rel=1e-12)


@pytest.mark.long
def test_meshes_in_a_loop_keep_their_forces_when_the_mount_of_the_ring_becomes_rigid() -> None:
    full = planetary_backlash.build()
    _, start = _carried(full, "mount.*")
    meshes = [f"{place}_mesh{i}.force" for place in ("sun", "ring") for i in range(4)]
    before = _first(full, None)
    assert [start[m][0] for m in meshes] == pytest.approx([before[m][0] for m in meshes], rel=1e-10)


@pytest.mark.long
def test_a_branch_of_the_cvt_on_a_rigid_shaft_starts_as_the_ties_ask_and_the_others_as_before() -> None:
    full = noncircular_cvt.build()
    _, start = _carried(full, "shaft_0.compliance")
    before = _first(full, None)
    for name in ("output.w", "branch_1.w", "branch_2.w", "shaft_1.torque", "shaft_2.torque"):
        assert start[name][0] == pytest.approx(before[name][0], rel=1e-12, abs=1e-12)


@pytest.mark.long
def test_a_static_start_is_asked_of_the_variant_where_it_has_one() -> None:
    found, start = _carried(_whine(), "shaft.compliance", initial="static")
    assert found == "static"
    assert start["mesh.contact"][0] == 1.0


@pytest.mark.long
def test_static_values_of_the_full_train_serve_where_the_variant_has_none() -> None:
    rig = gb.Drivetrain("on a weak spring")
    spring = gb.Shaft(torque=gb.sin(gb.twist), hysteresis=gb.Hysteresis(friction=2.0))
    load, disc = rig.add("load", gb.Torque(tau=1.5)), rig.add("disc", gb.Inertia(J=0.1, phi0=0.2))
    rig.chain(rig.add("ground", gb.Fixed()), rig.add("spring", spring), disc, load)
    found, start = _carried(rig, "spring.hysteresis", initial="static")
    assert found != "static"
    assert start["spring.twist"][0] == _first(rig, "static")["spring.twist"][0] != 0


@pytest.mark.long
def test_an_earlier_run_goes_on_with_what_is_stuck_still_stuck() -> None:
    rig = gb.Drivetrain("held ring")
    discs = [
        rig.add(name, gb.Inertia(J=J)) for name, J in (("sun", 0.1), ("ring", 0.2), ("carrier", 0.3), ("load", 0.4))
    ]
    gear = rig.add("gear", gb.IdealPlanetary(ratio=2.0))
    for disc, flange in zip(discs, (gear.sun, gear.ring, gear.carrier), strict=False):
        rig.connect(disc.a, flange)
    rig.connect(rig.add("drive", gb.Torque(tau=1.0)).flange, discs[0].b)
    rig.connect(rig.add("brake", gb.Brake(capacity=50.0)).a, discs[1].b)
    rig.chain(discs[2], rig.add("shaft", gb.Shaft(k=200.0)), discs[3])
    run = gb.simulate(rig, t_end=0.37)
    found, start = _carried(rig, "shaft.*", initial=run)
    assert isinstance(found, gb.Trajectory)
    assert start["brake.mode"][0] == 0.0
    before, after = (
        sum(J * x["carrier.w" if i else "load.w"][-1] for i, J in ((1, 0.3 + 9 * 0.1), (0, 0.4))) for x in (run, start)
    )
    assert after == pytest.approx(before, rel=1e-12)
    assert start["sun.w"][0] == pytest.approx(3.0 * start["load.w"][0], rel=1e-12)


@pytest.mark.long
def test_states_of_blocks_are_carried() -> None:
    rig = gb.Drivetrain("governed motor")
    drive = rig.add("drive", gb.Torque(tau=20.0 * gb.sense("governor.command")))
    rotor = rig.add("rotor", gb.Inertia(J=0.1))
    governor = rig.add("governor", gb.Governor(target=100.0, gain=0.05, integral_gain=0.1))
    bearing = rig.add("bearing", gb.BearingFriction(coulomb=0.1, viscous=0.01))
    rig.chain(drive, rotor, governor)
    rig.connect(bearing.a, rotor.b)
    run = gb.simulate(rig, t_end=0.5)
    _, start = _carried(rig, "bearing.viscous", initial=run)
    assert start["governor.command"][0] == run["governor.command"][-1] != 0
    assert np.array_equal(start["rotor.w"], run["rotor.w"][-1:])


@pytest.mark.long
def test_a_lossy_gear_behind_a_new_tie_starts_as_its_ratio_says() -> None:
    rig = gb.Drivetrain("lossy reduction")
    motor, pinion = rig.add("motor", gb.Inertia(J=0.3, w0=8.0)), rig.add("pinion", gb.Inertia(J=0.1, w0=0.0))
    wheel, load = rig.add("wheel", gb.Inertia(J=0.4)), rig.add("load", gb.Torque(tau=-1.0))
    gear = rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8)))
    rig.chain(motor, rig.add("shaft", gb.Shaft(k=100.0)), pinion, gear, wheel, load)
    _, start = _carried(rig, "shaft.compliance")
    assert start["motor.w"][0] == pytest.approx(0.3 * 8.0 / (0.3 + 0.1 + 0.4 / 4), rel=1e-12)
    assert start["wheel.w"][0] == pytest.approx(start["motor.w"][0] / 2, rel=1e-12)


@pytest.mark.long
def test_what_went_with_an_effect_and_what_does_not_run_are_told_apart() -> None:
    rig = _whine()
    rigid = rig.without("mesh.*")
    with pytest.raises(gb.UnknownNameError, match="dynamic_transmission_error"):
        gb.simulate(rigid, t_end=0.01, outputs="mesh.dynamic_transmission_error")
    assert "mesh.dynamic_transmission_error" in gb.build(rig).program.output_numbers
    rig.connect(rig.add("sensing", gb.Torque(tau=1e-3 * gb.sense("mesh.deflection"))).flange, rig["wheel"].b)
    with pytest.raises(gb.ModelError, match=r"mesh\.deflection"):
        gb.build(rig.without("mesh.*"))


def test_a_gap_that_was_pressed_together_starts_closed_once_it_is_rigid() -> None:
    rig = gb.Drivetrain("pressed gap")
    left, right = rig.add("left", gb.Inertia(J=2.0, phi0=0.3)), rig.add("right", gb.Inertia(J=1.0, w0=0.5))
    gap = gb.Lash(k=100.0, half_gap=0.05, contact_damping=gb.HuntCrossley(restitution=0.7), phi_rel0=0.07, w_rel0=0.2)
    rig.chain(left, rig.add("gap", gap), right)
    _, start = _carried(rig, "gap.compliance")
    assert start["right.phi"][0] - start["left.phi"][0] == pytest.approx(0.05, rel=1e-12)
    assert 2 * start["left.phi"][0] + start["right.phi"][0] == pytest.approx(2 * 0.3 + 0.37, rel=1e-12)
    assert [start["left.w"][0], start["right.w"][0]] == pytest.approx([0.3, 0.5], rel=1e-12)


def test_a_lossy_gear_behind_a_ratio_that_moves_starts_as_both_say() -> None:
    rig = gb.Drivetrain("moving phase")
    law = gb.RatioLaw.ellipse(e=0.3, order=2)
    pair = gb.NonCircularGear(law=law, external=False, k=300.0, c=0.2, phase=0.3 * gb.sin(5.0 * gb.time))
    driver, wheel = rig.add("driver", gb.Inertia(J=1.4, w0=-5.0)), rig.add("wheel", gb.Inertia(J=0.4, w0=-1.0))
    gear, load = rig.add("gear", gb.LossyGear(ratio=-2.0, efficiency=(0.8, 0.6))), rig.add("load", gb.Inertia(J=0.1))
    rig.chain(driver, rig.add("pair", pair), wheel, rig.add("shaft", gb.Shaft(k=50.0)), gear, load)
    _, start = _carried(rig, "pair.compliance", "shaft.compliance")
    assert start["wheel.w"][0] == pytest.approx(-2 * start["load.w"][0], rel=1e-9)
    assert abs(start["wheel.w"][0]) > 0.1
