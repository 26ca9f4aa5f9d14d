"""HTML from templates: pages in one frame, small tables for notebooks, text as its lines; nothing is fetched from elsewhere."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any, final

MOST_ROWS = 40
FRAGMENT = "fragment.html.jinja"


def page(package: str, template: str, **values: Any) -> str:
    """Text of a template in a package's folder, filled; plain values are escaped, markupsafe ones are not. frame: what it
    extends, a whole page by default, or what stands in a notebook (FRAGMENT)."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(package, ""), jinja2.PackageLoader("gearblocks", "")]),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(template).render(**{"frame": "page.html.jinja", **values})


def small_table(
    title: str, rows: Sequence[Sequence[object]], *, head: Sequence[str] = (), numbers: Collection[int] = (),
    notes: Sequence[str] = (),
) -> str:  # fmt: skip
    """A table for a notebook (`_repr_html_`), text escaped; numbers: columns that are aligned to the right. Of a long one the
    first MOST_ROWS rows."""
    more = len(rows) - MOST_ROWS
    said = [*notes, f"and {more} more rows"] if more > 0 else [*notes]
    return page(
        "gearblocks", "table.html.jinja", title=title, rows=rows[:MOST_ROWS], head=head, numbers=numbers, notes=said
    )


@final
class Lines(str):
    """A text that a notebook and IPython show as its lines, not in quotes with \\n between them."""

    __slots__ = ()

    def _repr_pretty_(self, printer: Any, cycle: bool) -> None:
        printer.text("..." if cycle else str(self))


_LEGIBLE = 0.75
"""Of its width, that a drawing keeps on a telephone: it is moved aside there."""


def legible_width(drawing: str) -> int:
    """The least width [px] at which the drawing in an SVG text is shown; 0 where there is none."""
    width = re.search(r'<svg [^>]*?width="([\d.]+)"', drawing)
    return round(_LEGIBLE * float(width[1])) if width else 0
