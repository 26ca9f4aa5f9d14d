"""Shafts without inertia between springs, dampers and gears."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb


def _split(parts: int, c: float | None, empty: bool) -> gb.Drivetrain:
    """Two discs and a shaft, in parts with nothing (or an Inertia of zero) between."""
    rig = gb.Drivetrain("two discs")
    a, b = rig.add("a", gb.Inertia(J=0.1)), rig.add("b", gb.Inertia(J=0.3, phi0=0.02))
    drive = rig.add("drive", gb.Torque(tau=2.0 + 3 * sp.sin(30 * gb.time)))
    rig.connect(drive.flange, a.a)
    node = a.b
    for i in range(parts):
        shaft = rig.add(f"shaft{i}", gb.Shaft(k=1000.0 * parts, c=None if c is None else c * parts))
        rig.connect(node, shaft.a)
        node = shaft.b
        if empty and i < parts - 1:
            disc = rig.add(f"disc{i}", gb.Inertia(J=0.0))
            rig.connect(node, disc.a)
            node = disc.b
    rig.connect(node, b.a)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("c", [pytest.param(None, marks=pytest.mark.long), 0.5])
@pytest.mark.parametrize("empty", [pytest.param(False, marks=pytest.mark.long), True])
def test_a_shaft_split_into_parts_without_inertia_between_moves_as_the_whole(c: float | None, empty: bool) -> None:
    t = np.linspace(0, 1, 101)
    whole = gb.simulate(_split(1, c, False), t=t, rtol=1e-11)
    for parts in (2, 3):
        run = gb.simulate(_split(parts, c, empty), t=t, rtol=1e-11)
        for name in ("a.w", "b.w", "a.phi", "b.phi"):
            assert np.abs(run[name] - whole[name]).max() < 1e-9 * np.abs(whole[name]).max(), name
        assert np.abs(run["shaft0.twist"] - whole["shaft0.twist"] / parts).max() < 1e-11
        assert np.abs(run["shaft0.torque"] - run["shaft1.torque"]).max() < 1e-8  # of 60 N m
        assert abs(run.energy.residual) < 1e-9


def test_a_damper_at_a_shaft_without_inertia_makes_a_state_of_first_order() -> None:
    """Spring and damper in a row from the wall: the node creeps back with the time constant c/k."""
    rig = gb.Drivetrain("maxwell")
    node = rig.add("node", gb.Inertia(J=0.0, phi0=0.1))
    spring, damper = rig.add("spring", gb.Shaft(k=50.0)), rig.add("damper", gb.Damper(c=10.0))
    wall, floor = rig.add("wall", gb.Fixed()), rig.add("floor", gb.Fixed())
    rig.connect(wall.flange, spring.a)
    rig.connect(spring.b, node.a)
    rig.connect(node.b, damper.a)
    rig.connect(damper.b, floor.flange)
    run = gb.simulate(rig, t=np.linspace(0, 1, 11), rtol=1e-10)
    assert np.abs(run["node.phi"] - 0.1 * np.exp(-5.0 * run.t)).max() < 1e-10
    assert abs(run.energy.residual) < 1e-9
    assert np.isnan(run["node.alpha"]).all()  # a shaft without inertia has no equation for it


@pytest.mark.parametrize("method", ["dp8", "rodas"])
@pytest.mark.parametrize("geared", [False, True])
@pytest.mark.few(1)
def test_shafts_without_inertia_that_are_damped_against_each_other_hang_on_a_spring(method: str, geared: bool) -> None:
    """The torque reaches the disc at once; the damped shaft between follows c x' + k x = tau from k x = tau(0)."""
    rig = gb.Drivetrain("hanging")
    disc, spring = rig.add("disc", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(k=100.0))
    damped, drive = (
        rig.add("damped", gb.Shaft(k=200.0, c=10.0)),
        rig.add("drive", gb.Torque(tau=1 + sp.sin(3 * gb.time))),
    )
    ratio = 2.0 if geared else 1.0
    rig.connect(disc.a, spring.a)
    if geared:  # the torque on the disc's side is twice as large
        gear = rig.add("gear", gb.IdealGear(ratio=2.0))
        rig.connect(spring.b, gear.b)
        rig.connect(gear.a, damped.a)
    else:
        rig.connect(spring.b, damped.a)
    rig.connect(damped.b, drive.flange)
    t = np.linspace(0, 2, 41)
    run = gb.simulate(rig, t=t, rtol=1e-10, method=method)
    tau, k, c = 1 + np.sin(3 * t), 200.0, 10.0
    a, b = k / (k**2 + 9 * c**2), -3 * c / (k**2 + 9 * c**2)
    twist = 1 / k + a * np.sin(3 * t) + b * np.cos(3 * t) - b * np.exp(-k / c * t)
    assert run["damped.twist"] == pytest.approx(twist, abs=1e-9)  # of 0.01 rad, the tolerance over its steps
    assert run["spring.twist"] == pytest.approx(ratio * tau / 100, abs=1e-11)  # at once, to rounding
    assert run["disc.w"] == pytest.approx(ratio * (t + (1 - np.cos(3 * t)) / 3), abs=1e-8)
    assert abs(run.energy.residual) < 1e-9


@pytest.mark.long
def test_an_inertia_of_zero_is_part_of_the_structure() -> None:
    model = gb.build(_split(2, 0.5, empty=True))
    with pytest.raises(gb.ParameterError, match=r"disc0\.J"):
        gb.simulate(model, t_end=0.1, parameters={"disc0.J": 1.0})
    heavy = gb.simulate(_split(2, 0.5, empty=True).set({"disc0.J": 1.0}), t_end=0.1)
    assert heavy["disc0.alpha"][0] == heavy["disc0.alpha"][0]
