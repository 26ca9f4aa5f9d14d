"""HeatLosses of Modelica, rotational and translational, as a user builds them, against equations by hand (scipy, 1e-12)."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import gearblocks as gb

pi = np.pi
METHODS = [pytest.param("auto", 1e-10), pytest.param("rodas", 1e-9), pytest.param("dp5", 1e-10)]


def _heated(rig: gb.Drivetrain) -> gb.Drivetrain:
    """With a mass at the convection, which Modelica has not: its temperature tells the heat."""
    rig.add("node", gb.ThermalMass(C=1.0, T0=298.15))
    rig.add("convection", gb.ThermalConductance(G=20.0, a="node", b=298.15))
    return rig


def _rotational() -> gb.Drivetrain:
    rig, e = gb.Drivetrain("HeatLosses"), gb.sin(2 * pi * 0.2 * gb.time)
    one, two, three, four, five, six = (rig.add(f"inertia{i}", gb.Inertia(J=2.0)) for i in range(1, 7))
    hot = {"heat": gb.HeatPort(T="node")}
    losses = ((0, 0.8, 0.8, 1, 1), (1, 0.7, 0.7, 2, 2))
    rig.chain(
        rig.add("torque", gb.Torque(tau=20 * gb.sin(2 * pi * 5 * gb.time))), one,
        rig.add("springDamper", gb.Shaft(k=1e4, c=20.0, **hot)), two,
        rig.add("elastoBacklash", gb.Lash(k=1e5, c=100.0, half_gap=0.0005, **hot)), three,
        rig.add("spring3", gb.Shaft(k=1e4)), four,
        rig.add("lossyGear", gb.LossyGear(ratio=2, loss_table=losses, **hot)),
        rig.add("clutch", gb.Clutch(mu=0.5, force_max=10.0, engagement=e, **hot)), five,
        rig.add("oneWayClutch", gb.OneWayClutch(mu=0.5, force_max=1.0, engagement=e, **hot)), six,
        rig.add("brake", gb.Brake(mu=0.5, force_max=2.0, engagement=e, **hot)),
    )  # fmt: skip
    rig.chain(rig.add("fixed", gb.Fixed()), rig.add("damper", gb.Damper(c=10.0, **hot)), one)
    rig.connect(three.b, rig.add("bearingFriction", gb.BearingFriction(coulomb=1.0, **hot)).a)
    return _heated(rig)


def _clipped(k: float, c: float, g: float, rate: float) -> tuple[float, float]:
    """Force of a contact g beyond its gap, damping clipped to the elastic part, and the power that it loses."""
    damping = float(np.clip(c * rate, -abs(k * g), abs(k * g)))
    return k * g + damping, damping * rate


def _contact_corners(k: float, c: float, g: float, rate: float) -> list[float]:
    return [abs(k * g) - c * rate, abs(k * g) + c * rate] if g != 0 else [1.0, 1.0]


def _of_rotational(Friction: Any, dry: Any, Bodies: Any, t: Any) -> Any:
    def e(time: float) -> float:
        return max(float(np.sin(2 * pi * 0.2 * time)), 0.0)

    def lash(y: Any) -> tuple[float, float]:
        twist, rate = y[2] - y[1], y[8] - y[7]
        return (max(twist - 0.0005, 0.0) + min(twist + 0.0005, 0.0), rate)

    def f(time: float, y: Any) -> Any:
        damped = 1e4 * (y[1] - y[0]) + 20 * (y[7] - y[6])
        contact, spring = _clipped(1e5, 100.0, *lash(y))[0], 1e4 * (y[3] - y[2])
        drive = 20 * np.sin(10 * pi * time) - 10 * y[6]
        return np.array([drive + damped, contact - damped, spring - contact, -spring, 0.0, 0.0])

    def gear(_t: float, _y: Any, slip: float, d: int, _stuck: bool) -> Any:
        """tau_a less tau_b/2: (tau_b/2 + bearing)/eta where a drives, times eta where b does; tau_b: of the clutch."""
        eta, bearing = 0.8 - 0.1 * min(slip, 1.0), 1.0 + min(slip, 1.0)
        return [
            (d * bearing / eta, {1: (1 / eta - 1) / 2}, bearing, {1: d / 2}),
            (d * bearing * eta, {1: (eta - 1) / 2}, -bearing, {1: -d / 2}),
        ]

    def one_way(time: float, _y: Any, _slip: float, d: int, stuck: bool) -> Any:
        least = 0.5e-4 if stuck else 0.0
        return [(-max(0.5 * e(time), least) if d < 0 else 1e300, {}, 1.0, {})]

    frictions = [
        Friction([0, 0, 0, 1, 0, 0], gear),
        Friction([0, 0, 0, 0.5, -1, 0], dry(lambda time, _y, _s: 5 * e(time)).law),
        Friction([0, 0, 0, 0, 1, -1], one_way, (-1,)),
        Friction([0, 0, 0, 0, 0, 1], dry(lambda time, _y, _s: e(time)).law),
        Friction([0, 0, 1, 0, 0, 0], dry(lambda _t, _y, _s: 1.0).law),
    ]

    def heat(_t: float, y: Any, q: Any, slips: Any, modes: Any) -> list[float]:
        lost = 10 * y[6] ** 2 + 20 * (y[7] - y[6]) ** 2 + _clipped(1e5, 100.0, *lash(y))[1]
        lost += sum(force * slip for force, slip, (side, _) in zip(q, slips, modes, strict=True) if side in (-1, 1))
        return [lost, lost - 20 * y[13]]

    def corners(_t: float, y: Any) -> list[float]:
        twist = y[2] - y[1]
        return [twist - 0.0005, twist + 0.0005, abs(y[9]) - 1.0, *_contact_corners(1e5, 100.0, *lash(y))]

    return Bodies([2.0] * 6, f, frictions, corners, heat).run(np.zeros(14), t)


def _translational() -> gb.Drivetrain:
    """Masses of 0.1 m: the free lengths of springs grow by it, and the stops move in."""
    rig, hot = gb.Drivetrain("HeatLosses"), {"heat": gb.HeatPort(T="node")}
    m1 = rig.add("mass1", gb.Mass(m=1.0, s0=0.0, v0=0.0))
    m2, m3 = rig.add("mass2", gb.Mass(m=1.0)), rig.add("mass3", gb.Mass(m=1.0, v0=0.0))
    last = rig.add("massWithStopAndFriction", gb.Mass(m=1.0, v0=0.0))
    rig.chain(
        rig.add("force", gb.Force(f=20 * gb.sin(2 * pi * gb.time))), m1,
        rig.add("springDamper", gb.Shaft(k=100.0, c=10.0, rest=0.1, phi_rel0=0.1, w_rel0=0.0, **hot)), m2,
        rig.add("spring", gb.Shaft(k=100.0, rest=0.1, phi_rel0=0.1)), m3,
        rig.add("springDamper1", gb.Shaft(k=1e4, c=1e3, rest=0.1, phi_rel0=0.1, **hot)), last,
    )  # fmt: skip
    brake = gb.Brake(mu=0.5, force_max=10.0, engagement=10 * gb.sin(4 * pi * gb.time), **hot)
    rub = gb.BearingFriction(torque=1.0 + 0.5 * gb.slip + 2.0 * gb.exp(-2.0 * gb.slip), peak=1.001, **hot)
    rig.chain(m2, rig.add("supportFriction", gb.BearingFriction(coulomb=1.0, **hot)))
    rig.chain(m3, rig.add("brake", brake))
    rig.chain(last, rig.add("friction", rub))
    rig.chain(last, rig.add("stop", gb.HardStop(lower=0.05, upper=0.35, restitution=0.0)))
    rig.chain(m1, rig.add("damper", gb.Damper(c=10.0, **hot)), rig.add("fixed1", gb.Fixed()))
    rig.chain(rig.add("fixed2", gb.Fixed()), rig.add("elastoGap", gb.Lash(k=100.0, c=20.0, lower=0.03, **hot)), m1)
    return _heated(rig)


def _of_translational(Friction: Any, dry: Any, Bodies: Any, t: Any) -> Any:
    def gap(y: Any) -> tuple[float, float]:
        return min(y[0] - 0.03, 0.0), y[4]

    def f(time: float, y: Any) -> Any:
        soft, spring = 100 * (y[1] - y[0] - 0.1) + 10 * (y[5] - y[4]), 100 * (y[2] - y[1] - 0.1)
        hard = 1e4 * (y[3] - y[2] - 0.1) + 1e3 * (y[7] - y[6])
        first = 20 * np.sin(2 * pi * time) - 10 * y[4] + soft - _clipped(100.0, 20.0, *gap(y))[0]
        return np.array([first, spring - soft, hard - spring, -hard])

    def stop(_t: float, _y: Any, _slip: float, d: int, stuck: bool) -> Any:
        return [(1e300 if stuck and d > 0 else 0.0, {}, 1.0, {})]

    frictions = [
        Friction([0, 1, 0, 0], dry(lambda _t, _y, _s: 1.0).law),
        Friction([0, 0, 1, 0], dry(lambda time, _y, _s: 50 * max(float(np.sin(4 * pi * time)), 0.0)).law),
        Friction([0, 0, 0, 1], dry(lambda _t, _y, s: 1 + 0.5 * s + 2 * float(np.exp(-2 * s)), 1.001).law),
        Friction([0, 0, 0, 1], stop, (-1,), lambda _t, y: abs(y[3] - 0.35) < 1e-10),
    ]

    def heat(_t: float, y: Any, q: Any, slips: Any, modes: Any) -> list[float]:
        lost = 10 * y[4] ** 2 + 10 * (y[5] - y[4]) ** 2 + 1e3 * (y[7] - y[6]) ** 2 + _clipped(100.0, 20.0, *gap(y))[1]
        lost += sum(force * slip for force, slip, (side, _) in zip(q, slips, modes, strict=True) if side in (-1, 1))
        return [lost, lost - 20 * y[9]]

    def corners(_t: float, y: Any) -> list[float]:
        return [y[0] - 0.03, y[3] - 0.35, y[3] - 0.05, *_contact_corners(100.0, 20.0, *gap(y))]

    def impact(y: Any) -> None:
        if y[3] > 0.35 - 1e-12 and y[7] > 0:
            y[3], y[7] = 0.35, 0.0

    bodies = Bodies([1.0] * 4, f, frictions, corners, heat, impact)
    return bodies.run([0.0, 0.1, 0.2, 0.3, *np.zeros(6)], t, jumps=np.arange(0.25, 2.0, 0.25))


@cache
def _wanted(rubbing: Any, name: str) -> tuple[Any, Any]:
    t = np.linspace(0.0, 1.0 if name == "rotational" else 2.0, 101)
    return t, (_of_rotational if name == "rotational" else _of_translational)(*rubbing, t)


@pytest.mark.long
@pytest.mark.parametrize(("method", "rtol"), METHODS)
def test_rotational_heat_losses_are_those_of_equations_by_hand(rubbing: Any, method: str, rtol: float) -> None:
    """As in Modelica the clutch hangs at the lossy gear with nothing between; 63 changes of modes in 1 s."""
    t, wanted = _wanted(rubbing, "rotational")
    run = gb.simulate(_rotational(), t=t, rtol=rtol, method="dp8" if method == "rodas" else method)
    for i in range(6):
        for name, column in (("phi", wanted[:, i]), ("w", wanted[:, 6 + i])):
            assert np.abs(run[f"inertia{i + 1}.{name}"] - column).max() < 1e-8 * np.abs(column).max(), (i + 1, name)
    assert np.abs(run["node.rise"] - wanted[:, 13]).max() < 1e-9 * wanted[:, 13].max()
    assert sum(run.energy.heat.values()) == pytest.approx(wanted[-1, 12], rel=1e-9)
    assert run.energy.heat_residual < 1e-9 and len(run.energy.heat) == 8


@pytest.mark.parametrize(("method", "rtol"), METHODS)
@pytest.mark.few(1)
def test_translational_heat_losses_are_those_of_equations_by_hand(rubbing: Any, method: str, rtol: float) -> None:
    """The last mass strikes its stop twice, rests there under its friction and leaves it; 27 changes of modes in 2 s."""
    t, wanted = _wanted(rubbing, "translational")
    run = gb.simulate(_translational(), t=t, rtol=rtol, method=method)
    for i, name in enumerate(("mass1", "mass2", "mass3", "massWithStopAndFriction")):
        for quantity, column in (("s", wanted[:, i]), ("v", wanted[:, 4 + i])):
            assert np.abs(run[f"{name}.{quantity}"] - column).max() < 1e-8 * np.abs(column).max(), (name, quantity)
    assert np.abs(run["node.rise"] - wanted[:, 9]).max() < 1e-8 * wanted[:, 9].max()
    assert sum(run.energy.heat.values()) == pytest.approx(wanted[-1, 8], rel=1e-8)  # Modelica's stop gives no heat
