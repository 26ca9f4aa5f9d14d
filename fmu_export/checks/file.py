"""Checks of an FMU's files that need no run: archive, description, binary, sources."""

from __future__ import annotations

import math
import shutil
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from fmu_export.archive import irregularities
from fmu_export.binary import GENERATED, digest_of, kept_object, native_platform
from fmu_export.checks.elf import SharedLibrary, read_shared_library
from fmu_export.checks.instance import Unpacked
from fmu_export.checks.limits import BYTES_OF_FILES, FILES, NAMES
from fmu_export.checks.report import Item
from fmu_export.fmi2.description import structured_name
from gearblocks.errors import CompileError
from gearblocks.solver.cache import digest
from gearblocks.solver.compiler import SHARED_SUFFIX, find_compiler
from gearblocks.solver.library import produced

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
_STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fPIC")
LIBC = {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}


def check_archive(path: Path) -> Item:
    """Names and sizes in the zip."""
    with zipfile.ZipFile(path) as archive:
        entries = archive.infolist()
        size = sum(entry.file_size for entry in entries)
    if len(entries) > FILES or size > BYTES_OF_FILES:
        words = f"{len(entries)} files of {size / 2**20:.0f} MiB together are more than a check unpacks"
        return Item("archive", False, words)
    found = irregularities(path)
    return Item("archive", not found, "; ".join(found) or "names are plain, every file can be read")


def check_validation(path: Path) -> Item:
    """fmpy's validation; names of very many variables, which it parses slowly, by a look of our own."""
    from fmpy import read_model_description
    from fmpy.model_description import ValidationError

    with zipfile.ZipFile(path) as archive:
        count = archive.read("modelDescription.xml").count(b"<ScalarVariable")
    names = count <= NAMES
    try:
        described = read_model_description(
            str(path), validate=True, validate_variable_names=names, validate_model_structure=True
        )
        remarks = [] if names else name_remarks(described)
    except ValidationError as error:
        remarks = [remark.strip() for remark in error.problems]
    words = "no remark" if names else f"no remark; the names of {count} variables have the form that they claim"
    return Item("fmpy validation", not remarks, "; ".join(remarks[:20]) or words)


def name_remarks(description: Any) -> list[str]:
    """Names that have not the form that the description claims for them."""
    if description.variableNamingConvention != "structured":
        return []
    return [f"'{v.name}' is no structured name" for v in description.modelVariables if not structured_name(v.name)]


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


def check_binary(unpacked: Unpacked) -> Item:
    """Exports, imports and needed glibc of this machine's library (Linux; elsewhere only that it is there)."""
    platform = native_platform()
    name = unpacked.description.coSimulation.modelIdentifier + SHARED_SUFFIX
    path = unpacked.folder / "binaries" / platform / name
    if not path.is_file():
        return Item("binary", False, f"binaries/{platform}/{name} is missing")
    if platform != "linux64":
        return Item("binary", None, f"{name} is there; its symbols are read on Linux only")
    try:
        library = read_shared_library(path.read_bytes())
    except ValueError as error:
        return Item("binary", False, f"{name}: {error}")
    missing = [f"{symbol} is not exported" for symbol in sorted(MANDATORY - library.exports)]
    found = _beside(library)
    version = ".".join(str(part) for part in library.glibc)
    needs = f"needs glibc {version} or later" if version else "asks for no version of glibc"
    if unpacked.own or missing:
        words = "; ".join([*missing, *found][:5])
        return Item("binary", not words, words or f"all functions and nothing else; {needs}")
    return Item("binary", True, "; ".join([f"all functions; {needs}", *found][:6]))


def _beside(library: SharedLibrary) -> list[str]:
    """What the standard allows and gearblocks leaves away."""
    extra = sorted(s for s in library.exports - _LINKER_SYMBOLS if not s.startswith("fmi2"))
    found = [f"{symbol} is exported besides" for symbol in extra[:3]]
    found += [f"needs {other}" for other in sorted(library.needed - LIBC)]
    if library.writable > _LINKER_BYTES:
        found.append(f"{library.writable} bytes of variables are shared by all instances")
    return found


def check_sources(unpacked: Unpacked) -> Item:
    """The sources compile in an empty folder: the files that the description lists, the headers of FMI beside them.

    Those of gearblocks bring all headers, list every file and give no warning.
    """
    folder = unpacked.folder / "sources"
    if not folder.is_dir():
        return Item("sources", None, "none inside")
    listed = _listed(unpacked.description)
    if not listed:
        return Item("sources", False if unpacked.own else None, "the description lists no source files")
    absent = [name for name in listed if not (folder / name).is_file()]
    if absent:
        return Item("sources", False, f"listed, but not inside: {', '.join(absent[:5])}")
    unlisted = sorted({file.name for file in folder.glob("*.c")} - set(listed)) if unpacked.own else []
    if unlisted:
        return Item("sources", False, f"inside, but not listed: {', '.join(unlisted[:5])}")
    try:
        _compile_strictly(folder, listed) if unpacked.own else _compile(folder, listed)
    except CompileError as error:
        return Item("sources", False, str(error))
    without = " without a warning" if unpacked.own else ""
    return Item("sources", True, f"{len(listed)} C files compile in an empty folder{without}")


def _compile(folder: Path, listed: Sequence[str]) -> None:
    """All at once in a copy of the folder. Raises CompileError."""
    with tempfile.TemporaryDirectory(prefix="gearblocks-sources-", ignore_cleanup_errors=True) as place:
        directory = Path(place) / "sources"
        shutil.copytree(folder, directory)
        flags = ("-fPIC", "-shared", "-w", "-I.", f"-I{_standard_headers()}")
        find_compiler().run((*flags, *listed, "-o", "all" + SHARED_SUFFIX, "-lm"), directory)


def _compile_strictly(folder: Path, listed: Sequence[str]) -> None:
    """One by one, each with the headers alone, without a warning; then linked. Files that passed before, as those of the
    solver in every FMU, are not compiled again. Raises CompileError."""
    compiler = find_compiler()
    headers = {file.name: file.read_bytes() for file in folder.glob("*.h")}
    known = digest_of(headers)
    objects = {}
    for number, listed_name in enumerate(listed):
        name = Path(listed_name).name
        source = (folder / listed_name).read_bytes()
        files = {**headers, name: source}
        arguments = (*_STRICT, "-c", name, "-o", "out.o")
        if name in GENERATED:
            objects[f"{number}.o"] = produced(compiler, files, arguments, "out.o")
        else:
            objects[f"{number}.o"] = kept_object(compiler, files.copy, arguments, digest(known, name, source))
    product = "all" + SHARED_SUFFIX
    produced(compiler, objects, ("-shared", *objects, "-o", product, "-lm"), product)


def _listed(description: Any) -> list[str]:
    """The source files that the description says are to be compiled."""
    wanted = description.coSimulation.modelIdentifier
    found = [c for c in description.buildConfigurations if c.modelIdentifier == wanted]
    return [str(name) for files in found[0].sourceFileSets for name in files.sourceFiles] if found else []


def _standard_headers() -> Path:
    """FMI's headers, which need not lie in an FMU; fmpy has them."""
    import fmpy

    return Path(fmpy.__file__).parent / "c-code"
