"""A folder with the motions of a diagram that are known, so that one that was killed goes on where it was.

    d/diagram.json       what the diagram is
    d/up-0001.npz, ...   of each motion: points, last states, and its label with what that rests on, or why there is none

A file is written in one step, when its motion has its label. Knows nothing of how labels are found.
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.analysis.regimes.carried import DIRECTIONS
from gearblocks.analysis.regimes.exponents import LyapunovExponents
from gearblocks.analysis.regimes.orbit import PeriodicOrbit
from gearblocks.analysis.regimes.regime import Regime
from gearblocks.analysis.regimes.strobe import GrowthError
from gearblocks.errors import SimulationError, StorageError
from gearblocks.files import as_path, make_folder, write_bytes, write_text
from gearblocks.simulation.records import FinalState

Array = NDArray[np.float64]

FORMAT = "gearblocks diagram store 3"
_KINDS = {
    kind.__name__: kind for kind in (Regime, PeriodicOrbit, FinalState, LyapunovExponents, SimulationError, GrowthError)
}
_WORDS = ("time", "component", "cause", "remedy")  # of an error
_BROKEN = (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile)


class Told(NamedTuple):
    """A motion. points: of the output at the section; last: states at the last of them, None where it could not be run;
    found: its label, or why there is none."""

    points: Array
    last: Array | None
    found: str | Regime | SimulationError


@final
class DiagramStore:
    """An open store. known: its motions by (direction, number of the value)."""

    def __init__(self, path: str | os.PathLike[str], identity: Mapping[str, str]) -> None:
        """Opened, or made. Raises StorageError where there is something else, or another diagram."""
        self.path = as_path(path)
        mark = self.path / "diagram.json"
        if not self.path.exists() or (self.path.is_dir() and not any(self.path.iterdir())):
            make_folder(self.path)
            write_text(mark, json.dumps({"format": FORMAT, "identity": dict(identity)}, indent=1))
        try:
            kept = json.loads(mark.read_text(encoding="utf-8"))
            held = kept["identity"] if kept["format"] == FORMAT else None
        except _BROKEN as error:
            raise StorageError(f"'{path}' is no store of a diagram and is left alone; name another one") from error
        if held is None:
            raise StorageError(f"'{path}' is no store of a diagram of this version and is left alone; name another one")
        other = [name for name, digest in identity.items() if held.get(name) != digest]
        if other:
            raise StorageError(
                f"the store '{path}' holds another diagram (what differs: {', '.join(other)}); name another store, or "
                "delete this one"
            )
        self.known = {point: told for point in self._points() if (told := self._read(point)) is not None}

    def write(self, point: tuple[int, int], told: Told) -> None:
        """Keeps a motion. Raises StorageError."""
        arrays: dict[str, Any] = {}
        words = json.dumps(_packed(told._asdict(), "told", arrays))
        file = io.BytesIO()
        np.savez(file, words=np.array(words), **arrays)
        write_bytes(self._file(point), file.getvalue())

    def _file(self, point: tuple[int, int]) -> Path:
        return self.path / f"{DIRECTIONS[point[0]]}-{point[1]:04d}.npz"

    def _points(self) -> list[tuple[int, int]]:
        found = []
        for file in sorted(self.path.glob("*-*.npz")):
            direction, _, number = file.stem.partition("-")
            if direction in DIRECTIONS and number.isdecimal():
                found.append((DIRECTIONS.index(direction), int(number)))
        return found

    def _read(self, point: tuple[int, int]) -> Told | None:
        """A motion; None where its file is broken."""
        try:
            with np.load(self._file(point), allow_pickle=False) as file:
                return Told(**_unpacked(json.loads(str(file["words"])), file))
        except _BROKEN:
            return None


def _packed(thing: Any, name: str, arrays: dict[str, Any]) -> Any:
    """What JSON takes of it; arrays go beside, by name."""
    if isinstance(thing, np.ndarray):
        arrays[name] = thing
        return {"array": name}
    if isinstance(thing, SimulationError):
        return {"kind": type(thing).__name__, "fields": {word: getattr(thing, word) for word in _WORDS}}
    if is_dataclass(thing):
        given = {f.name: _packed(getattr(thing, f.name), f"{name}.{f.name}", arrays) for f in fields(thing)}
        return {"kind": type(thing).__name__, "fields": given}
    if isinstance(thing, Mapping):
        return {key: _packed(value, f"{name}.{key}", arrays) for key, value in thing.items()}
    if isinstance(thing, tuple):
        return [_packed(value, f"{name}.{i}", arrays) for i, value in enumerate(thing)]
    return thing


def _unpacked(thing: Any, arrays: Mapping[str, Any]) -> Any:
    if isinstance(thing, list):
        return tuple(_unpacked(value, arrays) for value in thing)
    if not isinstance(thing, dict):
        return thing
    if "array" in thing:
        return arrays[thing["array"]]
    if "kind" in thing:
        return _KINDS[thing["kind"]](**_unpacked(thing["fields"], arrays))
    return {key: _unpacked(value, arrays) for key, value in thing.items()}
