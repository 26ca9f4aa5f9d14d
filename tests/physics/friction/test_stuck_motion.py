"""What is stuck moves as one: no slip, no creep, the same bits."""

import numpy as np
import pytest

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


@pytest.mark.long
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


@pytest.mark.long
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
@pytest.mark.few(1)
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


@pytest.mark.long
def test_the_lock_of_a_planetary_does_not_creep_by_a_bit_in_a_million_seconds():
    rig = _planetary(2.0 * gb.sin(0.3 * gb.time), lock=("sun", "ring"))
    run = gb.simulate(rig, t=np.linspace(0, 1e6, 101), rtol=1e-4)
    assert run.events == ()
    assert len(set(run["lock.phi_rel"])) == 1
    assert (run["lock.w_rel"] == 0.0).all()


@pytest.mark.long
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


@pytest.mark.long
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


@pytest.mark.parametrize(
    ("way", "most", "slides"), [pytest.param(1.0, 3.0, 2.0, marks=pytest.mark.long), (-1.0, 5.0, 4.0)]
)
def test_friction_that_differs_forward_and_backward_breaks_away_and_slides_as_it_says(way, most, slides):
    rig = _chain(drive=gb.Torque(tau=way * gb.time), body=gb.Inertia(J=1.0), pad=OneSided())
    run = gb.simulate(rig, t_end=6.0)
    ((t, after),) = _modes(run, "pad")
    assert (t, after) == (pytest.approx(most, rel=1e-9), way)
    assert run["body.w"][-1] == pytest.approx(way * ((36 - most**2) / 2 - slides * (6 - most)), rel=1e-9)


@pytest.mark.long
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
