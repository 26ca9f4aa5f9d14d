"""`python -m benchmarks.p4 [N ...]`: a stiff chain of N inertias (100 and 1000), and 100 with hits on both sides."""

from __future__ import annotations

import sys

import numpy as np

from benchmarks import chain, peers
from benchmarks.cases import P4, Array
from benchmarks.measure import Table, attempt, machine
from benchmarks.native import reference
from benchmarks.problems import ours


def table(n: int, swing: float = 0.5) -> Table:
    """One length of chain; with a swing of 1.5 the meshes hit both sides."""
    problem = P4(n=n, swing=swing)
    t: Array = np.linspace(0.0, problem.t_end, 51)[1:]
    extended = n <= 300
    rtol = 1e-14 if extended else 1e-12
    known = reference(problem, t, peers.coordinates(problem), rtol, extended=extended)
    y = known.y
    result = Table(
        f"P4, N = {n}, swing {swing:g}, {problem.t_end:g} s, 50 samples (two references agree to {known.agreement:.0e})"
    )
    attempt(result, "gearblocks rodas", lambda: ours(problem, t, y, (1e-3, 3e-4, 1e-6), "rodas"))
    attempt(result, "gearblocks auto", lambda: ours(problem, t, y, (1e-3, 1e-6), "auto"))
    attempt(result, "gearblocks dp8", lambda: ours(problem, t, y, (1e-5, 1e-8), "dp8"))
    attempt(result, "hand-written C", lambda: peers.hand_written(problem, t, y, (1e-5, 1e-8)))
    attempt(result, "scipy Radau sparse", lambda: chain.radau(problem, t, y, (1e-4, 1e-6)))
    attempt(result, "casadi CVODES", lambda: chain.casadi(problem, t, y, (1e-6,)))
    if n <= 300:
        attempt(result, "scipy DOP853 + numpy", lambda: chain.dop853(problem, t, y, (1e-6,)))
    return result


def main() -> None:
    """Prints one table per length."""
    print(machine(), "\n")
    for n in [int(a) for a in sys.argv[1:]] or [100, 1000]:
        print(table(n).text(), flush=True)
    if not sys.argv[1:]:
        print(table(100, 1.5).text())


if __name__ == "__main__":
    main()
