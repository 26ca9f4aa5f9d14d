"""The C compiler: the one named in CC, else `cc` on PATH, else the zig that comes as a Python package.

CC may hold flags: with one of -march= or -mcpu= ("cc -march=x86-64-v3") the C is made for that processor, else for the one at
hand; a level of optimisation ("cc -O0") is that of generated laws, and of all of an FMU: compiled sooner, slower to run, the
same bits.
"""

from __future__ import annotations

import functools
import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gearblocks.errors import CompileError
from gearblocks.solver.cache import digest, user_cache

FLAGS = (
    "-std=c99",
    "-O3",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fPIC",
    "-fvisibility=hidden",
)
"""Flags of everything that runs in-process, without those of the CPU at hand."""

GENERATED_FLAGS = ("-O1", "-finline-functions", "-ftree-vectorize", "-fno-tree-slp-vectorize")
"""Besides, for generated laws, which a user waits for: they run as fast as with -O3 and compile in 0.56 of its time (gcc 12).
gcc 12 makes fused operations (fmaddsub) in the last pass although contraction is off."""

SHARED_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")

_PROBE = "#include <math.h>\n#include <string.h>\ndouble probe(double x);\ndouble probe(double x) { return sin(x); }\n"

_zig_lock = threading.Lock()


@dataclass(frozen=True, slots=True)
class Compiler:
    """A compiler that works.

    command: how it is called; identity: changes when the program behind it changes; native: flags that let it use every
    instruction of this machine (empty where it has none).
    """

    command: tuple[str, ...]
    identity: str
    native: tuple[str, ...]
    is_zig: bool

    @property
    def generated_flags(self) -> tuple[str, ...]:
        """The flags of generated laws, behind FLAGS."""
        return (*GENERATED_FLAGS, *self.level)

    @property
    def level(self) -> tuple[str, ...]:
        """The level of optimisation that the command names."""
        return tuple(word for word in self.command[1:] if word.startswith("-O"))

    def run(self, arguments: Sequence[str], directory: Path) -> None:
        """Calls the compiler in `directory`, which also takes its temporary files. Raises CompileError."""
        _run((*self.command, *arguments), directory, self.is_zig)


def find_compiler() -> Compiler:
    """The compiler of this environment. Raises CompileError when there is none, or when the one in CC does not work."""
    named = os.environ.get("CC", "").strip()
    if named:
        return _named_compiler(named)
    path = shutil.which("cc")
    if path is not None:
        found = _examined((path,))
        if isinstance(found, Compiler):
            return found
    return zig_compiler()


def zig_compiler(target: str | None = None) -> Compiler:
    """The zig package as a compiler for `target`, a zig triple; the default is this machine.

    An explicit target makes zig forget the CPU at hand, so its output runs on every machine of that kind unless the
    flags in `native` are given.
    """
    spec = importlib.util.find_spec("ziglang")
    places = list(spec.submodule_search_locations or ()) if spec is not None else []
    for place in places:
        program = os.path.join(place, "zig.exe" if sys.platform == "win32" else "zig")
        if os.path.isfile(program):
            triple = host_target() if target is None else target
            command = (program, "cc", "-target", triple)
            return Compiler(command, _identity(program, command), ("-mcpu=native",) if target is None else (), True)
    raise CompileError(
        "no C compiler found: no working 'cc' on PATH, and the Python package ziglang is not there; "
        "'pip install ziglang' brings one, or set CC to the compiler to use"
    )


@functools.cache
def host_target() -> str:
    """This machine as a zig triple. Linux is held to glibc 2.17, which every distribution of the last ten years has."""
    machine = platform.machine().lower()
    machine = {"amd64": "x86_64", "arm64": "aarch64", "i686": "x86", "i386": "x86"}.get(machine, machine)
    if sys.platform == "win32":
        return f"{machine}-windows-gnu"
    if sys.platform == "darwin":
        return f"{machine}-macos"
    if not platform.libc_ver()[0]:
        return f"{machine}-linux-musl"
    return f"{machine}-linux-gnu.2.17" if machine in {"x86_64", "x86", "aarch64"} else f"{machine}-linux-gnu"


