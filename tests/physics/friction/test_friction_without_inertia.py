"""Friction, locks and one-way clutches beside shafts without inertia: balance of torques with switched constraints.

Independent: by hand, the speed w of such a shaft solves c (w - w_1) + k z + F sign(slip) = 0 as an inclusion, which is a clip
in closed form; integrated by scipy. And the same trains with a small inertia there, extrapolated to none.
"""

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose

T = np.linspace(0.0, 2.0, 41)
METHODS = ("dp8", pytest.param("rodas", marks=pytest.mark.long))


def _rig(element: gb.Block, *, J: float | None = None, c: float | None = 2.0) -> gb.Drivetrain:
    """A driven inertia, a shaft, the element, another inertia; J: at the shaft between."""
    rig = gb.Drivetrain("friction without inertia")
    one, other = rig.add("one", gb.Inertia(J=0.3, w0=10.0)), rig.add("other", gb.Inertia(J=0.5))
    shaft, part = rig.add("shaft", gb.Shaft(k=500.0, c=c)), rig.add("part", element)
    rig.chain(rig.add("drive", gb.Torque(tau=60 * gb.sin(7 * gb.time))), one, shaft)
    if J is not None:
        rig.connect(shaft.b, rig.add("node", gb.Inertia(J=J)).a)
    rig.connect(shaft.b, part.a)
    if "b" in type(element).flanges:
        rig.connect(part.b, other.a)
    else:
        rig.chain(other, rig.add("rest", gb.BearingFriction(coulomb=1.0)))
    return rig


