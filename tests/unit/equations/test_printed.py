"""Printed equations: what stands on paper computes what the sympy objects do, and fits on the paper."""

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.cli import scripts
from gearblocks.equations import sections
from gearblocks.equations.latex import aligned, name_latex
from gearblocks.equations.latex import value as latex_value
from gearblocks.equations.mathml import name_mathml
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Call, Cases, Fence, Fraction, Num, Op, Power, Root, Row, Sym, Times, Words
from gearblocks.equations.notation import Reader
from gearblocks.equations.text import equation_lines, name_text, text
from gearblocks.laws.functions import ContactSide, DeadZone, EllipseLead, Table2At, TableAt
from gearblocks.laws.symbols import time_symbol

sys.path.insert(0, str(Path(__file__).parents[3] / "models"))

MODELS = [f"{name}:{maker.name}" for name in scripts.shipped() for maker in scripts.makers(scripts.locate(name)[0])]


def _spur_pair():
    """The train of the README."""
    code = re.search(r"```python\n(import gearblocks.*?)\neq = rig", (Path(__file__).parents[3] / "README.md")
                     .read_text(encoding="utf-8"), re.DOTALL)  # fmt: skip
    found = {}
    exec(code[1], found)  # noqa: S102 - the README's own lines
    return found["rig"]


# -- a reader of notation ---------------------------------------------------------------------------------------------

SIGNS = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "=": lambda a, b: a == b, "<": lambda a, b: a < b,
    ">": lambda a, b: a > b, "<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "≠": lambda a, b: a != b,
    "and": lambda a, b: a and b, "or": lambda a, b: a or b,
}  # fmt: skip
RANKS = [("or",), ("and",), ("=", "<", ">", "<=", ">=", "≠"), ("+", "-")]
FUNCTIONS = {
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "arctan": math.atan, "exp": math.exp, "max": max, "min": min,
    "sgn": lambda x: float(np.sign(x)), "H": lambda x: float(x >= 0), "frac": lambda x: x - math.floor(x),
}  # fmt: skip


def _computed(node, values, tables):
    """What a reader computes from what is printed."""

    def of(inner):
        return _computed(inner, values, tables)

    if isinstance(node, Sym):
        return math.pi if node.name == Name("π") else values[node.name]
    if isinstance(node, Num):
        return float(node.digits)
    if isinstance(node, Row):
        return _row(list(node.items), of)
    if isinstance(node, Times):
        return math.prod(of(f) for f in node.factors if f != Op("×"))
    if isinstance(node, Fraction):
        return of(node.top) / of(node.bottom)
    if isinstance(node, Power):
        return of(node.base) ** of(node.exponent)
    if isinstance(node, Root):
        return math.sqrt(of(node.inner))
    if isinstance(node, Fence):
        return {"(": lambda x: x, "|": abs, "⌊": math.floor}[node.left](of(node.inner))
    if isinstance(node, Cases):
        return next(of(value) for value, condition in node.rows if condition is None or of(condition))
    assert isinstance(node, Call), node
    arguments = [of(x) for x in node.arguments]
    if isinstance(node.function, Words):
        return FUNCTIONS[node.function.text](*arguments)
    return tables(node.function.name, node.primes, arguments)


def _row(items, of):
    """Terms and signs, the weakest sign last."""
    for rank in RANKS:
        places = [i for i, x in enumerate(items) if isinstance(x, Op) and x.sign in rank and i]
        if places:
            at = places[-1]
            return SIGNS[items[at].sign](_row(items[:at], of), _row(items[at + 1 :], of))
    if items[0] == Op("neg"):
        return -_row(items[1:], of)
    assert len(items) == 1, items
    return of(items[0])


def _waves(name, primes, arguments):
    """Any smooth function will do for a table."""
    return math.sin(
        sum(map(ord, f"{name.letter}{name.owner}")) + primes + sum(k * x for k, x in enumerate(arguments, 2))
    )


