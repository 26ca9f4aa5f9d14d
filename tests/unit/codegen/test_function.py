"""Signatures and calls of generated functions follow from the roles in them."""

import gearblocks as gb
from gearblocks.codegen.function import UNROLLED, Argument, Column, Function, Names, column, identifier
from gearblocks.codegen.operands import NONE, Local, Operand, Role, Statement
from gearblocks.model.build import make_program


def _function(body, *, read=NONE, arguments=(), count=1):
    return Function("rates_b", list(arguments), [], list(body), read, count)


def test_a_vector_that_is_only_read_is_const_and_one_that_is_written_is_not():
    body = [Statement(Operand(Role.RATES, 0, instance=True), "=", "y[0]")]
    function = _function(body, read=frozenset({Role.STATES, Role.INSTANCE}))
    assert function.signature == "const double *restrict y, double *restrict dy, const int e"
    assert function.calls == ["rates_b(y, dy, 0)"]


def test_roles_stand_in_one_order_with_single_numbers_last():
    read = frozenset({Role.STEP, Role.SKEWS, Role.PARAMETERS})
    body = [Statement(Operand(Role.RATES, 0), "=", "g", full=True)]
    assert [role.value for role in _function(body, read=read).roles] == ["par", "dy", "skew", "g", "full"]
    assert _function(body, read=read).signature == (
        "const double *restrict par, double *restrict dy, const double *restrict skew, const double g, const int full, "
        "const int e"
    )


def test_outputs_are_given_the_last_one_that_is_wanted():
    body = [Statement(Operand(Role.OUTPUTS, 3, instance=True), "show", "y[0]")]
    function = _function(body, read=frozenset({Role.STATES}), count=2)
    assert function.signature == ("const double *restrict y, double *restrict out, const int last, const int e")
    assert function.calls == ["rates_b(y, out, last, 0)", "rates_b(y, out, last, 1)"]


def test_words_in_a_text_ask_for_nothing():
    body = [Statement(Local("r0"), "define", "tau + mode + par")]
    assert _function(body).signature == "const int e"


def test_numbers_of_instances_are_written_into_calls_and_tables_are_for_loops_only():
    values = [3, 1, 4, 1, 5, 9, 2, 6, 5]
    few = [Argument("int", "q0", column("b_q0", values[:3]))]
    many = [Argument("int", "q0", column("b_q0", values))]
    assert _function([], arguments=few, count=3).calls == ["rates_b(0, 3)", "rates_b(1, 1)", "rates_b(2, 4)"]
    assert _function([], arguments=few, count=3).tables == []
    assert len(values) > UNROLLED
    assert _function([], arguments=many, count=len(values)).calls == ["rates_b(e, b_q0[e])"]
    assert _function([], arguments=many, count=len(values)).tables == many


def test_what_no_step_runs_through_is_looped_over():
    rig = gb.Drivetrain("pair")
    rig.chain(rig.add("one", gb.Inertia(J=1.0)), rig.add("shaft", gb.Shaft(k=1.0)), rig.add("two", gb.Inertia(J=1.0)))
    source = make_program(rig.train()).source
    assert source.count("inertia_torques_inertia_0(par, flange_tau") == 1
    assert source.count("energies_inertia_0(par, y, energy, ") == 2  # the ledger follows them step by step
    assert "GB_OUT_OF_LINE void outputs_inertia_0(" in source
    assert "static inline void outputs_shaft_1(" in source


def test_progressions_need_no_table():
    assert Column("x", (3, 5, 7, 9)).text() == "3 + 2 * e"
    assert Column("x", (0, 1, 2)).text() == "e"
    assert Column("x", (2.5, 2.5, 2.5)).text() == "2.5"
    assert Column("x", (1.0, 2.0, 3.0)).text() == "x[e]"  # floats could round
    assert Column("x", (1.0, 2.0)).is_table


def test_an_argument_is_taken_once():
    function = _function([], arguments=[Argument("int", "q0", Column("b_q0", (1,)))])
    function.take([Argument("int", "q0", Column("other", (2,))), Argument("int", "q1", Column("b_q1", (3,)))])
    assert [(x.name, x.column.values) for x in function.arguments] == [("q0", (1,)), ("q1", (3,))]


def test_names_remember_what_they_read():
    names = Names(Role.STATES)
    assert names.define("p_k", Operand(Role.PARAMETERS, 2, instance=True)) == "p_k"
    assert names.constants == {"p_k": "par[2 + e]"}
    assert names.reads == {Role.PARAMETERS, Role.INSTANCE}
    assert names.per_instance
    assert not Names(Role.STATES).per_instance
    assert Names(Role.UNWRAPPED_ANGLES).states is Role.STATES
    assert Names(Role.DIRECTION).states is Role.DIRECTION


def test_an_identifier_comes_of_any_path():
    assert identifier("backlash.half_gap") == "backlash_half_gap"
    assert identifier("cos[0]") == "cos_0"
