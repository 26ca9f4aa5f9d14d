"""The matrix of implicit methods against differences of the right-hand side, modes frozen."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.cli.scripts import make
from gearblocks.codegen.jacobian.sparsity import Pattern
from gearblocks.solver.binding import Simulation
from gearblocks.solver.step_matrix import StepMatrix
from gearblocks.solver.structures import Options
from gearblocks.train.handles import FlangeHandle

NEAR = 1e-9  # differences of fourth order with steps of 1e-3 of each state: 1e-12, times what terms cancel


def dense(pattern: Pattern, linear: StepMatrix) -> np.ndarray:
    """The matrix in full."""
    full = np.diag(linear.diag)
    for k, column in enumerate(pattern.order):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            row = pattern.order[pattern.row[place]]
            full[row, column], full[column, row] = linear.lower[place], linear.upper[place]
    return full


def solved(pattern: Pattern, linear: StepMatrix, b: np.ndarray) -> np.ndarray:
    """The solution by L D U as gb_pattern describes it."""
    n = len(pattern.order)
    d, low, up = (linear.diag[list(pattern.order)], linear.lower.copy(), linear.upper.copy())
    at = 0
    for k in range(n):
        places = range(pattern.start[k], pattern.start[k + 1])
        for a, one in enumerate(places):
            d[pattern.row[one]] -= low[one] * up[one] / d[k]
            for other in places[a + 1 :]:
                low[pattern.pair[at]] -= low[other] * up[one] / d[k]
                up[pattern.pair[at]] -= low[one] * up[other] / d[k]
                at += 1
    assert at == len(pattern.pair)
    x = b[list(pattern.order)].astype(float)
    for k in range(n):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            x[pattern.row[place]] -= low[place] * x[k] / d[k]
    for k in reversed(range(n)):
        for place in range(pattern.start[k], pattern.start[k + 1]):
            x[k] -= up[place] * x[pattern.row[place]]
        x[k] /= d[k]
    out = np.empty(n)
    out[list(pattern.order)] = x
    return out


def differences(sim: Simulation, t: float, y: np.ndarray, size: np.ndarray) -> np.ndarray:
    """d(dy)/dy by central differences of fourth order."""
    n = len(size)
    result = np.empty((n, n))
    for j in range(n):
        f = []
        for k in (1, -1, 2, -2):
            moved = y.copy()
            moved[j] += k * 1e-3 * size[j]
            f.append(sim.rhs(t, moved)[:n])
        result[:, j] = (8 * (f[0] - f[1]) - (f[2] - f[3])) / (12e-3 * size[j])
    return result


def check(rig: gb.Drivetrain, angle: float = 1.0, speed: float = 1.0, state: float = 1.0) -> Pattern:
    """Compares at random points of that size. g goes from small to large, so that each part of the matrix counts."""
    model = gb.build(rig)
    size = np.array([{"rad": angle, "rad/s": speed}.get(q.unit, state) for q in model.program.states])
    random = np.random.default_rng(7)
    with model.library.open() as sim:
        pattern = sim.pattern()
        assert pattern is not None
        sim.parameters[:] = model.values
        sim.inputs[:] = 1.3
        for t in (0.0, 0.37, 2.9):
            y = np.zeros(model.program.n_total)
            y[: len(size)] = size * random.normal(size=len(size))
            assert sim.start(Options(2, 1, 1e-6, 0.0, np.inf, np.inf), t, y) == 0
            J = differences(sim, t, y, size)
            off, row = np.abs(sim.jacobian(t, y).toarray() - J) * size, (np.abs(J) * size).max(axis=1, keepdims=True)
            assert (off <= NEAR * row).all()
            for g in (1e-3 * angle / speed, angle / speed, 1e3 * angle / speed):
                check_step(sim, pattern, sim.step_matrix(t, y, g), (J, sim.step_matrix(t, y, 0.0).diag, size), random)
    return pattern


def check_step(
    sim: Simulation, pattern: Pattern, linear: StepMatrix, known: tuple, random: np.random.Generator
) -> None:
    """One step size: the matrix, the right side, the solution, the rates. known: derivatives, inertias, sizes."""
    (J, E, size), g = known, linear.g
    simple = len(size) - len(E)
    A, K, B = E[:, None] * J[simple:, simple:], E[:, None] * J[simple:, :simple], J[:simple, simple:]
    S = dense(pattern, linear)
    parts = np.diag(E) + g * np.abs(A) + g**2 * np.abs(K) @ np.abs(B)
    off = (np.diag(E) - g * A - g**2 * K @ B - S) * size[simple:]
    assert (np.abs(off) / (parts * size[simple:]).max(axis=1, keepdims=True)).max() < NEAR
    r = size * random.normal(size=len(size))
    b = sim.right_side(linear, r)
    weight = E * np.abs(r[simple:]) + g * np.abs(K) @ np.abs(r[:simple])
    assert (np.abs(E * r[simple:] + g * K @ r[:simple] - b) / weight).max() < NEAR
    x = solved(pattern, linear, b)
    assert np.abs(S @ x - b).max() <= 1e-12 * (np.abs(S) @ np.abs(x)).max()  # rounding of a few dozen operations
    assert np.allclose(x, np.linalg.solve(S, b), rtol=0, atol=1e-14 * np.linalg.cond(S) * np.abs(x).max())
    rates = sim.simple_rates(linear, x)
    assert np.allclose(rates, B @ x, rtol=0, atol=NEAR * (np.abs(B) @ np.abs(x)).max(initial=0.0))


# -- laws -------------------------------------------------------------------------------------------------------------


def between(*links: gb.Block, ends: tuple[gb.Block, ...] = ()) -> gb.Drivetrain:
    """Inertias with these links in between, and blocks at the end of the chain."""
    rig = gb.Drivetrain("chain")
    parts = [rig.add("disc0", gb.Inertia(J=1.5))]
    for i, link in enumerate(links):
        parts += [rig.add(f"link{i}", link), rig.add(f"disc{i + 1}", gb.Inertia(J=1.0 + 0.5 * i))]
    parts += [rig.add(f"end{i}", end) for i, end in enumerate(ends)]
    rig.chain(*parts)
    return rig


def test_the_shipped_spline_coupling():
    assert check(make("spline_coupling"), angle=1e-3, speed=0.1).is_tree


def test_a_long_chain_to_the_ground_is_eliminated_from_both_ends():
    links = [gb.Shaft(k=100.0 + i, c=0.1 * i) if i % 2 else gb.Lash(k=50.0, half_gap=0.3, c=0.2) for i in range(40)]
    pattern = check(between(*links, ends=(gb.Shaft(k=3.0, c=1.0), gb.Fixed())))
    assert pattern.is_tree
    assert pattern.order[:4] == (0, 40, 1, 39)


def test_damping_ratios_clipped_dampers_and_loads():
    mesh = gb.GearMesh(
        teeth=(20, 33), external=True, r_base=(0.2, 0.33), k=300.0, damping_ratio=0.1,
        backlash=gb.Backlash(half_gap=0.05), contact_damping="clipped",
        stiffness_variation=gb.Fourier(cos=(0.2,), sin=(0.1,), driven_by=3.0),
        transmission_error=gb.Harmonic(cos=(0.02,), driven_by=gb.Input("speed", unit="rad/s") * 2),
    )  # fmt: skip
    pushing = gb.Lash(k=40.0, half_gap=0.2, damping_ratio=0.2, contact_damping="clipped_force")
    check(between(gb.Shaft(k=50.0, damping_ratio=0.1), mesh, pushing, ends=(gb.SpeedLoad(coeffs=(1.0, 2.0, 3.0)),)))


def test_a_mesh_over_the_angle_with_a_carrier_that_turns():
    rig = gb.Drivetrain("epicyclic")
    bodies = [rig.add(n, gb.Inertia(J=j)) for n, j in (("sun", 1.0), ("planet", 0.5), ("arm", 2.0), ("ring", 3.0))]
    sun, planet, arm, ring = bodies
    wave = gb.Fourier(cos=(0.2, 0.1), sin=(0.05,))
    gap = gb.Backlash(half_gap=0.01)
    inner = gb.GearMesh(
        teeth=(20, 30), external=True, r_base=(0.2, 0.3), k=200.0, c=1.0, stiffness_variation=wave, backlash=gap,
        transmission_error=gb.Harmonic(cos=(0.01,)), contact_damping="always",
    )  # fmt: skip
    outer = gb.GearMesh(teeth=(30, 80), external=False, r_base=(0.3, 0.8), k=150.0, c=2.0, stiffness_variation=wave)
    for name, mesh, one, other in (("inner", inner, sun, planet), ("outer", outer, planet, ring)):
        added = rig.add(name, mesh)
        rig.connect(added.pinion, one.a)
        rig.connect(added.wheel, other.a)
        rig.connect(added.carrier, arm.a)
    check(rig, angle=0.03)  # so that the phase of the teeth, 40 times the angle, moves little in a difference


@pytest.mark.parametrize("external", [False, True], ids=["internal", "external"])
def test_non_circular_pairs_with_a_stiffness_over_the_angle(external):
    laws = (gb.RatioLaw.ellipse(0.3), gb.RatioLaw.segments(0.0887, 0.8143, 4.19))
    stiff = 20 + 5 * gb.cos(2 * gb.driver_angle)
    moves = 0.3 + gb.sin(gb.time)
    gears = [gb.NonCircularGear(law=law, external=external, k=stiff, c=1.0, phase=moves) for law in laws]
    check(between(*gears), angle=0.3)


def test_springs_over_tables_and_expressions():
    table = gb.Table([-3.0, -1.0, 0.5, 2.0, 4.0], [-5.0, -1.0, 0.2, 3.0, 9.0], kind="cubic")
    law = 3 * gb.twist + 2 * gb.twist**3 + sp.sin(gb.twist)
    stiff = gb.Shaft(k=10 + gb.sin(2 * gb.time) + gb.Input("k"))
    check(between(gb.Shaft(torque=table, c=1.0), gb.Shaft(torque=law), stiff))


# -- loops and ratios -------------------------------------------------------------------------------------------------


def test_loops_fold_their_deflections_onto_the_coordinates():
    rig = between(gb.Shaft(k=10.0), gb.Shaft(k=20.0, c=0.3), gb.Lash(k=15.0, half_gap=0.2, c=0.1))
    handles = [FlangeHandle(rig, f"disc{i}", "a") for i in range(4)]
    for i, (a, b) in enumerate(((0, 2), (1, 3), (0, 3), (0, 3))):
        cross = rig.add(f"cross{i}", gb.Shaft(k=5.0 + i, c=0.2))
        rig.connect(cross.a, handles[a])
        rig.connect(cross.b, handles[b])
    pattern = check(rig)
    assert not pattern.is_tree


def test_ideal_gears_bring_their_ratios_in():
    rig = gb.Drivetrain("ratios")
    a, b, c, d = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abcd", (1.0, 0.3, 2.0, 0.7), strict=True))
    gear, other = (
        rig.add("gear", gb.IdealGear(teeth=(21, 44), external=True)),
        rig.add("other", gb.IdealGear(ratio=2.5)),
    )
    one, two = rig.add("one", gb.Shaft(k=30.0, c=0.5)), rig.add("two", gb.Lash(k=20.0, half_gap=0.1))
    rig.chain(a, gear, b, one, c, other, d)
    rig.connect(two.a, d.b)
    rig.connect(two.b, a.a)
    check(rig)


def test_a_spring_between_two_shafts_of_one_gear_and_a_spring_elsewhere():
    """Both ends of `across` turn with the same group, at different speeds; the entry is one number on the diagonal."""
    rig = gb.Drivetrain("across")
    a, b, c = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abc", (1.0, 0.3, 2.0), strict=True))
    gear, across, on = (
        rig.add("gear", gb.IdealGear(ratio=3.0)),
        rig.add("across", gb.Shaft(k=30.0, c=0.5)),
        rig.add("on", gb.Shaft(k=20.0, c=0.4)),
    )
    rig.chain(a, gear, b, on, c)
    rig.connect(across.a, a.a)
    rig.connect(across.b, b.a)
    check(rig)


# -- states and feedback ----------------------------------------------------------------------------------------------


class Motor(gb.Block):
    """DC motor with its current as a state, saturating."""

    shaft = gb.Flange("output shaft")
    u = gb.signal("terminal voltage", "V")
    i = gb.State("current", "A")

    def physics(self, s):
        yield gb.Acts(s.shaft, 0.7 * sp.tanh(s.i))
        yield gb.Rate(s.i, (s.u - 2 * s.i - 0.7 * s.shaft.w) / 0.3)
        yield gb.Shows("torque", 0.7 * sp.tanh(s.i), "N m")
        yield gb.Shows("current", s.i, "A")
        yield gb.Shows("limited", sp.Max(-1, sp.Min(s.i + s.shaft.w, 1)), "A")


class Hysteresis(gb.Block):
    """Bouc-Wen spring: k (a x + (1 - a) z), z' = v (1 - z^2 (b sign(v z) + c))."""

    a, b = gb.Flange("left end"), gb.Flange("right end")
    k: float = gb.param("stiffness", "N m/rad")
    z = gb.State("hysteretic part")

    def physics(self, s):
        v = s.b.w - s.a.w
        yield gb.Force(s.b.phi - s.a.phi, self_force := s.k * (0.4 * (s.b.phi - s.a.phi) + 0.6 * s.z))
        yield gb.Rate(s.z, v * (1 - s.z**2 * (0.5 * sp.sign(v * s.z) + 0.3)))
        yield gb.Shows("torque", self_force, "N m")


