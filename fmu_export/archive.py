"""Zip files whose bytes depend on their content alone: sorted names, one date, forward slashes, fixed rights."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

from gearblocks.files import replacing

DATE = (1980, 1, 1, 0, 0, 0)
_EXECUTABLE, _PLAIN = 0o100755 << 16, 0o100644 << 16


def write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write `files` (names with forward slashes) to `path`, atomically; StorageError leaves what was there before."""
    with replacing(path) as stream, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(files):
            info = zipfile.ZipInfo(name, DATE)
            info.create_system = 3  # unix, whatever machine writes it
            info.external_attr = _EXECUTABLE if name.startswith("binaries/") else _PLAIN
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, files[name], compresslevel=6)


def irregularities(path: Path) -> list[str]:
    """What in the zip's directory would make it differ between two exports or unreadable elsewhere."""
    found = []
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()
        names = [entry.orig_filename for entry in entries]
        if archive.testzip() is not None:
            found.append(f"'{archive.testzip()}' is damaged")
        found += [f"'{name}' has a backslash" for name in names if "\\" in name]
        found += [f"'{name}' leaves the archive" for name in names if name.startswith("/") or ".." in name.split("/")]
        if len(set(names)) != len(names):
            found.append("a name occurs twice")
        if "modelDescription.xml" not in names:
            found.append("modelDescription.xml is missing")
    return found
