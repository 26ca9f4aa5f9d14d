"""What a study found: a table of quantities over its points, with units, as arrays, pictures and files."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import StorageError, UnknownNameError, arguments_told, did_you_mean, missing_attribute
from gearblocks.files import as_path, replacing, unreadable, write_bytes
from gearblocks.language.tidy import Tidy, told
from gearblocks.pages import small_table
from gearblocks.plurals import singular
from gearblocks.train.summary import span_text

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

FORMAT = "gearblocks study 1"
_ENDS, _WIDE = 5, 110  # points at either end of a printed table, and letters in its lines


class Failure(NamedTuple):
    """A point that has no values: where it lies (by path), and why."""

    point: Mapping[str, float]
    message: str


@final
@arguments_told
@told
@dataclass(frozen=True, slots=True, eq=False)
class Study(metaclass=Tidy):
    """Quantities over the points of a study.

    paths, units: what varies, and its units; points: its values, shape (points, paths); shape: lengths of the dimensions of
    the grid, () for a list of cases. names, name_units, widths: the quantities, their units, and how many numbers each is;
    values: shape (points, numbers), NaN where a point failed or was not reached; done: which were, shape (points,).
    messages: by number of the point: why it failed, or why it is in doubt. meta: train, method, rtol, seconds and the like.
    """

    paths: tuple[str, ...]
    units: tuple[str, ...]
    points: Array
    shape: tuple[int, ...]
    names: tuple[str, ...]
    name_units: tuple[str, ...]
    widths: tuple[int, ...]
    values: Array
    done: NDArray[np.bool_]
    messages: Mapping[int, str] = field(default_factory=dict)
    meta: Mapping[str, Any] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        """False where the study was stopped before its end."""
        return bool(self.done.all())

    @property
    def failures(self) -> tuple[Failure, ...]:
        """Points that failed, in their order."""
        return self._named(failed=True)

    @property
    def doubts(self) -> tuple[Failure, ...]:
        """Points that have values, but whose energy does not balance."""
        return self._named(failed=False)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """Which points failed, shape (points,)."""
        found = np.zeros(len(self.points), dtype=np.bool_)
        found[[*self.messages]] = True
        return found & np.isnan(self.values).all(axis=1)

    def _named(self, *, failed: bool) -> tuple[Failure, ...]:
        lost = self.failed
        rows = [i for i in sorted(self.messages) if lost[i] == failed]
        return tuple(
            Failure(dict(zip(self.paths, self.points[i].tolist(), strict=True)), self.messages[i]) for i in rows
        )

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions: the paths of a grid, or "case"."""
        return self.paths if self.shape else ("case",)

    def __getitem__(self, name: str) -> Array:
        """Values of a quantity, shape of the grid (or (cases,)), with one more dimension for the points of a section; of a path
        that varies its value at each of them, in that shape."""
        if name in self.paths and name not in self.names:
            column: Array = self.points[:, self.paths.index(name)].reshape(self.shape or (len(self.points),))
            return column
        if name not in self.names:
            known = (*self.names, *self.paths)
            raise UnknownNameError(f"the study has no {name!r}; it has {', '.join(known)}{did_you_mean(name, known)}")
        i = self.names.index(name)
        begin, width = sum(self.widths[:i]), self.widths[i]
        values = self.values[:, begin : begin + width].reshape(*(self.shape or (len(self.points),)), width)
        return values[..., 0] if self.widths[i] == 1 else values

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            raise missing_attribute(self, name, outputs=() if name.startswith("_") else (*self.names, *self.paths))

    def __len__(self) -> int:
        return len(self.points)

    def _title(self) -> str:
        grid = f"{' x '.join(map(str, self.shape))} point{'s' * (len(self.points) != 1)}"
        size = grid if self.shape else singular(f"{len(self.points)} cases")
        return f"study of '{self.meta.get('train', '')}': {size} over {', '.join(self.paths)}"

    def _spans(self) -> list[tuple[str, str]]:
        """Each quantity and the range of its values."""
        rows = []
        for name, unit in zip(self.names, self.name_units, strict=True):
            found = self[name]
            known = found[np.isfinite(found)]
            span = span_text(known.min(), known.max(), self._size(name)) if known.size else "no value"
            each = found.reshape(len(self.points), -1)
            none = int((np.isnan(each).all(axis=1) & self.done & ~self.failed).sum()) if known.size else 0
            said = f", none at {none} of {len(self.points)} points" if none else ""
            rows.append((name, f"{span}{'' if unit in ('', '1') else ' ' + unit}{said}"))
        return rows

    def _size(self, name: str) -> float:
        """The largest value that a quantity and others of the same output have: a trough of 1e-23 beside a peak of 100 is 0."""
        units, of = dict(zip(self.names, self.name_units, strict=True)), name.partition("(")[2]
        alike = [
            self[x] for x in self.names if x == name or (of and of == x.partition("(")[2] and units[x] == units[name])
        ]
        return max((float(np.abs(x[np.isfinite(x)]).max()) for x in alike if np.isfinite(x).any()), default=0.0)

    def _notes(self) -> list[str]:
        """What was stopped, failed, or is in doubt."""
        lines = [f"stopped early: {int(self.done.sum())} of {len(self.points)} points are done"] * (not self.complete)
        for what, found in (("failed", self.failures), ("in doubt", self.doubts)):
            if found:
                lines.append(
                    singular(f"{len(found)} points {what}; first {_words(found[0].point)}: {found[0].message}")
                )
        return lines

    def _repr_html_(self) -> str:
        title = self._title()
        return small_table(title[0].upper() + title[1:], self._spans(), head=("quantity", "range"), notes=self._notes())

    def __repr__(self) -> str:
        lines = [f"<{self._title()}", *(f"  {name}: {span}" for name, span in self._spans())]
        return "\n".join([*lines, *(f"  {note}" for note in self._notes())]) + ">"

    def __str__(self) -> str:
        """What it is, the ranges, and its first and last points as a table."""
        title = self._title()
        lines = [title[0].upper() + title[1:], *(f"  {name}: {span}" for name, span in self._spans())]
        return "\n".join([*lines, *(f"  {note}" for note in self._notes()), "", *self._table()])

    def _table(self) -> list[str]:
        """Lines of the first and last points, as many columns as fit."""
        single = [
            (n, u, np.where(abs(self[n].ravel()) < 1e-12 * self._size(n), 0.0, self[n].ravel()))
            for n, u, w in zip(self.names, self.name_units, self.widths, strict=True)
            if w == 1
        ]
        columns = [*zip(self.paths, self.units, self.points.T, strict=True), *single]
        n = len(self.points)
        rows = range(n) if n <= 2 * _ENDS + 1 else [*range(_ENDS), None, *range(n - _ENDS, n)]
        shown: list[list[str]] = []
        for name, unit, values in columns:
            cells = ["..." if i is None else _cell(values[i], bool(self.done[i]), bool(self.failed[i])) for i in rows]
            cells = [name, "" if unit in ("", "1") else unit, *cells]
            width = max(map(len, cells))
            if shown and sum(len(column[0]) + 2 for column in shown) + width > _WIDE:
                break
            shown.append([cell.rjust(width) for cell in cells])
        lines = [line for line in ("  ".join(row).rstrip() for row in zip(*shown, strict=True)) if line]
        hidden = len(self.paths) + len(self.names) - len(shown)
        return (
            [*lines, f"and {hidden} more column{'s' * (hidden > 1)}: to_xarray() or to_csv() has all"]
            if hidden
            else lines
        )

    # -- elsewhere ----------------------------------------------------------------------------------------------------

    def to_xarray(self) -> xarray.Dataset:
        """One variable per quantity over the values of each path (or over `case`), with units."""
        import xarray

        variables: dict[str, Any] = {}
        for name, unit, width in zip(self.names, self.name_units, self.widths, strict=True):
            dims = (*self.dims, f"point of {name}") if width > 1 else self.dims
            variables[name] = (dims, self[name].copy(), {"units": unit, "long_name": name})
        coords: dict[str, Any] = {}
        for i, (path, unit) in enumerate(zip(self.paths, self.units, strict=True)):
            attributes = {"units": unit, "long_name": path}
            if self.shape:
                levels = self.points[:, i].reshape(self.shape)[
                    tuple(slice(None) if j == i else 0 for j in range(len(self.shape)))
                ]
                coords[path] = (path, levels.copy(), attributes)
            else:
                coords[path] = ("case", self.points[:, i].copy(), attributes)
        data = xarray.Dataset(variables, coords=coords)
        data.attrs = {"title": str(self.meta.get("train", "")), "format": FORMAT, "record": json.dumps(self.record())}
        return data

    def record(self) -> dict[str, Any]:
        """All but the values, in JSON's terms."""
        return {
            "paths": self.paths, "units": self.units, "shape": self.shape, "names": self.names,
            "name_units": self.name_units, "widths": self.widths,
            "messages": {str(i): words for i, words in self.messages.items()},
            "missing": np.flatnonzero(~self.done).tolist(), "meta": dict(self.meta),
        }  # fmt: skip

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """A line of names, then one line per point in full precision: paths, quantities, message. Raises StorageError."""
        head = [*self.paths]
        for name, width in zip(self.names, self.widths, strict=True):
            head += [name] if width == 1 else [f"{name}[{i}]" for i in range(width)]
        with replacing(path) as file:
            text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
            writer = csv.writer(text, lineterminator="\n")
            writer.writerow([*head, "message"])
            for i, (point, row) in enumerate(zip(self.points.tolist(), self.values.tolist(), strict=True)):
                writer.writerow([*point, *row, self.messages.get(i, "")])
            text.detach()

    def save(self, path: str | os.PathLike[str]) -> None:
        """Store everything in a `.nc` (netCDF) file or a `.zarr` folder (needs gearblocks[zarr]), or a table as `.csv`.
        Raises StorageError."""
        ending = as_path(path).suffix.lower()
        if ending == ".csv":
            self.to_csv(path)
        elif ending == ".nc":
            data = self.to_xarray()
            for name in data.variables:
                if "/" in str(name):
                    raise StorageError(f"cannot write '{path}': netCDF has no '/' in names, and there is '{name}'")
            write_bytes(path, memoryview(data.to_netcdf(None, engine="scipy")))
        elif ending == ".zarr":
            from gearblocks.analysis.study_store import needs_zarr

            needs_zarr(path)
            if Path(path).exists():
                raise StorageError(f"'{path}' is there already; take another name")
            self.to_xarray().to_zarr(Path(path), mode="w-", consolidated=False)
        else:
            raise StorageError(f"'{path}': the ending says how a study is stored and must be one of .nc, .zarr, .csv")

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Study:
        """The study that `save` put into a `.nc` file or a `.zarr` folder, bit for bit. Raises StorageError."""
        import xarray

        ending = as_path(path).suffix.lower()
        if ending not in (".nc", ".zarr"):
            raise StorageError(f"'{path}': the ending says how a study is stored and must be one of .nc, .zarr")
        try:
            if ending == ".nc":
                data = xarray.load_dataset(io.BytesIO(Path(path).read_bytes()), engine="scipy")
            else:
                from gearblocks.analysis.study_store import needs_zarr

                needs_zarr(path)
                data = xarray.open_zarr(Path(path), consolidated=False).load()
            return _restored(data)
        except OSError as error:
            raise unreadable(path, error) from error
        except (ValueError, KeyError, TypeError) as error:
            words = str(error).partition("\n")[0]
            raise StorageError(f"cannot read '{path}': it is not a stored study, or it is damaged ({words})") from error

    def plot(self, *names: str, path: str | os.PathLike[str] | None = None) -> Figure:
        """Figure of the quantities (default all), one panel each: lines over one dimension, colours over two, cases over each
        value that varies in them; points without a value are crosses. Saved to `path` where given. Raises UnknownNameError,
        ParameterError for more dimensions."""
        from gearblocks.analysis.study_pictures import picture

        for name in names:
            self[name]
        return picture(self, names or self.names, path)


