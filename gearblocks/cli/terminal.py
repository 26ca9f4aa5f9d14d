"""Output streams of the shell: any encoding is written, complaints go to standard error, long runs show how far they are."""

from __future__ import annotations

import codecs
import io
import re
import sys
import time
import unicodedata
from collections.abc import Callable, Iterator
from contextlib import contextmanager

DEGRADED = "gearblocks.degraded"
"""Name under which `codecs` knows `degraded`."""
_PLAIN = {
    "\N{MULTIPLICATION SIGN}": "x", "\N{MIDDLE DOT}": "*", "\N{DOT OPERATOR}": "*", "\N{MINUS SIGN}": "-",
    "\N{EN DASH}": "-", "\N{EM DASH}": "-", "\N{DEGREE SIGN}": "deg", "\N{MICRO SIGN}": "u",
    "\N{GREEK SMALL LETTER MU}": "u", "\N{LESS-THAN OR EQUAL TO}": "<=", "\N{GREATER-THAN OR EQUAL TO}": ">=",
    "\N{NOT EQUAL TO}": "!=", "\N{SQUARE ROOT}": "sqrt", "\N{PARTIAL DIFFERENTIAL}": "d", "\N{RIGHTWARDS ARROW}": "->",
    "\N{LEFT SINGLE QUOTATION MARK}": "'", "\N{RIGHT SINGLE QUOTATION MARK}": "'", "\N{LEFT DOUBLE QUOTATION MARK}": '"',
    "\N{RIGHT DOUBLE QUOTATION MARK}": '"', "\N{LATIN SMALL LETTER SHARP S}": "ss", "\N{INFINITY}": "inf",
    "\N{LEFT FLOOR}": "floor(", "\N{RIGHT FLOOR}": ")", "\N{FRACTION SLASH}": "/",
    "\N{LEFT CURLY BRACKET UPPER HOOK}": "{", "\N{LEFT CURLY BRACKET MIDDLE PIECE}": "{",
    "\N{LEFT CURLY BRACKET LOWER HOOK}": "{", "\N{CURLY BRACKET EXTENSION}": "{",
}  # fmt: skip
"""Characters whose plain form Unicode does not give."""


def degraded(error: UnicodeError) -> tuple[str, int]:
    """Error handler of `codecs`: a character that an encoding lacks, in ASCII: 'é' as 'e', 'φ' as 'phi', else '?'."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(_plain, error.object[error.start : error.end])), error.end


def accept_every_character() -> None:
    """Standard output and error degrade what their encoding lacks, where they would raise UnicodeEncodeError."""
    codecs.register_error(DEGRADED, degraded)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors=DEGRADED)


def say(text: object = "") -> None:
    """A line of the answer, on standard output."""
    print(text)


def say_page(html: str) -> None:
    """HTML on standard output: its bytes are UTF-8, or entities where the stream has another encoding."""
    unicode = (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"
    print(html if unicode else html.encode("ascii", "xmlcharrefreplace").decode("ascii"))


def complain(words: str) -> None:
    """A message on standard error, with the name of the program."""
    print(f"gearblocks: {words}", file=sys.stderr)


_IN_PYTHON = (
    (r"rig\.(describe|outputs|parameters|inputs)\(\)", r"`gearblocks \1 FILE`"),
    (r"rig\.set\(\{'([^']+)': [^}]*\}\)", r"--set \1=VALUE"),
    (r"rig\.set(\(\.\.\.\))?", "--set PATH=VALUE"),
    (r"rig\.without\((['\"][^'\"]+['\"])\)", r"--without \1"),
    (r"help\(gb\.(\w+)\)", r"`gearblocks doc \1`"),
)
"""What messages tell a user of Python to write, and what one of the shell types."""


def in_the_shell(message: str) -> str:
    """A message with the ways out that there are in the shell."""
    for python, shell in _IN_PYTHON:
        message = re.sub(python, shell, message)
    return message


@contextmanager
def progress() -> Iterator[Callable[[float], None] | None]:
    """A function that takes the share done, 0 .. 1: on a terminal, a bar that appears when the run takes long.

    None elsewhere: the run itself then writes a line every so often.
    """
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

    columns = (TextColumn("simulating"), BarColumn(), TaskProgressColumn(), TimeRemainingColumn(), TextColumn("left"))
    bar = Progress(*columns, console=Console(stderr=True), transient=True)
    task = bar.add_task("", total=1.0)
    began = time.monotonic()

    def show(share: float) -> None:
        if time.monotonic() - began > 0.5 and not bar.live.is_started:
            bar.start()
        bar.update(task, completed=share)

    try:
        yield show
    finally:
        bar.stop()


def _plain(character: str) -> str:
    if character in _PLAIN:
        return _PLAIN[character]
    if unicodedata.combining(character):
        return ""
    parts = unicodedata.normalize("NFKD", character)
    if parts != character:
        power = "^" if unicodedata.decomposition(character).startswith("<super>") else ""
        return power + "".join(part if part.isascii() else _plain(part) for part in parts)
    words = unicodedata.name(character, "").split()
    if words[:1] != ["GREEK"] or "LETTER" not in words:
        return "?"
    letter = words[words.index("LETTER") + 1].lower()
    return letter.capitalize() if "CAPITAL" in words else letter