def _number(expr, known, reader):
    """sympy's value of an expression, tables by the same waves."""
    expr = sp.sympify(expr).xreplace(known)
    expr = expr.replace(lambda e: isinstance(e, DeadZone), lambda e: e.spelled_out())
    expr = expr.replace(lambda e: isinstance(e, EllipseLead), lambda e: e.written_out())
    expr = expr.replace(
        lambda e: isinstance(e, ContactSide),
        lambda e: sp.Piecewise((1, e.args[0] > e.args[1]), (-1, e.args[0] < -e.args[1]), (0, True)),
    )
    while found := [e for e in expr.atoms(TableAt, Table2At) if not e.args[1].has(TableAt, Table2At)]:
        new = {}
        for e in found:
            n = 2 if isinstance(e, TableAt) else 3
            arguments = [_number(x, known, reader) for x in e.args[1:n]]
            primes = int(e.args[2]) if n == 2 else 0
            new[e] = sp.Float(_waves(reader.name(e.args[0]), primes, arguments), 17)
        expr = expr.xreplace(new)
    return float(sp.N(expr.replace(sp.Heaviside, lambda x, *_: sp.Integer(1 if x >= 0 else 0)), 17))


def _check(eq, seed):
    """Each printed equation holds at a random point, where left sides are what the sympy objects say."""
    reader, random = sections.reader(eq), np.random.default_rng(seed)
    tables = {x for x, entry in eq.entries.items() if entry.table is not None}
    free = [x for x in {*eq.used(), *eq.q, *eq.v, time_symbol()} - tables if x not in eq.definitions]
    known = {
        x: sp.Float(random.uniform(0.3, 1.7), 17) for x in sorted(free, key=str) if x in eq.names or x == time_symbol()
    }
    while rest := [s for s in eq.definitions if s not in known]:
        ready = [s for s in rest if not eq.definitions[s].free_symbols & set(rest)]
        known |= {s: sp.Float(_number(eq.definitions[s], known, reader), 17) for s in ready}
    values = {reader.name(x): float(y) for x, y in known.items()} | {Name("t"): float(known[time_symbol()])}
    mass = eq.mass_matrix.applyfunc(lambda e: _number(e, known, reader))
    force = sp.Matrix([_number(e, known, reader) for e in eq.forcing])
    moving = [i for i in range(len(eq.v)) if mass[i, i] != 0]
    alpha = mass.extract(moving, moving).LUsolve(sp.Matrix([force[i] for i in moving]))
    values |= {eq.names[eq.v[i]].rate(): float(a) for i, a in zip(moving, alpha, strict=True)}
    values |= {eq.names[s].rate(): _number(e, known, reader) for s, e in eq.states.items()}
    found = 0
    shown = [sections.balances(eq), *sections.parts(eq).values()]
    lines = [line for section in shown for line in section.lines if line.left is not None]
    for line in lines:  # slips, and cases that were lifted out of what they stand in
        if isinstance(line.left, Sym) and re.match(r"[pf]\d+_|Δ", text(line.left)) and line.left.name not in values:
            values[line.left.name] = _computed(line.right, values, _waves)
    for section in [sections.balances(eq), *sections.parts(eq).values()]:
        for line in (x for x in section.lines if x.left is not None):
            left, right = (_computed(x, values, _waves) for x in (line.left, line.right))
            if len(moving) == len(eq.v) or isinstance(line.left, Sym):
                assert left == pytest.approx(right, rel=1e-9, abs=1e-9 * (1 + abs(left))), text(line.left)
                found += 1
    return found


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[] if name in ("spline_coupling:build", "dual_clutch:build") else pytest.mark.long)
     for name in MODELS if not name.startswith("stiff_chain")],
)  # fmt: skip
def test_what_is_printed_computes_what_the_objects_do(name):
    eq = scripts.make(name).equations()
    assert sum(_check(eq, seed) for seed in range(3)) >= 3 * len(eq.q)


def test_what_is_printed_of_the_readme_s_pair_computes_what_the_objects_do():
    assert _check(_spur_pair().equations(), 5) == 15


# -- how it looks -----------------------------------------------------------------------------------------------------


