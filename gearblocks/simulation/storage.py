"""Runs as files: netCDF and JSON keep everything to the last bit, CSV keeps the outputs."""

from __future__ import annotations

import csv
import io
import json
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearblocks.errors import StorageError
from gearblocks.files import as_path, replacing, unreadable, write_bytes
from gearblocks.simulation.events import KINDS, Event, Events
from gearblocks.simulation.records import Array, Content, EnergyLedger, FinalState, Stats

if TYPE_CHECKING:
    import xarray

FORMAT = "gearblocks run 1"


def to_dataset(run: Content) -> xarray.Dataset:
    """Outputs over `t` with units; events along `event`; counters, energy and what else is known as attributes."""
    import xarray

    variables: dict[str, Any] = {
        name: ("t", np.array(values), {"units": run.units[name], "long_name": name})
        for name, values in run.arrays().items()
    }
    if run.events:
        rows = run.events.array
        components, component = _named(run.events.components, rows["component"])
        kinds, kind = _named(KINDS, rows["kind"])
        variables |= {
            "event_t": ("event", rows["t"].copy(), {"units": "s"}),
            "event_component": _codes(component, components),
            "event_kind": _codes(kind, kinds),
            "event_before": ("event", rows["before"].copy()),
            "event_after": ("event", rows["after"].copy()),
        }
    time = ("t", np.array(run.t), {"units": "s", "long_name": "time"})
    data = xarray.Dataset(variables, coords={"t": time})
    data.attrs = {"title": str(run.meta.get("train", "")), "format": FORMAT, "record": json.dumps(_record(run))}
    return data


def write_csv(run: Content, path: str | os.PathLike[str]) -> None:
    """`t` and every output as text with all digits, names in the first line. Raises StorageError."""
    with replacing(path) as file:
        text = io.TextIOWrapper(file, encoding="utf-8", newline="", write_through=True)
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(["t", *run.columns])
        for table in run.tables():
            for start in range(0, len(table), 1000):
                writer.writerows(table[start : start + 1000].tolist())
        text.detach()


def save(run: Content, path: str | os.PathLike[str]) -> None:
    """Store the run in the form that the ending of `path` names: .nc, .json or .csv. Raises StorageError."""
    _form(path, {".nc": _save_netcdf, ".json": _save_json, ".csv": write_csv})(run, path)


def load(path: str | os.PathLike[str]) -> Content:
    """The run stored in a .nc or .json file. Raises StorageError."""
    reader = _form(path, {".nc": _load_netcdf, ".json": _load_json})
    try:
        run: Content = reader(path)
        return run
    except StorageError:
        raise
    except OSError as error:
        raise unreadable(path, error) from error
    except (ValueError, KeyError, TypeError) as error:
        words = str(error).partition("\n")[0]
        raise StorageError(f"cannot read '{path}': it is not a stored run, or it is damaged ({words})") from error


def _form(path: str | os.PathLike[str], forms: Mapping[str, Callable[..., Any]]) -> Callable[..., Any]:
    ending = as_path(path).suffix.lower()
    if ending not in forms:
        raise StorageError(f"'{path}': the ending says how a run is stored and must be one of {', '.join(forms)}")
    return forms[ending]


# -- netCDF -----------------------------------------------------------------------------------------------------
def _save_netcdf(run: Content, path: str | os.PathLike[str]) -> None:
    if not len(run.t):
        raise StorageError(f"cannot write '{path}': the run is empty")
    data = to_dataset(run)
    for name in data.variables:
        if "/" in str(name):
            raise StorageError(f"cannot write '{path}': netCDF has no '/' in names, and there is '{name}'; use .json")
        data[name].encoding["_FillValue"] = None
    write_bytes(path, memoryview(data.to_netcdf(None, engine="scipy")))


def _load_netcdf(path: str | os.PathLike[str]) -> Content:
    import xarray

    data = xarray.load_dataset(io.BytesIO(Path(path).read_bytes()), engine="scipy", decode_cf=False)
    columns = {str(name): _doubles(data[name].values) for name in data.data_vars if data[name].dims == ("t",)}
    units = {name: str(data[name].attrs["units"]) for name in columns}
    return _restored(data.attrs, _doubles(data["t"].values), columns, units, _events(data))


