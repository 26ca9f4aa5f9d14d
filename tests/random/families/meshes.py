"""Compliant meshes, splines and non-circular pairs between bodies."""

from __future__ import annotations

from typing import Any

from tests.random.draw import Growth, digits
from tests.random.expressions import thing


def teeth_and_radii(g: Growth) -> tuple[tuple[int, int], tuple[float, float]]:
    """Tooth counts and base radii in their ratio."""
    teeth = (g.d.choice((17, 20, 23)), g.d.choice((20, 31, 40, 46)))
    r = g.d.choice((0.02, 0.05, 0.1))
    return teeth, (r, r * teeth[1] / teeth[0])


def mesh(g: Growth, a: str, b: str, gap: bool, excited: bool = True) -> None:
    """A mesh along the line of action; gap: with backlash."""
    teeth, radii = teeth_and_radii(g)
    at, over = (g.inertia[n] for n in (a, b))
    reduced = 1.0 / (radii[0] ** 2 / at + radii[1] ** 2 / over)
    k = digits(reduced * g.d.log(15.0, 120.0) ** 2)
    fields: dict[str, Any] = {"teeth": teeth, "external": g.d.chance(0.7), "r_base": radii, "k": k}
    if g.d.chance(0.7):
        fields["c"] = digits(2 * g.d.log(0.005, 0.3) * (k * reduced) ** 0.5)
    if excited:
        excitation(g, fields, radii[0])
    if gap:
        fields |= backlash(g, radii[0] * g.d.log(0.001, 0.1), "c" in fields)
    g.drops.append(g.add("mesh", "GearMesh", {"pinion": a, "wheel": b}, **fields))


def excitation(g: Growth, fields: dict[str, Any], radius: float) -> None:
    """A variation of stiffness or an error, driven by the angle or by a frequency."""
    driven = g.d.choice(("angle", "angle", g.d.log(5.0, 60.0)))
    if g.d.chance(0.4):
        fields["stiffness_variation"] = thing("Fourier", cos=(g.d.even(0.05, 0.4),), driven_by=driven)
    elif g.d.chance(0.15):
        fields["stiffness_variation"] = thing(
            "Square", ripple=g.d.even(0.05, 0.4), contact_ratio=g.d.even(1.2, 1.8), driven_by=g.d.log(5.0, 60.0)
        )
    if g.d.chance(0.3):
        fields["transmission_error"] = thing(
            "Harmonic", cos=(digits(radius * g.d.log(0.0005, 0.02)),), driven_by=driven
        )


def backlash(g: Growth, half_gap: float, damped: bool) -> dict[str, Any]:
    """Backlash and what damping does in it."""
    if not damped and g.d.chance(0.3):
        hunt = thing("HuntCrossley", restitution=g.d.even(0.2, 0.95))
        return {"backlash": thing("Backlash", half_gap=digits(half_gap)), "contact_damping": hunt}
    if g.d.chance(0.15):
        smooth = thing("Backlash", half_gap=digits(half_gap), law="smooth", width=digits(0.3 * half_gap))
        return {"backlash": smooth, "contact_damping": "always"}
    choice = g.d.choice((None, "clipped", "clipped_force", "always")) if damped else None
    return {"backlash": thing("Backlash", half_gap=digits(half_gap))} | (
        {} if choice is None else {"contact_damping": choice}
    )


def spline(g: Growth, a: str, b: str) -> None:
    """A spline with backlash, of all teeth together or of every tooth."""
    radius, reduced = g.d.choice((0.02, 0.05)), g.reduced(a, b)
    k = digits(reduced / radius**2 * g.d.log(15.0, 120.0) ** 2)
    fields: dict[str, Any] = {"teeth": g.d.choice((3, 4, 6)), "radius": radius, "k": k}
    if g.d.chance(0.7):
        fields["c"] = digits(2 * g.d.log(0.005, 0.3) * (k * reduced) ** 0.5 / radius)
    half_gap = radius * g.d.log(0.002, 0.1)
    if g.d.chance(0.35):
        gaps = tuple(digits(half_gap * g.d.choice((0.5, 1.0, 1.0, 1.5, 2.0))) for _ in range(fields["teeth"]))
        fields["backlash"] = thing("Backlash", gaps=gaps)
        if "c" in fields:
            fields["contact_damping"] = g.d.choice((None, "always"))
    else:
        fields |= backlash(g, half_gap, "c" in fields)
    g.drops.append(g.add("spline", "SplineCoupling", {"a": a, "b": b}, **fields))


def rigid_play(g: Growth, a: str, b: str) -> None:
    """A rigid mesh, spline or lash with play and restitution."""
    hunt = thing("HuntCrossley", restitution=g.d.choice((1.0, g.d.even(0.1, 0.95), g.d.even(0.2, 0.8))))
    kind = g.d.choice(("Lash", "SplineCoupling", "GearMesh"))
    half_gap = g.d.log(0.005, 0.3)
    if kind == "Lash":
        g.add("lash", kind, {"a": a, "b": b}, k=1000.0, half_gap=half_gap, contact_damping=hunt, hits=True)
    elif kind == "SplineCoupling":
        gap = thing("Backlash", half_gap=digits(0.05 * half_gap))
        g.add("spline", kind, {"a": a, "b": b}, teeth=4, radius=0.05, k=1e6, backlash=gap,
              contact_damping=hunt, hits=True)  # fmt: skip
    else:
        teeth, radii = teeth_and_radii(g)
        gap = thing("Backlash", half_gap=digits(radii[0] * half_gap))
        at = {"pinion": a, "wheel": b}
        g.add("mesh", kind, at, teeth=teeth, external=g.d.chance(0.7), r_base=radii, backlash=gap, contact_damping=hunt)


def noncircular(g: Growth, a: str, b: str | None = None, gap: bool = False) -> str:
    """A pair of elliptic gears: rigid to a new body, or compliant between two."""
    law = thing("RatioLaw.ellipse", e=g.d.even(0.05, 0.6), order=g.d.choice((1, 1, 2)))
    external = g.d.chance(0.6)
    if b is None:
        b = g.follower()
        g.add("noncircular", "NonCircularGear", {"a": a, "b": b}, law=law, external=external)
        return b
    k = g.stiffness(a, b, 10.0, 100.0)
    fields: dict[str, Any] = {"law": law, "external": external, "k": k, "c": g.damping(a, b, k)}
    if gap:
        fields["backlash"] = thing("Backlash", half_gap=g.d.log(0.002, 0.1))
    g.add("noncircular", "NonCircularGear", {"a": a, "b": b}, **fields)
    return b
