"""Enclosures in C: what a function takes over a box, and its rate, lie inside; and not far inside."""

import ctypes

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.laws.enclosure_printer import EnclosureError, enclosure_text
from gearblocks.laws.functions import EllipseLead, InverseInvolute, Table2At, TableAt
from gearblocks.laws.printer import c_text
from tests.unit.laws.enclosing_library import EXPORT, Box, library_of

X, Y, P = sp.symbols("x y p", real=True)
LINE, CURVE, STEPS, ENDS, MAP = sp.symbols("line curve steps ends map", real=True)

TABLES = """
static const double xs[] = {0.0, 0.5, 1.2, 2.0}, ys[] = {1.0, -0.4, 0.7, 1.0}, none[4];
static const double bend[] = {%s};
static const gb_table line = {GB_TABLE_LINEAR, 4, 1, xs, ys, none};
static const gb_table curve = {GB_TABLE_CUBIC, 4, 1, xs, ys, bend};
static const gb_table steps = {GB_TABLE_STEP, 4, 1, xs, ys, none};
static const gb_table ends = {GB_TABLE_LINEAR, 4, 0, xs, ys, none};
static const double z[] = {1.0, 2.0, -1.0, 0.5, 0.0, 1.5, -2.0, 1.0, 0.3, 0.2, 0.9, -1.0, 2.0, 0.1, 0.4, 0.6};
static const double bend_z[] = {0.5, -1.0, 2.0, 0.3, 1.0, 0.2, 0.0, -0.7, 0.4, 0.1, 3.0, -2.0, 0.6, 0.2, 0.8, 1.0};
static const gb_table2 map = {&ends, &ends, z, bend_z, bend_z, z};
"""
EXPRESSIONS = [
    X + 2 * Y - P, X * Y, X * X, X**3 - Y**2, X**-1, Y**-2, X**-3, -X, 3 * X * Y * P + 1,
    sp.sin(X), sp.cos(X), sp.sin(40 * X + Y), sp.cos(X - 3 * Y) * sp.sin(X), sp.tan(X), sp.sin(X) / (1.5 + sp.cos(Y)),
    sp.asin(X / 30), sp.acos(X / 30), sp.atan(X * Y), sp.atan2(Y, X), sp.exp(X / 5), sp.log(sp.exp(Y) + 1), sp.sinh(X / 9),
    sp.cosh(Y / 9), sp.tanh(X), sp.sqrt(X**2 + 1), sp.sqrt(sp.exp(Y)), sp.exp(X / 9) ** P, sp.exp(X / 9) ** (Y / 9),
    (X**2 + 1) ** sp.Rational(-3, 2), EllipseLead(X, sp.Float(0.3)), sp.Heaviside(X - Y, 1) * (X - Y), sp.frac(X),
    sp.floor(Y) + X, TableAt(LINE, X, sp.Integer(0)), TableAt(CURVE, Y, sp.Integer(0)), TableAt(STEPS, X, sp.Integer(0)),
    TableAt(CURVE, X, sp.Integer(1)), TableAt(ENDS, Y, sp.Integer(0)), TableAt(CURVE, sp.sin(X), sp.Integer(0), sp.Integer(1)),
    TableAt(LINE, X, sp.Integer(0), P), Table2At(MAP, X, Y, sp.Integer(0), sp.Integer(0), sp.Integer(1), sp.Integer(2)),
    Table2At(MAP, X, sp.sin(Y), sp.Integer(1), sp.Integer(0), sp.Integer(1), sp.Integer(0)),
]  # fmt: skip
P_VALUE = 2.0


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """All expressions, enclosed and at a point, and their rates at a point by a central difference."""
    folder = tmp_path_factory.mktemp("enclosures")
    names = {LINE: "line", CURVE: "curve", STEPS: "steps", ENDS: "ends", MAP: "map", P: "p"}
    boxes = "".join(
        f"    case {i}: *out = {enclosure_text(e, {X: 'x', Y: 'y'}, names)}; break;\n"
        for i, e in enumerate(EXPRESSIONS)
    )
    points = "".join(
        f"    case {i}: return {c_text(e.replace(sp.floor, lambda a: a - sp.frac(a)), {**names, X: 'x', Y: 'y'})};\n"
        for i, e in enumerate(EXPRESSIONS)
    )
    spline = gb.Table([0.0, 0.5, 1.2, 2.0], [1.0, -0.4, 0.7, 1.0], "cubic", periodic=True).second
    tables = TABLES % ", ".join(map(repr, np.asarray(spline).tolist()))
    text = f"""#include "gb_enclosed_table.h"
{tables}
void box(int i, gb_enclosure x, gb_enclosure y, double p, gb_enclosure *out);
double point(int i, double x, double y, double p);
{EXPORT} void box(int i, gb_enclosure x, gb_enclosure y, double p, gb_enclosure *out) {{
    switch (i) {{
{boxes}    }}
}}
{EXPORT} double point(int i, double x, double y, double p) {{
    switch (i) {{
{points}    }}
    return 0.0;
}}
"""
    found = library_of(text, folder)
    found.point.restype, found.point.argtypes = ctypes.c_double, [ctypes.c_int] + [ctypes.c_double] * 3
    found.box.restype = None
    found.box.argtypes = [ctypes.c_int, Box, Box, ctypes.c_double, ctypes.POINTER(Box)]
    return found


