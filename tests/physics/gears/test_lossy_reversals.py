"""Lossy gears as their torque turns, their speed turns, and at both: closed forms of one gear between two bodies.

With u = J_b alpha/ratio - load/ratio, the torque that leaves, and x what enters (direction 1):
    x = (u + tau1)/eta1 driving, (u + tau2) eta2 driven,   J_a ratio alpha = torque - x,   alpha that of b.
"""

import numpy as np
import pytest

import gearblocks as gb

METHODS = pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])


def _train(torque, load=0.0, *, J=(1.0, 1.0), w0=0.0, ratio=3.0, shaft=None, **losses):
    """Torque - one - gear - two - load, with a shaft and a third body in front of the load where there is one."""
    rig = gb.Drivetrain("train")
    parts = [
        rig.add("torque", gb.Torque(tau=torque)), rig.add("one", gb.Inertia(J=J[0], w0=ratio * w0)),
        rig.add("gear", losses.get("gear") or gb.LossyGear(ratio=ratio, **losses)),
        rig.add("two", gb.Inertia(J=J[1], w0=w0)),
    ]  # fmt: skip
    if shaft is not None:
        parts += [rig.add("shaft", gb.Shaft(k=shaft)), rig.add("three", gb.Inertia(J=1.0, w0=w0))]
    rig.chain(*parts, rig.add("load", gb.Torque(tau=load)))
    return rig


@METHODS
@pytest.mark.parametrize("ratio", [3.0, -0.5])
@pytest.mark.parametrize("eta", [(0.9, 0.9), (1.0, 1.0), (0.6, 0.95)])
@pytest.mark.few(1)
def test_a_sine_at_b_turns_the_torque_of_a_gear_that_turns_on(eta, ratio, method):
    """b turns with about 1 rad/s all the time: a forward torque at b drives a, against a backward one a drives b."""
    run = gb.simulate(_train(0.0, gb.sin(20 * gb.time), w0=1.0, ratio=ratio, efficiency=eta), t_end=2.0, method=method)
    forward, backward = 1 / (1 + ratio**2 / eta[1]), 1 / (1 + ratio**2 * eta[0])
    t = run.t
    half = np.floor(20 * t / np.pi)
    whole, rest = np.divmod(half, 2)
    cosine = (1 - np.cos(20 * t - half * np.pi)) / 20
    true = (
        1.0
        + 0.1 * whole * (forward - backward)
        + np.where(rest == 0, forward * cosine, 0.1 * forward - backward * cosine)
    )
    assert run["two.w"] == pytest.approx(true, abs=2e-5)
    assert run.energy.residual < 2e-5 and run.events == ()


@pytest.mark.long
@METHODS
@pytest.mark.parametrize("eta", [(0.9, 0.9), (1.0, 1.0)])
def test_a_compliant_shaft_beside_turns_the_torque_many_times(eta, method):
    """Between two looks at tolerance 1e-9 and the default nothing differs but their tolerance."""
    rig = _train(0.0, gb.sin(20 * gb.time), w0=1.0, shaft=4000.0, efficiency=eta)
    at = np.linspace(0.0, 1.0, 21)
    true = gb.simulate(rig, t=at, method="dp8", rtol=1e-11)
    run = gb.simulate(rig, t=at, method=method)
    for name in ("one.w", "two.w", "three.w"):
        assert run[name] == pytest.approx(true[name], abs=3e-5)
    if eta == (1.0, 1.0):  # an ideal gear is the same train
        ideal = _train(0.0, gb.sin(20 * gb.time), w0=1.0, shaft=4000.0, gear=gb.IdealGear(ratio=3.0))
        assert run["three.w"] == pytest.approx(gb.simulate(ideal, t=at, rtol=1e-11)["three.w"], abs=3e-5)


def _ramp(tau, t_end, method):
    """Speed of b after a torque at a from 6 N m to -2, or back, in four seconds; a gear of ratio 2."""
    torque = 6.0 - 2 * gb.time if tau[0] > 0 else -2.0 + 2 * gb.time
    rig = _train(torque, J=(0.5, 3.0), w0=50.0, ratio=2.0, efficiency=(0.9, 0.8), bearing=tau[1:])
    return gb.simulate(rig, t_end=t_end, rtol=1e-9, method=method)["two.w"][-1]


def _gain(torque, start, end, driven, tau):
    """Speed that b gains as the torque goes from start to end at 2 N m/s on one side: driving, driven, or where nothing
    enters."""
    if driven is None:
        factor, constant = 1 / (2 * 0.5), 0.0
    else:
        c = 0.8 if driven else 1 / 0.9
        factor = 1 / (2 * 0.5 + 3.0 * c / 2)
        constant = -c * tau * factor
    return abs(end - start) / 2 * (factor * (start + end) / 2 + constant) if torque else 0.0