def _by_hand(capacity: Callable[[float], float], *, braked: bool = False) -> np.ndarray:
    """w of both inertias: the shaft's torque is that of its other end held by the partner, clipped at the capacity."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        w1, w2, z = y  # z: twist
        partner = 0.0 if braked else w2
        torque = float(np.clip(500.0 * z + 2.0 * (partner - w1), -capacity(t), capacity(t)))
        slip = (torque - 500.0 * z) / 2.0  # rate of the twist
        return [(60 * np.sin(7 * t) + torque) / 0.3, 0.0 if braked else -torque / 0.5, slip]

    run = solve_ivp(rates, (0.0, 2.0), [10.0, 0.0, 0.0], t_eval=T, rtol=1e-11, atol=1e-12, max_step=1e-3)
    return np.array(run.y[:2])


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_clutch_behind_a_damped_shaft_follows_the_clipped_torque(method: str) -> None:
    run = gb.simulate(_rig(gb.Clutch(capacity=15.0)), t=T, rtol=1e-9, method=method)
    found = np.array([run["one.w"], run["other.w"]])
    assert np.abs(found - _by_hand(lambda _: 15.0)).max() < 1e-7 * np.abs(found).max()
    assert {e.after for e in run.events} == {-1.0, 0.0, 1.0}
    assert run.energy.residual < 1e-9


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp8", "rodas"])
def test_a_clutch_of_varying_capacity_is_free_where_that_is_not_above_zero(method: str) -> None:
    capacity = gb.Table([0.0, 0.5, 1.2, 2.0], [5.0, 20.0, 20.0, -5.0])
    run = gb.simulate(_rig(gb.Clutch(capacity=capacity)), t=T, rtol=1e-9, method=method)
    found = np.array([run["one.w"], run["other.w"]])
    by_hand = _by_hand(lambda t: max(0.0, float(np.interp(t, [0.0, 0.5, 1.2, 2.0], [5.0, 20.0, 20.0, -5.0]))))
    assert np.abs(found - by_hand).max() < 1e-7 * np.abs(found).max()
    assert run["part.mode"][-1] == 2.0
    assert run["part.torque"][-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.long
def test_a_brake_on_the_end_of_a_shaft_holds_it_up_to_its_capacity() -> None:
    run = gb.simulate(_rig(gb.Brake(capacity=15.0)), t=T, rtol=1e-9)
    assert np.abs(run["one.w"] - _by_hand(lambda _: 15.0, braked=True)[0]).max() < 1e-7 * np.abs(run["one.w"]).max()
    stuck = run["part.mode"] == 0
    assert stuck.any()
    assert (run["part.w_rel"][stuck] == 0.0).all()
    assert np.abs(run["part.torque"]).max() <= 15.0 * (1 + 1e-12)


ELEMENTS = {
    "peak": gb.Clutch(capacity=15.0, peak=1.3),
    "mu over slip": gb.Clutch(mu=gb.Table([0.0, 1.0, 5.0], [0.3, 0.28, 0.31]), force_max=60.0, engagement=1.0),
    "bearing": gb.BearingFriction(coulomb=5.0, viscous=0.1, stribeck=gb.Stribeck(rise=2.0, speed=3.0)),
    "one-way clutch": gb.OneWayClutch(capacity=15.0),
    "freewheel": gb.Freewheel(),
    "dog clutch": gb.DogClutch(engaged=gb.Table([0.0, 0.5, 1.0], [0.0, 1.0, 0.0], "step")),
}
SOME = [pytest.param(n, marks=() if n == "peak" else pytest.mark.long) for n in ELEMENTS]


@pytest.mark.long
@pytest.mark.parametrize("name", SOME)
def test_it_is_the_limit_of_a_vanishing_inertia(name: str) -> None:
    run = gb.simulate(_rig(ELEMENTS[name]), t=T, rtol=1e-9)
    limit = [gb.simulate(_rig(ELEMENTS[name], J=J), t=T, rtol=1e-8) for J in (4e-5, 2e-5, 1e-5)]
    for body in ("one.w", "other.w") if "b" in type(ELEMENTS[name]).flanges else ("one.w",):
        first, second = (2 * b[body] - a[body] for a, b in itertools.pairwise(limit))
        size = np.abs(run[body]).max()
        assert np.abs(run[body] - limit[-1][body]).max() > 1e-6 * size  # what the inertia does is seen
        assert np.abs(run[body] - (4 * second - first) / 3).max() < 1e-6 * size


@pytest.mark.long
def test_a_clutch_between_two_shafts_without_inertia_is_the_limit_of_two_inertias() -> None:
    def rig(J: float | None) -> gb.Drivetrain:
        rig = gb.Drivetrain("between shafts")
        one, other = rig.add("one", gb.Inertia(J=0.3, w0=10.0)), rig.add("other", gb.Inertia(J=0.5))
        first, second = rig.add("first", gb.Shaft(k=500.0, c=2.0)), rig.add("second", gb.Shaft(k=300.0, c=1.0))
        clutch = rig.add("clutch", gb.Clutch(capacity=15.0))
        rig.chain(rig.add("drive", gb.Torque(tau=60 * gb.sin(7 * gb.time))), one, first, clutch, second, other)
        for name, at in (("a", clutch.a), ("b", clutch.b)) if J else ():
            rig.connect(at, rig.add(name, gb.Inertia(J=J)).a)
        return rig

    run = gb.simulate(rig(None), t=T, rtol=1e-9)
    limit = [gb.simulate(rig(J), t=T, rtol=1e-8)["other.w"] for J in (4e-5, 2e-5, 1e-5)]
    extrapolated = (4 * (2 * limit[2] - limit[1]) - (2 * limit[1] - limit[0])) / 3
    assert np.abs(run["other.w"] - extrapolated).max() < 1e-6 * np.abs(run["other.w"]).max()


# -- springs that friction alone loads --------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_an_undamped_spring_keeps_the_twist_of_its_friction(method: str) -> None:
    """By hand: k z = F while it slides, so z stays; stuck, z' = w_other - w_one (the play operator)."""
    run = gb.simulate(_rig(gb.Clutch(capacity=15.0), c=None), t=T, rtol=1e-9, method=method)
    twist = run["shaft.twist"]
    assert np.abs(500.0 * twist).max() <= 15.0 * (1 + 1e-9)
    slides = np.abs(run["part.mode"]) == 1
    assert slides.any()
    assert np.abs(np.abs(500.0 * twist[slides]) - 15.0).max() < 1e-9 * 15.0

    def rates(t: float, y: np.ndarray) -> list[float]:  # z is held at its bound by the projection of its rate
        w1, w2, z = y
        rate = w2 - w1
        rate = 0.0 if 500.0 * abs(z) >= 15.0 and z * rate > 0 else rate
        torque = float(np.clip(500.0 * z, -15.0, 15.0))
        return [(60 * np.sin(7 * t) + torque) / 0.3, -torque / 0.5, rate]

    hand = solve_ivp(rates, (0.0, 2.0), [10.0, 0.0, 0.0], t_eval=T, rtol=1e-8, atol=1e-10, max_step=1e-4)
    assert np.abs(run["one.w"] - hand.y[0]).max() < 1e-4 * np.abs(run["one.w"]).max()


