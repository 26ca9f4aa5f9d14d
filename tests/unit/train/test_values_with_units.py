"""Values with units, from the field to the run, the file, the FMU and the shell: converted, or refused by both names."""

import math
import zipfile
from pathlib import Path

import numpy as np
import pytest
from lxml import etree
from typer.testing import CliRunner

import fmu_export
import gearblocks as gb
from gearblocks.cli.main import app

RPM = math.pi / 30


def _driven(k="20 kN m/rad"):
    """Two bodies on a shaft at n = 3000 rpm; a torque by an input in kN m."""
    n = gb.Parameter("n", 3000, "rpm")
    rig = gb.Drivetrain("driven")
    drive = rig.add("drive", gb.Torque(tau=gb.Input("T", start=0.1, unit="kN m")))
    motor = rig.add("motor", gb.Inertia(J="200 kg cm2", w0=n))
    load = rig.add("load", gb.Inertia(J=0.1, w0="50 rev/s"))
    rig.chain(drive, motor, rig.add("shaft", gb.Shaft(k=k, damping_ratio="2 %")), load)
    return rig


@pytest.mark.long
def test_a_train_with_units_is_that_in_si():
    plain = gb.Drivetrain("driven")
    drive = plain.add("drive", gb.Torque(tau=100.0))
    bodies = [plain.add(name, gb.Inertia(J=J, w0=100 * math.pi)) for name, J in (("motor", 0.02), ("load", 0.1))]
    plain.chain(drive, bodies[0], plain.add("shaft", gb.Shaft(k=20e3, damping_ratio=0.02)), bodies[1])
    one, other = (gb.simulate(rig, t_end=0.02) for rig in (_driven(), plain))
    assert np.array_equal(one["shaft.torque"], other["shaft.torque"]) and one["motor.w"][0] == 100 * math.pi


def test_values_of_a_run_are_in_the_unit_that_was_declared_or_bring_one():
    model = gb.build(_driven())
    for n in (6000, "6000 rpm", "200 rad/s", f"{200 * math.pi!r} rad/s"):
        run = gb.simulate(model, t_end=1e-3, parameters={"n": n, "shaft.k": "1 MN m/rad"}, inputs={"T": 0.2})
        assert run["motor.w"][0] == (200.0 if n == "200 rad/s" else pytest.approx(200 * math.pi, rel=1e-15))
        assert run["drive.torque"][-1] == 200.0 and run.meta["parameters"]["shaft.k"] == 1e6
    table = gb.Table([0.0, 1.0], [0.2, 0.2])
    for source in (table, lambda t: 0.2, "200 N m"):
        assert gb.simulate(model, t_end=1e-3, inputs={"T": source})["drive.torque"][-1] == pytest.approx(
            200.0, rel=1e-15
        )
    start = gb.simulate(model, t_end=1e-3, initial={"motor.w": "1000 rpm", "load.w": "1 rev/s"})
    assert start["motor.w"][0] == pytest.approx(1000 * RPM, rel=1e-15) and start["load.w"][0] == pytest.approx(
        2 * math.pi
    )


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"parameters": {"n": "3 kN"}}, r"in kN \(N\), but what belongs here is in rad/s"),
        ({"parameters": {"n": "50 Hz"}}, "give rad/s or rpm"),
        ({"parameters": {"n": "3000 1/min"}}, "'1/min' does not say whether it counts turns or radians: write rpm"),
        ({"initial": {"motor.w": "3000 min-1"}}, "'min-1' does not say"),
        ({"parameters": {"shaft.k": "5 bananas"}}, "'bananas' is no unit"),
        ({"inputs": {"T": "3 mm"}}, "belongs here is in N m"),
        ({"initial": {"motor.w": "3 m/s"}}, "belongs here is in rad/s"),
    ],
)
def test_values_of_something_else_are_refused_by_both_names(given, words):
    with pytest.raises(gb.ParameterError, match=words):
        gb.simulate(gb.build(_driven()), t_end=1e-3, **given)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.Shaft(k="3 kN"), r"k: '3 kN' is in kN \(N\), but what belongs here is in N m/rad"),
        (lambda: gb.GearMesh(teeth=(20, 40), module="2 mm", k="200 N m"), "k: '200 N m' .* belongs here is in N/m"),
        (lambda: gb.Backlash(half_gap="3 N"), "half_gap: '3 N'"),
        (lambda: gb.Inertia(J="3 bananas"), "J: .*'bananas' is no unit"),
        (lambda: gb.Inertia(J="0,02 kg m2"), "without commas: '0.02 kg m2'"),
        (lambda: gb.Speed(w="3000 1/min"), "w: '3000 1/min' .* write rpm"),
        (lambda: gb.Inertia(J=1.0, w0="3000 1/min"), "w0: '3000 1/min' .* write rpm"),
        (lambda: gb.param("speed", "rpm"), "declare it in SI, 'rad/s'"),
        (lambda: gb.option("which", ("one", "two")), "must be text such as"),
    ],
)
def test_fields_refuse_other_measures(make, words):
    with pytest.raises(gb.GearblocksError, match=words):
        make()


