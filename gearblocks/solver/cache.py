"""A cache of files that survives concurrent writers, damage, read-only places and full disks.

An entry is two files: a blob named after its own content, and a pointer `<key>.ref` that holds the sha256 of the blob.
Both are written aside and moved into place, so a reader sees an entry whole or not at all. A blob whose sum does not
match counts as absent and is written again.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import os
import shutil
import tempfile
import threading
import time
from pathlib import Path

from gearblocks.errors import StorageError, warn

_STALE_TEMPORARY = 3600.0
_UNUSED = 90 * 86400.0


def digest(*parts: str | bytes) -> str:
    """The first 40 hex digits of sha256 over the parts; order, and where one part ends and the next begins, matter."""
    total = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        total.update(len(data).to_bytes(8, "little"))
        total.update(data)
    return total.hexdigest()[:40]


class Cache:
    """Entries under one directory; a temporary directory stands in, with one warning, where that cannot be written."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self._spare: Path | None = None
        self._swept: set[Path] = set()
        self._lock = threading.RLock()

    def find(self, kind: str, key: str, suffix: str = "") -> Path | None:
        """The file of an entry, its content verified, or None."""
        for root in (self.root, self._spare):
            found = _verified(root / kind, key, suffix) if root is not None else None
            if found is not None:
                return found
        return None

    def read(self, kind: str, key: str) -> bytes | None:
        """The content of an entry, verified, or None."""
        path = self.find(kind, key)
        try:
            return None if path is None else path.read_bytes()
        except OSError:
            return None

    def write(self, kind: str, key: str, data: bytes, suffix: str = "") -> Path:
        """Stores an entry and returns its file. Raises StorageError when nothing at all can be written."""
        if self._spare is None:
            try:
                return self._put(self.root / kind, key, data, suffix)
            except OSError as error:
                self._use_spare(error)
        try:
            return self._put(self._spare_root() / kind, key, data, suffix)
        except OSError as error:
            raise StorageError(f"nothing can be written to {self._spare}: {_reason(error)}") from error

    def folder(self, name: str) -> Path:
        """A writable directory that stays from run to run (or until exit, where the cache cannot be written)."""
        if self._spare is None:
            try:
                return _writable(self.root / name)
            except OSError as error:
                self._use_spare(error)
        return _writable(self._spare_root() / name)

    def _use_spare(self, error: OSError) -> None:
        with self._lock:
            told = self._spare is not None
            spare = self._spare_root()
        if told:
            return
        warn(
            f"the cache {self.root} cannot be written ({_reason(error)}); "
            f"using {spare} until this process ends: set GEARBLOCKS_CACHE to a directory that can be written",
        )

    def _spare_root(self) -> Path:
        if self._spare is None:
            try:
                self._spare = Path(tempfile.mkdtemp(prefix="gearblocks-"))
            except OSError as error:
                raise StorageError(f"no temporary directory can be written: {_reason(error)}") from error
            atexit.register(shutil.rmtree, self._spare, ignore_errors=True)
        return self._spare

    def _put(self, directory: Path, key: str, data: bytes, suffix: str) -> Path:
        directory.mkdir(parents=True, exist_ok=True)
        if directory not in self._swept:
            self._swept.add(directory)
            _sweep(directory)
        total = hashlib.sha256(data).hexdigest()
        blob = directory / _blob_name(key, total, suffix)
        _replace(blob, data)
        _replace(directory / f"{key}.ref", f"{total} {len(data)}\n".encode())
        return blob


def user_cache() -> Cache:
    """The user's cache: the directory in GEARBLOCKS_CACHE, else where the system keeps caches."""
    named = os.environ.get("GEARBLOCKS_CACHE", "")
    return _cache_at(os.path.abspath(os.path.expanduser(named)) if named else _system_directory())


@functools.cache
def _cache_at(root: str) -> Cache:
    return Cache(Path(root))


@functools.cache
def _system_directory() -> str:
    import platformdirs

    return platformdirs.user_cache_dir("gearblocks", appauthor=False)


def _blob_name(key: str, total: str, suffix: str) -> str:
    return f"{key}-{total[:16]}{suffix}"


def _verified(directory: Path, key: str, suffix: str) -> Path | None:
    """The blob that the pointer names, if it is there and its sum matches."""
    pointer = directory / f"{key}.ref"
    try:
        total, length = pointer.read_text("ascii").split()
        blob = directory / _blob_name(key, total, suffix)
        data = blob.read_bytes()
    except (OSError, ValueError):
        return None
    if len(data) != int(length) or hashlib.sha256(data).hexdigest() != total:
        return None
    with contextlib.suppress(OSError):
        if time.time() - pointer.stat().st_mtime > 86400.0:
            os.utime(pointer)
            os.utime(blob)
    return blob


def _replace(path: Path, data: bytes) -> None:
    """Writes a file aside and moves it into place; an identical file in use there is good enough."""
    handle, aside = tempfile.mkstemp(prefix=".tmp-", dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.chmod(aside, 0o644)
        os.replace(aside, path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(aside)
        if not (path.is_file() and path.read_bytes() == data):
            raise


def _sweep(directory: Path) -> None:
    """Removes what dead writers left behind and entries that nobody asked for in three months."""
    now = time.time()
    with contextlib.suppress(OSError):
        for entry in os.scandir(directory):
            limit = _STALE_TEMPORARY if entry.name.startswith(".tmp-") else _UNUSED
            with contextlib.suppress(OSError):
                if entry.is_file(follow_symlinks=False) and now - entry.stat().st_mtime > limit:
                    os.unlink(entry.path)


def _writable(directory: Path) -> Path:
    """The directory, made if needed; raises OSError where a file of some size cannot be written in it."""
    directory.mkdir(parents=True, exist_ok=True)
    handle, probe = tempfile.mkstemp(prefix=".tmp-", dir=directory)
    try:
        os.write(handle, bytes(65536))
    finally:
        os.close(handle)
        os.unlink(probe)
    return directory


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()
