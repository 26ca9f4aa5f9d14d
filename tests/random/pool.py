"""Worker processes that are started anew after a hang or a crash."""

from __future__ import annotations

import json
import os
import queue
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
WALL_LIMIT = 400.0  # s for a train; its runs have limits of processor time of their own
FRESH = 200  # trains after which a worker is replaced


class Worker:
    """One child process and its last stage."""

    def __init__(self, package: str | None, cache: str) -> None:
        command = [sys.executable, "-m", "tests.random.worker"] + (["--package", package] if package else [])
        environment = {**os.environ, "GEARBLOCKS_CACHE": cache, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
        environment.pop("PYTHONPATH", None)
        self.child = subprocess.Popen(
            command, cwd=ROOT, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self.buffer, self.stage, self.done = b"", "start", 0

    def judge(self, job: dict[str, Any]) -> dict[str, Any]:
        """The verdict on one job; a hang or crash is one too, and leaves a dead worker."""
        assert self.child.stdin is not None
        self.done += 1
        try:
            self.child.stdin.write(json.dumps(job).encode() + b"\n")
            self.child.stdin.flush()
        except BrokenPipeError:
            pass
        end = time.monotonic() + WALL_LIMIT
        while (line := self._line(end)) is not None:
            said = json.loads(line)
            if "verdict" in said:
                return dict(said["verdict"])
            self.stage = said["stage"]
        hangs = self.child.poll() is None and time.monotonic() >= end
        code = self.close()
        reason = f"no end within {WALL_LIMIT:g} s" if hangs else f"the process ended ({_ending(code)})"
        kind = (
            "crash" if not hangs else "none" if self.stage == "reference" else "hang"
        )  # a slow reference is no finding
        return {
            "family": job.get("family", ""), "seed": job.get("seed", 0), "kind": kind,
            "what": self.stage, "message": reason, "evidence": [], "notes": [], "seconds": WALL_LIMIT if hangs else 0.0,
        }  # fmt: skip

    def _line(self, end: float) -> bytes | None:
        assert self.child.stdout is not None
        number = self.child.stdout.fileno()
        while b"\n" not in self.buffer:
            ready, _, _ = select.select([number], [], [], max(0.0, end - time.monotonic()))
            more = os.read(number, 65536) if ready else b""
            if not more:
                return None
            self.buffer += more
        line, self.buffer = self.buffer.split(b"\n", 1)
        return line

    def close(self) -> int:
        """Ends the process; its exit status."""
        if self.child.stdin is not None and self.child.poll() is None:
            self.child.stdin.close()
            try:
                self.child.wait(0.5)
            except subprocess.TimeoutExpired:
                self.child.kill()
        code = self.child.wait()
        if self.child.stdout is not None:
            self.child.stdout.close()
        return code


def _ending(code: int) -> str:
    return signal.Signals(-code).name if code < 0 else f"status {code}"


def judge_all(
    jobs: Iterable[dict[str, Any]], workers: int, package: str | None, tell: Callable[[dict[str, Any]], None]
) -> None:
    """Judges every job in that many processes and tells each verdict as it comes."""
    waiting: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
    for job in jobs:
        waiting.put(job)
    lock = threading.Lock()

    def work(cache: str) -> None:
        worker: Worker | None = None
        while True:
            try:
                job = waiting.get_nowait()
            except queue.Empty:
                break
            if worker is None or worker.child.poll() is not None or worker.done >= FRESH:
                if worker is not None:
                    worker.close()
                worker = Worker(package, cache)
            verdict = worker.judge(job)
            with lock:
                tell(verdict)
        if worker is not None:
            worker.close()

    with tempfile.TemporaryDirectory(prefix="random-trains-") as folder:
        cache = os.environ.get("RANDOM_TRAINS_CACHE", folder)
        threads = [threading.Thread(target=work, args=(cache,), daemon=True) for _ in range(max(1, workers))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
