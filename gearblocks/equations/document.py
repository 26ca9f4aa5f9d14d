"""Printed equations: sections of lines in notation, shown as text, LaTeX and a page of MathML.

Knows nothing of trains: what the lines say is decided in `sections.py`.
"""

from __future__ import annotations

import itertools
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, final

from gearblocks.equations import latex as tex
from gearblocks.equations import mathml as web
from gearblocks.equations import text as plain
from gearblocks.equations.names import Name
from gearblocks.equations.nodes import Node
from gearblocks.equations.nomenclature import Entry
from gearblocks.errors import ParameterError, arguments_told
from gearblocks.language.signals import Table
from gearblocks.pages import FRAGMENT, legible_width, page

WIDTH = 100
"""Characters in a line of text."""
PAGE = 20
"""Lines of LaTeX that a page keeps together."""


def _at_dots(path: str, room: int) -> list[str]:
    """A path in lines of at most so many characters, broken behind dots where it can be."""
    found = [""]
    for piece in re.findall(r"[^.]*\.?", path):
        if found[-1] and len(found[-1]) + len(piece) > room:
            found.append("")
        found[-1] += piece
    return found


@final
@dataclass(frozen=True, slots=True)
class Line:
    """left = right, or where left is None what is said in words and symbols; equations are numbered."""

    left: Node | None
    right: Node


@final
@dataclass(frozen=True, slots=True)
class Section:
    """Lines under a heading."""

    heading: str
    lines: tuple[Line, ...]


@final
@arguments_told
@dataclass(frozen=True, slots=True)
class Nomenclature:
    """Symbols with their meaning. Shown by str(), latex() and html()."""

    entries: tuple[tuple[Name, Entry], ...]

    def __len__(self) -> int:
        return len(self.entries)

    def __iter__(self) -> Iterator[tuple[str, str, str, str, str]]:
        """(symbol, words, value, unit, path) of each, as text."""
        for name, entry in self.entries:
            yield plain.name_text(name), entry.words, entry.value, "" if entry.unit == "1" else entry.unit, entry.path

    def __str__(self) -> str:
        rows = [(symbol, words, f"{value} {unit}".strip(), path) for symbol, words, value, unit, path in self]
        wide = [min(max((len(row[i]) for row in rows), default=0), most) for i, most in ((0, 28), (1, 40), (2, 20))]
        found = ["Nomenclature"]
        room = max(WIDTH + 10 - sum(wide), 20)
        for symbol, *texts, path in rows:
            cells = [textwrap.wrap(text, width) for text, width in zip(texts, wide[1:], strict=True)]
            lines = itertools.zip_longest(*cells, _at_dots(path, room), fillvalue="")
            wider = len(symbol) > wide[0]  # a line of its own: the columns stay
            found += [f"    {symbol}"] * wider
            for i, (words, value, ends) in enumerate(lines):
                begins = "" if i or wider else symbol
                found.append(f"    {begins:<{wide[0]}}  {words:<{wide[1]}}  {value:<{wide[2]}}  {ends}".rstrip())
        return "\n".join(found)

    def __repr__(self) -> str:
        return str(self)

    def latex(self) -> str:
        """A description list."""
        rows = []
        for name, entry in self.entries:
            value = (
                f", {tex.value(entry.value)}~{tex.unit(entry.unit)}".rstrip("~") if entry.value else _in_brackets(entry)
            )
            rows.append(rf"\item[${tex.name_latex(name)}$] {tex.prose(entry.words)}{value}")
        return "\n".join([r"\begin{description}\itemsep0pt\parskip0pt", *rows, r"\end{description}"])

    def html(self) -> str:
        """A table."""
        return page("gearblocks.equations", "nomenclature.html.jinja", rows=self.rows())

    def rows(self) -> list[dict[str, Any]]:
        """What the table shows."""
        return [
            {
                "symbol": web.math(web.name_mathml(name)),
                "entry": entry,
                "unit": web.unit(entry.unit),
                "points": _picture(entry.table),
            }
            for name, entry in self.entries
        ]

    def _repr_html_(self) -> str:
        return self.html()


