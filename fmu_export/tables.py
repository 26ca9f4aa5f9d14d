"""The variable table of one model as C, and the token that ties description and binary together."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from typing import Any

from fmu_export.options import SolverOptions
from fmu_export.templates import render
from fmu_export.variables import KINDS, Variable
from gearblocks.codegen.program import Program

TOKEN_DIGITS = 64


def token_of(files: Mapping[str, bytes]) -> str:
    """Hash of the names and bytes of `files`, 64 hexadecimal digits: other ones for any other content."""
    hashed = hashlib.sha256()
    for name, data in sorted(files.items()):
        for part in (name.encode(), data):
            hashed.update(len(part).to_bytes(8, "little"))
            hashed.update(part)
    return hashed.hexdigest()


def render_table(
    program: Program, variables: Sequence[Variable], solver: SolverOptions, patience: float | None, token: str
) -> str:
    """Text of fmu_table.c. patience: processor time [s] after which a step stops on its way, or None."""
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
        quadratures=[{"name": c_string(f"{q.component}.{q.part}"), "index": q.offset} for q in program.integrals],
        switches=[c_string(f"{s.component}.{s.name}" if s.name else s.component) for s in program.switches],
        token=token,
        method=solver.to_core(None).method,
        locate=int(solver.locate),
        max_step=_number(solver.max_step, "HUGE_VAL"),
        patience=_number(patience, "HUGE_VAL"),
    )


def _entry(variable: Variable) -> dict[str, Any]:
    return {
        "name": c_string(variable.name),
        "index": variable.index,
        "tunable": int(variable.tunable),
        "start": _number(variable.start, "0.0"),
        "lower": _number(variable.lower, "-HUGE_VAL"),
        "upper": _number(variable.upper, "HUGE_VAL"),
        "open_lower": int(variable.open_lower),
        "open_upper": int(variable.open_upper),
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
