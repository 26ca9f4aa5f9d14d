"""Impacts that cause each other at one instant: a contact that opens is not hit until an impulse has turned it around.

Closed form: impacts of two bodies at a time, one after the other, by momentum and Newton's restitution. One
complementarity problem for all that touch would let what leaves be pulled along, and energy would come from nowhere.
"""

import numpy as np
import pytest

import gearblocks as gb

EXACT = 1e-12


def _in_turn(J: tuple[float, float], w: list[float], wall: float, between: float) -> list[float]:
    """Speeds after body 1, which a wall stops, and body 2 behind it have hit all they can."""
    for _ in range(10000):
        if w[0] > EXACT:
            w = [-wall * w[0], w[1]]
        elif w[1] - w[0] > EXACT:
            common = (J[0] * w[0] + J[1] * w[1]) / (J[0] + J[1])
            apart = between * (w[1] - w[0]) / (J[0] + J[1])
            w = [common + J[1] * apart, common - J[0] * apart]
        else:
            break
    return w


def _energy(J, w):
    return 0.5 * sum(j * v * v for j, v in zip(J, w, strict=True))


def _pair(J, w, wall, between, ratio=1.0):
    """Two bodies that touch; the first one stands at its wall, behind a gear."""
    rig = gb.Drivetrain("in turn")
    one, two = (rig.add(n, gb.Inertia(J=j, w0=v)) for n, j, v in zip(("one", "two"), J, w, strict=True))
    touching = rig.add("between", gb.HardStop(restitution=between, upper=0.0))
    stop = rig.add("wall", gb.HardStop(restitution=wall, upper=0.0))
    rig.connect(touching.a, one.a)
    rig.connect(touching.b, two.a)
    if ratio == 1.0:
        rig.connect(stop.a, one.b)
    else:
        gear = rig.add("gear", gb.IdealGear(ratio=ratio))
        rig.connect(one.b, gear.b)
        rig.connect(gear.a, stop.a)
    return rig


@pytest.mark.parametrize("ratio", [1.0, 2.5])
@pytest.mark.parametrize(
    ("J", "w", "wall", "between"),
    [
        ((1.0, 1.0), [1.0, 0.0], 1.0, 0.0),
        ((0.994, 0.4), [13.7, 0.0], 0.161, 0.0),
        ((1.0, 3.0), [2.0, 0.5], 0.8, 0.4),
        ((0.2, 5.0), [3.0, 1.0], 0.9, 0.7),
        ((1.0, 7.0), [1.0, 0.2], 1.0, 1.0),
    ],
)
@pytest.mark.few(3)
def test_what_a_wall_throws_back_hits_what_it_was_leaving(J, w, wall, between, ratio):
    run = gb.simulate(_pair(J, w, wall, between, ratio), t=[0.0, 0.1])
    expected = _in_turn(J, list(w), wall, between)
    assert [run["one.w"][-1], run["two.w"][-1]] == pytest.approx(expected, rel=1e-11, abs=1e-12)
    assert _energy(J, [run["one.w"][-1], run["two.w"][-1]]) <= _energy(J, w) * (1 + EXACT)


@pytest.mark.long
def test_a_freewheel_that_overruns_is_caught_by_what_comes_back():
    rig = gb.Drivetrain("freewheel")
    one, two = rig.add("one", gb.Inertia(J=2.0, w0=3.0)), rig.add("two", gb.Inertia(J=1.0, w0=1.0))
    wheel = rig.add("wheel", gb.Freewheel())
    rig.connect(one.a, rig.add("wall", gb.HardStop(restitution=0.5, upper=0.0)).a)
    rig.connect(two.a, wheel.a)
    rig.connect(one.b, wheel.b)
    run = gb.simulate(rig, t=[0.0, 0.1])
    common = (2.0 * -1.5 + 1.0) / 3.0  # the freewheel drives b forward only, so a that runs ahead takes it along
    assert [run["one.w"][-1], run["two.w"][-1]] == pytest.approx([common, common], rel=EXACT)


