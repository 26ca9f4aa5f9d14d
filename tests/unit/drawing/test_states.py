"""The state of a run in the drawing of its train: by colour, in words on hover, and in a legend."""

import re
from typing import Any

import pytest

import gearblocks as gb
from gearblocks.drawing.states import COAST, DRIVE, FREE, LEGEND, SLIDING, STUCK


def _shows(drawing: Any, colour: str) -> bool:
    return f'class="element" color="{colour}"' in str(drawing) and f">{LEGEND[colour]}</text>" in str(drawing)


def test_a_brake_slides_and_then_sticks() -> None:
    rig = gb.Drivetrain("brake that slides, then sticks")
    body, brake = rig.add("body", gb.Inertia(J=1.0, w0=1.0)), rig.add("brake", gb.Brake(capacity=1.0))
    rig.connect(body.a, brake.a)
    run = gb.simulate(rig, t_end=2.0)
    early, late = rig.draw(run=run, at=0.0), rig.draw(run=run)
    assert "brake: slides forward" in str(early) and _shows(early, SLIDING) and not _shows(early, STUCK)
    assert "brake: stuck" in str(late) and _shows(late, STUCK) and not _shows(late, SLIDING)
    assert LEGEND[STUCK] not in str(rig.draw())


@pytest.mark.parametrize(("torque", "contact", "colour"), [(1.0, -1, COAST), (-1.0, 1, DRIVE), (0.0, 0, FREE)])
def test_play_shows_the_side_on_which_it_is_closed(torque: float, contact: int, colour: str) -> None:
    rig = gb.Drivetrain("play")
    drive, body = rig.add("drive", gb.Torque(tau=torque)), rig.add("body", gb.Inertia(J=1.0))
    lash, load = rig.add("lash", gb.Lash(k=1e3, half_gap=0.01, c=10.0)), rig.add("load", gb.Inertia(J=1.0))
    rig.chain(drive, body, lash, load)
    run = gb.simulate(rig, t_end=1.0)
    assert run["lash.contact"][-1] == contact
    assert _shows(rig.draw(run=run), colour)


@pytest.mark.long
def test_planets_show_the_contact_of_their_meshes_though_these_are_parts_of_one_block() -> None:
    rig = gb.Drivetrain("planets")
    mesh = gb.MeshLaw(k=1e7, damping_ratio=0.1, backlash=gb.Backlash(half_gap=1e-5))
    gear = gb.PlanetaryGear(z_sun=20, z_planet=20, z_ring=60, planets=4, module=2e-3, pressure_angle=0.35,
                            planet_inertia=1e-4, sun_mesh=mesh, ring_mesh=mesh)  # fmt: skip
    drive, sun, part = rig.add("drive", gb.Torque(tau=1.0)), rig.add("sun", gb.Inertia(J=0.1)), rig.add("gear", gear)
    carrier, wall = rig.add("carrier", gb.Inertia(J=0.1)), rig.add("wall", gb.Fixed())
    rig.connect(drive.flange, sun.a)
    rig.connect(sun.b, part.sun)
    rig.connect(part.carrier, carrier.a)
    rig.connect(part.ring, wall.flange)
    run = gb.simulate(rig, t_end=0.05)
    contact = run["gear.sun_mesh[4].contact"]
    within = next(i for i in range(len(contact) - 1) if contact[i] == contact[i + 1] == 1 and run.t[i] < run.t[i + 1])
    drawing = rig.draw(run=run, at=run.t[within])
    assert _shows(drawing, DRIVE) and "gear.sun_mesh[4]: contact on the drive side" in str(drawing)


@pytest.mark.long
def test_of_elements_side_by_side_each_shows_its_own_state() -> None:
    rig = gb.Drivetrain("clutch beside a spring")
    a, b = rig.add("a", gb.Inertia(J=1.0, w0=1.0)), rig.add("b", gb.Inertia(J=1.0))
    rig.chain(a, rig.add("clutch", gb.Clutch(capacity=0.1)), b)
    rig.chain(a, rig.add("spring", gb.Shaft(k=1.0)), b)
    text = str(rig.draw(run=gb.simulate(rig, t_end=0.1)))
    coloured = re.findall(r'<g class="element" color="(.+?)"><title>(\w+): ', text)
    assert coloured == [(SLIDING, "clutch")]


@pytest.mark.long
def test_a_gear_with_losses_is_no_friction_that_slides() -> None:
    rig = gb.Drivetrain("losses")
    drive, a = rig.add("drive", gb.Torque(tau=1.0)), rig.add("a", gb.Inertia(J=1.0))
    gear, b = rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.9))), rig.add("b", gb.Inertia(J=1.0))
    rig.chain(drive, a, gear, b)
    run = gb.simulate(rig, t_end=0.1)
    assert run["gear.mode"][-1] != 0 and str(rig.draw(run=run)) == str(rig.draw())


def test_what_is_no_state_of_the_train_is_refused() -> None:
    rig, other = gb.Drivetrain("one"), gb.Drivetrain("other")
    for train, name in ((rig, "body"), (other, "disc")):
        train.add(name, gb.Inertia(J=1.0, w0=1.0))
    run = gb.simulate(rig, t_end=2.0)
    with pytest.raises(gb.ParameterError, match=r"must lie within the run, 0 \.\. 2 s"):
        rig.draw(run=run, at=3.0)
    with pytest.raises(gb.ParameterError, match="must be a time in s"):
        rig.draw(run=run, at="late")  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match="must be a run, as gb"):
        rig.draw(run=2.0)  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match="give run= too"):
        rig.draw(at=1.0)
    with pytest.raises(gb.ParameterError, match="the run is of another train"):
        other.draw(run=run)
