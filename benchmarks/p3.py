"""`python -m benchmarks.p3 [SECONDS]`: a planetary set with four planets and eight meshes with backlash, 0.02 s."""

from __future__ import annotations

import sys

import numpy as np

from benchmarks import peers
from benchmarks.cases import P3, Array
from benchmarks.measure import Table, attempt, machine
from benchmarks.native import reference
from benchmarks.problems import ours

PROBLEM = P3()


def main() -> None:
    """Prints the table."""
    print(machine(), "\n")
    t_end = float(sys.argv[1]) if sys.argv[1:] else 0.02
    t: Array = np.linspace(0.0, t_end, 101)[1:]
    known = reference(PROBLEM, t, checked=True)
    result = Table(f"P3, {t_end:g} s, 100 samples ({known.words})")
    y = known.y
    attempt(result, "gearblocks", lambda: ours(PROBLEM, t, y, (1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-10), "dp8"))
    attempt(result, "gearblocks auto", lambda: ours(PROBLEM, t, y, (1e-6,), "auto"))
    attempt(result, "hand-written C", lambda: peers.hand_written(PROBLEM, t, y, (1e-4, 1e-6, 1e-8, 1e-10)))
    attempt(result, "CVODE + KLU", lambda: peers.cvode_klu(PROBLEM, t, y, (1e-6, 1e-7, 1e-8)))
    attempt(result, "numbalsoda", lambda: peers.numbalsoda(PROBLEM, t, y, (1e-6, 1e-8)))
    attempt(result, "casadi CVODES", lambda: peers.casadi(PROBLEM, t, y, (1e-8,)))
    attempt(result, "scipy DOP853 + lambdify", lambda: peers.scipy_dop853(PROBLEM, t, y, (1e-6,)))
    print(result.text())


if __name__ == "__main__":
    main()
