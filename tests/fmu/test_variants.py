"""Code for several kinds of processors in one binary: the same bits from each, and a name that is none is refused."""

from __future__ import annotations

import itertools
import platform
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import fmpy
import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.binary import is_of_solver, names_with, source_files
from fmu_export.checks.instance import Instance, Unpacked
from gearblocks.solver.compiler import find_compiler, zig_compiler
from gearblocks.solver.variants import VARIABLE, runs, variants_of

on_x86 = pytest.mark.skipif(platform.machine().lower() not in ("x86_64", "amd64"), reason="levels of x86-64")


def _rig() -> gb.Drivetrain:
    """A spur pair that rattles, a table in its drive, and a clutch."""
    rig = gb.Drivetrain("pair")
    table = gb.Table(
        np.linspace(0, 0.02, 9), (0.0, 4.0, -2.0, 3.0, 1.0, -5.0, 2.0, 4.0, 0.0), kind="cubic", periodic=True
    )
    mesh = gb.GearMesh(
        teeth=(23, 41), r_base=(0.023, 0.041), external=True, k=2e8, damping_ratio=0.05,
        stiffness_variation=gb.Fourier(cos=(0.2,)), backlash=gb.Backlash(half_gap=30e-6),
    )  # fmt: skip
    wheel, clutch = rig.add("wheel", gb.Inertia(J=4e-3)), rig.add("clutch", gb.Clutch(capacity=3.0))
    rig.chain(
        rig.add("drive", gb.Torque(tau=table)), rig.add("pinion", gb.Inertia(J=1e-3, w0=20.0)), rig.add("mesh", mesh),
        wheel, clutch, rig.add("load", gb.Inertia(J=2e-3)),
    )  # fmt: skip
    return rig


@on_x86
def test_every_kind_of_code_in_a_binary_gives_the_bits_of_the_run_in_process(
    tmp_path: Path, unpacker: Callable[[Path, Path], Unpacked], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = fmu_export.export(_rig(), tmp_path / "pair.fmu", t_end=0.05)
    unpacked = unpacker(path, tmp_path / "unpacked")
    names = ("mesh.force", "clutch.torque", "load.w")
    times = np.linspace(0.0, 0.05, 51)
    run = gb.simulate(_rig(), t=times, outputs=list(names))
    expected = np.column_stack([run[name] for name in names])
    by_name = {v.name: v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables}
    refs = [by_name[name] for name in names]
    here = [variant.name for variant in variants_of(find_compiler()) if runs(variant.name)]
    for name in ("", "x86-64", *(x for x in ("x86-64-v2",) if runs(x)), *here):
        monkeypatch.setenv(VARIABLE, name)
        with Instance(unpacked) as instance:
            instance.start(stop=0.05)
            rows = [instance.get(refs)]
            for begin, end in itertools.pairwise(times):
                instance.step(begin, end - begin)
                rows.append(instance.get(refs))
        np.testing.assert_array_equal(np.array(rows), expected)


@pytest.mark.long  # zig builds its runtime first
def test_a_binary_made_by_zig_shares_no_variables_between_instances(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if find_spec("ziglang") is None:
        pytest.skip("ziglang is not here")
    monkeypatch.setattr("fmu_export.binary.find_compiler", zig_compiler)
    rig = gb.Drivetrain("one")
    rig.add("body", gb.Inertia(J=1.0, w0=1.0))
    check = fmu_export.check(fmu_export.export(rig, tmp_path / "one.fmu"))
    assert "ok      binary" in str(check), check


def test_a_name_that_is_none_is_refused_with_those_that_there_are(
    unpacked: Unpacked, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, "x86-64-v9")
    with pytest.raises(Exception, match="ailed to instantiate"):
        Instance(unpacked)


@on_x86
def test_what_is_compiled_again_shares_no_name(monkeypatch: pytest.MonkeyPatch) -> None:
    sources = source_files("2.0", "", "")
    assert is_of_solver("gb_step.c") and is_of_solver("model.c") and not is_of_solver("gb_fmu.c")
    names = names_with({name: data for name, data in sources.items() if name.endswith(".h")}, "_v3").decode()
    for name in ("gb_open", "gb_get_model", "gb_model_key", "gb_step"):
        assert f"#define {name} {name}_v3\n" in names
    assert "#define gb_solver_plain gb_solver_v3\n" in names and "gb_fmu" not in names
    monkeypatch.setenv("CC", "cc -march=x86-64")
    assert variants_of(find_compiler()) == ()


def test_every_constant_of_a_declaration_gets_the_name_of_its_variant() -> None:
    header = b"extern const double gb_one[3], gb_two;\nextern const gb_kind\n    gb_three[], *gb_four;\nint gb_run(int *sim);"
    given = dict(line.split()[1:] for line in names_with({"gb_x.h": header}, "_v3").decode().splitlines())
    assert set(given) == {"gb_one", "gb_two", "gb_three", "gb_four", "gb_run", "gb_solver_plain", "gb_model_key"}
    assert given["gb_two"] == "gb_two_v3"


def test_what_studies_and_tangents_run_is_no_part_of_an_fmu() -> None:
    names = source_files("2.0", "", "")
    assert not [name for name in names if "tangent" in name or "study" in name or "lane" in name]