def test_states_of_blocks_couple_with_their_shafts():
    rig = between(Hysteresis(k=20.0), gb.Shaft(k=30.0, c=0.1), Hysteresis(k=5.0))
    motor = rig.add("motor", Motor(u=12.0 * gb.sin(gb.time)))
    rig.connect(motor.shaft, FlangeHandle(rig, "disc0", "a"))
    check(rig)


FEEDBACKS = {
    "speed": -3 * gb.sense("disc1.w"),
    "angle": -2 * gb.sense("disc2.phi") + sp.sin(gb.sense("disc0.phi")),
    "difference of speeds, squared": (gb.sense("disc0.w") - gb.sense("disc2.w")) ** 2 * gb.cos(gb.time),
    "force": 0.3 * gb.sense("link1.torque") * gb.sense("link0.torque"),
    "state": gb.sense("motor.current") * 1.7,
    "in a row": gb.sense("relay.torque") ** 2 * gb.sense("disc2.w"),
    "with a condition": sp.Piecewise(
        (gb.sense("disc1.w") ** 2, gb.sense("disc0.w") > 0.1), (gb.sense("disc0.w"), True)
    ),
}


@pytest.mark.parametrize("name", FEEDBACKS)
def test_what_is_sensed_adds_its_derivative(name):
    rig = between(gb.Lash(k=20.0, half_gap=0.1, c=0.3), gb.Shaft(k=30.0, c=0.1), ends=(gb.Torque(tau=FEEDBACKS[name]),))
    start = FlangeHandle(rig, "disc0", "a")
    motor, relay = rig.add("motor", Motor(u=2.0)), rig.add("relay", gb.Torque(tau=0.4 * gb.sense("link1.torque")))
    rig.connect(start, motor.shaft)
    rig.connect(start, relay.flange)
    check(rig)


