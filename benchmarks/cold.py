"""`python -m benchmarks.cold`: P1 from script to first result, each time in a fresh process; and the import."""

from __future__ import annotations

import json
import sys
import tempfile
from importlib import import_module
from pathlib import Path

from benchmarks.fresh import Stopwatch, in_fresh_process

WORDS = {
    "empty": "gearblocks, empty cache (core compiled too)",
    "cold": "gearblocks, core in the cache, model not",
    "warm": "gearblocks, sympy and jinja2 imported before; core in the cache, model not",
    "cached": "gearblocks, model in the cache",
    "numba": "numba + numbalsoda",
    "casadi": "casadi CVODES (interpreted)",
    "lambdify": "scipy DOP853 + lambdify",
}


def own(kind: str) -> dict[str, object]:
    """gearblocks: seconds of the import, then from the first block to the first result."""
    watch = Stopwatch()
    import gearblocks as gb

    imported = watch.read()
    if kind == "warm":
        for name in ("jinja2", "sympy"):
            import_module(name)
    import numpy as np

    from benchmarks.problems import p1

    watch = Stopwatch()
    gb.simulate(p1(), t=np.linspace(0.0, 0.02, 101)[1:], rtol=1e-6, method="dp8")
    return {"import": imported, "run": watch.read(), "sympy": "sympy" in sys.modules}


def peer(kind: str) -> dict[str, object]:
    """A peer: seconds of its imports, then from the equations to the first result."""
    watch = Stopwatch()
    if kind == "numba":
        import numbalsoda
    elif kind == "casadi":
        import casadi
    else:
        import scipy.integrate
    if kind != "casadi":
        import_module("sympy")
    imported = watch.read()
    import numpy as np

    from benchmarks import equations
    from benchmarks.cases import P1

    p, t = P1(), np.linspace(0.0, 0.02, 101)
    watch = Stopwatch()
    if kind == "numba":
        numbalsoda.lsoda(equations.numba_rates(p).address, p.start[:7], t, rtol=1e-7, atol=1e-10, mxstep=1_000_000)
    elif kind == "casadi":
        options = {"reltol": 1e-8, "abstol": 1e-11, "max_num_steps": 1_000_000}
        casadi.integrator("run", "cvodes", equations.casadi_rates(p), 0.0, t[1:].tolist(), options)(x0=p.start[:7])
    else:
        rhs = equations.lambdified(p)
        scipy.integrate.solve_ivp(rhs, (0.0, 0.02), p.start[:7], "DOP853", t[1:], rtol=1e-6, atol=1e-8)
    return {"import": imported, "run": watch.read(), "sympy": "sympy" in sys.modules}


def prepare_core() -> None:
    """Fills the cache with the compiled core by building a train that shares no law with P1."""
    import gearblocks as gb

    rig = gb.Drivetrain("any")
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("drag", gb.Damper(c=1.0)), rig.add("ground", gb.Fixed()))
    gb.build(rig)


def best_of(kind: str, repeats: int) -> dict[str, dict[str, float]]:
    """The run with the shortest wall time; every repetition starts from the cache that its kind asks for."""
    runs = []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as scratch:
            cache = Path(scratch)
            if kind in ("cold", "warm"):
                in_fresh_process("benchmarks.cold", "--one", "core", cache=cache)
            if kind == "cached":
                in_fresh_process("benchmarks.cold", "--one", "cold", cache=cache)
            runs.append(in_fresh_process("benchmarks.cold", "--one", kind, cache=cache))
    return min(runs, key=lambda figures: float(figures["run"]["wall"]))


def main() -> None:
    """Prints one row per way."""
    if sys.argv[1:2] == ["--one"]:
        kind = sys.argv[2]
        if kind == "core":
            prepare_core()
            print("{}")
        else:
            print(json.dumps(own(kind) if kind in ("empty", "cold", "warm", "cached") else peer(kind)))
        return
    from benchmarks.measure import machine  # not above: it imports numpy

    print(machine(), "\n\nSmallest of 3 fresh processes; P1 over 0.02 s.\n")
    print("| way | import s | equations to result s | CPU s with compiler | sympy imported |")
    print("|---|--:|--:|--:|---|")
    for kind, words in WORDS.items():
        try:
            f = best_of(kind, 3)
        except RuntimeError as error:
            print(f"| {words} | | | | {error} |", flush=True)
            continue
        run = f["run"]
        imported = f["import"]["wall"]
        print(f"| {words} | {imported:.3f} | {run['wall']:.3f} | {run['cpu']:.3f} | {'yes' if f['sympy'] else 'no'} |")


if __name__ == "__main__":
    main()
