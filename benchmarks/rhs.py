"""`python -m benchmarks.rhs [CALLS]`: one right-hand side of P1 - generated, by hand in C at equal flags, by lambdify."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from importlib import resources

import numpy as np

from benchmarks.cases import P1, Array
from benchmarks.equations import lambdified
from benchmarks.measure import cpu_seconds, machine
from benchmarks.native import FLAGS, SOURCES, folder, pointer

PROBLEM = P1()
OTHER = tuple(f for f in FLAGS if f not in ("-O3", "-march=native"))
SETS = {
    "-O3 -march=native, contraction off": FLAGS,
    "-O3 -march=native, contraction on": (*FLAGS, "-ffp-contract=fast"),
    "-O2, contraction off": (*OTHER, "-O2"),
}


def measured(source: str, values: Array, flags: tuple[str, ...], calls: int) -> Array:
    """ns per call: by hand with cos(w t) given and at a time, generated rhs, rhs_full, time terms of an instant."""
    place = folder()
    (place / "model.c").write_text(source, encoding="utf8")
    target = place / f"rhs{len(list(place.iterdir()))}.so"
    include = resources.files("gearblocks.solver") / "c"
    files = [str(SOURCES / "rhs.c"), str(SOURCES / "p1_rates.c"), str(place / "model.c")]
    command = ["cc", *flags, "-fPIC", "-shared", "-I", str(include), *files, "-o", str(target), "-lm"]
    subprocess.run(command, check=True)
    out, by_hand = np.zeros(64), np.zeros(8)
    n = ctypes.CDLL(str(target)).measure_p1(
        *(pointer(a) for a in (PROBLEM.packed(), PROBLEM.start)),
        *(pointer(a) for a in (by_hand, np.ascontiguousarray(values, dtype=np.float64))),
        ctypes.c_long(calls),
        pointer(out),
    )
    if n < 0:
        raise MemoryError
    # Both start in static equilibrium at t = 0, so the largest accelerations must agree however states are ordered.
    if not np.isclose(np.max(np.abs(out[5 : 5 + n])), np.max(np.abs(by_hand)), rtol=1e-9):
        raise RuntimeError("the generated and the hand-written right-hand side differ")
    return out[:5]


def main() -> None:
    """Prints ns per call and the ratio to the code by hand for each set of flags."""
    print(machine(), "\n")
    calls = int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000
    f, y = lambdified(PROBLEM), PROBLEM.start[:7]

    def many() -> None:
        for _ in range(2000):
            f(0.0, y)

    print(f"lambdify: {cpu_seconds(many)[0] / 2000 * 1e9:,.0f} ns a call\n")
    import gearblocks as gb
    from benchmarks.problems import p1

    model = gb.build(p1(PROBLEM))
    print("ns a call (smallest of 7 rounds); cos given: the time terms are known, as in a step of the solver\n")
    print(
        "| flags | by hand, cos given | generated | ratio | by hand, cos | generated + columns | ratio | with ledger |"
    )
    print("|---|--:|--:|--:|--:|--:|--:|--:|")
    for words, flags in SETS.items():
        hand, at, rhs, full, columns = measured(model.program.source, model.values, flags, calls)
        whole = rhs + columns
        cells = [words, f"{hand:.1f}", f"{rhs:.1f}", f"{rhs / hand:.2f}", f"{at:.1f}", f"{whole:.1f}"]
        print("| " + " | ".join([*cells, f"{whole / at:.2f}", f"{full:.1f}"]) + " |")


if __name__ == "__main__":
    main()
