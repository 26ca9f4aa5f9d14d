"""Rules: what the blocks of a train refuse of numbers, asked again of those that a run gives.

A block is made anew with these numbers, and asked what it is asked when a train is composed: the bounds of its fields, and
its `problems()`. Bounds of a number by itself are known beside it in the program, and need no block. Knows nothing of
programs, nor of runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

from gearblocks.language.block import Block, Declared, field_values
from gearblocks.language.signals import Parameter
from gearblocks.language.units import parse_unit
from gearblocks.train.graph import Component
from gearblocks.train.leaves import with_leaves
from gearblocks.train.values import is_plain, leaves_of, numbers_of, value_problems, with_values

Given = Callable[[str], "float | None"]
"""The number in SI that stands at a path, or that a Parameter of this name has; None where there is none."""


class Rules:
    """The rules of the blocks of a train."""

    def __init__(self, components: tuple[Component, ...]) -> None:
        self._components = components
        self._judging: dict[str, tuple[str, ...]] = {}

    def __reduce__(self) -> tuple[Any, ...]:
        return Rules, (self._components,)

    @property
    def travels(self) -> bool:
        """Whether other processes know the classes of all blocks: those of the catalogue."""
        return all(type(c.block).__module__.startswith("gearblocks.") for c in self._components)

    @cached_property
    def _blocks(self) -> Mapping[str, Block]:
        return {c.path: c.block for c in self._components}

    @cached_property
    def _with(self) -> Mapping[str, tuple[str, ...]]:
        """Blocks that a Parameter stands in, by its name."""
        found: dict[str, dict[str, None]] = {}
        for path, block in self._blocks.items():
            for leaf in leaves_of(block):
                if isinstance(leaf, Parameter):
                    found.setdefault(leaf.name, {})[path] = None
        return {name: tuple(paths) for name, paths in found.items()}

    def is_parameter(self, name: str) -> bool:
        """Whether a name is that of a Parameter."""
        return name in self._with

    def of(self, name: str) -> tuple[str, ...]:
        """Blocks that judge the number at a path, or that of a Parameter, together with others."""
        if name not in self._judging:
            found = ((path, self._blocks[path]) for path in self.all_of(name))
            shared = self.is_parameter(name)
            self._judging[name] = tuple(p for p, b in found if _judges(b) or (shared and not _stands_alone(b, name)))
        return self._judging[name]

    def all_of(self, name: str) -> tuple[str, ...]:
        """Blocks that have the number at a path, or that a Parameter stands in."""
        return self._with.get(name) or self._owner(name)

    def _owner(self, path: str) -> tuple[str, ...]:
        owner = path
        while owner and owner not in self._blocks:
            owner = owner.rpartition(".")[0]
        return (owner,) if owner else ()

    def problems(self, path: str, given: Given) -> Iterator[str]:
        """What a block finds wrong with the numbers that are given."""
        yield from value_problems(path, _anew(self._blocks[path], path, given), again=True)


def _judges(block: Declared) -> bool:
    """Whether a block or one of its effects relates its numbers."""
    if type(block).problems is not Declared.problems:
        return True
    return any(isinstance(part, Declared) and _judges(part) for part in field_values(block).values())


def _stands_alone(block: Block, name: str) -> bool:
    """Whether a Parameter is in no expression of a block."""
    return all(isinstance(v, Parameter) or name not in _names(v) for _, v, _ in numbers_of(block, ""))


def _names(value: Any) -> set[str]:
    """Names of the Parameters in an expression."""
    leaves = value.leaves() if hasattr(value, "leaves") else ()
    return {leaf.args[0].name for leaf in leaves if leaf.op == "parameter"}


def _anew(block: Block, path: str, given: Given) -> Block:
    """A block with the numbers that are given."""

    def number(name: str, value: Any) -> Any:
        other = given(name) if type(value) in (float, int) else None
        return value if other is None or other == value else other

    def leaf(one: Any) -> Any:
        other = given(one.name) if isinstance(one, Parameter) else None
        return one if other is None or other == one.si else replace(one, value=parse_unit(one.unit).of_si(other))

    changed = with_values(block, f"{path}.", number)
    found = changed if is_plain(changed) else with_leaves(changed, leaf)
    assert isinstance(found, Block)
    return found
