"""Handles of parts and flanges, as `Drivetrain.add` and `rig["mesh"]` return them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Protocol, final

from gearblocks.errors import STAYS, ModelError, UnknownAttributeError, did_you_mean
from gearblocks.language.block import Block
from gearblocks.train.summary import field_texts


class Composition(Protocol):
    """What has parts: the drivetrain whose part a handle is, and a part that is a drivetrain itself."""

    @property
    def _exposed(self) -> Mapping[str, tuple[str, str]]: ...


class PartsByName:
    """What is asked by brackets, `in`, `len` and `for`, and not changed by them."""

    _parts: dict[str, Any]

    def __iter__(self) -> Iterator[str]:
        """The names of the parts."""
        return iter(self._parts)

    def __len__(self) -> int:
        """How many parts there are."""
        return len(self._parts)

    def __bool__(self) -> bool:
        return True  # without parts, too

    if not TYPE_CHECKING:  # so that a type checker finds these

        def __setitem__(self, path: str, _: object) -> None:
            raise ModelError(f"rig[{path!r}] = ... changes nothing: rig.set({{{path!r}: ...}}) makes a changed train")

        def __delitem__(self, path: str) -> None:
            raise ModelError(f"del rig[{path!r}]: {STAYS}")


@final
class FlangeHandle:
    """A flange of a part of one drivetrain, for `connect`."""

    __slots__ = ("flange", "owner", "part")

    def __init__(self, owner: Composition, part: str, flange: str) -> None:
        self.owner, self.part, self.flange = owner, part, flange

    def __repr__(self) -> str:
        return f"<flange {self.part}.{self.flange}>"


@final
class Handle:
    """A part of one drivetrain: its flanges (for `connect`) and its fields as attributes, and what else the part has.

    part: the block or train itself. A name that the part has not raises an error that is an AttributeError too, so that
    hasattr and getattr(handle, name, default) work.
    """

    def __init__(self, owner: Composition, name: str, part: Block | Composition) -> None:
        self.__dict__.update(_owner=owner, _name=name, _part=part)

    @property
    def part(self) -> Any:
        """The block or train that it is a handle of."""
        return self._part

    @property
    def flanges(self) -> tuple[str, ...]:
        """Names of the flanges."""
        return tuple(self._part._exposed) if not isinstance(self._part, Block) else tuple(type(self._part).flanges)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        if name in self.flanges:
            return FlangeHandle(self._owner, self._name, name)
        if hasattr(self._part, name):
            return getattr(self._part, name)
        fields = tuple(type(self._part).fields) if isinstance(self._part, Block) else ()
        kind = type(self._part).__name__
        way = did_you_mean(name, (*self.flanges, *fields))
        if kind == "Drivetrain" and not way:
            way = "; the flanges of a train are those that it shows: stage.expose('name', part.flange), before it is added"
        raise UnknownAttributeError(
            f"'{self._name}' ({kind}) has no flange '{name}'{' and no such field' if fields else ''}; "
            f"flanges: {', '.join(self.flanges) or 'none'}{'; fields: ' if fields else ''}{', '.join(fields)}{way}"
        )

    def __setattr__(self, name: str, value: object) -> None:
        fields = tuple(type(self._part).fields) if isinstance(self._part, Block) else ()
        kind, shown = type(self._part).__name__, f"{value!r:.80}"
        if fields and name not in fields:
            raise UnknownAttributeError(
                f"'{self._name}' ({kind}) has no field '{name}' that could be set to {shown}; fields: {', '.join(fields)}"
                f"{did_you_mean(name, fields)}"
            )
        way = f"{{'{self._name}.{name}': {shown}}}" if fields else f"{{'{self._name}.PART.FIELD': value}}"
        raise UnknownAttributeError(
            f"'{self._name}' ({kind}) is frozen, {name} = {shown} changes nothing: make a changed train with rig.set({way})"
        )

    def __delattr__(self, name: str) -> None:
        raise UnknownAttributeError(
            f"'{self._name}' ({type(self._part).__name__}) is frozen, {name} stays: make a changed train with rig.set(...)"
        )

    def __dir__(self) -> list[str]:
        """Flanges and fields first of all: what a prompt completes."""
        fields = type(self._part).fields if isinstance(self._part, Block) else ()
        return sorted({"flanges", "part", *self.flanges, *fields})

    def __eq__(self, other: object) -> bool:
        """Whether both stand for equal parts of one name."""
        return isinstance(other, Handle) and (self._name, self._part) == (other._name, other._part)

    def __hash__(self) -> int:
        return hash((self._name, self._part))

    def __repr__(self) -> str:
        part = self._part
        if not isinstance(part, Block):
            return f"<{self._name}: {part!r}>"
        return f"<{self._name}: {type(part).__name__}({', '.join(field_texts(part, slides=False))})>"


def bare(part: Any) -> Any:
    """The block or train that a handle is one of; anything else as it is."""
    return part._part if isinstance(part, Handle) else part


def lost_flanges(part: Handle, links: Iterable[Iterable[tuple[str, str]]]) -> Iterator[str]:
    """Flanges of a part that stand in a link (are connected or exposed), but which it does not have."""
    ends, has = {end for link in links for end in link}, part.flanges
    for flange in sorted(flange for name, flange in ends if name == part._name and flange not in has):
        yield f"the new '{part._name}' has no flange '{flange}', which is connected; it has {', '.join(has) or 'none'}"


def end_of(owner: Any, flange: Any) -> tuple[str, str]:
    """Part and name of a flange of a drivetrain. Raises ModelError for anything else."""
    if isinstance(flange, Handle):
        raise ModelError(f"connect joins flanges: name one of {flange._name}.{{{', '.join(flange.flanges)}}}")
    if not isinstance(flange, FlangeHandle) or flange.owner is not owner:
        way = "use the handle that add returned"
        part, _, end = flange.rpartition(".") if isinstance(flange, str) else ("", "", "")
        if part in owner:
            has = owner[part].flanges
            way = f"write rig['{part}'].{end}" if end in has else f"'{part}' has {', '.join(has)}"
        if isinstance(flange, (list, tuple)):
            way = "give flanges one by one, as connect(one, other), or connect(*flanges)"
        raise ModelError(f"{flange!r:.80} is no flange of '{owner.name}': {way}")
    return (flange.part, flange.flange)


@cache
def _main_flanges(kind: type[Block]) -> tuple[str, ...]:
    return tuple(n for n, f in kind.flanges.items() if not f.ground or f.spare)


def main_ends(owner: Any, part: Any) -> list[tuple[str, str]]:
    """The one or two flanges by which a chain passes through a part of a drivetrain. Raises ModelError."""
    if not isinstance(part, Handle) or part._owner is not owner:
        way = f"write rig['{part}']" if isinstance(part, str) and part in owner else "use the handle that add returned"
        if isinstance(part, (list, tuple)):
            way = "give parts one by one, as chain(one, other), or chain(*parts)"
        elif isinstance(part, FlangeHandle):
            way = f"a chain goes through parts, here {part.part}; flanges are joined by rig.connect"
        raise ModelError(f"{part!r:.80} is no part of '{owner.name}': {way}")
    main = _main_flanges(type(part._part)) if isinstance(part._part, Block) else part.flanges
    if not 1 <= len(main) <= 2:
        raise ModelError(
            f"'{part._name}' has {len(main)} flanges ({', '.join(main)}), so a chain cannot pass through it: use connect"
        )
    return [(part._name, flange) for flange in main]
