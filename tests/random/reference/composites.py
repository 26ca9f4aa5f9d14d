"""Composites as the parts that they stand for: planetary gears with meshes, shafts in segments."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from tests.random.description import Part, Train
from tests.random.expressions import Node


def expanded(train: Train) -> Train:
    """The same train of simple parts; bodies that a composite brings along come after those of the train."""
    parts, more = [], []
    for p in train.parts:
        found = [p]
        if p.block == "PlanetaryGear":
            found = _planetary(p)
        elif p.block == "Gearbox" and p.field("k") is None:
            found = [_rigid_gearbox(p)]
        elif p.field("segments", 1) > 1:
            found = _segments(p)
        parts += found[:1]
        more += found[1:]
    return replace(train, parts=(*parts, *more))


def _segments(p: Part) -> list[Part]:
    """n springs of n k, and J in n lumps, half ones at the ends."""
    n, J, c = p.field("segments"), p.field("J"), p.field("c")
    nodes = [p.node("a"), *(f"{p.name} node {i}" for i in range(1, n)), p.node("b")]
    fields = (("k", p.field("k") * n), *((("c", c * n),) if c is not None else ()), *_warm(p))
    out = [Part(f"{p.name} spring {i}", "Shaft", fields, (("a", nodes[i]), ("b", nodes[i + 1]))) for i in range(n)]
    for i, node in enumerate(nodes):
        out.append(Part(f"{p.name} lump {i}", "Inertia", (("J", J / n / (2 if i in (0, n) else 1)),), (("a", node),)))
    return out


def _warm(p: Part) -> tuple[tuple[str, Any], ...]:
    """The heat port that all parts share."""
    heat = p.field("heat")
    return () if heat is None else (("heat", heat),)


def _rigid_gearbox(p: Part) -> Part:
    """A gear with losses alone; with a gap: gearboxes.py."""
    kept = ("ratio", "efficiency", "bearing", "loss_table", "heat")
    return Part(f"{p.name} gear", "LossyGear", tuple((n, x) for n, x in p.fields if n in kept), p.at)


def _planetary(p: Part) -> list[Part]:
    """Mesh angles z_sun (phi_s - phi_c) - z_sun psi and z_planet (phi_p - phi_c) - z_ring psi + pi (even planets)."""
    z_sun, z_planet, z_ring = (p.field(f"z_{x}") for x in ("sun", "planet", "ring"))
    half = p.field("module") * math.cos(p.field("pressure_angle")) / 2
    count, out = p.field("planets", 3), []
    for i in range(count):
        psi, node = 2 * math.pi * i / count, f"{p.name} planet {i}"
        own = math.pi if z_planet % 2 == 0 else 0.0
        for name, teeth, ends, phase in (
            ("sun_mesh", (z_sun, z_planet), (p.node("sun"), node), -z_sun * psi),
            ("ring_mesh", (z_planet, z_ring), (node, p.node("ring")), own - z_ring * psi),
        ):
            radii = (half * teeth[0], half * teeth[1])
            fields: dict[str, Any] = {"teeth": teeth, "external": name == "sun_mesh", "r_base": radii}
            law = p.field(name)
            for key, value in law.args[1] if law is not None else ():
                fields[key] = _shifted(value, phase) if isinstance(value, Node) else value
            fields |= dict(_warm(p)) if law is not None else {}
            at = (("pinion", ends[0]), ("wheel", ends[1]), ("carrier", p.node("carrier")))
            out.append(Part(f"{p.name} {name} {i}", "GearMesh", tuple(fields.items()), at))
        out.append(Part(f"{p.name} planet {i}", "Inertia", (("J", p.field("planet_inertia")),), (("a", node),)))
    if p.field("planet_mass") is not None:
        radius = p.field("module") * (z_sun + z_planet) / 2
        fields = {"J": count * p.field("planet_mass") * radius**2}
        out.append(Part(f"{p.name} mass", "Inertia", tuple(fields.items()), (("a", p.node("carrier")),)))
    return out


def _shifted(effect: Node, phase: float) -> Node:
    if effect.args[0] not in ("Fourier", "Harmonic"):
        return effect
    return Node("object", (effect.args[0], (*effect.args[1], ("phase", phase))))
