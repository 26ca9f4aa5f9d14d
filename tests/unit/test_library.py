"""C text becomes a library that runs, once per content, on any machine that has Python."""

import math
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gearblocks.codegen.program import EnergyInfo, InputInfo, ParameterInfo, Program, Quantity
from gearblocks.errors import CompileError, GearblocksWarning
from gearblocks.solver import library as stage
from gearblocks.solver.binding import Simulation
from gearblocks.solver.compiler import FLAGS, SHARED_SUFFIX, Compiler, find_compiler, zig_compiler
from gearblocks.solver.library import Library, compile_program, core_files, start_core_build
from gearblocks.solver.structures import Code, Kind, Method, Options

HERE = Path(__file__).parent


def _oscillator(note: str = "") -> Program:
    """The hand-written model; a note makes another text of it."""
    return Program(
        name="oscillator",
        source=(HERE / "oscillator.c").read_text() + note,
        key="oscillator",
        parameters=(ParameterInfo("spring.w", "rad/s", "angular frequency", 0.0, None, True),),
        inputs=(InputInfo("u", "m/s2", 0.0),),
        states=(Quantity("x", "m", "deflection"), Quantity("v", "m/s", "its rate")),
        switches=(),
        outputs=(Quantity("x", "m", "deflection"), Quantity("v", "m/s", "its rate")),
        energies=(EnergyInfo("mass", "kinetic", 0), EnergyInfo("spring", "stored", 1)),
        integrals=(),
        n=2,
        n_padded=8,
        n_total=8,
    )


@pytest.fixture(scope="module")
def oscillator() -> Library:
    return compile_program(_oscillator())


def _options(rtol: float = 1e-10, step: float = 0.0) -> Options:
    return Options(method=Method.DP8, locate=1, rtol=rtol, step=step, max_step=math.inf, t_stop=math.inf)


def _begin(sim: Simulation, w: float = 2.0) -> None:
    sim.parameters[0] = w
    sim.changed()
    assert sim.start(_options(), 0.0) == Code.DONE


def test_a_run_through_samples_follows_the_cosine(oscillator: Library) -> None:
    t = np.linspace(0.0, 10.0, 101)
    with oscillator.open() as sim:
        _begin(sim)
        record = sim.record(rows=1000)
        assert sim.run(t, 10.0, record, 10.0) == Code.DONE
        rows, events = record.take()
        code, out, energy = sim.evaluate(rows, np.array([0], dtype=np.intc), energies=True)
        counters = sim.counters
    assert code == Code.DONE
    assert len(events) == 0
    assert np.array_equal(rows[:, 0], t)
    # rtol 1e-10 per step, some tens of steps
    assert np.abs(out[:, 0] - np.cos(2.0 * t)).max() < 1e-8
    assert np.abs(energy.sum(axis=1) - 2.0).max() < 1e-7
    assert counters.steps > 0
    assert counters.rhs_calls > counters.steps


def test_a_full_record_is_emptied_and_the_run_goes_on(oscillator: Library) -> None:
    t = np.linspace(0.0, 1.0, 101)
    with oscillator.open() as sim:
        _begin(sim)
        record = sim.record(rows=10)
        times = []
        while (code := sim.run(t, 1.0, record, 10.0)) == Code.FULL:
            times.append(record.take()[0][:, 0])
        times.append(record.take()[0][:, 0])
    assert code == Code.DONE
    assert np.array_equal(np.concatenate(times), t)


def test_communication_points_and_saved_states_repeat_bit_for_bit(oscillator: Library) -> None:
    with oscillator.open() as sim:
        _begin(sim)
        sim.advance(0.7)
        block = sim.save()
        sim.advance(1.9)
        first = sim.state()
        assert sim.restore(block) == Code.DONE
        assert sim.time == 0.7
        sim.advance(1.9)
        assert np.array_equal(sim.state(), first)
        assert sim.outputs()[0] == first[0]
        assert sim.energies()[0] == 0.5 * first[1] ** 2
        assert sim.restore(block[:-8]) == Code.ERR_STATE


