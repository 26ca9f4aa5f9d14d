"""What a Linux shared library shows and needs, read from its dynamic symbol table (64-bit, little endian)."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass

_DYNAMIC, _DYNSYM, _VERNEED = 6, 11, 0x6FFFFFFE
_DT_NEEDED = 1
_SHARED, _LOAD = 3, 1
_MOST = 1 << 16  # entries of a table


@dataclass(frozen=True, slots=True)
class SharedLibrary:
    """Exported and imported symbols, needed libraries, the newest glibc version asked for, e.g. (2, 17).

    writable: bytes of variables that every instance in a process would share (.data and .bss). Tables of long trains, which
    are filled once before there is an instance, are in a section of their own (gb_filled).
    """

    exports: frozenset[str]
    imports: frozenset[str]
    needed: frozenset[str]
    glibc: tuple[int, ...]
    writable: int


@dataclass(frozen=True, slots=True)
class _Section:
    name: int
    kind: int
    offset: int
    size: int
    link: int
    entries: int
    entry_size: int


def read_shared_library(data: bytes) -> SharedLibrary:
    """Raises ValueError where `data` is no 64-bit little-endian ELF shared library, or one that is cut short or damaged."""
    if data[:6] != b"\x7fELF\x02\x01":
        raise ValueError("it is no 64-bit little-endian ELF file")
    try:
        _check_segments(data)
        return _read(data)
    except (struct.error, IndexError, UnicodeDecodeError, _CutShortError) as error:
        raise ValueError(f"it is cut short or damaged ({error})") from None


class _CutShortError(Exception):
    """The file ends before what its tables name."""


def _check_segments(data: bytes) -> None:
    """What the loader maps must lie inside the file: beyond its end the process that reads there is ended."""
    (table,) = struct.unpack_from("<Q", data, 0x20)
    (kind,) = struct.unpack_from("<H", data, 0x10)
    size, count = struct.unpack_from("<HH", data, 0x36)
    if kind != _SHARED:
        raise _CutShortError("no shared library by its header")
    if not 0 < count < _MOST or size < struct.calcsize("<IIQQQQQQ"):
        raise _CutShortError("no table of segments")
    for i in range(count):
        kind, _, offset, _, _, length, _, _ = struct.unpack_from("<IIQQQQQQ", data, table + i * size)
        if kind == _LOAD and offset + length > len(data):
            raise _CutShortError(f"a segment ends at byte {offset + length}, the file at {len(data)}")


def _read(data: bytes) -> SharedLibrary:
    sections = list(_sections(data))
    for section in sections:
        if section.kind in (_DYNAMIC, _DYNSYM, _VERNEED) and section.offset + section.size > len(data):
            raise _CutShortError(f"a table ends at byte {section.offset + section.size}, the file at {len(data)}")
    exports: set[str] = set()
    imports: set[str] = set()
    needed: set[str] = set()
    versions: list[str] = []
    for section in sections:
        if section.kind == _DYNSYM:
            for name, defined in _symbols(data, section, sections[section.link]):
                (exports if defined else imports).add(name)
        elif section.kind == _DYNAMIC:
            needed.update(_needed(data, section, sections[section.link]))
        elif section.kind == _VERNEED:
            versions += _versions(data, section, sections[section.link])
    found = [re.fullmatch(r"GLIBC_([\d.]+)", version) for version in versions]
    glibc = max((tuple(int(part) for part in m[1].split(".")) for m in found if m), default=())
    (at,) = struct.unpack_from("<H", data, 0x3E)
    writable = sum(s.size for s in sections if _text(data, sections[at], s.name) in (".data", ".bss"))
    return SharedLibrary(frozenset(exports), frozenset(imports), frozenset(needed), glibc, writable)


def _sections(data: bytes) -> Iterator[_Section]:
    (table,) = struct.unpack_from("<Q", data, 0x28)
    size, count = struct.unpack_from("<HH", data, 0x3A)
    for i in range(count):
        name, kind, _, _, offset, length, link, info, _, entry = struct.unpack_from(
            "<IIQQQQIIQQ", data, table + i * size
        )
        yield _Section(name, kind, offset, length, link, info, entry)


def _text(data: bytes, strings: _Section, at: int) -> str:
    begin = strings.offset + at
    end = data.find(b"\0", begin)
    if not 0 <= begin <= end:
        raise _CutShortError("a name beyond the end of the file")
    return data[begin:end].decode()


def _symbols(data: bytes, table: _Section, strings: _Section) -> Iterator[tuple[str, bool]]:
    if table.entry_size < struct.calcsize("<IBBHQQ"):
        raise _CutShortError("a table of symbols without entries")
    for at in range(table.offset, table.offset + table.size, table.entry_size):
        name, _, _, section, _, _ = struct.unpack_from("<IBBHQQ", data, at)
        if name:
            yield _text(data, strings, name), section != 0


def _needed(data: bytes, table: _Section, strings: _Section) -> Iterator[str]:
    for at in range(table.offset, table.offset + table.size, 16):
        tag, value = struct.unpack_from("<qQ", data, at)
        if tag == _DT_NEEDED:
            yield _text(data, strings, value)


def _versions(data: bytes, table: _Section, strings: _Section) -> Iterator[str]:
    at = table.offset
    for _ in range(min(table.entries, _MOST)):
        _, count, _, first, following = struct.unpack_from("<HHIII", data, at)
        place = at + first
        for _ in range(count):
            _, _, _, name, after = struct.unpack_from("<IHHII", data, place)
            yield _text(data, strings, name)
            place += after
        at += following
