"""Long tables of the generated C are written out from a few numbers, and are then what they were."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import gearblocks as gb
from fmu_export.checks.elf import read_shared_library
from gearblocks.codegen import long_tables
from gearblocks.codegen.long_tables import LONG, LongTables, pattern_of
from gearblocks.model.build import make_program
from gearblocks.solver.library import compile_program


def _written_out(pattern):
    """What the generated C makes of a pattern."""
    bends, x = dict(pattern.bends[:-1]), [0] * pattern.n
    for i in range(pattern.n):
        one, two = (x[i - k * pattern.lag] if i >= k * pattern.lag else 0 for k in (1, 2))
        x[i] = 2 * one - two + bends.get(i, 0)
    return [pattern.numbers[i] for i in x] if pattern.numbers else x


@pytest.mark.parametrize(
    "values",
    [
        range(600),
        [7] * 600,
        range(599, -1, -1),
        [x for i in range(300) for x in (i, 299 - i)],
        [x for i in range(200) for x in (3 * i, 5, -i)],
        [-1] * 300 + [*range(0, 900, 3)] + [4, 17],
    ],
)
def test_a_table_that_follows_a_pattern_is_what_it_was(values):
    pattern = pattern_of("int", "x", values)
    assert pattern is not None
    assert len(pattern.bends) <= 10
    assert pattern.bends[-1] == (len(values), 0)
    assert _written_out(pattern) == [*values]


def test_numbers_with_a_point_are_kept_as_their_texts():
    values = ["-1.0", "0.1", "-0.0"] * 200
    assert _written_out(pattern_of("double", "x", values)) == values
    assert _written_out(pattern_of("double", "x", [0.0, -0.0] * 300)) == ["0.0", "-0.0"] * 300


def test_a_table_without_a_pattern_stands_in_the_text():
    numbers = np.random.default_rng(1).integers(0, 1000, 600)
    assert pattern_of("int", "x", numbers.tolist()) is None
    assert pattern_of("double", "x", (numbers / 7).tolist()) is None
    assert pattern_of("int", "x", [2**29] * 600) is None  # an int of C would overflow on the way


def test_short_tables_stand_in_the_text():
    tables = LongTables()
    assert tables.take("int", "x", range(LONG - 1)) is None
    assert tables.take("int", "y", range(LONG)).name == "y"
    assert (len(tables.patterns), tables.kinds) == (1, ["int"])


def _train(n=40):
    rig = gb.Drivetrain("row")
    parts = [rig.add("drive", gb.Torque(tau=10 * gb.sin(50 * gb.time)))]
    for i in range(n):
        parts.append(rig.add(f"disc{i}", gb.Inertia(J=0.01 + 0.001 * i, phi0=-1e-3 * i)))
        lash = gb.Lash(k=1e4, c=1.0, half_gap=1e-3)
        parts.append(rig.add(f"link{i}", lash if i % 2 else gb.Shaft(k=2e3, c=0.5)))
    rig.chain(*parts, rig.add("ground", gb.Fixed()))
    return rig


@pytest.mark.parametrize("method", ["dp8", "rodas"])
def test_tables_that_are_written_out_change_no_bit_of_a_run(monkeypatch, method):
    model = gb.build(_train())
    assert "write_tables" not in model.program.source
    monkeypatch.setattr(long_tables, "LONG", 9)
    program = make_program(_train().train())
    assert program.source.count("static const int bends") > 20
    assert "static GB_FILLED signed char energy_sign[" in program.source
    other = replace(model, program=program, library=compile_program(program))
    runs = [gb.simulate(x, t=np.linspace(0, 0.05, 51), method=method) for x in (model, other)]
    names = [x.name for x in program.outputs]
    assert np.abs(runs[0]["link1.torque"]).max() > 0
    assert all(runs[0][name].tobytes() == runs[1][name].tobytes() for name in names)


@pytest.mark.skipif(sys.platform != "linux", reason="reads ELF")
def test_tables_that_are_written_out_are_no_variables_that_instances_share(monkeypatch):
    """As the check of an FMU asks (fmu_export/checks/file.py)."""
    monkeypatch.setattr(long_tables, "LONG", 9)
    library = compile_program(make_program(_train().train()))
    assert read_shared_library(library.path.read_bytes()).writable <= 64


def test_the_text_over_lanes_has_all_its_tables(monkeypatch):
    """Nothing writes tables out there."""
    rig = gb.Drivetrain("on one shaft")
    parts = [rig.add(f"disc{i}", gb.Inertia(J=0.1, w0=3.0 if i == 0 else None)) for i in range(20)]
    rig.connect(*(part.a for part in parts))
    rig.chain(parts[1], rig.add("drag", gb.Damper(c=0.5)), rig.add("ground", gb.Fixed()))
    aside = gb.Torque(tau=gb.sin(gb.Parameter("pace", 6.0, unit="rad/s") * gb.time))
    rig.chain(rig.add("aside", aside), rig.add("other", gb.Inertia(J=1.0)))
    monkeypatch.setattr(long_tables, "LONG", 9)
    quick = {"section": gb.stroboscopic("pace"), "transient": 0, "keep": 1, "locate": False, "steps_per_period": 400}
    model = gb.build(rig)
    assert "static const int bends" in model.program.source
    assert "static const char reads_angles[]" in model.program.lanes
    found = gb.study(model, {"pace": [2 * np.pi]}, quantity=[gb.last("disc7.phi"), gb.last("disc7.w")], **quick)
    rate = 0.5 / 2.0
    assert found["last(disc7.w)"] == pytest.approx(3.0 * np.exp(-rate), rel=1e-6)
    assert found["last(disc7.phi)"] == pytest.approx(3.0 / rate * (1 - np.exp(-rate)), rel=1e-6)
