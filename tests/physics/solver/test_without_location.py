"""Runs that locate nothing: every stage takes the side it is on, as an `if` in a right-hand side does."""

from math import cos

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

# P1 of the benchmarks: four discs, two shafts, a mesh with backlash, driven over time
J, K, ZETA, RADIUS, MESH, RIPPLE, HALF_GAP = (5e-3, 2e-4, 2e-4, 1e-2), 1e5, 0.05, 0.025, 245e6, 0.3, 20e-6
LOAD, SWING, W, T_END = 2600.0, 0.1, 4.2e4, 0.02
LEFT, RIGHT = (2 * ZETA * np.sqrt(K / (1 / a + 1 / b)) for a, b in (J[:2], J[2:]))
DAMPING = 2 * ZETA * np.sqrt(MESH * (J[1] * J[2] / (J[1] + J[2])) / RADIUS**2)
START = np.array([LOAD / K, (HALF_GAP + LOAD / (RADIUS * MESH)) / RADIUS, LOAD / K, 0.0, 0.0, 0.0, 0.0])
SIZES = np.array([*START[:3], *[0.1 * HALF_GAP / RADIUS * W] * 4])
T = np.linspace(0.0, T_END, 101)[1:]


def _p1():
    rig = gb.Drivetrain("P1")
    wave = gb.cos(W * gb.time)
    angles = np.cumsum([0.0, *START[2::-1]])[::-1]
    discs = [rig.add(f"disc{i}", gb.Inertia(J=J[i], phi0=float(angles[i]))) for i in range(4)]
    left, right = (rig.add(name, gb.Shaft(k=K, damping_ratio=ZETA)) for name in ("left", "right"))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20, radius=RADIUS, k=MESH, c=DAMPING, contact_damping="always",
            stiffness_variation=gb.Fourier(cos=(RIPPLE,), driven_by=W), backlash=gb.Backlash(half_gap=HALF_GAP),
        ),
    )  # fmt: skip
    drive, load = rig.add("drive", gb.Torque(tau=LOAD * (1 + SWING * wave))), rig.add("load", gb.Torque(tau=-LOAD))
    rig.chain(drive, discs[0], left, discs[1], mesh, discs[2], right, discs[3], load)
    return rig


def _p1_rates(t, y):
    a, d, e, w1, w2, w3, w4 = y
    x, wave = RADIUS * d, cos(W * t)
    gap = x - HALF_GAP if x > HALF_GAP else x + HALF_GAP if x < -HALF_GAP else 0.0
    left, right = K * a + LEFT * (w1 - w2), K * e + RIGHT * (w3 - w4)
    mesh = RADIUS * (DAMPING * RADIUS * (w2 - w3) + MESH * (1 + RIPPLE * wave) * gap)
    torque = LOAD * (1 + SWING * wave)
    return [
        w1 - w2, w2 - w3, w3 - w4,
        (torque - left) / J[0], (left - mesh) / J[1], (mesh - right) / J[2], (right - LOAD) / J[3],
    ]  # fmt: skip


def _p1_error(twists, true):
    return np.max(np.abs(twists - true) / np.abs(true).max(axis=0))


def _twists(run):
    return np.column_stack([-run["left.twist"], run["mesh.deflection"] / RADIUS, -run["right.twist"]])


LONG = [1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 3e-8, 1e-8]


@pytest.mark.long
@pytest.mark.parametrize(
    "tolerances",
    [
        pytest.param(LONG[:2], id="two"),
        pytest.param(LONG[:4], id="few"),
        pytest.param(LONG, id="all"),
    ],
)
def test_p1_is_as_right_as_by_dop853_for_the_same_number_of_right_hand_sides(tolerances):
    """Both errors scatter by a factor of two or three from one tolerance to the next, since it is chance where in a step a
    corner falls: hence the curve of errors through those of DOP853 at many tolerances, down to one more than is compared
    (ours takes more right-hand sides), and the median over neighbours of each tolerance."""
    model = gb.build(_p1())
    true = _twists(gb.simulate(model, t=T, rtol=1e-12, method="dp8"))
    calls, errors = [], []
    for rtol in np.outer(LONG[: len(tolerances) + 1], np.linspace(0.9, 1.1, 15)).ravel():
        run = solve_ivp(_p1_rates, (0.0, T_END), START, method="DOP853", rtol=rtol, atol=rtol * SIZES, t_eval=T)
        calls.append(np.log(run.nfev))
        errors.append(np.log(_p1_error(run.y[:3].T, true)))
    curve = np.polyfit(calls, errors, 1 if len(tolerances) < 6 else 2)
    for rtol in tolerances:
        ratios = []
        for near in np.linspace(0.9, 1.1, 15):
            run = gb.simulate(model, t=T, rtol=near * rtol, method="dp8", locate=False)
            ratios.append(_p1_error(_twists(run), true) / np.exp(np.polyval(curve, np.log(run.stats.rhs_calls))))
            assert run.energy.residual < 10 * rtol
        assert np.median(ratios) < 2, (rtol, ratios)


