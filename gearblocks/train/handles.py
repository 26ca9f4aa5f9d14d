"""Handles of parts and flanges, as `Drivetrain.add` returns them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from gearblocks.errors import ModelError, did_you_mean
from gearblocks.language.block import Block


class Composition(Protocol):
    """What has parts: the drivetrain whose part a handle is, and a part that is a drivetrain itself."""

    @property
    def _exposed(self) -> Mapping[str, tuple[str, str]]: ...


class FlangeHandle:
    """A flange of a part of one drivetrain, for `connect`."""

    __slots__ = ("flange", "owner", "part")

    def __init__(self, owner: Composition, part: str, flange: str) -> None:
        self.owner, self.part, self.flange = owner, part, flange

    def __repr__(self) -> str:
        return f"<flange {self.part}.{self.flange}>"


class Handle:
    """A part of one drivetrain: its flanges as attributes."""

    def __init__(self, owner: Composition, name: str, part: Block | Composition) -> None:
        self._owner, self._name, self._part = owner, name, part

    @property
    def flanges(self) -> tuple[str, ...]:
        """Names of the flanges."""
        return tuple(self._part._exposed) if not isinstance(self._part, Block) else tuple(type(self._part).flanges)

    def __getattr__(self, name: str) -> FlangeHandle:
        if name.startswith("__"):
            raise AttributeError(name)
        if name in self.flanges:
            return FlangeHandle(self._owner, self._name, name)
        kind = type(self._part).__name__
        raise ModelError(
            f"block '{self._name}' ({kind}) has no flange '{name}'; it has {', '.join(self.flanges) or 'none'}"
            f"{did_you_mean(name, self.flanges)}"
        )

    def __repr__(self) -> str:
        return f"<{self._name}: {self._part!r}>"
