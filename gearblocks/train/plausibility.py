"""Values that are admissible in SI and yet hardly meant: a field says up to where its values are usual.

Knows nothing of bounds, which refuse.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from numbers import Real

from gearblocks.errors import warn
from gearblocks.language.block import Block
from gearblocks.language.fields import Field
from gearblocks.language.signals import constant_value
from gearblocks.language.units import Given
from gearblocks.train.values import is_plain, numbers_of


def unusual(path: str, block: Block, *, bare: bool = False) -> Iterator[str]:
    """Numbers above what their field expects; bare: of those that are given without a unit alone."""
    if is_plain(block) and not _expects(type(block)):
        return
    for name, value, spec in numbers_of(block, f"{path}."):
        if spec.usual is not None and (is_bare(value) or not bare):
            number = abs(constant_value(value))
            yield from _doubt(name, number, spec, f'{name.rpartition(".")[2]}="{number:g} mm"')


@cache
def _expects(kind: type[Block]) -> bool:
    """Whether a field of its own says up to where its values are usual."""
    return any(spec.usual is not None for spec in kind.fields.values())


def _doubt(name: str, number: float, spec: Field, meant: str) -> Iterator[str]:
    """What is said of a number above what its field expects; meant: how it is written where millimetres were meant."""
    if spec.usual is not None and number > spec.usual:
        milli = f"; {number:g} mm is written as {meant}" if spec.unit == "m" else ""
        yield f"{name} = {number:g} {spec.unit} ({spec.words}) is implausible, more than {spec.usual:g} {spec.unit}{milli}"


def warn_of_doubts(path: str, part: object) -> None:
    """A GearblocksWarning for every unusual value of a part that is a block."""
    for doubt in unusual(path, part, bare=True) if isinstance(part, Block) else ():
        warn(f"{type(part).__name__} {doubt}")


def is_bare(value: object) -> bool:
    """Whether a value is a number that is given without a unit."""
    return isinstance(value, Real) and not isinstance(value, (bool, Given))


def warn_of_changed(blocks: Iterable[tuple[str, Block]], path: str, value: float, meant: str) -> None:
    """A GearblocksWarning where a parameter of a run, given without a unit, is more than its field expects; meant: how it is
    written where millimetres were meant, with {path} and {number}."""
    number = abs(value)
    for component, block in blocks:
        for name, _, spec in numbers_of(block, f"{component}.") if path.startswith(f"{component}.") else ():
            if name == path:
                for doubt in _doubt(path, number, spec, meant.format(path=path, number=number)):
                    warn(f"{type(block).__name__} {doubt}")
