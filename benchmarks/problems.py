"""The benchmark problems as trains of blocks, and gearblocks' own rows of the tables."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.cases import P1, P2, P3, P4, Array, Problem
from benchmarks.measure import cpu_seconds, relative_error
from models.planetary_backlash import planetary
from models.stiff_chain import chain

if TYPE_CHECKING:
    from gearblocks import Drivetrain
    from gearblocks.solver.library import Model

Row = tuple[str, float, float, str]


def p1(p: P1 | None = None) -> Drivetrain:
    """P1: inertia, shaft, inertia, spline mesh with backlash, inertia, shaft, inertia; a torque at each end."""
    import gearblocks as gb

    p = p or P1()
    w = gb.Parameter("w", p.w, "rad/s")
    wave = gb.cos(w * gb.time)
    rig = gb.Drivetrain("P1, spline-like, 4 discs")
    discs = [rig.add(f"disc{i + 1}", gb.Inertia(J=p.J[i], phi0=p.angles[i])) for i in range(4)]
    left = rig.add("left", gb.Shaft(k=p.k_shaft, damping_ratio=p.zeta))
    right = rig.add("right", gb.Shaft(k=p.k_shaft, damping_ratio=p.zeta))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20,
            radius=p.radius,
            k=p.k_mesh,
            c=p.c_mesh,
            stiffness_variation=gb.Fourier(cos=(p.ripple,), driven_by=w),
            backlash=gb.Backlash(half_gap=p.half_gap),
            contact_damping="always",
        ),
    )
    drive = rig.add("drive", gb.Torque(tau=p.torque * (1 + p.swing * wave)))
    load = rig.add("load", gb.Torque(tau=-p.torque))
    rig.chain(drive, discs[0], left, discs[1], mesh, discs[2], right, discs[3], load)
    return rig


def p2(p: P2 | None = None) -> Drivetrain:
    """P2: one inertia of 1 against ground through a mesh of radius 1, so that the deflection is the angle."""
    import gearblocks as gb

    p = p or P2()
    w = gb.Parameter("w", p.w, "rad/s")
    rig = gb.Drivetrain("P2, one gear pair")
    body = rig.add("body", gb.Inertia(J=1.0, phi0=p.x0))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20,
            radius=1.0,
            k=1.0,
            c=2 * p.zeta,
            stiffness_variation=gb.Fourier(cos=(p.eps,), driven_by=w),
            backlash=gb.Backlash(half_gap=p.half_gap),
            contact_damping="always",
        ),
    )
    ground = rig.add("ground", gb.Fixed())
    drive = rig.add("drive", gb.Torque(tau=p.load + p.swing * w**2 * gb.cos(w * gb.time)))
    rig.chain(drive, body, mesh, ground)
    return rig


def columns(problem: Problem) -> list[tuple[str, float]]:
    """Outputs that are the relative coordinates of the peers, with the factor between them."""
    if isinstance(problem, P1):
        return [("left.twist", -1.0), ("mesh.deflection", 1 / problem.radius), ("right.twist", -1.0)]
    if isinstance(problem, P2):
        return [("mesh.deflection", 1.0)]
    if isinstance(problem, P3):
        return [
            *((f"{kind}_mesh{i}.deflection", 1.0) for kind in ("sun", "ring") for i in range(4)),
            ("mount.twist", -1.0),
        ]
    return [(f"link{i}.twist", -1.0) for i in range(problem.n)]


def train(problem: Problem) -> Drivetrain:
    """The problem built from blocks."""
    if isinstance(problem, P1 | P2):
        return p1(problem) if isinstance(problem, P1) else p2(problem)
    return planetary(problem) if isinstance(problem, P3) else chain(problem)


@lru_cache(maxsize=1)
def model(problem: Problem) -> Model:
    """The compiled train, kept for the next method."""
    import gearblocks as gb

    return gb.build(train(problem))


def ours(problem: Problem, t: Array, reference: Array, rtols: tuple[float, ...], method: str) -> Iterator[Row]:
    """One row per tolerance: CPU seconds in the solver, with the energy ledger on, and the error reached."""
    import gearblocks as gb

    built, wanted = model(problem), columns(problem)
    for rtol in rtols:
        solver = whole = float("inf")
        for _ in range(10 if isinstance(problem, P1 | P3) and t[-1] < 0.1 else 1 if len(wanted) > 2000 else 4):
            once = partial(gb.simulate, built, t=t, rtol=rtol, method=method, outputs=[name for name, _ in wanted])
            seconds, run = cpu_seconds(once, repeats=1)
            solver, whole = min(solver, run.stats.cpu_seconds), min(whole, seconds)
        y = np.column_stack([factor * run[name] for name, factor in wanted])
        stats, each = run.stats, ""
        if isinstance(problem, P4):
            each = f", {solver / (stats.steps + stats.rejected) / problem.n * 1e9:.0f} ns a step and inertia"
        yield (
            f"gearblocks {method} {rtol:.0e}",
            solver,
            relative_error(y, reference),
            f"{stats.steps} steps, {stats.rejected} rejected, {stats.events} corners{each}, "
            f"ledger residual {run.energy.residual:.0e}, whole call {whole * 1e3:.3g} ms"
            + (f"; {stats.why}" if method == "auto" else ""),
        )
