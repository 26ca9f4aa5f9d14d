"""Values of a block as people read them: what is given, with its unit. Knows nothing of laws."""

from __future__ import annotations

from gearblocks.language.block import Block, Declared
from gearblocks.language.signals import Input, Parameter
from gearblocks.language.units import unit_along


def field_texts(block: Block, slides: bool) -> list[str]:
    """ "k = 20000.0 N m/rad" and the like for each field that is not as by default; slides: units are those of sliders."""
    parts = []
    for name, field in type(block).fields.items():
        value = block.__dict__[name]
        if value is not None and value != field.default:
            bare = field.unit == "1" or isinstance(value, (Parameter, Input))  # these say theirs
            unit = "" if bare else f" {unit_along(field.unit, slides)}"
            parts.append(f"{name} = {value!r}{unit}" if not isinstance(value, Declared) else f"{name}: {value!r}")
    return parts