def test_a_motor_that_is_fed_by_a_speed_control():
    u = 3 * (gb.Parameter("target", 2.0, "rad/s") - gb.sense("disc2.w")) + gb.sense("disc1.phi") ** 2
    rig = between(gb.Shaft(k=20.0), gb.Shaft(k=30.0, c=0.1))
    motor = rig.add("motor", Motor(u=u))
    rig.connect(motor.shaft, FlangeHandle(rig, "disc0", "a"))
    check(rig)


def test_a_sensed_output_with_a_limit_of_its_own_has_the_slope_of_its_side():
    tau = -2 * gb.sense("motor.limited") * gb.sense("disc1.w")
    rig = between(gb.Shaft(k=20.0), ends=(gb.Torque(tau=tau),))
    motor = rig.add("motor", Motor(u=1.0))
    rig.connect(motor.shaft, FlangeHandle(rig, "disc0", "a"))
    check(rig)


# -- shafts that follow others, and shafts without inertia ------------------------------------------------------------


class Cam(gb.Block):
    """phi_b = phi_a + sin(phi_a)/2."""

    a, b = gb.Flange("driving side"), gb.Flange("driven side")

    def physics(self, s):
        yield gb.Tie(s.b.phi - s.a.phi - sp.sin(s.a.phi) / 2)


