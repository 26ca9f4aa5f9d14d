"""Prescribed motion: kept exactly, its power supplied, and what no torque can follow is refused."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb


def test_a_prescribed_speed_is_kept_exactly_and_its_power_is_supplied() -> None:
    rig = gb.Drivetrain("test rig")
    drive = rig.add("drive", gb.Speed(w=10 + 3 * sp.sin(5 * gb.time)))
    flywheel, shaft, load = (
        rig.add("flywheel", gb.Inertia(J=0.7)),
        rig.add("shaft", gb.Shaft(k=100.0, c=0.5)),
        rig.add("load", gb.Inertia(J=0.2, w0=10.0)),
    )
    rig.connect(drive.flange, flywheel.a)
    rig.chain(flywheel, shaft, load)
    run = gb.simulate(rig, t_end=2.0, rtol=1e-10)
    t = run.t
    assert np.abs(run["flywheel.w"] - (10 + 3 * np.sin(5 * t))).max() < 1e-13
    assert np.abs(run["flywheel.phi"] - (10 * t + 0.6 * (1 - np.cos(5 * t)))).max() < 1e-9  # integrated along
    reaction = 0.7 * 15 * np.cos(5 * t) - run["shaft.a.tau"]
    assert np.abs(run["drive.torque"] - reaction).max() < 1e-10 * np.abs(reaction).max()
    assert abs(run.energy.residual) < 1e-9


def test_a_prescribed_angle_is_kept_exactly() -> None:
    rig = gb.Drivetrain("shaker")
    drive = rig.add("drive", gb.Angle(phi=0.1 * sp.sin(5 * gb.time)))
    shaft, load = rig.add("shaft", gb.Shaft(k=100.0, c=0.5)), rig.add("load", gb.Inertia(J=0.2))
    rig.connect(drive.flange, shaft.a)
    rig.connect(shaft.b, load.a)
    run = gb.simulate(rig, t=np.linspace(0, 2, 41), rtol=1e-11)
    assert np.abs(run["drive.flange.phi"] - 0.1 * np.sin(5 * run.t)).max() < 1e-15
    assert np.abs(run["shaft.twist"] - (run["load.phi"] - run["drive.flange.phi"])).max() < 1e-11
    assert abs(run.energy.residual) < 1e-10


BUMPS = {
    "a bump": (gb.exp(-(((gb.time - 0.5) / 0.01) ** 2)), lambda t: np.exp(-(((t - 0.5) / 0.01) ** 2))),
    "a late bump": (gb.exp(-(((gb.time - 17) / 0.01) ** 2)), lambda t: np.exp(-(((t - 17) / 0.01) ** 2))),
    "a soft step": (1 / (1 + gb.exp(-(gb.time - 0.5) / 2.5e-3)), lambda t: 1 / (1 + np.exp(-(t - 0.5) / 2.5e-3))),
}


@pytest.mark.parametrize("name", BUMPS)
def test_a_motion_that_is_level_but_for_a_moment_is_followed(name: str) -> None:
    """Its exponent is not multiplied out: exp(a) exp(b) is infinite times 0."""
    bump, true = BUMPS[name]
    rig = gb.Drivetrain("bump")
    for i, drive in enumerate((gb.Speed(w=3 + 0.2 * bump), gb.Angle(phi=0.2 * bump))):
        body, load = rig.add(f"body{i}", gb.Inertia(J=0.7)), rig.add(f"load{i}", gb.Inertia(J=0.2))
        rig.chain(rig.add(f"drive{i}", drive), body, rig.add(f"shaft{i}", gb.Shaft(k=100.0, c=0.5)), load)
    near = 17.0 if name == "a late bump" else 0.5
    run = gb.simulate(rig, t=[0.0, *(near + np.linspace(-0.05, 0.05, 41))], rtol=1e-9)
    assert np.abs(run["body0.w"] - 3 - 0.2 * true(run.t)).max() < 1e-12
    assert np.abs(run["body1.phi"] - 0.2 * true(run.t)).max() < 1e-13
    assert run.energy.residual < 1e-7


def test_a_cam_of_ones_own_with_a_narrow_nose_is_passed() -> None:
    class Cam(gb.Block):
        a, b = gb.Flange("shaft"), gb.Flange("follower")

        def physics(self, s):  # type: ignore[no-untyped-def]
            yield gb.Tie(s.b.phi - s.a.phi - 0.1 * sp.exp(-((4 * (s.a.phi - 30)) ** 2)))

    rig = gb.Drivetrain("cam")
    rig.chain(
        rig.add("shaft", gb.Inertia(J=1.0, w0=50.0)), rig.add("cam", Cam()), rig.add("follower", gb.Inertia(J=0.1))
    )
    run = gb.simulate(rig, t_end=1.0, rtol=1e-9)
    assert np.ptp(run["follower.phi"] - run["shaft.phi"]) > 0.09
    energy = run["shaft.w"] ** 2 / 2 + 0.1 * run["follower.w"] ** 2 / 2
    assert energy == pytest.approx(1375.0, rel=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("beside", ["parallel", "through a third", "driving to ground", "driven to ground"])
def test_an_angle_between_two_turning_shafts_lets_springs_go_any_way_beside_it(beside: str) -> None:
    rig = gb.Drivetrain("two shafts")
    i, j, spring = rig.add("i", gb.Inertia(J=1.0)), rig.add("j", gb.Inertia(J=2.0)), rig.add("s", gb.Shaft(k=10.0))
    angle, ground = rig.add("angle", gb.Angle(phi=gb.sin(gb.time))), rig.add("ground", gb.Fixed())
    rig.connect(angle.flange, j.a)
    rig.connect(angle.housing, i.a)
    rig.connect(spring.a, j.b if beside == "driven to ground" else i.b)
    if beside == "parallel":
        rig.connect(spring.b, j.b)
        rig.connect(ground.flange, rig.add("loose", gb.Inertia(J=1.0)).a)
    elif beside == "through a third":
        second, third = rig.add("s2", gb.Shaft(k=10.0)), rig.add("third", gb.Inertia(J=1.0))
        rig.connect(spring.b, third.a)
        rig.connect(third.b, second.a)
        rig.connect(second.b, j.b)
        rig.connect(ground.flange, rig.add("loose", gb.Inertia(J=1.0)).a)
    else:
        rig.connect(spring.b, ground.flange)
    run = gb.simulate(rig, t_end=1.0, rtol=1e-10)
    assert run["j.phi"] - run["i.phi"] == pytest.approx(np.sin(run.t), abs=1e-12)  # an exact tie: rounding alone
    assert run.energy.residual < 1e-9  # ten times the tolerance
    if beside in ("parallel", "through a third"):  # nothing from outside: the angular momentum stays (rtol)
        momentum = run["i.w"] + 2 * run["j.w"]
        if beside == "through a third":
            momentum = momentum + run["third.w"]
        assert momentum == pytest.approx(momentum[0], abs=1e-8)


@pytest.mark.long
def test_angles_that_are_all_prescribed_or_held_leave_the_implicit_method_its_tables() -> None:
    rig = gb.Drivetrain("held ring")
    planet, angle = rig.add("planet", gb.IdealPlanetary(ratio=-1.7)), rig.add("angle", gb.Angle(phi=gb.sin(gb.time)))
    sun, ring, carrier = (rig.add(n, gb.Inertia(J=2.0)) for n in ("sun", "ring", "carrier"))
    spring, ground = rig.add("spring", gb.Shaft(k=100.0)), rig.add("ground", gb.Fixed())
    load, last = rig.add("load_spring", gb.Shaft(k=50.0)), rig.add("last", gb.Inertia(J=0.5))
    rig.connect(planet.sun, sun.a, spring.a, load.a)
    rig.connect(planet.ring, ring.a, ground.flange)
    rig.connect(planet.carrier, carrier.a, spring.b, angle.flange)
    rig.connect(load.b, last.a)
    run = gb.simulate(rig, t_end=1.0, rtol=1e-9, method="rodas")
    assert run["sun.phi"] == pytest.approx(-0.7 * np.sin(run.t), abs=1e-12)  # sun = (1 + ratio) carrier: rounding
    other = gb.simulate(rig, t=run.t, rtol=1e-10, method="dp8")
    assert run["last.phi"] == pytest.approx(other["last.phi"], abs=1e-7)  # the tolerance of rodas over its steps


@pytest.mark.long
@pytest.mark.parametrize("method", ["rodas", "dp8"])
def test_a_dashpot_drawn_through_a_spring_follows_a_prescribed_angle_late(method: str) -> None:
    """No shaft has a speed of its own: phi' = (k/d) (sin t - phi) is all that is left."""
    rig = gb.Drivetrain("no speeds")
    angle, disc = rig.add("angle", gb.Angle(phi=gb.sin(gb.time))), rig.add("disc", gb.Inertia(J=2.0))
    stay, spring = rig.add("stay", gb.Shaft(k=100.0)), rig.add("spring", gb.Shaft(k=50.0))
    late, dashpot = rig.add("late", gb.Inertia(J=0.0, phi0=0.0)), rig.add("dashpot", gb.Damper(c=10.0))
    ground = rig.add("ground", gb.Fixed())
    rig.connect(angle.flange, disc.a, stay.a, spring.a)
    rig.connect(spring.b, late.a, dashpot.a)
    rig.connect(stay.b, dashpot.b, ground.flange)
    run = gb.simulate(rig, t_end=2.0, rtol=1e-9, method=method)
    exact = 5 / 26 * (5 * np.sin(run.t) - np.cos(run.t) + np.exp(-5 * run.t))
    assert run["late.phi"] == pytest.approx(exact, abs=1e-7)  # the tolerance over the steps
    assert run["stay.torque"] == pytest.approx(100 * np.sin(run.t), abs=1e-9)  # 100 N m, to rounding


