"""The first build of the core and of an FMU: files side by side, and who waits sees how far it is."""

from __future__ import annotations

import io
import sys
import threading
from pathlib import Path

import pytest

import gearblocks as gb
from fmu_export import binary
from gearblocks import progress
from gearblocks.errors import CompileError
from gearblocks.solver import library as stage
from models import gear_pair


class Terminal(io.StringIO):
    """Standard error of someone who looks on."""

    def isatty(self) -> bool:
        return True

    def lines(self) -> list[str]:
        """What stood in the line, one after the other."""
        return [line.strip() for line in self.getvalue().split("\r") if line.strip()]


def looked_at(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """A terminal that shows at once how far work is."""
    monkeypatch.setattr(progress, "_PATIENCE", -1.0)
    monkeypatch.setattr(stage, "_LOOK", 1e-3)
    screen = Terminal()
    monkeypatch.setattr(sys, "stderr", screen)
    return screen


def test_what_is_made_side_by_side_comes_in_the_order_asked_for_and_is_counted() -> None:
    told: list[tuple[int, int]] = []
    first_may_end = threading.Event()

    def made(number: int) -> int:
        if number == 0:
            first_may_end.wait(10.0)
        first_may_end.set()
        return number**2

    units = list(range(7))
    if (stage.os.cpu_count() or 1) == 1:
        first_may_end.set()
    assert stage.side_by_side(made, units, lambda done, of: told.append((done, of))) == [n**2 for n in units]
    assert told == [(n + 1, 7) for n in units]
    assert stage.side_by_side(made, [], lambda done, of: told.append((done, of))) == []


def test_what_fails_ends_the_rest() -> None:
    begun: list[int] = []

    def made(number: int) -> int:
        begun.append(number)
        threading.Event().wait(0.005)
        raise CompileError(f"file {number}")

    with pytest.raises(CompileError, match="file"):
        stage.side_by_side(made, range(1000), lambda done, of: None)
    assert len(begun) < 1000


def test_who_waits_for_the_core_sees_how_far_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path))
    half, seen, made = threading.Event(), threading.Event(), list[str]()
    number = sum(name.endswith(".c") for name in stage.core_files())

    def produced(compiler: object, files: object, arguments: object, product: str) -> bytes:
        made.append(product)
        if len(made) > number // 2:
            half.set()
            seen.wait(10.0)
        return b"object"

    monkeypatch.setattr(stage, "produced", produced)
    build = stage._core(stage.compiler_here(), "a key of its own")
    assert half.wait(10.0)
    terminal = looked_at(monkeypatch)
    asking = threading.Timer(0.05, seen.set)
    asking.start()
    assert build.core().is_there
    lines = terminal.lines()
    assert lines and lines[0].startswith("compiling the core: ")
    done, of = int(lines[0].split()[3]), int(lines[0].split()[5])
    assert 0 < done < of == number
    assert "files, " in lines[0] and lines[0].endswith("left (once on this machine)")
    assert not terminal.getvalue().rsplit("\r", 2)[1].strip()  # cleared
    assert stage._core(stage.compiler_here(), "a key of its own") is build


def test_who_waits_for_a_core_that_cannot_be_compiled_is_told_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path))

    def produced(*_: object) -> bytes:
        raise CompileError("the C compiler failed with status 1")

    monkeypatch.setattr(stage, "produced", produced)
    for _ in range(2):  # the second one begins again
        with pytest.raises(CompileError, match="status 1"):
            stage._core(stage.compiler_here(), "another key").core()


def test_who_waits_for_an_fmu_sees_how_far_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(binary, "kept_object", lambda *_: b"object")
    monkeypatch.setattr(binary, "produced", lambda *_: b"library")
    sources = binary.source_files("2.0", gb.build(gear_pair.build()).program.source, "int table;")
    terminal = looked_at(monkeypatch)
    assert list(binary.build_binary(sources, "pair").values()) == [b"library"]
    lines = terminal.lines()
    assert lines[0].startswith("compiling the FMU: 1 of ")
    total = int(lines[0].split()[5])
    assert lines[-1].startswith(f"compiling the FMU: {total} of {total} files, 0 s left")
    assert max(map(len, lines)) < 80
