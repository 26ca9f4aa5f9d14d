"""Examples of Modelica's Rotational and Translational packages, as a user builds them, against closed forms or scipy (1e-12).

Masses there have lengths: half of each is added to the free lengths of the springs beside.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import gearblocks as gb

pi, time = np.pi, gb.time
ONE = np.linspace(0.0, 1.0, 101)
Case = tuple[gb.Drivetrain, Any, dict[str, Any]]


def _mass(s0: float = 0.0, v0: float = 0.0) -> gb.Mass:
    return gb.Mass(m=1.0, s0=s0, v0=v0)


def _step(at: float, low: float = 0.0, high: float = 1.0) -> Any:
    return gb.piecewise((low, time < at), (high, True))


def _pieces(rates: Any, ends: Any, y: Any, t: Any) -> Any:
    """Rows at t, restarted at the inner ends."""
    rows = np.empty((len(t), len(y)))
    for a, b in itertools.pairwise(ends):
        part = solve_ivp(rates, (a, b), y, "DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
        here = (t >= a) & (t <= b)
        rows[here], y = part.sol(t[here]).T, part.y[:, -1]
    return rows


def sign_convention() -> Case:
    rig = gb.Drivetrain("SignConvention")
    masses = [rig.add(f"mass{i}", _mass()) for i in (1, 2, 3)]
    forces = [rig.add(f"force{i}", gb.Force(f=1.0)) for i in (1, 2, 3)]
    for mass, force, end in zip(masses, forces, ("a", "b", "b"), strict=True):
        rig.connect(getattr(mass, end), force.flange)
    rig.connect(rig.add("fixed", gb.Fixed()).flange, forces[2].housing)
    return rig, ONE, {f"mass{i}.{q}": v for i in (1, 2, 3) for q, v in (("v", ONE), ("s", ONE**2 / 2))}


def initial_conditions() -> Case:
    rig = gb.Drivetrain("InitialConditions")
    m3, m4 = rig.add("m3", _mass(4.5)), rig.add("m4", _mass(12.5))
    rig.chain(
        rig.add("fixed2", gb.Fixed(phi0=1.0)), rig.add("s2", gb.Shaft(k=1e3, rest=3.5)), m3,
        rig.add("sd2", gb.Shaft(k=111.0, c=1.0, rest=8.0)), m4,
    )  # fmt: skip
    m1, m2 = rig.add("m1", gb.Mass(m=1.0, v0=0.0)), rig.add("m2", gb.Mass(m=1.0))
    rig.chain(
        rig.add("fixed1", gb.Fixed(phi0=-1.0)), rig.add("s1", gb.Shaft(k=1e3, rest=1.5, phi_rel0=1.0)), m1,
        rig.add("sd1", gb.Shaft(k=111.0, c=1.0, rest=2.5, phi_rel0=2.5, w_rel0=0.0)), m2,
    )  # fmt: skip
    t, rest = np.linspace(0.0, 5.0, 101), np.array([0.5, 3.0])
    A = np.array([[0, 0, 1, 0], [0, 0, 0, 1], [-1111.0, 111, -1, 1], [111, -111, 1, -1]])
    moved = np.array([expm(A * x) @ [-0.5, -0.5, 0.0, 0.0] for x in t])
    still = {"m3.s": np.full(101, 4.5), "m4.s": np.full(101, 12.5)}
    return rig, t, still | {"m1.s": rest[0] + moved[:, 0], "m2.s": rest[1] + moved[:, 1], "m1.v": moved[:, 2]}


def why_arrows() -> Case:
    rig = gb.Drivetrain("WhyArrows")
    for name in ("mass1", "inertia2"):  # to flange b both, the second one drawn backward
        spring = rig.add(f"spring_{name}", gb.Shaft(k=11.0, rest=1.0))
        rig.chain(rig.add(f"fixed_{name}", gb.Fixed(phi0=-1.9)), spring)
        rig.connect(spring.b, rig.add(name, _mass()).b)
    s = 0.9 * (np.cos(np.sqrt(11.0) * ONE) - 1)
    return rig, ONE, {"mass1.s": s, "inertia2.s": s}


def accelerate() -> Case:
    rig = gb.Drivetrain("Accelerate")
    rig.chain(rig.add("accelerate", gb.Acceleration(alpha=1.0)), rig.add("mass", gb.Mass(m=1.0)))
    return rig, ONE, {"mass.v": ONE, "mass.s": ONE**2 / 2, "accelerate.torque": np.ones(101)}


def damper() -> Case:
    rig, A = gb.Drivetrain("Damper"), np.array([[0.0, 1.0], [-1.0, -25.0]])
    spring = {"k": 1.0, "rest": 1.5}
    elements = ([gb.Damper(c=25.0)], [gb.Damper(c=25.0), gb.Shaft(**spring)], [gb.Shaft(c=25.0, **spring)])
    for i, beside in enumerate(elements, 1):
        mass, fixed = rig.add(f"mass{i}", _mass(3.0, 10.0)), rig.add(f"fixed{i}", gb.Fixed(phi0=4.5))
        for j, element in enumerate(beside):
            rig.chain(mass, rig.add(f"element{i}_{j}", element), fixed)
    moved = np.array([expm(A * x) @ [0.0, 10.0] for x in ONE])
    alone = {"mass1.v": 10 * np.exp(-25 * ONE), "mass1.s": 3 + 0.4 * (1 - np.exp(-25 * ONE))}
    return rig, ONE, alone | {"mass2.s": 3 + moved[:, 0], "mass3.s": 3 + moved[:, 0], "mass3.v": moved[:, 1]}


def sensors() -> Case:
    rig, W = gb.Drivetrain("Sensors"), 8 * pi
    rig.chain(
        rig.add("force", gb.Force(f=10 * gb.sin(W * time))), rig.add("forceSensor", gb.Shaft(rigid=True)),
        rig.add("multiSensor", gb.Shaft(rigid=True)), rig.add("mass", _mass()),
    )  # fmt: skip
    f, v = 10 * np.sin(W * ONE), 10 / W * (1 - np.cos(W * ONE))
    wanted = {"forceSensor.torque": f, "multiSensor.torque": f, "mass.acceleration": f, "multiSensor.b.power": f * v}
    return rig, ONE, wanted | {"mass.v": v}


def brake() -> Case:
    rig, t = gb.Drivetrain("Brake"), np.linspace(0.0, 2.0, 101)
    for i in (1, 2):
        element = rig.add(f"brake{i}", gb.Brake(mu=0.5, force_max=1.0, engagement=_step(0.1, high=2.0)))
        rig.chain(rig.add(f"mass{i}", _mass(v0=1.0)), element)
    rig.connect(rig.add("fixed", gb.Fixed()).flange, rig["brake2"].housing)
    v, slow = np.clip(1.1 - t, 0, 1), np.clip(t - 0.1, 0, 1)
    return rig, t, {"mass1.v": v, "mass2.v": v, "mass1.s": np.minimum(t, 0.1) + slow - slow**2 / 2}


def elasto_gap(rubbing: Any) -> Case:
    rig, t = gb.Drivetrain("ElastoGap"), np.linspace(0.0, 5.0, 101)
    low, high = rig.add("rod1", gb.Fixed(phi0=-2.0)), rig.add("rod2", gb.Fixed(phi0=2.0))
    beside = {1: lambda: gb.Shaft(k=10.0, c=1.5, rest=1.0), 2: lambda: gb.Lash(k=10.0, c=1.5, lower=1.5)}
    for i, element in beside.items():
        left, right = rig.add(f"left{i}", element()), rig.add(f"right{i}", element())
        rig.chain(low, left, rig.add(f"mass{i}", _mass(2.0)), right, high)
    damped = np.array([expm(np.array([[0.0, 1.0], [-20.0, -3.0]]) * x) @ [2.0, 0.0] for x in t])

    def push(beyond: float, rate: float) -> float:
        return 10 * beyond + float(np.clip(1.5 * rate, -10 * beyond, 10 * beyond)) if beyond > 0 else 0.0

    def f(_t: float, y: Any) -> Any:
        return np.array([push(-0.5 - y[0], -y[1]) - push(y[0] - 0.5, y[1])])

    def corners(_t: float, y: Any) -> list[float]:
        g = 10 * (abs(y[0]) - 0.5)
        return [g, g - 1.5 * y[1] if g > 0 else 1.0, g + 1.5 * y[1] if g > 0 else 1.0]

    free = rubbing[2]([1.0], f, corners=corners).run([2.0, 0.0], t)
    return rig, t, {"mass1.s": damped[:, 0], "mass1.v": damped[:, 1], "mass2.s": free[:, 0], "mass2.v": free[:, 1]}


def _grounded(name: str, f: Any, of: Any, ends: list[float], *, loaded: bool) -> Case:
    """A lever of 1.6 : 1 with an elastic pivot u: u' = (v1 - i v2)/(1 - i), force on mass 1 that of the pivot over i - 1."""
    rig, i = gb.Drivetrain(name), 1.6
    load = rig.add("mass2", gb.Mass(m=7.0, s0=0.0, v0=0.0))
    lever, pivot = (
        rig.add("lever", gb.IdealGear(ratio=i)),
        rig.add("pivot", gb.Shaft(k=800.0, c=50.0, phi_rel0=0.0, w_rel0=0.0)),
    )
    rig.chain(rig.add("force", gb.Force(f=f)), rig.add("mass1", gb.Mass(m=0.1)), lever, load)
    rig.chain(rig.add("fixed", gb.Fixed()), pivot)
    rig.connect(pivot.b, lever.housing)
    if loaded:
        rig.chain(load, rig.add("springDamper", gb.Shaft(k=160.0, c=10.0, rest=0.1)), rig.add("fixed1", gb.Fixed()))

    def rates(t: float, y: Any) -> list[float]:
        u, s2, v1, v2 = y
        rate = (v1 - i * v2) / (1 - i)
        on_one = (800 * u + 50 * rate) / (i - 1)
        on_two = -i * on_one - (160 * (s2 + 0.1) + 10 * v2 if loaded else 0.0)
        return [rate, v2, (of(t) + on_one) / 0.1, on_two / 7.0]

    t = np.linspace(0.0, ends[-1], 101)
    rows = _pieces(rates, ends, np.zeros(4), t)
    return rig, t, {"mass2.s": rows[:, 1], "mass1.v": rows[:, 2], "mass2.v": rows[:, 3]}


