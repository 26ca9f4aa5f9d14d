"""Reference pages of blocks, effects and other public names, as `gearblocks doc` prints them."""

from __future__ import annotations

import inspect
import textwrap
from typing import Any

import gearblocks as gb
from gearblocks.analysis.quantity import Quantity
from gearblocks.errors import UnknownNameError, did_you_mean
from gearblocks.language.block import Block, Effect
from gearblocks.language.expression import Expr
from gearblocks.language.reference import Documented, Verbatim, written_doc

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
    return "\n".join([
        _call(f"gb.{bare}", value), "", inspect.getdoc(value) or "There are no words about it.", *_methods(value),
        *_answer(value),
    ])  # fmt: skip


def _call(name: str, value: Any) -> str:
    """How it is written: with its arguments, one per line where they do not fit into one."""
    if not callable(value):
        return name
    try:
        given = _arguments(value)
    except (TypeError, ValueError):
        return f"{name}(...)"
    line = f"{name}({', '.join(given)})"
    return line if len(line) <= WIDTH else "\n".join([f"{name}(", *(f"    {x}," for x in given), ")"])


def _arguments(value: Any) -> list[str]:
    """The arguments as they are declared; "*" where those begin that are given by name, which blocks take alone."""
    shown: list[str] = []
    for p in inspect.signature(value).parameters.values():
        if p.kind is p.KEYWORD_ONLY and "*" not in shown and not isinstance(value, Documented):
            shown.append("*")
        annotation = Verbatim(p.annotation) if isinstance(p.annotation, str) else p.annotation
        shown.append(str(p.replace(annotation=annotation)))
    return shown


def _answer(value: Any) -> list[str]:
    """What a function answers, where that is an object of ours without a public name of its own."""
    if isinstance(value, type) or not callable(value):
        return []
    function = inspect.unwrap(value)
    kind = getattr(function, "__globals__", {}).get(inspect.signature(function).return_annotation)
    if not isinstance(kind, type) or not kind.__module__.startswith("gearblocks.") or kind.__name__ in gb.__all__:
        return []
    if issubclass(kind, Quantity | Expr):
        return []
    return [
        "",
        f"Answers {kind.__name__}",
        *textwrap.indent(inspect.getdoc(kind) or "", "  ").split("\n"),
        *_methods(kind),
    ]


def _methods(value: Any) -> list[str]:
    """What objects of a class can do and what they have, a line each; blocks and effects have tables in place of that."""
    if not isinstance(value, type) or issubclass(value, Block | Effect | BaseException):
        return []
    members = {
        n: x for n, x in vars(value).items() if not n.startswith("_") and (callable(x) or isinstance(x, property))
    }
    found = []
    for name, member in sorted(members.items()):
        words = " ".join((inspect.getdoc(member) or "").split("\n\n")[0].split())
        head = f"  .{name}" if isinstance(member, property) else f"  .{name}({', '.join(_names(member))})"
        found += [head, *textwrap.wrap(words, WIDTH, initial_indent="      ", subsequent_indent="      ")]
    return ["", "Has", *found] if found else []


def _names(method: Any) -> list[str]:
    """The arguments of a method by name."""
    given = inspect.signature(method).parameters.values()
    stars = {"VAR_POSITIONAL": "*", "VAR_KEYWORD": "**"}
    return [f"{stars.get(p.kind.name, '')}{p.name}" for p in given if p.name != "self"]


def listing() -> str:
    """Every block, effect and function of the catalogue with the first words about it."""
    values = {name: getattr(gb, name) for name in gb.__all__ if not name.startswith("_")}
    kinds = {name: value for name, value in values.items() if isinstance(value, type)}
    groups = (
        ("Blocks", {n: k for n, k in kinds.items() if issubclass(k, Block) and k is not Block}),
        ("Effects", {n: k for n, k in kinds.items() if issubclass(k, Effect) and k is not Effect}),
        ("Functions", {n: x for n, x in values.items() if inspect.isfunction(x)}),
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
        [
            *lines,
            "gearblocks doc NAME: fields, flanges, outputs and an example of a block, arguments and answer of a function;",
            "in Python help(gb.NAME)",
        ]
    )


def _words(kind: Any, width: int) -> str:
    """The first sentence, or as much of it as there is room for."""
    words = written_doc(kind) if isinstance(kind, type) else inspect.getdoc(kind) or ""
    first = " ".join(words.split("\n\n")[0].split())
    end = min((i for i in (first.find(". "), first.find(": "), first.find("; ")) if i > 0), default=len(first))
    return textwrap.shorten(first[:end].rstrip(".:,"), width, placeholder=" ...")
