"""check(): an FMU looked at from outside, run by fmpy, and compared with the run in-process."""

from __future__ import annotations

import os
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_export import manifest
from fmu_export.binary import native_platform
from fmu_export.checks import file as check_file
from fmu_export.checks import lifecycle
from fmu_export.checks.instance import Unpacked
from fmu_export.checks.replay import replay
from fmu_export.checks.report import Item, Report
from gearblocks.errors import ParameterError


def check(path: str | os.PathLike[str], *, t_end: float | None = None, steps: int = 500) -> Report:
    """Report on an FMU: files, fmpy's validation, life cycle, a run by fmpy and the difference from the run in-process.

    t_end [s]: end of the run, by default that of the description; steps: communication steps of the run. FMUs of
    others are checked as far as it goes. A check that cannot be made is listed, a check that breaks down has failed.
    Raises ParameterError where there is no FMU at `path`.
    """
    fmu = Path(path)
    if not fmu.is_file():
        raise ParameterError(f"there is no file '{fmu}'")
    if not zipfile.is_zipfile(fmu):
        raise ParameterError(f"'{fmu}' is no FMU: it is not a zip file")
    items = [
        _guarded("archive", lambda: check_file.check_archive(fmu)),
        _guarded("fmpy validation", lambda: check_file.check_validation(fmu)),
    ]
    differences: dict[str, float] = {}
    with tempfile.TemporaryDirectory(prefix="gearblocks-check-", ignore_cleanup_errors=True) as place:
        unpacked = _unpack(fmu, Path(place), items)
        if unpacked is not None:
            items += _checks(unpacked, t_end, steps, differences)
    return Report(fmu, tuple(items), tuple(differences.items()))


def _unpack(fmu: Path, folder: Path, items: list[Item]) -> Unpacked | None:
    from fmpy import extract, read_model_description

    try:
        extract(str(fmu), str(folder))
        return Unpacked(folder, read_model_description(str(folder), validate=False))
    except Exception as error:  # noqa: BLE001 - what fmpy cannot read is for the report, whatever it raises
        items.append(Item("description", False, f"cannot be read: {error}"))
        return None


def _guarded(name: str, call: Callable[[], Item]) -> Item:
    try:
        return call()
    except Exception as error:  # noqa: BLE001 - a check that breaks down has failed, and says so
        return Item(name, False, f"{type(error).__name__}: {error}")


def _checks(unpacked: Unpacked, t_end: float | None, steps: int, differences: dict[str, float]) -> list[Item]:
    description = unpacked.description
    items = [_guarded("description", lambda: check_file.check_description(description))]
    if description.fmiVersion != "2.0" or description.coSimulation is None:
        return [*items, Item("run", None, "only FMI 2.0 co-simulation is run by this version")]
    begin, stop = _times(description, t_end)
    h = (stop - begin) / steps
    calls: dict[str, Callable[[], Item]] = {
        "binary": lambda: check_file.check_binary(unpacked, native_platform()),
        "token": lambda: lifecycle.check_token(unpacked),
        "start values": lambda: lifecycle.check_start_values(unpacked),
        "refusals": lambda: lifecycle.check_refusals(unpacked, h),
        "saved state": lambda: lifecycle.check_saved_state(unpacked, h),
        "reset": lambda: lifecycle.check_reset(unpacked, h),
        "instances": lambda: lifecycle.check_instances(unpacked, h),
        "communication step": lambda: lifecycle.check_steps(unpacked, h, _tolerance(description)),
        "log": lambda: lifecycle.check_log(unpacked, h),
        "sources": lambda: check_file.check_sources(unpacked),
    }
    items += [_guarded(name, call) for name, call in calls.items()]
    results: list[Any] = []
    items.append(_guarded("run", lambda: _run(unpacked, begin, stop, h, results)))
    if results:
        items.append(_guarded("in-process", lambda: _compare(unpacked, results[0], stop, differences)))
    return items


def _times(description: Any, t_end: float | None) -> tuple[float, float]:
    experiment = description.defaultExperiment
    begin = float(experiment.startTime or 0.0) if experiment is not None else 0.0
    stop = begin + 1.0
    if experiment is not None and experiment.stopTime is not None:
        stop = float(experiment.stopTime)
    stop = stop if t_end is None else t_end
    if not stop > begin:
        raise ParameterError(f"t_end = {stop!r} s must be later than the start at {begin!r} s")
    return begin, stop


def _tolerance(description: Any) -> float:
    experiment = description.defaultExperiment
    return 1e-6 if experiment is None or experiment.tolerance is None else float(experiment.tolerance)


def _run(unpacked: Unpacked, begin: float, stop: float, h: float, results: list[Any]) -> Item:
    """One run by fmpy.simulate_fmu; the result is appended to `results`."""
    from fmpy import simulate_fmu

    result = simulate_fmu(str(unpacked.folder), start_time=begin, stop_time=stop, output_interval=h)
    results.append(result)
    names = result.dtype.names[1:]
    bad = [name for name in names if not np.all(np.isfinite(result[name]))]
    reached = bool(np.isclose(result["time"][-1], stop))
    words = f"fmpy: {len(result) - 1} steps to t = {stop:g} s, {len(names)} outputs"
    if bad:
        words += f"; not finite: {', '.join(bad[:3])}"
    return Item("run", reached and not bad, words if reached else f"{words}; ended at t = {result['time'][-1]:g} s")


def _compare(unpacked: Unpacked, result: Any, stop: float, differences: dict[str, float]) -> Item:
    """The run by fmpy against the run in-process of the same sources."""
    data, source = unpacked.folder / manifest.NAME, unpacked.folder / "sources" / "model.c"
    if not (data.is_file() and source.is_file()):
        return Item("in-process", None, "no FMU of gearblocks: nothing to compare with")
    content = manifest.from_json(data.read_bytes(), source.read_text(encoding="utf-8"))
    times = np.ascontiguousarray(result["time"], dtype=np.float64)
    outputs = replay(content, times, stop)
    equal = True
    for name, i in content.outputs:
        if name in result.dtype.names[1:]:
            equal = equal and bool(np.array_equal(result[name], outputs[:, i]))
            differences[name] = _difference(result[name], outputs[:, i])
    if equal:
        return Item("in-process", True, f"{len(differences)} outputs at {len(times)} points have equal bits")
    name, worst = max(differences.items(), key=lambda entry: entry[1])
    limit = 10 * content.solver.rtol
    return Item(
        "in-process", worst <= limit, f"largest difference {worst:.1e} of the peak, in '{name}' (limit {limit:.0e})"
    )


def _difference(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Largest difference relative to the largest value."""
    peak = float(np.max(np.abs(b), initial=0.0))
    gap = float(np.max(np.abs(a - b), initial=0.0))
    return gap / peak if peak > 0 else gap
