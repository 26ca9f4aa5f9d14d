"""Store of a study on disk (Zarr): written chunk by chunk as it goes, so that a study that was killed goes on where it was.

    out.zarr/  values (points, numbers)   messages (points, bytes)   done (points)   attributes: what the study is

The flags of a chunk are written after its values, each file in one step: what is flagged is whole. Needs gearblocks[zarr].
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import StorageError
from gearblocks.files import as_path

if TYPE_CHECKING:
    from gearblocks.analysis.study_point import Measured

FORMAT = "gearblocks study store 1"
_WORDS = 400  # bytes of a message


def needs_zarr(path: str | os.PathLike[str]) -> Any:
    """The package zarr, for what is a path. Raises StorageError where it is not installed."""
    as_path(path)
    try:
        import zarr
    except ImportError:
        raise StorageError(f"'{path}' needs the package zarr: pip install 'gearblocks[zarr]'") from None
    return zarr


@final
class StudyStore:
    """An open store. chunk: how many points are written together; done: which points are, shape (points,)."""

    def __init__(self, path: str | os.PathLike[str], group: Any) -> None:
        self.path, self._group = as_path(path), group
        self.chunk = int(group["done"].chunks[0])
        self.done: NDArray[np.bool_] = group["done"][:].astype(np.bool_)

    @staticmethod
    def found(path: str | os.PathLike[str], identity: Mapping[str, str]) -> StudyStore | None:
        """The store at `path`, None where there is none. Raises StorageError where it holds another study."""
        zarr = needs_zarr(path)
        if not as_path(path).exists():
            return None
        try:
            group = zarr.open_group(as_path(path), mode="r+")
            kept = dict(group.attrs)
            if "done" not in group and kept.get("format") == FORMAT:  # killed while it was made
                return None
        except (OSError, ValueError, KeyError) as error:
            raise StorageError(
                f"'{path}' is no store of a study and is left alone ({error}); name another one"
            ) from error
        if kept.get("format") != FORMAT:
            raise StorageError(f"'{path}' is no store of a study of this version and is left alone; name another one")
        other = [name for name, digest in identity.items() if kept["identity"].get(name) != digest]
        if other:
            raise StorageError(
                f"the store '{path}' holds another study (what differs: {', '.join(other)}); name another store, or delete "
                "this one"
            )
        return StudyStore(path, group)

    @staticmethod
    def made(
        path: str | os.PathLike[str], identity: Mapping[str, str], points: int, width: int, chunk: int, words: Mapping[str, Any]
    ) -> StudyStore:  # fmt: skip
        """A new store. words: what the study is, for readers. Raises StorageError."""
        zarr = needs_zarr(path)
        try:
            group = zarr.open_group(as_path(path), mode="a")
            group.attrs.update({"format": FORMAT, "identity": dict(identity), "study": json.dumps(words)})
            group.create_array(
                "values", shape=(points, width), chunks=(chunk, width), dtype="f8", fill_value=float("nan")
            )
            group.create_array("messages", shape=(points, _WORDS), chunks=(chunk, _WORDS), dtype="u1", fill_value=0)
            group.create_array("done", shape=(points,), chunks=(chunk,), dtype="u1", fill_value=0)
        except (OSError, ValueError) as error:
            raise StorageError(f"cannot make the store '{path}': {error}") from error
        return StudyStore(path, group)

    def values(self) -> NDArray[np.float64]:
        """What is stored, NaN elsewhere."""
        found: NDArray[np.float64] = self._group["values"][:]
        return found

    def messages(self) -> dict[int, str]:
        """Stored messages by the number of the point."""
        raw = self._group["messages"][:]
        return {int(i): bytes(raw[i]).rstrip(b"\0").decode(errors="ignore") for i in np.flatnonzero(raw[:, 0])}

    def write(self, start: int, measured: Measured) -> None:
        """Stores a whole chunk that begins at point `start`. Raises StorageError."""
        rows = slice(start, start + len(measured.values))
        try:
            self._group["values"][rows] = measured.values
            if measured.messages:
                raw = np.zeros((len(measured.values), _WORDS), dtype=np.uint8)
                for i, words in measured.messages.items():
                    data = words.encode()[:_WORDS]
                    raw[i, : len(data)] = np.frombuffer(data, dtype=np.uint8)
                self._group["messages"][rows] = raw
            self._group["done"][rows] = np.ones(len(measured.values), dtype=np.uint8)
        except OSError as error:
            raise StorageError(f"cannot write the store '{self.path}': {error}; what it holds is whole") from error
        self.done[rows] = True
