"""Engines, motors and brakes with maps and states of their own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.language.block import Block
from gearblocks.language.contributions import Acts, Contribution, Energy, Rate, Shows
from gearblocks.language.fields import Flange, State, option, param, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Signal, Value
from gearblocks.language.tables import Table2


class EddyCurrentBrake(Block):
    """A brake by eddy currents: tau = -2 excitation tau_nominal / (w_nominal/w + w/w_nominal), w against the housing.

    The torque is largest, excitation tau_nominal, at w = w_nominal (Wouterse, Critical torque and speed of eddy
    current brake, IEE Proceedings B 138, 1991); it is 0 at rest. excitation: 1 for the nominal field, in proportion to
    the square of the field; it must not be negative. All power is lost. On a slider speeds are in m/s, tau a force in N.
    With a heat port and alpha the resistance of the disc follows its temperature T, and with it the speed of the largest
    torque: w_nominal (1 + alpha (T - T_ref)) takes the place of w_nominal
    (Modelica.Mechanics.Rotational.Sources.EddyCurrentTorque; alpha is its alpha20 where T_ref is 20 degC).

    Example:
        rig = gb.Drivetrain("retarder")
        retarder = gb.EddyCurrentBrake(tau_nominal=500.0, w_nominal="1500 rpm", excitation=gb.Input("field", start=1.0))
        rig.chain(rig.add("shaft", gb.Inertia(J=3.0, w0="2000 rpm")), rig.add("retarder", retarder))
    """

    flange = Flange("braked flange", slider=None)
    housing = Flange("housing", ground=True, slider=None)
    tau_nominal: Value = param("largest torque", "N m", ge=0, symbol="T_nom")
    w_nominal: Value = param("speed of the largest torque", "rad/s", gt=0, symbol="omega_nom")
    excitation: Signal = signal("factor on the torque", default=1.0, ge=0, symbol="u", why=": a brake does not drive")
    alpha: Value | None = param(
        "temperature coefficient of the resistance at T_ref", "1/K", default=None, belongs_to="heat"
    )
    T_ref: Value | None = param(
        "temperature that w_nominal holds at, 293.15 K where it is not given",
        "K",
        default=None,
        ge=0,
        belongs_to="heat",
    )
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """What belongs to a temperature that it has not."""
        if self.alpha is not None and self.heat is None:
            yield f"alpha = {self.alpha!r} needs the temperature: give heat=gb.HeatPort(T=...)"
        if self.T_ref is not None and self.alpha is None:
            yield f"T_ref = {self.T_ref!r} K goes with alpha"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The torque against the motion, and its reaction."""
        import sympy as sp

        w, w_nominal = s.flange.w - s.housing.w, s.w_nominal
        if self.alpha is not None:
            T_ref = sp.Float(293.15) if self.T_ref is None else s.T_ref
            w_nominal = w_nominal * (1 + s.alpha * (s.heat.T - T_ref))
            w_nominal = s.named("w_T", w_nominal, "speed of the largest torque", "rad/s")
        slope = 2 * s.excitation * s.tau_nominal * w_nominal / (w**2 + w_nominal**2)
        slope = s.named("d", slope, "braking torque over speed", "N m s/rad")
        yield Acts(s.flange, -slope * w)
        yield Acts(s.housing, slope * w)
        yield Energy(loss=slope * w**2)
        yield Shows("torque", -slope * w, "N m", "torque on the flange")
        yield Shows("loss_power", slope * w**2, "W", "power lost")


