"""How many there are of something, in words. Knows nothing of what is counted."""

from __future__ import annotations

import re

_COUNTED = (
    "angles", "bodies", "boxes", "cases", "categories", "components", "coordinates", "crossings", "definitions", "effects",
    "elements", "events", "files", "frequencies", "inputs", "lines", "links", "modes", "nodes", "orbits", "orders",
    "outputs", "parameters", "parts", "periods", "points", "problems", "right-hand sides", "rows", "runs", "samples",
    "segments", "shafts", "speeds", "states", "steps", "switches", "times", "trains", "values", "variables",
)  # fmt: skip
_ONE = re.compile(rf"(?<![\w.,/'\"-])1 ({'|'.join(_COUNTED)})\b")


def singular(text: str) -> str:
    """A text with "1 input" for "1 inputs"."""
    return _ONE.sub(lambda found: f"1 {_one_of(found[1])}", text)


def _one_of(plural: str) -> str:
    for end, one in (("ies", "y"), ("ches", "ch"), ("xes", "x")):
        if plural.endswith(end):
            return plural.removesuffix(end) + one
    return plural.removesuffix("s")


def among(count: int, words: str) -> str:
    """How many of what was counted before are something: "1 of them free rotation", "no free rotation"."""
    return f"{count} of them {words}" if count else f"no {words}"
