"""Random scenes: a geared train with effects, one drive, two quantities; determined by the seed alone.

What drives it are the Parameters `load` [N m] and `speed` [rad/s] and start speeds, nothing else, so that a scene at other
loads and speeds is easily made by hand.
"""

from __future__ import annotations

import math
from typing import Any

import gearblocks as gb
from tests.random.draw import Draw, digits

T_END = 0.3


def scene(seed: int) -> gb.Scene:
    """The scene of a seed."""
    d = Draw(f"scene {seed}")
    rig = gb.Drivetrain(f"scene {seed}")
    start = d.choice((0.0, digits(d.even(20.0, 150.0))))
    speeds = _chain(d, rig, start)
    _drags(d, rig, list(speeds))
    if d.chance(0.4):
        _aside(d, rig)
    outputs = _outputs(rig)
    asked: dict[str, gb.Quantity] = {}
    while len(asked) < 2:
        one = _quantity(d, d.choice(outputs))
        asked[str(one)] = one
    initial = {f"{name}.w": w for name, w in speeds.items()} if start else None
    return gb.Scene(
        rig, t_end=T_END, quantity=tuple(asked.values()), within=d.choice((0.01, 0.03, 0.1)), initial=initial
    )


def _chain(d: Draw, rig: gb.Drivetrain, start: float) -> dict[str, float]:
    """A drive and two to four bodies with elements between them; start speeds by body."""
    J, w = d.log(0.005, 0.05), start
    names, speeds = ["body1"], {"body1": w}
    rig.add("body1", gb.Inertia(J=J))
    for i in range(2, d.choice((3, 3, 4, 5))):
        name, before, ratio = f"body{i}", names[-1], 1.0
        other = d.log(0.005, 0.05)
        kind = d.choice(("shaft", "shaft", "mesh", "mesh", "lash"))
        if kind == "mesh":
            ratio = -_mesh(d, rig, f"mesh{i}", J, other)
        elif kind == "shaft":
            k, c = _stiff(d, J, other)
            rig.add(f"shaft{i}", gb.Shaft(k=k, c=d.choice((c, c, None))))
        else:
            k, c = _stiff(d, J, other)
            rig.add(f"lash{i}", gb.Lash(k=k, c=c, half_gap=d.log(1e-4, 5e-3)))
        rig.add(name, gb.Inertia(J=other))
        rig.chain(rig[before], rig[f"{kind}{i}"], rig[name])
        w *= ratio
        names.append(name)
        speeds[name] = w
        J = other
    _drive(d, rig, start, speeds)
    return speeds


def _drive(d: Draw, rig: gb.Drivetrain, start: float, speeds: dict[str, float]) -> None:
    """A torque that fluctuates, or a speed that does; then a torque at the other end."""
    wave = 1.0 + d.choice((0.0, 0.1, 0.5)) * gb.sin(d.log(20.0, 300.0) * gb.time)
    load = gb.Parameter("load", digits(d.even(2.0, 20.0)), "N m")
    if start and d.chance(0.5):
        speed = gb.Parameter("speed", start, "rad/s")
        wobble = 1.0 + d.choice((0.0, 0.02)) * gb.sin(d.log(20.0, 200.0) * gb.time)
        rig.chain(rig.add("engine", gb.Speed(w=speed * wobble)), rig.add("input", gb.Shaft(k=d.log(300, 3e4), c=0.2)))
        rig.connect(rig["input"].b, rig["body1"].a)
        last = [*speeds][-1]
        rig.connect(
            rig.add("work", gb.Torque(tau=load * wave * (-1.0 if speeds[last] > 0 else 1.0))).flange, rig[last].a
        )
    else:
        rig.connect(rig.add("motor", gb.Torque(tau=load * wave)).flange, rig["body1"].a)


def _mesh(d: Draw, rig: gb.Drivetrain, name: str, J1: float, J2: float) -> float:
    """A mesh with some effects; returns r_pinion/r_wheel."""
    teeth = (d.choice((17, 23, 29)), d.choice((31, 41, 53)))
    r = tuple(1.25e-3 * math.cos(0.35) * z for z in teeth)
    mass = 1.0 / (r[0] ** 2 / J1 + r[1] ** 2 / J2)
    more: dict[str, Any] = {}
    if d.chance(0.6):
        more["backlash"] = gb.Backlash(half_gap=d.log(1e-5, 1e-4))
    if d.chance(0.5):
        more["stiffness_variation"] = gb.Fourier(cos=(digits(d.even(0.02, 0.3)),))
    if d.chance(0.4):
        more["transmission_error"] = gb.Harmonic(cos=(d.log(1e-7, 1e-5),))
    if d.chance(0.4):
        more["friction"] = gb.ToothFriction(mu=digits(d.even(0.01, 0.1)), transition=1e-2)
    k = digits(mass * d.log(600.0, 5000.0) ** 2)
    mesh = gb.GearMesh(
        teeth=teeth,
        module=2.5e-3,
        pressure_angle=0.35,
        external=True,
        k=k,
        damping_ratio=d.log(0.02, 0.2),
        **more,
    )
    rig.add(name, mesh)
    return teeth[0] / teeth[1]


def _stiff(d: Draw, J1: float, J2: float) -> tuple[float, float]:
    reduced = 1.0 / (1.0 / J1 + 1.0 / J2)
    k = digits(reduced * d.log(60.0, 2000.0) ** 2)
    return k, digits(2 * d.log(0.01, 0.2) * (k * reduced) ** 0.5)


def _drags(d: Draw, rig: gb.Drivetrain, names: list[str]) -> None:
    """Bearings on some bodies, and a load over speed at the last one."""
    for name in names:
        if d.chance(0.6):
            fields: dict[str, Any] = {"viscous": d.log(1e-4, 1e-1)}
            if d.chance(0.4):
                fields["coulomb"] = d.log(0.01, 1.0)
            if d.chance(0.3):
                fields["windage"] = gb.FluidDrag(c=d.log(1e-7, 1e-4))
            rig.connect(rig.add(f"bearing_{name}", gb.BearingFriction(**fields)).a, rig[name].a)
    if d.chance(0.7):
        rig.connect(rig.add("pump", gb.SpeedLoad(coeffs=(0.0, d.log(1e-3, 0.1), 1e-4))).flange, rig[names[-1]].a)


def _aside(d: Draw, rig: gb.Drivetrain) -> None:
    """Something that turns by itself, on the ground."""
    wheel, wall = rig.add("aside", gb.Inertia(J=0.01, phi0=0.1)), rig.add("wall", gb.Fixed())
    rig.chain(wheel, rig.add("spiral", gb.Shaft(k=d.log(1.0, 100.0), c=0.01)), wall)


def _outputs(rig: gb.Drivetrain) -> list[str]:
    """Torques and forces of elements, speeds of bodies."""
    found = []
    for name in [o.name for o in rig.outputs()]:
        owner, _, what = name.rpartition(".")
        if what in ("torque", "force") and owner.startswith(("shaft", "mesh", "lash", "input")):
            found.append(name)
        if what == "w" and owner.startswith("body"):
            found.append(name)
    return found


def _quantity(d: Draw, output: str) -> gb.Quantity:
    after = T_END / 3
    if output.endswith(".w"):
        return d.choice((gb.last(output), gb.mean(output, after=after), gb.at(output, 0.2)))
    return d.choice((gb.peak(output), gb.rms(output, after=after), gb.rms(output), gb.std(output, after=after)))
