"""Content of what a law can reach: equal for equal content, another one for another, and no addresses."""

import functools
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np
import pytest

from gearblocks.train.content import content_of


def _power(n: float) -> Callable[[float], float]:
    return lambda x: x**n


def _both(f: Any, g: Any) -> Callable[[float], float]:
    return lambda x: f(x) + g(x)


class Power:
    def __init__(self, n: Any) -> None:
        self.n = n

    def __call__(self, x: float) -> float:
        return float(x**self.n)


class Slotted:
    __slots__ = ("n",)

    def __init__(self, n: int) -> None:
        self.n = n


@dataclass(frozen=True)
class Row:
    x: tuple[float, ...]


class Side(Enum):
    LEFT = 1
    RIGHT = 2


def _array(last: float) -> Any:
    return np.array([*range(2000), last, *range(2000)], dtype=float)


PAIRS: dict[str, tuple[Callable[[Any], Any], Any, Any]] = {
    "numbers": (lambda x: x, 1, 1.0),
    "what a function has from around it": (_power, 1, 2),
    "the second of two such functions": (lambda n: _both(_power(1), _power(n)), 2, 3),
    "one of three": (lambda x: x, [a := Power(1), b := Power(2), a], [a, b, b]),
    "objects": (Power, 1, 2),
    "objects with slots": (Slotted, 1, 2),
    "methods of objects": (lambda n: Power(n).__call__, 1, 2),
    "partial functions": (lambda n: functools.partial(Power, n), 1, 2),
    "data classes": (lambda n: Row((1.0, n)), 1, 2),
    "choices": (lambda x: x, Side.LEFT, Side.RIGHT),
    "long arrays": (_array, 1, 2),
    "dictionaries": (lambda n: {"a": _array(n)}, 1, 2),
    "sets": (lambda n: {"a", "b", n}, 1, 2),
}


@pytest.mark.parametrize("name", PAIRS)
def test_another_content_has_another_text_and_the_same_has_the_same(name: str) -> None:
    make, one, other = PAIRS[name]
    assert content_of(make(one)) == content_of(make(one))
    assert content_of(make(one)) != content_of(make(other))


def test_what_refers_to_itself_and_what_cannot_be_taken_apart_have_a_content() -> None:
    ring: list[Any] = [1]
    ring.append(ring)
    assert content_of(ring)
    assert "lock" in content_of(threading.Lock())
    deep: list[Any] = []
    for _ in range(100_000):
        deep = [deep]
    assert "list object" in content_of(deep)


def test_contents_are_the_same_in_every_process() -> None:
    """As sets and addresses are not."""
    code = "from tests.unit.train.test_content import *; print([content_of(make(x)) for make, x, _ in PAIRS.values()])"
    found = {
        subprocess.run(
            [sys.executable, "-c", code], env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True, check=True
        ).stdout
        for seed in ("1", "2")
    }
    assert len(found) == 1
