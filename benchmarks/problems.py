"""The benchmark problems as trains of blocks, and gearblocks' own rows of the tables."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.cases import P1, P2, P4, Array
from benchmarks.measure import cpu_seconds, relative_error

if TYPE_CHECKING:
    from gearblocks import Drivetrain

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
    rig = gb.Drivetrain("P2, one gear pair")
    body = rig.add("body", gb.Inertia(J=1.0, phi0=p.x0))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20,
            radius=1.0,
            k=1.0,
            c=2 * p.zeta,
            stiffness_variation=gb.Fourier(cos=(p.eps,), driven_by=p.w),
            backlash=gb.Backlash(half_gap=p.half_gap),
            contact_damping="always",
        ),
    )
    ground = rig.add("ground", gb.Fixed())
    drive = rig.add("drive", gb.Torque(tau=p.load + p.swing * p.w**2 * gb.cos(p.w * gb.time)))
    rig.chain(drive, body, mesh, ground)
    return rig


def p4(p: P4 | None = None) -> Drivetrain:
    """P4: a chain of n inertias, couplings 0, 2, 4, .. and the last are shafts, the others meshes with backlash."""
    import gearblocks as gb

    p = p or P4()
    rig = gb.Drivetrain(f"P4, chain of {p.n}")
    angles = p.angles
    links: list[Any] = [rig.add("drive", gb.Torque(tau=p.torque * (1 + p.swing * gb.sin(p.w * gb.time))))]
    for i in range(p.n):
        inertia = p.j_light if i % 2 else p.j_heavy
        links.append(rig.add(f"disc{i}", gb.Inertia(J=inertia, phi0=float(angles[i]))))
        if i % 2 == 0 or i == p.n - 1:
            link: Any = gb.Shaft(k=p.k_shaft, c=p.c_shaft)
        else:
            link = gb.Lash(k=p.k_mesh, c=p.c_mesh, half_gap=p.half_gap, contact_damping="always")
        links.append(rig.add(f"link{i}", link))
    links.append(rig.add("ground", gb.Fixed()))
    rig.chain(*links)
    return rig


def columns(problem: P1 | P2 | P4) -> list[tuple[str, float]]:
    """Outputs that are the relative coordinates of the peers, with the factor between them."""
    if isinstance(problem, P1):
        return [("left.twist", -1.0), ("mesh.deflection", 1 / problem.radius), ("right.twist", -1.0)]
    if isinstance(problem, P2):
        return [("mesh.deflection", 1.0)]
    return [(f"link{i}.twist", -1.0) for i in range(problem.n)]


def train(problem: P1 | P2 | P4) -> Drivetrain:
    """The problem built from blocks."""
    return p1(problem) if isinstance(problem, P1) else p2(problem) if isinstance(problem, P2) else p4(problem)


def ours(problem: P1 | P2 | P4, t: Array, reference: Array, rtols: tuple[float, ...], method: str) -> Iterator[Row]:
    """One row per tolerance: CPU seconds in the solver, with the energy ledger on, and the error reached."""
    import gearblocks as gb

    model = gb.build(train(problem))
    wanted = columns(problem)
    for rtol in rtols:
        solver = whole = float("inf")
        for _ in range(10 if t[-1] < 0.1 and isinstance(problem, P1) else 4):
            seconds, run = cpu_seconds(
                lambda: gb.simulate(model, t=t, rtol=rtol, method=method, outputs=[name for name, _ in wanted]),  # noqa: B023
                repeats=1,
            )
            solver, whole = min(solver, run.stats.cpu_seconds), min(whole, seconds)
        y = np.column_stack([factor * run[name] for name, factor in wanted])
        yield (
            f"gearblocks {method} {rtol:.0e}",
            solver,
            relative_error(y, reference[:, : len(wanted)]),
            f"{run.stats.steps} steps, {run.stats.rejected} rejected, {run.stats.events} corners, "
            f"ledger residual {run.energy.residual:.0e}, whole call {whole * 1e3:.3g} ms",
        )
