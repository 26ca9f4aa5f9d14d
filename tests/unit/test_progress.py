"""How far long work is: a line on a terminal, an output in a notebook, lines every so often in a log."""

from __future__ import annotations

import io
import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from gearblocks import progress
from gearblocks.progress import Progress


class Stream(io.StringIO):
    """Standard error of a terminal, or of a file."""

    def __init__(self, terminal: bool) -> None:
        super().__init__()
        self.terminal = terminal

    def isatty(self) -> bool:
        return self.terminal


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Any:
    """A clock that a test sets."""
    now = SimpleNamespace(seconds=0.0)
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: now.seconds))
    return now


def to(stream: Stream, monkeypatch: pytest.MonkeyPatch) -> Stream:
    monkeypatch.setattr(sys, "stderr", stream)
    return stream


def test_a_log_gets_a_line_every_so_often_and_no_carriage_return(clock: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    log = to(Stream(False), monkeypatch)
    tell = Progress("rig", " (a hint for who looks on)")
    for second in range(1, 1001):
        clock.seconds = float(second)
        tell(second / 1000)
    tell.close()
    text = log.getvalue()
    assert "\r" not in text and "hint" not in text
    lines = text.splitlines()
    assert lines[0] == "rig: 1 % done, 16 min left"
    # after 10 s, then at distances of 20, 40, 80, 160 s and 300 s at most
    assert [line.split()[1] for line in lines] == ["1", "3", "7", "15", "31", "61", "91"]


def test_a_terminal_has_one_line_that_is_cleared(clock: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    screen = to(Stream(True), monkeypatch)
    tell = Progress("rig", " (Ctrl-C keeps what is done)")
    clock.seconds = 1.0
    tell(0.1)
    assert not screen.getvalue()
    clock.seconds = 4.0
    tell(0.5, "3 of 6 points")
    tell(0.5)
    tell.close()
    shown = screen.getvalue().split("\r")
    assert shown[1] == "rig: 3 of 6 points, 4 s left (Ctrl-C keeps what is done)"
    assert shown[2].startswith("rig: 50 % done, 4 s left") and len(shown[2]) == len(shown[1])
    assert set(shown[3]) == {" "} and len(shown[3]) >= len(shown[2].rstrip()) and "\n" not in screen.getvalue()


def test_a_notebook_has_one_output_that_is_replaced_and_emptied(clock: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []
    module, displays = ModuleType("IPython"), ModuleType("IPython.display")
    handle = SimpleNamespace(update=lambda data, raw: shown.append(data["text/plain"]))

    def display(data: dict[str, str], raw: bool, display_id: bool) -> Any:
        shown.append(data["text/plain"])
        return handle

    module.get_ipython = lambda: SimpleNamespace(kernel=object())  # type: ignore[attr-defined]
    displays.display = display  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "IPython", module)
    monkeypatch.setitem(sys.modules, "IPython.display", displays)
    errors = to(Stream(False), monkeypatch)
    tell = Progress("rig")
    clock.seconds = 5.0
    tell(0.25)
    tell(0.5)
    tell.close()
    assert shown == ["rig: 25 % done, 15 s left", "rig: 50 % done, 5 s left", ""]
    assert not errors.getvalue()


def test_nothing_is_said_of_short_work(clock: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    for terminal in (True, False):
        stream = to(Stream(terminal), monkeypatch)
        tell = Progress("rig")
        clock.seconds += 1.5
        tell(0.9)
        tell.close()
        assert not stream.getvalue()


def test_how_long_the_rest_takes_is_said_once_enough_is_done_to_tell(
    clock: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = to(Stream(False), monkeypatch)
    tell = Progress("compiling the core")
    clock.seconds = 12.0  # the first file takes what all of them need once
    tell(1 / 69, "1 of 69 files")
    assert log.getvalue() == "compiling the core: 1 of 69 files\n"
    for files in range(2, 61):
        clock.seconds += 0.5
        tell(files / 69, f"{files} of 69 files")
    assert log.getvalue().splitlines()[1].endswith("left") and "min" not in log.getvalue()


def test_the_preparations_of_the_first_part_are_no_measure_of_the_rest(
    clock: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    screen = to(Stream(True), monkeypatch)
    tell = Progress("study")
    for done in range(1, 7):
        clock.seconds = 10.0 + done
        tell(done / 1000)
    assert "left" not in screen.getvalue().split("\r")[4] and "17 min left" in screen.getvalue().split("\r")[6]
