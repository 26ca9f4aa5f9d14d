"""check() of files that are damaged, hostile, or made by others."""

from __future__ import annotations

import struct
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

import fmu_export
from fmu_export.checks import check_fmu
from fmu_export.checks.elf import read_shared_library
from fmu_export.checks.file import check_validation
from gearblocks.solver.library import Model

sys.path.insert(0, str(Path(__file__).parent))
from foreign import BALL, Foreign

GATE = ("archive", "fmpy validation", "description", "binary")


def changed(fmu: Path, path: Path, change: Callable[[str, bytes], bytes]) -> Path:
    """A copy of the FMU with its files changed."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            new.writestr(name, change(name, old.read(name)))
    return path


def verdicts(report: fmu_export.Report) -> dict[str, bool | None]:
    return {item.name: item.ok for item in report.items}


def words(report: fmu_export.Report, name: str) -> str:
    return next(item.words for item in report.items if item.name == name)


# -- FMUs of others ------------------------------------------------------------------------------------------------


OTHERS = {
    "strict": Foreign(),
    "lenient": Foreign(("-DLENIENT",), without_sources=True),
    "ball": Foreign(
        part=BALL, start=(1.0, 0.7), listed=False, flags='canBeInstantiatedOnlyOncePerProcess="true"', stop=2.0
    ),
    "ends": Foreign(("-DENDS",), begin=0.5, flags=""),
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n == "strict" else pytest.mark.long) for n in OTHERS])
def test_a_legal_fmu_of_others_passes(name: str, tmp_path: Path) -> None:
    """Values are read from the initialization mode on, an instance is not used after an error, and only listed sources
    are compiled; what else they do is said and not judged."""
    report = fmu_export.check(OTHERS[name].write(tmp_path / "foreign.fmu", tmp_path / "build"))
    assert report.ok, str(report)
    found = verdicts(report)
    for one in ("start values", "reset", "communication step"):
        assert found[one], str(report)
    assert found["sources"] is (True if name in ("strict", "ends") else None)
    assert found["run"] is (None if name == "ends" else True)
    if name == "strict":
        assert found["token"] and found["saved state"] and found["log"]


@pytest.mark.parametrize(
    ("given", "name", "said"),
    [
        (Foreign(start=(2.0, 1.5)), "start values", "'mu' differs from the description"),
        pytest.param(
            Foreign(("-DCRASHES",)), "refusals", "the process that made it was ended by SIGSEGV", marks=pytest.mark.long
        ),
        pytest.param(Foreign(more={"sources/foreign.c": b"no C"}), "sources", "error", marks=pytest.mark.long),
    ],
)
def test_what_is_wrong_with_an_fmu_of_others_is_found(given: Foreign, name: str, said: str, tmp_path: Path) -> None:
    report = fmu_export.check(given.write(tmp_path / "foreign.fmu", tmp_path / "build"))
    assert verdicts(report)[name] is False, str(report)
    assert said in words(report, name)


# -- damaged and hostile files ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.3, pytest.param(0.9, marks=pytest.mark.long)])
def test_a_binary_that_is_cut_short_is_not_loaded(packed: Path, tmp_path: Path, share: float) -> None:
    """The loader would map what is not there, and whoever reads it is ended by a bus error."""

    def cut(name: str, data: bytes) -> bytes:
        return data[: int(share * len(data))] if name.startswith("binaries/") else data

    report = fmu_export.check(changed(packed, tmp_path / "cut.fmu", cut))
    assert verdicts(report)["binary"] is False
    assert "cut short or damaged" in words(report, "binary")
    assert verdicts(report)["run"] is None
    assert "token" not in verdicts(report)


def test_tables_of_a_binary_that_lead_nowhere_are_refused_with_words(packed: Path) -> None:
    with zipfile.ZipFile(packed) as archive:
        (name,) = (name for name in archive.namelist() if name.startswith("binaries/"))
        data = archive.read(name)
    assert "fmi2DoStep" in read_shared_library(data).exports
    for size in (0, 5, 40, 63, 64, 200, len(data) // 2, len(data) - 1):
        with pytest.raises(ValueError, match=r"ELF|cut short"):
            read_shared_library(data[:size])
    (table,), (size, count) = struct.unpack_from("<Q", data, 0x20), struct.unpack_from("<HH", data, 0x36)
    (load, *_) = (i for i in range(count) if struct.unpack_from("<I", data, table + i * size) == (1,))
    longer = bytearray(data)
    struct.pack_into("<Q", longer, table + load * size + 0x20, len(data) + 1)  # of the segment in the file
    with pytest.raises(ValueError, match="a segment ends at byte"):
        read_shared_library(bytes(longer))
    for at, form, value in ((0x20, "<Q", 1 << 60), (0x28, "<Q", len(data) - 8), (0x36, "<H", 0), (0x10, "<H", 2)):
        broken = bytearray(data)
        struct.pack_into(form, broken, at, value)
        with pytest.raises(ValueError, match="cut short"):
            read_shared_library(bytes(broken))


@pytest.mark.parametrize(
    ("given", "failed"),
    [
        (Foreign(more={"binaries/linux64/foreign.so": b"\x7fELF no more"}), "binary"),
        pytest.param(Foreign(start=(2.0, float("nan"))), "description", marks=pytest.mark.long),
        pytest.param(Foreign(stop=-1.0), "description", marks=pytest.mark.long),
    ],
)
def test_nothing_is_loaded_where_a_check_before_it_fails(given: Foreign, failed: str, tmp_path: Path) -> None:
    report = fmu_export.check(given.write(tmp_path / "foreign.fmu", tmp_path / "build"))
    assert not report.ok
    assert verdicts(report)[failed] is False, str(report)
    assert set(verdicts(report)) <= {*GATE, "sources", "run"}


@pytest.mark.long
def test_loading_a_library_is_left_to_another_process_and_to_the_last(tmp_path: Path) -> None:
    """The library writes a file when it is loaded: not where the description or fmpy's validation alone fails, and not by
    this process."""
    trace = tmp_path / "loaded"
    sound = Foreign(("-DSTRICT", f'-DLOADS="{trace}"'))
    bad = Foreign(sound.defines, start=(2.0, float("nan")))
    assert not fmu_export.check(bad.write(tmp_path / "bad.fmu", tmp_path / "build")).ok
    assert not trace.exists()

    def one_output_less(name: str, data: bytes) -> bytes:
        return data.replace(b'<Unknown index="2"/>', b"") if name.endswith(".xml") else data

    whole = sound.write(tmp_path / "whole.fmu", tmp_path / "build")
    report = fmu_export.check(changed(whole, tmp_path / "less.fmu", one_output_less))
    assert [item.name for item in report.items if item.ok is False] == ["fmpy validation"], str(report)
    assert not trace.exists()
    assert fmu_export.check(sound.write(tmp_path / "sound.fmu", tmp_path / "build")).ok
    assert trace.exists()
    assert str(tmp_path) not in Path("/proc/self/maps").read_text(encoding="utf-8") if Path("/proc").is_dir() else True


@pytest.mark.long
def test_a_step_that_never_ends_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_fmu, "SECONDS_OF_ONE", 5.0)
    monkeypatch.setattr(check_fmu, "DEATHS", 1)
    fmu = Foreign(("-DHANGS",), without_sources=True).write(tmp_path / "hangs.fmu", tmp_path / "build")
    report = fmu_export.check(fmu)
    assert "has not ended after 5 s" in words(report, "refusals"), str(report)
    assert verdicts(report)["rest"] is None


@pytest.mark.long
def test_memory_is_limited(tmp_path: Path) -> None:
    fmu = Foreign(("-DEATS",), without_sources=True).write(tmp_path / "eats.fmu", tmp_path / "build")
    assert "was ended by SIGSEGV" in words(fmu_export.check(fmu), "refusals")


def test_an_archive_that_would_fill_the_disk_is_not_unpacked(packed: Path, tmp_path: Path) -> None:
    """Its directory says so; what lies behind is not looked at."""
    data = bytearray(packed.read_bytes())
    at = data.index(b"PK\x01\x02")
    struct.pack_into("<I", data, at + 24, 0xF0000000)
    path = tmp_path / "bomb.fmu"
    path.write_bytes(data)
    report = fmu_export.check(path)
    assert "are more than a check unpacks" in words(report, "archive")
    assert set(verdicts(report)) == {"archive", "description"}


@pytest.mark.long
def test_a_stop_time_that_no_run_reaches_ends_with_words(model: Model, tmp_path: Path) -> None:
    report = fmu_export.check(fmu_export.export(model, tmp_path / "long.fmu", t_end=1e300, patience=0.0))
    assert verdicts(report)["run"] is False
    assert not report.ok


@pytest.mark.parametrize(
    ("count", "good"), [(3000, True), (3000, False), pytest.param(300_000, True, marks=pytest.mark.long)]
)
def test_names_of_very_many_variables_are_looked_at_without_a_parser(
    packed: Path, tmp_path: Path, count: int, good: bool
) -> None:
    one = '<ScalarVariable name="{}" valueReference="{}" causality="local" variability="continuous"><Real/></ScalarVariable>'
    more = "".join(one.format(f"part[{i}].x" if good or i != 77 else "part 77", 2**30 + i) for i in range(count))

    def longer(name: str, data: bytes) -> bytes:
        return (
            data.replace(b"</ModelVariables>", more.encode() + b"</ModelVariables>") if name.endswith(".xml") else data
        )

    item = check_validation(changed(packed, tmp_path / "many.fmu", longer))
    assert item.ok is good, item.words
    assert good or "'part 77' is no structured name" in item.words
