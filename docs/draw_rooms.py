"""Draws docs/pictures/rooms.svg: the rooms of the table in architecture.md and the imports between them, from the code.

    python docs/draw_rooms.py

A room is a row, the ground at the bottom. Its line to the right has a dot on the lane of every room that it imports; the
lane leads down into that room. Imports inside functions and for types count.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import NamedTuple

DOCS = Path(__file__).parent
ROOT = DOCS.parent
PICTURE = DOCS / "pictures" / "rooms.svg"

WIDTH, ROW, GAP, LANE, MARGIN = 590, 46, 16, 26, 24
LONGEST = 98  # letters in a box
COLOURS = ("#1f77b4", "#c44e52", "#2e8b57", "#8064a2", "#b8860b", "#3a8f9e", "#d2691e", "#5b6f8f")


class Room(NamedTuple):
    """One row of the table: the paths that it consists of, and what it is."""

    paths: tuple[str, ...]
    words: str

    @property
    def title(self) -> str:
        """The paths, as the table writes them."""
        return ", ".join(self.paths)

    @property
    def modules(self) -> tuple[str, ...]:
        """The modules or packages that the paths are."""
        return tuple(map(_module_named, self.paths))


def rooms() -> list[Room]:
    """The rooms of the first table of architecture.md, from the ground up."""
    text = (DOCS / "architecture.md").read_text(encoding="utf-8")
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| `")]
    return [Room(tuple(re.findall(r"`([^`]+)`", row[0])), row[1].strip()) for row in rows if len(row) == 3]


def _module_named(path: str) -> str:
    inner = path.removesuffix(".py").rstrip("/").replace("/", ".")
    if inner == "__init__":
        return "gearblocks"
    return inner if inner == "fmu_export" else f"gearblocks.{inner}"


def _files() -> dict[str, Path]:
    """Every module of the two packages and its file."""
    found = {}
    for package in ("gearblocks", "fmu_export"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """What lies below a node; into expressions, which import nothing, it does not look."""
    for name in ("body", "handlers", "orelse", "finalbody", "cases"):
        for below in getattr(tree, name, ()):
            yield below
            yield from _statements(below)


def _imports(path: Path, modules: dict[str, Path]) -> Iterator[str]:
    for node in _statements(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            inner = [f"{base}.{alias.name}" for alias in node.names]
            yield from (name if name in modules else base for name in inner if name in modules or base in modules)


def _room_of(module: str, table: list[Room]) -> int:
    for number, room in enumerate(table):
        for name in room.modules:
            if module == name or (name != "gearblocks" and module.startswith(f"{name}.")):
                return number
    raise LookupError(f"'{module}' lies in no room of docs/architecture.md")


def imports_between(table: list[Room]) -> set[tuple[int, int]]:
    """(importing, imported) numbers of rooms."""
    modules = _files()
    found = {(_room_of(m, table), _room_of(x, table)) for m, path in modules.items() for x in _imports(path, modules)}
    return {(a, b) for a, b in found if a != b}


def _counts(room: Room) -> str:
    """How many files a room has, by language."""
    paths: list[Path] = []
    for path in room.paths:
        at = ROOT / path if path.startswith("fmu_export") else ROOT / "gearblocks" / path
        paths += [x for x in at.rglob("*") if "__pycache__" not in x.parts] if at.is_dir() else [at]
    sorts = {".py": "py", ".c": "C", ".h": "C", ".jinja": "jinja"}
    found = Counter(sorts[x.suffix] for x in paths if x.suffix in sorts)
    return " · ".join(f"{found[sort]} {sort}" for sort in ("py", "C", "jinja") if found[sort])


def _fitting(words: str) -> str:
    """As much of the words as a box is wide."""
    for mark in ("; ", ", "):
        while len(words) > LONGEST and mark in words:
            words = words.rpartition(mark)[0]
    return words


def _text(x: float, y: float, words: str, style: str) -> str:
    return f'<text x="{x:g}" y="{y:g}" class="{style}">{escape(words)}</text>'


def picture() -> str:
    """The drawing as SVG text; the same for the same sources."""
    table = rooms()
    edges = imports_between(table)
    targets = sorted(
        {b for _, b in edges}, reverse=True
    )  # lanes of the uppermost rooms lie nearest: none crosses a return
    lane = {b: MARGIN + WIDTH + 40 + i * LANE for i, b in enumerate(targets)}
    top = {n: MARGIN + (len(table) - 1 - n) * (ROW + GAP) for n in range(len(table))}
    width = max(lane.values()) + MARGIN + 10
    height = len(table) * (ROW + GAP) - GAP + 2 * MARGIN
    right, parts = MARGIN + WIDTH, []
    for n in range(len(table)):  # lines to the right, below the lanes
        mine = [lane[b] for a, b in edges if a == n]
        if mine:
            parts.append(f'<path class="out" d="M{right} {top[n] + 15} H{max(mine)}"/>')
    for b in targets:
        colour, x = COLOURS[b % len(COLOURS)], lane[b]
        importers = [a for a, other in edges if other == b]
        y = top[b] + ROW - 13
        parts.append(
            f'<path class="lane" stroke="{colour}" d="M{x} {top[max(importers)] + 15} V{y} H{right + 8}"/>'
            f'<path fill="{colour}" d="M{right + 1} {y} l9 -4.5 v9 z"/>'
        )
        parts += [f'<circle cx="{x}" cy="{top[a] + 15}" r="4.5" fill="{colour}"/>' for a in sorted(importers)]
    for n, room in enumerate(table):
        colour = COLOURS[n % len(COLOURS)]
        parts.append(f'<rect x="{MARGIN}" y="{top[n]}" width="{WIDTH}" height="{ROW}" rx="5" stroke="{colour}"/>')
        parts.append(_text(MARGIN + 12, top[n] + 19, room.title, "name"))
        parts.append(_text(right - 12, top[n] + 19, _counts(room), "count"))
        parts.append(_text(MARGIN + 12, top[n] + 37, _fitting(room.words.replace("`", "")), "words"))
    style = (
        "text{font-family:Helvetica,Arial,sans-serif;fill:#222}.name{font-size:15px;font-weight:bold}"
        ".words{font-size:12px;fill:#555}.count{font-size:12px;text-anchor:end;fill:#555}"
        "rect{fill:#fbfbf9;stroke-width:1.6}.out{fill:none;stroke:#bbb;stroke-width:1.2}.lane{fill:none;stroke-width:1.8}"
    )
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}">'
    body = "\n".join(parts)
    return f'{head}\n<style>{style}</style>\n<rect width="100%" height="100%" style="fill:#fff"/>\n{body}\n</svg>\n'


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8", newline="\n")
