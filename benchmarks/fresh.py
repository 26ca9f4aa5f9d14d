"""Runs a step of a benchmark in a fresh Python process and reads the figures that it prints as JSON."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any


def in_fresh_process(module: str, *arguments: str, cache: Path) -> dict[str, Any]:
    """`python -m module arguments` with gearblocks' cache in the folder `cache`; its last line is JSON."""
    environment = dict(os.environ, GEARBLOCKS_CACHE=str(cache))
    command = [sys.executable, "-m", module, *arguments]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if run.returncode:
        raise RuntimeError(run.stderr.strip().splitlines()[-1] if run.stderr.strip() else f"exit {run.returncode}")
    figures: dict[str, Any] = json.loads(run.stdout.strip().splitlines()[-1])
    return figures


class Stopwatch:
    """Seconds since it was made or last read: wall time, and CPU time with that of child processes."""

    def __init__(self) -> None:
        self.wall, self.cpu = time.perf_counter(), self._cpu()

    @staticmethod
    def _cpu() -> float:
        t = os.times()
        return t.user + t.system + t.children_user + t.children_system

    def read(self) -> dict[str, float]:
        """Both times since the last reading."""
        wall, cpu = time.perf_counter(), self._cpu()
        seconds = {"wall": wall - self.wall, "cpu": cpu - self.cpu}
        self.wall, self.cpu = wall, cpu
        return seconds


def peak_mib() -> tuple[float, float]:
    """Peak resident memory in MiB of this process and of the largest child so far."""
    unit = 1024.0 if sys.platform != "darwin" else 1024.0**2
    own, child = (resource.getrusage(w).ru_maxrss / unit for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own, child
