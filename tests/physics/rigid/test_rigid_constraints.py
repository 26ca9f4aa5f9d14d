"""Rigid constraints: gears with turning housings, planetaries, differentials, closed loops."""

import numpy as np
import pytest

import gearblocks as gb


def _planetary(ratio: float, j: tuple[float, float, float], torques: tuple[float, float, float]) -> gb.Drivetrain:
    rig = gb.Drivetrain("planetary")
    planet = rig.add("planet", gb.IdealPlanetary(ratio=ratio))
    for name, inertia, tau in zip(("sun", "carrier", "ring"), j, torques, strict=True):
        body = rig.add(name, gb.Inertia(J=inertia))
        load = rig.add(f"{name}_torque", gb.Torque(tau=tau))
        rig.connect(body.b, getattr(planet, name), load.flange)
    return rig


@pytest.mark.parametrize("ratio", [2.0, pytest.param(0.4, marks=pytest.mark.long), -2.5])
@pytest.mark.few(1)
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


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.long
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