def check_whole(rig: gb.Drivetrain) -> tuple[int, ...]:
    """Solves (1 - g J) U = g r by way of the matrix: S x = g right_side(r), U = x and, of simple states, g (r + B x).

    This holds for every train, hidden unknowns included, and does not need to know what E is. Answers sizes.
    """
    model = gb.build(rig)
    n = model.program.n
    random = np.random.default_rng(11)
    with model.library.open() as sim:
        pattern = sim.pattern()
        assert pattern is not None
        simple, hidden, _ = sim.linear_sizes()
        assert len(pattern.order) == n - simple + hidden
        sim.parameters[:] = model.values
        sim.inputs[:] = 1.3
        for t in (0.0, 0.37, 2.9):
            y = np.zeros(model.program.n_total)
            y[:n] = random.normal(size=n)
            assert sim.start(Options(2, 1, 1e-6, 0.0, np.inf, np.inf), t, y) == 0
            y = sim.state()
            J = differences(sim, t, y, np.ones(n))
            assert (np.abs(sim.jacobian(t, y).toarray() - J) <= NEAR * np.abs(J).max(axis=1, keepdims=True)).all()
            for g in (1e-3, 0.1, 10.0):
                r = random.normal(size=n)
                linear = sim.step_matrix(t, y, g)
                x = solved(pattern, linear, g * sim.right_side(linear, r))
                ours = np.append(g * (r[:simple] + sim.simple_rates(linear, x)), x[: n - simple])
                true = np.linalg.solve(np.eye(n) - g * J, g * r)
                assert np.abs(ours - true).max() < NEAR * np.abs(true).max()
    return simple, hidden, len(pattern.order)