@pytest.mark.long
def test_what_a_shaft_takes_depends_on_what_it_joins():
    for block, k, wrong in (
        (gb.Mass(m="3 t"), "200 N/mm", "20 kN m/rad"),
        (gb.Inertia(J=1.0), "20 kN m/rad", "200 N/mm"),
    ):
        for value, fits in ((k, True), (wrong, False), (gb.Parameter("k", 2.0, k[-4:].strip()), k == "200 N/mm")):
            rig = gb.Drivetrain("pair")
            rig.chain(rig.add("one", block), rig.add("joint", gb.Shaft(k=value)), rig.add("two", block))
            if fits:
                gb.build(rig)
            else:
                with pytest.raises(gb.ModelError, match="'joint': k is given in"):
                    gb.build(rig)


@pytest.mark.parametrize("signal", [gb.Parameter, gb.Input])
@pytest.mark.parametrize("unit", ["1/min", "min-1", "1/h", "Hz"])
def test_a_leaf_that_may_count_turns_or_radians_is_refused_where_it_meets_a_speed(signal, unit):
    rig = gb.Drivetrain("driven")
    rig.chain(rig.add("drive", gb.Speed(w=signal("n", 3000, unit))), rig.add("body", gb.Inertia(J=1.0)))
    with pytest.raises(gb.ModelError, match=r"'drive': w is given in .*belongs here is in rad/s; .*rpm"):
        gb.build(rig)


def test_outputs_are_converted_where_they_are_asked_for():
    run = gb.simulate(_driven(), t_end=0.01)
    assert np.array_equal(run.to("shaft.twist", "deg"), run["shaft.twist"] / (math.pi / 180))
    assert run.to("motor.w", "rpm")[0] == pytest.approx(3000.0, rel=1e-15) and run.to("t", "ms")[-1] == pytest.approx(
        10.0
    )
    with pytest.raises(gb.ParameterError, match=r"'shaft.twist' is in rad"):
        run.to("shaft.twist", "kN")
    with pytest.raises(gb.ParameterError, match="no unit"):
        run.to("shaft.twist", "banana")
    with pytest.raises(gb.ParameterError, match=r"'motor.w' is in rad/s.* write rpm"):
        run.to("motor.w", "1/min")
    assert run.to("motor.w", "1/s")[0] == 100 * math.pi


def test_a_study_varies_in_the_declared_unit():
    study = gb.sweep(_driven(), {"n": [3000.0, 6000.0], "T": [0.1]}, quantity=gb.at("motor.w", 0.0), t_end=1e-3)
    assert study.units[:2] == ("rpm", "kN m") and study.points[:, 0].tolist() == [3000.0, 6000.0]
    assert study.values[:, 0] == pytest.approx([100 * math.pi, 200 * math.pi], rel=1e-15)


def test_a_file_keeps_the_declared_units(tmp_path):
    _driven().to_json(tmp_path / "rig.json")
    again = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert again.train() == _driven().train()
    assert "w0 = n (3000 rpm)" in again.describe()
    assert np.array_equal(gb.simulate(again, t_end=1e-3)["motor.w"], gb.simulate(_driven(), t_end=1e-3)["motor.w"])


def test_an_fmu_holds_si_and_shows_the_declared_unit(tmp_path: Path):
    path = fmu_export.export(gb.build(_driven()), tmp_path / "driven.fmu", t_end=0.01, platforms=())
    with zipfile.ZipFile(path) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    real = {v.get("name"): v.find("Real") for v in root.iter("ScalarVariable")}
    assert real["n"].get("unit") == "rad/s" and real["n"].get("displayUnit") == "rpm"
    assert float(real["n"].get("start")) == 100 * math.pi
    assert (
        real["T"].get("unit") == "N.m"
        and real["T"].get("displayUnit") == "kN.m"
        and float(real["T"].get("start")) == 100.0
    )
    units = {
        u.get("name"): {d.get("name"): float(d.get("factor")) for d in u.iter("DisplayUnit")} for u in root.iter("Unit")
    }
    assert units["N.m"]["kN.m"] == 1e-3 and units["rad/s"]["rpm"] == pytest.approx(30 / math.pi, rel=1e-15)


def test_the_shell_takes_units(tmp_path):
    script = tmp_path / "rig.py"
    script.write_text(
        "import gearblocks as gb\n\n\ndef make():\n    rig = gb.Drivetrain('one')\n"
        "    rig.chain(rig.add('a', gb.Inertia(J=1.0, w0=gb.Parameter('n', 60, 'rpm'))), rig.add('s', gb.Shaft(k=1e3)),\n"
        "              rig.add('b', gb.Inertia(J=2.0)))\n    return rig\n",
        encoding="utf-8",
    )
    out = tmp_path / "run.csv"
    arguments = [
        "run",
        f"{script}:make",
        "--t-end",
        "0.001",
        "--set",
        "n=120",
        "--set",
        "s.k=2kN m/rad",
        "--out",
        str(out),
    ]
    answer = CliRunner().invoke(app, arguments)
    assert answer.exit_code == 0, answer.output
    names, first = out.read_text(encoding="utf-8").splitlines()[:2]
    assert float(first.split(",")[names.split(",").index("a.w")]) == pytest.approx(4 * math.pi)
