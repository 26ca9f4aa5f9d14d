"""Numbers of many digits stand in the nomenclature, not in the equations."""

from __future__ import annotations

import math

import gearblocks as gb


def _driven(tau: object) -> gb.Drivetrain:
    rig = gb.Drivetrain("train")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=tau)).flange)
    return rig


def test_a_number_of_many_digits_is_a_constant_with_all_of_them_in_the_nomenclature() -> None:
    eq = _driven(math.sqrt(2) * gb.time + math.sqrt(2) * gb.sin(math.sqrt(3e-20) + 2.5 * gb.time)).equations()
    balance = str(eq.document().sections[0].lines[0].right)
    assert "1.4142" not in balance and "1.7320" not in balance and "2.5" in balance
    rows = {row[0]: row for row in eq.nomenclature()} | {row[0]: row for row in eq.document().nomenclature}
    assert rows["n1"][1] == "constant" and abs(float(rows["n1"][2]) - math.sqrt(2)) < 1e-14
    assert abs(float(rows["n2"][2]) / math.sqrt(3e-20) - 1) < 1e-14 and "n3" not in rows
    assert "n1 t" in str(eq) and r"n_{1}\,t" in eq.latex()


def test_short_numbers_and_fractions_of_pi_stand_where_they_are() -> None:
    text = str(_driven(9.80665 * gb.time + gb.sin(100 * math.pi / 3 * gb.time)).equations())
    assert "9.80665 t" in text and "π" in text and "constant" not in text


def test_a_constant_is_not_called_as_a_parameter_is() -> None:
    n = gb.Parameter("n", 3.0)
    names = [row[0] for row in _driven(math.sqrt(2) * gb.time * n).equations().document().nomenclature]
    assert "n" in names and "ν1" in names