def test_a_planetary_between_three_springs():
    rig = gb.Drivetrain("planetary")
    planetary = rig.add("planetary", gb.IdealPlanetary(ratio=2.5))
    ends = [rig.add(f"end{i}", gb.Inertia(J=1.0 + i)) for i in range(3)]
    near = [rig.add(f"near{i}", gb.Inertia(J=0.3 + 0.1 * i)) for i in range(3)]
    for i, flange in enumerate((planetary.sun, planetary.carrier, planetary.ring)):
        rig.chain(ends[i], rig.add(f"shaft{i}", gb.Shaft(k=20.0 + i, c=0.3)), near[i])
        rig.connect(near[i].b, flange)
    across = rig.add("across", gb.Lash(k=9.0, half_gap=0.1, c=0.2))
    rig.connect(across.a, ends[0].a)
    rig.connect(across.b, near[2].a)
    load = rig.add("load", gb.Torque(tau=-0.4 * gb.sense("near0.w") * gb.sense("near2.w")))
    rig.connect(load.flange, near[1].a)
    assert check_whole(rig)[1] == 0


def test_prescribed_speeds_and_angles_leave_no_unknown():
    rig = gb.Drivetrain("driven")
    a, b, c = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abc", (1.0, 2.0, 3.0), strict=True))
    one, two = rig.add("one", gb.Shaft(k=20.0, c=0.5)), rig.add("two", gb.Lash(k=30.0, half_gap=0.1, c=0.1))
    speed, angle = rig.add("speed", gb.Speed(w=gb.sin(gb.time))), rig.add("angle", gb.Angle(phi=gb.cos(2 * gb.time)))
    rig.chain(speed, a, one, b, two, c)
    back = rig.add("back", gb.Shaft(k=7.0, c=0.2))
    rig.connect(angle.flange, c.b, back.a)
    rig.connect(back.b, b.a)
    assert check_whole(rig)[1:] == (0, 1)


def test_motions_behind_filters_follow_the_states_of_their_blocks():
    rig = gb.Drivetrain("filtered")
    a, b, c, d = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abcd", (1.0, 2.0, 3.0, 0.5), strict=True))
    one, two, three = (rig.add(f"s{i}", gb.Shaft(k=20.0 + i, c=0.5 * i)) for i in range(3))
    speed = rig.add("speed", gb.Speed(w=gb.Input("w", unit="rad/s"), filter=3.0))
    angle = rig.add("angle", gb.Angle(phi=gb.Input("phi", unit="rad"), filter=2.0))
    gear, planetary = rig.add("gear", gb.IdealGear(ratio=-2.5)), rig.add("planetary", gb.IdealPlanetary(ratio=2.0))
    rig.chain(speed, a, gear, rig.add("e", gb.Inertia(J=0.4)), one, b, two, c)
    rig.connect(angle.flange, c.b, planetary.sun)
    rig.connect(planetary.carrier, b.b)
    rig.connect(planetary.ring, d.a, three.a)
    rig.connect(three.b, a.a)
    assert check_whole(rig)[1] == 0


