"""Phases and slopes that several equations of a part read have symbols of their own, and long equations few lines."""

import re

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.equations.repeated_terms import Part, with_symbols
from tests.unit.equations.planets import LAWS, planets


@pytest.mark.parametrize("kind", [*LAWS])
@pytest.mark.parametrize("nested", [False, True], ids=["whole", "nested"])
@pytest.mark.few(1)
def test_the_equations_of_planets_with_errors_are_short(kind, nested):
    eq = planets(kind, nested).equations()
    text, latex = str(eq), eq.latex()
    assert re.search(r"N_sun_mesh_i \(r1_sun_mesh_i - (\w+_)?e_φ_sun_mesh_i\)", text)
    assert "ψ" in text
    groups = re.findall(r"\\begin\{align\}\n(.*?)\n\\end\{align\}", latex, re.DOTALL)
    rows = [row for group in groups for row in group.split(" \\\\\n")]
    assert max(row.count(r"\\*") for row in rows) <= 7
    single = r"&\\quad \w+_\{[^{}]*\{[^{}]*\}\\,i\}(\\,)? \\notag"  # a line with one symbol and no sign
    assert len(re.findall(single, latex)) <= 2


def test_a_mesh_with_one_angle_needs_no_phase():
    rig = gb.Drivetrain("pair")
    mesh = gb.GearMesh(
        teeth=(20, 30), external=True, r_base=(0.02, 0.03), c=10.0, k=1e8, stiffness_variation=gb.Fourier(cos=(0.1,))
    )
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("mesh", mesh), rig.add("b", gb.Inertia(J=1.0)))
    text = str(rig.equations())
    assert "k_mesh = k0_mesh (1 + a1_mesh cos(z1_mesh φ_a))" in text
    assert "ψ" not in text


p, q, z, a, N, psi, slope = sp.symbols("p q z a N psi slope", real=True)
e, k, rate = (sp.Symbol(x, real=True) for x in ("e", "k", "e'"))
PHASE = z * (p - q)


def _short(definitions, terms):
    return with_symbols(Part(definitions, terms), (p, q), lambda *_: psi, lambda _: slope)


def test_multiples_of_a_phase_are_those_of_its_symbol():
    part = _short({k: 1 + sp.cos(PHASE) + a * sp.sin(3 * PHASE), rate: z * sp.cos(PHASE)}, {})
    assert part.definitions == {psi: PHASE, k: 1 + sp.cos(psi) + a * sp.sin(3 * psi), rate: z * sp.cos(psi)}
    assert [*part.definitions] == [psi, k, rate]


def test_slopes_stand_in_the_balances_with_either_sign():
    drive = -N * (1 - a * z * sp.cos(PHASE))
    part = _short({e: a * sp.sin(PHASE)}, {0: drive, 1: -N * (a * z * sp.cos(PHASE) - 2)})
    assert part.definitions == {psi: PHASE, e: a * sp.sin(psi), slope: a * z * sp.cos(psi)}
    assert part.terms == {0: -N * (1 - slope), 1: -N * (slope - 2)}


def test_what_stands_once_or_has_a_name_gets_no_other():
    once = {k: 1 + sp.cos(PHASE)}
    assert _short(once, {}).definitions == once
    theta = sp.Symbol("theta", real=True)
    named = _short({theta: PHASE, k: sp.cos(theta), e: sp.sin(PHASE)}, {0: sp.cos(PHASE)})
    assert named == Part({theta: PHASE, k: sp.cos(theta), e: sp.sin(theta)}, {0: sp.cos(theta)})
    in_time = {k: sp.cos(3 * a * N) + sp.sin(3 * a * N)}
    assert _short(in_time, {}).definitions == in_time


def test_put_in_again_the_symbols_are_what_they_stand_for():
    before = Part(
        {e: a * sp.sin(2 * PHASE) - sp.cos(PHASE)}, {0: N * (3 - sp.diff(a * sp.sin(2 * PHASE) - sp.cos(PHASE), q))}
    )
    after = _short(*before)
    back = {x: y.xreplace({psi: PHASE}) for x, y in after.definitions.items()}
    assert sp.simplify(after.terms[0].xreplace(back).xreplace({psi: PHASE}) - before.terms[0]) == 0
    assert sp.simplify(back[e] - before.definitions[e]) == 0
    assert slope in after.terms[0].free_symbols


@pytest.mark.long
def test_displays_of_a_notebook_fit_pages():
    for rig in (planets("waves"), planets("tables", nested=True)):
        displays = re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", rig.equations()._repr_latex_(), re.DOTALL)
        assert len(displays) >= 4
        assert max(x.count(r"\\") + 1 for x in displays) <= 20
        assert not any("notag" in x or r"\\*" in x for x in displays)


@pytest.mark.long
def test_pages_end_between_the_equations_of_an_article_and_not_within_them():
    latex = planets("waves").equations().latex()
    assert latex.split("\n")[1] == r"\begingroup\allowdisplaybreaks\raggedright"
    assert latex.endswith(r"\endgroup")
    assert r"\notag \\*" in latex
    assert "\\notag \\\\\n" not in latex


@pytest.mark.parametrize(
    ("factor", "printed"),
    [
        (1 / (2 * gb.pi), "t/(2 π)"), (59 / (2 * gb.pi), "59 t/(2 π)"), (2 * gb.pi * 50, "100 π t"), (gb.pi / 180, "1/180 π t"),
        (-gb.pi / 3, "1/3 π t"), (0.12345, "0.12345 t"), (314.1593, "314.1593 t"), (3.0, "3 t"),
    ],
)  # fmt: skip
def test_factors_that_are_fractions_of_pi_are_printed_as_such(factor, printed):
    rig = gb.Drivetrain("waves")
    rig.chain(rig.add("drive", gb.Torque(tau=gb.cos(factor * gb.time))), rig.add("body", gb.Inertia(J=1.0)))
    assert f"cos({printed})" in str(rig.equations())
