"""What several expressions of a function share is enclosed once: the same bits as alone, and all that they take lies inside."""

import ctypes
import functools
import random
import re

import numpy as np
import pytest
import sympy as sp

from gearblocks.laws.enclosure_printer import enclosure_text, enclosure_texts
from gearblocks.laws.printer import c_text
from tests.unit.laws.enclosing_library import EXPORT, Box, library_of

X, Y, P = sp.symbols("x y p", real=True)
NAMES, MOVING = {P: "p"}, {X: "x", Y: ("y", "2.0")}
P_VALUE = 0.7


def laws(seed):
    """Three laws of a mesh: a stiffness over an angle, times a deflection, and its energy's part by that angle."""
    draw = random.Random(seed)
    number = lambda: sp.Float(round(draw.uniform(-2, 2), 3))  # noqa: E731
    phase = number() * X + number() * Y + draw.choice([P, sp.Integer(0)])
    deflection = number() * X + number() * P
    force = (1 + number() * sp.cos(phase) + number() * sp.sin(2 * phase)) * deflection + number() * Y
    energy = sp.sin(phase) * deflection**2
    return [number() * force + energy, number() * force, P * energy - number() * force, sp.cos(phase) - number()]


NUMBER, COUNT = 12, 4
"""How many sets of laws there are, and how many laws are in each."""


def statements(exprs):
    shared, texts = enclosure_texts(exprs, MOVING, NAMES)
    lines = [f"const {x.kind} {x.name} = {x.text};" for x in shared]
    return " ".join([*lines, *(f"out[{k}] = {text};" for k, text in enumerate(texts))])


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """library(i): the laws of seed i, sharing what they have in common, each alone, and at a point."""

    @functools.cache
    def made(i):
        exprs, at = laws(i), {**NAMES, X: "x", Y: "(2.0 * y)"}
        alone = " ".join(f"out[{k}] = {enclosure_text(x, MOVING, NAMES)};" for k, x in enumerate(exprs))
        points = " ".join(f"out[{k}] = {c_text(x, at)};" for k, x in enumerate(exprs))
        text = f"""#include "gb_enclosure.h"
{EXPORT} void together(gb_enclosure x, gb_enclosure y, double p, gb_enclosure *out) {{ {statements(exprs)} }}
{EXPORT} void alone(gb_enclosure x, gb_enclosure y, double p, gb_enclosure *out) {{ {alone} }}
{EXPORT} void point(double x, double y, double p, double *out) {{ {points} }}
"""
        found = library_of(text, tmp_path_factory.mktemp("shared"))
        for name in ("together", "alone"):
            getattr(found, name).argtypes = [Box, Box, ctypes.c_double, ctypes.POINTER(Box)]
        found.point.argtypes = [*[ctypes.c_double] * 3, ctypes.POINTER(ctypes.c_double)]
        return found

    return made


def boxes(seed):
    """Lines x = a + c s, y = b + d s with s in [0, width], from narrow ones to several periods."""
    rng = np.random.default_rng(seed)
    for _ in range(200):
        (a, b), (c, d) = rng.uniform(-6, 6, 2), rng.uniform(-2, 2, 2)
        width = 10 ** rng.uniform(-7, 0.8)
        x, y = (Box(min(q, q + r * width), max(q, q + r * width), r, r) for q, r in ((a, c), (b, d)))
        yield x, y, (a, c, b, d), width


@pytest.mark.parametrize("i", range(NUMBER))
@pytest.mark.few(1)
def test_what_is_shared_has_the_bits_of_what_is_enclosed_alone(library, i):
    one, other = (Box * COUNT)(), (Box * COUNT)()
    for x, y, _, _ in boxes(i):
        library(i).together(x, y, P_VALUE, one)
        library(i).alone(x, y, P_VALUE, other)
        assert bytes(one) == bytes(other)


@pytest.mark.parametrize("i", range(NUMBER))
@pytest.mark.few(1)
def test_dense_samples_of_random_laws_lie_in_what_is_shared(library, i):
    found, at = (Box * COUNT)(), (ctypes.c_double * COUNT)()
    for x, y, (a, c, b, d), width in boxes(100 + i):
        library(i).together(x, y, P_VALUE, found)
        s = np.linspace(0.0, width, 101)
        values = np.empty((len(s), COUNT))
        for row, q in zip(values, s, strict=True):
            library(i).point(a + c * q, b + d * q, P_VALUE, at)
            row[:] = at
        room = 1e-13 * (1 + np.abs(values).max())
        rates = np.diff(values, axis=0) / np.diff(s)[:, None]
        blur = 1e-12 * (1 + np.abs(values).max()) / s[1]
        for k, box in enumerate(found):
            assert box.lo - room <= values[:, k].min() <= values[:, k].max() <= box.hi + room
            assert box.down - blur <= rates[:, k].min() <= rates[:, k].max() <= box.up + blur


def test_a_phase_is_enclosed_once_and_each_part_before_it_is_read():
    shared, texts = enclosure_texts(laws(0), MOVING, NAMES)
    everything = " ".join([*(x.text for x in shared), *texts])
    waves = re.findall(r"gb_enclosed_waves\(", everything)
    assert len(waves) == 2, "of the phase and of twice the phase"
    known = set()
    for x in shared:
        assert set(re.findall(r"\b(?:part|waves)\d+", x.text)) <= known
        known.add(x.name)
        assert len(re.findall(rf"\b{x.name}\b", everything)) >= 2, "what stands in one place is no local"
