"""Springs, dampers and bodies on one axis against closed forms."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

TIGHT = {"rtol": 1e-12}
NEAR = 1e-9  # tens to hundreds of steps at rtol 1e-12 each


def _pair(shaft, J=(0.02, 0.05), twist=0.01, rate=0.0):
    rig = gb.Drivetrain("pair")
    a = rig.add("a", gb.Inertia(J=J[0]))
    link = rig.add("shaft", shaft)
    b = rig.add("b", gb.Inertia(J=J[1], phi0=twist, w0=rate))
    rig.chain(a, link, b)
    return rig


def _on_ground(element, J=1.0, phi0=0.0, w0=0.0):
    """Inertia `a` on the element's flange a, the ground on flange b: twist = -phi."""
    rig = gb.Drivetrain("on ground")
    body = rig.add("a", gb.Inertia(J=J, phi0=phi0, w0=w0))
    link = rig.add("link", element)
    ground = rig.add("ground", gb.Fixed())
    rig.chain(body, link, ground)
    return rig


def test_two_inertias_and_a_shaft_oscillate_at_the_known_frequency(distance):
    w = np.sqrt(2.0e4 * (1 / 0.02 + 1 / 0.05))
    t = np.linspace(0, 20 * np.pi / w, 301)
    run = gb.simulate(_pair(gb.Shaft(k=2.0e4)), t=t, **TIGHT)
    assert distance(run["shaft.twist"], 0.01 * np.cos(w * t)) < NEAR
    assert distance(run["shaft.torque"], -2.0e4 * 0.01 * np.cos(w * t)) < NEAR
    # nothing acts from outside: the angular momentum stays zero
    assert np.abs(0.02 * run["a.w"] + 0.05 * run["b.w"]).max() < NEAR * np.abs(0.02 * run["a.w"]).max()


def test_the_damping_ratio_is_the_share_of_critical_damping(distance):
    k, zeta = 2.0e4, 0.07
    w = np.sqrt(k * (1 / 0.02 + 1 / 0.05))
    t = np.linspace(0, 10 * np.pi / w, 201)
    run = gb.simulate(_pair(gb.Shaft(k=k, damping_ratio=zeta)), t=t, **TIGHT)
    root = np.sqrt(1 - zeta**2)
    decay = 0.01 * np.exp(-zeta * w * t) * (np.cos(root * w * t) + zeta / root * np.sin(root * w * t))
    assert distance(run["shaft.twist"], decay) < NEAR


def _geared(**damping):
    """motor -2:1- gear wheel -shaft- load -(-3/2)- flywheel."""
    rig = gb.Drivetrain("geared")
    motor, load = rig.add("motor", gb.Inertia(J=0.01)), rig.add("load", gb.Inertia(J=0.03))
    wheel, fly = rig.add("wheel", gb.Inertia(J=0.005)), rig.add("fly", gb.Inertia(J=0.1))
    first, second = rig.add("first", gb.IdealGear(ratio=2.0)), rig.add("second", gb.IdealGear(ratio=-1.5))
    shaft = rig.add("shaft", gb.Shaft(k=1.0e4, **damping))
    rig.chain(motor, first, wheel, shaft, load, second, fly)
    return rig


@pytest.mark.long
def test_the_damping_ratio_counts_all_inertia_tied_rigidly_to_its_ends(distance):
    left, right = 0.005 + 2.0**2 * 0.01, 0.03 + 0.1 / 1.5**2
    c = 2 * 0.1 * np.sqrt(1.0e4 / (1 / left + 1 / right))
    t = np.linspace(0, 0.1, 101)
    start = {"load.w": 10.0}
    run = gb.simulate(_geared(damping_ratio=0.1), t=t, initial=start, **TIGHT)
    explicit = gb.simulate(_geared(c=c), t=t, initial=start, **TIGHT)
    assert distance(run["shaft.torque"], explicit["shaft.torque"]) < NEAR


def test_the_damping_ratio_follows_a_changed_parameter(distance):
    t = np.linspace(0, 0.1, 101)
    changed = {"motor.J": 0.02, "shaft.k": 2.0e4, "shaft.damping_ratio": 0.05}
    run = gb.simulate(_geared(damping_ratio=0.1), t=t, initial={"load.w": 10.0}, parameters=changed, **TIGHT)
    c = 2 * 0.05 * np.sqrt(2.0e4 / (1 / (0.005 + 4 * 0.02) + 1 / (0.03 + 0.1 / 1.5**2)))
    explicit = gb.simulate(
        _geared(c=c), t=t, initial={"load.w": 10.0}, parameters={"motor.J": 0.02, "shaft.k": 2.0e4}, **TIGHT
    )
    assert distance(run["shaft.torque"], explicit["shaft.torque"]) < NEAR