@pytest.mark.parametrize("method", ["auto", "dp8", "rodas", "rk4"])
def test_a_train_whose_every_motion_is_prescribed_or_held_runs_by_every_method(method: str) -> None:
    step = {"step": 0.01} if method == "rk4" else {"rtol": 1e-10}
    rig = gb.Drivetrain("told")
    drive, disc = rig.add("drive", gb.Speed(w=2 + gb.sin(gb.time))), rig.add("disc", gb.Inertia(J=2.0))
    shaft, wall = rig.add("shaft", gb.Shaft(k=10.0)), rig.add("wall", gb.Fixed())
    rig.connect(drive.flange, disc.a, shaft.a)
    rig.connect(shaft.b, wall.flange)
    run = gb.simulate(rig, t_end=1.0, method=method, **step)
    turned = 2 * run.t + 1 - np.cos(run.t)
    assert run["drive.torque"] == pytest.approx(2 * np.cos(run.t) + 10 * turned, abs=1e-7)  # of 40 N m, the tolerance
    assert run.energy.residual < 1e-8
    alone = gb.Drivetrain("held")
    disc, wall = alone.add("disc", gb.Inertia(J=2.0)), alone.add("wall", gb.Fixed())
    alone.connect(disc.a, wall.flange)
    assert gb.simulate(alone, t_end=1.0, method=method, **step)["disc.w"].max() == 0.0
    assert gb.modes(rig, at=None).free == gb.modes(alone, at=None).free == 0


