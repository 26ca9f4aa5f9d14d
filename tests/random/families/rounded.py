"""Trains of the six families with round numbers, as people write them: sizes, times and loads that meet each other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from math import floor, log10
from random import Random
from typing import Any

from tests.random.description import Train
from tests.random.expressions import Node
from tests.random.families.contact import contact
from tests.random.families.control import control
from tests.random.families.friction import friction
from tests.random.families.lossy import lossy
from tests.random.families.mixed import mixed
from tests.random.families.smooth import smooth

FAMILIES = (smooth, contact, friction, lossy, control, mixed)
KEPT = ("ratio", "loss_table", "pressure_angle", "r_base", "stiffness_variation")


def rounded(seed: int) -> Train:
    """One of them, its numbers with one digit or of 1, 2 and 5 alone; what was in order stays so, or becomes equal."""
    random = Random(f"rounded {seed}")
    train, to_round = random.choice(FAMILIES)(seed), random.choice((_one_digit, _one_two_five))
    parts = (
        p.changed(**{name: _round(value, to_round) for name, value in p.fields if name not in KEPT})
        for p in train.parts
    )
    inputs = tuple((name, _round(value, to_round)) for name, value in train.inputs)
    return replace(train.with_parts(parts), family="rounded", seed=seed, inputs=inputs)


def _one_digit(x: float) -> float:
    return float(f"{x:.0e}")


def _one_two_five(x: float) -> float:
    decade = 10.0 ** floor(log10(abs(x)))
    return min((abs(abs(x) / (k * decade) - 1.0), k * decade) for k in (1.0, 2.0, 5.0, 10.0))[1] * (1 if x > 0 else -1)


def _round(value: Any, to_round: Callable[[float], float]) -> Any:
    if isinstance(value, float) and value != 0.0:
        near = float(f"{to_round(value):.6g}")
        return value if abs(value) < 1.0 <= abs(near) else near  # a share of one, of an efficiency say
    if isinstance(value, Node):
        return replace(value, args=_round(value.args, to_round))
    if isinstance(value, tuple):
        new = tuple(_round(x, to_round) for x in value)
        numbers = all(isinstance(x, (int, float)) for x in value)
        rises = numbers and all(a < b for a, b in pairwise(value))
        return value if rises and not all(a < b for a, b in pairwise(new)) else new
    return value
