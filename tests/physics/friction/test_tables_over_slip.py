"""Friction tables over the size of the slip: what lies at or below slip 0 is no corner, the direction of the slip decides."""

from itertools import product

import numpy as np
import pytest

import gearblocks as gb

METHODS = ["dp5", "dp8", "rodas", "auto"]


def _swinging(part, *, wall=False):
    """A body on a spring of 100 N m/rad, turned by 1 rad, with friction against the ground (a wall for what has two sides)."""
    rig = gb.Drivetrain("swinging")
    body = rig.add("body", gb.Inertia(J=1.0, phi0=1.0))
    rig.chain(rig.add("ground", gb.Fixed()), rig.add("spring", gb.Shaft(k=100.0)), body)
    rub = rig.add("rub", part)
    rig.connect(rub.a, body.b)
    if wall:
        rig.connect(rig.add("wall", gb.Fixed()).flange, rub.b)
    return rig


def _half_swings(t, level=1.0, rise=0.1, k=100.0):
    """Angle and speed under a torque level + rise abs(w) against the motion, swing by swing in closed form."""
    wd = np.sqrt(k - rise**2 / 4)
    x, begin = 1.0, 0.0
    while True:
        offset = np.sign(x) * level / k
        if abs(x) <= level / k:
            return x, 0.0
        tau = min(t - begin, np.pi / wd)
        decay = (x - offset) * np.exp(-rise / 2 * tau)
        if t - begin <= np.pi / wd:
            angle = offset + decay * (np.cos(wd * tau) + rise / 2 / wd * np.sin(wd * tau))
            return angle, -decay * (wd + rise**2 / 4 / wd) * np.sin(wd * tau)
        x, begin = offset - (x - offset) * np.exp(-rise / 2 * np.pi / wd), begin + np.pi / wd


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "joints",
    [
        pytest.param([0.0, 12.0], id="from 0"),
        pytest.param([-1.0, 12.0], id="from -1", marks=pytest.mark.long),
        pytest.param([-3.0, 0.0, 12.0], id="joint at 0", marks=pytest.mark.long),
        pytest.param([-2.0, -1.0, 0.0, 5.0, 12.0], id="joints below"),
    ],
)
def test_a_bearing_swings_out_whatever_its_table_says_below_slip_0(method, joints):
    table = gb.Table(joints, 1 + 0.1 * np.array(joints))
    run = gb.simulate(_swinging(gb.BearingFriction(torque=table)), t=[0.0, 1.1, 2.5], method=method, rtol=1e-9)
    for i, t in ((1, 1.1), (2, 2.5)):
        angle, speed = _half_swings(t)
        assert run["body.phi"][i] == pytest.approx(angle, abs=1e-6)
        assert run["body.w"][i] == pytest.approx(speed, abs=1e-5)
    reversals = [e for e in run.events if e.component == "rub"]
    assert len(reversals) == len({e.t for e in reversals}) == 7  # one at each half swing


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_brake_and_a_clutch_take_tables_of_mu_from_slip_0(method):
    table = gb.Table([0.0, 12.0], [0.25, 0.55])
    brake = gb.Brake(mu=table, force_max=4.0, engagement=1.0)
    clutch = gb.Clutch(mu=table, force_max=4.0, engagement=1.0)
    for train in (_swinging(brake), _swinging(clutch, wall=True)):
        run = gb.simulate(train, t=[0.0, 2.5], method=method, rtol=1e-9)
        assert run["body.phi"][-1] == pytest.approx(_half_swings(2.5)[0], abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_a_step_table_that_begins_at_slip_0_is_constant_friction(method):
    table = gb.Table([0.0, 20.0], [1.0, 5.0], "step")
    run = gb.simulate(_swinging(gb.BearingFriction(torque=table)), t=[0.0, 2.5], method=method, rtol=1e-9)
    assert run["body.phi"][-1] == pytest.approx(_half_swings(2.5, rise=0.0)[0], abs=1e-6)


@pytest.mark.long
def test_the_corner_of_a_table_above_slip_0_is_still_located():
    """1 N m up to 2 rad/s, 3 N m from there on: spins down in (10 - 2)/3 + 2/1 s."""
    rig = gb.Drivetrain("corner")
    body = rig.add("body", gb.Inertia(J=1.0, w0=10.0))
    rig.connect(rig.add("rub", gb.BearingFriction(torque=gb.Table([0.0, 2.0], [1.0, 3.0], "step"))).a, body.b)
    run = gb.simulate(rig, t=[0.0, 6.0], rtol=1e-8)
    assert [e.t for e in run.events] == pytest.approx([8 / 3, 8 / 3 + 2], rel=1e-9)


SPEEDS, LEVELS, FORCE = (0.0, 1.0, 2.5), (0.317, 0.222, 0.19), 6.25


def _until(w, to, J):
    """The time from the speed w down to another one, J w' = -FORCE mu(w), segment by segment of the table."""
    time = 0.0
    for left, right, low, high in reversed(list(zip(SPEEDS, SPEEDS[1:], LEVELS, LEVELS[1:], strict=False))):
        begin, end = min(w, right), max(to, left)
        if begin > end:
            slope = (high - low) / (right - left)
            mu = [low + slope * (x - left) for x in (begin, end)]
            time += J / FORCE * np.log(mu[0] / mu[1]) / slope
    return time


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("w0", [1.0, -1.0, 2.5, -2.5])
@pytest.mark.parametrize("part", ["brake", "clutch", "late clutch"])
@pytest.mark.few(1)
def test_a_slip_may_begin_on_a_joint_of_its_table(part, w0, method):
    """From the joint downwards; with a clutch that engages there as the run goes on as well."""
    rig = gb.Drivetrain("on a joint")
    mu, body = gb.Table(SPEEDS, LEVELS), rig.add("body", gb.Inertia(J=0.5, w0=w0))
    late = 0.25 if part == "late clutch" else 0.0
    engagement = gb.piecewise((1.0, gb.time >= late), (0.0, True)) if late else 1.0
    kind = gb.Brake if part == "brake" else gb.Clutch
    rub = rig.add("rub", kind(mu=mu, force_max=FORCE, engagement=engagement))
    rig.connect(body.a, rub.a)
    if part != "brake":
        rig.connect(rub.b, rig.add("wall", gb.Fixed()).flange)
    stops = late + _until(abs(w0), 0.0, 0.5)
    run = gb.simulate(rig, t_end=1.1 * stops, method=method, rtol=1e-8)
    assert [e.t for e in run.events if e.component == "rub"][-1] == pytest.approx(stops, rel=1e-7)
    assert run["body.w"][-1] == 0.0
    joints = [late + _until(abs(w0), x, 0.5) for x in SPEEDS[1:] if x < abs(w0)]
    crossed = [
        e.t for e in run.events if e.component == "rub.table"
    ]  # the joint that it leaves as it engages may be one
    assert crossed[len(crossed) - len(joints) :] == pytest.approx(joints, rel=1e-7)


def _between_two(sense, base, joint):
    """Two bodies that turn against each other; what slips is their reduced inertia."""
    parts = {
        "one": gb.Inertia(J=1.0, w0=base),
        "rub": gb.Clutch(mu=gb.Table(SPEEDS, LEVELS), force_max=FORCE, engagement=1.0),
    }
    parts["two"] = gb.Inertia(J=3.0, w0=base + sense * joint)
    return parts, [("one.b", "rub.a"), ("rub.b", "two.a")], {"rub": 0.75}


def _in_a_row(sense, base, joint):
    """Three bodies, slips of one size on both sides of the middle one, which goes on as it is."""
    mu = gb.Table(SPEEDS, LEVELS)
    parts = {f"body{i}": gb.Inertia(J=0.5, w0=base + (1 - i) * sense * joint) for i in range(3)}
    parts |= {f"rub{i}": gb.Clutch(mu=mu, force_max=FORCE, engagement=1.0) for i in range(2)}
    wires = [("body0.b", "rub0.a"), ("rub0.b", "body1.a"), ("body2.a", "rub1.a"), ("rub1.b", "body1.b")]
    return parts, wires, {"rub0": 0.5, "rub1": 0.5}


def _carrier(sense, base, joint):
    """The carrier of a differential, the mean of two speeds that differ by `base`; all three inertias are braked."""
    brake = gb.Brake(mu=gb.Table(SPEEDS, LEVELS), force_max=FORCE, engagement=1.0, peak=1.1)
    parts = {"left": gb.Inertia(J=0.25, w0=sense * joint + base), "right": gb.Inertia(J=0.25, w0=sense * joint - base)}
    parts |= {"set": gb.Differential(ratio=1), "carrier": gb.Inertia(J=0.5), "rub": brake}
    wires = [("left.a", "set.left"), ("right.a", "set.right"), ("carrier.a", "set.carrier"), ("carrier.b", "rub.a")]
    return parts, wires, {"rub": 1.0}


def _joined(parts, wires, order):
    rig = gb.Drivetrain("on a joint")
    handles = {name: rig.add(name, parts[name]) for name in order}
    for ends in wires:
        rig.connect(*(getattr(handles[name], flange) for name, flange in (end.split(".") for end in ends)))
    return rig


@pytest.mark.long
@pytest.mark.parametrize("order", [pytest.param(1, marks=pytest.mark.long), -1])
@pytest.mark.parametrize("made", [_between_two, _in_a_row, _carrier])
def test_slips_on_joints_stop_alike_in_any_order_and_sense(made, order):
    """`base` beside the slip: its joint is met but for the rounding of both speeds."""
    for base, joint, sense in product((0.0, 1000.1), SPEEDS[1:], (1.0, -1.0)):
        parts, wires, inertias = made(sense, base, joint)
        run = gb.simulate(_joined(parts, wires, list(parts)[::order]), t_end=2.0, rtol=1e-9)
        for name, J in inertias.items():
            ((stop, after),) = ((e.t, e.after) for e in run.events if e.component == name)
            # speeds are told to rtol of themselves; what slips has friction of FORCE 0.19 at least
            assert stop == pytest.approx(_until(joint, 0.0, J), abs=1e-8 * max(base, joint) * J / (FORCE * LEVELS[-1]))
            assert after == 0.0
        assert run.energy.residual < 1e-8


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_slip_may_begin_on_a_joint_and_grow(sense, method):
    """From 1 rad/s on, against 6.25 (0.222 - 0.032/1.5 (w - 1)): J w' = excess + rate (w - 1)."""
    excess, rate, J = 2.0 - FORCE * LEVELS[1], FORCE * (LEVELS[1] - LEVELS[2]) / 1.5, 0.5
    rig = gb.Drivetrain("driven")
    body = rig.add("body", gb.Inertia(J=J, w0=sense))
    brake = gb.Brake(mu=gb.Table(SPEEDS, LEVELS), force_max=FORCE, engagement=1.0)
    rig.connect(body.a, rig.add("rub", brake).a, rig.add("drive", gb.Torque(tau=2.0 * sense)).flange)
    run = gb.simulate(rig, t=[0.0, 0.3, 0.6], method=method, rtol=1e-9)
    speeds = 1.0 + excess / rate * np.expm1(rate / J * np.array([0.0, 0.3, 0.6]))
    assert run["body.w"] == pytest.approx(sense * speeds, rel=1e-8)
    assert not [e for e in run.events if e.component == "rub"]
