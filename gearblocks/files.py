"""Writing files so that nothing is ever half written.

The text or bytes go to a new file beside the target, which takes the target's place in one step at the end.
"""

from __future__ import annotations

import errno
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO, cast

from gearblocks.errors import GearblocksError, ParameterError, StorageError, did_you_mean


def reason(error: OSError) -> str:
    """Words of the operating system for `error`, without number and file name."""
    return (error.strerror or str(error) or type(error).__name__).lower()


def as_path(path: object) -> Path:
    """What is given as the name of a file. Raises ParameterError for what is none."""
    if not isinstance(path, (str, os.PathLike)) or isinstance(os.fspath(path), bytes) or path == "":
        raise ParameterError(f"path = {path!r:.80} must be the name of a file, as text or a pathlib.Path")
    return Path(path)


def unreadable(path: str | os.PathLike[str], error: OSError) -> StorageError:
    """The error of a file that cannot be read, with the way to one that can."""
    source = Path(path)
    if source.is_dir():
        return StorageError(f"cannot read '{path}': it is a folder; name a file")
    if not source.parent.is_dir():
        return StorageError(f"cannot read '{path}': there is no folder '{source.parent}'")
    if isinstance(error, FileNotFoundError):
        near = [one.name for one in source.parent.glob(f"*{source.suffix}")]
        return StorageError(f"cannot read '{path}': there is no such file here{did_you_mean(source.name, near)}")
    return StorageError(f"cannot read '{path}': {reason(error)}; copy it to where you may read it")


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open file whose content replaces `path` when the block ends well; else `path` stays as it was.

    Raises StorageError for every OSError inside the block (no space, no permission, no such folder).
    """
    target = as_path(path).resolve()  # a link keeps pointing where it points
    temporary: str | None = None
    try:
        if target.exists() and not target.is_file():
            what = "a folder" if target.is_dir() else "no regular file"
            raise StorageError(f"'{path}' is {what} and is left alone; name a file")
        handle, temporary = tempfile.mkstemp(prefix=f".{target.name[:40]}.", suffix=".tmp", dir=target.parent)
        with open(handle, "wb") as file:
            yield cast(BinaryIO, file)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, _mode(target))
        os.replace(temporary, target)
    except BaseException as error:
        if temporary is not None:
            with suppress(OSError):
                os.unlink(temporary)
        if isinstance(error, OSError) and not isinstance(error, GearblocksError):
            raise StorageError(_complaint(target, error)) from error
        raise


def write_bytes(path: str | os.PathLike[str], content: bytes | memoryview) -> None:
    """Write `content` to `path` in one step; raises StorageError and leaves an existing file alone."""
    with replacing(path) as file:
        file.write(content)


def write_text(path: str | os.PathLike[str], text: str) -> None:
    """Write `text` as UTF-8 with plain line ends to `path` in one step; raises StorageError."""
    write_bytes(path, text.encode())


def make_folder(path: str | os.PathLike[str]) -> Path:
    """The folder `path`, made with its parents where missing; raises StorageError."""
    folder = as_path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StorageError(f"cannot make the folder '{folder}': {reason(error)}; choose another place") from error
    return folder


def check_place(what: str, path: Path) -> None:
    """ParameterError where no file can be made at `path`, to be known before long work and not after it."""
    if not path.parent.is_dir():
        raise ParameterError(f"{what} {path}: there is no folder '{path.parent}'; make it or choose another place")
    try:
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ParameterError(
            f"{what} {path}: the folder '{path.parent}' cannot be written to ({reason(error)}); choose another place"
        ) from error


def _mode(target: Path) -> int:
    """Permissions of the file at `target`, else those of an ordinary new file."""
    try:
        return target.stat().st_mode & 0o777
    except OSError:
        mask = os.umask(0o077)
        os.umask(mask)
        return 0o666 & ~mask


def _complaint(target: Path, error: OSError) -> str:
    if not target.parent.is_dir():
        return f"cannot write '{target}': there is no folder '{target.parent}'; make it or choose another place"
    kept = "; the file that was there is unchanged" if target.exists() else ""
    full = error.errno in (errno.ENOSPC, getattr(errno, "EDQUOT", None), errno.EFBIG)
    return f"cannot write '{target}': {reason(error)}{kept}; {'free some space or ' * full}choose another place"
