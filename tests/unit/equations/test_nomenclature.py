"""The words and letters of a nomenclature are those of a paper, not those of the one who fills in fields."""

from __future__ import annotations

import pytest

import gearblocks as gb


def _words(name: str, block: gb.Block) -> dict[str, str]:
    """Words by symbol of a train of two bodies and a block between them."""
    rig = gb.Drivetrain("train")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=1.0))
    rig.chain(a, rig.add(name, block), b)
    return {row[0]: row[1] for row in rig.equations().nomenclature()}


SPEEDS, TORQUES = [0.0, 100.0], [20.0, 10.0]
BLOCKS = {
    "converter": gb.TorqueConverter(capacity=gb.Table([0.0, 0.9], [0.01, 0.0]), ratio=gb.Table([0.0, 0.9], [2.0, 1.0])),
    "clutch": gb.Clutch(mu=gb.Table(SPEEDS, [0.3, 0.2]), force_max=100.0, engagement=1.0),
    "pair": gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3), external=True, k=1e4, c=1.0),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_what_is_said_to_the_user_alone_is_left_out(name: str) -> None:
    words = _words(name, BLOCKS[name])
    said = [text for text in words.values() if "gb." in text or "None" in text or "also over" in text]
    assert words and not said


def _driven(field: str, block: gb.Block) -> str:
    rig = gb.Drivetrain("train")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.connect(body.a, rig.add("drive", block).flange)
    eq = rig.equations()
    (symbol,) = [s for s, entry in eq.entries.items() if entry.path == f"drive.{field}"]
    return eq.names[symbol].letter


def test_a_table_has_the_letter_of_its_field_where_the_capital_is_a_latin_one() -> None:
    table = gb.Table(SPEEDS, TORQUES)
    assert _driven("tau", gb.Torque(tau=table)) == "τ"
    assert _driven("w", gb.Speed(w=gb.Table(SPEEDS, TORQUES, "cubic"))) == "Ω"


def test_the_force_of_friction_on_a_slider_is_called_one() -> None:
    rig = gb.Drivetrain("slider")
    mass = rig.add("mass", gb.Mass(m=2.0))
    rig.connect(mass.a, rig.add("brake", gb.Brake(capacity=3.0)).a)
    words = {row[0]: (row[1], row[3]) for row in rig.equations().nomenclature()}
    assert words["F_brake"] == ("force of the constraint", "N")
