"""Sizes that do not fit each other, in words: numbers in SI that were given in another unit, as a rule.

Teeth are judged by their module m (which 2 r_b / z stands for where base radii are given): a gap or an error larger than m,
a stiffness below 1e8 N/m2 times m (steel: 1e11, plastics: 1e9), damping c that leaves the teeth apart for longer than
10 ms (c/k). Trains without dimensions (a module above 0.1 m, of which is asked elsewhere) take any.
Knows nothing of laws and of runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from gearblocks.blocks.effects import Profile
from gearblocks.blocks.gears import IdealGear
from gearblocks.language.block import Block, Declared, field_values
from gearblocks.language.fields import Field
from gearblocks.language.signals import Table, constant_value
from gearblocks.train.graph import Tree, blocks_of
from gearblocks.train.values import numbers_of

_LARGEST_MODULE = 0.1  # m
_SOFTEST = 1e8  # stiffness over the module, N/m2
_SLOWEST = 1e-2  # damping over stiffness, s
_MANY = 10.0  # times the mean stiffness that a variation comes to
_FASTEST = 1.5e4  # rad/s, 143 000 rpm
_LARGER = 1e6  # times the next largest inertia


def out_of_proportion(path: str, block: Block) -> Iterator[str]:
    """What is asked of one block."""
    module = _module(block)
    numbers = {name: (constant_value(value), spec) for name, value, spec in numbers_of(block, f"{path}.")}
    for name, (value, spec) in numbers.items():
        found = _Number(name, value, spec)
        yield from _speed_or_ratio(found, math.isfinite(module))
        if math.isfinite(module):
            yield from _length(found, module)
            yield from _law_of_teeth(found, module, numbers.get(f"{found.owner}.k", (math.nan, spec))[0])
    yield from _tables(path, block, module)
    yield from _ring_inside(path, block)


def inertias_out_of_proportion(tree: Tree) -> Iterator[str]:
    """An inertia beside which every other one of the train is as good as none."""
    found = [
        (abs(constant_value(value)), name, spec)
        for path, block in blocks_of(tree)
        for name, value, spec in numbers_of(block, f"{path}.")
        if spec.unit == "kg m2"
    ]
    sizes = sorted((row for row in found if row[0] > 0), key=lambda row: row[0])
    if len(sizes) > 1 and sizes[-1][0] > _LARGER * sizes[-2][0] and sizes[-1][0] >= 1.0:
        (size, name, _), (next_size, next_name, _) = sizes[-1], sizes[-2]
        yield (
            f"{name} = {size:g} kg m2 is {size / next_size:.1g} times {next_name}, the next largest inertia, which "
            f"moves nothing of it; {size:g} kg cm2 is written as '{size:g} kg cm2', a given speed is gb.Speed(...)"
        )


@dataclass(frozen=True)
class _Number:
    path: str
    value: float
    spec: Field

    @property
    def owner(self) -> str:
        return self.path.rpartition(".")[0]

    @property
    def field(self) -> str:
        return self.path.rpartition(".")[2].partition("[")[0]

    @property
    def size(self) -> float:
        return abs(self.value)

    def __str__(self) -> str:
        return f"{self.path} = {self.value:g}" + f" {self.spec.unit}" * (self.spec.unit not in ("", "1"))

    def written(self, unit: str) -> str:
        """How the same number is given in another unit."""
        return f"{self.value:g} {unit} is written as '{self.value:g} {unit}'"


def _module(block: Block) -> float:
    """The size of the teeth [m]; NaN where there are none, or none with dimensions."""
    own = block.__dict__
    module = constant_value(own.get("module"))
    radius, teeth = own.get("r_base") or own.get("radius"), own.get("teeth")
    if math.isnan(module) and radius is not None and teeth is not None:
        radius, teeth = (x[0] if isinstance(x, tuple) else x for x in (radius, teeth))
        module = 2 * constant_value(radius) / max(constant_value(teeth), 1.0)
    return module if 0 < module <= _LARGEST_MODULE else math.nan


def _speed_or_ratio(x: _Number, teeth: bool) -> Iterator[str]:
    """Speeds in rpm, and damping ratios in percent."""
    if x.spec.unit == "rad/s" and (x.spec.start == "speed" or x.field == "w") and x.size > _FASTEST:
        yield f"{x} is {x.value * 30 / math.pi:.6g} rpm; {x.written('rpm')}"
    elif x.field == "damping_ratio" and (x.size >= 1 if teeth else x.size > 2):
        yield f"{x} is {x.size:g} times critical damping; {x.written('%')}"


def _length(x: _Number, module: float) -> Iterator[str]:
    """Gaps and errors in mm or um."""
    error = ".transmission_error." in x.path and x.field in ("cos", "sin")
    if x.spec.unit == "m" and (x.field in ("half_gap", "gaps") or error) and x.size > module:
        what = "the teeth would deviate by" if error else "the teeth would pass each other with"
        yield f"{x}: {what} more than their module, {module:g} m; {_in_um(x)}"


def _in_um(x: _Number) -> str:
    return x.written("um") if x.size >= 0.1 else "gaps and errors of teeth are some um; look at its unit"


def _law_of_teeth(x: _Number, module: float, k: float) -> Iterator[str]:
    """Stiffness in N/um, and damping in N s/mm."""
    if x.field == "k" and x.spec.unit == "N/m" and 0 < x.value < _SOFTEST * module:
        yield f"{x} is softer than teeth of plastic with a module of {module:g} m; {x.written('N/um')}"
    elif x.field == "c" and x.spec.unit == "N s/m" and k > 0 and x.value > _SLOWEST * k:
        yield (
            f"{x}: unloaded teeth come back within c/k = {x.value / k:.2g} s, of which a millisecond is much already; give "
            "damping_ratio=0.05 or so, or look at the units of c and k"
        )


def _tables(path: str, owner: Declared, module: float) -> Iterator[str]:
    """Measured cycles: a stiffness relative to k, an error in m."""
    for name, part in field_values(owner).items():
        where = f"{path}.{name}"
        if isinstance(part, Profile) and isinstance(part.table, Table):
            largest = float(np.abs(part.table.y).max())
            if "stiffness_variation" in where and largest > _MANY:
                yield (
                    f"{where}.table comes to {largest:g}: its values are relative to k (0.1: one tenth more); for a table in "
                    "N/m give k = its mean, and as values its y / mean - 1"
                )
            elif ".transmission_error" in where and largest > module:
                yield (
                    f"{where}.table comes to {largest:g} m, more than the module, {module:g} m; multiply values in um by 1e-6, "
                    "those in mm by 1e-3"
                )
        elif isinstance(part, Declared):
            yield from _tables(where, part, module)


def _ring_inside(path: str, block: Block) -> Iterator[str]:
    """An internal pair whose ring is the smaller gear."""
    teeth = block.__dict__.get("teeth")
    if (
        block.__dict__.get("external") is False
        and isinstance(teeth, tuple)
        and len(teeth) == 2
        and not isinstance(block, IdealGear)
    ):
        one, two = (constant_value(x) for x in teeth)
        if one > two:
            yield (
                f"{path}.teeth = ({one:g}, {two:g}) of an internal pair: the wheel is the ring, and it has fewer teeth than "
                f"the pinion inside; give ({two:g}, {one:g}), and connect the ring to {path}.wheel"
            )
