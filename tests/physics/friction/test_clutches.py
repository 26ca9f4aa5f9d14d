"""Clutches: closed forms of locking, holding, slipping and letting go."""

import math

import numpy as np
import pytest
import sympy as sp
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

import gearblocks as gb

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode before, mode after) of one element."""
    return [(e.t, e.before, e.after) for e in run.events if e.component == name]


# -- clutch -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("w1", "w2"), [(100.0, 0.0), (-30.0, 20.0), (5.0, 80.0)])
@pytest.mark.parametrize("J2", [2.0, 0.03])
def test_a_clutch_locks_when_and_as_hot_as_momentum_says(w1, w2, J2):
    J1, capacity = 1.0, 50.0
    rig = _chain(one=gb.Inertia(J=J1, w0=w1), clutch=gb.Clutch(capacity=capacity), two=gb.Inertia(J=J2, w0=w2))
    run = gb.simulate(rig, t_end=5.0)
    reduced = J1 * J2 / (J1 + J2)
    ((t, before, after),) = _modes(run, "clutch")
    assert (before, after) == (np.sign(w2 - w1), 0.0)
    assert t == pytest.approx(reduced * abs(w1 - w2) / capacity, rel=1e-9)
    assert run.energy.dissipated["clutch"] == pytest.approx(reduced * (w1 - w2) ** 2 / 2, rel=1e-9)
    assert run["one.w"][-1] == pytest.approx((J1 * w1 + J2 * w2) / (J1 + J2), rel=1e-12)
    assert run["one.w"][-1] == run["two.w"][-1]
    assert run["clutch.phi_rel"][-1] == pytest.approx((w2 - w1) * t / 2, rel=1e-9)
    assert run.energy.residual < 1e-12


@pytest.mark.long
def test_the_torque_of_a_clutch_is_that_on_its_second_flange():
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), clutch=gb.Clutch(capacity=4.0), two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t=[0.1])
    assert run["clutch.torque"][0] == run["clutch.b.tau"][0] == 4.0  # b is slower and driven forward
    assert run["clutch.loss_power"][0] == pytest.approx(4.0 * (10.0 - 2 * 0.4), rel=1e-12)
    assert run["clutch.w_rel"][0] == pytest.approx(-9.2, rel=1e-12)
    assert run["clutch.mode"][0] == -1.0


@pytest.mark.long
@pytest.mark.parametrize("rtol", [pytest.param(1e-4, marks=pytest.mark.long), 1e-3])
def test_a_stuck_clutch_does_not_creep_in_a_million_seconds(rtol):
    tau = 3.0 * gb.sin(0.7 * gb.time)
    rig = _chain(
        drive=gb.Torque(tau=tau), one=gb.Inertia(J=1.0, w0=2.0), clutch=gb.Clutch(capacity=5.0), two=gb.Inertia(J=2.0)
    )
    t = np.concatenate([np.linspace(0, 10, 101), np.linspace(20, 1e6, 50)])
    run = gb.simulate(rig, t=t, rtol=rtol)
    held = run["clutch.mode"] == 0.0
    assert held[t > 2].all()
    assert (run["clutch.w_rel"][held] == 0.0).all()
    assert len(set(run["clutch.phi_rel"][held])) == 1
    assert np.array_equal(run["one.w"][held], run["two.w"][held])
    assert (np.abs(run["clutch.torque"][held]) <= 5.0).all()


@pytest.mark.long
def test_a_clutch_is_free_where_its_capacity_is_not_positive():
    capacity = gb.piecewise((-3.0, gb.time < 1), (0.0, gb.time < 2), (4.0, gb.time < 3), (-1.0, True))
    rig = _chain(one=gb.Inertia(J=1.0, w0=10.0), clutch=gb.Clutch(capacity=capacity), two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t=[0.5, 1.5, 2.5, 3.5])
    assert list(run["clutch.mode"]) == [2.0, 2.0, -1.0, 2.0]
    assert list(run["clutch.torque"]) == [0.0, 0.0, 4.0, 0.0]
    assert run["one.w"] == pytest.approx([10.0, 10.0, 8.0, 6.0], rel=EXACT)
    assert _modes(run, "clutch") == [(2.0, 2.0, -1.0), (3.0, -1.0, 2.0)]


def test_a_clutch_without_capacity_is_no_storm_of_events():
    rig = _chain(
        drive=gb.Torque(tau=gb.sin(gb.time)),
        one=gb.Inertia(J=1.0),
        clutch=gb.Clutch(capacity=0.0),
        two=gb.Inertia(J=1.0),
    )
    run = gb.simulate(rig, t_end=50.0)
    assert len(run.events) == 0
    assert run["two.w"][-1] == 0.0
    assert (run["clutch.mode"] == 2.0).all()


@pytest.mark.long
def test_a_capacity_that_grazes_the_held_torque_does_not_let_go():
    capacity = 6 - sp.cos(2 * sp.pi * gb.time) * (1 - 1e-9)  # at least 5 + 1e-9
    rig = _chain(drive=gb.Torque(tau=5.0), body=gb.Inertia(J=1.0), brake=gb.Brake(capacity=capacity))
    run = gb.simulate(rig, t_end=5.0)
    assert (run["body.phi"] == 0.0).all()
    assert (run["brake.mode"] == 0.0).all()
    deeper = 6 - sp.cos(2 * sp.pi * gb.time) * (1 + 1e-2)
    run = gb.simulate(
        rig.set({"brake.capacity": deeper}), t_end=5.0, max_step=0.05
    )  # nothing else moves that asks for it
    assert len(_modes(run, "brake")) == 10  # slips at the start, in four dips and at the end


@pytest.mark.long
def test_friction_over_slip_stops_as_its_differential_equation_says():
    mu0, slope, force, J, w0 = 0.3, 0.02, 10.0, 0.5, 12.0
    mu = gb.Table([0.0, 20.0], [mu0, mu0 + 20 * slope])
    rig = _chain(
        one=gb.Inertia(J=J, w0=w0),
        clutch=gb.Clutch(mu=mu, force_max=force, engagement=1.0, geometry=2.0),
        end=gb.Fixed(),
    )
    run = gb.simulate(rig, t_end=10.0, rtol=1e-11)
    c = 2.0 * force * slope
    ((t, _, _),) = (e for e in _modes(run, "clutch") if e[2] == 0.0)
    assert t == pytest.approx(J / c * np.log(1 + w0 * slope / mu0), rel=1e-9)
    assert run.energy.dissipated["clutch"] == pytest.approx(J * w0**2 / 2, rel=1e-9)


@pytest.mark.parametrize("way", [pytest.param(1.0, marks=pytest.mark.long), -1.0])
def test_a_stuck_clutch_lets_go_at_its_peak_and_slips_with_less(way):
    mu = gb.Table([0.0, 1.0], [0.4, 0.4])
    clutch = gb.Clutch(mu=mu, force_max=10.0, engagement=0.5, geometry=1.5, peak=1.25)
    rig = _chain(drive=gb.Torque(tau=way * gb.time), one=gb.Inertia(J=1.0), clutch=clutch, end=gb.Fixed())
    run = gb.simulate(rig, t=[3.0, 3.74, 4.0, 5.0])
    slip_torque, most = 3.0, 3.75
    ((t, _, after),) = _modes(run, "clutch")
    assert t == pytest.approx(most, rel=1e-9)
    assert after == -way
    assert run["clutch.torque"] == pytest.approx(
        [3.0 * way, 3.74 * way, slip_torque * way, slip_torque * way], rel=1e-9
    )
    assert run["one.w"][-1] == pytest.approx(way * ((25 - most**2) / 2 - slip_torque * (5 - most)), rel=1e-8)


# -- every way to run it ----------------------------------------------------------------------------------------------


METHODS = [{"method": "dp5"}, {"method": "dp8"}, {"method": "rodas"}, {"method": "rk4", "step": 0.01}]


@pytest.mark.parametrize("options", METHODS, ids=lambda options: options["method"])
def test_every_method_locks_and_lets_go_at_the_same_times(options):
    clutch = gb.Clutch(capacity=20.0, peak=1.1)
    drive = gb.Torque(tau=30.0 * gb.time)
    rig = _chain(drive=drive, one=gb.Inertia(J=1.0, w0=10.0), clutch=clutch, two=gb.Inertia(J=1.0))
    run = gb.simulate(rig, t_end=3.0, rtol=1e-9, **options)
    # slip 10 + 15 t^2 - 40 t = 0; then half of the torque passes: 22 at 44/30 s
    times = [(40 - np.sqrt(1600 - 600)) / 30, 44 / 30]
    assert [t for t, _, _ in _modes(run, "clutch")] == pytest.approx(times, rel=1e-9)
    assert [m for _, _, m in _modes(run, "clutch")] == [0.0, -1.0]


def examples(count):
    """The same `count` examples in every run, in the quick tier a quarter of them; no search for smaller ones, no time
    limit."""
    return settings(
        max_examples=math.ceil(count * settings().max_examples / 100), derandomize=True, deadline=None, database=None,
        phases=[Phase.generate], suppress_health_check=[HealthCheck.too_slow],
    )  # fmt: skip


def _row(kinds, numbers, order, flips):
    """Three bodies in a row with a friction element between each two; the components added in any order, ends flipped."""
    J, w, cap = numbers
    wave = [c * (1 + sp.sin((i + 2) * gb.time)) for i, c in enumerate(cap)]
    made = {
        "clutch": lambda i: gb.Clutch(capacity=wave[i], peak=1.25),
        "mu": lambda i: gb.Clutch(mu=gb.Table([0, 5], [0.5, 0.3]), force_max=2 * cap[i], engagement=1.0),
        "dog": lambda i: gb.DogClutch(engaged=sp.sin((i + 2) * gb.time)),
    }
    parts = {f"body{i}": gb.Inertia(J=J[i], w0=w[i]) for i in range(3)}
    parts |= {f"link{i}": made[kinds[i]](i) for i in range(2)}
    parts |= {"brake": gb.Brake(capacity=cap[2]), "drive": gb.Torque(tau=3.0 * gb.sin(2 * gb.time))}
    rig = gb.Drivetrain("row")
    handles = {name: rig.add(name, parts[name]) for name in (list(parts)[i] for i in order)}
    for i in range(2):
        ends = ("b", "a") if flips[i] else ("a", "b")
        rig.connect(handles[f"body{i}"].b, getattr(handles[f"link{i}"], ends[0]))
        rig.connect(handles[f"body{i + 1}"].a, getattr(handles[f"link{i}"], ends[1]))
    rig.connect(handles["drive"].flange, handles["body0"].a)
    rig.connect(handles["brake"].a, handles["body2"].b)
    return rig


@pytest.mark.long
@examples(8)
@given(
    st.tuples(*(st.sampled_from(["clutch", "mu", "dog"]) for _ in range(2))),
    st.tuples(
        st.tuples(*(st.integers(1, 4) for _ in range(3))),
        st.tuples(*(st.integers(-9, 9) for _ in range(3))),
        st.tuples(*(st.integers(1, 5) for _ in range(3))),
    ),
    st.permutations(range(7)), st.tuples(st.booleans(), st.booleans()),
)  # fmt: skip
def test_the_order_of_components_and_the_sense_of_flanges_change_nothing(kinds, numbers, order, flips):
    t = np.linspace(0, 5, 51)
    one = gb.simulate(_row(kinds, numbers, range(7), (False, False)), t=t, rtol=1e-10)
    two = gb.simulate(_row(kinds, numbers, order, flips), t=t, rtol=1e-10)
    for body in ("body0", "body1", "body2"):
        assert np.abs(one[f"{body}.w"] - two[f"{body}.w"]).max() < 1e-8  # 100 rtol times speeds of up to 9
    sense = {"link0": -1.0 if flips[0] else 1.0, "link1": -1.0 if flips[1] else 1.0}

    def changes(run, signs):
        """Changes of mode; before and after of impacts are speeds."""
        modes = (-1.0, 0.0, 1.0, 2.0)
        found = [e for e in run.events if e.component in ("link0", "link1", "brake")]
        found = [e for e in found if e.kind != "impact" and e.before in modes and e.after in modes]
        turned = [[signs.get(e.component, 1.0) * m if abs(m) == 1 else m for m in (e.before, e.after)] for e in found]
        return sorted((round(e.t, 6), e.component, *m) for e, m in zip(found, turned, strict=True))

    assert changes(one, {}) == changes(two, sense)
    assert one.energy.residual < 1e-8