def test_shafts_without_inertia_that_are_damped_are_hidden_unknowns():
    rig = gb.Drivetrain("damped")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=2.0))
    one, two, three = (rig.add(f"s{i}", gb.Shaft(k=20.0 + i, c=0.3 * i)) for i in range(3))
    rig.chain(a, one, two, three, b)
    assert check_whole(rig)[1] == 2


def test_shafts_without_inertia_between_springs_are_in_balance_at_all_times():
    rig = gb.Drivetrain("springs alone")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=2.0))
    links = [
        gb.Shaft(k=20.0),
        gb.Shaft(torque=30 * gb.twist + 5 * gb.twist**3),
        gb.Shaft(k=9.0),
        gb.Shaft(k=4.0, c=0.2),
    ]
    rig.chain(a, *(rig.add(f"s{i}", link) for i, link in enumerate(links)), b)
    assert check_whole(rig)[1] == 3


# -- gains that change with the position ------------------------------------------------------------------------------


def in_a_row(*links: gb.Block) -> gb.Drivetrain:
    """Bodies with these links in between and springs to the ground at both ends."""
    rig = gb.Drivetrain("row")
    parts = [
        rig.add("ground0", gb.Fixed()),
        rig.add("spring0", gb.Shaft(k=6.0, c=0.2)),
        rig.add("body0", gb.Inertia(J=1.0)),
    ]
    for i, link in enumerate(links):
        parts += [rig.add(f"link{i}", link), rig.add(f"body{i + 1}", gb.Inertia(J=0.5 + 0.3 * i))]
    parts += [rig.add("spring1", gb.Shaft(k=9.0, c=0.1)), rig.add("ground1", gb.Fixed())]
    rig.chain(*parts)
    return rig


def test_a_cam_alone():
    rig = gb.Drivetrain("cam")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("cam", Cam()), rig.add("b", gb.Inertia(J=2.0)))
    check_whole(rig)


@pytest.mark.parametrize("external", [False, True], ids=["internal", "external"])
def test_a_rigid_non_circular_pair_between_springs(external):
    gear = gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.3), external=external, phase=0.4 + 0.3 * gb.sin(gb.time))
    check_whole(in_a_row(gb.Shaft(k=20.0, c=0.4), gear, gb.Lash(k=15.0, half_gap=0.1, c=0.2)))


def test_a_universal_joint_between_springs():
    rig = in_a_row(
        gb.Shaft(k=20.0, c=0.4), gb.UniversalJoint(angle=0.7, phase=0.2), gb.Shaft(k=30.0), gb.Shaft(k=9.0, c=0.1)
    )
    assert check_whole(rig)[0] > 0  # of the springs, only those beside the driven fork are no simple states


def test_universal_joints_with_springs_and_without_any_between_them():
    joint = gb.UniversalJoint(angle=0.5)
    check_whole(
        in_a_row(
            joint, gb.UniversalJoint(angle=0.6, phase=0.3), gb.Shaft(k=12.0, c=0.3), joint, gb.IdealGear(ratio=-1.5)
        )
    )


def test_two_non_circular_pairs_and_a_differential():
    """Both side shafts of a differential through pairs with ratios that change, and springs across."""
    rig = gb.Drivetrain("two pairs")
    set_ = rig.add("set", gb.IdealPlanetary(ratio=-1.5))
    for i, flange in enumerate((set_.sun, set_.ring)):
        pair = rig.add(f"pair{i}", gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.2 + 0.1 * i), external=bool(i)))
        near, far = rig.add(f"near{i}", gb.Inertia(J=0.4 + 0.2 * i)), rig.add(f"far{i}", gb.Inertia(J=1.0 + i))
        rig.chain(far, rig.add(f"shaft{i}", gb.Shaft(k=20.0 + i, c=0.3)), near, pair)
        rig.connect(pair.b, flange)
        if i:
            across = rig.add("across", gb.Lash(k=9.0, half_gap=0.1, c=0.2))
            rig.connect(across.a, flange)
            rig.connect(across.b, far.a)
    out = rig.add("out", gb.Inertia(J=2.0))
    rig.connect(set_.carrier, out.a)
    load = rig.add("load", gb.Torque(tau=-0.4 * gb.sense("near0.w") * gb.sense("out.w") - gb.sense("out.phi")))
    rig.connect(load.flange, out.a)
    check_whole(rig)


