"""A chain of a hundred thousand bodies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import gearblocks as gb
from gearblocks.hard.judging import Check, Meter, below, fact

LENGTH = 100_000


def long_chain(meter: Meter) -> Iterator[Check]:
    """A wave runs through equal bodies on equal shafts; the work per step grows as their number."""
    calls = []
    for n in (LENGTH // 100, LENGTH):
        run = meter.simulate(_chain(n), t=np.linspace(0.0, 50.0, 11), outputs=["j0.w", f"j{n - 1}.w", "j30.w"])
        calls.append(run.stats.rhs_calls)
        yield below(f"{n} bodies: energy drifts by", run.energy.residual, 1e-6)
        yield below("end moves at", float(np.abs(run[f"j{n - 1}.w"]).max()), 1e-3)
        yield fact(f"wave arrives at 30 with {np.abs(run['j30.w']).max():.3g} rad/s", np.abs(run["j30.w"]).max() > 0.1)
    yield fact(f"{calls[0]} and {calls[1]} right-hand sides", calls[0] == calls[1])


def _chain(n: int) -> gb.Drivetrain:
    """n bodies of J = 1 joined by shafts of k = 1; the first one turns at 1 rad/s."""
    rig = gb.Drivetrain("long chain")
    rig.chain(
        *(
            rig.add(f"j{i // 2}", gb.Inertia(J=1.0, w0=1.0 if i == 0 else 0.0)) if i % 2 == 0
            else rig.add(f"s{i // 2}", gb.Shaft(k=1.0))
            for i in range(2 * n - 1)
        )
    )  # fmt: skip
    return rig
