"""rodas keeps its order where what heats a thermal mass is lost in proportion to the force inside a lossy gear, which the
motion determines; where the temperature acts back on that; and where gears share a load or ratios change with the angle.

Independent: dp8, whose steps know no derivative; and the closed form of a gear that a constant torque drives.
"""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

T = np.linspace(0.0, 1.0, 6)
TABLE = ((0.0, 0.9, 0.8, 0.1, 0.1), (60.0, 0.6, 0.5, 0.5, 0.5))


def hot_gear(kind: str) -> gb.Drivetrain:
    """A motor, a lossy gear that heats its oil, a shaft, a load."""
    rig = gb.Drivetrain(f"hot gear {kind}")
    rig.add("oil", gb.ThermalMass(C=2.0, T0=300.0))
    rig.add("wall", gb.ThermalConductance(G=0.5, a="oil", b=290.0))
    port = gb.HeatPort(T="oil")
    motor, load = rig.add("motor", gb.Inertia(J=0.5)), rig.add("load", gb.Inertia(J=0.7))
    loss = {"loss_table": TABLE} if kind == "table" else {"efficiency": (0.9, 0.8)}
    gear = rig.add("gear", gb.LossyGear(ratio=2.0, heat=port, **loss))
    torque = 12.0 + 5.0 * gb.sin(3 * gb.time)
    if kind == "acts back":
        torque = torque - 0.05 * (gb.sense("oil.T") - 300.0) - 0.3 * gb.sense("motor.w")
    drive, drag = rig.add("drive", gb.Torque(tau=torque)), rig.add("drag", gb.SpeedLoad(coeffs=(0.0, 0.3, 0.01)))
    shaft = rig.add("shaft", gb.Shaft(k=90.0, c=0.5))
    rig.connect(drive.flange, motor.a)
    rig.connect(motor.b, gear.a)
    rig.connect(gear.b, shaft.a)
    rig.connect(shaft.b, load.a)
    rig.connect(load.b, drag.flange)
    if kind == "shared":
        second = rig.add("second", gb.LossyGear(ratio=2.0, efficiency=(0.95, 0.85), heat=port))
        rig.connect(second.a, motor.a)
        rig.connect(second.b, gear.b)
    elif kind == "varying ratio":
        pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.25, order=1), external=True))
        rig.chain(gear, pair, rig.add("beside", gb.Inertia(J=0.2)))
    return rig


@pytest.mark.parametrize("kind", ["efficiency", "table", "acts back", "shared", "varying ratio"])
def test_half_the_step_divides_the_error_of_the_temperature_by_what_its_order_says(kind: str) -> None:
    rig, initial = hot_gear(kind), gb.rolling({"motor.w": 30.0})
    true = gb.simulate(rig, t=T, method="dp8", rtol=1e-12, initial=initial)
    assert not [e for e in true.events if e.component == "gear" and e.t > 1e-9]  # one mode throughout
    rise = np.max(np.abs(true["oil.T"] - 300.0))
    errors = [
        np.max(np.abs(gb.simulate(rig, t=T, method="rodas", step=step, initial=initial)["oil.T"] - true["oil.T"]))
        / rise
        for step in (0.01, 0.005)
    ]
    assert errors[0] < 1e-5 and errors[1] < max(errors[0] / 14.0, 1e-11), errors


@pytest.mark.parametrize("efficiency", [(0.9, 0.8), (0.5, 0.7)])
def test_a_gear_that_a_constant_torque_drives_heats_its_oil_by_the_work_it_loses(
    efficiency: tuple[float, float],
) -> None:
    rig = gb.Drivetrain("gear")
    motor, load = rig.add("motor", gb.Inertia(J=0.5)), rig.add("load", gb.Inertia(J=2.0))
    rig.add("oil", gb.ThermalMass(C=3.0, T0=300.0))
    gear = rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=efficiency, heat=gb.HeatPort(T="oil")))
    rig.chain(rig.add("drive", gb.Torque(tau=10.0)), motor, gear, load)
    run = gb.simulate(rig, t_end=2.0, method="rodas", rtol=1e-10)
    eta = efficiency[0]
    inside = 10.0 / (
        1.0 + 0.5 * 2.0**2 * eta / 2.0
    )  # tau_a with load.alpha = 2 eta tau_a / 2, motor.alpha = 2 load.alpha
    alpha = (10.0 - inside) / 0.5
    lost = (1.0 - eta) * inside * 0.5 * alpha * run.t**2
    np.testing.assert_allclose(run["oil.T"] - 300.0, lost / 3.0, rtol=1e-9, atol=1e-9)


def test_a_gearbox_with_gaps_heats_by_any_method_alike() -> None:
    rig = gb.Drivetrain("gearbox")
    motor, load = rig.add("motor", gb.Inertia(J=0.5, w0=10.0)), rig.add("load", gb.Inertia(J=2.0))
    rig.add("oil", gb.ThermalMass(C=4.0, T0=300.0))
    box = rig.add(
        "box", gb.Gearbox(ratio=2.0, loss_table=TABLE, half_gap=0.01, k=1000.0, c=4.0, heat=gb.HeatPort(T="oil"))
    )
    drive = rig.add("drive", gb.Torque(tau=5.0 + 20.0 * gb.sin(3 * gb.time)))
    rig.connect(drive.flange, motor.a)
    rig.connect(motor.b, box.a)
    rig.connect(box.b, load.a)
    true = gb.simulate(rig, t_end=2.0, method="dp8", rtol=1e-10)
    run = gb.simulate(rig, t_end=2.0, method="rodas", rtol=1e-6)
    rise = true["oil.T"][-1] - 300.0
    assert run["oil.T"][-1] - 300.0 == pytest.approx(rise, rel=1e-5)
    assert run.energy.heat_residual < 1e-5
