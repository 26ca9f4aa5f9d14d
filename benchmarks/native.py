"""The hand-written C peer and the references: compiles c/*.c with `cc` and calls it.

The reference is the same C in extended precision at a tolerance far below; two tolerances must agree.
"""

from __future__ import annotations

import atexit
import ctypes
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.cases import P1, P2, P4, Array
from benchmarks.measure import relative_error

FLAGS = (
    "-std=c99",
    "-O3",
    "-march=native",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-tree-slp-vectorize",
)
SOURCES = Path(__file__).parent / "c"


@dataclass(frozen=True)
class Solved:
    """States at the samples (rows) and the counters of the run."""

    y: Array
    steps: int
    rejected: int
    rates: int
    corners: int


def pointer(a: Array) -> ctypes.c_void_p:
    """The address of a contiguous array of doubles."""
    assert a.dtype == np.float64 and a.flags.c_contiguous
    return ctypes.c_void_p(a.ctypes.data)


@cache
def folder() -> Path:
    """A scratch folder that lives as long as the process."""
    path = tempfile.mkdtemp(prefix="benchmarks-")
    atexit.register(shutil.rmtree, path, ignore_errors=True)
    return Path(path)


@cache
def library(name: str, *more: str) -> ctypes.CDLL:
    """The shared object of c/<name>.c, built with FLAGS and more."""
    target = folder() / f"{name}{len(list(folder().iterdir()))}.so"
    source = SOURCES / f"{name}.c"
    command = ["cc", *FLAGS, *more, "-fPIC", "-shared", str(source), "-o", str(target), "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(target))


def solve(problem: P1 | P2 | P4, t: Array, rtol: float, *, extended: bool = False) -> Solved:
    """Order 8 with located corners through the samples t (seconds, increasing), from the problem's start."""
    name = type(problem).__name__.lower()
    run = getattr(library(name, *(("-DEXTENDED",) if extended else ())), f"{name}_solve")
    start, scale, packed = problem.start, problem.scale, problem.packed()
    side = np.ones(max(1, len(start) // 4))
    y, count = np.empty((len(t), len(start))), np.zeros(4, dtype=np.int_)
    first = {"p1": 1e-7, "p2": 1e-2, "p4": 1e-7}[name]
    failed = run(
        *(pointer(a) for a in (packed, start, side, scale)),
        ctypes.c_double(first),
        ctypes.c_double(rtol),
        ctypes.c_int(len(t)),
        *(pointer(a) for a in (t, y)),
        ctypes.c_void_p(count.ctypes.data),
    )
    if failed:
        raise RuntimeError(f"{name}: " + ("no memory", "the step size fell below rounding")[failed - 1])
    return Solved(y, *(int(c) for c in count))


@dataclass(frozen=True)
class Reference:
    """States at the samples and how far two tolerances disagree (largest relative error)."""

    y: Array
    agreement: float


def reference(
    problem: P1 | P2 | P4, t: Array, coordinates: slice, rtol: float = 1e-14, *, extended: bool = True
) -> Reference:
    """The problem at rtol (in extended precision if so asked), checked against 30 times rtol."""
    fine = solve(problem, t, rtol, extended=extended).y
    coarse = solve(problem, t, 30 * rtol, extended=extended).y
    return Reference(fine, relative_error(coarse[:, coordinates], fine[:, coordinates]))
