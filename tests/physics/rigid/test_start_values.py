"""Start values that rigid constraints, prescribed motion and balance give or refuse."""

import pytest

import gearblocks as gb


def _paced(**start: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("paced")
    drive, disc = rig.add("drive", gb.Speed(w=2.0 + gb.sin(gb.time))), rig.add("disc", gb.Inertia(J=2.0, **start))
    rig.connect(drive.flange, disc.a)
    return rig


def test_a_start_speed_that_a_prescribed_speed_contradicts_is_refused() -> None:
    with pytest.raises(gb.ModelError, match=r"'disc': w0 = 0.3, but 'drive' moves it: 2 at t = 0; leave w0 out"):
        gb.build(_paced(w0=0.3))
    run = gb.simulate(_paced(w0=2.0, phi0=0.5), t_end=0.1)
    assert (run["disc.w"][0], run["disc.phi"][0]) == (2.0, 0.5)


def test_start_values_on_a_shaft_whose_angle_is_prescribed_must_be_those_that_it_has() -> None:
    """Relative to its housing, the motor starts at 0 with 2 rad/s: the housing takes over what the shaft is given."""
    rig = gb.Drivetrain("told")
    drive, shaft = rig.add("drive", gb.Angle(phi=2 * gb.time)), rig.add("shaft", gb.Inertia(J=1.0, phi0=0.3, w0=5.0))
    rig.connect(drive.flange, shaft.a)
    with pytest.raises(gb.ModelError, match=r"'shaft': w0 = 5.0, but 'drive' moves it: 2 at t = 0; leave w0 out"):
        gb.build(rig)
    rig.connect(drive.housing, rig.add("stator", gb.Inertia(J=4.0)).a)
    run = gb.simulate(rig, t_end=0.1)
    start = [run[name][0] for name in ("shaft.phi", "shaft.w", "stator.phi", "stator.w")]
    assert start == pytest.approx([0.3, 5.0, 0.3, 3.0], abs=1e-14)


def test_the_angle_that_springs_give_a_shaft_without_inertia_cannot_be_given_otherwise() -> None:
    rig = gb.Drivetrain("row")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=1.0, phi0=0.3))
    left, right = rig.add("left", gb.Shaft(k=100.0)), rig.add("right", gb.Shaft(k=200.0))
    node = rig.add("node", gb.Inertia(J=0.0, phi0=0.1))
    rig.chain(one, left, node, right, two)
    with pytest.raises(
        gb.ModelError, match=r"'node': phi0 = 0.1, but the balance of torques .* holds it: 0.2 at t = 0"
    ):
        gb.build(rig)
    assert gb.simulate(rig.set({"node.phi0": 0.2}), t_end=0.01)["node.phi"][0] == pytest.approx(0.2, abs=1e-15)


@pytest.mark.long
def test_start_values_that_nobody_gives_follow_from_given_ones_through_ties_and_prescribed_speeds() -> None:
    """Sun and ring turn as given; the carrier, driven 3 rad/s faster than the arm, takes the arm along."""
    rig = gb.Drivetrain("arm")
    planet, drive = rig.add("planet", gb.IdealPlanetary(ratio=2.0)), rig.add("drive", gb.Speed(w=3.0))
    sun, ring = (
        rig.add("sun", gb.Inertia(J=1.0, phi0=0.3, w0=4.0)),
        rig.add("ring", gb.Inertia(J=1.0, phi0=0.9, w0=7.0)),
    )
    carrier, arm = rig.add("carrier", gb.Inertia(J=0.0)), rig.add("arm", gb.Inertia(J=0.0))
    rig.connect(planet.sun, sun.a)
    rig.connect(planet.ring, ring.a)
    rig.connect(planet.carrier, carrier.a, drive.flange)
    rig.connect(drive.housing, arm.a)
    run = gb.simulate(rig, t_end=0.1)
    start = {
        name: run[name][0] for name in ("sun.w", "ring.w", "carrier.w", "arm.w", "sun.phi", "ring.phi", "carrier.phi")
    }
    assert start == pytest.approx({  # carrier = (sun + 2 ring)/3; to rounding
        "sun.w": 4.0, "ring.w": 7.0, "carrier.w": 6.0, "arm.w": 3.0, "sun.phi": 0.3, "ring.phi": 0.9, "carrier.phi": 0.7,
    }, abs=1e-14)  # fmt: skip
    with pytest.raises(gb.ModelError, match=r"w0 = 4\.0, but 'drive' moves it"):
        gb.build(rig.set({"arm.w0": 5.0}))
