"""Others' solvers on P1, P2 and P3, each at several tolerances: rows of (what, CPU seconds, error, remark)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from benchmarks.cases import P1, P2, P3, P4, Array, Problem
from benchmarks.equations import casadi_rates, lambdified, numba_rates
from benchmarks.measure import cpu_seconds, relative_error
from benchmarks.native import cvode, solve

Row = tuple[str, float, float, str]


def states(problem: P1 | P2 | P3) -> int:
    """Number of states without the padding of the C code."""
    return {P1: 7, P2: 2, P3: 13}[type(problem)]


def hand_written(problem: Problem, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """The C of this folder: order 8, located corners."""
    for rtol in rtols:
        seconds, run = cpu_seconds(partial(solve, problem, t, rtol))
        remark = f"{run.steps} steps, {run.rejected} rejected, {run.corners} corners, no ledger"
        yield f"hand-written C {rtol:.0e}", seconds, relative_error(problem.relative(run.y), reference), remark


def cvode_klu(problem: P3 | P4, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """SUNDIALS' CVODE with a sparse analytic Jacobian and KLU, all in C."""
    for rtol in rtols:
        seconds, run = cpu_seconds(partial(cvode, problem, t, rtol))
        remark = f"{run.steps} steps, {run.failed} failed, {run.rates} calls, {run.jacobians} Jacobians"
        yield f"CVODE + KLU {rtol:.0e}", seconds, relative_error(problem.relative(run.y), reference), remark


def scipy_dop853(problem: P1 | P2 | P3, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """scipy's DOP853 with a right-hand side from sympy.lambdify."""
    from scipy.integrate import solve_ivp

    n = states(problem)
    f = lambdified(problem)
    for rtol in rtols:
        options: dict[str, Any] = {"method": "DOP853", "rtol": rtol, "atol": rtol * problem.scale[:n], "t_eval": t}
        seconds, run = cpu_seconds(partial(solve_ivp, f, (0.0, t[-1]), problem.start[:n], **options))
        yield (
            f"scipy DOP853 + lambdify {rtol:.0e}",
            seconds,
            relative_error(problem.relative(run.y.T), reference),
            (f"{run.nfev} calls"),
        )


def numbalsoda(problem: P1 | P2 | P3, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """numbalsoda's LSODA and DOP853 with a right-hand side compiled by numba."""
    from numbalsoda import dop853, lsoda

    n = states(problem)
    address = numba_rates(problem).address
    times = np.concatenate([[0.0], t])
    for name, solver in (("LSODA", lsoda), ("DOP853", dop853)):
        for rtol in rtols:
            options = {"rtol": rtol, "atol": 1e-3 * rtol, "mxstep": 1_000_000_000}
            solver(address, problem.start[:n], times[:2], **options)  # compiles
            seconds, (y, fine) = cpu_seconds(partial(solver, address, problem.start[:n], times, **options))
            error = relative_error(problem.relative(y[1:]), reference)
            yield f"numbalsoda {name} {rtol:.0e}", seconds, error, "" if fine else "reports failure"


def casadi(problem: P1 | P2 | P3, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """CVODES through casadi, backward differentiation formulas with its own Jacobian."""
    import casadi as ca

    n = states(problem)
    model = casadi_rates(problem)
    for rtol in rtols:
        options = {"reltol": rtol, "abstol": 1e-3 * rtol, "max_num_steps": 100_000_000}
        integrator = ca.integrator("run", "cvodes", model, 0.0, t.tolist(), options)
        seconds, run = cpu_seconds(partial(integrator, x0=problem.start[:n]))
        error = relative_error(problem.relative(np.array(run["xf"]).T), reference)
        yield f"casadi CVODES {rtol:.0e}", seconds, error, ""
