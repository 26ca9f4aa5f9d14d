"""Pages from templates."""

from __future__ import annotations

from typing import Any


def page(template: str, **values: Any) -> str:
    """Text of a template of this folder, filled; plain values are escaped, markupsafe ones are not."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("gearblocks", "report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(template).render(**values)
