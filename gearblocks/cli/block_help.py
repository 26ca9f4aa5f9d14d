"""Reference pages of blocks, effects and other public names, as `gearblocks doc` prints them."""

from __future__ import annotations

import inspect
import textwrap
from typing import Any

import gearblocks as gb
from gearblocks.errors import UnknownNameError, did_you_mean
from gearblocks.language.block import Block, Effect
from gearblocks.language.reference import Verbatim, written_doc

WIDTH = 118


def page(name: str) -> str:
    """The reference of a public name: what help() says in Python."""
    bare = name.removeprefix("gb.").removeprefix("gearblocks.")
    if bare not in gb.__all__:
        raise UnknownNameError(
            f"gearblocks has no block or other public name '{bare}'{did_you_mean(bare, gb.__all__)}; "
            "`gearblocks doc` lists the blocks"
        )
    value = getattr(gb, bare)
    return f"{_call(bare, value)}\n\n{inspect.getdoc(value) or 'There are no words about it.'}"


def _call(name: str, value: Any) -> str:
    """How it is written: with its arguments, one per line where they do not fit into one."""
    if not callable(value):
        return f"gb.{name}"
    try:
        parameters = inspect.signature(value).parameters.values()
    except (TypeError, ValueError):
        return f"gb.{name}(...)"
    given = [str(p.replace(annotation=Verbatim(a)) if isinstance(a := p.annotation, str) else p) for p in parameters]
    line = f"gb.{name}({', '.join(given)})"
    return line if len(line) <= WIDTH else "\n".join([f"gb.{name}(", *(f"    {x}," for x in given), ")"])


def listing() -> str:
    """Every block and effect of the catalogue with the first words about it."""
    kinds = {name: value for name in gb.__all__ if isinstance(value := getattr(gb, name), type)}
    groups = (
        ("Blocks", {n: k for n, k in kinds.items() if issubclass(k, Block) and k is not Block}),
        ("Effects", {n: k for n, k in kinds.items() if issubclass(k, Effect) and k is not Effect}),
    )
    width = max(len(name) for _, group in groups for name in group)
    lines = []
    for title, group in groups:
        lines += [
            title,
            *(f"  {name:<{width}}  {_words(kind, WIDTH - width - 4)}" for name, kind in sorted(group.items())),
            "",
        ]
    return "\n".join(
        [*lines, "gearblocks doc NAME: fields, flanges, outputs and an example of one; in Python help(gb.NAME)"]
    )


def _words(kind: type, width: int) -> str:
    """The first sentence, or as much of it as there is room for."""
    first = " ".join(written_doc(kind).split("\n\n")[0].split())
    end = min((i for i in (first.find(". "), first.find(": "), first.find("; ")) if i > 0), default=len(first))
    return textwrap.shorten(first[:end].rstrip(".:,"), width, placeholder=" ...")
