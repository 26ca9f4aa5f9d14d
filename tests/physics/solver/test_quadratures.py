"""Integrals of the ledger under the tolerance, where the motion is a polynomial of time that every method follows without
error: work and losses against polynomials, within a few rtol of the turnover, also across events inside long steps."""

import numpy as np
import pytest
from numpy.polynomial import Polynomial as Poly
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import gearblocks as gb

T = gb.time
TORQUE = Poly([6.0, -20.0, 0.0, 45.0, -22.0])  # N m over s; above 2 N m in 0 .. 0.2 s, 2 s at most
CASES = [("dp5", 1e-4), ("dp5", 1e-7), ("dp5", 1e-10), ("dp8", 1e-4), ("dp8", 1e-7), ("dp8", 1e-10), ("dp8", 1e-12)]
CASES += [("rodas", 1e-4), ("rodas", 1e-7), ("auto", 1e-9)]
WITH_METHODS = pytest.mark.parametrize(("method", "rtol"), CASES)


def _signal(p):
    return sum(float(c) * T**i for i, c in enumerate(p.coef))


def _work(power, start, end):
    whole = power.integ()
    return whole(end) - whole(start)


def _close(run, wanted, rtol):
    energy = run.energy
    found = {("in", n): x for n, x in energy.supplied.items()} | {("out", n): x for n, x in energy.dissipated.items()}
    assert found.keys() == wanted.keys()
    for name, x in wanted.items():
        assert abs(found[name] - x) <= (5 * rtol + 1e-12) * energy.turnover, name
    assert energy.residual <= 5 * rtol + 1e-14


@WITH_METHODS
@pytest.mark.few(3)
def test_work_and_slipping_losses_are_those_of_the_polynomials(method, rtol):
    J, C, brake, start, end = (2.0, 3.0), 4.0, 1.5, (40.0, 12.0), 1.7
    rig = gb.Drivetrain("slipping")
    parts = [gb.Torque(tau=_signal(TORQUE)), gb.Inertia(J=J[0], w0=start[0]), gb.Clutch(capacity=C)]
    parts += [gb.Inertia(J=J[1], w0=start[1]), gb.Brake(capacity=brake)]
    rig.chain(*(rig.add(f"p{i}", part) for i, part in enumerate(parts)))
    one = start[0] + (TORQUE - C).integ() / J[0]
    two = start[1] + Poly([C - brake]).integ() / J[1]
    run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
    assert run["p1.w"][-1] == pytest.approx(one(end), rel=1e-9) and one(end) > two(end) > 0
    losses = {("out", "p2"): _work(C * (one - two), 0, end), ("out", "p4"): _work(brake * two, 0, end)}
    _close(run, {("in", "p0"): _work(TORQUE * one, 0, end), **losses}, rtol)


@WITH_METHODS
@pytest.mark.few(3)
def test_a_freewheel_that_opens_inside_a_long_step_leaves_the_ledger_right(method, rtol):
    J, start, end = (2.0, 3.0), 4.0, 1.5
    tau = Poly([5.0, 3.0, -2.0, -9.0, 2.0])
    rig = gb.Drivetrain("freewheel")
    parts = [gb.Torque(tau=_signal(tau)), gb.Inertia(J=J[0], w0=start), gb.Freewheel(), gb.Inertia(J=J[1], w0=start)]
    rig.chain(*(rig.add(f"p{i}", part) for i, part in enumerate(parts)), rig.add("drag", gb.Brake(capacity=0.5)))
    # it carries J2/(J1 + J2) of the torque and the rest of the drag, until that passes zero
    carried = (J[1] * (tau - 0.5)) / sum(J) + 0.5
    opens = min(r.real for r in carried.roots() if abs(r.imag) < 1e-12 and r.real > 0)
    together = start + (tau - 0.5).integ() / sum(J)
    one = together(opens) + tau.integ(lbnd=opens) / J[0]
    two = together(opens) - Poly([-opens, 1.0]) * 0.5 / J[1]
    run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
    assert [e.t for e in run.events] == pytest.approx([opens], rel=rtol + 1e-9)
    assert run["p1.w"][-1] == pytest.approx(one(end), rel=rtol + 1e-9)
    assert run["p3.w"][-1] == pytest.approx(two(end), rel=rtol + 1e-9)
    given = _work(tau * together, 0, opens) + _work(tau * one, opens, end)
    dragged = 0.5 * (_work(together, 0, opens) + _work(two, opens, end))
    _close(run, {("in", "p0"): given, ("out", "p2"): 0.0, ("out", "drag"): dragged}, rtol)


