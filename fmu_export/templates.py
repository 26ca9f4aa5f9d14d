"""Text from the .jinja files of this package."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import jinja2

C_FOLDER = Path(__file__).with_name("c")
"""The C that all versions of FMI share."""
VERSION_FOLDERS = {"2.0": Path(__file__).with_name("fmi2")}
"""The C of one version."""


def render(name: str, /, **values: Any) -> str:
    """The template `name` with its values filled in; text in HTML templates is escaped."""
    return _environment().get_template(name).render(**values)


@functools.cache
def _environment() -> jinja2.Environment:
    import jinja2

    return jinja2.Environment(
        loader=jinja2.FileSystemLoader([C_FOLDER, C_FOLDER.parent]),
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        undefined=jinja2.StrictUndefined,
        autoescape=lambda name: name is not None and name.endswith(".html.jinja"),
    )
