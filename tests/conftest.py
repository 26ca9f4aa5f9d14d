"""An independent integrator for hand-derived equations (scipy's DOP853, stopped at every corner), and the tiers."""

from __future__ import annotations

import gc
import os
import shutil
import sys
from collections.abc import Callable, Generator, Iterable
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import HealthCheck, settings
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp

Array: TypeAlias = NDArray[np.float64]
Rates: TypeAlias = Callable[[float, Array, Array], ArrayLike]
Surfaces: TypeAlias = Callable[[float, Array], ArrayLike]


def pytest_configure(config: pytest.Config) -> None:
    """Most of the time of the quick tier would be that of compilers. C: generated laws and FMUs are not optimised, the bits are
    the same (unless CC names a level). Python: what is compiled is kept for the other workers and for the processes that tests
    start, whatever PYTHONDONTWRITEBYTECODE says. Every random test draws a quarter of its examples."""
    if "not long" in config.getoption("markexpr"):
        compiler = os.environ.get("CC", "").strip() or ("cc" if shutil.which("cc") else "")
        if compiler and " -O" not in compiler:
            os.environ["CC"] = f"{compiler} -O0"
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        sys.dont_write_bytecode = False
        busy = (HealthCheck.too_slow,)  # tells of the machine, not of the test
        settings.register_profile("quick", max_examples=25, suppress_health_check=busy)
        settings.load_profile("quick")


def pytest_collection_finish() -> None:
    """What has been collected stays: nobody has to look for garbage in it."""
    gc.freeze()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Every other worker reads the files from the last one on: what one has compiled the others need not."""
    report = yield
    if isinstance(collector, pytest.Directory) and os.environ.get("PYTEST_XDIST_WORKER", "gw0")[-1] in "13579":
        report.result = [*reversed(report.result or ())]
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of the cases of a test that is marked few(n), all but n are long. All workers have the tests in the same order."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        items.sort(key=lambda item: item.path.parts)
    for item in beyond_the_few(items):
        item.add_marker(pytest.mark.long)


def beyond_the_few(items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """The cases of tests marked few(n) that are neither long nor among the n."""
    cases: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker("few") and not item.get_closest_marker("long"):
            cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
    left = []
    for found in cases.values():
        mark = found[0].get_closest_marker("few")
        assert mark is not None
        left += [item for i, item in enumerate(found) if i not in diagonal(len(found), *mark.args)]
    return left


def diagonal(number: int, n: int) -> set[int]:
    """n of the places 0 to number - 1: one in each n-th part, at another place in every part, so that of cases which are
    products of parameters not always the same values of the last one are taken."""
    parts = ((i * number // n, (i + 1) * number // n) for i in range(n))
    return {low + i % (high - low) for i, (low, high) in enumerate(parts) if high > low}


def _integrate(
    rates: Rates, y0: ArrayLike, t: ArrayLike, surfaces: Surfaces = lambda t, y: (), *, max_step: float = np.inf
) -> Array:
    """Rows of y at the times t. rates(t, y, modes): modes[i] is +1 or -1, the side of surfaces(t, y)[i], frozen between
    corners; a run stops and restarts at each. rtol 1e-12, atol 1e-15."""
    t = np.asarray(t, dtype=float)
    y = np.array(y0, dtype=float)
    at, end = float(t[0]), float(t[-1])
    modes = np.where(np.asarray(surfaces(at, y), dtype=float) >= 0, 1.0, -1.0)
    rows = np.empty((len(t), len(y)))
    while True:
        events = []
        for i in range(len(modes)):

            def event(time: float, state: Array, i: int = i) -> float:
                return float(np.asarray(surfaces(time, state))[i])

            event.terminal, event.direction = True, -modes[i]
            events.append(event)
        found = solve_ivp(
            lambda time, state: np.asarray(rates(time, state, modes)), (at, end), y, "DOP853", dense_output=True,
            events=events or None, rtol=1e-12, atol=1e-15, max_step=max_step,
        )  # fmt: skip
        inside = (t >= at) & (t <= found.t[-1])
        if inside.any():
            rows[inside] = found.sol(t[inside]).T
        at, y = float(found.t[-1]), found.y[:, -1].copy()
        if found.status != 1:
            return rows
        hit = next(i for i, times in enumerate(found.t_events) if len(times))
        values = np.asarray(surfaces(at, y), dtype=float)
        clear = np.abs(values) > 1e-12
        clear[hit] = False
        modes[clear] = np.where(values[clear] >= 0, 1.0, -1.0)
        modes[hit] = -modes[hit]


@pytest.fixture(scope="session")
def reference() -> Callable[..., Array]:
    """reference(rates, y0, t, surfaces): see _integrate."""
    return _integrate


@pytest.fixture(scope="session")
def distance() -> Callable[[ArrayLike, ArrayLike], float]:
    """distance(ours, true): the largest difference relative to the largest true value."""
    return lambda ours, true: float(np.abs(np.asarray(ours) - np.asarray(true)).max() / np.abs(np.asarray(true)).max())
