"""Breaks the sources on purpose, one change at a time, and asks whether the tests notice.

    python tests/hard/mutations.py [--workers N] [name or subject ...]
    python tests/hard/mutations.py --table

Each entry of mutations.toml replaces one piece of text. Its tests pass on the sources as they are, and fail on the changed
ones by a wrong result: an assertion, or a run that the solver gives up. A change that does not compile or import proves
nothing and counts as not caught.
"""

from __future__ import annotations

import argparse
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIST = Path(__file__).with_name("mutations.toml")
COPIED = ("gearblocks", "fmu_export", "models", "tests", "pyproject.toml")
WRONG = ("AssertionError", "ValueError", "IndexError", "SimulationError", "GearblocksWarning", "Failed")
"""Errors of a test that tell of a wrong result: ValueError and IndexError where events are more or fewer than expected,
GearblocksWarning where the ledger does not close, Failed where a refusal is missing."""
PATIENCE, WITH_ALL = 600.0, 3600.0
"""Seconds after which pytest is stopped: with the tests of one mutation, which is not caught then, and with those of all."""
GUARD = Path(__file__).with_name("of_the_copy.py")
"""conftest.py of the copies."""


@dataclass(frozen=True, slots=True)
class Mutation:
    """In `file` the `text` becomes another one, which the `tests` (file::name) must notice; `says` is what breaks, `subject`
    what kind of thing that is."""

    name: str
    subject: str
    says: str
    file: str
    text: str
    becomes: str
    tests: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Answer:
    """What the tests of a mutation said: the error by which one failed, "" where all passed; the rest of its message."""

    error: str
    words: str
    seconds: float

    @property
    def noticed(self) -> bool:
        """Whether a test failed by a wrong result."""
        return self.error in WRONG


def mutations() -> list[Mutation]:
    """All of the list, in its order."""
    entries = tomllib.loads(LIST.read_text(encoding="utf-8"))["mutation"]
    return [Mutation(**{**entry, "tests": tuple(entry["tests"])}) for entry in entries]


def table() -> str:
    """What README.md lists: a row per change, and how many there are of each subject."""
    found = mutations()
    rows = ["| change | subject | what breaks | where | noticed by |", "|---|---|---|---|---|"]
    for m in found:
        tests = ", ".join(f"`{test.removeprefix('tests/').removeprefix('physics/')}`" for test in m.tests)
        rows.append(f"| `{m.name}` | {m.subject} | {m.says} | `{Path(m.file).name}` | {tests} |")
    counts = Counter(m.subject for m in found)
    words = ", ".join(f"{subject} {count}" for subject, count in sorted(counts.items()))
    return "\n".join([f"{len(found)} changes: {words}.", "", *rows, ""])


def copied(folder: Path) -> Path:
    """A copy of the package and its tests in `folder`, which it makes."""
    folder.mkdir()
    unwanted = shutil.ignore_patterns("__pycache__", ".*_cache", "*.pyc")
    for name in COPIED:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name, ignore=unwanted)
        else:
            shutil.copy2(ROOT / name, folder / name)
    shutil.copy2(GUARD, folder / "conftest.py")
    return folder


def answer(folder: Path, tests: tuple[str, ...], *options: str, patience: float = PATIENCE) -> Answer:
    """Runs tests in a copy, up to the first that fails."""
    report = folder / "report.xml"
    report.unlink(missing_ok=True)
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", f"--junitxml={report}"]
    command += [*options, *tests]
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    environment["GEARBLOCKS_CACHE"] = str(folder / "cache")
    began = time.monotonic()
    try:
        subprocess.run(command, cwd=folder, env=environment, capture_output=True, timeout=patience, check=False)
    except subprocess.TimeoutExpired:
        return Answer("no end", f"after {patience:g} s", time.monotonic() - began)
    if not report.is_file():
        return Answer("no report", "pytest itself failed", time.monotonic() - began)
    return Answer(*_read(report), time.monotonic() - began)


def _read(report: Path) -> tuple[str, str]:
    """Error and message of the first failure."""
    cases = ET.parse(report).getroot().iter("testcase")
    ran = 0
    for case in cases:
        for kind in ("error", "failure"):
            found = case.find(kind)
            if found is not None:
                message = " ".join(found.get("message", "").split())
                error = "AssertionError" if message.startswith("assert ") else message.split(":")[0].rsplit(".", 1)[-1]
                sound = kind == "failure" and "the C compiler" not in message
                return (error if sound else f"broken: {error}"), message[:100]
        ran += case.find("skipped") is None
    return ("", "") if ran else ("no test", "all were skipped, or none was found")


def applied(folder: Path, mutation: Mutation) -> str:
    """Changes the copy; returns the text of the file before."""
    path = folder / mutation.file
    before = path.read_text(encoding="utf-8")
    if before.count(mutation.text) != 1:
        raise SystemExit(f"{mutation.name}: its text stands {before.count(mutation.text)} times in {mutation.file}")
    path.write_text(before.replace(mutation.text, mutation.becomes), encoding="utf-8")
    return before


def judged(folder: Path, mutation: Mutation) -> Answer:
    """The answer to one mutation; the copy is as before afterwards."""
    before = applied(folder, mutation)
    try:
        return answer(folder, mutation.tests)
    finally:
        (folder / mutation.file).write_text(before, encoding="utf-8")


def judgements(folder: Path, found: list[Mutation], workers: int) -> Iterator[Answer]:
    """The answers to mutations, in their order, from so many copies of a copy at a time."""
    free: queue.Queue[Path] = queue.Queue()
    for number in range(workers):
        free.put(shutil.copytree(folder, folder.with_name(f"copy {number}")))

    def one(mutation: Mutation) -> Answer:
        copy = free.get()
        try:
            return judged(copy, mutation)
        finally:
            free.put(copy)

    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(one, found)


def main(names: list[str], workers: int) -> int:
    """Prints a row per mutation; 0 when all are caught."""
    found = [m for m in mutations() if not names or m.name in names or m.subject in names]
    unknown = sorted(set(names) - {m.name for m in found} - {m.subject for m in found})
    if unknown:
        print(f"no mutation is named {', '.join(unknown)}", file=sys.stderr)
        return 2
    workers = max(1, min(workers, len(found)))
    with tempfile.TemporaryDirectory(prefix="mutations-") as place:
        folder = copied(Path(place, "copy"))
        tests = tuple(dict.fromkeys(test for m in found for test in m.tests))
        sound = answer(folder, tests, "-n", str(workers), patience=WITH_ALL)
        print(
            f"{'unchanged':28} {'passes' if not sound.error else 'FAILS':12} {sound.seconds:6.1f} s  {sound.words}",
            flush=True,
        )
        missed = []
        for m, said in zip(found, judgements(folder, found, workers) if not sound.error else (), strict=False):
            missed += [] if said.noticed else [m.name]
            verdict = "caught" if said.noticed else "NOT CAUGHT"
            print(f"{m.name:28} {verdict:12} {said.seconds:6.1f} s  {said.error}: {said.words}", flush=True)
    print(f"{len(found) - len(missed)} of {len(found)} caught" if not sound.error else f"unchanged: {sound.error}")
    return int(bool(sound.error or missed))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Are changes of the sources noticed by the tests?")
    parser.add_argument("names", nargs="*", help="mutations of mutations.toml, or subjects; without: all")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, help="copies that are tested at a time")
    parser.add_argument("--table", action="store_true", help="prints the table of README.md")
    given = parser.parse_args()
    if given.table:
        print(table(), end="")
        sys.exit(0)
    sys.exit(main(given.names, given.workers))
