"""Conditions over angles, speeds and time: no crossing is stepped over, however long the steps are."""

import numpy as np
import pytest
import sympy as sp
from scipy.optimize import brentq

import gearblocks as gb

METHODS = ("dp8", "dp5", "rodas")
RTOLS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
PHI = gb.sense("crank.phi")


def crank(tau, *, w0, J=1.0, drag=None):
    """A torque on a flywheel, with a damper to the ground where there is drag."""
    rig = gb.Drivetrain("crank")
    parts = [rig.add("gas", gb.Torque(tau=tau)), rig.add("crank", gb.Inertia(J=J, w0=w0))]
    if drag is not None:
        parts += [rig.add("drag", gb.Damper(c=drag)), rig.add("ground", gb.Fixed())]
    rig.chain(*parts)
    return gb.build(rig)


@pytest.mark.long
@pytest.mark.parametrize("method", [*METHODS, "auto"])
@pytest.mark.few(1)
def test_the_gas_torque_of_a_crank_acts_in_every_turn(method, reference):
    model = crank(gb.piecewise((200, gb.cos(PHI) > 0.9), (0, True)), w0=300.0, J=0.2, drag=0.3)
    rates = lambda t, y, m: (y[1], (200 * (m[0] > 0) - 0.3 * y[1]) / 0.2)  # noqa: E731
    phi, w = reference(rates, [0.0, 300.0], [0.0, 1.0], lambda t, y: [np.cos(y[0]) - 0.9], max_step=1e-3)[-1]
    windows = sum(phi > np.arccos(0.9) + 2 * np.pi * k for k in range(40))
    windows += sum(phi > 2 * np.pi * (k + 1) - np.arccos(0.9) for k in range(40))
    for rtol in RTOLS:
        run = gb.simulate(model, t_end=1.0, method=method, rtol=rtol)
        assert len(run.events) == windows, rtol
        assert abs(run["crank.w"][-1] - w) < 10 * rtol * 300 + 1e-8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
@pytest.mark.few(3)
def test_work_over_half_turns_is_the_torque_times_the_angle(method, rtol):
    run = gb.simulate(
        crank(gb.piecewise((10, gb.sin(PHI) > 0), (0, True)), w0=100.0), t_end=1.0, method=method, rtol=rtol
    )
    phi, w = run["crank.phi"][-1], run["crank.w"][-1]
    turns, rest = divmod(phi, 2 * np.pi)
    assert abs(w**2 - 100.0**2 - 2 * 10 * (turns * np.pi + min(rest, np.pi))) < 1e-6
    assert len(run.events) == int(phi / np.pi)


@pytest.mark.long
@pytest.mark.parametrize("method", [*METHODS, "auto"])
@pytest.mark.parametrize("phi", [4.03, 62.0], ids=["within a turn", "ten turns"])
def test_forty_switches_over_one_angle_flip_as_often_as_they_cross(method, phi):
    small = sum(gb.piecewise((1e-9, gb.sin(n * PHI) > 0), (0, True)) for n in range(1, 41))
    assert min(abs(n * phi / np.pi - round(n * phi / np.pi)) for n in range(1, 41)) > 1e-3
    model = crank(small, w0=1e4)
    for rtol in RTOLS:
        run = gb.simulate(model, t_end=1e-4 * phi, method=method, rtol=rtol)
        assert len(run.events) == sum(int(n * phi / np.pi) for n in range(1, 41)), rtol


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(1)
def test_a_rectified_wave_changes_its_side_at_every_zero_and_does_its_work(method):
    model = crank(10 * abs(gb.sin(20 * PHI)), w0=1000.0)
    for rtol in (1e-3, 1e-8):
        run = gb.simulate(model, t_end=0.2, method=method, rtol=rtol)
        phi, w = run["crank.phi"][-1], run["crank.w"][-1]
        waves, rest = divmod(20 * phi, np.pi)
        assert len(run.events) == waves
        work = 10 * (2 * waves + 1 - np.cos(rest)) / 20
        assert abs(0.5 * (w**2 - 1e6) - work) < 0.05 * work  # 5e-5 of the speed


