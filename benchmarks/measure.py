"""Timing, errors and tables of the benchmarks."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from benchmarks.cases import Array

T = TypeVar("T")


def cpu_seconds(work: Callable[[], T], at_least: float = 0.2, repeats: int = 15) -> tuple[float, T]:
    """Smallest CPU time (user + system) of a call, repeated until `at_least` s are spent, and its result."""
    best, spent = float("inf"), 0.0
    for _ in range(repeats):
        begin = time.process_time()
        result = work()
        took = time.process_time() - begin
        best, spent = min(best, took), spent + took
        if spent >= at_least:
            break
    return best, result


def relative_error(y: Array, reference: Array) -> float:
    """Largest error over the samples (rows), each coordinate (column) against its own largest value."""
    if y.shape != reference.shape or not np.all(np.isfinite(y)):
        return float("nan")
    return float(np.max(np.max(np.abs(y - reference), axis=0) / np.max(np.abs(reference), axis=0)))


@dataclass
class Table:
    """Rows of (what, CPU seconds, error, remark).

    The ratio of a row is its time over that of gearblocks at the same error: per method interpolated between the rows
    called "gearblocks METHOD ..." on logarithmic axes (held beyond their ends), and the fastest method of these.
    """

    title: str
    rows: list[tuple[str, float, float, str]] = field(default_factory=list)

    def add(self, what: str, seconds: float, error: float, remark: str = "") -> None:
        """Appends one row."""
        self.rows.append((what, seconds, error, remark))

    def missing(self, what: str, why: str) -> None:
        """Appends a row without figures."""
        self.rows.append((what, float("nan"), float("nan"), why))

    def ratio(self, seconds: float, error: float) -> float:
        """Time over that of gearblocks at this error; NaN without rows of gearblocks."""
        methods: dict[str, list[tuple[float, float]]] = {}
        for what, s, e, _ in self.rows:
            if what.startswith("gearblocks") and s > 0 and e > 0:
                methods.setdefault(what.rpartition(" ")[0], []).append((e, s))
        if not methods or not error > 0:
            return float("nan")
        own = (np.log(np.array(sorted(rows)).T) for rows in methods.values())
        return seconds / min(float(np.exp(np.interp(np.log(error), e, s))) for e, s in own)

    def text(self) -> str:
        """The table in Markdown."""
        lines = [f"### {self.title}", "", "| run | CPU ms | error | x gearblocks | remark |", "|---|--:|--:|--:|---|"]
        for what, seconds, error, remark in self.rows:
            cells = [
                what,
                _cell(seconds * 1e3),
                "" if error != error else f"{error:.1e}",
                _cell(self.ratio(seconds, error)),
                remark,
            ]
            lines.append("| " + " | ".join(cells) + " |")
        return "\n".join(lines) + "\n"


def _cell(x: float) -> str:
    return "" if x != x else f"{x:.3g}" if x < 1000 else f"{x:,.0f}"


def machine() -> str:
    """Kind of processor, cores and present load, without names of hosts."""
    model = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf8") as info:
            model = next(line.split(":")[1].strip() for line in info if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    return f"{model}, {os.cpu_count()} cores, load {load}, Python {platform.python_version()}"


def attempt(table: Table, what: str, run: Callable[[], Iterable[tuple[str, float, float, str]]]) -> None:
    """Adds the rows of a peer; one that is not installed or fails leaves a row that says why."""
    try:
        for row in run():
            table.add(*row)
    except ModuleNotFoundError as error:
        table.missing(what, f"not installed: {error.name}")
    except Exception as error:  # noqa: BLE001  a peer's failure is a finding, not an end
        table.missing(what, f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"[:120])
