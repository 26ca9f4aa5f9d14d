"""Effects of a deflection are in its unit: a length in a mesh, an angle in a non-circular gear."""

from typing import Any

import pytest

import gearblocks as gb


def _rig(**effects: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("elliptical pair")
    law = gb.RatioLaw.ellipse(e=0.3)
    pair = rig.add("pair", gb.NonCircularGear(law=law, external=True, k=1e4, c=1.0, **effects))
    rig.chain(rig.add("drive", gb.Speed(w=10.0)), pair, rig.add("load", gb.Inertia(J=0.1)))
    return rig


def _mesh(**effects: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("pair")
    mesh = gb.GearMesh(teeth=(20, 30), external=True, r_base=(0.02, 0.03), k=1e8, **effects)
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("mesh", mesh), rig.add("b", gb.Inertia(J=1.0)))
    return rig


def test_a_gap_about_an_angle_is_given_in_degrees_and_shown_in_radians() -> None:
    error = gb.Superposition(first=gb.Harmonic(cos=("0.1 mrad",)), second=gb.Harmonic(sin=(2e-4,), driven_by=3.0))
    rig = _rig(backlash=gb.Backlash(half_gap="0.1 deg"), transmission_error=error)
    model = gb.build(rig)
    units = {p.path: p.unit for p in model.program.parameters}
    paths = ["backlash.half_gap", "transmission_error.first.cos[0]", "transmission_error.second.sin[0]"]
    assert [units[f"pair.{path}"] for path in paths] == ["rad"] * 3
    rows = {path: unit for _, _, _, unit, path in rig.equations().nomenclature()}
    assert [rows[f"pair.{path}"] for path in paths] == ["deg", "mrad", "rad"]
    run = gb.simulate(model, t_end=0.1)
    number = run.meta["parameters"]["pair.backlash.half_gap"]
    bare = _rig(backlash=gb.Backlash(half_gap=number), transmission_error=error)
    assert run["load.w"].tobytes() == gb.simulate(bare, t_end=0.1)["load.w"].tobytes()
    with pytest.raises(gb.ParameterError, match=r"'0\.1 mm' is in mm \(m\), but what belongs here is in rad"):
        gb.simulate(model, t_end=0.1, parameters={"pair.backlash.half_gap": "0.1 mm"})


@pytest.mark.parametrize(
    ("make", "effects", "words"),
    [
        (_rig, {"backlash": gb.Backlash(half_gap="0.1 mm")}, "backlash.half_gap is given in mm, .* is in rad"),
        (
            _rig,
            {"transmission_error": gb.Harmonic(cos=("5 um",))},
            r"transmission_error.cos\[0\] is given in um, .* in rad",
        ),
        (_mesh, {"backlash": gb.Backlash(half_gap="0.1 deg")}, "backlash.half_gap is given in deg, .* is in m"),
    ],
)
def test_what_measures_something_else_is_refused_when_the_train_is_put_together(
    make: Any, effects: dict[str, Any], words: str
) -> None:
    with pytest.raises(gb.ModelError, match=words):
        gb.build(make(**effects))
