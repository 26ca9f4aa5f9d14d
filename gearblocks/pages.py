"""Pages from templates: one frame for all, nothing fetched from elsewhere."""

from __future__ import annotations

from typing import Any


def page(package: str, template: str, **values: Any) -> str:
    """Text of a template in a package's folder, filled; plain values are escaped, markupsafe ones are not."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(package, ""), jinja2.PackageLoader("gearblocks", "")]),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template(template).render(**values)