def test_the_mesh_force_of_the_readme_s_pair_fits_on_a_page():
    eq = _spur_pair().equations()
    shown = str(eq).splitlines()
    assert max(map(len, shown)) <= 110
    assert "    N_mesh = k_mesh g_mesh + d_mesh" in [line[:35] for line in shown]
    gap = next(i for i, line in enumerate(shown) if "g_mesh = ⎨" in line)
    assert [line.split("(")[0].split() for line in shown[gap - 1 : gap + 2]] == [
        ["⎧", "x_mesh", "-", "b_mesh,", "x_mesh", ">", "b_mesh"],
        ["g_mesh", "=", "⎨", "x_mesh", "+", "b_mesh,", "x_mesh", "<", "-b_mesh"],
        ["⎩", "0,", "otherwise"],
    ]
    numbers = [int(m[1]) for line in shown if (m := re.search(r"\((\d+)\)$", line))]
    assert numbers == list(range(1, len(numbers) + 1))
    assert "J_pinion φ_pinion'' = -T_shaft - r1_mesh N_mesh - 1/2 g_mesh² κ_mesh" in str(eq)


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long) if "chain" in n else n for n in MODELS])
@pytest.mark.few(1)
def test_all_models_are_shown_in_all_forms_with_distinct_names(name):
    eq = scripts.make(name).equations()
    document = eq.document()
    assert max(map(len, str(document).splitlines())) <= 125
    latex, html = eq.latex(), eq.html()
    assert latex.count("{") - latex.count(r"\{") == latex.count("}") - latex.count(r"\}")
    assert html.count("<math") == html.count("</math>") > 5
    shown = [name_text(n) for n, _ in document.nomenclature.entries]
    assert len(shown) == len(set(shown))
    used = {x for x in eq.used() if x in eq.parameters}
    assert used <= set(eq.entries)


@pytest.mark.long
def test_two_tables_two_gaps_and_two_errors_have_two_names():
    rig = gb.Drivetrain("two")
    mesh = {
        "teeth": (20, 30), "r_base": (0.02, 0.03), "external": True, "c": 10.0, "k": 1e8,
        "backlash": gb.Backlash(half_gap=1e-5), "transmission_error": gb.Harmonic(cos=(1e-6,)),
        "stiffness_variation": gb.Fourier(cos=(0.1,), sin=(0.2,)),
    }  # fmt: skip
    one, two = gb.GearMesh(**mesh), gb.GearMesh(**mesh)
    table = gb.Table([0.0, 1.0], [0.0, 5.0])
    rig.chain(
        rig.add("drive", gb.Torque(tau=table)), rig.add("a", gb.Inertia(J=1.0)), rig.add("one", one),
        rig.add("b", gb.Inertia(J=1.0)), rig.add("two", two), rig.add("c", gb.Inertia(J=1.0)),
        rig.add("load", gb.Torque(tau=table)),
    )  # fmt: skip
    eq = rig.equations()
    shown = [row[0] for row in eq.nomenclature()]
    assert len(shown) == len(set(shown))
    assert {"b_one", "b_two", "g_one", "g_two", "e_one", "e_two", "τ_drive", "τ_load"} <= set(shown)
    assert {"a1_one", "a_s1_one", "a_e1_one", "a1_two"} <= set(shown)


def _cycle(a):
    return gb.Table([0.0, 0.25, 0.5, 1.0], [a, -a, a / 2, a], "cubic", periodic=True)


class _Worn(gb.Effect):
    table: gb.Table = gb.option("depth over the angle")


class _Track(gb.Block):
    a = gb.Flange("")
    table: gb.Table = gb.option("height over the angle")
    law: gb.Table = gb.option("push over the angle")
    left: _Worn = gb.effect("wear on the left", default=None)
    right: _Worn = gb.effect("wear on the right", default=None)

    def physics(self, s):
        depths = s.left.local("table", x=s.a.phi) - s.right.local("table", x=s.a.phi)
        yield gb.Acts(s.a, s.local("table", x=s.a.phi) * s.local("law", x=s.a.phi) + depths)


def _meshed(*meshes):
    rig = gb.Drivetrain("measured")
    mesh = {"teeth": (23, 41), "module": "3 mm", "pressure_angle": "20 deg", "external": True, "k": 2e8, "c": 1e3}
    whole = [rig.add("b0", gb.Inertia(J=1.0))]
    for i, fields in enumerate(meshes, 1):
        whole += [rig.add(f"m{i}", gb.GearMesh(**mesh, **fields)), rig.add(f"b{i}", gb.Inertia(J=1.0))]
    rig.chain(*whole)
    return rig


