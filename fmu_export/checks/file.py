"""Checks of an FMU's files that need no run: archive, description, binary, sources."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fmu_export.archive import irregularities
from fmu_export.checks.elf import read_shared_library
from fmu_export.checks.instance import Unpacked
from fmu_export.checks.report import Item
from gearblocks.errors import CompileError
from gearblocks.solver.compiler import SHARED_SUFFIX, find_compiler

_FUNCTIONS = (
    *("GetTypesPlatform", "GetVersion", "SetDebugLogging", "Instantiate", "FreeInstance", "SetupExperiment"),
    *("EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset", "DoStep", "CancelStep"),
    *("GetReal", "GetInteger", "GetBoolean", "GetString", "SetReal", "SetInteger", "SetBoolean", "SetString"),
    *("GetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializedFMUstateSize", "SerializeFMUstate"),
    *("DeSerializeFMUstate", "GetDirectionalDerivative", "SetRealInputDerivatives", "GetRealOutputDerivatives"),
    *("GetStatus", "GetRealStatus", "GetIntegerStatus", "GetBooleanStatus", "GetStringStatus"),
)
MANDATORY = frozenset(f"fmi2{name}" for name in _FUNCTIONS)
"""What FMI 2.0 asks of every co-simulation library."""

_LINKER_SYMBOLS = {"_init", "_fini", "_edata", "_end", "__bss_start"}
_LINKER_BYTES = 64  # of its own, for loading and unloading
_STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fPIC", "-shared")
LIBC = {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}


def check_archive(path: Path) -> Item:
    """Names in the zip."""
    found = irregularities(path)
    return Item("archive", not found, "; ".join(found) or "names are plain, every file can be read")


def check_validation(path: Path) -> Item:
    """fmpy's validation."""
    from fmpy.validation import validate_fmu

    remarks = [remark.strip() for remark in validate_fmu(str(path))]
    return Item("fmpy validation", not remarks, "; ".join(remarks) or "no remark")


def check_description(description: Any) -> Item:
    """What fmpy does not look at: start within limits, limits in order, times in order, flags that imply others."""
    found = list(_variable_remarks(description))
    experiment = description.defaultExperiment
    if experiment is not None:
        begin, stop, step = (_number(getattr(experiment, name)) for name in ("startTime", "stopTime", "stepSize"))
        if stop is not None and not stop > (begin or 0.0):
            found.append("the stop time is not later than the start time")
        if step is not None and not step > 0:
            found.append("the step size is not positive")
    simulation = description.coSimulation
    if simulation is not None and simulation.canSerializeFMUstate and not simulation.canGetAndSetFMUstate:
        found.append("states can be serialized but not got and set")
    count = len(description.modelVariables)
    return Item("description", not found, "; ".join(found[:5]) or f"{count} variables: values, limits and flags agree")


def _variable_remarks(description: Any) -> Iterator[str]:
    for variable in description.modelVariables:
        if variable.type not in ("Real", "Float64", "Float32"):
            continue
        low, high, start = _number(variable.min), _number(variable.max), _number(variable.start)
        nominal = _number(variable.nominal)
        if low is not None and high is not None and low > high:
            yield f"'{variable.name}': min {low!r} > max {high!r}"
        if start is not None and not (-math.inf if low is None else low) <= start <= (
            math.inf if high is None else high
        ):
            yield f"'{variable.name}': start {start!r} is not within [{low}, {high}]"
        if nominal is not None and not nominal > 0:
            yield f"'{variable.name}': nominal {nominal!r} is not positive"


def _number(text: Any) -> float | None:
    """The number in an attribute; None where it is absent or an array."""
    try:
        return None if text is None else float(text)
    except ValueError:
        return None


def check_binary(unpacked: Unpacked, platform: str) -> Item:
    """Exports, imports and needed glibc of this machine's library (Linux; elsewhere only that it is there)."""
    name = unpacked.description.coSimulation.modelIdentifier + SHARED_SUFFIX
    path = unpacked.folder / "binaries" / platform / name
    if not path.is_file():
        return Item("binary", False, f"binaries/{platform}/{name} is missing")
    if platform != "linux64":
        return Item("binary", None, f"{name} is there; its symbols are read on Linux only")
    library = read_shared_library(path.read_bytes())
    found = [f"{symbol} is not exported" for symbol in sorted(MANDATORY - library.exports)]
    extra = sorted(s for s in library.exports - _LINKER_SYMBOLS if not s.startswith("fmi2"))
    found += [f"{symbol} is exported besides" for symbol in extra]
    found += [f"needs {other}" for other in sorted(library.needed - LIBC)]
    if library.writable > _LINKER_BYTES:
        found.append(f"{library.writable} bytes of variables are shared by all instances")
    version = ".".join(str(part) for part in library.glibc)
    return Item(
        "binary", not found, "; ".join(found[:5]) or f"all functions and nothing else; needs glibc {version} or later"
    )


def check_sources(unpacked: Unpacked) -> Item:
    """The sources compile in an empty folder, warnings being errors."""
    folder = unpacked.folder / "sources"
    if not folder.is_dir():
        return Item("sources", None, "none inside")
    compiler = find_compiler()
    with tempfile.TemporaryDirectory(prefix="gearblocks-sources-", ignore_cleanup_errors=True) as place:
        directory = Path(place)
        for file in folder.iterdir():
            (directory / file.name).write_bytes(file.read_bytes())
        names = sorted(file.name for file in folder.glob("*.c"))
        try:
            compiler.run((*_STRICT, *names, "-o", "all" + SHARED_SUFFIX, "-lm"), directory)
        except CompileError as error:
            return Item("sources", False, str(error))
    return Item("sources", True, f"{len(names)} C files compile in an empty folder without a warning")
