"""Bare numbers that runs and studies are given for parameters, and that are more than a field expects: one word for each path.

Knows nothing of what a field expects (`train/plausibility.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearblocks.errors import UnknownNameError
from gearblocks.language.units import has_unit
from gearblocks.simulation.arguments import resolve
from gearblocks.solver.library import Model
from gearblocks.train.graph import blocks_of
from gearblocks.train.plausibility import is_bare, warn_of_changed


def warn_of_parameters(model: Model, parameters: Mapping[str, Any] | None) -> None:
    """Warns of values by path."""
    for path, value in (parameters or {}).items():
        if is_bare(value):
            _warn(model, path, float(value), 'parameters={{"{path}": "{number:g} mm"}}')


def warn_of_rows(model: Model, rows: Mapping[str, Any]) -> None:
    """Warns of rows of values by path, or of one value: of the largest in each. What is no parameter is passed over."""
    for path, row in rows.items():
        cells = [row] if has_unit(row) or np.ndim(row) == 0 else row
        if numbers := [float(x) for x in cells if is_bare(x)]:
            _warn(model, path, max(numbers, key=abs), '{{"{path}": ["{number:g} mm"]}}')


def _warn(model: Model, path: str, value: float, meant: str) -> None:
    try:
        info = model.program.parameters[resolve(path, model.program.parameter_numbers, "parameter")]
    except UnknownNameError:
        return
    if model.tree is not None and not info.given_in:
        warn_of_changed(blocks_of(model.tree), info.path, value, meant)
