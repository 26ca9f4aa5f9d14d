"""Counts per family as a table, and the failures, one a line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

KINDS = ("right", "wrong", "ledger", "refused", "stopped", "hang", "crash", "none")
FAILURES = KINDS[1:-1]


def table(verdicts: Sequence[dict[str, Any]]) -> str:
    """Markdown: a row per family and one of all."""
    lines = [
        "| family | trains | " + " | ".join(KINDS[:-1]) + " | no evidence | reference |",
        "|---" * (len(KINDS) + 3) + "|",
    ]
    families = list(dict.fromkeys(v["family"] for v in verdicts))
    for family in [*families, "all"]:
        rows = [v for v in verdicts if family in ("all", v["family"])]
        counts = Counter(v["kind"] for v in rows)
        referred = sum("reference" in v["evidence"] for v in rows)
        numbers = " | ".join(str(counts[k]) for k in KINDS)
        lines.append(f"| {family} | {len(rows)} | {numbers} | {referred} |")
    return "\n".join(lines)


def line(verdict: dict[str, Any], width: int = 240) -> str:
    """One failure."""
    message = " ".join(str(verdict["message"]).split())
    return f"{verdict['family']} {verdict['seed']}: {verdict['kind']} ({verdict['what']}) {message}"[:width]


def failures(verdicts: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Those that are neither right nor without evidence, in order."""
    found = [v for v in verdicts if v["kind"] in FAILURES]
    return sorted(found, key=lambda v: (v["family"], v["seed"]))
