"""Components of Modelica and the rest of its examples, as a user types them, against closed forms or scipy (1e-12)."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import gearblocks as gb

pi, time, g_n = np.pi, gb.time, 9.80665
ONE = np.linspace(0.0, 1.0, 101)


def _near(run: gb.Trajectory, wanted: dict[str, Any], tolerance: float = 1e-8) -> None:
    for name, x in wanted.items():
        assert np.abs(run[name] - x).max() <= tolerance * np.abs(x).max(), name


def test_torque2_and_force2_push_two_bodies_apart() -> None:
    """tau drives flange_b (flange here) and has its reaction on flange_a (housing); a spring holds the second body."""
    rig, W = gb.Drivetrain("Torque2"), 7.0
    pairs = {
        "w": (gb.Torque(tau=10 * gb.sin(W * time)), gb.Inertia(J=0.5, w0=1.0), gb.Inertia(J=2.0)),
        "v": (gb.Force(f=10 * gb.sin(W * time)), gb.Mass(m=0.5, v0=1.0), gb.Mass(m=2.0)),
    }
    for q, (source, left, right) in pairs.items():
        source, left, right = rig.add(f"source_{q}", source), rig.add(f"left_{q}", left), rig.add(f"right_{q}", right)
        rig.connect(left.b, source.housing)
        rig.chain(source, right, rig.add(f"spring_{q}", gb.Shaft(k=50.0)), rig.add(f"fixed_{q}", gb.Fixed()))
    first = 1.0 - 10 / (0.5 * W) * (1 - np.cos(W * ONE))
    second = 10 * W / (2.0 * (25.0 - W**2)) * (np.cos(W * ONE) - np.cos(5 * ONE))
    run = gb.simulate(rig, t=ONE, rtol=1e-10)
    _near(run, {"left_w.w": first, "right_w.w": second, "left_v.v": first, "right_v.v": second})


def test_discs_and_rods_add_to_the_springs_beside() -> None:
    """Disc(deltaPhi) between two inertias with a spring each; Rod(L) between a wall and a spring, and before a gap."""
    delta, angles = np.deg2rad(30.0), gb.Drivetrain("Disc")
    one, two = angles.add("one", gb.Inertia(J=1.0, phi0=0.2, w0=0.0)), angles.add("two", gb.Inertia(J=3.0))
    angles.chain(
        angles.add("wall1", gb.Fixed()), angles.add("spring1", gb.Shaft(k=60.0)), one,
        angles.add("disc", gb.Shaft(rigid=True)), two,
        angles.add("spring2", gb.Shaft(k=40.0, c=0.5, rest=delta)), angles.add("wall2", gb.Fixed(phi0=0.0)),
    )  # fmt: skip
    # two.phi + delta is Modelica's: 4 phi'' = -60 phi - 40 (phi + delta) - 0.5 phi'
    A, rest = np.array([[0.0, 1.0], [-25.0, -0.125]]), -40 * delta / 100
    moved = np.array([expm(A * x) @ [0.2 - rest, 0.0] for x in ONE])
    carried = 40 * (rest + moved[:, 0] + delta) + 0.5 * moved[:, 1] + 3 * (moved @ A[1])
    _near(
        gb.simulate(angles, t=ONE, rtol=1e-10),
        {"one.phi": rest + moved[:, 0], "two.phi": rest + moved[:, 0], "two.w": moved[:, 1], "disc.torque": carried},
    )


REGULARIZED = {  # of RollingResistance: over v, below v0 or everywhere; w is the sensed speed
    "exponential": lambda v, v0: 2 / (1 + gb.exp(-v / (0.01 * v0))) - 1,
    "sine": lambda v, v0: gb.piecewise((v / abs(v), abs(v) >= v0), (gb.sin(pi / 2 * v / v0), True)),
    "linear": lambda v, v0: gb.piecewise((v / abs(v), abs(v) >= v0), (v / v0, True)),
    "cosine": lambda v, v0: gb.piecewise(
        (v / abs(v), abs(v) >= v0), (v / abs(v) * (1 - gb.cos(pi / 2 * v / v0)), True)
    ),
}


def test_rolling_resistance_is_a_force_of_the_sensed_speed() -> None:
    """a = 2 m/s2 from 1 m/s: straight down to v0, then by the closed form of each regularisation."""
    rig, v0, a, m = gb.Drivetrain("RollingResistance"), 0.1, 2.0, 5.0
    cr, inclination = 0.25, 0.75  # cos(atan(3/4)) = 0.8
    load = m * a / (cr * 0.8)
    for name, law in REGULARIZED.items():
        f = -cr * load * sympy.cos(sympy.atan(inclination)) * law(gb.sense(f"{name}.v"), v0)
        rig.chain(rig.add(f"f_{name}", gb.Force(f=f)), rig.add(name, gb.Mass(m=m, v0=1.0)))
    since, c = np.maximum(ONE - 0.45, 0.0), a * pi / (2 * v0)
    below = {
        "sine": 4 * v0 / pi * np.arctan(np.exp(-c * since)),
        "linear": v0 * np.exp(-a / v0 * since),
        "cosine": 4 * v0 / pi * np.arctan(1 / (1 + c * since)),
    }
    wanted = {f"{name}.v": np.where(since > 0, x, 1 - a * ONE) for name, x in below.items()}
    e = 0.02 * v0  # exponential: tanh(v/e), so that sinh(v/e) falls as exp(-a t/e)
    fallen = 1 / e - np.log(2.0) - a * ONE / e
    wanted["exponential.v"] = e * np.where(
        fallen > 20, fallen + np.log(2.0), np.arcsinh(np.exp(np.minimum(fallen, 20)))
    )
    _near(gb.simulate(rig, t=ONE, rtol=1e-10), wanted)


def test_rolling_resistance_of_a_chassis_is_a_signal() -> None:
    """cr = 0.1 + 0.2 t on a slope of 0.05, held once at rest; v' = -g (cr cos + sin)."""
    rig, slope = gb.Drivetrain("Chassis"), np.arctan(0.05)
    car = gb.Chassis(mass=100.0, v0=1.0, rolling=0.1 + 0.2 * time, grade=sympy.atan(0.05))
    rig.add("car", car)
    v = 1.0 - g_n * ((0.1 * ONE + 0.1 * ONE**2) * np.cos(slope) + ONE * np.sin(slope))
    ends = np.argmax(v < 0)
    _near(gb.simulate(rig, t=ONE, rtol=1e-10), {"car.v": np.where(np.arange(101) < ends, v, 0.0)})


