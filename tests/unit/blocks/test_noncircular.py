"""The pair of non-circular gears as a block: files, programs, and what is refused."""

import pytest

import gearblocks as gb


def _rig(law, **mesh):
    rig = gb.Drivetrain("pair")
    gear = gb.NonCircularGear(law=law, **({"external": False, "k": 400.0, "c": 0.01} | mesh))
    rig.chain(
        rig.add("drive", gb.Torque(tau=0.2)), rig.add("one", gb.Inertia(J=1e-4, w0=100.0)), rig.add("mesh", gear),
        rig.add("two", gb.Inertia(J=2e-4, w0=float(law.m(0.0)) * 100.0)),
    )  # fmt: skip
    return rig


@pytest.mark.parametrize(
    "name",
    [
        "segments",
        pytest.param("two lobes", marks=pytest.mark.long),
        "ellipse",
        pytest.param("three lobes", marks=pytest.mark.long),
        pytest.param("waves", marks=pytest.mark.long),
        pytest.param("fitted", marks=pytest.mark.long),
        pytest.param("table", marks=pytest.mark.long),
    ],
)
@pytest.mark.few(1)
def test_a_train_with_a_ratio_law_survives_its_file(ratio_laws, name, tmp_path):
    law = ratio_laws[name]
    rig = _rig(law, backlash=gb.Backlash(half_gap=1e-4), k=400 + 20 * gb.cos(gb.driver_angle))
    rig.to_json(tmp_path / "rig.json")
    back = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert back["mesh"].law == law
    assert gb.build(back).program.key == gb.build(rig).program.key


@pytest.mark.long
def test_another_law_is_another_program(ratio_laws):
    keys = {gb.build(_rig(law)).program.key for law in ratio_laws.values()}
    assert len(keys) == len(ratio_laws)


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"law": 2.0}, r"law = 2\.0 must be a gb\.RatioLaw"),
        ({"external": None}, "external = None must be True or False"),
        ({"k": -1.0}, r"k = -1\.0 N m/rad must be > 0"),
        ({"k": None}, "damping needs compliance: give k"),
        ({"k": gb.twist}, r"contains gb\.twist, which only the torque of a Shaft knows"),
        ({"k": None, "c": None, "phase": gb.Input("p")}, "has no acceleration.*an Input may jump"),
        ({"k": None, "c": None, "phase": gb.Table([0, 1], [0, 1])}, "a table of kind 'linear' has corners"),
        ({"k": None, "c": None, "phase": abs(gb.time)}, "Abs has corners"),
        ({"phase": gb.sense("one.w"), "filter": 10.0}, "is sensed and has no value yet when the filter starts"),
        ({"filter": 10.0}, "filter is that of a phase; give one"),
        ({"k": 400 + gb.driver_angle, "c": None, "damping_ratio": 0.1}, "damping_ratio needs a k that does not change"),
    ],
)
def test_a_pair_that_cannot_be_is_refused(ratio_laws, fields, words):
    with pytest.raises(gb.ModelError, match=words):
        gb.Drivetrain("wrong").add(
            "mesh",
            gb.NonCircularGear(**({"law": ratio_laws["ellipse"], "external": False, "k": 400.0, "c": 0.01} | fields)),
        )


def test_a_spring_over_the_driver_angle_is_no_shaft():
    rig = gb.Drivetrain("wrong")
    with pytest.raises(gb.ModelError, match=r"gb\.driver_angle, which only the k of a NonCircularGear knows"):
        rig.add("shaft", gb.Shaft(k=gb.driver_angle + 1))
