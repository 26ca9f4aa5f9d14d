"""Lossy gears that turn side by side and in a ring: the motion does not tell their forces, and what they lose hangs on them.

They are those of gears that give a little, all alike in units of their a. Side by side what leaves each is the same u, so that
with efficiencies eta_k and the ratio i

    a: T - u sum 1/eta_k = J_a alpha,    b: n i u = J_b alpha/i    =>    alpha = T/(J_a + J_b/(n i^2) sum 1/eta_k)

and eta_k in place of 1/eta_k where b drives. In a ring a - c - b of ratios p, q beside p q the third has u_3 = u_1 + p u_2.
"""

import itertools

import numpy as np
import pytest

import gearblocks as gb

RATIO, J_A, J_B = 3.0, 1.0, 2.0
SINE = 4.0


def _side_by_side(
    losses: list[tuple[float, float]], tau: object, ideal: bool = False, k: float | None = None
) -> gb.Drivetrain:
    """Gears of one ratio between a and b; an ideal one beside them, or behind the load a soft spring to a body."""
    rig = gb.Drivetrain("side by side")
    a, b = rig.add("a", gb.Inertia(J=J_A, w0=20.0)), rig.add("b", gb.Inertia(J=J_B))
    rig.connect(rig.add("load", gb.Torque(tau=tau)).flange, a.a)
    for i, efficiency in enumerate(losses):
        gear = rig.add(f"gear{i}", gb.LossyGear(ratio=RATIO, efficiency=efficiency))
        rig.connect(a.b, gear.a)
        rig.connect(gear.b, b.a)
    if ideal:
        gear = rig.add("ideal", gb.IdealGear(ratio=RATIO))
        rig.connect(a.b, gear.a)
        rig.connect(gear.b, b.a)
    if k is not None:
        rig.chain(b, rig.add("spring", gb.Shaft(k=k)), rig.add("far", gb.Inertia(J=0.3, w0=20.0 / RATIO)))
    return rig


def _inertia(losses: list[tuple[float, float]], driving: bool) -> float:
    """T/alpha."""
    shares = [1 / one if driving else two for one, two in losses]
    return J_A + J_B / (len(losses) * RATIO**2) * sum(shares)


UNLIKE = [(0.9, 0.8), (0.5, 0.4), (0.7, 0.95)]


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("count", [2, 3])
@pytest.mark.few(1)
def test_gears_side_by_side_share_what_they_pass_on_in_any_order(count: int, method: str) -> None:
    """A torque that turns round: a drives for half a period, then b."""
    half = np.pi / SINE
    for order in itertools.islice(itertools.permutations(UNLIKE[:count]), 2):
        run = gb.simulate(
            _side_by_side(list(order), 4.0 * gb.sin(SINE * gb.time)), t_end=2 * half, method=method, rtol=1e-8
        )
        gain = 4.0 / SINE * (1 - np.cos(SINE * np.minimum(run.t, half)))
        loss = 4.0 / SINE * (-1 - np.cos(SINE * np.maximum(run.t, half)))
        exact = 20.0 + gain / _inertia(list(order), True) + loss / _inertia(list(order), False)
        assert run["a.w"] == pytest.approx(exact, rel=1e-7)
        passed = np.array([run[f"gear{i}.b.tau"] for i in range(count)])
        assert passed[1:] == pytest.approx(passed[:-1], abs=1e-6)
        taken = sum(run[f"gear{i}.a.tau"] for i in range(count))
        assert J_A * run["a.alpha"] == pytest.approx(4.0 * np.sin(SINE * run.t) + taken, abs=1e-6)
        assert run.energy.residual < 1e-7


@pytest.mark.long
def test_a_gear_beside_an_ideal_one_passes_nothing_on() -> None:
    run = gb.simulate(_side_by_side(UNLIKE[:2], 4.0, ideal=True), t_end=0.5)
    assert run["a.w"][-1] == pytest.approx(20.0 + 2.0 / (J_A + J_B / RATIO**2), rel=1e-9)
    assert abs(run["gear0.b.tau"]).max() < 1e-9


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "rodas"])
def test_a_spring_behind_gears_side_by_side_swings_as_behind_one_gear_of_their_mean(method: str) -> None:
    """Two gears that pass on the same lose as one with the mean of 1/eta_1 and of eta_2."""
    one = 2 / (1 / UNLIKE[0][0] + 1 / UNLIKE[1][0])
    mean = [(one, (UNLIKE[0][1] + UNLIKE[1][1]) / 2)]
    runs = [
        gb.simulate(_side_by_side(losses, 4.0 * gb.sin(7.0 * gb.time), k=30.0), t_end=2.0, method=method, rtol=1e-8)
        for losses in (UNLIKE[:2], mean)
    ]
    assert runs[0]["far.w"][-1] == pytest.approx(runs[1]["far.w"][-1], rel=1e-6)
    assert runs[0].stats.steps <= 1.2 * runs[1].stats.steps + 20


