"""`python -m benchmarks.locks [N ...]`: rows of N clutches over 0.01 s, and four lasting locks beside the rigid train."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import gearblocks as gb

COUNTS = (50, 100, 200, 500, 1000)
REPEATS = 5


def row(count: int, capacity: float) -> gb.Drivetrain:
    """A torque of 100 sin(500 t) on a row of equal bodies with clutches between."""
    rig = gb.Drivetrain("row of clutches")
    parts = [rig.add("drive", gb.Torque(tau=100.0 * gb.sin(500 * gb.time))), rig.add("b0", gb.Inertia(J=1.0))]
    for i in range(count):
        parts += [rig.add(f"c{i}", gb.Clutch(capacity=capacity)), rig.add(f"b{i + 1}", gb.Inertia(J=1.0))]
    rig.chain(*parts)
    return rig


def six(lock: Callable[[], gb.Block]) -> gb.Drivetrain:
    """Six bodies, one spring, four locks."""
    rig = gb.Drivetrain("six bodies")
    parts = [rig.add("drive", gb.Torque(tau=gb.sin(5 * gb.time))), rig.add("J0", gb.Inertia(J=1.0))]
    for i in range(5):
        parts.append(rig.add(f"s{i}", gb.Shaft(k=1e4) if i == 0 else lock()))
        parts.append(rig.add(f"J{i + 1}", gb.Inertia(J=1.0)))
    rig.chain(*parts)
    return rig


def cost(rig: gb.Drivetrain, t_end: float, method: str = "auto") -> tuple[float, int]:
    """Smallest solver time of a few runs in ms, and its steps."""
    model = gb.build(rig)
    runs = [gb.simulate(model, t=[0.0, t_end], method=method).stats for _ in range(REPEATS)]
    return 1e3 * min(stats.cpu_seconds for stats in runs), runs[0].steps


def main(counts: tuple[int, ...]) -> None:
    """Prints both tables."""
    print("| clutches | all stuck, ms a step | growth | one breaks, ms | growth |\n|--:|--:|--:|--:|--:|")
    before: tuple[int, float, float] | None = None
    for count in counts:
        stuck, steps = cost(row(count, 1e6), 0.01)
        breaks, _ = cost(row(count, 10.0), 0.01)
        powers = ["", ""]
        if before is not None:
            ratio = math.log(count / before[0])
            powers = [
                f"N^{math.log(now / then) / ratio:.1f}" for now, then in ((stuck, before[1]), (breaks, before[2]))
            ]
        print(f"| {count} | {stuck / steps:.4f} | {powers[0]} | {breaks:.2f} | {powers[1]} |")
        before = (count, stuck, breaks)
    print("\n| 2 s of six bodies | locked, ms | rigid, ms | ratio |\n|---|--:|--:|--:|")
    for method in ("auto", "dp8", "dp5", "rodas"):
        locked, _ = cost(six(lambda: gb.Clutch(capacity=1e3)), 2.0, method)
        rigid, _ = cost(six(lambda: gb.Shaft(rigid=True)), 2.0, method)
        print(f"| {method} | {locked:.3f} | {rigid:.3f} | {locked / rigid:.2f} |")


if __name__ == "__main__":
    main(tuple(int(x) for x in sys.argv[1:]) or COUNTS)