@pytest.mark.parametrize("kind", ["Vehicle", "Chassis"])
@pytest.mark.parametrize(("slope", "v0"), [(0.0, 0.5), (0.005, 0.0), (0.005, -0.3), (-0.002, 1e-4)])
def test_rolling_resistance_that_fades_in_a_straight_line_below_vreg_creeps_on_a_slope(
    kind: str, slope: float, v0: float
) -> None:
    """v' = -g (Cr cos(a) min(|v|/vReg, 1) sign(v) + sin a): from above vReg straight down, then exponentially to the creep."""
    Cr, v_reg, m, R, a = 0.01, 1e-3, 100.0, 0.25, np.arctan(slope)
    fading = {"rolling": Cr * gb.minimum(abs(gb.sense("car.v")) / v_reg, 1.0), "grade": sympy.atan(slope)}
    rig = gb.Drivetrain("creep")
    if kind == "Chassis":
        rig.add("car", gb.Chassis(mass=m, v0=v0, **fading))
    else:
        wheel = rig.add("wheel", gb.Inertia(J=2.0, w0=v0 / R))
        rig.chain(wheel, rig.add("car", gb.Vehicle(mass=m - 2.0 / R**2, wheel_radius=R, **fading)))
    weight = g_n if kind == "Chassis" else g_n * (1 - 2.0 / R**2 / m)
    creep, rate = -v_reg * np.tan(a) / Cr, weight * Cr * np.cos(a) / v_reg
    reached = max(abs(v0) - v_reg, 0.0) / (weight * (Cr * np.cos(a) + np.sign(v0) * np.sin(a)))
    below = np.sign(v0) * min(abs(v0), v_reg)
    v = np.where(
        reached > ONE, v0 - np.sign(v0) * (abs(v0) - v_reg) * ONE / max(reached, 1e-300),
        creep + (below - creep) * np.exp(-rate * np.maximum(ONE - reached, 0.0)),
    )  # fmt: skip
    _near(gb.simulate(rig, t=ONE, rtol=1e-10), {"car.v": v})


def _filtered(A: Any, gain: float, starts: float, t: Any) -> Any:
    """Rows of x' = A x + (0, .., gain u), u = starts + sin 8 t and 0.5 more from 0.4 s; the sine from a system of its own."""
    n = len(A)
    B, C = np.zeros((n + 3, n + 3)), np.array([[0.0, 1.0], [-64.0, 0.0]])
    B[:n, :n], B[n : n + 2, n : n + 2], B[n - 1, n], B[n - 1, n + 2] = A, C, gain, gain
    y0, jump = np.array([starts, *np.zeros(n - 1), 0.0, 8.0, starts]), np.array([*np.zeros(n + 2), 0.5])
    at = expm(B * 0.4) @ y0 + jump
    return np.array([expm(B * x) @ y0 if x < 0.4 else expm(B * (x - 0.4)) @ at for x in t])


