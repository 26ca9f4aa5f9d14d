"""Sources and loads."""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Any

from gearblocks.blocks.given_rates import rate_problems
from gearblocks.errors import did_you_mean
from gearblocks.language.block import Block
from gearblocks.language.contributions import Acts, Contribution, Energy, Motion, Rate, Shows, Start, Stick, Tie
from gearblocks.language.fields import Flange, State, option, param, signal
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

    w must be continuous (a ramp may have corners, which are located). An Input takes filter=: the speed x then follows it from
    w at the start; so does a law that jumps. filter_type:
        "first order"   x' = filter (w - x)
        "critical", "bessel", "butterworth"   of second order, as of `Angle`

    Example:
        rig = gb.Drivetrain("ramp")
        ramp = gb.Table([0.0, 1.0], [0.0, 100.0])
        rig.chain(rig.add("drive", gb.Speed(w=ramp)), rig.add("disc", gb.Inertia(J=0.01)))
    """

    flange = Flange("driven flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    w: Signal = signal("prescribed speed", "rad/s")
    filter: Value | None = param("cut-off frequency of the filter", "rad/s", default=None, gt=0, symbol="omega_c")
    filter_type: str = option("'first order', 'critical', 'bessel' or 'butterworth'", default="first order")
    filtered_speed = State("speed behind the filter", "rad/s", symbol="omega_f")
    filtered_acceleration = State("its rate, of a filter of second order", "rad/s2", symbol="alpha_f")

    def problems(self) -> Iterator[str]:
        """A filter that there is not."""
        yield from _filter_problems(self, ("first order", *SECOND_ORDER), "first order")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """w_flange - w_housing = w, through the filter where there is one."""
        wanted = s.w
        if self.filter is not None and self.filter_type == "first order":
            wanted = s.filtered_speed
            yield Start(wanted, s.w)
            yield Rate(wanted, s.filter * (s.w - wanted))
        elif self.filter is not None:
            wanted = s.filtered_speed
            yield from second_order(self.filter_type, s.filter, s.w, wanted, s.filtered_acceleration)
        yield Motion(s.flange.w - s.housing.w - wanted)
        yield Shows("torque", s.flange.tau, "N m", "reaction on the flange")


SECOND_ORDER = {
    "critical": (2.0, 1.0),
    "bessel": (1.3616541287161308, 0.6180339887498949),
    "butterworth": (sqrt(2.0), 1.0),
}
"""a and b of x'' = (filter^2 (u - x) - a filter x')/b: of "critical" the double pole at filter (-6 dB there), of the others
filter is where the gain is -3 dB (Tietze, Schenk: Halbleiter-Schaltungstechnik, chapter on active filters)."""


def _filter_problems(block: Any, known: tuple[str, ...], usual: str) -> Iterator[str]:
    """A type of filter that there is not, or without a filter."""
    if block.filter_type not in known:
        near = did_you_mean(str(block.filter_type), known)
        yield f"filter_type = {block.filter_type!r} must be {', '.join(map(repr, known[:-1]))} or {known[-1]!r}{near}"
    elif block.filter is None and block.filter_type != usual:
        yield f"filter_type = {block.filter_type!r} needs filter, the cut-off frequency in rad/s"


def second_order(kind: str, cutoff: Any, u: Any, x: Any, rate: Any) -> Iterator[Contribution]:
    """A filter of second order of u into x, at rest at the start."""
    a, b = SECOND_ORDER[kind]
    yield Start(x, u)
    yield Rate(x, rate)
    if kind == "critical":
        yield Rate(rate, cutoff**2 * (u - x) - 2 * cutoff * rate)
    else:
        yield Rate(rate, cutoff / b * (cutoff * (u - x) - a * rate))


class Angle(Block):
    """Prescribed angle of the flange over the housing; output torque: the reaction that keeps it, on the flange.

    On a slider phi is a position in m and torque a force in N.

    phi must be smooth twice over. An Input takes filter=: the angle x then follows it from phi and rest at the
    start. filter_type:
        "critical"      x'' = filter^2 (phi - x) - 2 filter x'
        "bessel"        x'' = filter (filter (phi - x) - 1.3617 x')/0.6180     -3 dB at filter, delay without overshoot
        "butterworth"   x'' = filter^2 (phi - x) - sqrt(2) filter x'           -3 dB at filter, flattest gain

    Or its speed w and acceleration alpha are given with it, from a measurement or another program: then any signal will do that
    is continuous, an Input too. Laws of time that disagree are refused; what is not known before the run shows in the outputs
    angle_gap = phi - phi(start) - integral of w and speed_gap = w - w(start) - integral of alpha, which are 0 where they agree.

    Example:
        rig = gb.Drivetrain("positioning")
        drive = rig.add("drive", gb.Angle(phi=0.1 * gb.sin(20 * gb.time)))
        rig.chain(drive, rig.add("shaft", gb.Shaft(k=100.0, c=0.1)), rig.add("disc", gb.Inertia(J=0.01)))
    """

    flange = Flange("driven flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    phi: Signal = signal("prescribed angle", "rad")
    w: Signal | None = signal("its speed, given beside", "rad/s", default=None)
    alpha: Signal | None = signal("its acceleration, given beside", "rad/s2", default=None)
    filter: Value | None = param("cut-off frequency of the filter", "rad/s", default=None, gt=0, symbol="omega_c")
    filter_type: str = option("'critical', 'bessel' or 'butterworth'", default="critical")
    filtered_angle = State("angle behind the filter", "rad", symbol="phi_f")
    filtered_speed = State("its rate", "rad/s", symbol="omega_f")
    angle_sum = State("integral of the speed that is given beside", "rad", accumulates=True, symbol="phi_s")
    speed_sum = State("integral of the acceleration that is given beside", "rad/s", accumulates=True, symbol="omega_s")

    def problems(self) -> Iterator[str]:
        """A filter that there is not, and an angle, a speed and an acceleration that do not belong together."""
        yield from _filter_problems(self, tuple(SECOND_ORDER), "critical")
        if (self.w is None) != (self.alpha is None):
            yield "w and alpha are given together, or neither: a rigid motion needs both"
        elif self.w is not None and self.filter is not None:
            yield "filter finds speed and acceleration of phi; w and alpha give them: leave one of both out"
        elif self.w is not None:
            yield from rate_problems("phi", self.phi, "w", self.w)
            yield from rate_problems("w", self.w, "alpha", self.alpha)

    def number_problems(self) -> Iterator[str]:
        """None: what belongs together are signals, over all time."""
        return iter(())

    def physics(self, s: Any) -> Iterator[Contribution]:
        """phi_flange - phi_housing = phi, through the filter where there is one."""
        wanted, rates = s.phi, None
        if self.filter is not None:
            wanted = s.filtered_angle
            yield from second_order(self.filter_type, s.filter, s.phi, wanted, s.filtered_speed)
        if self.w is not None:
            rates = (s.w, s.alpha)
            for total, value, rate in ((s.angle_sum, s.phi, s.w), (s.speed_sum, s.w, s.alpha)):
                yield Start(total, value)
                yield Rate(total, rate)
            yield Shows("angle_gap", s.phi - s.angle_sum, "rad", "phi less the integral of w")
            yield Shows("speed_gap", s.w - s.speed_sum, "rad/s", "w less the integral of alpha")
        yield Tie(s.flange.phi - s.housing.phi - wanted, rates=rates)
        yield Shows("torque", s.flange.tau, "N m", "reaction on the flange")


class Acceleration(Block):
    """Prescribed acceleration of the flange over the housing, from the speed w0; output torque: the reaction that keeps it.

        w' = alpha,   w = w0 at the start

    On a slider alpha is in m/s2, w0 in m/s and torque a force in N. alpha may jump, and may be an Input. The angle at the start
    is that of the bodies on the shaft.

    Example:
        rig = gb.Drivetrain("starting up")
        up = gb.piecewise((50.0, gb.time < 2.0), (0.0, True))
        rig.chain(rig.add("drive", gb.Acceleration(alpha=up)), rig.add("disc", gb.Inertia(J=0.01)))
    """

    flange = Flange("driven flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    alpha: Signal = signal("prescribed acceleration", "rad/s2")
    w0: Value = param("speed at the start", "rad/s", default=0.0)
    speed = State("prescribed speed", "rad/s", symbol="omega")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """w_flange - w_housing = integral of alpha."""
        yield Start(s.speed, s.w0)
        yield Rate(s.speed, s.alpha)
        yield Motion(s.flange.w - s.housing.w - s.speed)
        yield Shows("torque", s.flange.tau, "N m", "reaction on the flange")


class SpeedLoad(Block):
    """A load that opposes motion: tau = -sign(w) (c0 + c1 abs(w) + c2 w^2), coeffs = (c0, c1, c2).

        flange o---(w)---# housing        w against the housing (the ground when not connected), which gets -tau

    On a slider w is its speed in m/s and tau a force in N. The constant part is dry friction: at w = 0 it holds the shaft
    against up to c0. direction="along" drives: tau = sign(w) (...), from w = 0 forward; "forward" and "backward" keep their
    sign whatever the motion: tau = +-(...) (Modelica's TorqueDirection=true). What such a torque gives counts as supplied.

    Example:
        rig = gb.Drivetrain("pump")
        drive, pump = rig.add("drive", gb.Torque(tau=5.0)), rig.add("pump", gb.SpeedLoad(coeffs=(0.5, 0.01, 1e-4)))
        rig.chain(drive, rig.add("rotor", gb.Inertia(J=0.01)), pump)
    """

    flange = Flange("loaded flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    coeffs: tuple[Value, Value, Value] = param(
        "coefficients c0, c1, c2",
        "N m (rad/s)^-i",
        ge=0,
        many=True,
        each=("dry friction", "torque per speed", "torque per speed squared"),
    )
    heat: HeatPort | None = HEAT
    direction: str = option("'against' the motion, 'along' it, 'forward' or 'backward'", default="against")

    def problems(self) -> Iterator[str]:
        """A wrong number of coefficients, and directions that do not exist."""
        if self.direction not in ("against", "along", "forward", "backward"):
            yield f"direction = {self.direction!r} must be 'against', 'along', 'forward' or 'backward'"
        elif self.direction != "against" and self.heat is not None:
            yield f"heat: a torque with direction = {self.direction!r} loses nothing; leave heat out"
        if not isinstance(self.coeffs, tuple) or len(self.coeffs) != 3:
            yield f"coeffs = {self.coeffs!r} must be three numbers (c0, c1, c2)"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The torque; all power of one that opposes is lost."""
        import sympy as sp

        w = s.flange.w - s.housing.w
        c0, c1, c2 = s.coeffs
        size = sp.Piecewise(
            (w, w >= 0), (-w, True)
        )  # abs(w) of the drag, with or without a dry part that has a direction
        if self.direction != "against":
            tau = c0 + c1 * size + c2 * w**2
            side = {"along": sp.Piecewise((1, w >= 0), (-1, True)), "forward": 1, "backward": -1}[self.direction]
            tau = s.named("T", side * tau, "torque on the flange", "N m")
            yield Acts(s.flange, tau)
            yield Acts(s.housing, -tau)
            yield Shows("torque", tau, "N m", "torque on the flange")
            yield Shows("power", tau * w, "W", "power given")
            return
        drag = c1 * w + c2 * w * size
        yield Stick("", w, c0, engaged=c0)
        yield Acts(s.flange, -drag)
        yield Acts(s.housing, drag)
        yield Energy(loss=drag * w)
        direction, _, held = s.stick("")
        yield Shows("torque", held - direction * c0 - drag, "N m", "torque on the flange")
        yield Shows("loss_power", (direction * c0 + drag) * w, "W", "power taken")
