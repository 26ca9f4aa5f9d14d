"""Equations as a reader of an article sees them, in a two-column article of LaTeX and in a browser."""

import re
import shutil
import subprocess

import pytest

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.equations.latex import STYLE, latex, prose, unit, word
from gearblocks.equations.line_breaking import lines
from gearblocks.equations.mathml import mathml
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Call, Cases, Fence, Fraction, Num, Op, Power, Row, Sym, Times, Words
from tests.random.description import build
from tests.random.families import FAMILIES

MODELS = [f"{name}:{maker.name}" for name in scripts.shipped() for maker in scripts.makers(scripts.locate(name)[0])]
HEAD = "\\documentclass[10pt,twocolumn]{article}\n\\usepackage{amsmath}\n\\begin{document}\n"


@pytest.mark.long
@pytest.mark.parametrize("name", [*MODELS, *FAMILIES])
def test_latex_fits_the_column_of_an_article(name, tmp_path):
    if shutil.which("pdflatex") is None:
        pytest.skip("texlive is not here")
    rig = build(FAMILIES[name](7), gb) if name in FAMILIES else scripts.make(name)
    (tmp_path / "it.tex").write_text(f"{HEAD}{rig.equations().latex()}\n\\end{{document}}\n")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "it.tex"]
    said = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    log = said.stdout.decode(errors="replace")
    assert said.returncode == 0, log[-2000:]
    wide = [float(x) for x in re.findall(r"Overfull \\hbox \(([\d.]+)pt", log)]
    assert max(wide, default=0.0) <= 5.0
    assert "Missing character" not in (tmp_path / "it.log").read_text(errors="replace")


def test_words_keep_their_signs():
    """As text | is a dash in TeX's own fonts, < and > are punctuation of Spanish, and ~ stands for a space."""
    assert prose("over |w_a| < 3 > 2") == r"over $|$w\_a$|$ $<$ 3 $>$ 2"
    assert (
        prose("T/w_i^2 ~ 5°, φ ≥ 1, x\\y, m²")
        == r"T/w\_i$^{2}$ $\sim$ 5$^\circ$, $\varphi$ $\ge$ 1, x$\backslash$y, m$^2$"
    )
    assert word("a_1 50%") == r"\mathrm{a\_1\,50\%}"


@pytest.mark.parametrize(
    ("plain", "shown"),
    [
        ("um", r"\mu m"),
        ("N m s2/rad2", r"N\,m\,s^{2}/rad^{2}"),
        ("1/s", "1/s"),
        ("%", r"\%"),
        ("uN um", r"\mu N\,\mu m"),
    ],
)
def test_units_are_those_of_print(plain, shown):
    assert unit(plain) == rf"$\mathrm{{{shown}}}$"


def test_values_stay_beside_their_units():
    rig = gb.Drivetrain("pair")
    shaft = rig.add("shaft", gb.Shaft(k=2e8))
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), shaft, rig.add("b", gb.Inertia(J=1.0)))
    assert r"$2 \times 10^{8}$~$\mathrm{N\,m/rad}$" in rig.equations().nomenclature().latex()


def test_a_line_that_goes_on_with_a_factor_begins_with_a_dot():
    long = Sym(Name("k", "0", "a longer name"))
    inner = Fence("(", ")", Row((Sym(Name("a", "", "gearbox")), Op("+"), Sym(Name("b", "", "gearbox")))))
    broken = lines([Times((long, inner))], STYLE, 20, 20)
    assert len(broken) == 2 and broken[1].startswith(r"\cdot (")
    assert r"\cdot" not in "".join(lines([Times((long, inner))], STYLE, 60, 60))


def _cases(words):
    value = Row((Sym(Name("x", "", words)), Op("-"), Sym(Name("b", "", words))))
    condition = Row((Sym(Name("x", "", words)), Op(">"), Sym(Name("b", "", words))))
    return latex(Cases(((value, condition), (Sym(Name("y")), None))))


def test_the_comma_of_a_case_stands_behind_its_last_line():
    assert r"b_{\mathrm{p}}, & x" in _cases("p")
    assert r"b_{\mathrm{a\,longer\,name}},\end{aligned} &" in _cases("a longer name")


def test_a_condition_has_the_room_that_short_values_leave():
    sides = [Sym(Name(letter, "", "a long foot")) for letter in "vww"]
    condition = Row((sides[0], Op(">"), sides[1], Op("+"), sides[2]))
    assert "aligned" not in latex(Cases(((Sym(Name("p")), condition), (Sym(Name("q")), None))))


def test_brackets_of_a_page_are_as_tall_as_what_stands_in_them():
    x, y = Sym(Name("φ", "", "pinion")), Sym(Name("y"))
    flat, tall = Call(Words("cos"), (x,)), Call(Words("cos"), (Fraction(x, y),))
    assert mathml(flat).count('stretchy="false"') == 2 and "stretchy" not in mathml(tall)
    assert mathml(Fence("(", ")", flat)).count('stretchy="false"') == 4 and "stretchy" not in mathml(
        Fence("(", ")", tall)
    )


def test_an_exponent_stands_above_the_foot():
    squared = mathml(Power(Sym(Name("r", "1", "mesh")), Sym(Name("n"))))
    assert squared == "<msubsup><mi>r</mi><mtext>1,mesh</mtext><mrow><mi>n</mi></mrow></msubsup>"
    assert mathml(Power(Sym(Name("r")), Sym(Name("n")))) == "<msup><mi>r</mi><mrow><mi>n</mi></mrow></msup>"
    assert mathml(Power(Sym(Name("Δω", "", "c")), Sym(Name("n")))).startswith("<msup><mrow><mrow>")


def test_the_drags_of_a_bearing_have_letters():
    rig = gb.Drivetrain("bearing")
    body = rig.add("disc", gb.Inertia(J=1.0, w0=1.0))
    drags = {"windage": gb.FluidDrag(c=0.03), "churning": gb.FluidDrag(c=0.003)}
    rig.connect(body.a, rig.add("bearing", gb.BearingFriction(viscous=0.1, **drags)).a)
    shown = [row[0] for row in rig.equations().nomenclature()]
    assert {"c_bearing", "cw_bearing", "co_bearing"} <= {x.replace("_w_", "w_").replace("_o_", "o_") for x in shown}, (
        shown
    )


def test_no_line_ends_with_a_short_number_before_a_factor():
    angle = Fraction(Sym(Name("x", "", "a longer name")), Sym(Name("y")))
    broken = lines(
        [Sym(Name("z", "", "gear")), Op("+"), Times((Num("2"), Call(Words("arctan"), (angle,))))], STYLE, 12, 12
    )
    assert len(broken) == 2 and broken[1].startswith(" + 2")
    assert r"\left(" in broken[1]  # what has no place to break stands as if it were short


def test_the_numbers_of_a_square_wave_have_letters():
    rig = gb.Drivetrain("square")
    wave = gb.Square(ripple=0.2, contact_ratio=1.3, driven_by="500 rad/s")
    shaft = gb.GearMesh(
        teeth=(20, 30), external=True, module=0.002, pressure_angle="20 deg", k=1e8, stiffness_variation=wave
    )
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("mesh", shaft), rig.add("b", gb.Inertia(J=1.0)))
    assert {"δ_mesh", "ε_mesh"} <= {row[0] for row in rig.equations().nomenclature()}
