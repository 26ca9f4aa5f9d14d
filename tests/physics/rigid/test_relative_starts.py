"""Start values between bodies, phi_rel0 and w_rel0, and start accelerations, alpha0 and a0."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb


def _three(left: dict[str, Any] | None = None, shaft: dict[str, Any] | None = None, **right: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("three")
    rig.chain(
        rig.add("left", gb.Inertia(J=0.1, **(left or {}))), rig.add("shaft", gb.Shaft(k=50.0, **(shaft or {}))),
        rig.add("middle", gb.Inertia(J=0.2)), rig.add("gear", gb.IdealGear(ratio=-2)), rig.add("wheel", gb.Inertia(J=0.3)),
        rig.add("lash", gb.Lash(k=80.0, half_gap=0.01)), rig.add("right", gb.Inertia(J=0.4, **right)),
    )  # fmt: skip
    return rig


def _start(rig: gb.Drivetrain, *names: str, **how: Any) -> list[float]:
    run = gb.simulate(rig, t_end=1e-6, **how)
    return [float(run[name][0]) for name in names]


def test_a_start_twist_turns_what_nothing_holds() -> None:
    """The first body stays, what follows turns along undeformed, through the gear."""
    rig = _three(shaft={"phi_rel0": "0.2 rad", "w_rel0": -3.0})
    angles = _start(rig, "shaft.twist", "left.phi", "middle.phi", "wheel.phi", "lash.twist")
    assert angles == pytest.approx([0.2, 0.0, 0.2, -0.1, 0.0], abs=1e-15)
    speeds = _start(rig, "shaft.twist_rate", "left.w", "middle.w", "wheel.w", "right.w")
    assert speeds == pytest.approx([-3.0, 0.0, -3.0, 1.5, 1.5], abs=1e-15)


@pytest.mark.long
def test_given_start_values_stay_as_they_are() -> None:
    rig = _three({"w0": 10.0, "phi0": 0.3}, {"phi_rel0": 0.2, "w_rel0": -3.0}, w0=0.0, phi0=1.0)
    found = _start(rig, "left.phi", "middle.phi", "right.phi", "left.w", "middle.w", "wheel.w", "right.w")
    assert found == pytest.approx([0.3, 0.5, 1.0, 10.0, 7.0, -3.5, 0.0], abs=1e-14)
    behind = _start(_three(None, {"w_rel0": 4.0}, w0=2.0), "left.w", "middle.w", "right.w")
    assert behind == pytest.approx([-8.0, -4.0, 2.0], abs=1e-14)  # from the right, through the gear


@pytest.mark.long
def test_a_start_twist_keeps_its_rest_and_its_meaning_when_rolling() -> None:
    rig = _three(shaft={"phi_rel0": 0.2, "rest": 0.05}).set({"lash": gb.Lash(k=80.0, lower=0.03)})
    assert _start(rig, "shaft.twist", "lash.twist") == pytest.approx([0.2, 0.03], abs=1e-15)
    rolling = _start(rig, "shaft.twist", "lash.twist", "right.w", initial=gb.rolling({"left.w": 6.0, "left.phi": 1.0}))
    assert rolling == pytest.approx([0.2, 0.03, -3.0], abs=1e-14)
    moved = rig.set({"shaft.phi_rel0": gb.Parameter("twist", 0.1, "rad")})
    assert _start(moved, "shaft.twist", parameters={"twist": 0.4}) == pytest.approx([0.4], abs=1e-15)


def test_contradictions_are_said() -> None:
    rig = _three({"phi0": 0.1}, {"phi_rel0": 0.2}).set({"middle.phi0": 0.4})
    with pytest.raises(gb.ModelError, match=r"'shaft': phi_rel0 = 0.2 contradicts the 0.3 that .* 'left', 'middle'"):
        gb.build(rig)
    driven = gb.Drivetrain("driven")
    driven.chain(
        driven.add("drive", gb.Speed(w=3.0)),
        driven.add("shaft", gb.Shaft(k=1.0, w_rel0=1.0)),
        driven.add("disc", gb.Inertia(J=1.0)),
    )
    with pytest.raises(gb.ModelError, match="'shaft': w_rel0: one of its ends has no start value of its own"):
        gb.build(driven)
    with pytest.raises(gb.ModelError, match="a rigid shaft has no start twist"):
        gb.Drivetrain("wrong").add("shaft", gb.Shaft(rigid=True, phi_rel0=0.1))


def test_speed_and_acceleration_given_give_the_start_twist() -> None:
    """Modelica's w and a fixed: phi = a J/k, then w cos + ... in closed form."""
    J, k, a, w = 0.5, 200.0, 7.0, 3.0
    rig = gb.Drivetrain("pendulum")
    rig.chain(
        rig.add("ground", gb.Fixed()), rig.add("wire", gb.Shaft(k=k)), rig.add("disc", gb.Inertia(J=J, w0=w, alpha0=a))
    )
    t = np.linspace(0, 1, 11)
    run = gb.simulate(rig, t=t, rtol=1e-12, method="dp8")
    om = np.sqrt(k / J)
    assert run["disc.phi"] == pytest.approx(-a * J / k * np.cos(om * t) + w / om * np.sin(om * t), abs=1e-10)
    assert run["disc.alpha"][0] == pytest.approx(a, rel=1e-9)