@pytest.mark.long
def test_an_undamped_spring_whose_friction_jumps_is_refused_by_name() -> None:
    for element in (
        gb.Clutch(capacity=15.0, peak=1.3),
        gb.Clutch(capacity=gb.Table([0.0, 0.5, 1.0], [5.0, 20.0, 12.0], "step")),
    ):
        with pytest.raises(gb.SimulationError, match=r"'shaft'.*jumps.*give it a c"):
            gb.simulate(_rig(element, c=None), t_end=2.0)
        gb.simulate(_rig(element, c=2.0), t_end=2.0)


def test_three_elements_that_stick_on_one_shaft_without_inertia_are_refused_by_name() -> None:
    rig = _rig(gb.Clutch(capacity=15.0))
    rig.connect(rig["part"].a, rig.add("brake", gb.Brake(capacity=1.0)).a)
    with pytest.raises(gb.ModelError, match=r"'brake'.*one shaft without inertia.*put an Inertia there"):
        gb.build(rig)


# -- friction in a row, with nothing between --------------------------------------------------------------------------


def _row(*elements: gb.Block, J: float | None = None) -> gb.Drivetrain:
    rig = gb.Drivetrain("friction in a row")
    one, other = rig.add("one", gb.Inertia(J=0.3, w0=10.0)), rig.add("other", gb.Inertia(J=0.5))
    row = []
    for i, element in enumerate(elements):
        row += [
            rig.add(f"c{i}", element),
            *([rig.add(f"n{i}", gb.Inertia(J=J))] if J and i < len(elements) - 1 else []),
        ]
    rig.chain(rig.add("drive", gb.Torque(tau=40 * gb.sin(7 * gb.time))), one, *row, other)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("capacities", [(15.0, 20.0), pytest.param((20.0, 12.0, 30.0), marks=pytest.mark.long)])
