"""`python -m benchmarks.p1 [SECONDS ...]`: P1 over 0.02 s and over 1 s, gearblocks and its peers."""

from __future__ import annotations

import sys

import numpy as np

from benchmarks import peers
from benchmarks.cases import P1, Array
from benchmarks.measure import Table, attempt, machine
from benchmarks.native import reference
from benchmarks.problems import ours

PROBLEM = P1()


def table(t_end: float, samples: int) -> Table:
    """One window: every run writes the same samples."""
    t: Array = np.linspace(0.0, t_end, samples + 1)[1:]
    known = reference(PROBLEM, t)
    result = Table(f"P1, {t_end:g} s, {samples} samples ({known.words})")
    y, short = known.y, t_end < 0.1
    attempt(result, "gearblocks", lambda: ours(PROBLEM, t, y, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10), "dp8"))
    attempt(result, "hand-written C", lambda: peers.hand_written(PROBLEM, t, y, (1e-4, 1e-6, 1e-8, 1e-10)))
    attempt(result, "numbalsoda", lambda: peers.numbalsoda(PROBLEM, t, y, (1e-6, 1e-8)))
    attempt(result, "casadi CVODES", lambda: peers.casadi(PROBLEM, t, y, (1e-8, 1e-10) if short else (1e-8,)))
    if short:
        attempt(result, "scipy DOP853 + lambdify", lambda: peers.scipy_dop853(PROBLEM, t, y, (1e-6,)))
    else:
        result.missing("scipy DOP853 + lambdify", "50 times the row of 0.02 s, not run")
    return result


def main() -> None:
    """Prints a table per window."""
    print(machine(), "\n")
    for t_end in [float(a) for a in sys.argv[1:]] or [0.02, 1.0]:
        print(table(t_end, 1000 if t_end > 0.1 else 100).text())


if __name__ == "__main__":
    main()
