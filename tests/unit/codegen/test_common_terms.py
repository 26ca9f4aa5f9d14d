"""What expressions of a generated function have in common is computed once, with the same bits."""

import math
import random

import pytest
import sympy as sp

from gearblocks.codegen.common_terms import CommonTerms
from gearblocks.codegen.function import Names
from gearblocks.codegen.operands import Role
from gearblocks.model.build import make_program
from models import gear_pair

NAMES = sp.symbols("a b c d", real=True)
C = {
    "gb_sin": math.sin, "gb_cos": math.cos, "gb_atan": math.atan, "exp": math.exp, "fabs": abs, "sqrt": math.sqrt,
    "pow": math.pow, "fmax": max, "fmin": min, "gb_unit_step": lambda x: float(x >= 0), "tanh": math.tanh,
}  # fmt: skip


def written(exprs, *, common):
    """The statements of expressions in C, and the texts of these."""
    names = Names(Role.STATES, {x: x.name for x in NAMES})
    terms = CommonTerms(exprs if common else ())
    statements, texts = [], []
    for expr in exprs:
        statements += [names.common(x) for x in terms.of(expr)]
        texts.append((len(statements), names.print(expr)))
    return statements, texts


def computed(exprs, values, *, common):
    """Values of the expressions, their C read as Python: the two agree on sums, products and calls."""
    statements, texts = written(exprs, common=common)
    known, found, done = {**C, **dict(zip("abcd", values, strict=True))}, [], 0
    for number, text in texts:
        for s in statements[done:number]:
            known[str(s.target)] = eval(s.rhs, {}, known)  # noqa: S307
        done = number
        found.append(eval(text, {}, known))  # noqa: S307
    return found


def grown(draw, depth):
    """A random expression that repeats parts of itself."""
    if depth == 0:
        return draw.choice([*NAMES, sp.Float(draw.uniform(0.1, 3.0)), sp.Rational(2, 3)])
    x, y = grown(draw, depth - 1), grown(draw, depth - 1)
    forms = [
        lambda: x * y + x, lambda: x - y * NAMES[0], lambda: sp.sin(x + y) * x, lambda: (x + y) ** 2 - x,
        lambda: -(x + NAMES[1] * y) * (x + NAMES[1] * y), lambda: x / (1 + sp.Abs(x + y) ** 3), lambda: sp.exp(-(x**2)) + y,
        lambda: (x + y) ** -2 + (x + y) ** 2, lambda: sp.sqrt(1 + x**2) * sp.cos(x),
        lambda: sp.Heaviside(x, 1) * sp.Max(x, y), lambda: (1 + x**2) ** sp.Rational(-3, 2) + x,
    ]  # fmt: skip
    return draw.choice(forms)()


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.few(1)
def test_bits_are_those_of_expressions_written_out(seed):
    draw = random.Random(seed)
    base = grown(draw, 3)
    exprs = [base, base.diff(NAMES[0]), base.diff(NAMES[1]), -base, base * NAMES[2]]
    exprs = [x for x in exprs if not x.has(sp.DiracDelta, sp.Derivative, sp.Subs, sp.sign)]
    assert written(exprs, common=True)[0]
    for _ in range(5):
        values = [draw.uniform(-2.0, 2.0) for _ in NAMES]
        one, other = (computed(exprs, values, common=common) for common in (True, False))
        assert [float(x).hex() for x in one] == [float(x).hex() for x in other]


def test_what_is_repeated_stands_once_before_its_first_use():
    a, b, c, d = NAMES
    part = a * b + c * sp.cos(d) + 1
    statements, texts = written([part**2, a + part * d, c / part], common=True)
    assert [s.rhs for s in statements] == ["a*b + c*gb_cos(d) + 1.0"]
    assert [text for _, text in texts] == ["(common_0*common_0)", "a + d*common_0", "c/common_0"]
    assert [number for number, _ in texts] == [1, 1, 1]


def test_inner_parts_come_first_and_every_name_is_read():
    a, b, c, d = NAMES
    inner = sp.sin(a * b + c)
    outer = (inner + d * inner**2 + a * b * c) * (1 + a)
    exprs = [outer, outer * b, 1 / outer, inner]
    statements, texts = written(exprs, common=True)
    rest = [s.rhs for s in statements] + [text for _, text in texts]
    assert len(statements) == 2
    assert sum(text.count("gb_sin(") for text in rest) == 1
    for i, s in enumerate(statements):
        assert not any(str(s.target) in text for text in rest[: i + 1])
        assert any(str(s.target) in text for text in rest[i + 1 :])


def test_small_sums_are_written_out():
    a, b, _, d = NAMES
    assert not written([a - b, d * (a - b)], common=True)[0]


def test_a_branch_keeps_to_itself_what_it_has():
    a, b, c, _ = NAMES
    root = sp.sin(sp.sqrt(a))
    branch = sp.Piecewise((root * (b + c * a + 1) + root, a > 0), (b, True))
    assert not written([branch], common=True)[0]
    statements, texts = written([branch * b, branch * c], common=True)
    assert len(statements) == 1
    assert all("common_0" in text and "?" not in text for _, text in texts)


@pytest.mark.long
def test_the_matrix_of_a_mesh_with_tooth_friction_says_nothing_twice():
    """Its 17,000 characters a derivative took most of the compiler's time."""
    source = make_program(gear_pair.build().train()).source
    body = source.partition("static inline void step_matrix_gearmesh")[2].partition("\n}\n")[0]
    assert body.count("gb_cos(") == body.count("gb_sin(") == 1
    assert max(map(len, source.splitlines())) < 3000