@pytest.mark.long
@pytest.mark.parametrize("method", [*METHODS, "auto"])
def test_a_camshaft_with_twelve_followers_keeps_its_energy(method):
    # each lobe is a spring A/2 (cos 2 psi - cos 2 b) within b of its follower: energy is a function of the angle
    half, size, w0 = 0.4, 30.0, 50.0
    at = [k * np.pi / 6 + 0.1 * np.sin(k) for k in range(12)]
    tau = sum(gb.piecewise((size * gb.sin(2 * (PHI - a)), gb.cos(PHI - a) > np.cos(half)), (0, True)) for a in at)

    def stored(phi):
        inside = [(phi - a + np.pi) % (2 * np.pi) - np.pi for a in at]
        return sum(size / 2 * (np.cos(2 * x) - np.cos(2 * half)) for x in inside if abs(x) < half)

    def passed(phi):
        edges = [(a + side * half) % (2 * np.pi) for a in at for side in (-1, 1)]
        return sum(int((phi - edge) // (2 * np.pi)) + 1 for edge in edges)

    model = crank(tau, w0=w0)
    for rtol in RTOLS:
        run = gb.simulate(model, t_end=0.6, method=method, rtol=rtol)
        phi, w = run["crank.phi"][-1], run["crank.w"][-1]
        assert len(run.events) == passed(phi), rtol
        # one step or two between events, each of which may err by rtol w0 in the speed
        assert abs(0.5 * w**2 + stored(phi) - 0.5 * w0**2 - stored(0.0)) < len(run.events) * rtol * w0**2


WAVE = gb.Table(np.linspace(0, 2 * np.pi, 7), [0.3, -0.8, 0.9, 0.1, -0.5, 0.7, 0.3], "cubic", periodic=True)
MAP = gb.Table2(
    [-1.0, 0.0, 1.0], [-1.0, -0.2, 0.4, 1.0], [[0.5, -1, 0.2, 0.9], [-0.6, 0.7, -0.9, 0.4], [0.8, 0, 1, -1]]
)
A, B, T = gb.sense("one.phi"), gb.sense("two.phi"), gb.time
CONDITIONS = {
    "two harmonics": (gb.sin(3 * A) + 0.5 * gb.sin(7 * A + 1), lambda a, b, t: np.sin(3 * a) + 0.5 * np.sin(7 * a + 1)),
    "two shafts": (gb.cos(A - 2 * B) - 0.9, lambda a, b, t: np.cos(a - 2 * b) - 0.9),
    "angle and time": (gb.sin(A + 40 * T) * gb.cos(B), lambda a, b, t: np.sin(a + 40 * t) * np.cos(b)),
    "two waves of time": (
        gb.sin(90 * T) + gb.cos(211 * T) - 1.5,
        lambda a, b, t: np.sin(90 * t) + np.cos(211 * t) - 1.5,
    ),
    "a square": (gb.sin(5 * B) ** 2 - 0.98, lambda a, b, t: np.sin(5 * b) ** 2 - 0.98),
    "an exponential": (sp.exp(sp.sin(sp.sympify(A))) - 2.7, lambda a, b, t: np.exp(np.sin(a)) - 2.7),
    "a root": (sp.sqrt(1.1 + sp.cos(sp.sympify(B))) - 0.4, lambda a, b, t: np.sqrt(1.1 + np.cos(b)) - 0.4),
    "a quotient": (1 / (1.02 - gb.cos(A)) - 30, lambda a, b, t: 1 / (1.02 - np.cos(a)) - 30),
    "an arc tangent": (sp.atan(8 * sp.sin(sp.sympify(B))) - 1.4, lambda a, b, t: np.arctan(8 * np.sin(b)) - 1.4),
    "a table": (WAVE(A) - 0.85, lambda a, b, t: _wave(a) - 0.85),
    "a map": (MAP(gb.sin(A), gb.cos(B)) - 0.6, lambda a, b, t: _map(np.sin(a), np.cos(b)) - 0.6),
}


def _wave(a):
    from scipy.interpolate import CubicSpline

    return CubicSpline(WAVE.x, WAVE.y, bc_type="periodic")(np.mod(a, 2 * np.pi))


def _map(x, y):
    from scipy.interpolate import RegularGridInterpolator

    return RegularGridInterpolator((MAP.x, MAP.y), np.asarray(MAP.z))(np.stack(np.broadcast_arrays(x, y), axis=-1))


def _crossings(f, end):
    """Zeros of f in (0, end), each refined."""
    t = np.linspace(0.0, end, 200_001)
    side = f(t) > 0
    at = lambda x: float(f(np.array([x]))[0])  # noqa: E731
    return [brentq(at, t[i], t[i + 1], xtol=1e-15) for i in np.flatnonzero(side[1:] != side[:-1])]


@pytest.mark.long
def test_conditions_of_any_form_switch_where_their_zeros_are():
    rig = gb.Drivetrain("conditions")
    speeds, end = {"one": 170.0, "two": 131.0}, 0.5
    for name, w0 in speeds.items():
        rig.chain(
            rig.add(f"rest_{name}", gb.Torque(tau=gb.Parameter("none", 0.0))), rig.add(name, gb.Inertia(J=1.0, w0=w0))
        )
    for i, (condition, _) in enumerate(CONDITIONS.values()):
        tau = gb.piecewise((1.0, condition > 0), (0, True))
        rig.chain(rig.add(f"t{i}", gb.Torque(tau=tau)), rig.add(f"m{i}", gb.Inertia(J=1.0)))
    model = gb.build(rig)
    expected = []
    for _, f in CONDITIONS.values():
        g = lambda t, f=f: f(170.0 * t, 131.0 * t, t)  # noqa: E731
        roots = _crossings(g, end)
        edges = np.array([0.0, *roots, end])
        on = [g(np.array([x]))[0] > 0 for x in (edges[1:] + edges[:-1]) / 2]
        expected.append(float(np.sum(np.diff(edges)[on])))
    for method in METHODS:
        for rtol in (1e-3, 1e-9):
            run = gb.simulate(model, t_end=end, method=method, rtol=rtol)
            for i, name in enumerate(CONDITIONS):
                assert abs(run[f"m{i}.w"][-1] - expected[i]) < 1e-10, (name, method, rtol)


@pytest.mark.parametrize("method", METHODS)
def test_windows_of_a_ten_thousandth_of_a_turn_are_seen_and_touches_are_not(method):
    narrow = gb.piecewise((1e-9, gb.cos(PHI) > 1 - 2e-7), (0, True))
    touch = gb.piecewise((1e-9, gb.cos(PHI - 0.5) > 1), (0, True))
    run = gb.simulate(crank(narrow + touch, w0=1e3), t_end=0.1, method=method, rtol=1e-3)
    assert len(run.events) == 1 + 2 * 15
    edges = np.arccos(1 - 2e-7) * np.array([-1, 1])
    expected = [edges[1], *(2 * np.pi * k + edge for k in range(1, 16) for edge in edges)]
    assert np.allclose([e.t for e in run.events], np.array(expected) / 1e3, rtol=0, atol=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_an_angle_behind_a_joint_and_one_of_a_shaft_without_inertia_are_followed(method):
    rig = gb.Drivetrain("joint")
    fork = rig.add("fork", gb.Inertia(J=1e-3))
    rig.chain(rig.add("m", gb.Inertia(J=1.0, w0=200.0)), rig.add("joint", gb.UniversalJoint(angle=0.6)), fork)
    rig.chain(
        rig.add("t", gb.Torque(tau=gb.piecewise((1e-6, gb.cos(3 * gb.sense("fork.phi")) > 0.7), (0, True)))), fork
    )
    run = gb.simulate(rig, t_end=0.5, method=method, rtol=1e-4)
    edge = np.arccos(0.7) / 3
    phi = run["fork.phi"][-1]
    assert len(run.events) == sum(phi > k * 2 * np.pi / 3 + s * edge for k in range(60) for s in (-1, 1) if k + s >= 0)

    rig = gb.Drivetrain("massless")
    rig.chain(
        rig.add("t", gb.Torque(tau=gb.piecewise((1e-6, gb.sin(5 * gb.sense("n.phi")) > 0.3), (0, True)))),
        rig.add("m", gb.Inertia(J=1.0, w0=150.0)), rig.add("k", gb.Shaft(k=5000, c=3.0)), rig.add("n", gb.Inertia(J=0.0)),
        rig.add("k2", gb.Shaft(k=8000, c=2.0)), rig.add("q", gb.Inertia(J=0.5, w0=150.0)),
    )  # fmt: skip
    run = gb.simulate(rig, t_end=0.5, method=method, rtol=1e-3)
    first, second = np.arcsin(0.3), np.pi - np.arcsin(0.3)
    assert len(run.events) == sum(2 * np.pi * k + x < 5 * 75.0 for k in range(70) for x in (first, second))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("level", [lambda t: 0.5 * np.sin(30 * t), gb.Table([0.0, 0.2, 0.5], [0.1, 0.9, -0.6])])
@pytest.mark.few(3)
def test_a_threshold_that_comes_from_outside_is_crossed_as_often_as_it_is(method, level):
    tau = gb.piecewise((1.0, gb.sin(4 * PHI) > gb.Input("u")), (0, True))
    values = level if callable(level) and not isinstance(level, gb.Table) else lambda t: np.interp(t, level.x, level.y)
    start = 200.0
    rig = gb.Drivetrain("level")
    rig.chain(rig.add("free", gb.Torque(tau=gb.Parameter("none", 0.0))), rig.add("crank", gb.Inertia(J=1.0, w0=start)))
    rig.chain(rig.add("t", gb.Torque(tau=tau)), rig.add("counter", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=0.5, method=method, rtol=1e-3, inputs={"u": level})
    roots = _crossings(lambda t: np.sin(4 * start * t) - values(t), 0.5)
    edges = np.array([0.0, *roots, 0.5])
    on = np.sin(4 * start * (edges[1:] + edges[:-1]) / 2) > values((edges[1:] + edges[:-1]) / 2)
    assert abs(run["counter.w"][-1] - np.sum(np.diff(edges)[on])) < 1e-9


HALF = np.pi / 2
# a condition, and where it holds: from an angle on, over a length, again after each period
THROUGH_INFINITY = {
    "a tangent": (gb.tan(PHI / 2) > 1, HALF, HALF, 4 * HALF),
    "a narrow tangent": (gb.tan(PHI / 2) > 200, 2 * np.arctan(200), 2 * HALF - 2 * np.arctan(200), 4 * HALF),
    "over a tangent": (1 / gb.tan((PHI - 1) / 2) > 3, 1.0, 2 * np.arctan(1 / 3), 4 * HALF),
    "over a cube": (1 / (gb.sin(PHI) - 0.5) ** 3 > 0, HALF / 3, 4 * HALF / 3, 4 * HALF),
    "the size of a quotient": (abs(2 / gb.sin(PHI / 2) - 3) > 1, -14 * HALF / 3, 16 * HALF / 3, 8 * HALF),
    "a hyperbola": (1 / (PHI - 20) > 100, 20.0, 0.01, 1e9),
    "the angle of a pointer": (
        sp.atan2(sp.sin(sp.sympify(PHI)), sp.cos(sp.sympify(PHI))) > 3,
        3.0,
        np.pi - 3,
        4 * HALF,
    ),
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", THROUGH_INFINITY)
@pytest.mark.few(4)
def test_conditions_that_change_through_infinity_or_by_a_jump_are_met_there(name, method):
    """Work over the angle; neither the pole nor the crossing before it is passed over, however long the steps are."""
    condition, start, length, period = THROUGH_INFINITY[name]
    model = crank(gb.piecewise((10, condition), (0, True)), w0=50.0)
    for rtol in (1e-4, 1e-9):
        run = gb.simulate(model, t_end=1.0, method=method, rtol=rtol)
        phi, w = run["crank.phi"][-1], run["crank.w"][-1]
        begins = start + period * np.arange(10)
        width = np.sum(np.clip(phi - begins, 0.0, length) - np.clip(-begins, 0.0, length))
        assert 0.5 * (w**2 - 50.0**2) == pytest.approx(10 * width, abs=1e-7), rtol


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(1)
def test_the_angle_of_a_pointer_as_a_torque_jumps_where_it_does(method):
    """atan2 of sine and cosine is the angle within half a turn: its work is that of a spring."""
    phi = sp.sympify(PHI)
    model = crank(10 * sp.atan2(sp.sin(phi), sp.cos(phi)), w0=50.0)
    for rtol in (1e-4, 1e-9):
        run = gb.simulate(model, t_end=1.0, method=method, rtol=rtol)
        within = (run["crank.phi"] + np.pi) % (2 * np.pi) - np.pi
        smooth = np.abs(np.abs(within) - np.pi) > 1e-6
        work = 0.5 * (run["crank.w"] ** 2 - 50.0**2)
        assert np.abs(work - 5 * within**2)[smooth].max() < 10 * rtol * 50.0**2


@pytest.mark.parametrize("centre", [0.1, 0.3])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(2)
def test_the_angle_of_a_point_on_an_ellipse_round_the_origin_or_beside_it(method, centre):
    """3 sin and 0.2 cos + centre: behind the origin it jumps, right of it both half angles have a value."""
    tau = sp.atan2(3 * sp.sin(30 * sp.sympify(T)), 0.2 * sp.cos(30 * sp.sympify(T)) + centre)
    t = np.linspace(0.0, 1.0, 2_000_001)
    mid = (t[1:] + t[:-1]) / 2
    right = 1.0 + np.mean(np.arctan2(3 * np.sin(30 * mid), 0.2 * np.cos(30 * mid) + centre))
    for rtol in (1e-4, 1e-8):
        run = gb.simulate(crank(tau, w0=1.0), t_end=1.0, method=method, rtol=rtol)
        assert run["crank.w"][-1] == pytest.approx(right, abs=20 * rtol + 1e-5)  # jumps between points
