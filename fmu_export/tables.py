"""The variable table of one model as C, and the token that ties description and binary together."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from fmu_export.options import SolverOptions
from fmu_export.templates import render
from fmu_export.variables import KINDS, Variable
from gearblocks.codegen.program import Program


def token_of(program: Program, variables: Sequence[Variable], solver: SolverOptions) -> str:
    """Hash of the canonical content: 64 hexadecimal digits, other ones for any other model, variables or settings."""
    content = {
        "program": program.key,
        "source": hashlib.sha256(program.source.encode()).hexdigest(),
        "variables": [asdict(v) for v in variables],
        "solver": asdict(solver),
    }
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def render_table(program: Program, variables: Sequence[Variable], solver: SolverOptions, token: str) -> str:
    """Text of fmu_table.c."""
    kinds = []
    for kind in KINDS:
        entries = [_entry(v) for v in variables if v.kind == kind]
        symbol = f"{kind}_entries" if entries else "NULL"
        kinds.append({"name": kind, "entries": entries, "count": len(entries), "symbol": symbol})
    return render(
        "fmu_table.c.jinja",
        name=program.name.replace("*/", "").replace("\n", " "),
        kinds=kinds,
        states=[c_string(q.name) for q in program.states],
        switches=[c_string(f"{s.component}.{s.name}" if s.name else s.component) for s in program.switches],
        token=token,
        method=solver.to_core(None).method,
        locate=int(solver.locate),
        max_step=_number(solver.max_step, "HUGE_VAL"),
    )


def _entry(variable: Variable) -> dict[str, Any]:
    return {
        "name": c_string(variable.name),
        "index": variable.index,
        "tunable": int(variable.tunable),
        "start": _number(variable.start, "0.0"),
        "lower": _number(variable.lower, "-HUGE_VAL"),
        "upper": _number(variable.upper, "HUGE_VAL"),
    }


def _number(value: float | None, otherwise: str) -> str:
    """A C literal that reads back to the same double."""
    if value is None or value in (float("inf"), float("-inf")):
        return otherwise
    return repr(float(value))


def c_string(text: str) -> str:
    """A C string literal of the UTF-8 bytes of `text`."""
    plain = "".join(
        chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}" for byte in text.encode()
    )
    return f'"{plain}"'
