"""C sources of an FMU and the shared library of one platform."""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fmu_export.templates import C_FOLDER, VERSION_FOLDERS
from gearblocks.errors import ParameterError
from gearblocks.progress import Progress
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.compiler import FLAGS, SHARED_SUFFIX, Compiler, find_compiler
from gearblocks.solver.library import core_files, core_flags, included, produced, side_by_side
from gearblocks.solver.variants import Variant, variants_of

SHARED_GLUE = (
    *("gb_fmu.c", "gb_fmu.h", "gb_fmu_clock.c", "gb_fmu_failure.c", "gb_fmu_internal.h", "gb_fmu_values.c"),
    *("gb_solver.c", "gb_solver.h", "gb_solver_table.c"),
)
"""Life cycle and variables: the same for every FMI version."""

VERSION_GLUE = {"2.0": ("fmi2.h", "fmi2_glue.c", "fmi2_instance.h", "fmi2_states.c")}
"""Names, types and states of one FMI version."""

GENERATED = ("fmu_table.c", "model.c")
"""What differs from model to model."""

_BASELINE = "glibc_baseline.h"
_NAMES = "variant_names.h"
_PROTOTYPE = re.compile(r"^(?!typedef|#|\s|static|[A-Z_]+INLINE)[A-Za-z_][\w *]*?\b(gb_\w+)\([^;{]*\);", re.MULTILINE)
_EXTERN = re.compile(r"^extern const ([^;]*);", re.MULTILINE)
_DECLARED = re.compile(r"\b(gb_\w+)\s*(?:\[[^\]]*\]\s*)*(?:,|$)")
_IN_PROCESS = re.compile(r"gb_(study|tangents?(_\w+)?|lane(_run)?)\.[ch]")
"""Files of the solver for studies and tangents, which no FMU runs."""

_MACHINES = {"amd64": "x86_64", "arm64": "aarch64"}
_PLATFORMS = {("linux", "x86_64"): "linux64", ("win32", "x86_64"): "win64", ("darwin", "x86_64"): "darwin64"}
KNOWN_PLATFORMS = ("native", "linux64", "win64", "darwin64", "aarch64-linux", "aarch64-darwin")


def source_files(fmi: str, model: str, table: str) -> dict[str, bytes]:
    """All C files by name; those that end in .c, compiled and linked with libm, are the whole library."""
    glue = {name: (C_FOLDER / name).read_bytes() for name in SHARED_GLUE}
    glue |= {name: (VERSION_FOLDERS[fmi] / name).read_bytes() for name in VERSION_GLUE[fmi]}
    core = {name: data for name, data in core_files().items() if not _IN_PROCESS.fullmatch(name)}
    return {**core, **glue, "model.c": model.encode(), "fmu_table.c": table.encode()}


def native_platform() -> str:
    """FMI's name of this machine. Raises ParameterError where FMI 2.0 has none."""
    machine = platform.machine().lower()
    key = (sys.platform, _MACHINES.get(machine, machine))
    if key not in _PLATFORMS:
        raise ParameterError(f"FMI 2.0 has no name for this platform ({sys.platform}, {machine})")
    return _PLATFORMS[key]


def checked_platforms(platforms: Sequence[str]) -> tuple[str, ...]:
    """FMI's names of the platforms asked for: in this version the machine at hand, or none at all."""
    names = (platforms,) if isinstance(platforms, str) else tuple(platforms)
    chosen = []
    for name in names:
        if name not in KNOWN_PLATFORMS:
            raise ParameterError(f"platform '{name}' is unknown; platforms are {', '.join(KNOWN_PLATFORMS)}")
        own = native_platform()
        if name not in ("native", own):
            raise ParameterError(
                f"platform '{name}' is not available in this version; possible on this machine: native ({own})"
            )
        chosen.append(own)
    return tuple(dict.fromkeys(chosen))


def build_binary(sources: Mapping[str, bytes], identifier: str) -> dict[str, bytes]:
    """The shared library of this machine under its name in the archive.

    Runs on every CPU of the platform: solver and model are compiled for its baseline, and for each of VARIANTS that the
    compiler knows, under names of their own; which are taken is decided as an instance is made (gb_solver.c). Contraction
    is off: all have the bits of the run in-process. Objects that are the same for all models are kept in the user's cache.
    """
    compiler = find_compiler()
    variants = variants_of(compiler)
    headers = {variant: _headers(compiler, sources, variant) for variant in (None, *variants)}
    again = [name for name in sorted(sources) if name.endswith(".c") and is_of_solver(name)]
    units: list[tuple[str, Variant | None]] = [(name, None) for name in sorted(sources) if name.endswith(".c")]
    units += [(name, variant) for variant in variants for name in again]

    def made(unit: tuple[str, Variant | None]) -> bytes:
        name, variant = unit
        return _object(compiler, headers[variant], name, sources[name], variant, bool(variants))

    said = Progress("compiling the FMU", " (most of it only once)")
    try:
        objects = side_by_side(made, units, lambda done, total: said(done / total, f"{done} of {total} files"))
    finally:
        said.close()
    product = identifier + SHARED_SUFFIX
    files = {
        f"{name[:-2]}{variant.suffix if variant else ''}.o": data
        for (name, variant), data in zip(units, objects, strict=True)
    }
    data = produced(compiler, files, ("-shared", "-s", *_unused(compiler), *files, "-o", product, "-lm"), product)
    return {f"binaries/{native_platform()}/{product}": data}


