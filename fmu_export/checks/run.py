"""One run of the whole window by fmpy, and how far it is from the run in-process of the same sources."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_export import manifest
from fmu_export.checks.instance import Plan, Unpacked
from fmu_export.checks.replay import replay
from fmu_export.checks.report import Item


def check_run(plan: Plan, results: list[Any]) -> Item:
    """One run by fmpy.simulate_fmu; the result is appended to `results`."""
    from fmpy import simulate_fmu

    begin, stop, folder = plan.begin, plan.stop, str(plan.unpacked.folder)
    result = simulate_fmu(folder, start_time=begin, stop_time=stop, output_interval=plan.h)
    results.append(result)
    names = result.dtype.names[1:]
    numbers = [name for name in names if result[name].dtype.kind == "f"]
    bad = [name for name in numbers if not np.all(np.isfinite(result[name]))]
    reached = bool(np.isclose(result["time"][-1], stop))
    words = f"fmpy: {len(result) - 1} steps to t = {stop:g} s, {len(names)} outputs"
    if bad:
        words += f"; not finite: {', '.join(bad[:3])}"
    if not reached:  # it may end the simulation by itself
        words += f"; ended at t = {result['time'][-1]:g} s"
    return Item("run", False if bad else True if reached else None if not plan.unpacked.own else False, words)


def compare(unpacked: Unpacked, result: Any, stop: float, differences: dict[str, float]) -> Item:
    """The run by fmpy against the run in-process of the same sources."""
    if not unpacked.own:
        return Item("in-process", None, "no FMU of gearblocks: nothing to compare with")
    data, source = unpacked.folder / manifest.NAME, unpacked.folder / "sources" / "model.c"
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
