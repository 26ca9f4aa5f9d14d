"""check(): an FMU looked at from outside, run by fmpy, and compared with the run in-process.

All of it happens in a child process with limits of time and memory, so that no file ends or stops the caller; the binary
is loaded only after archive, description and binary have passed. What the child found is read from a file that it writes
line by line: where it dies or does not end, the check it was at has failed, and another child makes the rest.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fmu_export.checks.inputs import plain
from fmu_export.checks.limits import DEATHS, SECONDS_OF_ALL, SECONDS_OF_ONE
from fmu_export.checks.report import Item, Report
from gearblocks.errors import ParameterError, by_name_only
from gearblocks.files import as_path
from gearblocks.language.units import seconds
from gearblocks.simulation.arguments import InputSource

_POLL = 0.02  # s between looks at what the child has written
_SOURCES = Path(__file__).parents[2]
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
"""Each thread of a linear algebra that nobody uses here would take its share of the address space."""


@by_name_only
def check(
    path: str | os.PathLike[str], *, t_end: float | str | None = None, steps: int = 500,
    inputs: Mapping[str, InputSource] | None = None,
) -> Report:  # fmt: skip
    """Report on an FMU: files, fmpy's validation, life cycle, a run by fmpy and the difference from the run in-process.

    t_end [s, or text such as "20 ms"]: end of the run, by default that of the description; steps: communication steps of the
    run. inputs: by name what the run gets instead of their start values, a number or text with its unit, a pair (t, y), a
    Series of pandas or a gb.Table, held over each communication step as FMI does; bare numbers are in the unit that the
    train declares for the input, as in simulate (of FMUs of others: in that of the description). FMUs of
    others are asked for what the standard asks for; what it leaves open is said and not judged. A check that cannot be
    made is listed, a check that breaks down or takes longer than a minute has failed. Memory is limited where the
    system knows such limits (not on Windows), time everywhere.
    Raises ParameterError where there is no FMU at `path`, and for arguments that make no sense.
    """
    fmu = as_path(path)
    end = None if t_end is None else seconds("t_end", t_end)
    if isinstance(steps, bool) or not isinstance(steps, int) or steps < 1:
        raise ParameterError(f"steps = {steps!r} must be a whole number of communication steps, >= 1")
    given = plain(inputs)
    if fmu.is_dir():
        raise ParameterError(f"'{fmu}' is a folder; name the FMU in it")
    if not fmu.is_file():
        raise ParameterError(f"there is no file '{fmu}'; fmu_export.export, or `gearblocks export`, writes an FMU")
    if not zipfile.is_zipfile(fmu):
        raise ParameterError(
            f"'{fmu}' is no FMU: it is not a zip file; name a file that ends in .fmu and export it anew"
        )
    with tempfile.TemporaryDirectory(prefix="gearblocks-check-", ignore_cleanup_errors=True) as place:
        work = _Work(fmu.resolve(), Path(place), end, steps, given)
        while not work.done:
            work.go_on()
    return Report(fmu, tuple(work.items), tuple(work.differences.items()))


@dataclass(slots=True)
class _Work:
    """What the children have said so far. at: the check that the present one is at, and since when."""

    fmu: Path
    folder: Path
    t_end: float | None
    steps: int
    inputs: dict[str, Any]
    items: list[Item] = field(default_factory=list)
    differences: dict[str, float] = field(default_factory=dict)
    done: bool = False
    at: str = ""
    since: float = 0.0
    deaths: int = 0
    began: float = field(default_factory=time.monotonic)

    def go_on(self) -> None:
        """One child, up to its end."""
        said = self.folder / f"said-{self.deaths}.jsonl"
        order = {
            "fmu": str(self.fmu), "folder": str(self.folder / "fmu"), "said": str(said), "t_end": self.t_end,
            "steps": self.steps, "inputs": self.inputs, "made": [[i.name, i.ok, i.words] for i in self.items],
        }  # fmt: skip
        self.at, self.since = "", time.monotonic()
        paths = [str(_SOURCES), *filter(None, [os.environ.get("PYTHONPATH")])]
        with (self.folder / "output.txt").open("ab") as output:
            child = subprocess.Popen(
                [sys.executable, "-m", "fmu_export.checks.child", json.dumps(order)],
                stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True,
                env={**os.environ, **_ONE_THREAD, "PYTHONPATH": os.pathsep.join(paths)}, cwd=self.folder,
            )  # fmt: skip
            try:
                late = self._follow(child, said)
            finally:
                _end(child)
        if not self.done:
            self._failed(late or _death(child.returncode))

    def _follow(self, child: subprocess.Popen[bytes], said: Path) -> str:
        """Reads what the child says until it ends; in words why it has to be ended, or ""."""
        read = 0
        while True:
            ended = child.poll() is not None
            lines = said.read_bytes()[read:] if said.is_file() else b""
            whole = lines[: lines.rfind(b"\n") + 1]
            read += len(whole)
            for line in whole.splitlines():
                self._hear(json.loads(line))
            now = time.monotonic()
            if ended:
                return ""
            if now - self.began > SECONDS_OF_ALL:
                self.done = True
                self._failed(f"all checks together have not ended after {SECONDS_OF_ALL:g} s")
                return ""
            if now - self.since > SECONDS_OF_ONE:
                return f"has not ended after {SECONDS_OF_ONE:g} s"
            time.sleep(_POLL)

    def _hear(self, line: dict[str, Any]) -> None:
        if "refused" in line:
            raise ParameterError(line["refused"])
        if "at" in line:
            self.at, self.since = line["at"], time.monotonic()
        if "item" in line:
            self.items.append(Item(*line["item"]))
            self.differences.update(line.get("differences", {}))
            self.at = ""
        self.done = self.done or line.get("done", False)

    def _failed(self, words: str) -> None:
        """The check that the child was at; one that died between two checks makes no third."""
        self.items.append(Item(self.at or "check", False, words))
        self.deaths += 1
        if self.deaths >= DEATHS and not self.done:
            self.items.append(Item("rest", None, "not made: no more processes are spent on this file"))
        self.done = self.done or not self.at or self.deaths >= DEATHS


def _death(code: int | None) -> str:
    if code is not None and code < 0:
        try:
            return f"the process that made it was ended by {signal.Signals(-code).name}"
        except ValueError:
            return f"the process that made it was ended by signal {-code}"
    return f"the process that made it ended with status {code}"


def _end(child: subprocess.Popen[bytes]) -> None:
    """The child and what it has started."""
    try:
        if hasattr(os, "killpg"):
            os.killpg(child.pid, signal.SIGKILL)
        else:
            child.kill()
    except OSError:
        pass  # it has ended by itself
    child.wait()
