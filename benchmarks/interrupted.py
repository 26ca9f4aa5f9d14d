"""`python -m benchmarks.interrupted [POINTS]`: a study in processes that is killed twice and goes on from its store.

On a local Dask cluster a worker is killed and then everything, scheduler and client included; in a pool of processes a worker
(which breaks the pool) and then everything. What ends is compared with the study that nobody disturbed.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import gearblocks as gb
from benchmarks.cases import P2, Array
from benchmarks.measure import machine
from benchmarks.problems import model

PROBLEM = P2()
T_END = 30 * PROBLEM.period
QUANTITIES = [gb.peak("mesh.force"), gb.energy_lost("mesh"), gb.rms("mesh.force")]
WORKERS = 2


class Round(NamedTuple):
    """One call of the study: points done at its begin and end, wall time [s], memory of the largest process [MB], its end."""

    first: int
    last: int
    seconds: float
    memory: float
    end: str


def studied(points: int, **how: Any) -> gb.Study:
    """The study: P2 over damping and stiffness."""
    levels = round(points**0.5)
    grid = {"mesh.k": np.linspace(0.8, 1.2, points // levels), "mesh.c": np.linspace(0.05, 0.2, levels)}
    return gb.sweep(model(PROBLEM), grid, quantity=QUANTITIES, t_end=T_END, **how)


@contextmanager
def executor(kind: str) -> Iterator[tuple[Any, list[int]]]:
    """Processes, and their numbers."""
    if kind == "processes":
        with ProcessPoolExecutor(WORKERS, get_context("spawn")) as pool:
            yield pool, [pool.submit(os.getpid).result()]
        return
    import distributed

    cluster_of: Any = distributed.LocalCluster
    with (
        cluster_of(n_workers=WORKERS, threads_per_worker=1, dashboard_address=None) as cluster,
        cluster.get_client() as client,
    ):
        yield client, [*client.run(os.getpid).values()]


def child(kind: str, points: int, store: str) -> None:
    """One call, which tells how far it is and ends with what it found."""

    def tell(done: int, _: int) -> None:
        print(json.dumps({"done": done}), flush=True)

    with executor(kind) as (pool, numbers):
        print(json.dumps({"workers": numbers}), flush=True)
        found = studied(points, executor=pool, store=store, progress=tell)
    largest = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    np.save(f"{store}.npy", found.values)
    print(json.dumps({"memory": largest / 1024, "complete": found.complete}), flush=True)


def call(kind: str, points: int, store: str, *, worker_at: float = 2.0, all_at: float = 2.0) -> Round:
    """One call in a process of its own; at these shares of the points a worker, or everything, is killed."""
    began, patience = time.perf_counter(), 60.0 + points / 100
    command = [sys.executable, "-m", "benchmarks.interrupted", "--child", kind, str(points), store]
    workers: list[int] = []
    first, last, memory, end = -1, 0, 0.0, ""
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
    ) as process:
        assert process.stdout is not None
        # a pool of Python before 3.11.5 waits for ever for a worker that was killed while something was sent to it
        watch = threading.Timer(patience, os.killpg, (process.pid, signal.SIGKILL))
        watch.start()
        for line in process.stdout:
            told = json.loads(line)
            workers, memory = told.get("workers", workers), told.get("memory", memory)
            if "done" not in told:
                continue
            last = told["done"]
            first = last if first < 0 else first
            if last >= worker_at * points and workers:
                os.kill(workers.pop(), signal.SIGKILL)
                workers, end = [], "a worker killed; "
            if last >= all_at * points:
                os.killpg(process.pid, signal.SIGKILL)
                break
        code = process.wait()
        watch.cancel()
    if code == -signal.SIGKILL and time.perf_counter() - began >= patience:
        return Round(first, last, time.perf_counter() - began, memory, f"{end}no end in {patience:.0f} s")
    end += {0: "complete", -signal.SIGKILL: "all killed"}.get(code, "ended with an error")
    return Round(first, last, time.perf_counter() - began, memory, end)


def rounds(kind: str, points: int, store: str) -> list[Round]:
    """Calls until the study is complete."""
    if kind == "dask":
        plans: list[dict[str, float]] = [{"worker_at": 0.25, "all_at": 0.5}, {}]
    else:
        plans = [{"worker_at": 0.25}, {"all_at": 0.5}, {}]
    return [call(kind, points, store, **plan) for plan in plans]


def main() -> None:
    """Prints the table."""
    if sys.argv[1:2] == ["--child"]:
        child(sys.argv[2], int(sys.argv[3]), sys.argv[4])
        return
    points = int(sys.argv[1]) if sys.argv[1:] else 100_000
    print(machine(), "\n")
    began = time.perf_counter()
    plain: Array = studied(points).values
    count = len(plain)
    print(f"P2 over 30 periods, {count} points; undisturbed, {WORKERS} threads: {time.perf_counter() - began:.1f} s\n")
    print("| on | begins at | ends at | how | wall s | largest process MB |\n|---|--:|--:|---|--:|--:|")
    for kind in ("dask", "processes"):
        folder = tempfile.mkdtemp()
        try:
            store = str(Path(folder, "out.zarr"))
            for done in rounds(kind, points, store):
                memory = f"{done.memory:.0f}" if done.memory else ""
                print(f"| {kind} | {done.first} | {done.last} | {done.end} | {done.seconds:.1f} | {memory} |")
            equal = np.load(f"{store}.npy").tobytes() == plain.tobytes()
            print(f"| {kind} | | | {'equal to the undisturbed study' if equal else 'DIFFERS'} | | |")
        finally:
            shutil.rmtree(folder)


if __name__ == "__main__":
    main()