def _restored(data: xarray.Dataset) -> Study:
    if data.attrs["format"] != FORMAT:
        raise ValueError(f"its format is '{data.attrs['format']}', this version reads '{FORMAT}'")
    record = json.loads(data.attrs["record"])
    paths, shape = tuple(record["paths"]), tuple(record["shape"])
    axes: list[Array] = [np.ascontiguousarray(data[path].values, dtype=np.float64) for path in paths]
    points = (
        np.column_stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")])
        if shape
        else np.column_stack(axes)
    )
    values = np.column_stack(
        [np.asarray(data[name].values, dtype=np.float64).reshape(len(points), -1) for name in record["names"]]
    )
    done = np.ones(len(points), dtype=np.bool_)
    done[record["missing"]] = False
    return Study(
        paths, tuple(record["units"]), points, shape, tuple(record["names"]), tuple(record["name_units"]),
        tuple(record["widths"]), values, done, {int(i): words for i, words in record["messages"].items()}, record["meta"],
    )  # fmt: skip


def _cell(value: float, done: bool, failed: bool) -> str:
    """A value in a printed table; none where a run has no such value, as a time of an event that did not come."""
    return f"{value:.6g}" if np.isfinite(value) else "not done" if not done else "failed" if failed else "none"


def _words(point: Mapping[str, float]) -> str:
    return ", ".join(f"{path} = {x:.6g}" for path, x in point.items())


def listed(failures: Sequence[Failure], most: int = 3) -> str:
    """The first failures in words."""
    lines = [f"{_words(failure.point)}: {failure.message}" for failure in failures[:most]]
    return "\n  ".join([*lines, *([f"and {len(failures) - most} more"] if len(failures) > most else [])])
