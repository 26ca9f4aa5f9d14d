"""`python -m benchmarks.fmu [TRAIN ...]`: a second in an FMU at steps of 1 ms, one output read, beside the run in-process.

Through fmpy, whose calls of Python count; the row of one inertia says what they cost. Each kind of code that the binary holds.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

import fmu_export
import gearblocks as gb
from benchmarks.measure import machine
from benchmarks.problems import p1
from gearblocks.solver.variants import VARIABLE, runs
from models.spline_coupling import build as spline

TIMES = np.linspace(0.0, 1.0, 1001)
LEVELS = ("x86-64", "x86-64-v3", "x86-64-v4")


def one_inertia() -> gb.Drivetrain:
    """Next to nothing to compute."""
    rig = gb.Drivetrain("one inertia")
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), rig.add("body", gb.Inertia(J=1.0)))
    return rig


def in_fmu(path: Path, output: str) -> float:
    """CPU seconds of the quickest of some runs."""
    description, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    fmu = FMU2Slave(
        guid=description.guid, unzipDirectory=folder, modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="timed",
    )  # fmt: skip
    reference = [v.valueReference for v in description.modelVariables if v.name == output]
    fmu.instantiate()
    best = float("inf")
    for _ in range(5):
        fmu.setupExperiment(startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        began = time.process_time()
        for t in TIMES[:-1].tolist():
            fmu.doStep(currentCommunicationPoint=t, communicationStepSize=1e-3)
            fmu.getReal(reference)
        best = min(best, time.process_time() - began)
        fmu.reset()
    return best


def in_process(rig: gb.Drivetrain, output: str) -> float:
    """CPU seconds of the quickest of some runs, the whole call."""
    model, best = gb.build(rig), float("inf")
    for _ in range(5):
        began = time.process_time()
        gb.simulate(model, t=TIMES[1:], outputs=[output])[output].sum()
        best = min(best, time.process_time() - began)
    return best


def main() -> None:
    """Prints the table."""
    print(machine(), "\n")
    print("| train | code | FMU ms | in-process ms | ratio |\n|---|---|--:|--:|--:|")
    for name, rig, output in (
        ("one inertia", one_inertia(), "body.w"), ("P1", p1(), "mesh.force"), ("spline coupling", spline(), "spline.force"),
    ):  # fmt: skip
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        with tempfile.TemporaryDirectory() as folder:
            path = fmu_export.export(rig, Path(folder, "timed.fmu"))
            for level in ("", *(level for level in LEVELS if runs(level))):
                os.environ.pop(VARIABLE, None)
                own = in_process(rig, output)
                os.environ[VARIABLE] = level
                inside = in_fmu(path, output)
                print(f"| {name} | {level or 'best'} | {inside * 1e3:.3g} | {own * 1e3:.3g} | {inside / own:.2f} |")
            os.environ.pop(VARIABLE)


if __name__ == "__main__":
    main()