@pytest.mark.long
@pytest.mark.parametrize("e", [1.0, 0.4])
@pytest.mark.parametrize(("m", "M", "ahead", "V"), [(1.0, 1.0, 1e-3, 2.0), (0.3, 2.0, 0.5, 1.5), (4.0, 1.0, 0.2, 3.0)])
def test_what_an_impact_throws_back_against_its_one_way_lock_is_caught_there(m, M, ahead, V, e):
    # one problem for both would throw M back with e (ahead + V) while m rests: energy from nowhere where m is slow or light
    rig = gb.Drivetrain("thrown back")
    one, two = rig.add("one", gb.Inertia(J=m, w0=ahead)), rig.add("two", gb.Inertia(J=M, w0=-V))
    between = rig.add("between", gb.HardStop(restitution=e, lower=0.0))
    lock = rig.add("lock", gb.Freewheel())
    rig.connect(between.a, one.a)
    rig.connect(between.b, two.a)
    rig.connect(rig.add("ground", gb.Fixed()).flange, lock.a)
    rig.connect(lock.b, one.b)
    run = gb.simulate(rig, t=[0.0, 0.1])
    common, apart = (m * ahead - M * V) / (m + M), e * (V + ahead) / (m + M)
    assert common - M * apart < 0.0  # thrown back, were it free
    rebound = common + m * apart
    while rebound < 0.0:  # hits once more what rests by now
        rebound *= -e
    assert [run["one.w"][-1], run["two.w"][-1]] == pytest.approx([0.0, rebound], rel=1e-11, abs=1e-12)
    assert _energy((m, M), [0.0, rebound]) <= _energy((m, M), [ahead, -V])


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "rodas"])
@pytest.mark.parametrize("gap", [1e-15, 3e-14])
@pytest.mark.parametrize(("J", "w", "wall"), [((1.0, 1.0), (1.0, 2.0), 0.5), ((0.994, 0.4), (0.2, 4.0), 0.3)])
def test_a_short_flight_to_another_body_is_no_hammering(J, w, wall, gap, method):
    """A body comes back to its wall at once since another one, a hair behind, runs into it: both rebound together."""
    rig = gb.Drivetrain("hair")
    one, two = (rig.add(n, gb.Inertia(J=j, w0=v)) for n, j, v in zip(("one", "two"), J, w, strict=True))
    between = rig.add("between", gb.HardStop(restitution=0.0, upper=gap))
    rig.connect(between.a, one.a)
    rig.connect(between.b, two.a)
    rig.connect(rig.add("wall", gb.HardStop(restitution=wall, upper=0.0)).a, one.b)
    run = gb.simulate(rig, t=np.linspace(0.0, 0.1, 3), method=method)
    common = (J[0] * -wall * w[0] + J[1] * w[1]) / sum(J)
    assert common > 0.0
    assert [run["one.w"][-1], run["two.w"][-1]] == pytest.approx([-wall * common] * 2, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp8", "rodas"])
@pytest.mark.parametrize("pull", [1e-10, 1e-4, 0.3])
@pytest.mark.parametrize(
    ("J", "wall", "between"),
    [
        ((1.0, 3.0), 0.0, 1.0),
        ((0.2, 2.6), 0.0, 0.7),
        ((1.0, 200.0), 0.0, 0.9),
        ((2.0, 1.0), 0.0, 1.0),
        ((1.0, 5.0), 0.6, 1.0),
    ],
)
def test_a_body_that_is_pulled_off_its_wall_is_struck_apart_from_it(J, wall, between, pull, method):
    """Torn off by next to nothing or by more: it is driven back onto its wall, and struck again, until nothing is left."""
    V, rest = 2.0, 1.0
    rig = gb.Drivetrain("torn off")
    one = rig.add("one", gb.Inertia(J=J[0], phi0=rest))
    two = rig.add("two", gb.Inertia(J=J[1], phi0=rest - 1e-3 * V, w0=V))
    touching = rig.add("between", gb.HardStop(restitution=between, upper=0.0))
    rig.connect(touching.a, one.a)
    rig.connect(touching.b, two.a)
    stop, load = rig.add("wall", gb.HardStop(restitution=wall, upper=rest)), rig.add("load", gb.Torque(tau=-pull))
    rig.connect(one.b, stop.a, load.flange)
    run = gb.simulate(rig, t=[0.0, 2e-3], method=method)
    expected = _in_turn(J, [0.0, V], wall, between)
    assert [run["one.w"][-1], run["two.w"][-1]] == pytest.approx(expected, rel=1e-3 * pull, abs=2e-3 * pull + 1e-9)


@pytest.mark.long
@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_a_body_that_another_hammers_against_its_wall_comes_to_rest(restitution):
    """Only the outer body is loaded; the inner one flies between it and the wall without any force of its own."""
    rig = gb.Drivetrain("hammer")
    inner, outer = rig.add("inner", gb.Inertia(J=1.0)), rig.add("outer", gb.Inertia(J=2.0))
    rig.chain(rig.add("drive", gb.Torque(tau=3.0)), outer)
    between = rig.add("between", gb.HardStop(restitution=restitution, upper=0.05))
    rig.connect(between.a, inner.a)
    rig.connect(between.b, outer.b)
    rig.connect(rig.add("wall", gb.HardStop(restitution=restitution, upper=0.1)).a, inner.b)
    run = gb.simulate(rig, t=[0.0, 10.0])
    assert run["inner.phi"][-1] == pytest.approx(0.1, rel=1e-13)
    assert run["outer.phi"][-1] == pytest.approx(0.15, rel=1e-13)
    assert [run["inner.w"][-1], run["outer.w"][-1]] == [0.0, 0.0]
    assert sum(run.energy.dissipated.values()) == pytest.approx(3.0 * 0.15, rel=1e-9)
    assert len(run.events) < 2000


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.parametrize(
    ("J", "load"), [((2.0, 0.1), (140.0, 20.0)), ((1.0, 1.0), (3.0, 1.0)), ((0.3, 0.05), (9.0, 8.0))]
)
@pytest.mark.few(3)
def test_two_stops_without_restitution_that_open_each_other_come_to_rest(J, load, method):
    """The outer body throws the inner one off its wall, which stops it again and lets the outer one fly on: speeds fall
    by J2 / (J1 + J2) a turn or so, in a finite time, and what the loads have done is lost."""
    rig = gb.Drivetrain("in turn")
    inner, outer = (rig.add(n, gb.Inertia(J=j)) for n, j in zip(("inner", "outer"), J, strict=True))
    rig.chain(rig.add("presses", gb.Torque(tau=load[0])), inner)
    rig.chain(rig.add("pulls", gb.Torque(tau=-load[1])), outer)
    between = rig.add("between", gb.HardStop(restitution=0.0, lower=-0.3))
    rig.connect(between.a, inner.a)
    rig.connect(between.b, outer.b)
    rig.connect(rig.add("wall", gb.HardStop(restitution=0.0, upper=0.1)).a, inner.b)
    run = gb.simulate(rig, t=[0.0, 5.0], method=method)
    assert [run["inner.phi"][-1], run["outer.phi"][-1]] == pytest.approx([0.1, -0.2], rel=1e-9)
    assert [run["inner.w"][-1], run["outer.w"][-1]] == [0.0, 0.0]
    assert sum(run.energy.dissipated.values()) == pytest.approx(0.1 * load[0] + 0.2 * load[1], rel=1e-8)
    assert len(run.events) < 200


@pytest.mark.parametrize(("first", "second", "third"), [(2.88, 0.12, 0.113), (1.0, 0.5, 0.2), (0.4, 0.3, 0.05)])
def test_a_one_way_lock_that_one_strike_opens_and_the_next_one_takes_up_again_loses_at_it(first, second, third):
    """The sun of a planetary set comes to its stop, bounces into a freewheel to the ring, and that throws the ring back
    onto a one-way clutch that the bounce has just opened: three strikes at one instant, each with its loss."""
    rig = gb.Drivetrain("in turn")
    ring, behind = (rig.add(n, gb.Inertia(J=J, w0=0.0)) for n, J in (("ring", first), ("behind", second)))
    carrier, sun = rig.add("carrier", gb.Inertia(J=third)), rig.add("sun", gb.Inertia(J=0.2, phi0=0.1, w0=-1.3))
    gear = rig.add("gear", gb.IdealPlanetary(ratio=1.5))
    clutch, wheel = rig.add("clutch", gb.OneWayClutch(capacity=13.0)), rig.add("wheel", gb.Freewheel())
    stop = rig.add("stop", gb.HardStop(lower=0.0, restitution=0.581))
    rig.connect(sun.a, gear.sun, stop.a, wheel.a)
    rig.connect(carrier.a, gear.carrier)
    rig.connect(ring.a, gear.ring, clutch.a, wheel.b)
    rig.connect(clutch.b, behind.a)
    rig.chain(rig.add("load", gb.Torque(tau=-0.55)), behind)
    rig.connect(ring.b, rig.add("brake", gb.Brake(capacity=5.0)).a)
    run = gb.simulate(rig, t_end=0.2, rtol=1e-9)
    assert [event.component for event in run.events if event.kind == "impact"][:3] == ["stop.lower", "wheel", "clutch"]
    moving = sum(run[f"{name}.kinetic_energy"] for name in ("ring", "behind", "carrier", "sun"))
    assert moving[-1] < 0.9 * moving[0] and run.energy.residual < 1e-9
