"""Bodies and the ground."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.contributions import Body, Contribution, Shows, Tie
from gearblocks.language.fields import Flange, option, param
from gearblocks.language.signals import Value


class Inertia(Block):
    """A rigid rotating body; both flanges turn by the same angle.

        a o---[ J ]---o b        phi = phi_a = phi_b

    phi0, w0: start values. Left out, they follow from tied neighbours, else they are 0. alpha0: start acceleration; what is
    not given of angles, of its own first, then of speeds is chosen so that it has it under the values that the train is built
    with: the twist of the springs beside. small=True makes the effect
    `inertia` of it: without that the part turns with its neighbour (the stiffest compliant element at its shaft becomes
    rigid), and J is lumped there, times the ratio squared.

    Example:
        rig = gb.Drivetrain("flywheel")
        rig.chain(rig.add("drive", gb.Torque(tau=2.0)), rig.add("flywheel", gb.Inertia(J=0.5, w0="3000 rpm")))
        print(gb.simulate(rig, t_end=1.0)["flywheel.w"][-1])
    """

    a, b = Flange("left end", spare=True), Flange("right end", spare=True)
    J: Value = param("moment of inertia", "kg m2", ge=0)
    phi0: Value | None = param("start angle", "rad", default=None, start="angle")
    w0: Value | None = param("start speed", "rad/s", default=None, start="speed")
    alpha0: Value | None = param("start acceleration", "rad/s2", default=None, start="acceleration")
    small: bool = option("whether it may be lumped into its neighbour", default=False, belongs_to="inertia")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """J phi'' = sum of the torques on both flanges."""
        yield Body(s.a, s.J)
        yield Tie(s.a.phi - s.b.phi)
        yield Shows("phi", s.a.phi, "rad", "angle")
        yield Shows("w", s.a.w, "rad/s", "speed")
        yield Shows("alpha", s.a.alpha, "rad/s2", "acceleration")
        yield Shows("kinetic_energy", s.J * s.a.w**2 / 2, "J", "kinetic energy")


class Fixed(Block):
    """The ground: holds its flange at the angle phi0. Output torque: what the ground exerts on the flange.

        flange o---#        phi = phi0

    On a slider phi0 is a position in m, and torque a force in N.

    Example:
        rig = gb.Drivetrain("torsion pendulum")
        disc = rig.add("disc", gb.Inertia(J=0.01, phi0="10 deg"))
        rig.chain(rig.add("ground", gb.Fixed()), rig.add("wire", gb.Shaft(k=0.5)), disc)
    """

    flange = Flange("held flange", slider=None)
    phi0: Value = param("angle at which the flange is held", "rad", default=0.0, start="angle")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """phi = phi0."""
        yield Tie(s.flange.phi - s.phi0)
        yield Shows("torque", s.flange.tau, "N m", "reaction on the flange")
