"""What a train has, before any run: outputs, parameters, inputs and flanges by pattern, with unit, words and value.

Outputs and parameters are those of the program, which is made for it (or read from the cache) and not compiled. Knows nothing
of runs.
"""

from __future__ import annotations

import fnmatch
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, final, overload

from gearblocks.errors import ParameterError, UnknownNameError, arguments_told, did_you_mean
from gearblocks.language.block import Block
from gearblocks.language.signals import Input
from gearblocks.language.units import parse_unit
from gearblocks.model.build import program_of
from gearblocks.model.start_values import fitted_later
from gearblocks.pages import small_table
from gearblocks.train.disjoint_sets import DisjointSets
from gearblocks.train.graph import Train, Tree, flatten
from gearblocks.train.summary import number_text
from gearblocks.train.values import leaves_of

SHOWN = 200
"""The lines of a listing that are printed."""


class Listed(NamedTuple):
    """One name. value: a number in `unit`, or in words what a flange is joined to; None where there is none before a run."""

    name: str
    unit: str
    words: str
    value: float | str | None = None


@final
@arguments_told
@dataclass(frozen=True, repr=False)
class Listing(Sequence[Listed]):
    """What was found, part by part; prints as a table. what: "outputs", "parameters", "inputs" or "flanges"."""

    what: str
    entries: tuple[Listed, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The names alone."""
        return tuple(x.name for x in self.entries)

    def __len__(self) -> int:
        return len(self.entries)

    @overload
    def __getitem__(self, at: int) -> Listed: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[Listed, ...]: ...
    def __getitem__(self, at: int | slice) -> Listed | tuple[Listed, ...]:
        return self.entries[at]

    def _repr_html_(self) -> str:
        rows = [(x.name, _shown(x.value), "" if x.unit == "1" else x.unit, x.words) for x in self.entries]
        if any(value for _, value, _, _ in rows):
            return small_table(self.what, rows, head=("name", "value", "unit", "meaning"), numbers=(1,))
        return small_table(
            self.what, [(x, unit, words) for x, _, unit, words in rows], head=("name", "unit", "meaning")
        )

    def __repr__(self) -> str:
        return self.table(SHOWN)

    def table(self, most: int) -> str:
        """How many there are, and as many lines as `most`."""
        rows = [(x.name, _shown(x.value), "" if x.unit == "1" else x.unit, x.words) for x in self.entries[:most]]
        widths = [max((len(row[i]) for row in rows), default=0) for i in range(3)]
        lines = [
            "  " + "  ".join([*(f"{cell:<{w}}" for cell, w in zip(row, widths, strict=False) if w), row[3]]).rstrip()
            for row in rows
        ]
        more = [f"  ... and {len(self) - most} more"] if len(self) > most else []
        count = f"{len(self)} {self.what if len(self) > 1 else self.what[:-1]}" if self.entries else f"no {self.what}"
        return "\n".join([count, *lines, *more])


def _shown(value: float | str | None) -> str:
    return "" if value is None else number_text(value, 6) if isinstance(value, float) else value


def outputs(train: Train, patterns: tuple[str, ...]) -> Listing:
    """The outputs that a run records."""
    program, _ = program_of(train)
    return _picked("outputs", _by_part(train, (Listed(q.name, q.unit, q.words) for q in program.outputs)), patterns)


def parameters(train: Train, patterns: tuple[str, ...]) -> Listing:
    """The parameters with their values, each in the unit it is given in; start values that a build finds have none."""
    program, values = program_of(train)
    later = fitted_later(program, train)

    def entries() -> Iterator[Listed]:
        for i, p in enumerate(program.parameters):
            unit = p.given_in or p.unit
            value = None if i in later else parse_unit(unit).of_si(float(values.get(p.path, 0.0)))
            structural = p.path in program.structural_paths
            note = f"; {program.why_structural(p.path)}, changed by rig.set" if structural else ""
            yield Listed(p.path, unit, p.words + note, value)

    return _picked("parameters", _by_part(train, entries()), patterns)


def inputs(tree: Tree, patterns: tuple[str, ...]) -> Listing:
    """The inputs with their values before anything is connected, each in the unit that it is given in."""
    components = flatten(tree, complete=False).components if tree.parts else ()
    found = {x.name: x for c in components for x in leaves_of(c.block) if isinstance(x, Input)}
    return _picked("inputs", (Listed(x.name, x.unit, "input", float(x.start)) for x in found.values()), patterns)


def _by_part(train: Train, entries: Iterable[Listed]) -> list[Listed]:
    """In the order of the parts, their own before those of their flanges; what belongs to no part at the end."""
    numbers = {c.path: i for i, c in enumerate(train.components)}

    def place(x: Listed) -> tuple[int, int]:
        owner, deep = x.name.rpartition(".")[0], 0
        while owner and owner not in numbers:
            owner, deep = owner.rpartition(".")[0], deep + 1
        return numbers.get(owner, len(numbers)), deep

    return sorted(entries, key=place)


def flanges(tree: Tree, patterns: tuple[str, ...]) -> Listing:
    """The flanges of all parts, and what each is joined to; of trains inside, those that they expose too."""
    known = list(_flanges_of(tree, ""))
    joined = DisjointSets[str]()
    for one, other in _joined(tree, ""):
        joined.join(one, other)
    groups: dict[str, list[str]] = {}
    for name, *_ in known:
        groups.setdefault(joined.root(name), []).append(name)
    flat = flatten(tree, complete=False).components if tree.parts else ()
    sliding = {f"{c.path}.{flange}" for c in flat for flange in c.sliders}

    def entries() -> Iterator[Listed]:
        for name, words, slides, alone in known:
            others = [x for x in groups[joined.root(name)] if x != name]
            slider = slides is True or not sliding.isdisjoint([name, *others])
            yield Listed(name, "m" if slider else "rad", words, f"joined to {', '.join(others)}" if others else alone)

    return _picked("flanges", entries(), patterns)


def _flanges_of(tree: Tree, prefix: str) -> Iterator[tuple[str, str, bool | None, str]]:
    """Name, words and kind of every flange, and what it means where nothing is joined to it."""
    for name, part in tree.parts:
        if isinstance(part, Block):
            for flange, spec in type(part).flanges.items():
                alone = "the ground" if spec.ground else "free" if spec.spare else "open"
                yield f"{prefix}{name}.{flange}", spec.words, spec.slider, alone
        else:
            for flange, (inner, end) in part.exposed:
                yield f"{prefix}{name}.{flange}", f"flange {end} of '{prefix}{name}.{inner}'", None, "open"
            yield from _flanges_of(part, f"{prefix}{name}.")


def _joined(tree: Tree, prefix: str) -> Iterator[tuple[str, str]]:
    """Pairs of flanges that are one: connected, or one exposed as the other."""
    for link in tree.links:
        first, *others = (f"{prefix}{part}.{flange}" for part, flange in link)
        yield from ((other, first) for other in others)
    for name, part in tree.parts:
        if isinstance(part, Tree):
            for flange, (inner, end) in part.exposed:
                yield f"{prefix}{name}.{flange}", f"{prefix}{name}.{inner}.{end}"
            yield from _joined(part, f"{prefix}{name}.")


# -- patterns ---------------------------------------------------------------------------------------------------------


def matches(name: str, pattern: str) -> bool:
    """Whether `pattern` means `name`: equal, or with `*` for any characters (dots too) and `?` for one."""
    return name == pattern or fnmatch.fnmatchcase(name, pattern.replace("[", "[[]"))


def near_patterns(pattern: str, names: Iterable[str]) -> str:
    """The question whether a near name was meant, or, of a pattern with `*`, a near one that matches something."""
    known = list(names)
    pieces = [x for x in re.split(r"[\s,;]+", pattern) if x]
    if len(pieces) > 1 and all(any(matches(name, piece) for name in known) for piece in pieces):
        return f" - patterns are given one by one: {', '.join(map(repr, pieces))}"
    if any(name.startswith(f"{pattern}.") for name in known):
        return f" - did you mean '{pattern}.*'?"
    if "*" in pattern or "?" in pattern:
        splits = [(name[:i], name[i + 1 :]) for name in known for i, c in enumerate(name) if c == "."]
        known = [*dict.fromkeys(x for head, tail in splits for x in (f"{head}.*", f"*.{tail}")), *known]
    return did_you_mean(pattern, known)


def _picked(what: str, entries: Iterable[Listed], patterns: tuple[str, ...]) -> Listing:
    """Those that match any pattern, all without one; UnknownNameError names each pattern that matches none."""
    found = tuple(entries)
    for pattern in patterns:
        if not isinstance(pattern, str):
            raise ParameterError(
                f"{what} takes patterns one by one as text, such as {what}('mesh.*'), not {pattern!r:.80}"
            )
    chosen = tuple(x for x in found if not patterns or any(matches(x.name, pattern) for pattern in patterns))
    names = [x.name for x in found]
    missed = [p for p in patterns if not any(matches(x.name, p) for x in chosen)]
    if missed:
        listed = textwrap.shorten(", ".join(names), 200, placeholder=" ...") or "none"
        raise UnknownNameError(
            "; ".join(f"none of the {what} matches '{p}'{near_patterns(p, names)}" for p in missed)
            + f" (there are {listed})"
        )
    return Listing(what, chosen)
