"""conftest.py of the copies in which mutations.py runs tests: runs that do not end fail, and C that a mutation leaves alone is
not compiled again.

An object is known by its C file, all headers and the flags. A model is compiled and linked in two calls, so that another
core costs it the linking alone; optimized less than elsewhere: the same bits, compiled sooner.
"""

import os
import signal
from pathlib import Path

import pytest

from gearblocks.solver import compiler as compilers
from gearblocks.solver import library
from gearblocks.solver.cache import digest

OBJECTS = Path(os.environ["GEARBLOCKS_CACHE"]) / "objects"
SECONDS = 20.0
"""CPU time after which a test has a run that does not end: it takes a fraction of that."""

compilers.FLAGS = library.FLAGS = tuple("-O1" if flag == "-O3" else flag for flag in library.FLAGS)
library._COOL = ()
produced = library.produced


def kept(compiler, files, arguments, product):
    """`library.produced`, from the folder of objects where it is there."""
    source = next((x for x in arguments if x.endswith(".c")), None)
    if source is None:
        return produced(compiler, files, arguments, product)
    if "-shared" in arguments:
        flags = tuple(x for x in arguments if x != "-shared" and not x.endswith(".o"))[:-4]
        cores = [x for x in arguments if x.endswith(".o")]
        objects = {name: files[name] for name in cores}
        objects["model.o"] = kept(compiler, files, (*flags, "-c", source, "-o", "model.o"), "model.o")
        linked = (*library.FLAGS, *compiler.native, "-shared", "model.o", *cores, "-o", product, "-lm")
        return produced(compiler, objects, linked, product)
    texts = {name: data for name, data in files.items() if name == source or name.endswith(".h")}
    key = digest(*arguments, *(part for name, data in sorted(texts.items()) for part in (name, data)))
    path = OBJECTS / f"{key}.o"
    if path.is_file():
        return path.read_bytes()
    data = produced(compiler, files, arguments, product)
    OBJECTS.mkdir(parents=True, exist_ok=True)
    half = path.with_suffix(f".{os.getpid()}")
    half.write_bytes(data)
    half.replace(path)
    return data


library.produced = kept


def stop(number, frame):
    """The solver comes back to Python about every 0.05 s."""
    signal.setitimer(signal.ITIMER_PROF, 0)
    raise AssertionError(f"a run that does not end: {SECONDS:g} s of CPU time for what takes a fraction of one")


@pytest.fixture(autouse=True)
def an_end():
    """Every test ends."""
    signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    yield
    signal.setitimer(signal.ITIMER_PROF, 0)
