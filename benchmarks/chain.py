"""Others' solvers on the stiff chain P4: rows of (what, CPU seconds, error, remark)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import scipy.sparse as sparse

from benchmarks.cases import P4, Array
from benchmarks.measure import cpu_seconds, relative_error

Row = tuple[str, float, float, str]


def vectors(p: P4) -> tuple[Array, Array, Array, Array]:
    """Stiffness, damping and half gap of each coupling and inertia of each disc."""
    k, c, gap = np.full(p.n, p.k_shaft), np.full(p.n, p.c_shaft), np.zeros(p.n)
    k[1:-1:2], c[1:-1:2], gap[1:-1:2] = p.k_mesh, p.c_mesh, p.half_gap
    return k, c, gap, np.where(np.arange(p.n) % 2, p.j_light, p.j_heavy)


def rates(p: P4) -> Callable[[float, Array], Array]:
    """f(t, y) with numpy, twists then speeds."""
    k, c, gap, inertia = vectors(p)
    n = p.n

    def f(t: float, y: Array) -> Array:
        twist, w = y[:n], y[n:]
        slip = w - np.append(w[1:], 0.0)
        torque = c * slip + k * (np.maximum(twist - gap, 0.0) + np.minimum(twist + gap, 0.0))
        into = np.concatenate([[p.torque * (1 + p.swing * np.sin(p.w * t))], torque[:-1]])
        return np.concatenate([slip, (into - torque) / inertia])

    return f


def jacobian(p: P4) -> Callable[[float, Array], Any]:
    """df/dy as a sparse matrix; the couplings out of contact lose their stiffness."""
    k, c, gap, inertia = vectors(p)
    slip = sparse.eye(p.n) - sparse.eye(p.n, k=1)
    forward = sparse.diags(1 / inertia) @ (sparse.eye(p.n, k=-1) - sparse.eye(p.n))
    damping = forward @ sparse.diags(c) @ slip

    def df(_t: float, y: Array) -> Any:
        stiffness = forward @ sparse.diags(np.where(np.abs(y[: p.n]) > gap, k, 0.0))
        return sparse.bmat([[None, slip], [stiffness, damping]], format="csc")

    return df


def scipy_rows(p: P4, t: Array, reference: Array, rtols: tuple[float, ...], method: str, words: str) -> Iterator[Row]:
    """One row per tolerance of a method of scipy's solve_ivp."""
    from scipy.integrate import solve_ivp

    run_ivp: Any = solve_ivp
    f = rates(p)
    more: dict[str, Any] = {"jac": jacobian(p)} if method == "Radau" else {}
    for rtol in rtols:
        options = more | {"rtol": rtol, "atol": rtol * p.scale, "t_eval": t}
        seconds, run = cpu_seconds(partial(run_ivp, f, (0.0, t[-1]), p.start, method=method, **options))
        error = relative_error(p.relative(run.y.T), reference)
        yield f"{words} {rtol:.0e}", seconds, error, f"{run.nfev} calls, {run.nlu} factorisations"


def radau(p: P4, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """scipy's Radau IIA of order 5 with the sparse analytic Jacobian."""
    return scipy_rows(p, t, reference, rtols, "Radau", "scipy Radau sparse")


def dop853(p: P4, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """scipy's DOP853 with numpy over the chain."""
    return scipy_rows(p, t, reference, rtols, "DOP853", "scipy DOP853 + numpy")


def casadi(p: P4, t: Array, reference: Array, rtols: tuple[float, ...]) -> Iterator[Row]:
    """CVODES through casadi with its sparse Jacobian."""
    import casadi as ca

    k, c, gap, inertia = vectors(p)
    time, y = ca.SX.sym("t"), ca.SX.sym("y", 2 * p.n)
    twist, w = y[: p.n], y[p.n :]
    slip = w - ca.vertcat(w[1:], 0)
    torque = c * slip + k * (ca.fmax(twist - gap, 0) + ca.fmin(twist + gap, 0))
    into = ca.vertcat(p.torque * (1 + p.swing * ca.sin(p.w * time)), torque[:-1])
    model = {"t": time, "x": y, "ode": ca.vertcat(slip, (into - torque) / inertia)}
    for rtol in rtols:
        options = {"reltol": rtol, "abstol": 1e-3 * rtol, "max_num_steps": 10_000_000}
        integrator = ca.integrator("run", "cvodes", model, 0.0, t.tolist(), options)
        seconds, run = cpu_seconds(partial(integrator, x0=p.start))
        yield f"casadi CVODES {rtol:.0e}", seconds, relative_error(p.relative(np.array(run["xf"]).T), reference), ""
