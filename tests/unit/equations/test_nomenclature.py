"""The words and letters of a nomenclature are those of a paper, not those of the one who fills in fields."""

from __future__ import annotations

from typing import Any

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.equations import names
from gearblocks.language.fields import Field


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


def test_every_number_of_the_catalogue_has_a_letter_and_no_name_of_code() -> None:
    kinds = [
        x for x in (getattr(gb, n) for n in gb.__all__) if isinstance(x, type) and issubclass(x, (gb.Block, gb.Effect))
    ]
    words = {
        f"{kind.__name__}.{name}"
        for kind in kinds
        for name, field in kind.fields.items()
        if field.role in ("param", "exact", "signal")
        and (
            names.of_field(name, "", field.symbol).is_word
            or (field.role == "signal" and _table_of(name, field).is_word)
        )
    }
    states = {
        f"{kind.__name__}.{name}"
        for kind in kinds
        for name, state in kind.states.items()
        if name not in ("impulse", "impacts") and names.of_state(name, "", state.symbol).is_word  # these move nothing
    }
    assert len(kinds) > 50 and not words and not states


def _table_of(name: str, field: Field) -> names.Name:
    return names.of_table(name, "", field.symbol)


class Fan(gb.Block):
    """Drag of a fan: its numbers have the symbols that it declares."""

    flange = gb.Flange("shaft")
    blade_loss: float = gb.param("drag per speed squared", "N m s2/rad2", gt=0, symbol="d_2")
    spin_up = gb.State("slip of the air", symbol="gamma_1")

    def physics(self, s: Any) -> Any:
        yield gb.Acts(s.flange, -s.blade_loss * s.flange.w * abs(s.flange.w) - s.spin_up)
        yield gb.Rate(s.spin_up, s.flange.w - s.spin_up)


def test_a_field_and_a_state_may_declare_their_symbol() -> None:
    rig = gb.Drivetrain("train")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.connect(body.a, rig.add("fan", Fan(blade_loss=2.0)).flange)
    symbols = {row[4]: row[0] for row in rig.equations().nomenclature()}
    assert symbols["fan.blade_loss"] == "d2_fan" and symbols["fan.spin_up"] == "γ1_fan"


def test_a_table_that_is_not_the_whole_of_its_field_is_told_apart_from_it() -> None:
    table = gb.Table([0.0, 1.0], [0.0, 40.0])
    rig = gb.Drivetrain("train")
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("brake", gb.Brake(capacity=3 + 2 * table(gb.time))))
    assert "C_brake = 3 + 2 C_tab_brake(t)" in str(rig.equations())
    assert "T_brake = -C_brake(t) sgn" in str(rig.set({"brake.capacity": table}).equations())


def test_a_symbol_that_is_wider_than_its_column_leaves_the_others_in_theirs() -> None:
    rig = gb.Drivetrain("train")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.connect(body.a, rig.add("aVeryLongNameOfWhatDrivesTheTrain", gb.Torque(tau=2.0)).flange)
    rows = str(rig.equations().nomenclature()).splitlines()[1:]
    assert rows[-2].strip() == "τ_aVeryLongNameOfWhatDrivesTheTrain"
    assert rows[-1].index("torque on") == rows[0].index("angle of")


def test_a_part_of_a_condition_that_belongs_together_stands_in_brackets() -> None:
    w = gb.sense("body.w")._sympy_()
    rig = gb.Drivetrain("train")
    body = rig.add("body", gb.Inertia(J=1.0))
    tau = sp.Piecewise((1.0, sp.Or(w > 3, sp.And(w > 1, gb.time._sympy_() > 2))), (0.0, True))
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=tau)).flange)
    assert "or (" in str(rig.equations()) and " and " in str(rig.equations())