def _enclosed(library, i, x, y):
    out = Box()
    library.box(i, Box(*x), Box(*y), P_VALUE, ctypes.byref(out))
    return out


@pytest.mark.parametrize("i", range(len(EXPRESSIONS)), ids=lambda i: str(EXPRESSIONS[i])[:40])
@pytest.mark.few(2)
def test_values_and_rates_over_a_box_lie_in_its_enclosure(library, i):
    rng = np.random.default_rng(i)
    for _ in range(300):
        a, b = rng.uniform(-6, 6, 2)
        width = 10 ** rng.uniform(-4, 0.7)
        pace = rng.uniform(-2, 2, 2)
        # along a line x = a + c s, y = b + d s: rates c and d, s in [0, width]
        x = (min(a, a + pace[0] * width), max(a, a + pace[0] * width), pace[0], pace[0])
        y = (min(b, b + pace[1] * width), max(b, b + pace[1] * width), pace[1], pace[1])
        box = _enclosed(library, i, x, y)
        s = np.linspace(0.0, width, 41)
        values = np.array([library.point(i, a + pace[0] * q, b + pace[1] * q, P_VALUE) for q in s])
        values = values[np.isfinite(values)]
        room = 1e-14 * (1 + np.abs(values))
        assert (values >= box.lo - room).all() and (values <= box.hi + room).all()
        if len(values) == len(s):
            rates = np.diff(values) / np.diff(s)
            room = 1e-12 * (1 + np.abs(values).max()) / (s[1] - s[0])
            assert (rates >= box.down - room).all() and (rates <= box.up + room).all()


@pytest.mark.parametrize("i", range(len(EXPRESSIONS)), ids=lambda i: str(EXPRESSIONS[i])[:40])
def test_a_small_box_has_a_narrow_enclosure(library, i):
    rng = np.random.default_rng(i)
    narrow = 0
    for _ in range(100):
        a, b = rng.uniform(0.1, 1.9, 2)
        box = _enclosed(library, i, (a, a + 1e-5, 1.0, 1.0), (b, b + 1e-5, 1.0, 1.0))
        values = [library.point(i, a + q, b + q, P_VALUE) for q in np.linspace(0, 1e-5, 11)]
        size = max(abs(box.down), abs(box.up), 1.0)
        narrow += box.hi - box.lo < max(values) - min(values) + 2e-4 * size and box.up - box.down < 0.02 * size
    assert narrow >= 95  # a few of them hold a jump or a pole


def test_what_does_not_move_is_a_number():
    assert enclosure_text(P + 1, {X: "x"}, {P: "p"}) == "gb_enclosed_number(p + 1.0)"
    assert enclosure_text(P * X, {X: "x"}, {P: "p"}) == "gb_enclosed_scale(x, p)"
    assert enclosure_text(X - P, {X: "x"}, {P: "p"}) == "gb_enclosed_shift(x, -p)"


def test_a_function_without_enclosure_is_named():
    with pytest.raises(EnclosureError, match="InverseInvolute"):
        enclosure_text(1 + InverseInvolute(X), {X: "x"}, {})
    with pytest.raises(EnclosureError, match="cells"):
        enclosure_text(Table2At(MAP, X, Y, sp.Integer(0), sp.Integer(0)), {X: "x", Y: "y"}, {MAP: "map"})