@pytest.mark.parametrize("by_angle", [False, True])
@pytest.mark.few(1)
def test_a_motor_that_stands_on_a_shaft_geared_to_its_own_turns_both(by_angle: bool) -> None:
    """w_a - w_b = w and w_b = w_a/3 give w_a = 3/2 w; the torque of the motor turns both discs."""
    rig = gb.Drivetrain("riding motor")
    motor = gb.Angle(phi=gb.sin(gb.time)) if by_angle else gb.Speed(w=gb.cos(gb.time))
    drive, gear = rig.add("drive", motor), rig.add("gear", gb.IdealGear(ratio=3.0))
    a, b, spring = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=9.0)), rig.add("s", gb.Shaft(k=36.0))
    ground = rig.add("ground", gb.Fixed())
    rig.connect(drive.flange, gear.a, a.a)
    rig.connect(drive.housing, gear.b, b.a)
    rig.connect(gear.housing, ground.flange)
    rig.connect(b.b, spring.a)
    rig.connect(spring.b, rig.add("wall", gb.Fixed()).flange)
    for method in ("dp8", "rodas"):
        run = gb.simulate(rig, t_end=1.0, rtol=1e-10, method=method)
        assert run["a.w"] == pytest.approx(1.5 * np.cos(run.t), abs=1e-14)  # to rounding
        assert run["b.w"] == pytest.approx(0.5 * np.cos(run.t), abs=1e-14)
        # power: tau w = (J_a + J_b/9) w_a' w_a + k phi_b w_b, with w = 2/3 w_a = 2 w_b
        torque = 1.5 * 2.0 * 1.5 * -np.sin(run.t) + 0.5 * 36.0 * 0.5 * np.sin(run.t)
        assert run["drive.torque"] == pytest.approx(torque, abs=1e-8)  # the tolerance over the steps
        assert run.energy.residual < 1e-9