def _unused(compiler: Compiler) -> tuple[str, ...]:
    """What makes the linker leave out functions that nothing calls: zig links all of its runtime otherwise, with variables
    that instances would share."""
    return ("-Wl,--gc-sections",) if compiler.is_zig and sys.platform == "linux" else ()


def is_of_solver(name: str) -> bool:
    """Whether a C file is compiled for each kind of processor: the solver, its table of calls, and the model."""
    return name in ("model.c", "gb_solver_table.c") or (name not in GENERATED and not is_glue(name))


def is_glue(name: str) -> bool:
    """Whether a file stands between the solver and an FMI version."""
    return name in SHARED_GLUE or any(name in names for names in VERSION_GLUE.values())


@dataclass(frozen=True, slots=True)
class _Headers:
    """The headers that all C files of a variant see, and their digest."""

    files: Mapping[str, bytes]
    key: str


def _headers(compiler: Compiler, sources: Mapping[str, bytes], variant: Variant | None) -> _Headers:
    files = {name: data for name, data in sources.items() if name.endswith(".h")}
    if variant is not None:
        files[_NAMES] = names_with(files, variant.suffix)
    if _has_baseline(compiler):
        files[_BASELINE] = (C_FOLDER / _BASELINE).read_bytes()
    return _Headers(files, digest_of(files))


def _has_baseline(compiler: Compiler) -> bool:
    return sys.platform == "linux" and not compiler.is_zig


def _object(
    compiler: Compiler, headers: _Headers, name: str, source: bytes, variant: Variant | None, several: bool
) -> bytes:

    def files() -> dict[str, bytes]:
        told = {header: headers.files[header] for header in (_NAMES, _BASELINE) if header in headers.files}
        return {**included(source, headers.files), **told, name: source}

    arguments: tuple[str, ...] = (
        *FLAGS,
        *(compiler.generated_flags if name in GENERATED else (*core_flags(name), *compiler.level)),
        "-DGB_API=",
        "-c",
        name,
        "-o",
        "out.o",
    )  # GB_API: nothing of the solver is exported
    if variant is not None:
        arguments = (*variant.flags, "-include", _NAMES, *arguments)
    if several and name == "gb_solver.c":
        arguments = ("-DGB_SOLVER_VARIANTS", *arguments)
    if _has_baseline(compiler):
        arguments = ("-include", _BASELINE, *arguments)
    if name in GENERATED:
        return produced(compiler, files(), arguments, "out.o")
    return kept_object(compiler, files, arguments, digest(headers.key, name, source))


def names_with(headers: Mapping[str, bytes], suffix: str) -> bytes:
    """A header that gives everything that files of the solver share another name, so that several of it fit into one
    library."""
    found = {"gb_solver_plain"}
    for name, data in headers.items():
        if not is_glue(name) or name == "gb_solver.h":
            text = re.sub(rb"/\*.*?\*/", b" ", data, flags=re.DOTALL).decode()
            found.update(_PROTOTYPE.findall(text))
            found.update(name for names in _EXTERN.findall(text) for name in _DECLARED.findall(names))
    found.add("gb_model_key")
    plain = {name: f"gb_solver{suffix}" if name == "gb_solver_plain" else name + suffix for name in sorted(found)}
    return "".join(f"#define {name} {new}\n" for name, new in plain.items()).encode()


def digest_of(files: Mapping[str, bytes]) -> str:
    """Digest of files, their names and what is in them."""
    return digest(*(part for name in sorted(files) for part in (name, files[name])))


def kept_object(
    compiler: Compiler, files: Callable[[], Mapping[str, bytes]], arguments: Sequence[str], key: str
) -> bytes:
    """The object out.o that the compiler makes of what `files` answers, from the user's cache where it was made before; key:
    what tells these files from others. Raises CompileError."""
    cache = user_cache()
    whole = digest(compiler.identity, *arguments, key)
    path = cache.find("fmu", whole, ".o")
    if path is None:
        path = cache.write("fmu", whole, produced(compiler, files(), arguments, "out.o"), ".o")
    return path.read_bytes()