@pytest.mark.long
@WITH_METHODS
@pytest.mark.parametrize("limit", [13.0, 24.0, 29.5])
def test_a_source_that_an_angle_switches_off_inside_a_long_step(method, rtol, limit):
    J, w0, end, tau = 2.0, 5.0, 2.9, Poly([3.0, 0.0, 2.0, 0.0, 0.5])
    rig = gb.Drivetrain("limit")
    drive = gb.Torque(tau=gb.piecewise((_signal(tau), gb.sense("body.phi") < limit), (-1.25, True)))
    rig.chain(
        rig.add("drive", drive), rig.add("body", gb.Inertia(J=J, w0=w0)), rig.add("drag", gb.Brake(capacity=0.75))
    )
    w = w0 + (tau - 0.75).integ() / J
    switch = next(r.real for r in (w.integ() - limit).roots() if abs(r.imag) < 1e-9 and 0 < r.real < end)
    after = w(switch) + Poly([2.0 * switch, -2.0]) / J
    run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
    assert run["body.w"][-1] == pytest.approx(after(end), rel=rtol + 1e-9)
    given = _work(tau * w, 0, switch) - 1.25 * _work(after, switch, end)
    dragged = 0.75 * (_work(w, 0, switch) + _work(after, switch, end))
    _close(run, {("in", "drive"): given, ("out", "drag"): dragged}, rtol)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["linear", "cubic"])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_work_of_a_table_over_time_does_not_get_worse_with_the_tolerance(kind, method):
    rig, x = gb.Drivetrain("table"), np.linspace(0.0, 2.0, 9)
    table = gb.Table(x, [1.0, 3, 5, 2, -1, -4, 2, 6, 1], kind)
    rig.chain(
        rig.add("drive", gb.Torque(tau=table)), rig.add("body", gb.Inertia(J=0.5, w0=3.0)),
        rig.add("brake", gb.Brake(capacity=0.25)),
    )  # fmt: skip
    nodes, weights = np.polynomial.legendre.leggauss(8)  # cubic pieces and their powers up to the seventh: exact
    t = (x[:-1, None] + (nodes + 1) / 2 * 0.25).ravel()
    tau = gb.simulate(rig, t=[0.0, *t, 2.0])["drive.torque"][1:-1].reshape(8, 8)
    integral = _antiderivative(nodes)
    w, reached = np.empty((8, 8)), 3.0
    for i in range(8):
        w[i] = reached + 0.25 / 2 * integral @ (tau[i] - 0.25) / 0.5
        reached += 0.25 / 2 * weights @ (tau[i] - 0.25) / 0.5
    given = 0.25 / 2 * (tau * w @ weights).sum()
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        run = gb.simulate(rig, t_end=2.0, method=method, rtol=rtol)
        assert run["body.w"][-1] == pytest.approx(reached, rel=10 * rtol)
        _close(run, {("in", "drive"): given, ("out", "brake"): 0.25 * 0.25 / 2 * (w @ weights).sum()}, rtol)


def _antiderivative(nodes):
    """Matrix from the values of a polynomial at the nodes to those of its integral from -1."""
    basis = [Poly.fromroots(np.delete(nodes, j)) / np.prod(nodes[j] - np.delete(nodes, j)) for j in range(len(nodes))]
    return np.array([[b.integ(lbnd=-1)(x) for b in basis] for x in nodes])


@pytest.mark.long
@pytest.mark.parametrize("load", [pytest.param("damper", marks=pytest.mark.long), "two dampers", "eddy currents"])
@pytest.mark.parametrize(("method", "rtol"), [*CASES, ("dp8", 1e-8), ("dp8", 1e-9), ("dp8", 1e-11), ("auto", 1e-10)])
@pytest.mark.few(1)
def test_a_load_that_hardly_moves_sets_no_step_for_the_work_beside_it(method, rtol, load):
    """States whose error is small but seen, beside a source and a slipping clutch that need the steps."""
    J, C, c, start, end = (2.0, 30.0), 3.0, 0.6, (60.0, 4.8), 1.6
    tau = Poly([1.0, 30.0, 0.0, -400.0, 0.0, 700.0, -330.0])
    rig = gb.Drivetrain("load")
    parts = [gb.Torque(tau=_signal(tau)), gb.Inertia(J=J[0], w0=start[0]), gb.Clutch(capacity=C)]
    chain = [rig.add(f"p{i}", part) for i, part in enumerate([*parts, gb.Inertia(J=J[1], w0=start[1])])]
    if load == "damper":
        rig.chain(*chain, rig.add("load", gb.Damper(c=c)), rig.add("ground", gb.Fixed()))
        shares = {"load": 1.0}
    elif load == "two dampers":
        rig.chain(*chain, rig.add("load", gb.Damper(c=c / 3)), rig.add("ground", gb.Fixed()))
        rig.connect(chain[3].b, rig.add("more", gb.SpeedLoad(coeffs=(0, 2 * c / 3, 0))).flange)
        shares = {"load": 1 / 3, "more": 2 / 3}
    else:
        rig.chain(*chain, rig.add("load", gb.SpeedLoad(coeffs=(0, c, 0))))
        shares = {"load": 1.0}
    rate, rest = c / J[1], C / c
    away = start[1] - rest
    one = start[0] + (tau - C).integ() / J[0]
    turned = rest * end + away * (1 - np.exp(-rate * end)) / rate
    squared = rest**2 * end + 2 * rest * away * (1 - np.exp(-rate * end)) / rate
    squared += away**2 * (1 - np.exp(-2 * rate * end)) / (2 * rate)
    run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
    assert run["p3.w"][-1] == pytest.approx(rest + away * np.exp(-rate * end), rel=rtol)
    wanted = {("in", "p0"): _work(tau * one, 0, end), ("out", "p2"): C * (_work(one, 0, end) - turned)}
    _close(run, wanted | {("out", name): share * c * squared for name, share in shares.items()}, rtol)