@pytest.mark.long
@METHODS
def test_bearing_losses_that_are_larger_where_b_drives_leave_a_gap_in_which_nothing_enters(method):
    """-u between tau1 = 0.4 and tau2 = 1: one turns alone, and b with it, as J_a ratio^2/J_b of -tau says: 0.267, 0.667."""
    on, off = -0.4 * 4 * 0.5 / 3, -1.0 * 4 * 0.5 / 3
    down = _gain(1, 6.0, on, False, 0.4) + _gain(1, on, off, None, 0.0) + _gain(1, off, -2.0, True, 1.0)
    assert _ramp((1, 0.4, 1.0), 4.0, method) == pytest.approx(50.0 + down, rel=1e-8)
    up = _gain(1, -2.0, off, True, 1.0) + _gain(1, off, on, None, 0.0) + _gain(1, on, 6.0, False, 0.4)
    assert _ramp((-1, 0.4, 1.0), 4.0, method) == pytest.approx(50.0 + up, rel=1e-8)


@pytest.mark.long
@METHODS
def test_bearing_losses_that_are_larger_where_a_drives_keep_the_side_that_is_present(method):
    """Between -tau1 and -tau2 both sides hold: down it drives until -0.667 N m, up it is driven until -0.267."""
    low, high = -1.0 * 4 * 0.5 / 3, -0.4 * 4 * 0.5 / 3
    down = _gain(1, 6.0, low, False, 1.0) + _gain(1, low, -2.0, True, 0.4)
    assert _ramp((1, 1.0, 0.4), 4.0, method) == pytest.approx(50.0 + down, rel=1e-8)
    up = _gain(1, -2.0, high, True, 0.4) + _gain(1, high, 6.0, False, 1.0)
    assert _ramp((-1, 1.0, 0.4), 4.0, method) == pytest.approx(50.0 + up, rel=1e-8)


@pytest.mark.long
@METHODS
@pytest.mark.parametrize("ratio", [2.0, -2.0])
def test_a_loaded_gear_turns_back_with_the_losses_of_each_direction(ratio, method):
    """10 N m at a against a body that comes backward: it is driven until it stops, then drives."""
    sign = np.sign(ratio)
    rig = _train(10.0, J=(0.5, 3.0), w0=-4.0 * sign, ratio=ratio, efficiency=(0.9, 0.8), bearing=(0.2, 0.1))
    run = gb.simulate(rig, t_end=3.0, rtol=1e-9, method=method)
    # backward (direction -1): u = J_b alpha/ratio > 0, so b drives: x = (u - tau2) eta2; forward x = (u + tau1)/eta1
    before = (10.0 + 0.1 * 0.8) / (2 * 0.5 + 3.0 * 0.8 / 2)
    after = (10.0 - 0.2 / 0.9) / (2 * 0.5 + 3.0 / 0.9 / 2)
    stop = 4.0 / before
    assert [(e.t, e.after) for e in run.events if e.component == "gear"] == [(pytest.approx(stop, rel=1e-9), 1.0)]
    assert run["two.w"][-1] == pytest.approx(sign * after * (3.0 - stop), rel=1e-8)
    assert run.energy.residual < 1e-8


@pytest.mark.long
@METHODS
def test_torque_and_speed_that_turn_at_one_instant_leave_the_gear_at_rest_or_turning_as_the_torque_goes_on(method):
    """Without losses: after 20 sin(10 t) from rest both vanish at every whole cycle, after 20 cos(10 t) in turn."""
    rig = _train(20 * gb.sin(10 * gb.time), J=(1.0, 1.0), ratio=1.0, efficiency=(1.0, 1.0))
    run = gb.simulate(rig, t_end=2.0, method=method, rtol=1e-8)
    assert run["two.w"] == pytest.approx((1 - np.cos(10 * run.t)), abs=1e-6)
    rig = _train(20 * gb.cos(10 * gb.time), J=(1.0, 1.0), ratio=1.0, efficiency=(1.0, 1.0))
    run = gb.simulate(rig, t_end=2.0, method=method, rtol=1e-8)
    assert run["two.w"] == pytest.approx(np.sin(10 * run.t), abs=1e-6)


@METHODS
def test_a_worm_pushed_on_by_its_wheel_asks_for_torque_and_locks_when_it_stands(method):
    """Self-locking, eta2 = -0.3: u < 0 pushes on, and x = -0.3 u > 0 brakes the worm all the same."""
    rig = _train(0.0, 20.0, J=(0.05, 1.0), w0=3.0, ratio=10.0, efficiency=(0.4, -0.3))
    run = gb.simulate(rig, t_end=3.0, method=method, rtol=1e-9)
    # J_b alpha = load + ratio u and J_a ratio alpha = -x = -eta2 u
    u = -20.0 * 0.05 * 10.0 / (0.05 * 10.0 * 10.0 + -0.3)
    alpha = 20.0 + 10.0 * u
    assert alpha < 0.0
    assert [(e.t, e.after) for e in run.events] == [(pytest.approx(-3.0 / alpha, rel=1e-8), 0.0)]
    assert run["two.w"][-1] == 0.0 and run.energy.residual < 1e-7


