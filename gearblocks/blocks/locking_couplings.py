"""Locking couplings: one way, by teeth, or by a cone before the teeth."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gearblocks.blocks.friction import (
    CAPACITY,
    ENGAGEMENT,
    FORCE_MAX,
    GEOMETRY,
    MU,
    PEAK,
    DryFriction,
    dry_friction,
    friction_element,
    friction_problems,
    relative_motion,
)
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Shows, Stick, Switch
from gearblocks.language.fields import Flange, State, signal
from gearblocks.language.heat import HEAT, HeatPort
from gearblocks.language.signals import Signal, Value

_LEAST = 1e-4  # break-away torque while not engaged, over that of the largest normal force


class OneWayClutch(Block):
    """A freewheel and a friction clutch in parallel: b never turns slower than a.

        a o---|>|---o b        w_rel = w_b - w_a >= 0, phi_rel = phi_b - phi_a, torque: on b

    w_rel < 0 is prevented without limit. While w_rel > 0 the clutch slips with capacity, or geometry mu(w_rel) force_max
    engagement, against it; not engaged (<= 0) it turns freely. Stuck, w_rel is exactly 0 until the torque that pulls b
    ahead exceeds peak times the slip torque at rest, or where it is not engaged 1e-4 mu(0) geometry force_max (with
    capacity: 0). The law of Modelica.Mechanics.Rotational.Components.OneWayClutch. mode: 0 stuck, 1 turning ahead.

    Example:
        rig = gb.Drivetrain("starter")
        starter, engine = rig.add("starter", gb.Inertia(J=1e-3, w0=100.0)), rig.add("engine", gb.Inertia(J=0.1, w0=120.0))
        rig.chain(starter, rig.add("clutch", gb.OneWayClutch(capacity=1.0)), engine)
    """

    a, b = Flange("side that drives", slider=None), Flange("side that may run ahead", slider=None)
    capacity: Signal | None = CAPACITY
    mu: Signal | None = MU
    force_max: Value | None = FORCE_MAX
    engagement: Signal | None = ENGAGEMENT
    geometry: Value = GEOMETRY
    peak: Value = PEAK
    phi_rel = State("relative angle", "rad")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting or missing fields."""
        yield from friction_problems(self)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """A constraint force between the break-away and infinity."""
        import sympy as sp

        slip = s.b.w - s.a.w
        found = dry_friction(self, s, slip)
        least: Any = sp.Integer(0)
        if self.capacity is None:
            least = sp.Float(_LEAST) * s.geometry * s.force_max * s.local("mu", slip=sp.Integer(0))
            yield Switch("break-away", found.limit - least)
        on = s.named("n", 1 - sp.Heaviside(-found.engaged, 1), "1 while it is engaged, else 0")
        yield Switch("engagement", -found.engaged, low=1.0, high=0.0)
        lower = -on * found.limit if self.capacity is not None else -sp.Max(found.limit, least)
        yield from friction_element(
            s, slip, s.b.phi - s.a.phi, DryFriction(sp.Integer(1), on * found.sliding, (lower, sp.oo))
        )


class Freewheel(Block):
    """An ideal freewheel: b never turns slower than a, and runs ahead without friction.

        a o---|>|---o b        w_rel = w_b - w_a >= 0, phi_rel = phi_b - phi_a, torque: on b, >= 0

    Where b would fall behind it locks: w_rel is exactly 0, until the torque on b falls to 0. mode: 0 stuck, 1 running
    ahead.

    Example:
        rig = gb.Drivetrain("bicycle")
        crank, wheel = rig.add("crank", gb.Inertia(J=0.01)), rig.add("wheel", gb.Inertia(J=0.2, w0=10.0))
        rig.chain(rig.add("rider", gb.Torque(tau=5.0)), crank, rig.add("freewheel", gb.Freewheel()), wheel)
    """

    a, b = Flange("side that drives", slider=None), Flange("side that may run ahead", slider=None)
    phi_rel = State("relative angle", "rad")
    heat: HeatPort | None = HEAT

    def physics(self, s: Any) -> Iterator[Contribution]:
        """A constraint force >= 0, which pushes b forward alone."""
        import sympy as sp

        zero = sp.Integer(0)
        yield from friction_element(
            s, s.b.w - s.a.w, s.b.phi - s.a.phi, DryFriction(sp.Integer(1), zero, (zero, sp.oo))
        )


