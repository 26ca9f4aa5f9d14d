"""Loss of contact: shares of time and of revolutions, closings; of motions that are given."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

TURN = 2 * np.pi


@pytest.fixture(scope="module")
def run() -> gb.Trajectory:
    """A lash whose ends move by sin t against each other, half gap 0.5; beside it a shaft of angle t + 0.5 sin t."""
    rig, drive = gb.Drivetrain("given"), gb.Parameter("drive", 1.0, "rad/s")
    shake = rig.add("shake", gb.Angle(phi=gb.sin(drive * gb.time)))
    rig.chain(shake, rig.add("lash", gb.Lash(k=10.0, half_gap=0.5)), rig.add("ground", gb.Fixed()))
    turn = rig.add("turn", gb.Speed(w=1 + 0.5 * gb.cos(drive * gb.time)))
    rig.chain(turn, rig.add("shaft", gb.Inertia(J=1.0)))
    return gb.simulate(rig, t=[0.0, 3 * TURN], max_step=0.1)


def test_shares_are_those_of_the_given_motion_though_nothing_was_sampled(run: gb.Trajectory) -> None:
    found = gb.contact_loss(run, "lash", angle="shaft.phi", section=gb.stroboscopic("drive"))
    opens = np.arcsin(0.5)
    assert found.time_share == pytest.approx(2 * opens / np.pi, abs=1e-9)
    assert found.closings == pytest.approx([opens + k * np.pi for k in range(6)], abs=1e-8)
    assert found.per_period == pytest.approx(2.0)
    assert found.free[[0, 1, -1]] == pytest.approx(
        np.array([[0, opens], [np.pi - opens, np.pi + opens], [3 * TURN - opens, 3 * TURN]]), abs=1e-8
    )
    # free from pi k - opens to pi k + opens: the shaft turns by 2 opens + (-1)^k sin(opens) there
    assert found.turn_share == pytest.approx(4 * opens / TURN, abs=1e-8)
    assert "of the revolutions; contact is made 6 times (2 in a period)" in repr(found)
    assert gb.count("lash", "contact_made").of(run) == 6.0
    assert gb.count(kind="contact_lost", before=TURN).of(run) == 2.0
    assert gb.event_time("lash", "contact_lost", number=1).of(run) == pytest.approx(TURN - opens, abs=1e-8)


def test_a_window_counts_what_lies_in_it(run: gb.Trajectory) -> None:
    found = gb.contact_loss(run, "lash", angle="shaft.phi", after=0.0, before=np.pi / 2)
    opens = np.arcsin(0.5)
    assert found.time_share == pytest.approx(2 * opens / np.pi, abs=1e-9) and len(found.closings) == 1
    assert found.turn_share == pytest.approx((opens + 0.25) / (np.pi / 2 + 0.5), abs=1e-8)
    within = gb.contact_loss(run, "lash", after=1.0, before=2.0)
    assert within.time_share == 0.0 and not len(within.closings) and within.turn_share is None


def test_points_of_a_table_are_no_losses_of_contact_in_a_study() -> None:
    rig, x = gb.Drivetrain("rattle"), np.linspace(0, 1, 9)
    cycle = gb.Table(x, 0.1 * np.cos(2 * np.pi * x), periodic=True)
    mesh = gb.GearMesh(teeth=(23, 41), module=3e-3, pressure_angle=0.35, external=True, k=2e8, damping_ratio=0.05,
                       stiffness_variation=cycle, backlash=gb.Backlash(half_gap=5e-5))  # fmt: skip
    shake = gb.Torque(tau=10 + gb.Parameter("shake", 30.0, "N m") * gb.sin(900 * gb.time))
    pinion, wheel = gb.Inertia(J=1e-3, w0=100.0), gb.Inertia(J=5e-3, w0=-100 * 23 / 41)
    rig.chain(rig.add("drive", shake), rig.add("pinion", pinion), rig.add("mesh", mesh), rig.add("wheel", wheel))
    asked = [gb.count("mesh", kind) for kind in ("state", "contact_made", "contact_lost")]
    study = gb.sweep(rig, {"shake": [0.0, 30.0]}, quantity=asked, t_end=0.02)
    for shaken, (events, made, lost) in zip(study.points[:, 0], study.values, strict=True):
        found = gb.contact_loss(gb.simulate(rig, t_end=0.02, parameters={"shake": shaken}), "mesh")
        assert events > made + lost + 20 and made == len(found.closings)
        assert abs(made - lost) <= 1
    assert study.values[1, 2] > 5


@pytest.mark.long
def test_impacts_of_a_rigid_stop_close_it(tmp_path: Path) -> None:
    rig = gb.Drivetrain("bounce")
    ball, wall = rig.add("ball", gb.Mass(m=1.0, s0=1.0)), rig.add("wall", gb.HardStop(lower=0.0, restitution=0.5))
    rig.chain(rig.add("weight", gb.Force(f=-9.81)), ball, wall)
    run = gb.simulate(rig, t_end=1.2, rtol=1e-9)  # falls for 0.4515 s, then flies for 0.4515, 0.2258 s
    found = gb.contact_loss(run, "wall")
    fall = np.sqrt(2 / 9.81)
    assert found.closings == pytest.approx([fall, 2 * fall, 2.5 * fall], rel=1e-7) and found.time_share == 1.0
    assert gb.count("wall", "contact_made").of(run) == 3.0 and gb.count("wall", "contact_lost").of(run) == 0.0
    run.save(tmp_path / "run.nc")
    assert gb.contact_loss(gb.Trajectory.load(tmp_path / "run.nc"), "wall").closings == pytest.approx(found.closings)


def test_what_has_no_contact_is_refused_by_name(run: gb.Trajectory) -> None:
    with pytest.raises(gb.UnknownNameError, match=r"'lsh' has no output 'contact'; lash has .* did you mean 'lash'"):
        gb.contact_loss(run, "lsh")
    with pytest.raises(gb.UnknownNameError, match=r"there is no output 'shaft\.angle'"):
        gb.contact_loss(run, "lash", angle="shaft.angle")
    with pytest.raises(gb.ParameterError, match="does not turn in the window"):
        gb.contact_loss(run, "lash", angle="ground.flange.phi")
