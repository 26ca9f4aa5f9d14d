"""Workers of studies: what is taken as an executor, and a Dask cluster with processes that is killed and goes on."""

from __future__ import annotations

import os
import signal
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.workers import as_done, cores, executor_of

VALUES = {"shaft.k": np.linspace(100.0, 200.0, 15), "clutch.capacity": [6.0, 8.0]}
QUANTITIES = [gb.peak("shaft.torque"), gb.energy_lost("clutch"), gb.rms("load.w")]


def test_few_chunks_wait_at_a_time_and_all_come_back() -> None:
    waiting, most, lock = 0, 0, threading.Lock()

    def work(chunk: slice) -> int:
        nonlocal waiting
        with lock:
            waiting -= 1
        return int(chunk.start)

    with ThreadPoolExecutor(2) as pool:

        def submit(chunk: slice) -> Future[int]:
            nonlocal waiting, most
            with lock:
                waiting += 1
                most = max(most, waiting)
            return pool.submit(work, chunk)

        found = [(chunk.start, result) for chunk, result in as_done(2, [slice(i, i + 1) for i in range(100)], submit)]
    assert sorted(found) == [(i, i) for i in range(100)]
    assert most <= 8


def test_threads_are_as_many_as_cores_unless_said() -> None:
    with executor_of(None, None) as (_, number):
        assert number == cores() >= 1
    with executor_of(None, 3) as (_, number):
        assert number == 3


def test_what_was_not_begun_is_cancelled_when_the_caller_leaves() -> None:
    futures: list[Future[int]] = []

    def submit(_: slice) -> Future[int]:
        future: Future[int] = Future()
        futures.append(future)
        if len(futures) == 1:
            future.set_result(1)
        return future

    results = as_done(1, [slice(i, i + 1) for i in range(10)], submit)
    next(results)
    results.close()  # type: ignore[attr-defined]  # it is a generator
    assert len(futures) > 1 and all(future.cancelled() for future in futures[1:])


def test_what_is_done_comes_back_before_a_failure_beside_it_is_told() -> None:
    """Ctrl-C in an input function lost points of other workers, and of the same one where the caller woke late."""

    def submit(chunk: slice) -> Future[int]:
        future: Future[int] = Future()
        if chunk.start == 17:
            future.set_exception(KeyboardInterrupt("enough"))
        else:
            future.set_result(chunk.start)
        return future

    results, found = as_done(10, [slice(i, i + 1) for i in range(40)], submit), []
    with pytest.raises(KeyboardInterrupt, match="enough"):
        for _, result in results:
            found.append(result)
    assert sorted(found) == [i for i in range(40) if i != 17]


@pytest.fixture
def cluster() -> Any:
    """A scheduler with threads in this process."""
    distributed = pytest.importorskip("distributed")
    with distributed.Client(processes=False, n_workers=1, threads_per_worker=2, dashboard_address=None) as client:
        yield client


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning")
def test_a_dask_client_changes_no_bit(clutch_model: gb.Model, cluster: Any) -> None:
    plain = gb.sweep(clutch_model, VALUES, quantity=QUANTITIES, t_end=0.5)
    made = gb.sweep(clutch_model, VALUES, quantity=QUANTITIES, t_end=0.5, executor=cluster, chunk=4)
    assert made.values.tobytes() == plain.values.tobytes() and made.complete


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_of_processes_that_loses_a_worker_ends_as_if_undisturbed(
    clutch_model: gb.Model, tmp_path: Path
) -> None:
    distributed = pytest.importorskip("distributed")
    pytest.importorskip("zarr")
    plain = gb.sweep(clutch_model, VALUES, quantity=QUANTITIES, t_end=2.0, rtol=1e-9)
    killed: list[int] = []
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as made,
        made.get_client() as client,
    ):

        def kill_one(done: int, _: int) -> None:
            if done >= 4 and not killed:
                killed.append(next(iter(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        found = gb.sweep(
            clutch_model, VALUES, quantity=QUANTITIES, t_end=2.0, rtol=1e-9, executor=client, chunk=2,
            store=tmp_path / "out.zarr", progress=kill_one,
        )  # fmt: skip
    assert killed and found.complete and found.values.tobytes() == plain.values.tobytes()