def test_an_input_is_a_value_a_table_or_a_function(oscillator: Library) -> None:
    def end(prepare: str) -> float:
        with oscillator.open() as sim:
            if prepare == "value":
                sim.inputs[0] = 4.0
                sim.changed()
            elif prepare == "table":
                sim.set_table(0, Kind.LINEAR, np.array([0.0, 1.0]), np.array([4.0, 4.0]))
            else:
                sim.set_function(0, lambda t: 4.0)
            _begin(sim)
            assert sim.advance(3.0) == Code.DONE
            return float(sim.outputs()[0])

    # u = w^2 holds the mass where it starts
    assert end("value") == pytest.approx(1.0, abs=1e-12)
    assert end("table") == end("value")
    assert end("function") == end("value")


def test_what_an_input_function_raises_stops_the_run_and_is_kept(oscillator: Library) -> None:
    def broken(t: float) -> float:
        raise ZeroDivisionError(f"at {t}")

    with oscillator.open() as sim:
        sim.set_function(0, broken)
        code = sim.start(_options(), 0.0)
        if code == Code.DONE:
            code = sim.advance(1.0)
        assert code == Code.ERR_CALLBACK
        assert sim.report.index == 0
        assert isinstance(sim.error, ZeroDivisionError)


def test_the_right_hand_side_can_be_asked(oscillator: Library) -> None:
    with oscillator.open() as sim:
        _begin(sim, 3.0)
        y = np.zeros(8)
        y[:2] = 2.0, 5.0
        assert np.array_equal(sim.rhs(0.0, y)[:2], [5.0, -18.0])
        with pytest.raises(ValueError, match="length 8"):
            sim.rhs(0.0, np.zeros(2))


def test_two_simulations_of_one_library_do_not_share_anything(oscillator: Library) -> None:
    with oscillator.open() as first, oscillator.open() as second:
        _begin(first, 2.0)
        _begin(second, 3.0)
        first.advance(1.0)
        second.advance(1.0)
        assert first.outputs()[0] == pytest.approx(math.cos(2.0), abs=1e-8)
        assert second.outputs()[0] == pytest.approx(math.cos(3.0), abs=1e-8)


def test_a_closed_simulation_can_be_closed_again(oscillator: Library) -> None:
    sim = oscillator.open()
    sim.close()
    sim.close()
    assert len(sim.parameters) == 0


def test_the_same_program_is_compiled_once(oscillator: Library, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stage, "produced", None)
    assert compile_program(_oscillator()).path == oscillator.path


def test_another_text_is_another_library(oscillator: Library) -> None:
    assert compile_program(_oscillator("/* another */\n")).path != oscillator.path


def test_a_damaged_library_is_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "größer als ein Wort"))
    first = compile_program(_oscillator())
    content = first.path.read_bytes()
    # another file under the old name: what is loaded stays as it is
    first.path.unlink()
    first.path.write_bytes(content[: len(content) // 2])
    second = compile_program(_oscillator())
    with second.open() as sim:
        _begin(sim)


def test_a_cache_that_cannot_be_written_costs_only_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GEARBLOCKS_CACHE", str(tmp_path / "file"))
    with pytest.warns(GearblocksWarning, match="cannot be written"), compile_program(_oscillator()).open() as sim:
        _begin(sim)


@pytest.mark.parametrize("find", [find_compiler, zig_compiler])
def test_the_core_compiles_in_an_empty_folder_without_a_remark(find: Callable[[], Compiler], tmp_path: Path) -> None:
    files = core_files()
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    remarks = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
    sources = [name for name in files if name.endswith(".c")]
    find().run([*FLAGS, *remarks, "-shared", *sources, "-o", "core" + SHARED_SUFFIX, "-lm"], tmp_path)


def test_c_that_is_wrong_is_shown_with_the_compilers_words() -> None:
    with pytest.raises(CompileError, match="no_such_thing"):
        compile_program(_oscillator("int f(void) { return no_such_thing; }\n"))


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
def test_it_works_without_a_compiler_on_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    start_core_build()
    with compile_program(_oscillator()).open() as sim:
        _begin(sim)
        sim.advance(1.0)
        assert sim.outputs()[0] == pytest.approx(math.cos(2.0), abs=1e-8)