def gear_grounded() -> Case:
    ramp = gb.Table([0.3, 0.9], [10.0, 20.0])
    return _grounded(
        "GearGrounded", ramp, lambda t: np.interp(t, [0.3, 0.9], [10.0, 20.0]), [0.0, 0.3, 0.9, 3.0], loaded=True
    )


def lever_grounded() -> Case:
    wave = 10 * gb.sin(10 * pi * time)
    return _grounded("LeverGrounded", wave, lambda t: 10 * np.sin(10 * pi * t), [0.0, 1.0], loaded=False)


def _eddy_current(name: str, body: gb.Block, of: tuple[str, str]) -> Case:
    rig, alpha = gb.Drivetrain("EddyCurrentBrake"), 3.92e-3
    ramp, port = gb.Table([0.1, 0.2], [0.0, 1.0]), gb.HeatPort(T="heatCapacitor")
    element = gb.EddyCurrentBrake(tau_nominal=100.0, w_nominal=10.0, alpha=alpha, excitation=ramp, heat=port)
    rig.chain(rig.add(name, body), rig.add("eddyCurrent", element))
    rig.add("heatCapacitor", gb.ThermalMass(C=1.0, T0=293.15))

    def rates(t: float, y: Any) -> list[float]:
        x = y[0] / (10 * (1 + alpha * (y[2] - 293.15)))
        force = 200 * np.clip((t - 0.1) / 0.1, 0, 1) * x / (1 + x * x)
        return [-force, y[0], force * y[0]]

    rows = _pieces(rates, [0.0, 0.1, 0.2, 1.0], [20.0, 0.0, 293.15], ONE)
    wanted = {f"{name}.{q}": rows[:, j] for j, q in enumerate(of)}
    return rig, ONE, wanted | {"heatCapacitor.T": rows[:, 2]}


