"""`python -m benchmarks.p4 [--seconds S] [N ...]`: a stiff chain of N inertias, without and with hits on both sides."""

from __future__ import annotations

import argparse

import numpy as np

from benchmarks import chain, peers
from benchmarks.cases import P4, Array
from benchmarks.measure import Table, attempt, machine, relative_error
from benchmarks.native import Reference, cvode, reference
from benchmarks.problems import ours

LONG = 20_000
"""Beyond this length the explicit reference takes minutes; CVODE at 1e-9 against 1e-8 serves instead."""


def known(problem: P4, t: Array) -> Reference:
    """The reference: order 8 with located corners, in extended precision for short chains."""
    if problem.n > LONG:
        fine, coarse = (problem.relative(cvode(problem, t, rtol).y) for rtol in (1e-9, 1e-8))
        return Reference(fine, relative_error(coarse, fine))
    extended = problem.n <= 300
    return reference(problem, t, 1e-14 if extended else 1e-12, extended=extended, checked=problem.n <= 300)


def table(n: int, seconds: float, swing: float = 0.5) -> Table:
    """One length of chain; with a swing of 1.5 the meshes hit both sides."""
    problem = P4(n=n, swing=swing, t_end=seconds)
    t: Array = np.linspace(0.0, problem.t_end, 51)[1:]
    reference = known(problem, t)
    y, hits = reference.y, swing > 1
    result = Table(f"P4, N = {n}, swing {swing:g}, {problem.t_end:g} s, 50 samples ({reference.words})")
    if n <= 1000:
        attempt(result, "gearblocks dp8", lambda: ours(problem, t, y, (1e-5, 1e-8), "dp8"))
    attempt(result, "gearblocks rodas", lambda: ours(problem, t, y, (1e-3, 3e-4, 1e-4, 1e-6), "rodas"))
    attempt(result, "gearblocks auto", lambda: ours(problem, t, y, (1e-3, 1e-6), "auto"))
    if n <= 1000:
        attempt(result, "hand-written C", lambda: peers.hand_written(problem, t, y, (1e-5, 1e-8)))
    if not hits or n <= 300:
        attempt(result, "CVODE + KLU", lambda: peers.cvode_klu(problem, t, y, (1e-6, 1e-7)))
    if n <= 300:
        attempt(result, "scipy DOP853 + numpy", lambda: chain.dop853(problem, t, y, (1e-6,)))
    if n <= 1000 and not hits:
        attempt(result, "scipy Radau sparse", lambda: chain.radau(problem, t, y, (1e-4, 1e-6)))
        attempt(result, "casadi CVODES", lambda: chain.casadi(problem, t, y, (1e-6,)))
    return result


def main() -> None:
    """Prints one table per length."""
    print(machine(), "\n")
    parser = argparse.ArgumentParser()
    parser.add_argument("n", type=int, nargs="*")
    parser.add_argument("--seconds", type=float, default=0.1)
    given = parser.parse_args()
    for n in given.n or [100, 1000, 10_000, 100_000]:
        print(table(n, given.seconds).text(), flush=True)
        if n <= 1000:
            print(table(n, given.seconds, 1.5).text(), flush=True)


if __name__ == "__main__":
    main()