@final
@arguments_told
@dataclass(frozen=True, slots=True)
class Document:
    """Sections and the symbols in them. Shown by str(), latex(), html() and mathml()."""

    title: str
    sections: tuple[Section, ...]
    nomenclature: Nomenclature

    def __repr__(self) -> str:
        return str(self)

    def __str__(self) -> str:
        number, blocks = 0, [self.title]
        for section in self.sections:
            shown = [section.heading]
            for line in section.lines:
                broken = plain.equation_lines(line.left, line.right, WIDTH - 10)
                if line.left is not None:
                    number += 1
                    middle = (len(broken) - 1) // 2 if _is_block(broken) else len(broken) - 1
                    broken[middle] = f"{broken[middle]:<{WIDTH - 10}}  ({number})"
                shown += ["    " + part for part in broken]
            blocks.append("\n".join(part.rstrip() for part in shown))
        return "\n\n".join([*blocks, str(self.nomenclature)] if len(self.nomenclature) else blocks)

    def latex(self) -> str:
        """Equations for a document with amsmath, as wide as a column of a two-column article; pages end between them."""
        blocks = ["% needs amsmath\n\\begingroup\\allowdisplaybreaks\\raggedright"]
        for section in self.sections:
            shown = [rf"\paragraph{{{tex.prose(section.heading)}}}"]
            for group in _grouped(section.lines):
                if group[0].left is not None:
                    rows = tex.align([(line.left, line.right) for line in group if line.left is not None])
                    shown.append(f"\\begin{{align}}\n{rows}\n\\end{{align}}")
                else:
                    shown += [rf"\noindent {tex.sentence(line.right)}\par" for line in group]
            blocks.append("\n".join(shown))
        if len(self.nomenclature):
            blocks.append("\\paragraph{Nomenclature}\n" + self.nomenclature.latex())
        return "\n\n".join([*blocks, r"\endgroup"])

    def _repr_latex_(self) -> str:
        """The equations as displays that fit pages, for what shows no page of MathML; MathJax reads them too."""
        found: list[list[str]] = []
        for section in self.sections:
            rows = [tex.aligned(line.left, line.right) for line in section.lines if line.left is not None]
            titled = ["&" + tex.word(section.heading).replace("mathrm", "mathbf"), *rows] if rows else []
            for number, row in enumerate(titled):
                if number == 0 or sum(map(_height, found[-1])) + _height(row) > PAGE:
                    found.append([])
                found[-1].append(row)
        displays = (" \\\\\n".join(rows).replace(" \\notag \\\\*", r" \\") for rows in found)
        return "\n".join(f"\\begin{{align*}}\n{rows}\n\\end{{align*}}" for rows in displays)

    def mathml(self) -> str:
        """<math> elements, one in a line."""
        return "\n".join(
            x for s in self.sections for line in s.lines for x in web.equation_mathml(line.left, line.right)
        )

    def html(self, drawing: str = "") -> str:
        """A page that a browser shows without a network; drawing: SVG that stands above the equations."""
        if drawing and "<svg" not in str(drawing):
            raise ParameterError(
                f"drawing = {str(drawing)!r:.80} must be the SVG of the train, str(rig.draw()); the page is text, written to a "
                "file by pathlib.Path('page.html').write_text"
            )
        return self._page(drawing=str(drawing))

    def _page(self, drawing: str = "", **frame: str) -> str:
        number, sections = 0, []
        for section in self.sections:
            rows = []
            for line in section.lines:
                number += line.left is not None
                shown = web.flowing_mathml(line.left, line.right)
                rows.append({"pieces": shown, "number": number if line.left is not None else None})
            sections.append({"heading": section.heading.replace(" = ", "\xa0=\xa0"), "rows": rows})
        rows = self.nomenclature.rows()
        values = {
            "title": self.title,
            "sections": sections,
            "rows": rows,
            "drawing": drawing,
            "least": legible_width(drawing),
        }
        return page("gearblocks.equations", "equations.html.jinja", **values, **frame)

    def _repr_html_(self) -> str:
        return self._page(frame=FRAGMENT)


def _height(row: str) -> int:
    """Lines of an equation in LaTeX."""
    return 1 + row.count(r"\\")


def _in_brackets(entry: Entry) -> str:
    return f" [{tex.unit(entry.unit)}]" if entry.unit not in ("", "1") else ""


def _is_block(broken: list[str]) -> bool:
    return any(brace in broken[0] for brace in "⎧⎡")


def _grouped(all_lines: tuple[Line, ...]) -> Iterator[list[Line]]:
    """Equations that are aligned with each other, and sentences; one that is wide stands alone."""
    group: list[Line] = []
    for line in all_lines:
        if group and not _stand_together(group, line):
            yield group
            group = []
        group.append(line)
    if group:
        yield group


def _stand_together(group: list[Line], line: Line) -> bool:
    """Whether a line goes on with a group."""
    if line.left is None or group[0].left is None:
        return line.left is group[0].left
    sides = [(x.left, x.right) for x in (*group, line) if x.left is not None]
    return not any(tex.is_wide(*x) for x in (sides[0], sides[-1])) and tex.fit_together(sides)


def _picture(table: Any) -> str:
    """Points of a table over one quantity as those of a polyline in a box of 120 by 40."""
    if not isinstance(table, Table):
        return ""
    x, y = [float(v) for v in table.x], [float(v) for v in table.y]
    wide, high = x[-1] - x[0], (max(y) - min(y)) or 1.0
    pairs = [(120 * (a - x[0]) / wide, 38 - 36 * (b - min(y)) / high) for a, b in zip(x, y, strict=True)]
    if table.kind == "step":
        pairs = [p for (a, b), (c, _) in zip(pairs, [*pairs[1:], pairs[-1]], strict=True) for p in ((a, b), (c, b))]
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in pairs)
