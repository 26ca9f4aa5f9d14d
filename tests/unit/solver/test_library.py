"""C text becomes a library, once per content, on any machine that has Python."""

import math
import os
import pickle
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import gearblocks as gb
from gearblocks.codegen.program import Program
from gearblocks.errors import CompileError, GearblocksWarning
from gearblocks.solver import library as stage
from gearblocks.solver.cache import Cache
from gearblocks.solver.compiler import FLAGS, SHARED_SUFFIX, Compiler, find_compiler, zig_compiler
from gearblocks.solver.library import Library, compile_program, core_files, start_core_build
from models import modelica_examples, spline_coupling


def test_the_same_program_is_compiled_once(
    program: Callable[..., Program], oscillator: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stage, "produced", None)
    assert compile_program(program()).path == oscillator.path


def test_the_core_is_hashed_and_looked_for_once(
    program: Callable[..., Program], oscillator: Library, monkeypatch: pytest.MonkeyPatch
) -> None:
    read: list[str] = []
    find = Cache.find
    monkeypatch.setattr(stage, "core_digest", None)
    monkeypatch.setattr(Cache, "find", lambda self, kind, *key: read.append(kind) or find(self, kind, *key))
    assert compile_program(program()).path == oscillator.path
    assert set(read) == {"models", "compilers"}


def test_another_text_is_another_library(program: Callable[..., Program], oscillator: Library) -> None:
    assert compile_program(program("/* another */\n")).path != oscillator.path


@pytest.mark.numeric
@pytest.mark.skipif(not shutil.which("cc"), reason="a level of optimisation is part of a command in CC")
@pytest.mark.parametrize(
    "train",
    [
        spline_coupling.steel,
        modelica_examples.build,
        pytest.param(modelica_examples.coupled_clutches, marks=pytest.mark.long),
    ],
)
@pytest.mark.few(1)
def test_a_level_of_optimisation_changes_no_bit(
    train: Callable[[], gb.Drivetrain], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Tests of the quick tier run generated laws as they are written, users run them optimised."""
    command = [word for word in os.environ.get("CC", "cc").split() if not word.startswith("-O")]
    paths, bits = [], []
    for level in ("-O0", "", "-O3"):
        monkeypatch.setenv("CC", " ".join([*command, level]).strip())
        model = gb.build(train())
        paths.append(model.library.path)
        for method in ("dp8", "rodas"):
            run = gb.simulate(model, t_end=2e-3, method=method)
            assert run.final_state is not None
            bits.append((level, method, run.stats.steps, run.final_state.y.tobytes()))
    assert len(set(paths)) == 3
    for of_level in (bits[2:4], bits[4:]):
        assert [part[1:] for part in of_level] == [part[1:] for part in bits[:2]]


def test_a_damaged_library_is_compiled_again(
    program: Callable[..., Program], begin: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "größer als ein Wort"))
    first = compile_program(program())
    content = first.path.read_bytes()
    # another file under the old name: what is loaded stays as it is
    first.path.unlink()
    first.path.write_bytes(content[: len(content) // 2])
    second = compile_program(program())
    with second.open() as sim:
        begin(sim)


def test_a_cache_that_cannot_be_written_costs_only_time(
    program: Callable[..., Program], begin: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "file"))
    with pytest.warns(GearblocksWarning, match="cannot be written"), compile_program(program()).open() as sim:
        begin(sim)


@pytest.mark.long
@pytest.mark.parametrize("find", [find_compiler, zig_compiler])
def test_the_core_compiles_in_an_empty_folder_without_a_remark(find: Callable[[], Compiler], tmp_path: Path) -> None:
    files = core_files()
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    remarks = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
    sources = [name for name in files if name.endswith(".c")]
    find().run([*FLAGS, *remarks, "-shared", *sources, "-o", "core" + SHARED_SUFFIX, "-lm"], tmp_path)


def test_c_that_is_wrong_is_shown_with_the_compilers_words(program: Callable[..., Program]) -> None:
    with pytest.raises(CompileError, match="no_such_thing"):
        compile_program(program("int f(void) { return no_such_thing; }\n"))


def test_a_library_travels_to_another_process_as_its_program(oscillator: Library) -> None:
    again = pickle.loads(pickle.dumps(oscillator))
    assert again.path == oscillator.path
    assert again.program == oscillator.program


def test_a_cached_library_is_found_without_heavy_imports(oscillator: Library, tmp_path: Path) -> None:
    stored = tmp_path / "program"
    stored.write_bytes(pickle.dumps(oscillator.program))
    script = (
        "import pickle, sys\n"
        "from gearblocks.solver.library import compile_program\n"
        f"compile_program(pickle.loads(open({str(stored)!r}, 'rb').read()))\n"
        "print([name for name in ('sympy', 'jinja2', 'matplotlib', 'fmpy', 'scipy') if name in sys.modules])\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, env={**os.environ}
    )
    assert done.stdout.strip() == "[]"


@pytest.mark.long
def test_it_works_without_a_compiler_on_path(
    program: Callable[..., Program], begin: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    start_core_build()
    with compile_program(program()).open() as sim:
        begin(sim)
        sim.advance(1.0)
        assert sim.outputs()[0] == pytest.approx(math.cos(2.0), abs=1e-8)
