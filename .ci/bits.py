"""Prints one run of every method to the last bit: what must be the same on every processor."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import numpy as np

import gearblocks as gb
from gearblocks.solver.lanes import Lanes, LaneSteps
from models import planetary_backlash

MODEL = gb.build(planetary_backlash.planetary(planetary_backlash.Numbers()))

for method in ("rk4", "dp5", "dp8", "rodas", "auto"):
    run = gb.simulate(MODEL, t_end=2e-3, method=method, rtol=1e-7, step=1e-6 if method == "rk4" else None)
    assert run.final_state is not None
    print(method, run.stats.steps, run.stats.events, *(float(y).hex() for y in run.final_state.y))

rows = np.tile(MODEL.values, (3, 1))
found = Lanes(MODEL, [0]).run(rows, np.array([1e-6, 8e-7, 1.2e-6]), MODEL.program.input_starts, LaneSteps(steps=2000))
print("lanes", *(float(y).hex() for y in found.last.ravel()))
