"""What lies in the file: reproducible, described with units, and refused by name where it cannot be made."""

from __future__ import annotations

import math
import shutil
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree

import fmu_export
from fmu_export.checks.file import check_sources
from fmu_export.checks.instance import Unpacked
from fmu_export.exporter import model_identifier
from gearblocks.codegen.output_list import OutputList
from gearblocks.codegen.program import StartInfo
from gearblocks.errors import GearblocksError
from gearblocks.solver.library import Model

START = np.array([1e-3, 0.5] + 14 * [0.0])
MODELS = Callable[[str], Model]


def description(path: Path) -> Any:
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))


def variable(root: Any, name: str) -> Any:
    found = root.xpath(f"ModelVariables/ScalarVariable[@name='{name}']")
    assert len(found) == 1, name
    return found[0]


def test_two_exports_are_identical_byte_for_byte(model: Model, packed: Path, tmp_path: Path) -> None:
    again = fmu_export.export(model, tmp_path / "again.fmu", t_end=0.1)
    assert again.read_bytes() == packed.read_bytes()


def test_the_archive_holds_all_that_is_needed_under_plain_names(packed: Path) -> None:
    with zipfile.ZipFile(packed) as archive:
        names = archive.namelist()
    assert names == sorted(names)
    assert {"modelDescription.xml", "documentation/index.html", "resources/gearblocks.json"} <= set(names)
    assert {"sources/model.c", "sources/fmu_table.c", "sources/fmi2_glue.c", "sources/gb_core.h"} <= set(names)
    assert any(name.startswith("binaries/") for name in names)


def test_every_c_source_is_listed_in_the_description(packed: Path) -> None:
    listed = description(packed).xpath("CoSimulation/SourceFiles/File/@name")
    with zipfile.ZipFile(packed) as archive:
        held = [name.removeprefix("sources/") for name in archive.namelist() if name.endswith(".c")]
    assert sorted(listed) == sorted(held)


def test_variables_carry_units_limits_and_start_values(packed: Path) -> None:
    root = description(packed)
    stiffness = variable(root, "spring.k")
    assert (stiffness.get("causality"), stiffness.get("variability")) == ("parameter", "tunable")
    assert dict(stiffness[0].attrib) == {"unit": "N.m/rad", "min": "0.0", "start": "20000.0"}
    assert variable(root, "wheel.phi0").get("variability") == "fixed"
    assert variable(root, "solver.rtol")[0].get("start") == "1e-06"
    tau = variable(root, "tau")
    assert (tau.get("causality"), tau.get("variability"), tau[0].get("start")) == ("input", "continuous", "5.0")
    speed = variable(root, "wheel.w")
    assert (speed.get("causality"), speed[0].get("unit"), speed[0].get("displayUnit")) == ("output", "rad/s", "rpm")
    assert "unit" not in variable(root, "spring.contact")[0].attrib


def test_units_are_written_in_base_units_with_known_display_factors(packed: Path) -> None:
    root = description(packed)
    units = {unit.get("name"): unit for unit in root.xpath("UnitDefinitions/Unit")}
    assert dict(units["N.m.s/rad"][0].attrib) == {"kg": "1", "m": "2", "s": "-1", "rad": "-1"}
    shown = {u.get("name"): float(u.get("factor")) for u in root.xpath("UnitDefinitions/Unit/DisplayUnit")}
    assert shown["rpm"] * 2 * math.pi == pytest.approx(60.0, rel=1e-15)
    assert shown["deg"] * math.pi == pytest.approx(180.0, rel=1e-15)


@pytest.mark.long
def test_an_output_named_like_a_parameter_is_shown_beside_it(model: Model, tmp_path: Path) -> None:
    quantity = model.program.outputs[3]._replace(name="spring.k")
    outputs = OutputList.of([*model.program.outputs[:3], quantity, *model.program.outputs[4:]])
    twin = Model(replace(model.program, outputs=outputs), model.library, model.values)
    path = fmu_export.export(twin, tmp_path / "twin.fmu", t_end=0.01)
    assert variable(description(path), "spring.k").get("causality") == "parameter"
    assert variable(description(path), "spring.k_output").get("causality") == "output"
    assert all(item.ok for item in fmu_export.check(path).items)


def test_two_variables_of_one_name_are_refused(model: Model, tmp_path: Path) -> None:
    clashing = replace(model.program, inputs=(model.program.inputs[0]._replace(name="time"),))
    with pytest.raises(GearblocksError, match="two variables of the FMU would be called 'time'"):
        fmu_export.export(Model(clashing, model.library, model.values), tmp_path / "clash.fmu")


def test_only_the_chosen_outputs_are_shown(model: Model, tmp_path: Path) -> None:
    path = fmu_export.export(model, tmp_path / "few.fmu", outputs=["spring.*", "wheel.w"], platforms=())
    names = description(path).xpath("ModelVariables/ScalarVariable[@causality='output']/@name")
    assert names == ["wheel.w", "spring.torque", "spring.contact"]


@pytest.mark.long
@pytest.mark.parametrize(
    ("chosen", "t_end"),
    [
        ({"outputs": ["spring.*", "wheel.w"]}, 0.01), ({"parameters": {"half_gap": 5e-4, "speed": 700.0}}, 0.02)
    ],
)  # fmt: skip
def test_an_fmu_with_chosen_outputs_or_given_parameters_passes_every_check(
    model: Model, tmp_path: Path, chosen: dict[str, Any], t_end: float
) -> None:
    assert fmu_export.check(fmu_export.export(model, tmp_path / "chosen.fmu", **chosen), t_end=t_end).ok