@pytest.mark.parametrize(("turns", "f_crit"), [(True, 50.0), (False, 5.0)])
@pytest.mark.parametrize("of", ["law", "input"])
def test_position_and_speed_with_exact_false_are_their_filters(of: str, turns: bool, f_crit: float) -> None:
    """-3 dB at f_crit: bf = (sqrt 5 - 1)/2, af^2 = 3 bf, rounded to 4 digits there; the reference jumps at 0.4 s."""
    rig, w_crit, bf = gb.Drivetrain("filters"), 2 * pi * f_crit, (np.sqrt(5.0) - 1) / 2
    af = np.sqrt(3 * bf)
    u: Any = 0.3 + gb.sin(8 * time) + gb.piecewise((0.0, time < 0.4), (0.5, True))
    if of == "input":
        u = gb.Input("u", start=0.3)
    position, speed = gb.Angle(phi=u, filter=w_crit, filter_type="bessel"), gb.Speed(w=u, filter=w_crit)
    for name, source in (("position", position), ("speed", speed)):
        rig.chain(rig.add(name, source), rig.add(f"body_{name}", gb.Inertia(J=2.0) if turns else gb.Mass(m=2.0)))
    inputs = {"u": lambda t: 0.3 + np.sin(8 * t) + 0.5 * (t >= 0.4)} if of == "input" else {}
    t = np.delete(ONE, 40)
    run = gb.simulate(rig, t=t, rtol=1e-10, inputs=inputs)
    second, there = (
        _filtered(np.array([[0.0, 1.0], [-(w_crit**2) / b, -a * w_crit / b]]), w_crit**2 / b, 0.3, t)
        for a, b in ((af, bf), (1.3617, 0.6180))
    )
    first = _filtered(np.array([[-w_crit]]), w_crit, 0.3, t)
    where, rate = ("phi", "w") if turns else ("s", "v")
    u_t = 0.3 + np.sin(8 * t) + 0.5 * (t > 0.4)
    torque = 2.0 * (w_crit * (u_t - second[:, 0]) - af * second[:, 1]) * w_crit / bf
    _near(run, {
        f"body_position.{where}": second[:, 0], f"body_position.{rate}": second[:, 1], "position.torque": torque,
        f"body_speed.{rate}": first[:, 0], "speed.torque": 2.0 * w_crit * (u_t - first[:, 0]),
    }, 1e-7)  # fmt: skip
    _near(run, {f"body_position.{where}": there[:, 0], f"body_position.{rate}": there[:, 1]}, 1e-4)


@pytest.mark.parametrize(("height", "after"), [(1.0, 0.0), (4.0, 300.0)])
@pytest.mark.parametrize("method", ["auto", "rodas"])
def test_the_driving_side_that_is_not_obvious(height: float, after: float, method: str) -> None:
    """LossyGearDemo3: T = -1/2 N m with a driving though b pushes. At rest neither side drives under 1 N m; 4 N m turn it."""
    rig = gb.Drivetrain("LossyGearDemo3")
    step = gb.piecewise((0.0, time < 0.5), (height, True))
    rig.chain(
        rig.add("torque1", gb.Torque(tau=0.0)), rig.add("Inertia1", gb.Inertia(J=0.001)),
        rig.add("gear", gb.LossyGear(ratio=1, loss_table=((0, 0.25, 0.25, 0.625, 2.5),))),
        rig.add("Inertia2", gb.Inertia(J=0.001, phi0=0.0, w0=10.0)), rig.add("torque2", gb.Torque(tau=step)),
    )  # fmt: skip
    t, late = np.linspace(0.0, 1.0, 1001), np.maximum(np.linspace(-0.5, 0.5, 1001), 0.0)
    slow = np.minimum(t, 0.02)
    w = 10 - 500 * slow + after * late
    run = gb.simulate(rig, t=t, rtol=1e-10, method=method)
    _near(run, {"Inertia1.w": w, "Inertia2.phi": 10 * slow - 250 * slow**2 + after / 2 * late**2})
    assert run["gear.mode"][t < 0.0199].tolist() == [1.0] * 20 and set(run["gear.mode"][(t > 0.0201) & (t < 0.5)]) == {
        0.0
    }
    assert run["gear.mode"][-1] == (1.0 if after else 0.0)