class Crank(gb.Block):
    """phi = sin(z), z' = 2 w - z: a motion that is nonlinear in a state, which follows a shaft in turn."""

    a, b = gb.Flange("shaft that is read"), gb.Flange("shaft that is moved")
    z = gb.State("position", "rad")

    def physics(self, s):
        yield gb.Tie(s.b.phi - sp.sin(s.z))
        yield gb.Rate(s.z, 0.7 * sp.cos(s.z))


def test_a_motion_that_is_nonlinear_in_a_state():
    rig = in_a_row(gb.Shaft(k=20.0, c=0.4), gb.Shaft(k=30.0, c=0.1))
    crank = rig.add("crank", Crank())
    rig.connect(crank.b, FlangeHandle(rig, "body1", "a"))
    rig.connect(crank.a, FlangeHandle(rig, "body0", "a"))
    check_whole(rig)


def test_a_cam_beside_a_damped_shaft_without_inertia_and_a_mesh_over_the_angle():
    mesh = gb.GearMesh(
        teeth=(3, 4), external=True, r_base=(0.3, 0.4), k=80.0, c=1.0, stiffness_variation=gb.Fourier(cos=(0.2,)),
        transmission_error=gb.Harmonic(cos=(0.05,)),
    )  # fmt: skip
    rig = in_a_row(Cam(), mesh, Hysteresis(k=5.0), gb.UniversalJoint(angle=-0.4))
    one, two = rig.add("one", gb.Shaft(k=6.0, c=0.3)), rig.add("two", gb.Shaft(k=5.0, c=0.2))
    rig.connect(one.a, FlangeHandle(rig, "body1", "a"))
    rig.connect(one.b, two.a)
    rig.connect(two.b, FlangeHandle(rig, "body4", "a"))
    assert check_whole(rig)[1] == 1


def test_a_pair_on_a_carrier_that_turns_with_a_phase_behind_a_filter():
    rig = gb.Drivetrain("carrier")
    law = gb.RatioLaw.segments(0.0887, 0.8143, 4.19)
    pair = rig.add("pair", gb.NonCircularGear(law=law, external=True, phase=gb.Input("phase"), filter=3.0))
    one, two, arm = (rig.add(n, gb.Inertia(J=j)) for n, j in (("one", 1.0), ("two", 0.5), ("arm", 2.0)))
    rig.connect(pair.a, one.a)
    rig.connect(pair.b, two.a)
    rig.connect(pair.carrier, arm.a)
    rig.chain(one, rig.add("across", gb.Shaft(k=5.0, c=0.1)), two, rig.add("beside", gb.Shaft(k=7.0)), arm)
    check_whole(rig)


def test_a_cam_beside_a_shaft_in_balance_between_springs_alone():
    rig = in_a_row(Cam(), gb.Shaft(k=4.0))
    one, two = rig.add("one", gb.Shaft(k=6.0)), rig.add("two", gb.Shaft(k=5.0))
    rig.connect(one.a, FlangeHandle(rig, "body1", "a"))
    rig.connect(one.b, two.a)
    rig.connect(two.b, FlangeHandle(rig, "body0", "a"))
    assert check_whole(rig)[1] == 1


class Variator(gb.Block):
    """phi_b = u phi_a with a ratio that moves."""

    a, b = gb.Flange("driving side"), gb.Flange("driven side")
    u = gb.signal("ratio", "1")

    def physics(self, s):
        yield gb.Tie(s.b.phi - s.u * s.a.phi)


def test_gains_that_change_with_time_and_many_joints():
    joints = [link for i in range(9) for link in (gb.UniversalJoint(angle=0.2 + 0.03 * i), gb.Shaft(k=5.0 + i, c=0.1))]
    check_whole(in_a_row(gb.Shaft(k=5.0), Variator(u=2 + 0.3 * gb.sin(gb.time)), *joints))