def _events(data: xarray.Dataset) -> tuple[Event, ...]:
    if "event_t" not in data:
        return ()
    names = {name: json.loads(data[name].attrs["names"]) for name in ("event_component", "event_kind")}
    return tuple(
        Event(*row)
        for row in zip(
            data["event_t"].values.tolist(),
            (names["event_component"][code] for code in data["event_component"].values),
            (names["event_kind"][code] for code in data["event_kind"].values),
            data["event_before"].values.tolist(),
            data["event_after"].values.tolist(),
            strict=True,
        )
    )


def _named(names: Sequence[str], numbers: NDArray[np.int32]) -> tuple[list[str], NDArray[np.int32]]:
    """Those of the names that occur, sorted, and the numbers of these."""
    used, place = np.unique(numbers, return_inverse=True)
    words = [names[i] for i in used.tolist()]
    order = np.argsort(words)
    return [words[i] for i in order.tolist()], np.argsort(order).astype(np.int32)[place]


def _codes(numbers: NDArray[np.int32], names: list[str]) -> tuple[str, Any, dict[str, str]]:
    return "event", numbers, {"names": json.dumps(names)}


def _doubles(values: Any) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


# -- JSON -------------------------------------------------------------------------------------------------------
def _save_json(run: Content, path: str | os.PathLike[str]) -> None:
    content = {
        "format": FORMAT,
        "record": _record(run),
        "t": _plain(run.t),
        "outputs": {name: {"unit": run.units[name], "values": _plain(values)} for name, values in run.arrays().items()},
        "events": [_plain(event) for event in run.events],
    }
    write_bytes(path, json.dumps(content, allow_nan=False).encode())


def _load_json(path: str | os.PathLike[str]) -> Content:
    content = json.loads(Path(path).read_text(encoding="utf-8"))
    outputs = content["outputs"]
    columns = {name: _array(item["values"]) for name, item in outputs.items()}
    units = {name: item["unit"] for name, item in outputs.items()}
    events = tuple(Event(float(t), name, kind, float(a), float(b)) for t, name, kind, a, b in content["events"])
    return _restored(content, _array(content["t"]), columns, units, events)


# -- what is neither a column nor an event ------------------------------------------------------------------------
def _record(run: Content) -> dict[str, Any]:
    end = run.final_state
    return {
        "stats": asdict(run.stats),
        "energy": _plain(run.energy.to_dict()),
        "meta": _plain(dict(run.meta)),
        "final_state": end and _plain({"t": end.t, "y": end.y, "modes": end.modes, "key": end.key}),
    }


def _restored(
    content: Mapping[str, Any], t: Array, columns: dict[str, Array], units: dict[str, str], events: tuple[Event, ...]
) -> Content:
    if content["format"] != FORMAT:
        raise ValueError(f"its format is '{content['format']}', this version reads '{FORMAT}'")
    record = content["record"]
    record = json.loads(record) if isinstance(record, str) else record
    end = record["final_state"]
    return Content(
        t=t,
        columns=columns,
        units=units,
        events=Events.of(events),
        stats=Stats(**record["stats"]),
        energy=EnergyLedger(**_numbers(record["energy"])),
        meta=_numbers(record["meta"]),
        final_state=end and FinalState(float(end["t"]), _array(end["y"]), _array(end["modes"]), end["key"]),
    )


_SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


def _plain(value: Any) -> Any:
    """JSON form of nested values; numbers that JSON does not know become the words nan, inf and -inf."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        listed = value.tolist()
        return listed if np.isfinite(value).all() else _plain(listed)
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value if value is None or isinstance(value, (bool, int, float, str)) else str(value)


def _numbers(value: Any) -> Any:
    """What `_plain` was made from, but for tuples and arrays, which come back as lists."""
    if isinstance(value, dict):
        return {key: _numbers(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_numbers(item) for item in value]
    return _SPECIAL.get(value, value) if isinstance(value, str) else value


def _array(values: list[Any]) -> Array:
    return np.array([float(value) for value in values], dtype=np.float64)
