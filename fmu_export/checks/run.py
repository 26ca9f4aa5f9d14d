"""One run of the whole window by fmpy, and how far it is from the run in-process of the same sources."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from fmu_export import manifest
from fmu_export.checks.instance import Plan
from fmu_export.checks.replay import replay
from fmu_export.checks.report import Item

Inputs: TypeAlias = Mapping[str, NDArray[np.float64]]
"""Values at the communication points, by name."""


def check_run(plan: Plan, inputs: Inputs, results: list[Any]) -> Item:
    """One run by fmpy.simulate_fmu, inputs at the communication points given; the result is appended to `results`."""
    from fmpy import simulate_fmu

    begin, stop, folder = plan.begin, plan.stop, str(plan.unpacked.folder)
    signals = None
    if inputs:
        signals = np.empty(len(plan.points), dtype=[("time", np.float64), *((name, np.float64) for name in inputs)])
        for name, values in (("time", plan.points), *inputs.items()):
            signals[name] = values
    result = simulate_fmu(folder, start_time=begin, stop_time=stop, output_interval=plan.h, input=signals)
    results.append(result)
    names = result.dtype.names[1:]
    numbers = [name for name in names if result[name].dtype.kind == "f"]
    bad = [name for name in numbers if not np.all(np.isfinite(result[name]))]
    reached = bool(np.isclose(result["time"][-1], stop))
    words = f"fmpy: {len(result) - 1} steps to t = {stop:g} s, {len(names)} outputs{_of_inputs(plan, inputs)}"
    if bad:
        words += f"; not finite: {', '.join(bad[:3])}"
    if not reached:  # it may end the simulation by itself
        words += f"; ended at t = {result['time'][-1]:g} s"
    return Item("run", False if bad else True if reached else None if not plan.unpacked.own else False, words)


def _of_inputs(plan: Plan, inputs: Inputs) -> str:
    """What the inputs of the run were."""
    left = [v.name for v in plan.unpacked.description.modelVariables if v.causality == "input" and v.name not in inputs]
    words = f", inputs {_listed([*inputs])} as given, held over each step" if inputs else ""
    return words + (f", inputs {_listed(left)} at their start values (inputs= gives others)" if left else "")


def _listed(names: list[str]) -> str:
    return ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")


def compare(plan: Plan, inputs: Inputs, result: Any, differences: dict[str, float]) -> Item:
    """The run by fmpy against the run in-process of the same sources and inputs."""
    unpacked = plan.unpacked
    if not unpacked.own:
        return Item("in-process", None, "no FMU of gearblocks: nothing to compare with")
    data, source = unpacked.folder / manifest.NAME, unpacked.folder / "sources" / "model.c"
    content = manifest.from_json(data.read_bytes(), source.read_text(encoding="utf-8"))
    times = np.ascontiguousarray(result["time"], dtype=np.float64)
    outputs = replay(content, times, plan.stop, _held(content, inputs, plan, times))
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


def _held(
    content: manifest.Manifest, inputs: Inputs, plan: Plan, times: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """All inputs of the program at the times; None where they stay as they start."""
    if not inputs:
        return None
    held = np.tile([u.start for u in content.program.inputs], (len(times), 1))
    for name, values in inputs.items():
        held[:, content.program.input_numbers[name]] = np.interp(times, plan.points, values)
    return held


def _difference(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Largest difference relative to the largest value."""
    peak = float(np.max(np.abs(b), initial=0.0))
    gap = float(np.max(np.abs(a - b), initial=0.0))
    return gap / peak if peak > 0 else gap
