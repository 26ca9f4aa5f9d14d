"""The commands that tell what a train has before any run: values, outputs, parameters, inputs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gearblocks.cli.terminal import say
from gearblocks.cli.trains import Change, Train, Without, named

if TYPE_CHECKING:
    from gearblocks.model.listing import Listing

Patterns = Annotated[
    list[str] | None, typer.Argument(metavar="[PATTERN]...", help="Such as 'mesh.*'; without: all of them.")
]


def describe(train: Train, change: Change = None, without: Without = None) -> None:
    """Blocks of a train with their values, and what among them is hardly meant."""
    say(named(train, change, without).describe())


def outputs(train: Train, patterns: Patterns = None, change: Change = None, without: Without = None) -> None:
    """Names, units and words of what a run of a train records."""
    _all(named(train, change, without).outputs(*(patterns or ())))


def parameters(train: Train, patterns: Patterns = None, change: Change = None, without: Without = None) -> None:
    """Names, values, units and words of what --set and --over change."""
    _all(named(train, change, without).parameters(*(patterns or ())))


def inputs(train: Train, patterns: Patterns = None, change: Change = None, without: Without = None) -> None:
    """Names, units and values of the inputs of a train."""
    _all(named(train, change, without).inputs(*(patterns or ())))


def _all(listing: Listing) -> None:
    say(listing.table(len(listing)))
