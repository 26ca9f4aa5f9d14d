"""The hand-written C peer, CVODE with KLU, and the references: compiles c/*.c with `cc` and calls it.

The reference is the hand-written C in extended precision at a tolerance far below; two tolerances must agree, and
CVODE, which shares nothing with it but the right-hand side, must come close.
"""

from __future__ import annotations

import atexit
import ctypes
import shutil
import subprocess
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.cases import P3, P4, Array, Problem
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
    libraries = [flag for flag in more if flag.startswith("-l")]
    command = ["cc", *FLAGS, *more, "-fPIC", "-shared", str(source), "-o", str(target), *libraries, "-lm"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    if run.returncode:
        raise RuntimeError(f"{name}: cc failed: {next((x for x in run.stderr.splitlines() if 'error' in x), '')}")
    return ctypes.CDLL(str(target))


def solve(problem: Problem, t: Array, rtol: float, *, extended: bool = False) -> Solved:
    """Order 8 with located corners through the samples t (seconds, increasing), from the problem's start."""
    name = type(problem).__name__.lower()
    run = getattr(library(name, *(("-DEXTENDED",) if extended else ())), f"{name}_solve")
    start, scale, packed, side = problem.start, problem.scale, problem.packed(), problem.sides
    y, count = np.empty((len(t), len(start))), np.zeros(4, dtype=np.int_)
    first = 1e-2 if name == "p2" else 1e-7
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


SUNDIALS = (
    "-I/usr/include/suitesparse",
    "-lsundials_cvode",
    "-lsundials_sunlinsolklu",
    "-lsundials_sunmatrixsparse",
    "-lsundials_nvecserial",
)


@dataclass(frozen=True)
class Cvode:
    """States at the samples (rows) and the counters of a run of CVODE."""

    y: Array
    steps: int
    failed: int
    rates: int
    jacobians: int


def cvode(problem: P3 | P4, t: Array, rtol: float) -> Cvode:
    """CVODE with KLU through the samples t. Raises ModuleNotFoundError where SUNDIALS is not installed."""
    name = type(problem).__name__.lower()
    try:
        run = getattr(library(name, "-DWITH_CVODE", *SUNDIALS), f"{name}_cvode")
    except RuntimeError as error:
        raise ModuleNotFoundError(str(error), name="SUNDIALS with KLU (libsundials-dev)") from error
    states = 13 if isinstance(problem, P3) else len(problem.start)
    start, scale, packed = problem.start[:states], problem.scale[:states], problem.packed()
    y, count = np.empty((len(t), states)), np.zeros(4, dtype=np.int_)
    failed = run(
        *(pointer(a) for a in (packed, start, scale)),
        ctypes.c_double(rtol),
        ctypes.c_int(len(t)),
        *(pointer(a) for a in (t, y)),
        ctypes.c_void_p(count.ctypes.data),
    )
    if failed:
        raise RuntimeError(f"{name}: CVODE " + ("could not be set up", "gave up")[failed - 1])
    return Cvode(y, *(int(c) for c in count))


@dataclass(frozen=True)
class Reference:
    """States at the samples, how far two tolerances disagree (largest relative error), and CVODE at 1e-11 if asked."""

    y: Array
    agreement: float
    other: float = float("nan")

    @property
    def words(self) -> str:
        """How far the reference can be trusted."""
        beside = "" if self.other != self.other else f", CVODE at 1e-11 to {self.other:.0e}"
        return f"two references agree to {self.agreement:.0e}{beside}"


def reference(
    problem: Problem, t: Array, rtol: float = 1e-14, *, extended: bool = True, checked: bool = False
) -> Reference:
    """The problem at rtol (in extended precision if so asked), checked against 30 times rtol and against CVODE."""
    fine, coarse = (problem.relative(solve(problem, t, r, extended=extended).y) for r in (rtol, 30 * rtol))
    other = float("nan")
    if checked and isinstance(problem, P3 | P4):
        with suppress(ModuleNotFoundError):
            other = relative_error(problem.relative(cvode(problem, t, 1e-11).y), fine)
    return Reference(fine, relative_error(coarse, fine), other)
