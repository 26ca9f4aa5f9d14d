"""Operands print their C once; what a statement reads and writes follows from its values."""

import pytest

from gearblocks.codegen.operands import Assignment, Choice, Index, Local, Operand, Role, Statement

TEXTS = {
    "par[3]": Operand(Role.PARAMETERS, 3),
    "par[3 + e]": Operand(Role.PARAMETERS, 3, instance=True),
    "dy[v_a]": Operand(Role.RATES, "v_a"),
    "time_terms[2 * GB_LANES]": Operand(Role.TIME_TERMS, 2),
    "time_terms[(2 + e) * GB_LANES]": Operand(Role.TIME_TERMS, 2, instance=True),
    "time_terms[(2 + e) * GB_LANES + i]": Operand(Role.TIME_TERMS, 2, instance=True).of_lane(),
    "u[1 * GB_LANES + i]": Operand(Role.INPUTS, 1, lane=True),
    "t[i]": Operand(Role.TIME, lane=True),
    "g": Operand(Role.STEP),
    "n5": Local("n5"),
    "(l0 ? lower : upper)[p0]": Choice("l0", Role.LOWER, Role.UPPER, "p0"),
    "7 + e": Index(7, instance=True),
    "at0": Index("at0"),
}


@pytest.mark.parametrize("text", TEXTS)
def test_an_operand_prints_its_vector_and_offset(text):
    assert str(TEXTS[text]) == text


def test_an_operand_that_is_read_asks_for_its_vector_and_for_what_its_offset_needs():
    assert TEXTS["par[3]"].read == {Role.PARAMETERS}
    assert TEXTS["time_terms[(2 + e) * GB_LANES + i]"].read == {Role.TIME_TERMS, Role.INSTANCE, Role.LANE}
    assert TEXTS["t[i]"].read == {Role.TIME, Role.LANE}
    assert not TEXTS["n5"].read


def test_a_target_is_written_and_its_offset_is_read():
    statement = Statement(TEXTS["time_terms[(2 + e) * GB_LANES + i]"], "=", "1.0")
    assert statement.written == {Role.TIME_TERMS}
    assert statement.read == {Role.LANE, Role.INSTANCE}
    choice = Statement(TEXTS["(l0 ? lower : upper)[p0]"], "+=", "1.0", full=True)
    assert choice.written == {Role.LOWER, Role.UPPER}
    assert choice.read == {Role.FULL}


@pytest.mark.parametrize("op", ["sign", "table", "band"])
def test_limits_of_a_switch_read_its_mode_and_write_both(op):
    statement = Statement(Index(0, instance=True), op, "1.0")
    assert statement.written == {Role.LOWER_LIMITS, Role.UPPER_LIMITS}
    assert statement.read == {Role.MODES}


def test_entries_of_a_matrix_are_spread_over_its_three_parts():
    parts = {Role.DIAGONAL, Role.LOWER, Role.UPPER}
    assert Statement(Index(0), "spread", "1.0").written == parts
    terms = Statement(Index(0), "spread_terms", "1.0")
    assert terms.written == parts | {Role.ENTRIES}
    assert terms.read == {Role.COEFFICIENTS}


def test_equal_places_are_one():
    assert Operand(Role.KINEMATIC_TERMS, 5) == Operand(Role.KINEMATIC_TERMS, 5)
    assert (
        len(
            {
                Operand(Role.KINEMATIC_TERMS, 5),
                Operand(Role.KINEMATIC_TERMS, 5),
                Operand(Role.KINEMATIC_TERMS, 5, instance=True),
            }
        )
        == 2
    )
    assert Assignment(Local("x"), "define", 1).factor == ""