def _wall():
    """An inertia of 1 that meets a spring of 400 N m/rad at phi = 0: half a sine of pi/20 s, and back."""
    rig, phi = gb.Drivetrain("wall"), gb.sense("body.phi")
    spring = rig.add("wall", gb.Torque(tau=gb.piecewise((-400 * phi, phi > 0), (0, True))))
    rig.chain(spring, rig.add("body", gb.Inertia(J=1.0)))
    return rig


def test_no_step_across_a_corner_is_taken_for_right_wherever_the_corner_falls():
    """At a corner the two estimates of the pair of order 8 are of the same order: their quotient vanishes by chance."""
    model = gb.build(_wall())
    for rtol in (1e-5, 1e-7):
        for way in np.linspace(0.1, 1.7, 41):
            start = {"body.phi": -way, "body.w": 1.0}
            run = gb.simulate(model, t=[0.0, 2.0], rtol=rtol, method="dp8", locate=False, initial=start)
            back = -(2.0 - way - np.pi / 20)
            assert abs(run["body.phi"][-1] - back) < 10 * rtol * max(way, abs(back)), (rtol, way)
            assert abs(run["body.w"][-1] + 1.0) < 10 * rtol, (rtol, way)


def _governor():
    """Full torque below 80 rad/s and then less by straight lines, a load that starts at 0.4 s and a drag with a step."""
    rig, w = gb.Drivetrain("governor"), gb.sense("rotor.w")
    lines = gb.Table([70.0, 80.0, 90.0], [50.0, 30.0, -10.0])
    rig.chain(
        rig.add("engine", gb.Torque(tau=lines(w))),
        rig.add("rotor", gb.Inertia(J=0.2, w0=10.0)),
        rig.add("load", gb.Torque(tau=gb.piecewise((-0.25 * w, w > 60), (0, True)))),
        rig.add("late", gb.Torque(tau=gb.piecewise((-8 * gb.sin(20 * gb.time), gb.Input("on", 0.0) > 0.5), (0, True)))),
    )
    return rig


def _governor_rates(t, y):
    w = y[0]
    torque = 50.0 if w < 70 else 50.0 - 2 * (w - 70) if w < 80 else 30.0 - 4 * (w - 80) if w < 90 else -10.0
    torque -= 0.25 * w if w > 60 else 0.0
    torque -= 8 * np.sin(20 * t) if t > 0.4 else 0.0
    return [torque / 0.2]


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.few(1)
def test_conditions_on_speeds_tables_and_inputs_change_between_stages(method):
    t = np.linspace(0.0, 1.0, 51)
    marks = gb.Table([0.0, 0.4, 1.0], [0.0, 1.0, 1.0], "step")
    true, y = [], [10.0]
    for part in (t[t <= 0.4], t[t >= 0.4]):  # the load over time starts between the two
        run = solve_ivp(_governor_rates, part[[0, -1]], y, method="DOP853", rtol=1e-12, t_eval=part, max_step=1e-3)
        true, y = [*true, *run.y[0]], run.y[:, -1]
    true = np.delete(true, int(np.flatnonzero(t >= 0.4)[0]))
    model = gb.build(_governor())
    for rtol in (1e-5, 1e-8):
        run = gb.simulate(model, t=t, rtol=rtol, method=method, locate=False, inputs={"on": marks})
        assert np.abs(run["rotor.w"] - true).max() < 300 * rtol * true.max(), rtol
        w = run["rotor.w"]  # outputs at a sample are those of its own side
        assert run["load.torque"] == pytest.approx(np.where(w > 60, -0.25 * w, 0.0), rel=1e-12)


def test_a_fixed_step_takes_the_side_of_every_stage():
    """rk4 by hand with an `if`, against the same steps of ours: the same numbers."""
    h, y = 0.01, np.array([-0.503, 1.0])

    def rates(y):
        return np.array([y[1], -400 * y[0] if y[0] > 0 else 0.0])

    model, found = gb.build(_wall()), []
    for _ in range(100):
        k1 = rates(y)
        k2 = rates(y + h / 2 * k1)
        k3 = rates(y + h / 2 * k2)
        k4 = rates(y + h * k3)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(y)
    t = h * np.arange(1, 101)
    start = {"body.phi": -0.503, "body.w": 1.0}
    run = gb.simulate(model, t=t, method="rk4", step=h, locate=False, initial=start)
    assert np.abs(np.column_stack([run["body.phi"], run["body.w"]]) - found).max() < 1e-12
    assert run.stats.events == 2