def test_vehicles_with_driving_resistances() -> None:
    """Translational.Examples.Vehicle, a second one with twice the torque and a trailer: 60 s of its table, to rest."""
    m, R, A, Cd, Cr, v_nom = 100.0, 0.25, 1.0, 0.5, 0.01, 25 / 3.5
    nominal = (Cd * A * 1.18 * v_nom**2 / 2 + Cr * m * g_n) * R
    x = [0, 5, 5, 10.8, 10.8, 20, 20, 25, 25, 50, 50, 55, 55, 60]
    factor = [0, 0, 5.6, 5.6, 1, 1, 2.8, 2.8, 1, 1, -5, -5, 0, 0]
    climb = [0, 0, 0, 0, 0, 0, 0.05, 0.05, 0, 0, 0, 0, 0, 0]
    torque, grade = gb.Table(x, [nominal * y for y in factor]), gb.Table(x, list(np.arctan(climb)))
    same = {"mass": m, "drag_area": Cd * A, "rolling": Cr, "grade": grade}
    rig = gb.Drivetrain("Vehicle")
    rig.chain(rig.add("torque", gb.Torque(tau=torque)), rig.add("vehicle", gb.Vehicle(wheel_radius=R, **same)))
    rig.chain(
        rig.add("torque1", gb.Torque(tau=2 * torque)), rig.add("wheel", gb.Rack(radius=R)),
        rig.add("vehicle1", gb.Chassis(s0=0.0, v0=0.0, **same)), rig.add("multiSensor", gb.Shaft(rigid=True)),
        rig.add("trailer", gb.Chassis(**same)),
    )  # fmt: skip
    t, rows, pulls, y = np.linspace(0.0, 60.0, 601), np.zeros((601, 2)), np.zeros(601), np.zeros(2)
    stops = lambda _t, y: y[1]  # noqa: E731
    stops.terminal, stops.direction = True, -1  # type: ignore[attr-defined]
    for i, (a, b) in enumerate(itertools.pairwise(x)):
        if a == b or i == 0:
            continue
        force, angle = nominal * factor[i] / R, np.arctan(climb[i])
        against = m * g_n * (Cr * np.cos(angle) + np.sin(angle))

        def rates(_t: float, y: Any, f: float = force - against) -> list[float]:
            return [y[1], (f - 0.3 * y[1] ** 2) / m]

        part = solve_ivp(
            rates, (a, b), y, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True, events=stops, first_step=1e-3
        )
        inside = (t >= a) & (t <= part.t[-1])
        rows[inside], pulls[inside], y = part.sol(t[inside]).T, force, part.y[:, -1]
    rows[t > part.t[-1]] = [y[0], 0.0]
    assert part.status == 1 and 55.0 < part.t[-1] < 60.0
    run = gb.simulate(rig, t=t, rtol=1e-10)
    _near(run, {"vehicle.v": rows[:, 1], "vehicle1.v": rows[:, 1], "trailer.s": rows[:, 0], "vehicle1.s": rows[:, 0]})
    clear = (np.abs(t[:, None] - np.array(x)).min(axis=1) > 1e-9) & (t > 5.0) & (t < part.t[-1])
    assert np.abs(run["multiSensor.torque"] - pulls)[clear].max() < 1e-8 * pulls.max()
    assert np.abs(run["multiSensor.b.power"] - pulls * rows[:, 1])[clear].max() < 1e-8 * (pulls * rows[:, 1]).max()


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "rodas"])
def test_a_gearbox_is_its_equations(rubbing: Any, method: str) -> None:
    """Loss table, gap and damped contact in one block, b = 0.01 rad; the drive turns around: in and out of contact, stuck."""
    Friction, _, Bodies = rubbing
    i, k, c, half, J = 3.0, 2e4, 20.0, 0.005, (0.02, 1.5)
    losses = ((0.0, 0.9, 0.8, 0.5, 0.5), (50.0, 0.8, 0.7, 1.0, 1.0), (1e3, 0.8, 0.7, 1.0, 1.0))
    rig = gb.Drivetrain("Gearbox")
    rig.chain(
        rig.add("torque", gb.Torque(tau=12 * gb.sin(20 * time))), rig.add("motor", gb.Inertia(J=J[0])),
        rig.add("gearbox", gb.Gearbox(ratio=i, loss_table=losses, k=k, c=c, half_gap=half)),
        rig.add("load", gb.Inertia(J=J[1])), rig.add("weight", gb.Torque(tau=-4.0)),
    )  # fmt: skip

    def pulled(y: Any) -> float:
        """Torque of the contact, which pulls the gear's wheel forward and the load back."""
        g, rate = max(y[1] - y[0] / i - half, 0.0) + min(y[1] - y[0] / i + half, 0.0), y[3] - y[2] / i
        return float(k * g + np.clip(c * rate, -abs(k * g), abs(k * g)))

    def law(_t: float, y: Any, slip: float, d: int, _stuck: bool) -> Any:
        T, x = -pulled(y) / i, min(slip, 50.0) / 50.0
        one, two, bearing = 0.9 - 0.1 * x, 0.8 - 0.1 * x, 0.5 + 0.5 * x
        return [
            ((T + d * bearing) / one - T, {}, d * T + bearing, {}),
            ((T + d * bearing) * two - T, {}, -d * T - bearing, {}),
        ]

    def f(t: float, y: Any) -> Any:
        return np.array([12 * np.sin(20 * t) + pulled(y) / i, -4.0 - pulled(y)])

    def corners(_t: float, y: Any) -> list[float]:
        twist, rate = y[1] - y[0] / i, y[3] - y[2] / i
        elastic = k * (max(twist - half, 0.0) + min(twist + half, 0.0))
        clipped = [abs(elastic) - c * rate, abs(elastic) + c * rate] if elastic else [1.0, 1.0]
        return [twist - half, twist + half, abs(y[2]) - 50.0, *clipped]

    rows = Bodies(J, f, [Friction([1, 0], law)], corners).run(np.zeros(4), ONE)
    run = gb.simulate(rig, t=ONE, rtol=1e-10, method=method)
    _near(run, {"motor.phi": rows[:, 0], "load.phi": rows[:, 1], "motor.w": rows[:, 2], "load.w": rows[:, 3]}, 1e-7)
    assert len({e.component for e in run.events}) > 2
    assert run.energy.residual < 1e-8