# -- slip that reverses inside a long step, from rest ------------------------------------------------------------------

KNOTS = np.linspace(0.0, 2.0, 9)
SPLINE = CubicSpline(KNOTS, [0.0, 3, 5, 2, -1, -4, 2, 6, 1], bc_type="clamped")
FIRST, SECOND, DRAG = 0.4, 0.7, 0.8


def _pieces():
    """The spline as polynomials of time between its knots."""
    polys = [Poly(SPLINE.c[::-1, i])(Poly([-x, 1.0])) for i, x in enumerate(KNOTS[:-1])]
    return gb.piecewise(
        *((_signal(p), x > T) for p, x in zip(polys, KNOTS[1:-1], strict=False)), (_signal(polys[-1]), True)
    )


def _with_slip(coupling, tau):
    rig = gb.Drivetrain("reversals")
    parts = {"drive": gb.Torque(tau=tau), "one": gb.Inertia(J=FIRST), "coupling": coupling}
    parts |= {"two": gb.Inertia(J=SECOND), "load": gb.Damper(c=DRAG), "ground": gb.Fixed()}
    rig.chain(*(rig.add(name, part) for name, part in parts.items()))
    return rig


def _by_hand(low, high, slides):
    """Work of the drive and losses of coupling and load, by scipy: force on `two` in [low, high] while its slip is 0, else
    slides(sign of slip)."""
    y, t, end, mode = np.zeros(5), 0.0, 2.0, 0.0
    while t < end:
        knot = KNOTS[np.searchsorted(KNOTS, t + 1e-12)]

        def force(t, y, mode=mode):
            held = (SECOND * SPLINE(t) + FIRST * DRAG * y[1]) / (FIRST + SECOND)
            return held if mode == 0 else slides(mode)

        def rates(t, y, force=force):
            f = force(t, y)
            return [
                (SPLINE(t) - f) / FIRST,
                (f - DRAG * y[1]) / SECOND,
                SPLINE(t) * y[0],
                f * (y[0] - y[1]),
                DRAG * y[1] ** 2,
            ]

        watched = [lambda t, y, f=force: f(t, y) - high, lambda t, y, f=force: f(t, y) - low] if mode == 0 else []
        watched = watched or [lambda t, y, m=mode: m * (y[1] - y[0])]
        for event, direction in zip(watched, (1, -1) if mode == 0 else (-1,), strict=True):
            event.terminal, event.direction = True, direction
        run = solve_ivp(rates, (t, knot), y, "DOP853", rtol=1e-13, atol=1e-15, events=watched)
        t, y = run.t[-1], run.y[:, -1].copy()
        if mode == 0 and any(len(x) for x in run.t_events):
            mode = -1.0 if len(run.t_events[0]) else 1.0
        elif mode != 0 and len(run.t_events[0]):
            y[:2] = y[:2].mean()
            held = (SECOND * SPLINE(t) + FIRST * DRAG * y[1]) / (FIRST + SECOND)
            mode = 0.0 if low <= held <= high else -1.0 if held > high else 1.0
    return y[2:]


COUPLINGS = {
    "clutch": (gb.Clutch(capacity=1.5), (-1.5, 1.5, lambda sign: -1.5 * sign)),
    "small clutch": (gb.Clutch(mu=0.3, force_max=2.0, engagement=1.0), (-0.6, 0.6, lambda sign: -0.6 * sign)),
    "freewheel": (gb.Freewheel(), (0.0, np.inf, lambda sign: 0.0)),
    "one way": (gb.OneWayClutch(capacity=0.4), (-0.4, np.inf, lambda sign: -0.4)),
}


