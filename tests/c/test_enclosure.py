"""Enclosures of the core: values and rates of every function lie within them, wherever the piece lies."""

from __future__ import annotations

import ctypes
import math
import subprocess
from collections.abc import Callable

import numpy as np
import pytest

from tests.c.test_core import CORE, FLAGS, _compiler

FUNCTIONS: dict[str, tuple[str, Callable[[float], float], float, float]] = {
    "sine": ("gb_enclosed_sin(x, gb_enclosed_waves(x))", math.sin, -20.0, 20.0),
    "cosine": ("gb_enclosed_cos(x, gb_enclosed_waves(x))", math.cos, -20.0, 20.0),
    "tangent": ("gb_enclosed_tan(x)", math.tan, -1.4, 1.4),
    "arc tangent": ("gb_enclosed_atan(x)", math.atan, -5.0, 5.0),
    "arc sine": ("gb_enclosed_asin(x)", math.asin, -0.95, 0.95),
    "exponential": ("gb_enclosed_exp(x)", math.exp, -5.0, 5.0),
    "logarithm": ("gb_enclosed_log(x)", math.log, 0.1, 9.0),
    "hyperbolic tangent": ("gb_enclosed_tanh(x)", math.tanh, -3.0, 3.0),
    "hyperbolic sine": ("gb_enclosed_sinh(x)", math.sinh, -3.0, 3.0),
    "hyperbolic cosine": ("gb_enclosed_cosh(x)", math.cosh, -3.0, 3.0),
    "root": ("gb_enclosed_root(x, 0.5)", math.sqrt, 0.1, 9.0),
    "square": ("gb_enclosed_power(x, 2)", lambda x: x**2, -3.0, 3.0),
    "cube": ("gb_enclosed_power(x, 3)", lambda x: x**3, -3.0, 3.0),
    "inverse": ("gb_enclosed_power(x, -1)", lambda x: 1 / x, 0.2, 4.0),
    "product": ("gb_enclosed_mul(x, gb_enclosed_shift(x, -1.0))", lambda x: x * (x - 1), -3.0, 3.0),
    "difference": ("gb_enclosed_add(x, gb_enclosed_scale(x, -3.0))", lambda x: -2 * x, -3.0, 3.0),
}


@pytest.fixture(scope="module")
def core(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("enclosure")
    text = '#include "gb_enclosure.h"\n'
    for number, (call, *_) in enumerate(FUNCTIONS.values()):
        text += f"void enclose{number}(double *at) {{\n    const gb_enclosure x = {{at[0], at[1], at[2], at[3]}};\n"
        text += f"    const gb_enclosure f = {call};\n    at[0] = f.lo;\n    at[1] = f.hi;\n"
        text += "    at[2] = f.down;\n    at[3] = f.up;\n}\n"
    (folder / "enclose.c").write_text(text, encoding="utf-8")
    command = [*_compiler(), *FLAGS, "-Wno-unused-function", "-O1", "-shared", "-fPIC", f"-I{CORE}"]
    subprocess.run([*command, str(folder / "enclose.c"), "-lm", "-o", str(folder / "enclose.so")], check=True)
    return ctypes.CDLL(str(folder / "enclose.so"))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_values_and_rates_lie_within(core: ctypes.CDLL, name: str) -> None:
    _, function, least, most = FUNCTIONS[name]
    enclose = getattr(core, f"enclose{list(FUNCTIONS).index(name)}")
    draw = np.random.default_rng(7)
    for _ in range(300):
        begin, width = draw.uniform(least, most), 10.0 ** draw.uniform(-6.0, 0.5)
        end = min(most, begin + width)
        rate = (end - begin) * draw.choice([1.0, -1.0])
        at = (ctypes.c_double * 4)(begin, end, rate, rate)
        enclose(at)
        part = draw.uniform(0.01, 0.99, 20)
        x = begin + (end - begin) * part
        values = np.array([function(each) for each in x])
        assert np.all(at[0] <= values) and np.all(values <= at[1]), (begin, end)
        small = 1e-6 * np.minimum(np.maximum(1.0, abs(x)), (end - begin) * np.minimum(part, 1 - part) * 1e3 + 1e-3)
        slope = (
            np.array([(function(b) - function(a)) / (b - a) for a, b in zip(x - small, x + small, strict=True)]) * rate
        )
        slack = 1e-6 * max(1.0, abs(at[2]), abs(at[3]))
        assert np.all(at[2] - slack <= slope) and np.all(slope <= at[3] + slack), (begin, end)
