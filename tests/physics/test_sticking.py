"""Locks, friction and stops where one number decides: equality, shared loads, impacts."""

import numpy as np
import pytest
from scipy.optimize import brentq

import gearblocks as gb
from gearblocks.solver.structures import Options

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left
METHODS = [
    {"method": "dp5"},
    {"method": "dp8"},
    {"method": "rodas"},
    {"method": "auto"},
    {"method": "rk4", "step": 0.01},
]
EVERY_METHOD = pytest.mark.parametrize("options", METHODS, ids=lambda options: options["method"])


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode after) of one element."""
    return [(e.t, e.after) for e in run.events if e.component == name]


# -- what is stuck ----------------------------------------------------------------------------------------------------


@EVERY_METHOD
def test_a_clutch_stuck_to_a_shaft_of_prescribed_speed_has_no_slip_and_does_not_creep(options):
    rig = _chain(
        drive=gb.Speed(w=2.0 + gb.sin(3 * gb.time)), one=gb.Inertia(J=1.0), clutch=gb.Clutch(capacity=7.0),
        two=gb.Inertia(J=2.0, w0=2.0),
    )  # fmt: skip
    run = gb.simulate(rig, t_end=20.0, **options)
    assert run.events == ()
    assert np.array_equal(run["one.w"], run["two.w"])
    assert (run["clutch.w_rel"] == 0.0).all()
    assert len(set(run["clutch.phi_rel"])) == 1
    assert run["clutch.torque"] == pytest.approx(6.0 * np.cos(3 * run.t), abs=1e-12)  # J2 times the acceleration
    sampled = gb.simulate(rig, t=np.linspace(0, 20, 201), **options)
    assert (sampled["clutch.w_rel"] == 0.0).all()
    assert len(set(sampled["clutch.phi_rel"])) == 1


def test_implicit_steps_carry_a_prescribed_speed_through_a_stuck_clutch_to_their_order():
    rig = _chain(
        drive=gb.Speed(w=2.0 + gb.sin(3 * gb.time)), one=gb.Inertia(J=1.0), clutch=gb.Clutch(capacity=99.0),
        two=gb.Inertia(J=2.0, w0=2.0), shaft=gb.Shaft(k=50.0), end=gb.Inertia(J=1.0, w0=2.0),
    )  # fmt: skip
    true = gb.simulate(rig, t=[2.0], method="dp8", rtol=1e-12)
    errors = []
    for step in (0.04, 0.02):
        run = gb.simulate(rig, t=[2.0], method="rodas", step=step)
        errors.append([abs(run[x][0] - true[x][0]) for x in ("two.phi", "end.phi", "end.w")])
    assert true["two.phi"][0] == pytest.approx(4.0 + (1 - np.cos(6.0)) / 3, rel=1e-11)
    assert max(errors[0]) < 1e-5
    assert (np.array(errors[1]) < np.array(errors[0]) / 16).all()  # of order five, by 32 as steps shrink


@EVERY_METHOD
def test_bodies_that_springs_pull_apart_stay_together_to_the_last_bit_while_stuck(options):
    def rig(**middle):
        return _chain(
            wall=gb.Fixed(), left=gb.Shaft(k=300.0, c=2.0), **middle, right=gb.Shaft(k=700.0), end=gb.Inertia(J=3.0),
            drive=gb.Torque(tau=3.0 * gb.sin(2 * gb.time)),
        )  # fmt: skip

    t = np.linspace(0, 3, 301)
    options = {**options, "step": 1e-3} if "step" in options else options
    one, two = gb.Inertia(J=0.7, w0=1.0), gb.Inertia(J=1.9, w0=1.0)
    run = gb.simulate(rig(one=one, clutch=gb.Clutch(capacity=50.0), two=two), t=t, rtol=1e-8, **options)
    assert np.array_equal(run["one.w"], run["two.w"])
    assert len(set(run["clutch.phi_rel"])) == 1
    welded = gb.simulate(rig(body=gb.Inertia(J=2.6, w0=1.0)), t=t, rtol=1e-11)
    assert run["end.w"] == pytest.approx(welded["end.w"], abs=1e-6)  # 100 rtol: some ten swings


def _planetary(tau, **between):
    """Sun, carrier and ring of 2 kg m2 together, a torque on the sun; clutches of 9 N m between two members each."""
    rig = gb.Drivetrain("block")
    gear = rig.add("gear", gb.IdealPlanetary(ratio=2.3))
    body = {}
    for name, J in (("sun", 0.3), ("carrier", 1.0), ("ring", 0.7)):
        body[name] = rig.add(name, gb.Inertia(J=J))
        rig.connect(body[name].a, getattr(gear, name))
    rig.connect(rig.add("drive", gb.Torque(tau=tau)).flange, gear.sun)
    for name, (a, b) in between.items():
        clutch = rig.add(name, gb.Clutch(capacity=9.0))
        rig.connect(body[a].b, clutch.a)
        rig.connect(body[b].b, clutch.b)
    return rig


def test_the_lock_of_a_planetary_does_not_creep_by_a_bit_in_a_million_seconds():
    rig = _planetary(2.0 * gb.sin(0.3 * gb.time), lock=("sun", "ring"))
    run = gb.simulate(rig, t=np.linspace(0, 1e6, 101), rtol=1e-3)
    assert run.events == ()
    assert len(set(run["lock.phi_rel"])) == 1
    assert (run["lock.w_rel"] == 0.0).all()


def test_a_changed_inertia_or_capacity_acts_on_what_is_stuck_at_once():
    rig = _chain(
        drive=gb.Torque(tau=6.0), one=gb.Inertia(J=1.0), clutch=gb.Clutch(capacity=gb.Parameter("most", 10.0)),
        two=gb.Inertia(J=1.0),
    )  # fmt: skip
    model = gb.build(rig)
    speeds = [i for i, state in enumerate(model.program.states) if state.name in ("one.w", "two.w")]
    place = {p.path: i for i, p in enumerate(model.program.parameters)}
    with model.library.open() as sim:
        sim.parameters[:] = model.values
        sim.start(Options(2, 1, 1e-9, 0.0, np.inf, np.inf), 0.0)
        sim.advance(1.0)
        assert sim.state()[speeds] == pytest.approx(3.0, rel=EXACT)
        sim.parameters[place["two.J"]] = 5.0  # speeds stay, what follows is slower
        sim.changed()
        sim.advance(2.0)
        assert sim.state()[speeds] == pytest.approx(4.0, rel=EXACT)
        sim.parameters[place["most"]] = 1.0  # less than the 5 that it passes on
        sim.changed()
        sim.advance(3.0)
        assert sim.state()[speeds] == pytest.approx([9.0, 4.2], rel=EXACT)


def _in_step():
    """Two bodies whose speeds differ by one bit, their clutch pressed at 1 s, pulled on from 2 s."""
    pull = gb.piecewise((0.0, gb.time < 2), (0.05, True))
    return _chain(
        drive=gb.Torque(tau=pull), one=gb.Inertia(J=0.7, w0=0.1),
        clutch=gb.Clutch(capacity=gb.piecewise((0.0, gb.time < 1), (0.1, True))),
        two=gb.Inertia(J=1.9, w0=float(np.nextafter(0.1, 1.0))),
    )  # fmt: skip


def test_a_clutch_pressed_where_speeds_differ_by_rounding_sticks_at_once():
    run = gb.simulate(_in_step(), t_end=3.0)
    assert _modes(run, "clutch") == [(1.0, 0.0)]
    assert list(run["clutch.mode"][run.t == 1.0]) == [2.0, 0.0]  # without a moment of sliding between
    assert np.array_equal(run["one.w"][run.t > 1], run["two.w"][run.t > 1])


def test_a_saved_state_goes_on_with_the_same_bits_in_another_instance():
    model = gb.build(_in_step())
    with model.library.open() as sim, model.library.open() as other:
        sim.parameters[:] = model.values
        sim.start(Options(2, 1, 1e-6, 0.0, np.inf, np.inf), 0.0)
        sim.advance(0.4)
        other.restore(sim.save())
        for t in (0.5, 1.0, 3.0):
            sim.advance(t)
            other.advance(t)
            assert np.array_equal(sim.modes(), other.modes())
            assert np.array_equal(sim.state(), other.state())
        assert sim.save() == other.save()


class OneSided(gb.Block):
    """Friction with other numbers forward than backward."""

    a = gb.Flange("shaft")

    def physics(self, s):
        yield gb.Stick("", s.a.w, (-3.0, 5.0), sliding=(2.0, 4.0))


@pytest.mark.parametrize(("way", "most", "slides"), [(1.0, 3.0, 2.0), (-1.0, 5.0, 4.0)])
def test_friction_that_differs_forward_and_backward_breaks_away_and_slides_as_it_says(way, most, slides):
    rig = _chain(drive=gb.Torque(tau=way * gb.time), body=gb.Inertia(J=1.0), pad=OneSided())
    run = gb.simulate(rig, t_end=6.0)
    ((t, after),) = _modes(run, "pad")
    assert (t, after) == (pytest.approx(most, rel=1e-9), way)
    assert run["body.w"][-1] == pytest.approx(way * ((36 - most**2) / 2 - slides * (6 - most)), rel=1e-9)


def test_what_is_stuck_behind_gears_of_a_varying_ratio_turns_with_them():
    rig = gb.Drivetrain("pair")
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.3), external=True, k=None))
    one, two, three = (rig.add("one", gb.Inertia(J=1.0, w0=3.0)), rig.add("two", gb.Inertia(J=0.5)),
                       rig.add("three", gb.Inertia(J=0.8)))  # fmt: skip
    rig.connect(one.b, pair.a)
    rig.connect(pair.b, two.a)
    clutch = rig.add("clutch", gb.Clutch(capacity=gb.piecewise((100.0, gb.time < 0.01), (50.0, True))))
    rig.chain(two, clutch, three)
    run = gb.simulate(rig, t_end=10.0, rtol=1e-9)
    stuck = run["clutch.mode"] == 0.0
    assert stuck[run.t > 1.0].all()
    last = run.t > 1.0
    energy = (run["one.w"] ** 2 + 0.5 * run["two.w"] ** 2 + 0.8 * run["three.w"] ** 2)[last] / 2
    assert np.ptp(run["two.w"][last]) > 1.0
    assert run["three.w"][last] == pytest.approx(run["two.w"][last], abs=1e-14)
    assert energy == pytest.approx(energy[0], rel=1e-7)  # 10 s at rtol 1e-9
    assert len(set(run["clutch.phi_rel"][last])) == 1


# -- equality ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_torque_of_exactly_the_capacity_is_held_and_one_bit_more_is_not(way):
    tau = gb.Parameter("tau", 10.0)
    rig = _chain(drive=gb.Torque(tau=tau), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=10.0))
    held = gb.simulate(rig, t_end=10.0, parameters={"tau": way * 10.0})
    assert (held["body.phi"] == 0.0).all() and held.events == ()
    assert (held["brake.mode"] == 0.0).all()
    loose = gb.simulate(rig, t_end=10.0, parameters={"tau": way * 10.0 * (1 + 1e-9)})
    assert loose["brake.mode"][-1] == way
    assert loose["body.w"][-1] == pytest.approx(way * 1e-7, rel=1e-6)


def test_a_torque_that_exceeds_the_capacity_by_rounding_is_held():
    rig = _chain(drive=gb.Torque(tau=0.1 + 0.2), body=gb.Inertia(J=0.7), brake=gb.Brake(capacity=0.3))
    run = gb.simulate(rig, t_end=10.0)
    assert (run["brake.mode"] == 0.0).all() and (run["body.phi"] == 0.0).all()


def test_a_stuck_clutch_holds_what_friction_at_rest_says_not_that_of_a_slip():
    mu = gb.Table([0.0, 1.0], [0.5, 0.2])
    clutch = gb.Clutch(mu=mu, force_max=8.0, engagement=1.0)
    run = gb.simulate(
        _chain(drive=gb.Torque(tau=gb.time), body=gb.Inertia(J=1.0), clutch=clutch, end=gb.Fixed()), t_end=4.5
    )
    ((t, after),) = _modes(run, "clutch")
    assert (t, after) == (pytest.approx(4.0, rel=1e-9), -1.0)


# -- one event after another ------------------------------------------------------------------------------------------


@EVERY_METHOD
def test_a_swinging_torque_breaks_a_body_away_until_it_has_given_its_speed_back(options):
    rig = _chain(drive=gb.Torque(tau=5.0 * gb.sin(gb.time)), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=3.0))
    run = gb.simulate(rig, t_end=10.0, rtol=1e-10, **options)
    away = float(np.arcsin(0.6))
    stop = brentq(lambda t: 5 * (np.cos(away) - np.cos(t)) - 3 * (t - away), 2.0, 3.7)
    found = _modes(run, "brake")
    assert [mode for _, mode in found] == [1.0, 0.0, -1.0, 0.0, 1.0, 0.0]
    assert [t for t, _ in found] == pytest.approx([x + i * np.pi for i in range(3) for x in (away, stop)], rel=1e-7)


def test_a_body_pushed_back_through_rest_goes_on_through_what_happens_later():
    push = gb.piecewise((-5.0, gb.time < 1), (-1.0, True))
    rig = _chain(drive=gb.Torque(tau=push), body=gb.Inertia(J=1.0, w0=1.4), brake=gb.Brake(capacity=2.0))
    run = gb.simulate(rig, t=[2.0])
    assert _modes(run, "brake") == [(pytest.approx(0.2, rel=EXACT), -1.0)]
    assert run["body.w"][0] == pytest.approx(-3 * 0.8 + 1.0, rel=EXACT)


# -- what comes at once -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("load", "capacity"), [(3.0, 2.0), (2.0, 3.0)])
def test_where_load_and_capacity_rise_from_nothing_together_the_stronger_wins(way, load, capacity):
    rise = gb.piecewise((0.0, gb.time < 1), (gb.time - 1, True))
    rig = _chain(
        drive=gb.Torque(tau=way * load * rise), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=capacity * rise)
    )
    run = gb.simulate(rig, t_end=3.0)
    assert run["body.w"][-1] == pytest.approx(way * max(load - capacity, 0.0) * 2.0, rel=1e-9, abs=1e-15)
    assert run["brake.mode"][-1] == (way if load > capacity else 0.0)


@pytest.mark.parametrize("w0", [10.0, 0.0])
def test_a_clutch_whose_capacity_comes_down_to_nothing_is_free_until_it_rises_again(w0):
    capacity = gb.Table([0, 1, 2, 3], [6.0, 0.0, 0.0, 6.0])
    rig = _chain(
        drive=gb.Torque(tau=1.0),
        one=gb.Inertia(J=1.0, w0=w0),
        clutch=gb.Clutch(capacity=capacity),
        two=gb.Inertia(J=1.0),
    )
    run = gb.simulate(rig, t=[0.5, 1.5, 1.9, 2.5])
    assert list(run["clutch.mode"]) == [-1.0 if w0 else 0.0, 2.0, 2.0, -1.0]
    assert run["two.w"][2] == run["two.w"][1]
    assert run["two.w"][3] - run["two.w"][2] == pytest.approx(0.75, rel=EXACT)  # 6 (t - 2) for half a second
    assert _modes(run, "clutch")[-2:] == [(1.0, 2.0), (2.0, -1.0)]


def test_without_location_what_meets_its_speed_sticks_at_the_end_of_the_step():
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), clutch=gb.Clutch(capacity=5.0), two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t_end=3.0, method="rk4", step=1e-3, locate=False)
    assert run["clutch.mode"][-1] == 0.0
    # locks up to a step late, in which the slip turns by 10 rad/s2 times 1 ms
    assert run["one.w"][-1] == run["two.w"][-1] == pytest.approx(5.0, abs=1e-2)
    assert [after for _, after in _modes(run, "clutch")] == [0.0]


# -- shared loads -----------------------------------------------------------------------------------------------------


def _two_brakes(tau, one, two):
    rig = gb.Drivetrain("two brakes")
    body = rig.add("body", gb.Inertia(J=1.0))
    left, right = rig.add("left", gb.Brake(capacity=one)), rig.add("right", gb.Brake(capacity=two))
    rig.connect(rig.add("drive", gb.Torque(tau=tau)).flange, body.a, left.a, right.a)
    return rig


@pytest.mark.parametrize(("tau", "shares"), [(3.0, (1.5, 1.5)), (5.0, (3.0, 2.0)), (-5.5, (-3.5, -2.0))])
def test_two_brakes_share_a_load_evenly_and_the_stronger_takes_what_the_weaker_cannot(tau, shares):
    run = gb.simulate(_two_brakes(tau, 4.0, 2.0), t_end=1.0)
    assert run.events == ()
    for name, share in zip(("left", "right"), shares, strict=True):
        assert run[f"{name}.torque"] == pytest.approx(share, rel=1e-9)


def test_two_brakes_share_a_load_that_swings_without_an_event():
    t = np.linspace(0, 20, 201)
    run = gb.simulate(_two_brakes(5.7 * gb.sin(3 * gb.time), 4.0, 2.0), t=t)
    assert run.events == ()
    assert run["left.torque"] + run["right.torque"] == pytest.approx(5.7 * np.sin(3 * t), abs=1e-8)
    assert np.abs(run["right.torque"]).max() <= 2.0 and (run["body.phi"] == 0.0).all()


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_two_brakes_let_go_together_at_the_sum_of_what_they_hold(way):
    run = gb.simulate(_two_brakes(way * gb.time, 4.0, 2.0), t_end=8.0)
    for name in ("left", "right"):
        ((t, after),) = _modes(run, name)
        assert (t, after) == (pytest.approx(6.0, rel=1e-9), way)
    assert run["body.w"][-1] == pytest.approx(way * 2.0, rel=1e-8)


def test_three_clutches_that_lock_a_planetary_twice_over_turn_it_as_one_body():
    rig = _planetary(4.0, one=("sun", "carrier"), two=("carrier", "ring"), three=("sun", "ring"))
    run = gb.simulate(rig, t_end=1.0)
    assert run.events == ()
    for name in ("sun", "carrier", "ring"):
        assert run[f"{name}.w"][-1] == pytest.approx(2.0, rel=EXACT)
    assert max(np.abs(run[f"{name}.torque"]).max() for name in ("one", "two", "three")) < 4.0


def test_clutches_of_gears_that_close_a_loop_hold_as_two_of_them_do():
    rig = gb.Drivetrain("loop")
    body = [rig.add(f"body{i}", gb.Inertia(J=J)) for i, J in enumerate((1.0, 2.0, 0.5))]
    rig.connect(rig.add("drive", gb.Torque(tau=9.0)).flange, body[0].a)
    for i, (one, two, teeth) in enumerate(((0, 1, (30, 70)), (1, 2, (70, 110)), (0, 2, (30, 110)))):
        clutch = rig.add(f"clutch{i}", gb.Clutch(capacity=20.0))
        gear = rig.add(f"gear{i}", gb.IdealGear(teeth=teeth, external=False))
        rig.connect(body[one].b, clutch.a)
        rig.connect(clutch.b, gear.a)
        rig.connect(gear.b, body[two].b)
    run = gb.simulate(rig, t_end=1.0)
    assert run.events == ()
    alpha = 9.0 / (1.0 + 2.0 * (3 / 7) ** 2 + 0.5 * (3 / 11) ** 2)
    for i, ratio in enumerate((1.0, 3 / 7, 3 / 11)):
        assert run[f"body{i}.w"][-1] == pytest.approx(alpha * ratio, rel=EXACT)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_of_three_brakes_on_a_planetary_the_weak_ones_slide_and_the_strong_one_holds(way):
    rig = gb.Drivetrain("three brakes")
    gear = rig.add("gear", gb.IdealPlanetary(ratio=2.0))
    for name, J, capacity in (("sun", 0.1, 1.0), ("carrier", 1.0, 100.0), ("ring", 0.8, 2.0)):
        body = rig.add(name, gb.Inertia(J=J))
        rig.connect(body.a, getattr(gear, name), rig.add(f"{name}_brake", gb.Brake(capacity=capacity)).a)
    rig.connect(rig.add("drive", gb.Torque(tau=way * gb.time)).flange, gear.sun)
    run = gb.simulate(rig, t_end=3.0)
    assert _modes(run, "sun_brake") == [(pytest.approx(2.0, rel=1e-9), way)]  # 1 of its own, 2 of the ring by half
    assert _modes(run, "ring_brake") == [(pytest.approx(2.0, rel=1e-9), -way)]
    assert (run["carrier_brake.mode"] == 0.0).all() and (run["carrier.phi"] == 0.0).all()
    assert run["sun.w"][-1] == pytest.approx(way * 0.5 / (0.1 + 0.8 / 4), rel=1e-9)


# -- impacts ----------------------------------------------------------------------------------------------------------


def test_a_freewheel_passes_the_impact_of_a_stop_on_to_what_drives_it():
    rig = gb.Drivetrain("halt")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("two", gb.Inertia(J=3.0, w0=2.0))
    rig.chain(one, rig.add("wheel", gb.Freewheel()), two)
    rig.connect(rig.add("stop", gb.HardStop(upper=1.0, restitution=0.0)).a, two.b)
    run = gb.simulate(rig, t=[0.4, 0.6, 2.0])
    assert run["one.w"] == pytest.approx([2.0, 0.0, 0.0], abs=1e-14)
    assert run["two.w"] == pytest.approx([2.0, 0.0, 0.0], abs=1e-14)
    assert run["stop.impulse"][-1] == pytest.approx(8.0, rel=EXACT)
    assert sum(run.energy.dissipated.values()) == pytest.approx(8.0, rel=EXACT)


def test_a_body_at_its_stop_that_is_pulled_away_leaves_at_once():
    stop = gb.HardStop(lower=0.0, restitution=0.5)
    rig = _chain(drive=gb.Torque(tau=gb.Parameter("tau", 1.0)), body=gb.Inertia(J=2.0), stop=stop)
    assert gb.simulate(rig, t=[1.0])["body.phi"][0] == pytest.approx(0.25, rel=EXACT)
    assert gb.simulate(rig, t=[1.0], parameters={"tau": -1.0})["body.phi"][0] == 0.0


@pytest.mark.parametrize("block", [gb.Clutch(capacity=gb.time - 0.2), gb.Clutch(capacity=gb.sin(gb.time - 0.2))])
def test_a_clutch_whose_capacity_rises_from_below_zero_takes_hold(block):
    rig = gb.Drivetrain("train")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=1.0)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(one, rig.add("clutch", block), two)
    run = gb.simulate(rig, t_end=0.5)
    ((t, before, after),) = [(e.t, e.before, e.after) for e in run.events if e.component == "clutch"]
    assert (t, before, after) == (pytest.approx(0.2, rel=1e-9), 2.0, -1.0)
    given = 0.3**2 / 2 if block.capacity.op != "sin" else 1 - np.cos(0.3)
    assert run["two.w"][-1] == pytest.approx(given, rel=1e-6)