@pytest.mark.long
def test_the_token_changes_with_everything_that_changes_the_run(
    model: Model, make_model: MODELS, tmp_path: Path
) -> None:
    def token(path: Path) -> str:
        return str(description(path).get("guid"))

    variants = [
        fmu_export.export(model, tmp_path / "a.fmu"),
        fmu_export.export(model, tmp_path / "b.fmu", rtol=1e-7),
        fmu_export.export(model, tmp_path / "c.fmu", method="dp5"),
        fmu_export.export(model, tmp_path / "d.fmu", outputs="wheel.*"),
        fmu_export.export(model, tmp_path / "e.fmu", parameters={"spring.k": 1.9e4}),
        fmu_export.export(model, tmp_path / "f.fmu", initial=START),
    ]
    assert len({token(path) for path in variants}) == len(variants)


def test_given_parameters_become_the_start_values(model: Model, tmp_path: Path) -> None:
    given = {"half_gap": 5e-4, "speed": 700.0}
    root = description(fmu_export.export(model, tmp_path / "other.fmu", parameters=given, platforms=()))
    assert variable(root, "spring.backlash.half_gap")[0].get("start") == "0.0005"
    assert variable(root, "speed")[0].get("start") == "700.0"


@pytest.mark.long
def test_a_given_start_state_replaces_the_start_parameters(model: Model, tmp_path: Path) -> None:
    path = fmu_export.export(model, tmp_path / "start.fmu", initial=START, t_end=0.02)
    root = description(path)
    assert variable(root, "wheel.w.start")[0].get("start") == "0.5"
    assert variable(root, "wheel.w.start").get("variability") == "fixed"
    assert not root.xpath("ModelVariables/ScalarVariable[@name='wheel.phi0']")
    assert fmu_export.check(path).ok


@pytest.mark.long
def test_start_values_by_name_set_the_start_parameters(model: Model, tmp_path: Path) -> None:
    program = replace(model.program, starts=(StartInfo("wheel.phi", 6, 1.0),))
    named = Model(program, model.library, model.values)
    path = fmu_export.export(named, tmp_path / "start.fmu", initial={"wheel.phi": 1.5e-3}, t_end=0.02)
    assert variable(description(path), "wheel.phi0")[0].get("start") == "0.0015"
    assert fmu_export.check(path).ok


@pytest.mark.long
def test_the_name_may_be_any_text(make_model: MODELS, tmp_path: Path) -> None:
    name = 'Prüfstand "1" <50 %> \\ */'
    folder = tmp_path / "mit Umlaut ä und Leerzeichen"
    folder.mkdir()
    path = fmu_export.export(make_model(name), folder / "Prüf stand.fmu", t_end=0.01)
    assert description(path).get("modelName") == name
    assert model_identifier(name) == "Pr_fstand_1_50"
    assert model_identifier("2 stages") == "m2_stages"
    assert fmu_export.check(path).ok


def test_sources_compile_in_an_empty_folder_without_a_warning(unpacked: Unpacked) -> None:
    item = check_sources(unpacked)
    assert item.ok, item.words


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("gb_start.c", lambda text: text + "static int unused;\n", "unused"),
        ("gb_model.h", lambda text: text + "int 2nd;\n", "gb_model.h"),
        ("model.c", lambda text: text + "static int unused;\n", "unused"),
    ],
    ids=["warning", "error in a header", "warning in the model"],
)
@pytest.mark.few(1)
def test_sources_that_differ_from_those_that_compiled_are_compiled_again(
    unpacked: Unpacked, tmp_path: Path, name: str, change: Callable[[str], str], words: str
) -> None:
    assert check_sources(unpacked).ok
    folder = shutil.copytree(unpacked.folder, tmp_path / "changed")
    file = folder / "sources" / name
    file.write_text(change(file.read_text()))
    item = check_sources(replace(unpacked, folder=folder))
    assert item.ok is False and words in item.words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fmi": "3.0"}, "not available in this version; possible: fmi='2.0'"),
        ({"fmi": "1.0"}, "fmi = '1.0' is unknown"),
        ({"platforms": ("aarch64-darwin",)}, "not available in this version; possible on this machine: native"),
        ({"platforms": ("beos",)}, "platform 'beos' is unknown"),
        ({"method": "euler"}, "method = 'euler' must be"),
        ({"method": "rk4"}, "give step="),
        ({"rtol": 0.0}, "rtol = 0.0 must lie"),
        ({"step": -1e-5}, "step = -1e-05 s must be > 0"),
        ({"outputs": "spring.torqe"}, "did you mean 'spring.torque'"),
        ({"parameters": {"spring.kk": 1.0}}, "did you mean 'spring.k'"),
        ({"parameters": {"spring.k": math.nan}}, "spring.k = nan"),
        ({"parameters": {"spring.k": -1.0}}, "spring.k = -1.0 N m/rad must be >= 0"),
        ({"initial": [math.nan, *START[1:]]}, "the initial value of 'wheel.phi'"),
        ({"initial": [0.0]}, "a state vector has 16 entries"),
        ({"t_end": 0.0}, "t_end = 0.0 s"),
        ({"patience": -1.0}, "patience = -1.0 s must be >= 0"),
    ],
)
def test_what_cannot_be_exported_is_refused_by_name_and_the_file_kept(
    model: Model, tmp_path: Path, options: dict[str, Any], words: str
) -> None:
    path = tmp_path / "kept.fmu"
    path.write_text("before")
    with pytest.raises(GearblocksError) as caught:
        fmu_export.export(model, path, **options)
    assert words in str(caught.value)
    assert path.read_text() == "before"
    assert [file.name for file in tmp_path.iterdir()] == ["kept.fmu"]
