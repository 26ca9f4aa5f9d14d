"""A compiler is found, tried out, and its refusals are shown."""

import ctypes
import os
import pickle
import stat
import sys
from pathlib import Path

import pytest

from gearblocks.errors import CompileError
from gearblocks.solver.compiler import FLAGS, SHARED_SUFFIX, find_compiler, host_target, zig_compiler

ANSWER = "int answer(void);\nint answer(void) { return 42; }\n"
on_posix = pytest.mark.skipif(os.name != "posix", reason="needs shell scripts")


def _program(path: Path, text: str) -> Path:
    path.write_text("#!/bin/sh\n" + text + "\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


@pytest.fixture
def empty_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A PATH with nothing in it but one directory, which is returned, and a cache of its own."""
    place = tmp_path / "bin"
    place.mkdir()
    monkeypatch.setenv("PATH", str(place))
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("CC", raising=False)
    return place


def test_without_cc_the_zig_package_is_the_compiler(empty_path: Path) -> None:
    assert find_compiler().is_zig


@on_posix
def test_a_cc_that_does_not_work_is_passed_over(empty_path: Path) -> None:
    _program(empty_path / "cc", "echo no developer tools; exit 1")
    assert find_compiler().is_zig


@on_posix
def test_a_cc_that_writes_nothing_is_passed_over(empty_path: Path) -> None:
    _program(empty_path / "cc", "exit 0")
    assert find_compiler().is_zig


@on_posix
def test_a_compiler_asked_for_by_name_is_never_replaced(empty_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _program(empty_path / "mycc", "echo licence expired; exit 3")
    monkeypatch.setenv("CC", "mycc -m64")
    with pytest.raises(CompileError, match=r"CC is 'mycc -m64'[^\0]*licence expired"):
        find_compiler()
    monkeypatch.setenv("CC", "nocc")
    with pytest.raises(CompileError, match="no program 'nocc'"):
        find_compiler()


@on_posix
def test_a_compiler_is_tried_out_once(empty_path: Path, tmp_path: Path) -> None:
    count = tmp_path / "count"
    _program(empty_path / "cc", f"echo x >> '{count}'; for word; do out=$word; done; echo > probe{SHARED_SUFFIX}")
    first = find_compiler()
    assert not first.is_zig
    assert first.native == ("-march=native",)
    assert find_compiler() == first
    assert count.read_text() == "x\n"


@on_posix
@pytest.mark.parametrize("flag", ["-march=x86-64-v2", "-mcpu=cortex-a53"])
def test_a_processor_named_in_cc_takes_the_place_of_the_one_at_hand(
    empty_path: Path, monkeypatch: pytest.MonkeyPatch, flag: str
) -> None:
    _program(empty_path / "cc", f"echo > probe{SHARED_SUFFIX}")
    plain = find_compiler()
    monkeypatch.setenv("CC", f"cc {flag}")
    named = find_compiler()
    assert plain.native == ("-march=native",) and named.native == ()
    assert named.command[1:] == (flag,) and named.identity != plain.identity


@on_posix
def test_a_level_in_cc_is_that_of_generated_laws_and_fmus(empty_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _program(empty_path / "cc", f"echo > probe{SHARED_SUFFIX}")
    plain = find_compiler()
    monkeypatch.setenv("CC", "cc -O0")
    named = find_compiler()
    assert [flag for flag in plain.generated_flags if flag.startswith("-O")] == ["-O1"]
    assert named.generated_flags == (*plain.generated_flags, "-O0") and named.native == plain.native
    assert named.level == ("-O0",) and plain.level == ()
    assert named.identity == plain.identity  # the core in-process is the same


@on_posix
def test_a_changed_compiler_has_another_identity(empty_path: Path) -> None:
    _program(empty_path / "cc", f"echo > probe{SHARED_SUFFIX}")
    first = find_compiler()
    _program(empty_path / "cc", f"echo >  probe{SHARED_SUFFIX}")
    assert find_compiler().identity != first.identity


def test_a_refusal_shows_command_and_complaint(tmp_path: Path) -> None:
    (tmp_path / "wrong.c").write_text("this is not C\n")
    with pytest.raises(CompileError) as caught:
        find_compiler().run([*FLAGS, "-c", "wrong.c", "-o", "wrong.o"], tmp_path)
    assert "wrong.c" in str(caught.value)
    assert "-ffp-contract=off" in caught.value.command
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_a_place_with_blanks_and_umlauts_is_fine(tmp_path: Path) -> None:
    place = tmp_path / "größer als ein Wort"
    place.mkdir()
    (place / "answer.c").write_text(ANSWER)
    compiler = find_compiler()
    compiler.run([*FLAGS, *compiler.native, "-shared", "answer.c", "-o", "answer" + SHARED_SUFFIX], place)
    assert (place / ("answer" + SHARED_SUFFIX)).stat().st_size > 0


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="the first use of zig takes a minute there")
def test_zig_compiles_for_this_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CC", raising=False)
    (tmp_path / "answer.c").write_text(ANSWER)
    compiler = zig_compiler()
    assert host_target() in compiler.command
    visible = "-fvisibility=default"
    compiler.run([*FLAGS, *compiler.native, visible, "-shared", "answer.c", "-o", "answer" + SHARED_SUFFIX], tmp_path)
    assert ctypes.CDLL(str(tmp_path / ("answer" + SHARED_SUFFIX))).answer() == 42