def _way(t: Any) -> tuple[Any, Any, Any]:
    """KinematicPTP2: 3 rad at no more than 2 rad/s and 5 rad/s2, with its speed and acceleration."""
    pieces = (
        (0.4, 2.5 * t**2, 5 * t, 5.0),
        (1.5, 2 * (t - 0.2), 2.0 + 0 * t, 0.0),
        (1.9, 3 - 2.5 * (1.9 - t) ** 2, 5 * (1.9 - t), -5.0),
    )
    return tuple(
        gb.piecewise(*((p[i], t < p[0]) for p in pieces), (rest, True))
        if t is time
        else np.select([t < p[0] for p in pieces], [p[i] for p in pieces], rest)
        for i, rest in ((1, 3.0), (2, 0.0), (3, 0.0))
    )


@pytest.mark.parametrize("slides", [False, pytest.param(True, marks=pytest.mark.long)])
@pytest.mark.parametrize("of", ["law", pytest.param("input", marks=pytest.mark.long)])
def test_move_is_an_angle_with_its_speed_and_acceleration(of: str, slides: bool) -> None:
    """An inertia that moves along the way draws another one behind a spring along."""
    rig, t = gb.Drivetrain("Move"), np.linspace(0.0, 3.0, 61)
    phi, w, alpha = _way(time) if of == "law" else (gb.Input(n) for n in ("phi", "w", "alpha"))
    bodies = [gb.Mass(m=x) if slides else gb.Inertia(J=x) for x in (0.5, 0.8)]
    one, spring, two = rig.add("one", bodies[0]), rig.add("spring", gb.Shaft(k=120.0, c=0.7)), rig.add("two", bodies[1])
    rig.chain(rig.add("move", gb.Angle(phi=phi, w=w, alpha=alpha)), one, spring, two)
    fed = {n: (lambda at, i=i: float(_way(at)[i])) for i, n in enumerate(("phi", "w", "alpha"))}
    run = gb.simulate(rig, t=t, rtol=1e-9, inputs=fed if of == "input" else None)

    def rates(at: float, y: Any) -> list[float]:
        phi, w, _ = _way(at)
        return [y[1], (-120 * (y[0] - phi) - 0.7 * (y[1] - w)) / 0.8]

    found = solve_ivp(rates, (0.0, 3.0), [0.0, 0.0], t_eval=t, rtol=1e-11, atol=1e-12, max_step=1e-2, method="DOP853").y
    for name, expected in zip(("s", "v") if slides else ("phi", "w"), found, strict=True):
        assert run[f"two.{name}"] == pytest.approx(expected, abs=1e-8)
    for name, expected in zip(("s", "v") if slides else ("phi", "w"), _way(t), strict=False):
        assert run[f"one.{name}"] == pytest.approx(expected, abs=1e-12)