def eddy_current_torque() -> Case:
    return _eddy_current("inertia", gb.Inertia(J=1.0, phi0=0.0, w0=20.0), ("w", "phi"))


def eddy_current_force() -> Case:
    return _eddy_current("mass", _mass(v0=20.0), ("v", "s"))


def _compared(body: Any, source: Any, q: str) -> Case:
    """Sign, linear, quadratic and inverse brakes; the first and the last are regularised below 1."""
    rig, t = gb.Drivetrain("CompareBraking"), np.linspace(0.0, 5.0, 251)
    w1, w4 = gb.sense(f"body1.{q}"), gb.sense(f"body4.{q}")
    brakes = (
        source(-100 * gb.piecewise((w1, abs(w1) < 1), (w1 / abs(w1), True))), gb.SpeedLoad(coeffs=(0, 1.0, 0)),
        gb.SpeedLoad(coeffs=(0, 0, 0.01)), source(gb.piecewise((-100 * w4, abs(w4) < 1), (-1e4 / w4, True))),
    )  # fmt: skip
    for i, element in enumerate(brakes, 1):
        rig.chain(rig.add(f"brake{i}", element), rig.add(f"body{i}", body()))
    end = (1e4 - 1) / 2e4
    first = np.where(t <= 0.99, 100 - 100 * t, np.exp(-100 * (t - 0.99)))
    last = np.where(t < end, np.sqrt(np.maximum(1e4 - 2e4 * t, 0)), np.exp(-100 * (t - end)))
    wanted = (first, 100 * np.exp(-t), 100 / (1 + t), last)
    return rig, t, {f"body{i}.{q}": x for i, x in enumerate(wanted, 1)}


def compare_braking_torque() -> Case:
    return _compared(lambda: gb.Inertia(J=1.0, phi0=0.0, w0=100.0), lambda tau: gb.Torque(tau=tau), "w")


