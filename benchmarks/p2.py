"""`python -m benchmarks.p2`: P2 over 100 periods of the excitation, gearblocks and its peers."""

from __future__ import annotations

import numpy as np

from benchmarks import peers
from benchmarks.cases import P2, Array
from benchmarks.measure import Table, attempt, machine
from benchmarks.native import reference
from benchmarks.problems import ours

PROBLEM = P2()


def main() -> None:
    """Prints the table."""
    print(machine(), "\n")
    t: Array = PROBLEM.period * np.arange(1.0, PROBLEM.periods + 1.0)
    known = reference(PROBLEM, t)
    result = Table(f"P2, {PROBLEM.periods} periods, one sample each ({known.words})")
    y = known.y
    attempt(result, "gearblocks", lambda: ours(PROBLEM, t, y, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10), "dp8"))
    attempt(result, "hand-written C", lambda: peers.hand_written(PROBLEM, t, y, (1e-4, 1e-6, 1e-8, 1e-10)))
    attempt(result, "numbalsoda", lambda: peers.numbalsoda(PROBLEM, t, y, (1e-6, 1e-8, 1e-10)))
    attempt(result, "casadi CVODES", lambda: peers.casadi(PROBLEM, t, y, (1e-8, 1e-10)))
    attempt(result, "scipy DOP853 + lambdify", lambda: peers.scipy_dop853(PROBLEM, t, y, (1e-6,)))
    print(result.text())


if __name__ == "__main__":
    main()