class DogClutch(Block):
    """Teeth that lock two shafts while engaged > 0, whatever the torque.

        a o---|H|---o b        w_rel = w_b - w_a, phi_rel = phi_b - phi_a, torque: on b

    Closing on a speed difference is a plastic impact: both sides go on with one speed, momentum is kept, the energy of
    the difference is lost; impulse [N m s] is that of the last one. mode: 0 locked, 2 free. Where several locks leave no
    motion or contradict each other (tie-up), the run says so by name.

    Example:
        rig = gb.Drivetrain("gear shift")
        shaft, gear = rig.add("shaft", gb.Inertia(J=0.1, w0=50.0)), rig.add("gear", gb.Inertia(J=0.02))
        rig.chain(shaft, rig.add("dog", gb.DogClutch(engaged=gb.Table([0.0, 0.5], [0.0, 1.0], "step"))), gear)
    """

    a, b = Flange("one side", slider=None), Flange("other side", slider=None)
    engaged: Signal = signal("locked while > 0", symbol="u")
    phi_rel = State("relative angle", "rad")
    impulse = State("impulse of the last closing", "N m s")
    heat: HeatPort | None = HEAT

    def physics(self, s: Any) -> Iterator[Contribution]:
        """A lock without limit."""
        import sympy as sp

        slip = s.b.w - s.a.w
        yield Stick("", slip, sp.oo, 0, s.engaged, s.impulse)
        direction, stuck, held = s.stick("")
        yield from relative_motion(s, slip, s.b.phi - s.a.phi, direction, stuck)
        yield Shows("torque", held, "N m", "torque on flange b")
        yield Shows("impulse", s.impulse, "N m s", "impulse of the last closing on a speed difference")


class Synchronizer(Block):
    """A cone clutch that brings two shafts to one speed, then teeth that lock them.

        a o---|cone||dog|---o b        w_rel = w_b - w_a, phi_rel = phi_b - phi_a, torque: on b

    Fields of the cone as of `Clutch`. engaged > 0 asks for the teeth: they are blocked as long as the cone slips or is
    free, go in without an impact once the cone sticks, and stay in until engaged <= 0, whatever the cone does
    then. The cone must be pressed (capacity or engagement > 0) for them to go in, at equal speeds too. locked: 1 while
    the teeth are in. mode: 0 one speed, +1 the cone slips with w_rel > 0, -1 with w_rel < 0, 2 free.

    Example:
        rig = gb.Drivetrain("synchronised shift")
        shaft, gear = rig.add("shaft", gb.Inertia(J=0.1, w0=50.0)), rig.add("gear", gb.Inertia(J=0.02))
        rig.chain(shaft, rig.add("sleeve", gb.Synchronizer(engaged=1.0, capacity=10.0)), gear)
    """

    a, b = Flange("one side", slider=None), Flange("other side", slider=None)
    engaged: Signal = signal("asks for the teeth while > 0", symbol="u")
    capacity: Signal | None = CAPACITY
    mu: Signal | None = MU
    force_max: Value | None = FORCE_MAX
    engagement: Signal | None = ENGAGEMENT
    geometry: Value = GEOMETRY
    peak: Value = PEAK
    phi_rel = State("relative angle", "rad")
    heat: HeatPort | None = HEAT

    def problems(self) -> Iterator[str]:
        """Contradicting or missing fields."""
        yield from friction_problems(self)

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Friction and a lock along one slip."""
        import sympy as sp

        slip = s.b.w - s.a.w
        cone = dry_friction(self, s, slip)
        direction, stuck, held = s.stick("cone")
        _, locked, teeth = s.stick("teeth")
        together = 1 - (1 - stuck) * (1 - locked)
        yield Stick("cone", slip, cone.limit, cone.sliding, cone.engaged)
        yield Stick("teeth", slip, sp.oo, 0, s.engaged * together)
        yield from relative_motion(s, slip, s.b.phi - s.a.phi, direction, together)
        yield Shows("torque", held + teeth - direction * cone.sliding, "N m", "torque on flange b")
        yield Shows("locked", locked, "1", "1 while the teeth are in")
        yield Shows("loss_power", direction * cone.sliding * slip, "W", "power lost by the cone")
