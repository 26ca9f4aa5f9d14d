"""Sources and loads."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.contributions import Acts, Contribution, Energy, Motion, Rate, Shows, Start, Stick, Tie
from gearblocks.language.fields import Flange, State, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Signal, Value


class Torque(Block):
    """A given torque on the flange, its reaction on the housing (the ground when not connected).

        housing #---(->)---o flange        positive tau drives forward

    Example:
        rig = gb.Drivetrain("shaker")
        rig.chain(rig.add("drive", gb.Torque(tau=5.0 + gb.sin(300 * gb.time))), rig.add("disc", gb.Inertia(J=0.01)))
    """

    flange = Flange("driven flange")
    housing = Flange("housing", ground=True)
    tau: Signal = signal("torque on the flange", "N m")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Action and reaction."""
        yield Acts(s.flange, s.tau)
        yield Acts(s.housing, -s.tau)
        yield Shows("torque", s.tau, "N m", "torque on the flange")


class Speed(Block):
    """Prescribed speed of the flange over the housing; output torque: the reaction that keeps it, on the flange.

    On a slider w is a speed in m/s and torque a force in N.

    w must be continuous (a ramp may have corners, which are located). An Input takes filter=: the speed then follows it
    as x' = filter (w - x), from w at the start; so does a law that jumps.

    Example:
        rig = gb.Drivetrain("ramp")
        ramp = gb.Table([0.0, 1.0], [0.0, 100.0])
        rig.chain(rig.add("drive", gb.Speed(w=ramp)), rig.add("disc", gb.Inertia(J=0.01)))
    """

    flange = Flange("driven flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    w: Signal = signal("prescribed speed", "rad/s")
    filter: Value | None = param("cut-off frequency of the filter", "rad/s", default=None, gt=0)
    filtered_speed = State("speed behind the filter", "rad/s")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """w_flange - w_housing = w, through the filter where there is one."""
        wanted = s.w
        if self.filter is not None:
            wanted = s.filtered_speed
            yield Start(wanted, s.w)
            yield Rate(wanted, s.filter * (s.w - wanted))
        yield Motion(s.flange.w - s.housing.w - wanted)
        yield Shows("torque", s.flange.tau, "N m", "reaction on the flange")


class Angle(Block):
    """Prescribed angle of the flange over the housing; output torque: the reaction that keeps it, on the flange.

    On a slider phi is a position in m and torque a force in N.

    phi must be smooth twice over. An Input takes filter=: the angle then follows it through a critically damped filter
    of second order, x'' = filter^2 (phi - x) - 2 filter x', from phi and rest at the start.

    Example:
        rig = gb.Drivetrain("positioning")
        drive = rig.add("drive", gb.Angle(phi=0.1 * gb.sin(20 * gb.time)))
        rig.chain(drive, rig.add("shaft", gb.Shaft(k=100.0, c=0.1)), rig.add("disc", gb.Inertia(J=0.01)))
    """

    flange = Flange("driven flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    phi: Signal = signal("prescribed angle", "rad")
    filter: Value | None = param("cut-off frequency of the filter", "rad/s", default=None, gt=0)
    filtered_angle = State("angle behind the filter", "rad")
    filtered_speed = State("its rate", "rad/s")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """phi_flange - phi_housing = phi, through the filter where there is one."""
        wanted = s.phi
        if self.filter is not None:
            wanted, speed = s.filtered_angle, s.filtered_speed
            yield Start(wanted, s.phi)
            yield Rate(wanted, speed)
            yield Rate(speed, s.filter**2 * (s.phi - wanted) - 2 * s.filter * speed)
        yield Tie(s.flange.phi - s.housing.phi - wanted)
        yield Shows("torque", s.flange.tau, "N m", "reaction on the flange")


class SpeedLoad(Block):
    """A load that opposes motion: tau = -sign(w) (c0 + c1 abs(w) + c2 w^2), coeffs = (c0, c1, c2).

    On a slider w is its speed in m/s and tau a force in N. The constant part is dry friction: at w = 0 it holds the shaft
    against up to c0.

    Example:
        rig = gb.Drivetrain("pump")
        drive, pump = rig.add("drive", gb.Torque(tau=5.0)), rig.add("pump", gb.SpeedLoad(coeffs=(0.5, 0.01, 1e-4)))
        rig.chain(drive, rig.add("rotor", gb.Inertia(J=0.01)), pump)
    """

    flange = Flange("loaded flange", slider=None)
    coeffs: tuple[Value, Value, Value] = param(
        "coefficients c0, c1, c2",
        "N m (rad/s)^-i",
        ge=0,
        many=True,
        each=("dry friction", "torque per speed", "torque per speed squared"),
    )
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """A wrong number of coefficients."""
        if not isinstance(self.coeffs, tuple) or len(self.coeffs) != 3:
            yield f"coeffs = {self.coeffs!r} must be three numbers (c0, c1, c2)"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The opposing torque; all its power is lost."""
        import sympy as sp

        w = s.flange.w
        c0, c1, c2 = s.coeffs
        size = sp.Piecewise(
            (w, w >= 0), (-w, True)
        )  # abs(w) of the drag, with or without a dry part that has a direction
        drag = c1 * w + c2 * w * size
        yield Stick("", w, c0, engaged=c0)
        yield Acts(s.flange, -drag)
        yield Energy(loss=drag * w)
        direction, _, held = s.stick("")
        yield Shows("torque", held - direction * c0 - drag, "N m", "torque on the flange")
        yield Shows("loss_power", (direction * c0 + drag) * w, "W", "power taken")
