"""resources/gearblocks.json: what is needed to repeat the FMU's run in-process. The FMU itself never reads it."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, get_args, get_type_hints

import numpy as np
from numpy.typing import NDArray

from fmu_export.options import SolverOptions
from gearblocks.codegen.output_list import OutputList, Quantity
from gearblocks.codegen.program import Program

NAME = "resources/gearblocks.json"
FORMAT = 2


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
    program = asdict(manifest.program) | {"outputs": [*manifest.program.outputs]}
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
    program = {**content["program"], "source": source}
    start = content["start"]
    return Manifest(
        Program(**{name: _read(kind, program[name]) for name, kind in get_type_hints(Program).items()}),
        np.array(content["values"], dtype=np.float64),
        SolverOptions(**content["solver"]),
        None if start is None else np.array(start, dtype=np.float64),
        tuple((str(name), int(index)) for name, index in content["outputs"]),
    )


def _read(kind: Any, value: Any) -> Any:
    """A field of Program from its JSON form: lists become tuples, of the rows that the field's type names."""
    if not isinstance(value, list):
        return value
    if kind is OutputList:
        return OutputList.of(map(Quantity._make, value))
    row = get_args(kind)[0]
    return tuple(row(*entry) if hasattr(row, "_make") else tuple(entry) for entry in value)