def test_of_clutches_in_a_row_the_weakest_slips(capacities: tuple[float, ...]) -> None:
    clutches = [gb.Clutch(capacity=x) for x in capacities]
    run = gb.simulate(_row(*clutches), t=T, rtol=1e-9)
    single = gb.simulate(_row(gb.Clutch(capacity=min(capacities))), t=T, rtol=1e-9)
    assert np.abs(run["one.w"] - single["one.w"]).max() < 1e-8 * np.abs(run["one.w"]).max()
    weakest = capacities.index(min(capacities))
    for i in range(len(capacities)):
        np.testing.assert_allclose(run[f"c{i}.torque"], single["c0.torque"], rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(run[f"c{i}.b.tau"], run[f"c{i}.torque"], rtol=1e-9, atol=1e-9)
        slips = run[f"c{i}.w_rel"] if i == weakest else run[f"c{i}.mode"]
        assert (slips != 0).any() == (i == weakest)
    limit = [gb.simulate(_row(*clutches, J=J), t=T, rtol=1e-9)["one.w"] for J in (2e-5, 1e-5)]
    assert np.abs(run["one.w"] - (2 * limit[1] - limit[0])).max() < 1e-6 * np.abs(run["one.w"]).max()


@pytest.mark.long
def test_a_clutch_and_a_brake_on_a_shaft_without_inertia_are_in_a_row_too() -> None:
    rig = gb.Drivetrain("clutch and brake")
    one, clutch = rig.add("one", gb.Inertia(J=0.3, w0=10.0)), rig.add("clutch", gb.Clutch(capacity=3.0))
    rig.chain(one, clutch, rig.add("brake", gb.Brake(capacity=5.0)))
    run = gb.simulate(rig, t=[0.0, 0.4, 2.0])
    assert run["one.w"] == pytest.approx([10.0, 6.0, 0.0])
    assert run["brake.torque"][1] == pytest.approx(3.0)
    assert run["clutch.loss_power"][1] == pytest.approx(18.0)


@pytest.mark.parametrize(("elements", "rule"), [
    ((gb.Clutch(capacity=15.0), gb.Clutch(capacity=15.0)), r"slip at the same torque, 15 N m"),
    ((gb.Clutch(capacity=15.0, peak=1.5), gb.Clutch(capacity=20.0)), r"breaks away at no more \(20 N m\)"),
    ((gb.Clutch(capacity=gb.Table([0.0, 1.0], [1.0, 9.0])), gb.Clutch(capacity=5.0)), r"'c0'.*with numbers for capacity"),
    ((gb.Clutch(capacity=5.0), gb.Freewheel()), r"'c1'.*with numbers for capacity"),
])  # fmt: skip
def test_a_row_whose_weakest_element_the_numbers_do_not_tell_is_refused(
    elements: tuple[gb.Block, ...], rule: str
) -> None:
    with pytest.raises(gb.ModelError, match=rule + ".*put an Inertia there"):
        gb.build(_row(*elements))


@pytest.mark.long
def test_capacities_of_a_row_are_structural() -> None:
    rig = _row(gb.Clutch(capacity=15.0), gb.Clutch(capacity=20.0))
    with pytest.raises(gb.GearblocksError, match=r"'c1\.capacity'.*structural.*rig\.set"):
        gb.simulate(rig, t_end=0.1, parameters={"c1.capacity": 10.0})
    changed = gb.simulate(rig.set({"c1.capacity": 10.0}), t=T, rtol=1e-9)
    single = gb.simulate(_row(gb.Clutch(capacity=10.0)), t=T, rtol=1e-9)
    assert np.abs(changed["one.w"] - single["one.w"]).max() < 1e-8 * np.abs(single["one.w"]).max()


def _star(seed: int, arms: int, *, gaps: bool) -> tuple[gb.Drivetrain, np.ndarray]:
    """A body at rest, moving bodies around it, each behind a brake and a shaft; the torques of the brakes at t = 0 by hand."""
    random = np.random.default_rng(seed)
    rig = gb.Drivetrain("star")
    hub = rig.add("hub", gb.Inertia(J=1.0))
    w, share, c = random.uniform(-3, 3, arms), random.uniform(0.2, 1.0, arms), random.uniform(0.1, 0.5, arms)
    for i in range(arms):
        brake = rig.add(f"brake{i}", gb.Brake(capacity=gb.Table([0.0, 1.0, 2.0], [share[i], 0.9 * share[i], 0.0])))
        link = gb.Lash(k=1.0, c=c[i], half_gap=1.0, contact_damping="always") if gaps else gb.Shaft(k=1.0, c=c[i])
        link, body = rig.add(f"link{i}", link), rig.add(f"body{i}", gb.Inertia(J=1.0, w0=w[i]))
        rig.connect(hub.a, brake.a)
        rig.connect(brake.housing, link.a)
        rig.connect(link.b, body.a)
    return rig, -np.clip(c * w, -share, share)


@pytest.mark.parametrize("gaps", [False, pytest.param(True, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("seed", "arms"),
    [(4, 25), *(pytest.param(*of, marks=pytest.mark.long) for of in ((0, 1), (2, 4), *((s, 5) for s in range(6))))],
)
def test_friction_whose_capacity_is_a_table_over_time_starts_stuck_or_sliding(seed: int, arms: int, gaps: bool) -> None:
    """Of 25 arms, more slide than a search through sets of modes would come to."""
    rig, torques = _star(seed, arms, gaps=gaps)
    run = gb.simulate(rig, t_end=0.5, outputs=[f"brake{i}.torque" for i in range(arms)])
    assert [run[f"brake{i}.torque"][0] for i in range(arms)] == pytest.approx(torques, rel=1e-9)


@pytest.mark.parametrize("w", [-6.0, -2.0, 2.0, 6.0])
@pytest.mark.parametrize("nested", [False, True])
@pytest.mark.few(1)
def test_friction_whose_capacity_hangs_on_conditions_starts_stuck_or_sliding(w: float, nested: bool) -> None:
    """Conditions that are found first put off by a round which direction of the friction is decided."""
    capacity = gb.piecewise((0.8, gb.sense("hub.w") > -50.0), (0.1, True)) if nested else 0.8
    rig = gb.Drivetrain("conditions")
    brake = rig.add("brake", gb.Brake(capacity=gb.piecewise((capacity, gb.sense("body.w") > -100.0), (0.0, True))))
    link, body = rig.add("link", gb.Shaft(k=1.0, c=0.2)), rig.add("body", gb.Inertia(J=1.0, w0=w))
    rig.connect(rig.add("hub", gb.Inertia(J=1.0)).a, brake.a)
    rig.connect(brake.housing, link.a)
    rig.connect(link.b, body.a)
    run = gb.simulate(rig, t_end=0.01, outputs=["brake.torque"])
    assert run["brake.torque"][0] == pytest.approx(-np.clip(0.2 * w, -0.8, 0.8), rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas"])
@pytest.mark.parametrize(("capacity", "peak"), [(0.1, 1.2), pytest.param(0.08, 1.5, marks=pytest.mark.long)])
def test_a_static_peak_at_a_shaft_without_inertia_lets_go_at_the_speed_of_its_jump(
    capacity: float, peak: float, method: str
) -> None:
    """The torque of the gap falls by (peak - 1) F at once, and so the rate of its twist by that over c: slip from there."""
    rig = gb.Drivetrain("peak")
    pushed, driving = rig.add("pushed", gb.Inertia(J=1.0)), rig.add("driving", gb.Inertia(J=1.0))
    gap = rig.add("gap", gb.Lash(k=6.0, c=0.1, half_gap=0.02))
    brake = rig.add("brake", gb.Brake(capacity=capacity, peak=peak))
    rig.connect(pushed.a, gap.a)
    rig.connect(gap.b, brake.a)
    rig.connect(driving.a, brake.housing)
    rig.connect(driving.b, rig.add("load", gb.Torque(tau=-0.1)).flange)
    run = gb.simulate(rig, t_end=1.3, method=method, rtol=1e-8, outputs="*")
    (breaks,) = [e.t for e in run.events if e.component == "brake" and e.after != 0.0][:1]
    sticks = [e.t for e in run.events if e.component == "brake" and e.after == 0.0]
    assert not sticks or sticks[0] > breaks + 0.2
    after = np.flatnonzero(run.t > breaks)[:5]
    apart = np.abs(run["driving.w"] - run["pushed.w"])
    jump, fades = (peak - 1.0) * capacity / 0.1, np.exp(-6.0 / 0.1 * (run.t[after] - breaks))
    slip = apart[after] - (np.interp(breaks, run.t, apart) - jump) * fades  # as c x' + k x = F
    assert np.abs(run["brake.w_rel"][after]) == pytest.approx(slip, rel=1e-6)
    assert run["brake.torque"][after] == pytest.approx(np.full(len(after), capacity), rel=1e-9)
    assert run.stats.steps < 400
    assert run.energy.residual < 1e-7