@pytest.mark.long
def test_the_ground_is_infinite_inertia_in_a_damping_ratio(distance):
    k, zeta, J = 900.0, 0.2, 4.0
    w, root = np.sqrt(k / J), np.sqrt(1 - zeta**2)
    t = np.linspace(0, 3, 101)
    run = gb.simulate(_on_ground(gb.Shaft(k=k, damping_ratio=zeta), J, phi0=0.1), t=t, **TIGHT)
    decay = 0.1 * np.exp(-zeta * w * t) * (np.cos(root * w * t) + zeta / root * np.sin(root * w * t))
    assert distance(run["a.phi"], decay) < NEAR


def test_a_damper_brings_two_inertias_to_their_common_speed(distance):
    rig = _pair(gb.Damper(c=0.3), twist=0.0, rate=7.0)
    t = np.linspace(0, 0.5, 101)
    run = gb.simulate(rig, t=t, **TIGHT)
    slip = 7.0 * np.exp(-0.3 * (1 / 0.02 + 1 / 0.05) * t)
    common = 0.05 * 7.0 / 0.07
    assert distance(run["shaft.w_rel"], slip) < NEAR
    assert distance(run["b.w"], common + slip * 0.02 / 0.07) < NEAR
    lost = 0.5 * 0.05 * 7.0**2 - 0.5 * 0.07 * common**2 - 0.5 * slip[-1] ** 2 * 0.02 * 0.05 / 0.07
    assert run.energy.dissipated["shaft"] == pytest.approx(lost, rel=NEAR)


@pytest.mark.long
def test_a_shaft_pulls_towards_the_angle_at_which_the_ground_is_held(distance):
    rig = _on_ground(gb.Shaft(k=50.0), J=2.0).set({"ground.phi0": 0.25})
    t = np.linspace(0, 4, 101)
    run = gb.simulate(rig, t=t, **TIGHT)
    assert distance(run["a.phi"], 0.25 * (1 - np.cos(5 * t))) < NEAR
    # what the ground exerts on the shaft's end pulls the inertia towards 0.25
    assert distance(run["ground.torque"], 50.0 * (0.25 - run["a.phi"])) < NEAR


def test_negative_stiffness_departs_like_an_inverted_pendulum(distance):
    t = np.linspace(0, 3, 61)
    run = gb.simulate(_on_ground(gb.Shaft(k=-4.0, allow_negative=True), phi0=1e-3), t=t, **TIGHT)
    assert distance(run["a.phi"], 1e-3 * np.cosh(2 * t)) < NEAR
    with pytest.raises(gb.GearblocksError, match="allow_negative"):
        _on_ground(gb.Shaft(k=-4.0))


@pytest.mark.long
def test_a_stiffness_that_swings_in_time_is_the_mathieu_equation(distance, reference):
    t = np.linspace(0, 10, 201)
    run = gb.simulate(_on_ground(gb.Shaft(k=4 + sp.cos(3 * gb.time)), phi0=1.0), t=t, **TIGHT)
    true = reference(lambda t, y, _: (y[1], -(4 + np.cos(3 * t)) * y[0]), (1.0, 0.0), t)
    assert distance(run["a.phi"], true[:, 0]) < NEAR
    assert run.energy.residual < 1e-11  # 10 rtol: parametric work counts as supplied


@pytest.mark.long
def test_a_cubic_spring_swings_as_duffing_did(distance, reference):
    k = gb.Parameter("k3", 1e4)
    rig = _on_ground(gb.Shaft(torque=100 * gb.twist + k * gb.twist**3, c=0.05), w0=1.0)
    t = np.linspace(0, 3, 101)
    run = gb.simulate(rig, t=t, parameters={"k3": 2e4}, **TIGHT)
    true = reference(lambda t, y, _: (y[1], -100 * y[0] - 2e4 * y[0] ** 3 - 0.05 * y[1]), (0.0, 1.0), t)
    assert distance(run["a.phi"], true[:, 0]) < NEAR
    assert run.energy.residual < 1e-11


def test_a_spring_given_by_a_table_is_straight_between_its_points(distance, reference):
    x, y = [-1.0, -0.05, 0.0, 0.05, 1.0], [-200.0, -5.0, 0.0, 5.0, 200.0]
    t = np.linspace(0, 3, 101)
    run = gb.simulate(_on_ground(gb.Shaft(torque=gb.Table(x, y)), w0=2.0), t=t, **TIGHT)
    true = reference(
        lambda t, s, _: (s[1], -np.interp(s[0], x, y)), (0.0, 2.0), t, lambda t, s: (s[0] - 0.05, s[0] + 0.05, s[0])
    )
    assert distance(run["a.phi"], true[:, 0]) < NEAR
    assert run["a.phi"].max() > 0.1  # the swing passes the joints of the table


