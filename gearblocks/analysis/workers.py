"""Chunks of a study on workers: threads of this process, or any executor of `concurrent.futures`.

Chunks come back as they are done; few wait at a time, so that a study of a million points takes no more memory than their
values. Knows nothing of what a chunk is.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from typing import Any, TypeVar

from gearblocks.errors import GearblocksError, ParameterError

T = TypeVar("T")

_WAITING = 4  # chunks that wait for each worker


def cores() -> int:
    """Cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:
        return os.cpu_count() or 1


@contextmanager
def executor_of(given: Any, threads: int | None) -> Iterator[tuple[Executor, int]]:
    """The executor and how many workers it has: the one given, that of a Dask client, or threads of our own."""
    if given is None:
        number = threads or cores()
        with ThreadPoolExecutor(number, thread_name_prefix="gearblocks-study") as pool:
            yield pool, number
    elif hasattr(given, "submit") and isinstance(given, Executor):
        yield given, int(getattr(given, "_max_workers", 0)) or cores()
    elif hasattr(given, "get_executor"):
        with given.get_executor(pure=False) as pool:
            yield pool, sum(given.nthreads().values()) or cores()
    else:
        raise ParameterError(
            f"executor = {given!r:.80} must be an executor of concurrent.futures or a Dask client; threads= are used without"
        )


def as_done(workers: int, chunks: Sequence[slice], submit: Callable[[slice], Future[T]]) -> Iterator[tuple[slice, T]]:
    """Results of all chunks in the order in which they are done. What was not begun is cancelled when the caller leaves."""
    waiting: dict[Future[T], slice] = {}
    rest = iter(chunks)
    try:
        while True:
            while len(waiting) < _WAITING * workers and (chunk := next(rest, None)) is not None:
                waiting[submit(chunk)] = chunk
            if not waiting:
                return
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in sorted(finished, key=_is_without_result):  # what is done is kept before what failed is told
                chunk = waiting.pop(future)
                yield chunk, result_of(future)
    finally:
        for future in waiting:
            future.cancel()


def _is_without_result(future: Future[T]) -> bool:
    return future.cancelled() or future.exception() is not None


def result_of(future: Future[T]) -> T:
    """What a worker found. Raises GearblocksError where there is none any more."""
    try:
        return future.result()
    except (BrokenExecutor, CancelledError) as error:
        raise GearblocksError(
            "the executor of this study lost its workers; with store= a second call goes on with what is missing"
        ) from error
