"""Friction that sticks, locks and stops where solvers trip: at limits, at rest, at coincidences."""

from collections.abc import Iterator
from typing import Any

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.language.block import Block
from gearblocks.language.contributions import Contribution, Stick, Stop
from gearblocks.language.fields import Flange, param, signal

METHODS = [{"method": "auto"}, {"method": "dp5"}, {"method": "rodas"}, {"method": "rk4", "step": 0.01}]


class Plate(Block):
    """Friction against b, the ground when not connected."""

    a, b = Flange("one side"), Flange("other side", ground=True)
    capacity: Any = signal("torque", "N m")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """Slides where it can not hold."""
        yield Stick("", s.b.w - s.a.w, s.capacity, engaged=s.capacity)


class Wall(Block):
    """phi_a - phi_b >= -room."""

    a, b = Flange("ball"), Flange("wall", ground=True)
    room: float = param("room", "rad")
    restitution: float = param("restitution")

    def physics(self, s: Any) -> Iterator[Contribution]:
        """One stop."""
        yield Stop("", s.a.phi - s.b.phi + s.room, s.restitution)


def shaft(tau: Any, *, w0: float = 0.0, **parts: Block) -> gb.Drivetrain:
    """A shaft of 1 kg m2 under a torque, with parts on it."""
    rig = gb.Drivetrain("shaft")
    a = rig.add("A", gb.Inertia(J=1.0, w0=w0))
    drive = rig.add("drive", gb.Torque(tau=tau))
    rig.connect(drive.flange, a.a)
    for name, part in parts.items():
        rig.connect(rig.add(name, part).a, a.b)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("how", METHODS)
def test_a_stop_from_which_the_load_turns_away_tangentially_opens_once(how: dict[str, Any]) -> None:
    """At pi/2 the force, and with it the gap and its first two rates, pass zero together."""
    run = gb.simulate(shaft(-3 * sp.cos(gb.time), wall=Wall(room=0.0, restitution=0.0)), t_end=6.0, **how)
    assert [e.component for e in run.events] == ["wall"]
    t = sp.Float(6.0)
    away = float(3 * sp.cos(t) + 3 * t - sp.Rational(3, 2) * sp.pi)
    assert run["A.phi"][-1] == pytest.approx(away, rel=1e-5)  # the default tolerance is 1e-6


@pytest.mark.long
@pytest.mark.parametrize("how", METHODS)
def test_a_capacity_that_dips_to_the_held_torque_is_survived(how: dict[str, Any]) -> None:
    """The dip lasts 3e-5 s and lets through what rounding does."""
    rig = shaft(3.0, plate=Plate(capacity=4 + (1 + 1e-10) * sp.cos(gb.time)))
    run = gb.simulate(rig, t_end=7.0, **how)
    assert run["A.w"][-1] == 0.0
    assert abs(run["A.phi"][-1]) < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("how", METHODS)
def test_a_shaft_of_prescribed_speed_supplies_the_work_of_the_impacts_on_it(how: dict[str, Any]) -> None:
    """A ball of 2 kg m2 at -3 rad/s meets a wall that moves on at 1 rad/s, by a plastic impact at t = 1/4 s."""
    rig = gb.Drivetrain("pushed")
    ball, wall = rig.add("ball", gb.Inertia(J=2.0, w0=-3.0)), rig.add("wall", gb.Inertia(J=1.0))
    drive = rig.add("drive", gb.Speed(w=1.0))
    stop = rig.add("stop", Wall(room=1.0, restitution=0.0))
    rig.connect(drive.flange, wall.a)
    rig.connect(stop.a, ball.a)
    rig.connect(stop.b, wall.b)
    run = gb.simulate(rig, t_end=1.0, **how)
    assert run["ball.w"][-1] == 1.0
    assert run.energy.supplied["drive"] == pytest.approx(2.0 * 4.0 * 1.0, rel=1e-13)  # impulse times speed
    assert run.energy.dissipated["stop"] == pytest.approx(0.5 * 2.0 * 4.0**2, rel=1e-13)
    assert run.energy.residual < 1e-14


@pytest.mark.filterwarnings("ignore::gearblocks.errors.GearblocksWarning")  # its energy in steps of seconds
@pytest.mark.parametrize("how", METHODS)
def test_a_break_away_that_lasts_far_shorter_than_a_step_is_found(how: dict[str, Any]) -> None:
    """The capacity is below the torque for 0.03 s, in steps of seconds: away and stuck again."""
    rig = shaft(3.0, plate=Plate(capacity=4 + (1 + 1e-4) * sp.cos(gb.time)))
    run = gb.simulate(rig, t_end=7.0, **how)
    assert [(e.before, e.after) for e in run.events] == [(0.0, -1.0), (-1.0, 0.0)]
    assert run["A.w"][-1] == 0.0


@pytest.mark.long
@pytest.mark.parametrize("how", METHODS)
def test_locks_that_tie_a_turning_shaft_to_the_ground_are_refused_by_name(how: dict[str, Any]) -> None:
    """One lock holds the shaft at the prescribed speed, the other one wants it at rest."""
    rig = gb.Drivetrain("tie-up")
    held, drive = rig.add("held", gb.Inertia(J=1.0)), rig.add("drive", gb.Speed(w=2.0))
    turned = rig.add("turned", gb.Inertia(J=1.0))
    rig.connect(drive.flange, turned.a)
    for name, side in (("first", turned.b), ("second", None)):
        dog = rig.add(name, gb.DogClutch(engaged=1.0 if side else sp.Piecewise((0, gb.time < 1), (1, True))))
        rig.connect(dog.a, held.b)
        rig.connect(dog.b, side if side else rig.add("ground", gb.Fixed()).flange)
    with pytest.raises(gb.SimulationError, match=r"'(first|second)'.* t = 1 s"):
        gb.simulate(rig, t_end=2.0, **how)