@pytest.mark.long
def test_a_cubic_table_of_a_spring_passes_through_its_points(distance, reference):
    from scipy.interpolate import CubicSpline

    x = np.linspace(-0.5, 0.5, 9)
    y = 40 * x + 300 * x**3
    spline = CubicSpline(x, y)
    t = np.linspace(0, 3, 101)
    run = gb.simulate(_on_ground(gb.Shaft(torque=gb.Table(x, y, "cubic")), w0=2.0), t=t, **TIGHT)
    true = reference(
        lambda t, s, _: (s[1], -spline(s[0])), (0.0, 2.0), t, lambda t, s: tuple(s[0] - joint for joint in x)
    )
    assert np.abs(true[:, 0]).max() < 0.5  # inside the table
    assert distance(run["a.phi"], true[:, 0]) < NEAR


@pytest.mark.parametrize(
    ("n", "c"),
    [(2, 0.0), *(pytest.param(*case, marks=pytest.mark.long) for case in ((4, 0.0), (8, 0.0), (2, 0.4))), (8, 0.4)],
)
@pytest.mark.few(1)
def test_segments_swing_at_the_frequency_of_a_chain_of_lumps(n, c, distance):
    k, J = 500.0, 0.2
    rig = gb.Drivetrain("free shaft")
    left, right = rig.add("left", gb.Inertia(J=0.0)), rig.add("right", gb.Inertia(J=0.0))
    shaft = rig.add("shaft", gb.Shaft(k=k, c=c or None, J=J, segments=n))
    rig.chain(left, shaft, right)
    w = 2 * n * np.sqrt(k / J) * np.sin(np.pi / (2 * n))
    t = np.linspace(0, 4 * np.pi / w, 101)
    shape = {f"shaft.lump[{i}].phi": 0.01 * np.cos(np.pi * i / n) for i in range(n + 1)}
    run = gb.simulate(rig, t=t, initial=shape, **TIGHT)
    fall = c * w**2 / (2 * k)  # damping in proportion to stiffness leaves the shape as it is
    damped = np.sqrt(w**2 - fall**2)
    swing = np.exp(-fall * t) * (np.cos(damped * t) + fall / damped * np.sin(damped * t))
    assert distance(run["left.phi"], 0.01 * swing) < NEAR
    # free ends: the continuous shaft swings at pi sqrt(k/J); lumps come short of it by (pi/n)^2/24 at most
    assert 0 < 1 - w / (np.pi * np.sqrt(k / J)) < (np.pi / n) ** 2 / 24


def test_a_lash_does_nothing_in_its_gap_and_springs_beyond(distance):
    rig = _on_ground(gb.Lash(k=400.0, half_gap=0.1), w0=2.0)
    run = gb.simulate(rig, t_end=1.0, **TIGHT)
    # 0.05 s to the stop, half a period pi/20 in it, 0.1 s back to the other one
    first, back, other = 0.05, 0.05 + np.pi / 20, 0.15 + np.pi / 20
    corners = [e.t for e in run.events[:3]]
    assert np.allclose(corners, (first, back, other), rtol=0, atol=1e-11)  # corners located to 100 eps, steps at 1e-12
    assert run["a.phi"].max() == pytest.approx(0.1 + 2.0 / 20, rel=1e-4)  # accepted steps straddle the turning point
    # flange a leads: twist = phi_b - phi_a goes below -half_gap, the coast side first
    assert [(e.before, e.after) for e in run.events[:3]] == [(0.0, -1.0), (-1.0, 0.0), (0.0, 1.0)]
    assert set(np.unique(run["link.contact"])) == {-1.0, 0.0, 1.0}


def test_an_inertia_under_constant_torque_gains_speed_evenly(distance):
    rig = gb.Drivetrain("free")
    body = rig.add("body", gb.Inertia(J=4.0, phi0=1.0, w0=-2.0))
    drive = rig.add("drive", gb.Torque(tau=6.0))
    rig.chain(drive, body)
    t = np.linspace(0, 5, 11)
    run = gb.simulate(rig, t=t, **TIGHT)
    assert distance(run["body.w"], -2 + 1.5 * t) < 1e-13  # a polynomial: exact up to rounding
    assert distance(run["body.phi"], 1 - 2 * t + 0.75 * t**2) < 1e-13
    assert run.energy.supplied["drive"] == pytest.approx(6.0 * (run["body.phi"][-1] - 1.0), rel=1e-12)