QUICK = {("pieces", "clutch"), ("table", "small clutch"), ("pieces", "freewheel"), ("table", "one way")}


@pytest.mark.long
@pytest.mark.parametrize(
    ("source", "name"),
    [
        pytest.param(source, name, marks=[pytest.mark.long] * ((source, name) not in QUICK))
        for source in ("pieces", "table")
        for name in COUPLINGS
    ],
)
def test_work_and_losses_where_slip_reverses_inside_a_long_step(name, source):
    block, law = COUPLINGS[name]
    model = gb.build(
        _with_slip(block, _pieces() if source == "pieces" else gb.Table(KNOTS, SPLINE(KNOTS), "cubic", ends="flat"))
    )
    wanted = dict(zip([("in", "drive"), ("out", "coupling"), ("out", "load")], _by_hand(*law), strict=True))
    for method in ("dp5", "dp8", "rodas"):
        for rtol in (1e-4, 1e-6, 1e-8, 1e-9, 1e-10):
            run = gb.simulate(model, t_end=2.0, method=method, rtol=rtol)
            assert [e.component for e in run.events].count("coupling") >= 1
            _close(run, wanted, rtol)


def _driven(tau, *load, **start):
    rig = gb.Drivetrain("a long run")
    parts = [rig.add(f"part{i}", part) for i, part in enumerate((gb.Inertia(J=1.0, **start), *load))]
    rig.chain(rig.add("drive", gb.Torque(tau=tau)), *parts)
    return rig


@pytest.mark.filterwarnings("ignore:run of 'a long run'. its energy is balanced")  # above 1e-2, whatever rtol is
@pytest.mark.parametrize(
    ("rig", "rtol"),
    [
        (_driven(3 * gb.sin(0.7 * gb.time), w0=2.0), 1e-3),
        (_driven(3 * gb.cos(0.7 * gb.time), w0=2.0), 1e-2),
        (_driven(3 * gb.sin(0.7 * gb.time), gb.Shaft(k=0.02, c=0.01), gb.Fixed()), 1e-2),
        (_driven(2 * gb.sin(0.5 * gb.time) + gb.sin(0.8 * gb.time), gb.Damper(c=0.1), gb.Fixed()), 1e-2),
        (_driven(2 * gb.sin(0.5 * gb.time) + gb.sin(0.8 * gb.time), gb.IdealGear(ratio=2.0), gb.Inertia(J=0.5), w0=3.0), 1e-2),
    ],
    ids=["free", "free from the top", "on a soft shaft", "damped", "through a gear"],
)  # fmt: skip
@pytest.mark.few(1)
def test_the_ledger_of_twenty_thousand_steps_closes_as_that_of_a_hundred(rig, rtol):
    # a thousandth of what was exchanged so far is twenty times what one of so many steps exchanges
    run = gb.simulate(rig, t=np.linspace(0.0, 1e5, 50), rtol=rtol, method="dp5")
    assert run.stats.steps > 10_000
    assert run.energy.residual < 10 * rtol


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.parametrize(
    ("constant", "swing", "frequency", "torque"),
    [
        (0.0, 5.0, 8.71, 0.152),
        pytest.param(2.0, 5.0, 8.71, 0.152, marks=pytest.mark.long),
        pytest.param(0.0, 50.0, 8.71, 0.152, marks=pytest.mark.long),
        pytest.param(0.0, 5.0, 20.0, 0.152, marks=pytest.mark.long),
        pytest.param(0.0, 5.0, 8.71, 0.5, marks=pytest.mark.long),
    ],
)
def test_a_brake_that_comes_and_goes_ends_steps_that_nobody_looked_at(constant, swing, frequency, torque, method):
    """The body slides to rest in each period; what the last look found inside its step says nothing of a later one."""
    capacity = constant + swing * gb.cos(frequency * T)
    rig = gb.Drivetrain("pulsing brake")
    parts = rig.add("drive", gb.Torque(tau=torque)), rig.add("body", gb.Inertia(J=0.149))
    rig.chain(*parts, rig.add("brake", gb.Brake(capacity=capacity)))
    model = gb.build(rig)
    for rtol in (1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11):
        run = gb.simulate(model, t=np.linspace(0, 3, 101), rtol=rtol, method=method)
        (work,) = run.energy.supplied.values()
        assert work == pytest.approx(torque * run["body.phi"][-1], rel=2 * rtol), rtol
        assert run.energy.residual <= 3 * rtol, rtol
