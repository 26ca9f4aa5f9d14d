"""Reference pages of blocks, effects and other public names, as `gearblocks doc` prints them."""

from __future__ import annotations

import inspect
import textwrap
from typing import Any

import fmu_export
import gearblocks as gb
from gearblocks.analysis.quantity import Quantity
from gearblocks.errors import UnknownNameError, did_you_mean
from gearblocks.language.block import Block, Effect
from gearblocks.language.expression import Expr
from gearblocks.language.reference import Documented, Verbatim, written_doc

WIDTH = 118

_QUANTITIES = {
    "distance": "The way of a Vehicle or Chassis [m], for its slope, wind and rolling resistance",
    "driver_angle": "The angle of gear 1 [rad], for a RatioLaw and the k of a NonCircularGear",
    "pi": "The number 3.14159...",
    "slip": "The size of the slip [rad/s], for laws of friction over it",
    "temperature": "The temperature of the block's heat port [K]",
    "time": "The time of the run [s]",
    "twist": "The twist phi_b - phi_a [rad], for the torque of a Shaft",
}
"""What public names mean that are no classes and no functions."""
_OF_BLOCKS = (
    "gearblocks.language.contributions",
    "gearblocks.language.fields",
    "gearblocks.language.block",
    "gearblocks.language.watches",
)
"""Modules of what blocks of one's own are made of."""


def page(name: str) -> str:
    """The reference of a public name: what help() says in Python."""
    bare = name.removeprefix("gb.").removeprefix("gearblocks.").removeprefix("fmu_export.")
    if bare not in (*gb.__all__, *fmu_export.__all__):
        raise UnknownNameError(
            f"gearblocks has no block or other public name '{bare}'"
            f"{did_you_mean(bare, (*gb.__all__, *fmu_export.__all__))}; `gearblocks doc` lists all names"
        )
    if bare in _QUANTITIES:
        return f"gb.{bare}\n\n{_QUANTITIES[bare]}. Stands in expressions, such as 3 + 2*gb.sin(5*gb.time)."
    module, prefix = (gb, "gb") if bare in gb.__all__ else (fmu_export, "fmu_export")
    value = getattr(module, bare)
    return "\n".join([
        _call(f"{prefix}.{bare}", value), "", inspect.getdoc(value) or "There are no words about it.", *_methods(value),
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
    end = f"){_returned(value)}"
    line = f"{name}({', '.join(given)}{end}"
    return line if len(line) <= WIDTH else "\n".join([f"{name}(", *(f"    {x}," for x in given), end])


def _returned(value: Any) -> str:
    """What a function answers, as it is declared."""
    answer = "" if isinstance(value, type) else inspect.signature(value).return_annotation
    return f" -> {answer}" if isinstance(answer, str) and answer not in ("", "None", "Any") else ""


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
    """Every public name but errors, with the first words about it."""
    values = {name: getattr(gb, name) for name in gb.__all__ if not name.startswith("_")}
    own = {n: x for n, x in values.items() if getattr(x, "__module__", "") in _OF_BLOCKS}
    kinds = {
        n: x for n, x in values.items() if isinstance(x, type) and n not in own and not issubclass(x, BaseException)
    }
    groups: tuple[tuple[str, dict[str, Any]], ...] = (
        ("Blocks", {n: k for n, k in kinds.items() if issubclass(k, Block)}),
        ("Effects", {n: k for n, k in kinds.items() if issubclass(k, Effect)}),
        ("Trains, values and results", {n: k for n, k in kinds.items() if not issubclass(k, Block | Effect)}),
        ("Functions", {n: x for n, x in values.items() if inspect.isfunction(x) and n not in own}),
        ("In expressions, beside the functions of mathematics", dict(_QUANTITIES)),
        ("FMUs: import fmu_export", {n: getattr(fmu_export, n) for n in fmu_export.__all__}),
        ("For blocks of your own: see Block", own),
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
    words = (
        kind if isinstance(kind, str) else written_doc(kind) if isinstance(kind, type) else inspect.getdoc(kind) or ""
    )
    first = " ".join(words.split("\n\n")[0].split())
    end = min((i for i in (first.find(". "), first.find(": "), first.find("; ")) if i > 0), default=len(first))
    words = first[:end].rstrip(".:,")
    if words.count("(") > words.count(")"):
        words = words[: words.rindex("(")].rstrip()
    return textwrap.shorten(words, width, placeholder=" ...")
