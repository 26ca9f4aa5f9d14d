"""The shell writes to streams of any encoding: what one lacks is degraded, never an error."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from gearblocks.cli.terminal import degraded


def shell(encoding: str, *arguments: str) -> tuple[int, bytes, bytes]:
    done = subprocess.run(
        [sys.executable, "-m", "gearblocks", *arguments],
        capture_output=True, check=False, timeout=300, env=os.environ | {"PYTHONIOENCODING": encoding},
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.long
@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_equations_are_printed_in_a_narrow_encoding(encoding: str) -> None:
    status, out, err = shell(encoding, "equations", "spline_coupling")
    assert (status, err) == (0, b"")
    assert "phi" in out.decode(encoding) and "?" not in out.decode(encoding)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
@pytest.mark.few(1)
def test_pages_keep_every_character(encoding: str) -> None:
    status, out, err = shell(encoding, "equations", "spline_coupling", "--format", "html")
    assert (status, err) == (0, b"")
    page = out.decode("utf-8")
    assert ("\N{GREEK SMALL LETTER PHI}" if encoding == "utf-8" else "&#966;") in page


def test_a_complaint_may_hold_any_character() -> None:
    status, _, err = shell("ascii", "run", "Prüfstand_φ")
    assert status == 2 and b"no shipped model 'Prufstand_phi'" in err


@pytest.mark.parametrize(
    ("character", "plain"),
    [("é", "e"), ("φ", "phi"), ("Φ", "Phi"), ("μ", "u"), ("µ", "u"), ("²", "^2"), ("½", "1/2"), ("ẋ", "x"), ("≤", "<="),
     ("·", "*"), ("ϕ", "phi"), ("°", "deg"), ("漢", "?"), ("\ud800", "?")],
)  # fmt: skip
def test_a_character_is_degraded_to_its_nearest_ascii(character: str, plain: str) -> None:
    assert degraded(UnicodeEncodeError("ascii", f"a{character}b", 1, 2, "")) == (plain, 2)
