"""Kinds of processors that C is made for: levels of x86-64, each of which has all instructions of those before.

The bits are the same with all of them. Knows nothing of what is compiled.
"""

from __future__ import annotations

import os
import platform
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from gearblocks.errors import CompileError, did_you_mean
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.compiler import Compiler

VARIABLE = "GEARBLOCKS_VARIANT"
"""The environment variable that names one, for models in-process and for FMUs."""

_NEEDS: dict[str, tuple[str, ...]] = {
    "x86-64": (),
    "x86-64-v2": ("cx16", "popcnt", "sse4_1", "sse4_2", "ssse3"),
    "x86-64-v3": ("avx2", "bmi1", "bmi2", "f16c", "fma", "movbe"),
    "x86-64-v4": ("avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"),
}
"""Levels with the flags of /proc/cpuinfo that tell them from those before."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A level: its name, what names of functions end in that are made for it, and the flags of a compiler for it."""

    name: str
    suffix: str
    flags: tuple[str, ...]


def variants_of(compiler: Compiler) -> tuple[Variant, ...]:
    """Those that a binary for all processors of this platform holds besides the plain one: x86-64-v3 and v4 where the
    compiler knows both, none where it was told a processor or the machine is another."""
    told = any(word.startswith(("-march=", "-mcpu=")) for word in compiler.command[1:])
    if told or platform.machine().lower() not in ("x86_64", "amd64"):
        return ()
    found = tuple(Variant(name, f"_{name[-2:]}", flags_of(compiler, name)) for name in ("x86-64-v3", "x86-64-v4"))
    return found if all(_knows(compiler, variant.flags) for variant in found) else ()


def flags_of(compiler: Compiler, name: str) -> tuple[str, ...]:
    """What makes the compiler write code for a level."""
    return (f"-mcpu={name.replace('-', '_')}",) if compiler.is_zig else (f"-march={name}",)


def asked_flags(compiler: Compiler) -> tuple[str, ...] | None:
    """Flags of the level that the environment names for models in-process, None where it names none. Raises CompileError
    for one that there is not, or that this processor does not have."""
    name = os.environ.get(VARIABLE, "").strip()
    if not name:
        return None
    if name not in _NEEDS:
        raise CompileError(
            f"{VARIABLE} is '{name}', which is none of {', '.join(_NEEDS)}{did_you_mean(name, _NEEDS)}; correct or unset it"
        )
    if not runs(name):
        raise CompileError(
            f"{VARIABLE} is '{name}', which this processor does not have; unset it, or name a lower level"
        )
    return flags_of(compiler, name)


def runs(name: str) -> bool:
    """Whether this processor has a level; True where it does not say what it has."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return platform.machine().lower() in ("x86_64", "amd64")
    line = next((line for line in text.splitlines() if line.startswith("flags")), None)
    if line is None:
        return platform.machine().lower() in ("x86_64", "amd64")
    levels = [*_NEEDS]
    wanted = [flag for level in levels[: levels.index(name) + 1] for flag in _NEEDS[level]]
    return set(wanted) <= set(line.split())


def _knows(compiler: Compiler, flags: tuple[str, ...]) -> bool:
    """Whether the compiler takes these flags, tried once and remembered."""
    cache, key = user_cache(), digest(compiler.identity, "knows", *flags)
    known = cache.read("compilers", key)
    if known is None:
        with TemporaryDirectory(prefix="gearblocks-") as place:
            folder = Path(place)
            (folder / "probe.c").write_text("int probe(int x);\nint probe(int x) { return x; }\n")
            try:
                compiler.run((*flags, "-c", "probe.c", "-o", "probe.o"), folder)
                known = b"yes"
            except CompileError:
                known = b"no"
        cache.write("compilers", key, known)
    return known == b"yes"