def compare_braking_force() -> Case:
    return _compared(lambda: _mass(v0=100.0), lambda f: gb.Force(f=f), "v")


def lossy_gear_and_bearing(rubbing: Any) -> Case:
    """LossyGearDemo2: gear and bearing stick together, with no one answer for their torques."""
    Friction, dry, Bodies = rubbing
    rig, t = gb.Drivetrain("LossyGearDemo2"), np.linspace(0.0, 0.5, 101)
    one, two = rig.add("Inertia1", gb.Inertia(J=1.0)), rig.add("Inertia2", gb.Inertia(J=1.5, phi0=0.0, w0=0.0))
    gear, load = (
        rig.add("gear", gb.LossyGear(ratio=2, loss_table=((0, 0.5, 0.5, 0, 0),))),
        gb.Torque(tau=-10 + 2.5 * time),
    )
    rig.chain(rig.add("torque1", gb.Torque(tau=10 * gb.sin(2 * pi * time))), one, gear, two, rig.add("torque2", load))
    table = gb.Table([0, 1], [0.5, 1.0], extrapolate="linear")
    rig.chain(one, rig.add("bearingFriction", gb.BearingFriction(torque=table)))

    def tie(_t: float, _y: Any, _s: float, d: int, _stuck: bool) -> Any:
        return [(d * 1e300, {}, 1.0, {})]

    def loss(_t: float, _y: Any, _s: float, d: int, _stuck: bool) -> Any:
        return [(0.0, {0: 1.0}, 0.0, {0: float(d)}), (0.0, {0: -0.5}, 0.0, {0: -float(d)})]

    frictions = [
        Friction([1, -2], tie),
        Friction([1, 0], loss),
        Friction([1, 0], dry(lambda _t, _y, s: 0.5 + 0.5 * s).law),
    ]
    rows = Bodies([1.0, 1.5], lambda x, _y: np.array([10 * np.sin(2 * pi * x), -10 + 2.5 * x]), frictions).run(
        np.zeros(4), t
    )
    return rig, t, {"Inertia2.phi": rows[:, 1], "Inertia2.w": rows[:, 3]}


def one_way_clutch_disengaged(rubbing: Any) -> Case:
    Friction, _, Bodies = rubbing
    rig, t = gb.Drivetrain("OneWayClutchDisengaged"), np.linspace(0.0, 2.0, 101)
    one, two = (
        rig.add("inertiaIn", gb.Inertia(J=1.0, phi0=0.0, w0=-0.5)),
        rig.add("inertiaOut", gb.Inertia(J=1.0, w0=0.0)),
    )
    clutch = rig.add("oneWayClutch", gb.OneWayClutch(mu=0.5, force_max=3.0, peak=25.0, engagement=0.0))
    drive = rig.add("torque", gb.Torque(tau=0.3 + 10 * gb.sin(4 * pi * time)))
    rig.chain(drive, one, clutch, two, rig.add("torqueLoad", gb.Torque(tau=-0.3)))

    def law(_t: float, _y: Any, _s: float, d: int, stuck: bool) -> Any:
        return [((-1.5e-4 if d < 0 else 1e300) if stuck else 0.0, {}, 1.0, {})]

    bodies = Bodies(
        [1.0, 1.0], lambda x, _y: np.array([0.3 + 10 * np.sin(4 * pi * x), -0.3]), [Friction([1, -1], law, (-1,))]
    )
    rows = bodies.run([0.0, 0.0, -0.5, 0.0], t)
    return rig, t, {"inertiaIn.phi": rows[:, 0], "inertiaIn.w": rows[:, 2], "inertiaOut.w": rows[:, 3]}


EXAMPLES = [
    sign_convention, initial_conditions, why_arrows, accelerate, damper, sensors, brake, elasto_gap, gear_grounded,
    lever_grounded, eddy_current_torque, eddy_current_force, compare_braking_torque, compare_braking_force,
    lossy_gear_and_bearing, one_way_clutch_disengaged,
]  # fmt: skip
RUBBING = {elasto_gap, lossy_gear_and_bearing, one_way_clutch_disengaged}


@pytest.mark.parametrize("method", ["auto", "rodas"])
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda x: x.__name__)
@pytest.mark.few(4)
def test_an_example_is_its_closed_form(example: Any, method: str, rubbing: Any) -> None:
    rig, t, wanted = example(rubbing) if example in RUBBING else example()
    run = gb.simulate(rig, t=t, rtol=1e-9, method=method)
    for name, x in wanted.items():
        assert np.abs(run[name] - x).max() < 1e-7 * np.abs(x).max(), name
    assert run.energy.residual < 1e-8
