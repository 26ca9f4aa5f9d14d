"""resources/gearblocks.json: what is needed to repeat the FMU's run in-process. The FMU itself never reads it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmu_export.options import SolverOptions
from gearblocks.program import EnergyInfo, InputInfo, IntegralInfo, ParameterInfo, Program, Quantity, SwitchInfo

NAME = "resources/gearblocks.json"
FORMAT = 1

_ROWS = {
    "parameters": ParameterInfo,
    "inputs": InputInfo,
    "states": Quantity,
    "switches": SwitchInfo,
    "outputs": Quantity,
    "energies": EnergyInfo,
    "integrals": IntegralInfo,
}


@dataclass(frozen=True, slots=True, eq=False)
class Manifest:
    """A program with its values and settings.

    start: state vector (length n_total), or None for the program's own. outputs: name in the FMU and index in the
    program of every output shown.
    """

    program: Program
    values: NDArray[np.float64]
    solver: SolverOptions
    start: NDArray[np.float64] | None
    outputs: tuple[tuple[str, int], ...]


def to_json(manifest: Manifest, token: str) -> bytes:
    """The file's bytes; the C text is left out, it lies in sources/model.c."""
    program = asdict(manifest.program)
    del program["source"]
    content = {
        "format": FORMAT,
        "token": token,
        "program": program,
        "values": [float(v) for v in manifest.values],
        "start": None if manifest.start is None else [float(v) for v in manifest.start],
        "solver": asdict(manifest.solver),
        "outputs": [list(shown) for shown in manifest.outputs],
    }
    return (json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n").encode()


def from_json(data: bytes, source: str) -> Manifest:
    """The manifest, with `source` as the C text. Raises KeyError, TypeError or ValueError for other content."""
    content = json.loads(data)
    if content["format"] != FORMAT:
        raise ValueError(f"format {content['format']!r} of {NAME} is unknown; this version reads {FORMAT}")
    raw: dict[str, Any] = {**content["program"], "source": source}
    for name, row in _ROWS.items():
        raw[name] = tuple(row(**entry) for entry in raw[name])
    raw["structural"] = tuple((path, value) for path, value in raw["structural"])
    known = {field.name for field in fields(Program)}
    start = content["start"]
    return Manifest(
        Program(**{name: value for name, value in raw.items() if name in known}),
        np.array(content["values"], dtype=np.float64),
        SolverOptions(**content["solver"]),
        None if start is None else np.array(start, dtype=np.float64),
        tuple((str(name), int(index)) for name, index in content["outputs"]),
    )
