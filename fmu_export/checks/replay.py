"""The run of an FMU made in-process: its own model.c, compiled and stepped by gearblocks without any FMI in between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fmu_export.manifest import Manifest
from gearblocks.errors import SimulationError
from gearblocks.solver.library import compile_program
from gearblocks.solver.structures import Code


def replay(
    manifest: Manifest, times: NDArray[np.float64], stop: float | None, inputs: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Outputs at `times` (increasing; the first is the start), shape (times, outputs of the program).

    stop: end time that the solver knows of, or None. inputs: at the times, each held to the next one, shape (times, inputs);
    without them the inputs keep their start values. Raises SimulationError.
    """
    if inputs is not None:
        return _stepped(manifest, times, stop, inputs)
    program, solver = manifest.program, manifest.solver
    options = solver.to_core(stop)
    rows: list[NDArray[np.float64]] = []
    times = np.ascontiguousarray(times, dtype=np.float64)
    with compile_program(program).open() as simulation:
        simulation.parameters[:] = manifest.values
        simulation.inputs[:] = [u.start for u in program.inputs]
        simulation.changed()
        code = simulation.start(options, float(times[0]), manifest.start)
        record = simulation.record(len(times) + 1)
        while code >= 0:
            code = simulation.run(times, float(times[-1]), record)
            rows.append(record.take()[0])
            if code == Code.DONE:
                break
        if code < 0:
            report = simulation.report
            raise SimulationError(report.t, program.name, f"the run in-process ended with {Code(code).name}", "")
        pick = np.arange(len(program.outputs), dtype=np.intc)
        code, outputs, _ = simulation.evaluate(np.concatenate(rows), pick)
    if code < 0:
        raise SimulationError(float(times[-1]), program.name, "the outputs in-process are not finite", "")
    return outputs


def _stepped(
    manifest: Manifest, times: NDArray[np.float64], stop: float | None, inputs: NDArray[np.float64]
) -> NDArray[np.float64]:
    """From time to time with the inputs of each step, told to the solver where they change, as an FMU tells them."""
    program = manifest.program
    rows = []
    with compile_program(program).open() as simulation:
        simulation.parameters[:] = manifest.values
        simulation.inputs[:] = inputs[0]
        simulation.changed()
        code = simulation.start(manifest.solver.to_core(stop), float(times[0]), manifest.start)
        for k, t in enumerate(times):
            if k > 0 and code >= 0:
                if (inputs[k - 1] != simulation.inputs).any():
                    simulation.inputs[:] = inputs[k - 1]
                    simulation.changed()
                code = simulation.advance(float(t))
            if code < 0:
                report = simulation.report
                raise SimulationError(report.t, program.name, f"the run in-process ended with {Code(code).name}", "")
            rows.append(simulation.outputs())
    return np.array(rows)