def test_a_damper_gives_the_start_speed_and_a_slider_its_place() -> None:
    rig = gb.Drivetrain("sledge")
    mass = rig.add("mass", gb.Mass(m=2.0, a0=-6.0, s0=0.5))
    rig.chain(rig.add("ground", gb.Fixed()), rig.add("damper", gb.Damper(c=3.0)), mass)
    assert _start(rig, "mass.v", "mass.s", "mass.acceleration") == pytest.approx([4.0, 0.5, -6.0], rel=1e-9)
    hard = gb.Drivetrain("cubic")
    law = 10.0 * gb.twist + 400.0 * gb.twist**3
    mass = hard.add("mass", gb.Mass(m=2.0, a0=-8.0))
    hard.chain(hard.add("ground", gb.Fixed()), hard.add("spring", gb.Shaft(torque=law)), mass)
    s = _start(hard, "mass.s")[0]
    assert 10 * s + 400 * s**3 == pytest.approx(16.0, rel=1e-8)


@pytest.mark.long
def test_two_accelerations_in_a_train_are_both_met() -> None:
    rig = _three({"alpha0": 5.0, "w0": 1.0}, {"c": 0.1}).set(
        {"lash": gb.Shaft(k=80.0), "right.alpha0": -2.0, "middle.phi0": 0.0}
    )
    found = _start(rig, "left.alpha", "right.alpha", "middle.phi")
    assert found == pytest.approx([5.0, -2.0, 0.0], rel=1e-8, abs=1e-12)


@pytest.mark.long
def test_what_nothing_open_gives_is_said() -> None:
    free = gb.Drivetrain("free")
    free.chain(free.add("push", gb.Torque(tau=1.0)), free.add("disc", gb.Inertia(J=0.5, alpha0=3.0)))
    with pytest.raises(
        gb.ModelError, match="'disc': alpha0 = 3, but its acceleration at the start is 2, and no start angle"
    ):
        gb.build(free)
    assert _start(free.set({"disc.alpha0": 2.0}), "disc.alpha") == [2.0]
    driven = gb.Drivetrain("driven")
    driven.chain(driven.add("drive", gb.Speed(w=3.0)), driven.add("disc", gb.Inertia(J=1.0, alpha0=1.0)))
    with pytest.raises(gb.ModelError, match="'disc': alpha0 is given, but something moves this shaft"):
        gb.build(driven)
    with pytest.raises(gb.ParameterError, match="left gives a start acceleration, which a train that rolls"):
        gb.simulate(_three({"alpha0": 5.0}), t_end=1.0, initial="rolling")


def test_a_start_acceleration_moves_its_body_alone() -> None:
    """Its neighbours stay at 0, the springs beside it are twisted: phi = -J alpha/(k1 + k2)."""
    rig = _three().set({"lash": gb.Shaft(k=80.0), "wheel.alpha0": 6.0})
    rig.connect(rig.add("wire", gb.Shaft(k=200.0)).a, rig["right"].b)
    rig.connect(rig["wire"].b, rig.add("ground", gb.Fixed()).flange)
    found = _start(rig, "left.phi", "wheel.phi", "right.phi", "wheel.alpha")
    J, k = 0.3 + 4 * 0.2, 80.0 + 4 * 50.0  # on the shaft of the wheel
    assert found == pytest.approx([0.0, -J * 6.0 / k, 0.0, 6.0], rel=1e-8, abs=1e-12)