@pytest.mark.long
@pytest.mark.parametrize("tau", [5.0, -5.0])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
@pytest.mark.few(1)
def test_gears_in_a_ring_give_alike(order: tuple[int, ...], tau: float) -> None:
    p, q, between = 2.0, 3.0, 0.1
    ends, ratios = (("a", "c"), ("c", "b"), ("a", "b")), (p, q, p * q)
    rig = gb.Drivetrain("ring")
    bodies = {
        n: rig.add(n, gb.Inertia(J=J, **({"w0": 20.0} if n == "a" else {})))
        for n, J in (("a", J_A), ("b", J_B), ("c", between))
    }
    rig.connect(rig.add("load", gb.Torque(tau=tau)).flange, bodies["a"].a)
    for i in order:
        gear = rig.add(f"gear{i}", gb.LossyGear(ratio=ratios[i], efficiency=UNLIKE[i]))
        rig.connect(bodies[ends[i][0]].b, gear.a)
        rig.connect(gear.b, bodies[ends[i][1]].b)
    run = gb.simulate(rig, t_end=0.2)
    e = [1 / one if tau > 0 else two for one, two in UNLIKE]
    alpha = np.linalg.solve(
        [
            [e[0] + e[2], p * e[2], J_A],
            [p, -e[1], -between / p],
            [p * q, q + p * q * p, -J_B / (p * q)],
        ],
        [tau, 0.0, 0.0],
    )[2]
    assert run["a.w"][-1] - 20.0 == pytest.approx(0.2 * alpha, rel=1e-9)
    assert run.energy.residual < 1e-9


def _alike(count: int, rows: tuple[tuple[float, ...], ...], tau: object, held: float) -> gb.Drivetrain:
    """So many gears alike between a and b, or one with the bearing torques of all (-count); a brake on b."""
    rig = gb.Drivetrain("alike")
    a, b = rig.add("a", gb.Inertia(J=0.0641)), rig.add("b", gb.Inertia(J=0.786))
    rig.connect(rig.add("load", gb.Torque(tau=tau)).flange, b.b)
    one = tuple((w, eta1, eta2, max(-count, 1) * tau1, max(-count, 1) * tau2) for w, eta1, eta2, tau1, tau2 in rows)
    for i in range(max(count, 1)):
        gear = rig.add(f"gear{i}", gb.LossyGear(ratio=4.0, loss_table=one))
        rig.connect(a.b, gear.a)
        rig.connect(gear.b, b.a)
    if held:
        rig.connect(rig.add("hold", gb.Brake(capacity=held)).a, b.b)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("held", [0.0, 2.0])
@pytest.mark.parametrize("kind", ["constant", "table", "gap"])
@pytest.mark.parametrize("count", [2, 3])
def test_gears_alike_side_by_side_are_one_with_the_bearing_torques_of_all(count: int, kind: str, held: float) -> None:
    """From rest, through reversals of the torque, at which both change their side at once, and of the speed."""
    rows = {
        "constant": ((0.0, 0.521, 0.613, 0.296, 0.296),),
        "table": ((0.0, 0.521, 0.613, 0.296, 0.296), (0.995, 0.543, 0.634, 0.2, 0.2)),
        "gap": ((0.0, 0.7, 0.8, 0.1, 0.3),),
    }[kind]
    tau = 12.4 * gb.sin(2.26 * gb.time) + 3.0 * gb.cos(9.0 * gb.time)
    several, one = (
        gb.simulate(_alike(n, rows, tau, held), t=np.linspace(0.0, 3.0, 61), rtol=1e-8, watch=False)
        for n in (count, -count)
    )
    assert several["a.w"] == pytest.approx(one["a.w"], abs=1e-6 * abs(one["a.w"]).max())
    assert abs(one["a.w"]).max() > 3.0
    first = [round(e.t, 6) for e in several.events if e.component.startswith("gear0")]
    assert first == [round(e.t, 6) for e in one.events if e.component.startswith("gear0")]
    assert several.energy.residual < 1e-7


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize("count", [-3, 3])
def test_a_load_that_a_brake_and_gears_share_is_no_matter_of_step_sizes(count: int, method: str) -> None:
    """Gears that let nothing in for some torques hold a load with a brake: how much more they would hold has no jump."""
    tau = 12.4 * gb.sin(2.26 * gb.time) + 3.0 * gb.cos(9.0 * gb.time)
    rig = _alike(count, ((0.0, 0.7, 0.8, 0.1, 0.3),), tau, 2.0)
    run = gb.simulate(rig, t_end=3.0, method=method, rtol=1e-8)
    assert run.stats.steps + run.stats.rejected < 300
    assert run.energy.residual < 1e-7