def _of_tables(kind):
    """A train and its tables by the symbol that each has."""
    profile = [gb.Profile(table=_cycle(x)) for x in (0.1, 0.2, 0.3)]
    if kind == "stiffness and error":
        return _meshed({"stiffness_variation": profile[0], "transmission_error": profile[1]}), {"K_m1", "E_m1"}
    if kind == "errors that add up":
        return _meshed({"transmission_error": tuple(profile)}), {"E_a_m1", "E_ba_m1", "E_bb_m1"}
    if kind == "frequencies":
        ramps = (gb.Table([0.0, 1.0], [3.0, x]) for x in (4.0, 5.0))
        one, two = (gb.Profile(table=_cycle(0.1), driven_by=ramp) for ramp in ramps)
        fields = {"stiffness_variation": one, "transmission_error": two}
        return _meshed(fields), {"K_m1", "Ω_m1", "Ω_e_m1"}  # one table in both profiles is one function
    if kind == "meshes":
        return _meshed({"stiffness_variation": profile[0]}, {"stiffness_variation": profile[0]}), {"K_m1", "K_m2"}
    rig = gb.Drivetrain("user")
    track = _Track(table=_cycle(1.0), law=_cycle(2.0), left=_Worn(table=_cycle(3.0)), right=_Worn(table=_cycle(4.0)))
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("track", track))
    return rig, {"table_track", "F_track", "left_track", "right_track"}


@pytest.mark.parametrize("kind", ["stiffness and error", "errors that add up", "frequencies", "meshes", "user's block"])
def test_each_table_has_a_symbol_of_its_own_named_by_its_part_and_field(kind):
    rig, wanted = _of_tables(kind)
    eq = rig.equations()
    listed = [(name, entry) for name, entry in eq.document().nomenclature.entries if entry.table is not None]
    assert sorted(name_text(name) for name, _ in listed) == sorted(wanted)
    assert len({entry.path for _, entry in listed}) == len(wanted)
    shown, latex, web, symbols = str(eq), eq.latex(), eq.mathml(), eq.nomenclature().latex()
    for name, _ in listed:
        assert re.search(rf"(?<!\w){name_text(name)}'?\(", shown)
        assert re.search(re.escape(name_latex(name)) + r"\}?'*(\\left)?\(", latex)
        assert name_mathml(name) in web
        assert symbols.count(rf"\item[${name_latex(name)}$]") == 1


@pytest.mark.long
def test_parts_forms_and_symbols_can_be_asked_for():
    eq = _spur_pair().equations()
    mesh = eq.element("mesh")
    assert "g_mesh" in str(mesh)
    assert "T_shaft" not in str(mesh)
    assert "φ_motor''" in str(eq.form("angle"))
    rows = {row[0]: row[1:] for row in eq.nomenclature()}
    assert rows["b_mesh"] == ("half of the backlash", "30", "um", "mesh.backlash.half_gap")
    assert rows["τ"][1:] == ("20", "N m", "tau")
    assert [latex_value(x) for x in ("2.45e+08", "1e-05", "3.5", "a_b")] == [
        r"$2.45 \times 10^{8}$", "$10^{-5}$", "3.5", r"a\_b"
    ]  # fmt: skip
    assert r"\item[$b_{\mathrm{mesh}}$] half of the backlash, 30" in eq.nomenclature().latex()
    with pytest.raises(gb.ParameterError, match=r"'mehs' is no part .* did you mean 'mesh'\?"):
        eq.element("mehs")
    with pytest.raises(gb.ParameterError, match="must be 'angle' or 'relative'"):
        eq.form("polar")
    with pytest.raises(gb.ParameterError, match="has no relative form"):
        eq.form("relative")


