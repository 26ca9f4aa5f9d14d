"""Outputs of a program by what they mean: a name is put together where it is read, as a long train has a million of them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from itertools import accumulate, chain
from typing import Any, NamedTuple, final, overload


class Quantity(NamedTuple):
    """Name, SI unit and description of one number in a vector.

    kind, of a state: "coordinate" (relative), "angle" (absolute), "speed", "state" of a block, or "sum"
    of what passes it (heat); positions count as angles.
    """

    name: str
    unit: str
    words: str
    kind: str = ""


class OutputGroup(NamedTuple):
    """Outputs of one meaning, one per owner. sliding: what an owner's is called, and its unit, where it slides.

    slides: a byte per owner, 1 where it slides; empty where none does. An output without a name has its owner's.
    """

    owners: tuple[str, ...]
    turning: Quantity
    sliding: Quantity
    slides: bytes = b""

    def at(self, i: int) -> Quantity:
        """That of owner i."""
        meaning = self.sliding if self.slides and self.slides[i] else self.turning
        return meaning._replace(name=f"{self.owners[i]}.{meaning.name}" if meaning.name else self.owners[i])

    def names(self) -> Sequence[str]:
        """The names of all, in the order of the owners."""
        name = self.turning.name
        if not name:
            return self.owners
        if not self.slides:
            return [f"{owner}.{name}" for owner in self.owners]
        names = name, self.sliding.name
        return [f"{owner}.{names[slides]}" for owner, slides in zip(self.owners, self.slides, strict=True)]

    def units(self) -> Iterator[str]:
        """The units of all."""
        units = self.turning.unit, self.sliding.unit
        return map(units.__getitem__, self.slides or bytes(len(self.owners)))


@final
class OutputList(Sequence[Quantity]):
    """The outputs of groups, one group after another."""

    def __init__(self, groups: Sequence[OutputGroup]) -> None:
        self.groups = tuple(groups)

    @cached_property
    def _ends(self) -> list[int]:
        return [*accumulate(len(group.owners) for group in self.groups)]

    def __len__(self) -> int:
        return self._ends[-1] if self.groups else 0

    @overload
    def __getitem__(self, at: int) -> Quantity: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[Quantity, ...]: ...
    def __getitem__(self, at: int | slice) -> Quantity | tuple[Quantity, ...]:
        numbers = range(len(self))[at]
        return self._at(numbers) if isinstance(numbers, int) else tuple(map(self._at, numbers))

    def _at(self, number: int) -> Quantity:
        group = bisect_right(self._ends, number)
        return self.groups[group].at(number - (self._ends[group - 1] if group else 0))

    def __iter__(self) -> Iterator[Quantity]:
        for group in self.groups:
            yield from map(group.at, range(len(group.owners)))

    @staticmethod
    def of(outputs: Iterable[Quantity]) -> OutputList:
        """The list of single outputs."""
        return OutputList([OutputGroup((q.name,), q._replace(name=""), q._replace(name="")) for q in outputs])

    def names(self) -> Iterator[str]:
        """The names of all, which takes less than going through them."""
        return chain.from_iterable(group.names() for group in self.groups)

    def units(self) -> Iterator[str]:
        """The units of all."""
        return chain.from_iterable(group.units() for group in self.groups)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, OutputList):
            return self.groups == other.groups or tuple(self) == tuple(other)
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return OutputList, (self.groups,)

    def __repr__(self) -> str:
        return f"<{len(self)} outputs: {', '.join(q.name for q in self[:3])}{', ...' if len(self) > 3 else ''}>"