class DCMotor(Block):
    """DC machine with a constant field: L i' = u - R i - k w, torque k i, w against the housing.

        u o--[R]--[L]--(M)---o flange

    The current i is a state, 0 at the start (another value: initial={"motor.i": ...}).

    Example:
        rig = gb.Drivetrain("motor and fan")
        motor = rig.add("motor", gb.DCMotor(R=0.5, L=1e-3, k=0.05, u=gb.Input("u", start=12.0, unit="V")))
        rig.chain(motor, rig.add("fan", gb.Inertia(J=1e-4)), rig.add("air", gb.SpeedLoad(coeffs=(0.0, 0.0, 1e-6))))
    """

    flange = Flange("shaft")
    housing = Flange("housing", ground=True)
    R: Value = param("resistance", "ohm", ge=0)
    L: Value = param("inductance", "H", gt=0)
    k: Value = param("torque constant, and voltage per speed", "N m/A")
    u: Signal = signal("terminal voltage", "V")
    i = State("current", "A")
    heat: HeatPort | None = HEAT

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The circuit and the torque."""
        torque = s.k * s.i
        yield Acts(s.flange, torque)
        yield Acts(s.housing, -torque)
        yield Rate(s.i, (s.u - s.R * s.i - s.k * (s.flange.w - s.housing.w)) / s.L)
        yield Energy(stored=s.L * s.i**2 / 2, loss=s.R * s.i**2)
        yield Shows("torque", torque, "N m", "torque on the flange")
        yield Shows("current", s.i, "A", "current")
        yield Shows("electric_power", s.u * s.i, "W", "power from the terminals")


class Engine(Block):
    """A torque from a map over speed and throttle, its reaction on the housing.

    torque_map: a Table2 with x the speed of the flange against the housing in rad/s, y the throttle (0 to 1, or what
    the map uses), z the torque in N m, negative where the engine brakes. Outside, the map is held at its edge.

    Example:
        rig = gb.Drivetrain("engine on a load")
        torque = gb.Table2([0.0, 200.0, 600.0], [0.0, 1.0], [[-10.0, 150.0], [-20.0, 200.0], [-40.0, 120.0]])
        engine = rig.add("engine", gb.Engine(torque_map=torque, throttle=gb.Input("throttle", start=0.3)))
        crank, load = rig.add("crank", gb.Inertia(J=0.2, w0=100.0)), rig.add("load", gb.SpeedLoad(coeffs=(0.0, 0.2, 0.0)))
        rig.chain(engine, crank, load)
    """

    flange = Flange("shaft")
    housing = Flange("housing", ground=True)
    torque_map: Table2 = option("torque over speed in rad/s and throttle, a gb.Table2")
    throttle: Signal = signal("throttle, as in the map")

    def problems(self) -> Iterator[str]:
        """A map that is none."""
        if not isinstance(self.torque_map, Table2):
            yield f"torque_map = {self.torque_map!r:.80} must be a gb.Table2 over speed and throttle"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The torque of the map."""
        torque = s.local("torque_map", speed=s.flange.w - s.housing.w, throttle=s.throttle)
        yield Acts(s.flange, torque)
        yield Acts(s.housing, -torque)
        yield Shows("torque", torque, "N m", "torque on the flange")
        yield Shows("throttle", s.throttle, "1", "throttle")


class Governor(Block):
    """Speed controller: output `command`, to be read with gb.sense("governor.command"); exerts no torque.

        e = target - w,   u = bias + gain e + integral,   command = u held between lower and upper
        integral' = integral_gain (command - bias - integral)/gain,   which is integral_gain (e + (command - u)/gain)

    Without integral_gain a speed droop remains. The last term keeps the integral from running away while the command is
    at a limit (back-calculation: Åström and Hägglund, PID Controllers, 1995). With time_constant the command passes
    an actuator: command' = (held u - command)/time_constant. Both states start at 0.

    Example:
        rig = gb.Drivetrain("governed motor")
        drive = rig.add("drive", gb.Torque(tau=20.0 * gb.sense("governor.command")))
        rotor, governor = rig.add("rotor", gb.Inertia(J=0.1)), gb.Governor(target="1500 rpm", gain=0.05, integral_gain=0.1)
        rig.chain(drive, rotor, rig.add("governor", governor))
    """

    flange = Flange("sensed flange")
    target: Signal = signal("target speed", "rad/s", symbol="omega_ref")
    gain: Value = param("command per speed error", "s/rad", gt=0)
    integral_gain: Value | None = param("command per integrated speed error", "1/rad", default=None, ge=0, symbol="K_I")
    time_constant: Value | None = param("time constant of the actuator", "s", default=None, gt=0, symbol="T_a")
    bias: Value = param("command at the target speed", default=0.0, symbol="u_0")
    lower: Value = param("least command", default=0.0, symbol="y_min")
    upper: Value = param("largest command", default=1.0, symbol="y_max")
    integral = State("integral part of the command", symbol="I")
    actuator = State("command behind the actuator", symbol="u_a")

    def problems(self) -> Iterator[str]:
        """Limits that leave no room."""
        if isinstance(self.lower, (int, float)) and isinstance(self.upper, (int, float)) and self.lower >= self.upper:
            yield f"lower = {self.lower!r} must be < upper = {self.upper!r}"

    def physics(self, s: Any) -> Iterator[Contribution]:
        """The control law and its states."""
        import sympy as sp

        error = s.named("e", s.target - s.flange.w, "speed error", "rad/s")
        wanted = s.bias + s.gain * error + (s.integral if self.integral_gain is not None else 0)
        wanted = s.named("u", wanted, "command before its limits")
        held = s.named("y", sp.Min(sp.Max(wanted, s.lower), s.upper), "command within its limits")
        if self.integral_gain is not None:
            # without the error, which cancels at a limit: a rate of rounding would be followed there
            yield Rate(s.integral, s.integral_gain * (held - s.bias - s.integral) / s.gain)
        if self.time_constant is not None:
            yield Rate(s.actuator, (held - s.actuator) / s.time_constant)
        yield Shows("command", s.actuator if self.time_constant is not None else held, "1", "command")
        yield Shows("error", error, "rad/s", "speed error target - w")