def test_a_worm_that_jams_while_it_turns_is_refused_with_the_reason():
    """J_a ratio^2 = 0.1 is less than 0.3 J_b: what the wheel adds to the friction is more than what it slows."""
    rig = _train(0.0, 20.0, J=(0.001, 1.0), w0=3.0, ratio=10.0, efficiency=(0.4, -0.3))
    with pytest.raises(gb.SimulationError, match="'gear': no motion agrees with its losses: it jams while it turns"):
        gb.simulate(rig, t_end=1.0)


@pytest.mark.parametrize(("lead", "mu"), [(0.3, 0.05), (0.15, 0.08), (0.1, 0.2)])
def test_the_efficiencies_of_a_worm_are_those_of_an_inclined_plane(lead, mu):
    """tan(gamma)/tan(gamma + rho) and tan(gamma - rho)/tan(gamma), tan(rho) = mu/cos(alpha)."""
    worm = gb.Worm(ratio=20.0, lead_angle=lead, friction=mu)
    rho = np.arctan(mu / np.cos(np.deg2rad(20.0)))
    assert worm.efficiency() == pytest.approx(
        (np.tan(lead) / np.tan(lead + rho), np.tan(lead - rho) / np.tan(lead)), rel=1e-12
    )


@pytest.mark.long
def test_a_wheel_that_drives_its_worm_loses_what_the_inclined_plane_says():
    worm = gb.Worm(ratio=20.0, lead_angle=0.3, friction=0.05)
    rig = _train(0.0, 30.0, J=(0.01, 2.0), w0=1.0, ratio=20.0, gear=worm)
    rho = np.arctan(0.05 / np.cos(np.deg2rad(20.0)))
    eta2 = np.tan(0.3 - rho) / np.tan(0.3)
    run = gb.simulate(rig, t_end=1.0)
    assert run["two.w"][-1] == pytest.approx(1.0 + 30.0 / (2.0 + 0.01 * 20.0**2 / eta2), rel=1e-10)


@pytest.mark.long
@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("sun", {"motor": 4.0}),
        pytest.param("sun", {"motor": 4.0, "carrier": 2.0}, marks=pytest.mark.long),
        ("carrier", {"sun": 4.0, "ring": 2.0}),
        pytest.param("ring", {"carrier": 3.0}, marks=pytest.mark.long),
        ("ring", {"motor": 2.0, "sun": 5.0}),
    ],
)
@pytest.mark.few(1)
def test_start_speeds_follow_through_a_lossy_gear_beside_a_planetary(place, told):
    rig = gb.Drivetrain("start")
    motor, sun, carrier, ring = (
        rig.add(name, gb.Inertia(J=1.0, **({"w0": told[name]} if name in told else {})))
        for name in ("motor", "sun", "carrier", "ring")
    )
    gear, planet = (
        rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8))),
        rig.add("p", gb.IdealPlanetary(ratio=2.5)),
    )
    rig.chain(motor, gear, {"sun": sun, "carrier": carrier, "ring": ring}[place])
    for flange, body in ((planet.sun, sun), (planet.carrier, carrier), (planet.ring, ring)):
        rig.connect(flange, body.b)
    run = gb.simulate(rig, t_end=0.01)
    w = {name: run[f"{name}.w"][0] for name in ("motor", "sun", "carrier", "ring")}
    assert {name: w[name] for name in told} == pytest.approx(told, rel=1e-12)
    assert w["motor"] == pytest.approx(2.0 * w[place], rel=1e-12)
    assert w["sun"] + 2.5 * w["ring"] == pytest.approx(3.5 * w["carrier"], rel=1e-12)


def test_a_gear_beside_a_freewheel_whose_share_no_split_tells_is_named_with_what_it_shares():
    """Both tie the same two shafts; what the gear loses depends on what it carries, and nothing says how much that is."""
    rig = gb.Drivetrain("beside")
    bodies = [rig.add(name, gb.Inertia(J=1.0)) for name in ("j1", "j3", "j4")]
    bodies.append(rig.add("j5", gb.Inertia(J=1.0, w0=1.0)))
    first = rig.add("first", gb.LossyGear(ratio=1.0, efficiency=(0.4, 0.3)))
    second = rig.add("second", gb.LossyGear(ratio=1.0, efficiency=(0.8, 0.8)))
    shaft, wheel = rig.add("shaft", gb.Shaft(k=200.0)), rig.add("wheel", gb.Freewheel())
    rig.connect(bodies[0].a, first.a, second.a, shaft.a, wheel.b)
    rig.connect(bodies[1].a, first.b)
    rig.connect(bodies[2].a, second.b, wheel.a, rig.add("torque", gb.Torque(tau=1.0)).flange)
    rig.connect(bodies[3].a, shaft.b)
    with pytest.raises(
        gb.SimulationError, match=r"'second': it shares its load with a lock .* compliant Shaft into that loop"
    ):
        gb.simulate(rig, t_end=0.0625)
