"""From C text to loaded libraries: the core is compiled and linked once per machine, a model once per content.

The library of a model has its own C text and what that calls of the core, which are few files without a state; the solver is
the core's library, which all models of a process share and which is handed the model. Nothing here imports sympy or jinja2
unless the core itself has to be compiled, so a cached model loads in milliseconds.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
import random
import re
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed, wait
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from gearblocks.codegen.program import Program
from gearblocks.errors import CompileError, GearblocksError, UnknownAttributeError, log
from gearblocks.language.tidy import Tidy, told
from gearblocks.plurals import singular
from gearblocks.progress import Progress
from gearblocks.solver.binding import Simulation
from gearblocks.solver.cache import digest, user_cache
from gearblocks.solver.compiler import FLAGS, SHARED_SUFFIX, Compiler, cpu_identity, find_compiler
from gearblocks.solver.memory import Memory
from gearblocks.solver.shared_object import open_core, open_model
from gearblocks.solver.structures import Array
from gearblocks.solver.variants import asked_flags
from gearblocks.train.graph import Train, Tree
from gearblocks.train.left_out import LeftOut
from gearblocks.train.rules import Rules

SOURCES = Path(__file__).parent / "c"
METHOD_SOURCES = ("methods.py", "rosenbrock.py")
"""The files that the tables of the methods come from."""

# Read before the model: the one function of it that can be seen from outside.
_EXPORTS = '#include "gb_core.h"\nGB_API const gb_model *gb_get_model(void);\n'
_HOT = (
    "gb_cut.c",
    "gb_defect.c",
    "gb_dense_output.c",
    "gb_error_control.c",
    "gb_evaluate.c",
    "gb_features.c",
    "gb_ledger.c",
    "gb_locate.c",
    "gb_locate_polynomial.c",
    "gb_rates.c",
    "gb_rosenbrock.c",
    "gb_reach.c",
    "gb_runge_kutta.c",
    "gb_sparse_ldu.c",
    "gb_step.c",
    "gb_time_terms.c",
)
"""What every step runs through."""
_COOL = ("-O2",)  # the rest of the core: a third quicker to compile
_INCLUDE = re.compile(rb'^#include "(\w+\.h)"', re.MULTILINE)
_Unit = TypeVar("_Unit")
_Made = TypeVar("_Made")
_LOOK = 0.5  # seconds between two looks at how far the core is
_builds: dict[tuple[int, str], _Build] = {}
_libraries: dict[tuple[str, str], Path] = {}  # of the core, by place of the cache and key
_lock = threading.Lock()


@dataclass(frozen=True, slots=True)
class Core:
    """The compiled core. library: all of it, linked; objects: its files by their names, for models that call them."""

    library: Path
    objects: Mapping[str, Path]

    @property
    def is_there(self) -> bool:
        """Whether nobody has removed its files."""
        return all(path.is_file() for path in (self.library, *self.objects.values()))


@dataclass(slots=True)
class _Build:
    """The core, being compiled in the background or ready. done, total: files."""

    future: Future[Core] = field(default_factory=Future)
    began: float = field(default_factory=time.monotonic)
    done: int = 0
    total: int = 0

    @property
    def is_usable(self) -> bool:
        return self.future.exception() is None and self.future.result().is_there

    def tell(self, done: int, total: int) -> None:
        self.done, self.total = done, total

    def core(self) -> Core:
        """The core, as soon as it is there; whoever waits for it sees how far it is."""
        said = Progress("compiling the core", " (once on this machine)", self.began)
        try:
            while not wait((self.future,), _LOOK).done:
                if self.total:
                    said(self.done / self.total, f"{self.done} of {self.total} files")
            return self.future.result()
        finally:
            said.close()


class Library:
    """A compiled program, loaded: path of its library; shared: that of the core; native: the gb_model. Travels to other
    processes as its program and is found in the cache there."""

    def __init__(self, program: Program, path: Path, core: Path) -> None:
        self.program = program
        self.path = path
        self.shared: ctypes.CDLL = open_core(str(core))
        self._own, self.native = open_model(str(path))
        self._spare: list[Memory] = []

    def open(self) -> Simulation:
        """A new simulation of this model."""
        return Simulation(self.shared, self.native, self.program)

    def reopen(self) -> Simulation:
        """A simulation that may have run before: the caller sets all parameters and inputs."""
        return Simulation(self.shared, self.native, self.program, self._spare)

    def __del__(self) -> None:
        for memory in getattr(self, "_spare", ()):
            self.shared.gb_close(memory.sim)

    def __reduce__(self) -> tuple[Any, ...]:
        return compile_program, (self.program,)

    def __repr__(self) -> str:
        return f"Library('{self.program.name}', n={self.program.n})"


@told
@dataclass(frozen=True, slots=True, eq=False)
class Model(metaclass=Tidy):
    """A train that is ready to run. values: start values of the parameters, in the order of `program.parameters`; starts: the
    train, where start values follow from Parameters, and how often each of those stands in it; tree: the composition, for
    drawings; left_out: effects that its runs watch. Pickles keep neither of these two. rules: those of its blocks; pickles keep
    those of a train of the catalogue."""

    program: Program
    library: Library
    values: Array
    starts: Train | None = None
    start_parameters: Mapping[str, int] = field(default_factory=dict)
    tree: Tree | None = None
    left_out: LeftOut | None = None
    rules: Rules | None = None

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name.startswith("_"):
                raise AttributeError(name)
            raise UnknownAttributeError(
                f"a Model has no attribute '{name}'; what is asked of a train, and changed, is so before it is built: "
                "gb.build(rig.set({...}))"
            )

    def __reduce__(self) -> tuple[Any, ...]:
        rules = self.rules if self.rules is not None and self.rules.travels else None
        return Model, (self.program, self.library, self.values, self.starts, self.start_parameters, None, None, rules)

    def __repr__(self) -> str:
        p = self.program
        counts = f"{p.n} states, {len(p.parameters)} parameters, {len(p.inputs)} inputs, {len(p.outputs)} outputs"
        return singular(f"<Model '{p.name}': {counts}, {len(p.switches)} switches>")


def compile_program(program: Program) -> Library:
    """The library of a program, from the cache where it was compiled before. Raises CompileError."""
    compiler = compiler_here()
    cache, core = user_cache(), _core_key(compiler)
    key = digest(core, *compiler.generated_flags, _EXPORTS, program.source)
    path = cache.find("models", key, SHARED_SUFFIX)
    if path is None:
        began = time.perf_counter()
        objects = _core(compiler, core).core().objects
        path = cache.write("models", key, _linked(compiler, program.source, objects), SHARED_SUFFIX)
        log.info("'%s': compiled in %.3g s", program.name, time.perf_counter() - began)
    else:
        log.debug("'%s': its library is in the cache", program.name)
    return Library(program, path, _core_library(compiler, core))


def compiler_here() -> Compiler:
    """The compiler for models in-process: for this machine, or for the level that the environment names. Raises
    CompileError."""
    compiler = find_compiler()
    asked = asked_flags(compiler)
    return compiler if asked is None else replace(compiler, native=asked)


def start_core_build() -> None:
    """Begins to compile the core in the background, where this machine has not got it yet; whoever needs it will wait.

    Returns at once. What goes wrong is said by the call that needs the core.
    """
    threading.Thread(target=_begin_core, name="gearblocks-core").start()


def _begin_core() -> None:
    with contextlib.suppress(GearblocksError, RuntimeError):  # said by whoever needs the core
        compiler = compiler_here()
        _core(compiler, _core_key(compiler))


def core_files() -> dict[str, bytes]:
    """All C files of the core by name, the rendered tables among them; they compile in an empty folder."""
    return {**_written("c"), **_written("h"), "gb_methods.h": _method_tables()}


@functools.cache
def _method_tables() -> bytes:
    """The header of the methods, which are constants."""
    from gearblocks.solver.methods import render_tables

    return render_tables().encode()


def core_sources(solver: Path) -> dict[str, bytes]:
    """What the core in a folder like this one is made of, by file name: C files, and what the tables of the methods come
    from."""
    paths = [*(solver / "c").glob("gb_*.[ch]"), solver / "c" / "gb_methods.h.jinja"]
    paths += [solver / name for name in METHOD_SOURCES]
    return {path.name: path.read_bytes() for path in sorted(paths)}


@functools.cache
def _core_snapshot() -> dict[str, bytes]:
    """The sources of the core, read once, so that what is compiled is what its key was taken from."""
    return core_sources(SOURCES.parent)


def _written(ending: str) -> dict[str, bytes]:
    """The hand-written files of the core with that ending."""
    return {name: data for name, data in _core_snapshot().items() if name.endswith("." + ending)}


def headers_of(source: bytes) -> dict[str, bytes]:
    """The headers of the core that a C text includes, and those that they include."""
    return included(source, _written("h"))


def included(source: bytes, files: Mapping[str, bytes]) -> dict[str, bytes]:
    """Of these files those that a C text includes, and those that they include."""
    found, texts = dict[str, bytes](), [source]
    while texts:
        for name in _INCLUDE.findall(texts.pop()):
            if (header := name.decode()) in files and header not in found:
                texts.append(found.setdefault(header, files[header]))
    return found


def core_digest(sources: dict[str, bytes]) -> str:
    """Digest of everything the core is made of, the tables as the program that renders them."""
    return digest(*(part for item in sources.items() for part in item))


@functools.cache
def core_identity() -> str:
    """Digest of the sources of the core as they were read."""
    return core_digest(_core_snapshot())


def _core_key(compiler: Compiler) -> str:
    return digest(compiler.identity, *FLAGS, *_COOL, *_HOT, *compiler.native, cpu_identity(), core_identity())


def _core_library(compiler: Compiler, key: str) -> Path:
    """The library of the core, made where it is not in the cache; looked for once, since it is loaded once."""
    place = (str(user_cache().root), key)
    if place not in _libraries:
        _libraries[place] = user_cache().find("core", key, SHARED_SUFFIX) or _core(compiler, key).core().library
    return _libraries[place]


def _core(compiler: Compiler, key: str) -> _Build:
    """The core, being compiled in the background or ready. One build at a time in a process."""
    place = (os.getpid(), key)
    with _lock:
        build = _builds.get(place)
        if build is None or (build.future.done() and not build.is_usable):
            build = _Build()
            worker = ThreadPoolExecutor(max_workers=1, thread_name_prefix="gearblocks-core")
            build.future = worker.submit(_build_core, compiler, key, build.tell)
            _builds[place] = build
            worker.shutdown(wait=False)
        return build


def _build_core(compiler: Compiler, key: str, tell: Callable[[int, int], None]) -> Core:
    """Compiles what is missing, file by file and side by side; processes that begin at once share the work. tell: takes how
    many files are done, and of how many."""
    cache = user_cache()
    names = list(_written("c"))
    keys = {name: digest(key, name) for name in names}
    found = {name: cache.find("core", keys[name], ".o") for name in names}
    missing = [name for name in names if found[name] is None]
    if missing:
        files = core_files()
        random.shuffle(missing)  # each process in an order of its own, past what others have compiled meanwhile

        def made(name: str) -> Path:
            path = cache.find("core", keys[name], ".o")
            return path or cache.write("core", keys[name], _compiled(compiler, files, name), ".o")

        found.update(zip(missing, side_by_side(made, missing, tell), strict=True))
    objects = {name: path for name, path in found.items() if path is not None}
    library = cache.find("core", key, SHARED_SUFFIX)
    return Core(library or cache.write("core", key, _linked_core(compiler, objects), SHARED_SUFFIX), objects)


def side_by_side(
    made: Callable[[_Unit], _Made], units: Sequence[_Unit], tell: Callable[[int, int], None]
) -> list[_Made]:
    """What is made of each unit, on all processors; tell: takes how many are done, and of how many, whenever one is."""
    with ThreadPoolExecutor(max_workers=max(1, min(len(units), os.cpu_count() or 1))) as workers:
        under_way = [workers.submit(made, unit) for unit in units]
        try:
            for done, finished in enumerate(as_completed(under_way), start=1):
                finished.result()
                tell(done, len(units))
        except BaseException:
            workers.shutdown(cancel_futures=True)
            raise
    return [finished.result() for finished in under_way]


def _linked_core(compiler: Compiler, objects: Mapping[str, Path]) -> bytes:
    """The shared object of the core."""
    files = {name[:-2] + ".o": path.read_bytes() for name, path in objects.items()}
    return produced(compiler, files, ("-shared", *files, "-o", "core" + SHARED_SUFFIX, "-lm"), "core" + SHARED_SUFFIX)


def core_flags(name: str) -> tuple[str, ...]:
    """Flags of a file that is not generated, behind FLAGS."""
    return () if name in _HOT else _COOL


def _compiled(compiler: Compiler, files: dict[str, bytes], name: str) -> bytes:
    """The object of one C file of the core."""
    arguments = (*FLAGS, *core_flags(name), *compiler.native, "-c", name, "-o", "core.o")
    return produced(compiler, {name: files[name], **included(files[name], files)}, arguments, "core.o")


def _called(source: bytes, objects: Mapping[str, Path]) -> list[str]:
    """The files of the core whose headers a C text includes, or one of these files."""
    texts, found = _written("c"), list[str]()
    while True:
        headers = headers_of(b"".join((source, *(texts[name] for name in found))))
        known, found = found, [name for name in objects if name[:-2] + ".h" in headers]
        if found == known:
            return found


def _linked(compiler: Compiler, source: str, objects: Mapping[str, Path]) -> bytes:
    """The shared object of a model: its C text, and the files of the core that it calls."""
    own = {"exports.h": _EXPORTS.encode(), "model.c": source.encode()}
    headers = headers_of(b"".join(own.values()))
    called = _called(b"".join(own.values()), objects)
    files = {**headers, **own, **{name[:-2] + ".o": objects[name].read_bytes() for name in called}}
    product = "model" + SHARED_SUFFIX
    flags = (*FLAGS, *compiler.generated_flags, *compiler.native, "-include", "exports.h")
    own_objects = (name[:-2] + ".o" for name in called)
    return produced(compiler, files, (*flags, "-shared", "model.c", *own_objects, "-o", product, "-lm"), product)


def produced(compiler: Compiler, files: Mapping[str, bytes], arguments: Sequence[str], product: str) -> bytes:
    """Runs the compiler in a fresh folder that holds these files, under plain names whatever the user's paths are."""
    try:
        with tempfile.TemporaryDirectory(prefix="gearblocks-", ignore_cleanup_errors=True) as place:
            directory = Path(place)
            for name, content in files.items():
                (directory / name).write_bytes(content)
            compiler.run(arguments, directory)
            return (directory / product).read_bytes()
    except OSError as error:
        place = tempfile.gettempdir()
        raise CompileError(f"the model cannot be compiled in {place}: {error.strerror or error}") from error
