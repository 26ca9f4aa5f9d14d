"""Alike parts of a train printed once, by an index: sun_mesh0 ... sun_mesh3 as sun_mesh_i, i = 0, ..., 3.

What is printed of one member stands for all where it is the same, name by name, of each of them; terms of a sum that are
the same of each member are a sum over the index. Knows nothing of sympy.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, final

from gearblocks.equations.document import Line, Nomenclature, Section
from gearblocks.equations.names import INDEX, Name, owners, whole
from gearblocks.equations.nodes import Fence, Node, Op, Row, Sum
from gearblocks.equations.nomenclature import Entry

_FEWEST = 3
_LONG = 40


class Member(NamedTuple):
    """A part by its number in its family; stem: of its path; indices: first and last of the family; short: what stands at the
    foot of its symbols, without the number."""

    stem: str
    number: int
    indices: tuple[int, int]
    short: str

    @property
    def place(self) -> tuple[int, tuple[int, int]]:
        """Its number and those of its family."""
        return self.number, self.indices

    @property
    def foot(self) -> str:
        """What stands at the foot of symbols of any member."""
        return f"{self.short.rstrip('_')} {INDEX}"

    @property
    def words(self) -> str:
        """Any member, as a heading says it."""
        return f"{self.stem.rstrip('_[')}_{INDEX}"

    @property
    def range(self) -> str:
        """The values of the index."""
        return f"{INDEX} = {self.indices[0]}, ..., {self.indices[1]}"


@final
@dataclass(frozen=True, slots=True)
class Families:
    """members: by path; feet: the same by what stands at the foot of symbols."""

    members: Mapping[str, Member]
    feet: Mapping[str, Member]

    def member(self, owner: str) -> Member | None:
        """The member to which a symbol belongs, itself or a part of it."""
        return self.feet.get(owner) or self.feet.get(owner.rpartition(" ")[0])

    def without(self, stems: set[str]) -> Families:
        """Without some families, whose members are printed one by one."""
        kept = {path: m for path, m in self.members.items() if m.stem not in stems}
        return Families(kept, {foot: m for foot, m in self.feet.items() if m.stem not in stems})

    def unexplained(self, sections: Iterable[Section], nomenclature: Nomenclature) -> set[str]:
        """Stems of families of which symbols of any member are printed that the nomenclature does not have."""
        stems = {m.foot: m.stem for m in self.members.values()}
        printed = {dataclasses.replace(name, dots=0) for section in sections for name in names_in(section.lines)}
        entered = {name for name, _ in nomenclature.entries}
        unknown = {name.owner for name in printed - entered if not name.is_of_a_case}
        return {
            stem for foot, stem in stems.items() for owner in unknown if owner == foot or owner.startswith(f"{foot} ")
        }

    def indices_in(self, node: Any) -> set[tuple[int, tuple[int, int]]]:
        """Index and range of all members whose symbols stand in a node."""
        found = (self.member(name.owner) for name in names_in(node))
        return {(m.number, m.indices) for m in found if m is not None}

    def of_any(self, node: Any, index: int, indices: tuple[int, int]) -> Any:
        """A node with the symbols of the members of one index as those of any member."""

        def changed(name: Name) -> Name:
            member = self.member(name.owner)
            if member is None or (member.number, member.indices) != (index, indices):
                return name
            return dataclasses.replace(name, owner=name.owner.replace(f"{member.short}{index}", member.foot, 1))

        return _renamed(node, changed)


def families(kinds: Mapping[str, str]) -> Families:
    """The families of a train: three parts of one class or more whose names differ by a number, without a gap in these."""
    found: dict[tuple[str, str], dict[int, str]] = {}
    feet = owners(kinds)
    for path, kind in kinds.items():
        match = re.fullmatch(r"(.*?)(0|[1-9]\d*)\]?", path)
        if match and match[1]:
            found.setdefault((match[1], kind), {})[int(match[2])] = path
    members: dict[str, Member] = {}
    for (stem, _), paths in found.items():
        first, last = min(paths), max(paths)
        if len(paths) >= _FEWEST and last - first + 1 == len(paths):
            members |= {
                path: Member(stem, i, (first, last), feet[path].removesuffix(str(i))) for i, path in paths.items()
            }
    return Families(members, {feet[path]: member for path, member in members.items()})


def of_parts(found: Families, sections: Mapping[str, Section], kinds: Mapping[str, str]) -> Iterator[Section]:
    """Sections of parts by path, those of a family as one where they are the same."""
    done: set[str] = set()
    for path, section in sections.items():
        if path in done:
            continue
        member = found.members.get(path)
        alike = [] if member is None else [p for p, m in found.members.items() if m.stem == member.stem]
        shown = {p: found.of_any(sections[p].lines, *found.members[p].place) for p in alike if p in sections}
        if member is not None and len(shown) == len(alike) and len(set(shown.values())) == 1:
            done.update(alike)
            yield Section(f"{member.words} ({kinds[path]}), {member.range}", shown[path])
        else:
            yield section


def of_lines(found: Families, section: Section) -> Iterator[Section]:
    """The equations of a section, of which those of families stand in sections of their own."""
    alike: dict[tuple[Line, tuple[int, int]], list[Line]] = {}
    for line in section.lines:
        places = found.indices_in(line.left)
        if len(places) == 1:
            ((index, indices),) = places
            alike.setdefault((found.of_any(line, index, indices), indices), []).append(line)
    whole = {line: made for (line, (a, b)), made in alike.items() if len(made) == b - a + 1}
    single = [line for line in section.lines if not any(line in made for made in whole.values())]
    if single:
        yield Section(section.heading, tuple(with_sums(found, line) for line in single))
    for indices in dict.fromkeys(indices for line, indices in alike if line in whole):
        lines = tuple(with_sums(found, line) for line, its in alike if its == indices and line in whole)
        yield Section(f"{section.heading}, {INDEX} = {indices[0]}, ..., {indices[1]}", lines)


def with_sums(found: Families, line: Line) -> Line:
    """An equation whose terms of all members of a family are a sum over its index."""
    terms = list(_terms(line.right))
    alike: dict[tuple[str, Node, tuple[int, int]], dict[int, int]] = {}
    for at, (sign, node) in enumerate(terms):
        for index, indices in found.indices_in(node):
            alike.setdefault((sign, found.of_any(node, index, indices), indices), {})[index] = at
    left_out: set[int] = set()
    sums: dict[int, tuple[str, Node]] = {}
    for (sign, node, (first, last)), where in alike.items():
        if len(where) == last - first + 1 and not left_out & set(where.values()):
            left_out |= set(where.values())
            inner = Fence("(", ")", node) if isinstance(node, Row) else node
            sums[min(where.values())] = sign, Sum(INDEX, first, last, inner)
    kept = [sums.get(at, term) for at, term in enumerate(terms) if at in sums or at not in left_out]
    return Line(line.left, _row(kept)) if sums else line


def of_entries(found: Families, nomenclature: Nomenclature, sections: Iterable[Section]) -> Nomenclature:
    """Symbols of all members of a family as one, with all values where these differ; those that the sections name one by one
    alone stay so."""
    named = {dataclasses.replace(name, dots=0) for section in sections for name in names_in(section.lines)}
    alike: dict[tuple[Name, tuple[int, int]], list[tuple[Name, Entry]]] = {}
    for name, entry in nomenclature.entries:
        member = found.member(name.owner)
        if member is not None:
            alike.setdefault((found.of_any(name, *member.place), member.indices), []).append((name, entry))
    whole = {name: made for (name, (a, b)), made in alike.items() if len(made) == b - a + 1}
    whole = {name: made for name, made in whole.items() if name in named or not named & {old for old, _ in made}}
    standing = {old: name for name, made in whole.items() for old, _ in made}
    entries: dict[Name, Entry] = {}
    for name, entry in nomenclature.entries:
        if name not in standing:
            entries[name] = entry
        elif standing[name] not in entries:
            entries[standing[name]] = _of_all(found, whole[standing[name]])
    return Nomenclature(tuple(entries.items()))


def _of_all(found: Families, made: Sequence[tuple[Name, Entry]]) -> Entry:
    name, entry = made[0]
    member = found.member(name.owner)
    assert member is not None
    values = [other.value for _, other in made]
    value = entry.value if len(set(values)) == 1 else ", ".join(values)
    if len(value) > _LONG:
        value = f"{values[0]}, {values[1]}, ..., {values[-1]}"
    one = f"{member.stem}{member.number}"
    words = entry.words.replace(whole(one), member.words)
    return dataclasses.replace(entry, words=words, value=value, path=entry.path.replace(one, f"{member.stem}<{INDEX}>"))


# -- nodes ------------------------------------------------------------------------------------------------------------


def names_in(node: Any) -> Iterator[Name]:
    if isinstance(node, Name):
        yield node
    elif isinstance(node, tuple):
        for part in node:
            yield from names_in(part)
    elif dataclasses.is_dataclass(node):
        for field in dataclasses.fields(node):
            yield from names_in(getattr(node, field.name))


def _renamed(node: Any, changed: Any) -> Any:
    if isinstance(node, Name):
        return changed(node)
    if isinstance(node, tuple):
        return tuple(_renamed(part, changed) for part in node)
    if dataclasses.is_dataclass(node) and not isinstance(node, type):
        parts = {field.name: _renamed(getattr(node, field.name), changed) for field in dataclasses.fields(node)}
        return dataclasses.replace(node, **parts)
    return node


def _terms(node: Node) -> Iterator[tuple[str, Node]]:
    """The terms of a sum with their signs; what is none is one term."""
    items = node.items if isinstance(node, Row) else (node,)
    if any(isinstance(x, Op) and x.sign not in ("+", "-", "neg") for x in items):
        yield "+", node
        return
    sign = "+"
    for item in items:
        if isinstance(item, Op):
            sign = "-" if item.sign == "neg" else item.sign
        else:
            yield sign, item
            sign = "+"


def _row(terms: Iterable[tuple[str, Node]]) -> Node:
    items: list[Any] = []
    for sign, node in terms:
        if items or sign == "-":
            items.append(Op(sign if items else "neg"))
        items.append(node)
    return items[0] if len(items) == 1 else Row(tuple(items))
