"""Derivatives of states of blocks and of sensed outputs in the matrix of implicit methods."""

from __future__ import annotations

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.train.handles import FlangeHandle

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


@pytest.mark.long
def test_states_of_blocks_couple_with_their_shafts(check):
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


@pytest.mark.long
@pytest.mark.few(1)
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.long) if name in ("speed", "angle", "force") else name for name in FEEDBACKS],
)
def test_what_is_sensed_adds_its_derivative(check, name):
    rig = between(gb.Lash(k=20.0, half_gap=0.1, c=0.3), gb.Shaft(k=30.0, c=0.1), ends=(gb.Torque(tau=FEEDBACKS[name]),))
    start = FlangeHandle(rig, "disc0", "a")
    motor, relay = rig.add("motor", Motor(u=2.0)), rig.add("relay", gb.Torque(tau=0.4 * gb.sense("link1.torque")))
    rig.connect(start, motor.shaft)
    rig.connect(start, relay.flange)
    check(rig)


def test_a_motor_that_is_fed_by_a_speed_control(check):
    u = 3 * (gb.Parameter("target", 2.0, "rad/s") - gb.sense("disc2.w")) + gb.sense("disc1.phi") ** 2
    rig = between(gb.Shaft(k=20.0), gb.Shaft(k=30.0, c=0.1))
    motor = rig.add("motor", Motor(u=u))
    rig.connect(motor.shaft, FlangeHandle(rig, "disc0", "a"))
    check(rig)


@pytest.mark.long
def test_a_sensed_output_with_a_limit_of_its_own_has_the_slope_of_its_side(check):
    tau = -2 * gb.sense("motor.limited") * gb.sense("disc1.w")
    rig = between(gb.Shaft(k=20.0), ends=(gb.Torque(tau=tau),))
    motor = rig.add("motor", Motor(u=1.0))
    rig.connect(motor.shaft, FlangeHandle(rig, "disc0", "a"))
    check(rig)