def test_numbers_and_signs_are_set_as_on_paper():
    x, y, k = sp.symbols("x y k", real=True)
    reader = Reader({x: Name("x"), y: Name("y"), k: Name("k")}, {x: 0, y: 1})
    for expr, shown in (
        (y - x, "y - x"), (x / 2, "x/2"), (-k * x * y / 3, "-1/3 k x y"), (x / (2 * k), "x/(2 k)"), (k * (x - y), "k (x - y)"),
        (sp.Rational(1, 2) * k * x**2, "1/2 k x²"), (sp.sqrt(x + k), "√(x + k)"), (sp.Float(1e-12) + x, "10^-12 + x"),
        (sp.Abs(x) * sp.sign(y), "|x| sgn(y)"), (sp.Max(x, -k), "max(x, -k)"), (-x > k, "x < -k"), (k < x, "x > k"),
        (1 / (1 / x + 1 / y), "1/(1/x + 1/y)"), (sp.Rational(5, 68) * x, "5/68 x"),
        (sp.Piecewise((x, x >= 0), (-x, True)), "|x|"), (x - (y - k), "x - y + k"), (-(x + y) * k, "-k (x + y)"),
        (sp.Float(1.0) * x, "x"), (sp.Float(-1.0) * k * sp.Heaviside(x), "-k H(x)"),
    ):  # fmt: skip
        assert text(reader.read(expr)) == shown


def test_functions_keep_their_name_and_primes_where_they_are_broken():
    terms = Row(tuple(x for i in range(8) for x in (Sym(Name("x", str(i), "gearbox")), Op("+")))[:-1])
    left = Sym(Name("y"))
    assert aligned(left, Call(Sym(Name("f")), (terms,), 2)).startswith("y &= {f}''(x_")
    assert aligned(left, Call(Words("sin"), (terms,))).startswith(r"y &= \sin(x_")
    assert equation_lines(left, Call(Sym(Name("f")), (terms,), 1), 40)[0].startswith("y = f'(x0_gearbox")


def test_rounding_is_no_digit_and_numbers_of_a_lead_are_taken_together():
    x = sp.Symbol("x", real=True)
    reader = Reader({x: Name("x")}, {x: 0})
    assert text(reader.read((sp.Float(0.1) + sp.Float(0.2)) * x)) == "0.3 x"
    assert text(reader.read(sp.Float(0.1234567890123456) * x)) == "0.1234567890123456 x"
    assert text(reader.read(EllipseLead(x, 0.25) / 2)).startswith("arctan(")
    assert text(reader.read((1 + x) ** sp.Float(0.5))) == "√(1 + x)"


def test_the_inertia_of_several_bodies_stands_before_its_acceleration():
    rig = gb.Drivetrain("stage")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    rig.chain(rig.add("drive", gb.Torque(tau=3.0)), one, two)
    assert "(J_one + J_two) φ_one'' = τ_drive" in str(rig.equations())


def test_the_words_and_units_of_a_contact_are_those_of_a_shaft_or_of_a_slider():
    rows = {}
    for body in (gb.Inertia(J=1.0), gb.Mass(m=1.0)):
        rig = gb.Drivetrain("pair")
        lash = gb.Lash(k=1e3, half_gap=1e-3, contact_damping=gb.HuntCrossley(restitution=0.5))
        rig.chain(rig.add("a", body), rig.add("lash", lash), rig.add("b", body))
        eq = rig.equations()
        rows[type(body)] = {row[0]: (row[1], row[3]) for row in eq.nomenclature()}
        assert "taken as it begins, and held: γ_lash = 1/(" in str(eq)
        assert "γ_lash'" not in str(eq)  # it stays as it is
    assert rows[gb.Inertia]["γ_lash"] == ("1/v0 of the present contact", "s/rad")
    assert rows[gb.Inertia]["T_lash"] == ("torque of the contact", "N m")
    assert rows[gb.Inertia]["χ_lash"][1] == "s/rad"
    assert rows[gb.Mass]["γ_lash"][1] == rows[gb.Mass]["χ_lash"][1] == "s/m"
    assert rows[gb.Mass]["F_lash"] == ("force of the contact", "N")
    assert rows[gb.Mass]["k_lash"] == ("stiffness in contact", "N/m")


def test_one_part_has_the_symbols_that_it_prints_and_no_others():
    shown = [row[0] for row in _spur_pair().equations().element("shaft").nomenclature]
    assert shown == ["φ_motor", "φ_pinion", "θ_shaft", "T_shaft", "k_shaft", "c_shaft"]
