"""`python -m benchmarks.lanes [PERIODS]`: P2 for 1024 frequencies by 200 fixed steps a period, in steps a second.

Lanes of gearblocks (from blocks; with the peak of the deflection looked at after every step, and without), a loop over vectors
by hand in C, the scalar solver of gearblocks, and numpy over all points at once. Wall time of two threads beside that of one.
"""

from __future__ import annotations

import ctypes
import sys
import time

import numpy as np

from benchmarks.cases import P2, Array
from benchmarks.measure import cpu_seconds, machine
from benchmarks.native import FLAGS, library, pointer
from benchmarks.problems import p2

PROBLEM = P2()
PER_PERIOD = 200
W: Array = np.linspace(0.4, 1.4, 1024)
STEP: Array = 2 * np.pi / W / PER_PERIOD


def by_hand(periods: int) -> Array:
    """Last states by the hand-written loop."""
    p, out = PROBLEM, np.zeros((len(W), 2))
    sweep = library("p2_sweep").p2_sweep
    for first in range(0, len(W), 32):
        w, part = np.ascontiguousarray(W[first : first + 32]), np.zeros((32, 2))
        numbers = (ctypes.c_double(x) for x in (p.zeta, p.eps, p.load, p.swing, p.x0))
        sweep(pointer(w), *numbers, ctypes.c_long(periods), ctypes.c_long(PER_PERIOD), pointer(part))
        out[first : first + 32] = part
    return out


def by_numpy(periods: int) -> Array:
    """The same in numpy over all points."""
    p, x, v = PROBLEM, np.full(len(W), PROBLEM.x0), np.zeros(len(W))

    def rate(t: Array, x: Array, v: Array) -> Array:
        wave = np.cos(W * t)
        return p.load + p.swing * W**2 * wave - 2 * p.zeta * v - (1 + p.eps * wave) * (x - np.clip(x, -1, 1))

    for i in range(periods * PER_PERIOD):
        t, h = i * STEP, STEP
        b1 = rate(t, x, v)
        v2, b2 = v + h / 2 * b1, rate(t + h / 2, x + h / 2 * v, v + h / 2 * b1)
        v3, b3 = v + h / 2 * b2, rate(t + h / 2, x + h / 2 * v2, v + h / 2 * b2)
        v4, b4 = v + h * b3, rate(t + h, x + h * v3, v + h * b3)
        x, v = x + h / 6 * (v + 2 * (v2 + v3) + v4), v + h / 6 * (b1 + 2 * (b2 + b3) + b4)
    return np.column_stack([x, v])


def main() -> None:
    """Prints the table."""
    import gearblocks as gb
    from gearblocks.solver.lanes import Lanes, LaneSteps

    periods = int(sys.argv[1]) if len(sys.argv) > 1 else 500
    steps, model = periods * PER_PERIOD, gb.build(p2())
    rows = np.tile(model.values, (len(W), 1))
    rows[:, model.program.parameter_numbers["w"]] = W
    lanes = Lanes(model, [model.program.output_numbers["mesh.deflection"]])
    inputs, every = np.zeros(0), LaneSteps(steps=steps, period=PER_PERIOD)
    final = LaneSteps(steps=steps, period=PER_PERIOD, first=steps - 1)
    print(machine(), "\n")
    print(f"### P2, {len(W)} frequencies, {periods} periods of {PER_PERIOD} steps, {' '.join(FLAGS[1:4])}\n")
    print("| run | steps/s and core | x hand-written | remark |\n|---|--:|--:|---|")
    hand, states = cpu_seconds(lambda: by_hand(periods), repeats=3)
    ours, found = cpu_seconds(lambda: lanes.run(rows, STEP, inputs, final), repeats=3)
    peaks, _ = cpu_seconds(lambda: lanes.run(rows, STEP, inputs, every), repeats=3)
    one, two = (_wall(lambda n=n: lanes.run(rows, STEP, inputs, final, threads=n)) for n in (1, 2))
    k = len(W) // 3
    scalar, run = cpu_seconds(lambda: _scalar(model, k, min(steps, 20000)), repeats=3)
    same = lanes.run(rows, STEP, inputs, LaneSteps(steps=min(steps, 20000), stride=1)).samples[k, :, 0]
    vectors, _ = cpu_seconds(lambda: by_numpy(2), repeats=1)
    near = float(np.median(abs(found.last - states).max(axis=1)))
    count = steps * len(W)
    _row("hand-written C", count / hand, hand, hand, "two chains of 16 lanes, excitation tabulated")
    _row(
        "gearblocks, lanes",
        count / ours,
        hand,
        ours,
        f"two threads {one / two:.2f} x; median off by hand's by {near:.0e}",
    )
    _row("gearblocks, lanes, peak after every step", count / peaks, hand, peaks, "largest, least, mean, rms")
    bits = "equal bits" if np.array_equal(same, run["mesh.deflection"]) else "BITS DIFFER"
    scaled = scalar * count / min(steps, 20000)
    _row("gearblocks, scalar rk4", count / scaled, hand, scaled, f"with ledger and events; {bits} to the lanes")
    scaled = vectors * periods / 2
    _row("numpy over all points", count / scaled, hand, scaled, "2 periods")


def _scalar(model: object, k: int, steps: int) -> object:
    import gearblocks as gb

    t = np.arange(steps + 1) * STEP[k]
    return gb.simulate(
        model, t=t, method="rk4", step=STEP[k], locate=False, parameters={"w": W[k]}, outputs=["mesh.deflection"]
    )


def _wall(work: object) -> float:
    best = float("inf")
    for _ in range(3):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return best


def _row(what: str, rate: float, hand: float, seconds: float, remark: str) -> None:
    print(f"| {what} | {rate:.3g} | {hand / seconds:.2f} | {remark} |")


if __name__ == "__main__":
    main()