def test_a_motor_between_shafts_that_turn_as_one_is_refused() -> None:
    rig = gb.Drivetrain("locked motor")
    drive, a = rig.add("drive", gb.Speed(w=1.0)), rig.add("a", gb.Inertia(J=1.0))
    rig.connect(drive.flange, a.a)
    rig.connect(drive.housing, a.b)
    with pytest.raises(gb.ModelError, match="'drive' prescribes a motion between shafts that are tied rigidly"):
        gb.build(rig)


@pytest.mark.long
def test_an_input_as_a_prescribed_motion_needs_a_filter() -> None:
    for kind, signal in ((gb.Speed, "w"), (gb.Angle, "phi")):
        value = gb.Input("wish", start=2.0, unit="1")
        for filtered in (None, 200.0):
            rig = gb.Drivetrain("rig")
            drive, load = rig.add("drive", kind(**{signal: value}, filter=filtered)), rig.add("load", gb.Inertia(J=1.0))
            rig.connect(drive.flange, load.a)
            if filtered is None:
                with pytest.raises(gb.ModelError, match=r"no time derivative.*filter="):
                    gb.build(rig)
                continue
            run = gb.simulate(
                rig, t_end=0.5, inputs={"wish": gb.Table([0, 0.1, 1], [2, 3, 3], kind="step")}, rtol=1e-10
            )
            assert run[f"load.{signal}"][0] == 2.0
            assert run[f"load.{signal}"][-1] == pytest.approx(3.0, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("cut", [5.0, 40.0])
def test_a_filtered_motion_answers_a_step_as_its_filter_does(cut: float) -> None:
    wish, at = gb.piecewise((2.0, gb.time < 0.1), (3.0, True)), np.linspace(0, 0.5, 51)
    later = cut * np.maximum(at - 0.1, 0)
    answers = {
        "w": 3 - np.exp(-later),
        "phi": 3 - (1 + later) * np.exp(-later),
    }  # of first order, and critically damped
    for kind, signal in ((gb.Speed, "w"), (gb.Angle, "phi")):
        rig = gb.Drivetrain("rig")
        drive, load = rig.add("drive", kind(**{signal: wish}, filter=cut)), rig.add("load", gb.Inertia(J=1.0))
        rig.connect(drive.flange, load.a)
        run = gb.simulate(rig, t=at, rtol=1e-10)
        assert np.abs(run[f"load.{signal}"] - answers[signal]).max() < 1e-8
        if signal == "phi":
            pull = np.where(later > 0, cut**2 * (1 - later) * np.exp(-later), 0.0)
            assert np.abs(run["drive.torque"] - pull)[later != 0].max() < 1e-7 * cut**2


def test_motions_that_no_torque_can_follow_are_refused() -> None:
    jump = sp.Piecewise((1.0, gb.time < 1), (2.0, True))
    step = gb.Table([0, 1, 2], [0, 1, 3], kind="step")
    for block, words in (
        (gb.Speed(w=jump), "jumps"), (gb.Speed(w=2 * step(gb.time)), "jumps"), (gb.Speed(w=step), "jumps"),
        (gb.Angle(phi=sp.Abs(gb.time - 1)), "corners or jumps"),
    ):  # fmt: skip
        rig = gb.Drivetrain("rig")
        drive, load = rig.add("drive", block), rig.add("load", gb.Inertia(J=1.0))
        rig.connect(drive.flange, load.a)
        with pytest.raises(gb.ModelError, match=words):
            gb.build(rig)
