"""C text of enclosures as a shared library, for the tests that read them."""

import ctypes
from pathlib import Path

from gearblocks.solver.compiler import SHARED_SUFFIX, find_compiler

CORE = Path(__file__).parents[3] / "gearblocks" / "solver" / "c"
EXPORT = '__attribute__((visibility("default")))'


class Box(ctypes.Structure):
    """gb_enclosure."""

    _fields_ = [(name, ctypes.c_double) for name in ("lo", "hi", "down", "up")]


def library_of(text, folder):
    """The library of a C text that includes headers of the core, compiled in a folder."""
    (folder / "enclosures.c").write_text(text, encoding="utf-8")
    target = folder / f"enclosures{SHARED_SUFFIX}"
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", f"-I{CORE}"]
    find_compiler().run([*flags, "enclosures.c", "-lm", "-o", str(target)], folder)
    return ctypes.CDLL(str(target))
