"""Ties: gears with turning housings, planetaries, differentials, closed loops, prescribed motion, shafts without inertia."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb


def _planetary(ratio: float, j: tuple[float, float, float], torques: tuple[float, float, float]) -> gb.Drivetrain:
    rig = gb.Drivetrain("planetary")
    planet = rig.add("planet", gb.IdealPlanetary(ratio=ratio))
    for name, inertia, tau in zip(("sun", "carrier", "ring"), j, torques, strict=True):
        body = rig.add(name, gb.Inertia(J=inertia))
        load = rig.add(f"{name}_torque", gb.Torque(tau=tau))
        rig.connect(body.b, getattr(planet, name), load.flange)
    return rig


@pytest.mark.parametrize("ratio", [2.0, 0.4, -2.5])
def test_a_planetary_accelerates_as_lagrange_says(ratio: float) -> None:
    j, torques = (0.1, 0.3, 0.5), (2.0, -1.0, 0.7)
    run = gb.simulate(_planetary(ratio, j, torques), t_end=1.0)
    # J_i w_i' = T_i + lambda a_i with a . w = 0: three unknown accelerations and one multiplier
    a = np.array([1.0, -(1 + ratio), ratio])
    matrix = np.block([[np.diag(j), -a[:, None]], [a[None, :], np.zeros((1, 1))]])
    solution = np.linalg.solve(matrix, [*torques, 0.0])
    for i, name in enumerate(("sun", "carrier", "ring")):
        assert run[f"{name}.w"][-1] == pytest.approx(solution[i], rel=1e-12)
        assert run[f"planet.torque_{name}"][-1] == pytest.approx(a[i] * solution[3], rel=1e-12)
    assert abs(run.energy.residual) < 1e-12


def test_the_equations_for_people_say_what_the_c_computes_for_a_planetary() -> None:
    rig = _planetary(2.0, (0.1, 0.3, 0.5), (2.0, -1.0, 0.7))
    eq = rig.equations()
    numbers = {
        x: gb.build(rig).values[[p.path for p in gb.build(rig).program.parameters].index(path)]
        for x, path in eq.parameters.items()
    }
    acceleration = eq.mass_matrix.subs(numbers).LUsolve(eq.forcing.subs(numbers))
    run = gb.simulate(rig, t_end=1.0)
    for v, value in zip(eq.v, acceleration, strict=True):
        assert run[f"{v.name.removeprefix('w_')}.alpha"][0] == pytest.approx(float(value), rel=1e-12)


def test_the_reaction_of_a_gear_goes_to_its_housing_whether_that_turns_or_not() -> None:
    for held in (True, False):
        rig = gb.Drivetrain("gear")
        a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=2.0))
        gear, drive = rig.add("gear", gb.IdealGear(ratio=3.0)), rig.add("drive", gb.Torque(tau=2.0))
        rig.connect(drive.flange, a.a)
        rig.connect(a.b, gear.a)
        rig.connect(gear.b, b.a)
        house = rig.add("house", gb.Fixed() if held else gb.Inertia(J=5.0))
        rig.connect(gear.housing, house.flange if held else house.a)
        run = gb.simulate(rig, t_end=1.0)
        assert run["gear.a.tau"][-1] + run["gear.b.tau"][-1] + run["gear.housing.tau"][-1] == pytest.approx(
            0, abs=1e-12
        )
        assert run["gear.b.tau"][-1] == pytest.approx(-3 * run["gear.a.tau"][-1], rel=1e-12)
        if held:
            assert run["a.alpha"][-1] == pytest.approx(2.0 / (1.0 + 2.0 / 9.0), rel=1e-12)
            assert run["house.torque"][-1] == pytest.approx(-run["gear.housing.tau"][-1], rel=1e-12)


def test_a_differential_shares_the_torque_equally() -> None:
    rig = gb.Drivetrain("axle")
    diff = rig.add("diff", gb.Differential(ratio=4.0))
    for name, inertia, tau in (("carrier", 0.2, 12.0), ("left", 1.0, -1.0), ("right", 1.5, -9.0)):
        body, load = rig.add(name, gb.Inertia(J=inertia)), rig.add(f"{name}_torque", gb.Torque(tau=tau))
        rig.connect(getattr(diff, name), body.a, load.flange)
    run = gb.simulate(rig, t_end=0.5)
    assert run["diff.torque_left"][-1] == pytest.approx(run["diff.torque_right"][-1], rel=1e-12)
    assert run["diff.torque_left"][-1] == pytest.approx(-run["diff.torque_carrier"][-1] * 4.0 / 2.0, rel=1e-12)
    assert run["left.w"][-1] + run["right.w"][-1] == pytest.approx(2 * run["carrier.w"][-1] / 4.0, rel=1e-12)


def _ring_of_gears(n: int, last: tuple[int, int] | None = None) -> gb.Drivetrain:
    """n gear pairs in a closed loop whose ratios multiply to 1."""
    rig = gb.Drivetrain("loop")
    first = rig.add("first", gb.Inertia(J=1.0))
    node = first.b
    for i in range(n):
        za, zb = 23 + i % (n // 2) % 7, 41 + i % (n // 2) % 5
        teeth = (za, zb) if i < n // 2 else (zb, za)
        gear = rig.add(f"gear{i}", gb.IdealGear(teeth=last if last and i == n - 1 else teeth, external=True))
        rig.connect(node, gear.a)
        node = gear.b
    rig.connect(node, first.a)
    return rig


def test_a_closed_loop_of_fifty_gear_pairs_is_found_redundant_exactly() -> None:
    run = gb.simulate(_ring_of_gears(50), t_end=1.0, initial={"first.w": 2.0})
    assert run["first.w"][-1] == 2.0
    with pytest.raises(gb.ModelError, match=r"gear49.*contradict each other"):
        gb.build(_ring_of_gears(50, last=(46, 25)))


def test_equal_gear_pairs_side_by_side_share_the_torque_equally() -> None:
    rig = gb.Drivetrain("side by side")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    for i in range(3):
        gear = rig.add(f"gear{i}", gb.IdealGear(ratio=-2.0))
        rig.connect(one.b, gear.a)
        rig.connect(two.a, gear.b)
    rig.connect(rig.add("drive", gb.Torque(tau=9.0)).flange, one.a)
    run = gb.simulate(rig, t_end=1.0)
    alpha = 9.0 / (1.0 + 2.0 / 4)
    for i in range(3):
        assert run[f"gear{i}.a.tau"][-1] == pytest.approx((alpha - 9.0) / 3, rel=1e-14)
        assert run[f"gear{i}.torque"][-1] == pytest.approx(2.0 * -alpha / 2 / 3, rel=1e-14)


def test_a_shaft_that_two_walls_hold_loads_both_alike() -> None:
    rig = gb.Drivetrain("two walls")
    body = rig.add("body", gb.Inertia(J=1.0))
    left, right = rig.add("left", gb.Fixed()), rig.add("right", gb.Fixed())
    rig.connect(rig.add("drive", gb.Torque(tau=4.0)).flange, body.a, left.flange, right.flange)
    run = gb.simulate(rig, t_end=1.0)
    assert run["left.torque"][-1] == run["right.torque"][-1] == -2.0


def test_two_planetaries_that_share_two_shafts_have_one_degree_of_freedom_less_each() -> None:
    """A Simpson set: common sun; carrier of the first tied to the ring of the second."""
    rig = gb.Drivetrain("simpson")
    one, two = rig.add("one", gb.IdealPlanetary(ratio=2.0)), rig.add("two", gb.IdealPlanetary(ratio=2.5))
    sun, ring, out, carrier = (
        rig.add(n, gb.Inertia(J=j)) for n, j in (("sun", 0.1), ("ring", 0.2), ("out", 0.4), ("carrier", 0.3))
    )
    drive, load = rig.add("drive", gb.Torque(tau=5.0)), rig.add("load", gb.Torque(tau=-3.0))
    rig.connect(sun.a, one.sun, two.sun)
    rig.connect(ring.a, one.ring, drive.flange)
    rig.connect(out.a, one.carrier, two.ring, load.flange)
    rig.connect(carrier.a, two.carrier)
    run = gb.simulate(rig, t_end=1.0)
    w = {n: run[f"{n}.w"][-1] for n in ("sun", "ring", "out", "carrier")}
    assert w["sun"] + 2.0 * w["ring"] == pytest.approx(3.0 * w["out"], rel=1e-12)
    assert w["sun"] + 2.5 * w["out"] == pytest.approx(3.5 * w["carrier"], rel=1e-12)
    for n in ("sun", "ring", "out", "carrier"):  # every node is in balance
        ends = [x for x in run.names if x.endswith(".tau") and x.rsplit(".", 1)[0] in _ends(n)]
        assert sum(run[x][-1] for x in ends) == pytest.approx(0, abs=1e-11)


def _ends(name: str) -> set[str]:
    return {
        "sun": {"sun.a", "one.sun", "two.sun"}, "ring": {"ring.a", "one.ring", "drive.flange"},
        "out": {"out.a", "one.carrier", "two.ring", "load.flange"}, "carrier": {"carrier.a", "two.carrier"},
    }[name]  # fmt: skip


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


def _split(parts: int, c: float | None, empty: bool) -> gb.Drivetrain:
    """Two discs and a shaft, in parts with nothing (or an Inertia of zero) between."""
    rig = gb.Drivetrain("two discs")
    a, b = rig.add("a", gb.Inertia(J=0.1)), rig.add("b", gb.Inertia(J=0.3, phi0=0.02))
    drive = rig.add("drive", gb.Torque(tau=2.0 + 3 * sp.sin(30 * gb.time)))
    rig.connect(drive.flange, a.a)
    node = a.b
    for i in range(parts):
        shaft = rig.add(f"shaft{i}", gb.Shaft(k=1000.0 * parts, c=None if c is None else c * parts))
        rig.connect(node, shaft.a)
        node = shaft.b
        if empty and i < parts - 1:
            disc = rig.add(f"disc{i}", gb.Inertia(J=0.0))
            rig.connect(node, disc.a)
            node = disc.b
    rig.connect(node, b.a)
    return rig


@pytest.mark.parametrize("c", [None, 0.5])
@pytest.mark.parametrize("empty", [False, True])
def test_a_shaft_split_into_parts_without_inertia_between_moves_as_the_whole(c: float | None, empty: bool) -> None:
    t = np.linspace(0, 1, 101)
    whole = gb.simulate(_split(1, c, False), t=t, rtol=1e-11)
    for parts in (2, 3):
        run = gb.simulate(_split(parts, c, empty), t=t, rtol=1e-11)
        for name in ("a.w", "b.w", "a.phi", "b.phi"):
            assert np.abs(run[name] - whole[name]).max() < 1e-9 * np.abs(whole[name]).max(), name
        assert np.abs(run["shaft0.twist"] - whole["shaft0.twist"] / parts).max() < 1e-11
        assert np.abs(run["shaft0.torque"] - run["shaft1.torque"]).max() < 1e-8  # of 60 N m
        assert abs(run.energy.residual) < 1e-9


def test_a_damper_at_a_shaft_without_inertia_makes_a_state_of_first_order() -> None:
    """Spring and damper in a row from the wall: the node creeps back with the time constant c/k."""
    rig = gb.Drivetrain("maxwell")
    node = rig.add("node", gb.Inertia(J=0.0, phi0=0.1))
    spring, damper = rig.add("spring", gb.Shaft(k=50.0)), rig.add("damper", gb.Damper(c=10.0))
    wall, floor = rig.add("wall", gb.Fixed()), rig.add("floor", gb.Fixed())
    rig.connect(wall.flange, spring.a)
    rig.connect(spring.b, node.a)
    rig.connect(node.b, damper.a)
    rig.connect(damper.b, floor.flange)
    run = gb.simulate(rig, t=np.linspace(0, 1, 11), rtol=1e-10)
    assert np.abs(run["node.phi"] - 0.1 * np.exp(-5.0 * run.t)).max() < 1e-10
    assert abs(run.energy.residual) < 1e-9
    assert np.isnan(run["node.alpha"]).all()  # a shaft without inertia has no equation for it


@pytest.mark.parametrize("method", ["dp8", "rodas"])
@pytest.mark.parametrize("geared", [False, True])
def test_shafts_without_inertia_that_are_damped_against_each_other_hang_on_a_spring(method: str, geared: bool) -> None:
    """The torque reaches the disc at once; the damped shaft between follows c x' + k x = tau from k x = tau(0)."""
    rig = gb.Drivetrain("hanging")
    disc, spring = rig.add("disc", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(k=100.0))
    damped, drive = (
        rig.add("damped", gb.Shaft(k=200.0, c=10.0)),
        rig.add("drive", gb.Torque(tau=1 + sp.sin(3 * gb.time))),
    )
    ratio = 2.0 if geared else 1.0
    rig.connect(disc.a, spring.a)
    if geared:  # the torque on the disc's side is twice as large
        gear = rig.add("gear", gb.IdealGear(ratio=2.0))
        rig.connect(spring.b, gear.b)
        rig.connect(gear.a, damped.a)
    else:
        rig.connect(spring.b, damped.a)
    rig.connect(damped.b, drive.flange)
    t = np.linspace(0, 2, 41)
    run = gb.simulate(rig, t=t, rtol=1e-10, method=method)
    tau, k, c = 1 + np.sin(3 * t), 200.0, 10.0
    a, b = k / (k**2 + 9 * c**2), -3 * c / (k**2 + 9 * c**2)
    twist = 1 / k + a * np.sin(3 * t) + b * np.cos(3 * t) - b * np.exp(-k / c * t)
    assert run["damped.twist"] == pytest.approx(twist, abs=1e-9)  # of 0.01 rad, the tolerance over its steps
    assert run["spring.twist"] == pytest.approx(ratio * tau / 100, abs=1e-11)  # at once, to rounding
    assert run["disc.w"] == pytest.approx(ratio * (t + (1 - np.cos(3 * t)) / 3), abs=1e-8)
    assert abs(run.energy.residual) < 1e-9


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


def test_an_inertia_of_zero_is_part_of_the_structure() -> None:
    model = gb.build(_split(2, 0.5, empty=True))
    with pytest.raises(gb.ParameterError, match=r"disc0\.J"):
        gb.simulate(model, t_end=0.1, parameters={"disc0.J": 1.0})
    heavy = gb.simulate(_split(2, 0.5, empty=True).set({"disc0.J": 1.0}), t_end=0.1)
    assert heavy["disc0.alpha"][0] == heavy["disc0.alpha"][0]