@functools.cache
def cpu_identity() -> str:
    """A text that is the same on machines whose CPUs offer the same instructions."""
    if sys.platform.startswith("linux"):
        try:
            with open("/proc/cpuinfo", encoding="utf-8", errors="replace") as file:
                block = file.read(16384).split("\n\n")[0]
        except OSError:
            block = ""
        kept = ("vendor_id", "cpu family", "model", "flags", "Features", "CPU ", "isa", "uarch")
        return "\n".join(line for line in block.splitlines() if line.startswith(kept)) or platform.machine()
    return "/".join((platform.machine(), os.environ.get("PROCESSOR_IDENTIFIER", ""), _brand()))


def _brand() -> str:
    """The name of an Apple machine's CPU, else the empty string."""
    if sys.platform != "darwin":
        return ""
    import ctypes

    size = ctypes.c_size_t(256)
    text = ctypes.create_string_buffer(size.value)
    ctypes.CDLL(None).sysctlbyname(b"machdep.cpu.brand_string", text, ctypes.byref(size), None, ctypes.c_size_t(0))
    return text.value.decode(errors="replace")


def _named_compiler(named: str) -> Compiler:
    """The compiler that the user asked for by CC: this one or an error, never another."""
    words = shlex.split(named, posix=os.name != "nt") or [named]
    path = shutil.which(words[0])
    if path is None:
        raise CompileError(f"CC is '{named}', but there is no program '{words[0]}'; correct CC or unset it")
    found = _examined((path, *words[1:]))
    if isinstance(found, str):
        raise CompileError(f"CC is '{named}', but it makes no shared library; correct CC or unset it", (), found)
    return found


def _examined(command: tuple[str, ...]) -> Compiler | str:
    """The compiler behind a command, tried out once and remembered; its complaint where it cannot do the work."""
    identity = _identity(command[0], command)
    cache, key = user_cache(), digest(identity, _PROBE, *FLAGS)
    known = cache.read("compilers", key)
    if known is None:
        known = _tried(command).encode()
        cache.write("compilers", key, known)
    verdict, _, rest = known.decode().partition("\n")
    if verdict != "works":
        return rest
    return Compiler(command, identity, tuple(rest.split()), False)


def _tried(command: tuple[str, ...]) -> str:
    """ "works" and its native flags, or "broken" and the compiler's words."""
    complaint = ""
    with tempfile.TemporaryDirectory(prefix="gearblocks-") as place:
        directory = Path(place)
        (directory / "probe.c").write_text(_PROBE)
        named = any(word.startswith(("-march=", "-mcpu=")) for word in command[1:])
        for native in ("",) if named else ("-march=native", "-mcpu=native", ""):
            flags = (*FLAGS, native) if native else FLAGS
            try:
                _run((*command, *flags, "-shared", "probe.c", "-o", "probe" + SHARED_SUFFIX, "-lm"), directory, False)
            except CompileError as error:
                complaint = str(error)
                continue
            if (directory / ("probe" + SHARED_SUFFIX)).is_file():
                return f"works\n{native}"
            complaint = "it ends without a complaint, and without a shared library"
    return f"broken\n{complaint}"


def _identity(program: str, command: tuple[str, ...]) -> str:
    """What tells one compiler from another without starting it: file, size, date of change, arguments but for a level of
    optimisation, which the core in-process does not heed."""
    real = os.path.realpath(program)
    status = os.stat(real)
    arguments = [word for word in command[1:] if not word.startswith("-O")]
    return digest(real, str(status.st_size), str(status.st_mtime_ns), *arguments)


def _run(command: Sequence[str], directory: Path, is_zig: bool) -> None:
    environment = {**os.environ, "TMPDIR": str(directory), "TMP": str(directory), "TEMP": str(directory), "LC_ALL": "C"}
    if is_zig:
        with _zig_lock:
            environment["ZIG_GLOBAL_CACHE_DIR"] = str(_zig_folder())
        environment["ZIG_LOCAL_CACHE_DIR"] = str(directory / "zig")
    try:
        done = subprocess.run(
            command,
            cwd=directory,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
    except OSError as error:
        raise CompileError(f"the C compiler cannot be started: {error}", command) from error
    if done.returncode != 0:
        raise CompileError(
            f"the C compiler failed with status {done.returncode}", command, done.stdout.decode(errors="replace")
        )


@functools.cache
def _zig_folder() -> Path:
    """Where zig keeps what it builds of the C library; says so once when that has yet to be made."""
    named = os.environ.get("ZIG_GLOBAL_CACHE_DIR", "")
    folder = Path(named) if named else user_cache().folder("zig")
    if not (folder / "o").is_dir():
        print("gearblocks: compiling with zig for the first time, this takes some seconds", file=sys.stderr, flush=True)
    return folder
